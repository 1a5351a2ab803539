"""Lambert's problem: random Kepler problems with 0 to 5 turns, both ways round, against 40 digits and against peers.

    python -m benchmarks.lambert                      1 000 problems
    python -m benchmarks.lambert --rivals FOLDER      where lamberthub and pykep are installed, if not with hjsolve

Conics are made first (eccentricities to 0.99, and hyperbolas), so that one answer is known. The number of answers is
that of the roots of Lagrange's equation; each end point is recomputed with Kepler's equation to 40 digits from momenta
that ``motion`` starts with, and from the momenta in doubles.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import numpy as np

import hjsolve


def made(count: int, seed: int) -> dict[str, np.ndarray]:
    """Places and times of random conics: a third hyperbolic, eccentricities of ellipses to 0.99."""
    rng = np.random.default_rng(seed)
    e = np.where(rng.random(count) < 1 / 3, rng.uniform(1.01, 3, count), rng.uniform(0, 0.99, count))
    p = 10 ** rng.uniform(-0.3, 0.3, count) * (1 + e)
    turns = np.where(e < 1, rng.integers(0, 6, count), 0)
    far = np.where(e < 1, np.pi, np.arccos(-1 / np.maximum(e, 1.0001)) * 0.9)
    ν0 = rng.uniform(-1, 1, count) * far
    ν1 = np.where(e < 1, ν0 + rng.uniform(0, 2 * np.pi, count) + 2 * np.pi * turns, ν0 + (far - ν0) * rng.random(count))
    way = rng.choice([-1, 1], count)
    a = p / (1 - e**2)

    def mean(ν):
        root = np.sqrt(np.abs((1 - e) / (1 + e)))
        with np.errstate(all="ignore"):
            whole = np.floor((ν + np.pi) / (2 * np.pi))
            E = 2 * np.arctan(root * np.tan((ν - 2 * np.pi * whole) / 2)) + 2 * np.pi * whole
            F = 2 * np.arctanh(root * np.tan(ν / 2))
        return np.where(e < 1, E - e * np.sin(E), e * np.sinh(F) - F)

    T = np.abs(a) ** 1.5 * (mean(ν1) - mean(ν0))
    r = [p / (1 + e * np.cos(ν)) for ν in (ν0, ν1)]
    start = rng.uniform(-np.pi, np.pi, count)
    return {
        "r0": r[0], "r1": r[1], "θ0": start, "θ1": start + way * (ν1 - ν0), "T": T, "h": way * np.sqrt(p), "e": e,
        "turns": turns, "way": way,
    }  # fmt: skip


def roots(q, j, N, way) -> int:
    """How many ellipses with N turns Lagrange's equation has, by sign changes over a fine grid of α."""
    θ = (way * (q["θ1"][j] - q["θ0"][j])) % (2 * np.pi)
    r0, r1 = q["r0"][j], q["r1"][j]
    c = np.sqrt((r0 - r1) ** 2 + 4 * r0 * r1 * np.sin(θ / 2) ** 2)
    s = (r0 + r1 + c) / 2
    α = 2 * np.pi * np.linspace(0, 1, 200_001)[1:-1]
    a = s / (2 * np.sin(α / 2) ** 2)
    β = 2 * np.arcsin(np.sqrt((s - c) / (2 * a))) * (1 if θ < np.pi else -1)
    t = a**1.5 * (2 * np.pi * N + α - β - np.sin(α) + np.sin(β))
    return int(np.sum(np.diff(np.sign(t - q["T"][j])) != 0))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--problems", type=int, default=1000)
    options.add_argument("--checked", type=int, default=1000, help="problems whose numbers of answers are recounted")
    options.add_argument("--rivals", default="")
    chosen = options.parse_args()
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    q = made(chosen.problems, 1)
    ask = {"q0": {"r": q["r0"], "theta": q["θ0"]}, "q1": {"r": q["r1"], "theta": q["θ1"]}, "time": q["T"]}
    solution.two_point(**ask, turns=range(6))
    begin = time.process_time()
    table = solution.two_point(**ask, turns=range(6))
    together = time.process_time() - begin
    row = {"problems": chosen.problems, "motions": len(table), "batch, µs a problem": 1e6 * together / chosen.problems}
    row |= _singly(solution, q, min(200, chosen.problems))
    row |= _known(q, table)
    row |= _counted(q, table, chosen.checked)
    row |= _ends(solution, q)
    if chosen.rivals:
        sys.path.append(chosen.rivals)
    row |= _rivals(q, row)
    print(json.dumps(row, ensure_ascii=False, indent=1))


def _singly(solution, q, count) -> dict[str, float]:
    """Milliseconds of the public call for one problem with 0 to 5 turns."""
    spent = []
    for j in range(count):
        begin = time.process_time()
        solution.two_point(
            q0={"r": q["r0"][j], "theta": q["θ0"][j]}, q1={"r": q["r1"][j], "theta": q["θ1"][j]}, time=q["T"][j],
            turns=range(6),
        )  # fmt: skip
        spent.append(1e3 * (time.process_time() - begin))
    return {"single call, ms (median)": float(np.median(spent)), "single call, ms (worst)": float(np.max(spent))}


def _known(q, table) -> dict[str, int]:
    """Whether the conic that a problem was made from is among the answers."""
    missed = 0
    for j in range(len(q["T"])):
        rows = (table.problem == j) & (table.turns == q["turns"][j]) & (table.way == q["way"][j])
        h = table.p0["theta"].value[rows]
        missed += not np.any(np.abs(h - q["h"][j]) <= 1e-6 * np.abs(q["h"][j]))
    return {"known conics missed": missed}


def _counted(q, table, count) -> dict[str, int]:
    wrong = 0
    for j in range(min(count, len(q["T"]))):
        for way in (1, -1):
            for N in range(1, 6):
                rows = (table.problem == j) & (table.way == way) & (table.turns == N)
                wrong += int(rows.sum()) != roots(q, j, N, way)
            wrong += int(np.sum((table.problem == j) & (table.way == way) & (table.turns == 0))) != 1
    return {"wrong numbers of answers": wrong}


def _ends(solution, q) -> dict[str, float]:
    """End points by hjsolve's own motions of a sample, which start from momenta to more digits than doubles have."""
    rng = np.random.default_rng(2)
    worst = 0.0
    for j in rng.choice(len(q["T"]), min(20, len(q["T"])), replace=False):
        found = solution.two_point(
            q0={"r": q["r0"][j], "theta": q["θ0"][j]}, q1={"r": q["r1"][j], "theta": q["θ1"][j]}, time=q["T"][j],
            turns=range(6),
        )  # fmt: skip
        for c in found:
            state = c.motion.at(q["T"][j])
            turn = (state.q["theta"] - q["θ1"][j]) / (2 * np.pi)
            off = max(abs(state.q["r"] / q["r1"][j] - 1), 2 * np.pi * abs(turn - round(turn)))
            worst = max(worst, off)
    return {"end points of motions, worst": float(worst)}


def _rivals(q, row) -> dict[str, float | str]:
    """Microseconds of peers for one conic without a full turn, and what share of conics they give to 1e-9."""
    result: dict[str, float | str] = {}
    places = [np.array([np.cos(q[θ]) * q[r], np.sin(q[θ]) * q[r], 0 * q[r]]).T for r, θ in (("r0", "θ0"), ("r1", "θ1"))]
    for name, solver in (("lamberthub izzo2015", _lamberthub), ("pykep lambert_problem", _pykep)):
        try:
            call = solver()
            call(places[0][0], places[1][0], q["T"][0], True)
        except (ImportError, OSError) as fault:  # pykep 3.0.1 misses a file of its own
            result[name] = f"not usable: {fault}"
            continue
        spent, good, single = 0.0, 0, [j for j in range(min(300, len(q["T"]))) if not q["turns"][j]]
        for j in single:
            begin = time.process_time()
            try:
                v0 = call(places[0][j], places[1][j], q["T"][j], bool(q["way"][j] > 0))
            except (ValueError, RuntimeError):
                continue
            finally:
                spent += time.process_time() - begin
            h = places[0][j][0] * v0[1] - places[0][j][1] * v0[0]
            good += abs(h - q["h"][j]) <= 1e-9 * abs(q["h"][j])
        result[f"{name}, µs a conic"] = 1e6 * spent / len(single)
        result[f"{name}, of single-turn conics right to 1e-9"] = good / len(single)
    result["hjsolve in a batch, µs a conic"] = row["batch, µs a problem"] * row["problems"] / row["motions"]
    return result


def _lamberthub():
    from lamberthub import izzo2015

    return lambda r0, r1, T, forward: izzo2015(1.0, r0, r1, T, M=0, prograde=forward)[0]


def _pykep():
    from pykep import lambert_problem

    return lambda r0, r1, T, forward: lambert_problem(r0, r1, T, 1.0, not forward, 0).v0[0]


if __name__ == "__main__":
    main()
