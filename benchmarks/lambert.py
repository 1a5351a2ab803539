"""Lambert's problem: random Kepler problems with 0 to 5 turns, both ways round, against 40 digits and against peers.

    python -m benchmarks.lambert                      1 000 problems
    python -m benchmarks.lambert --rivals FOLDER      where lamberthub and pykep are installed, if not with hjsolve

Conics are made first (eccentricities to 0.99, and hyperbolas), so that one answer is known. The number of answers is
that of the roots of Lagrange's equation. Motions of a sample of the problems are followed to their end by quadratures
in doubles, and from momenta to 30 digits by Kepler's equation to 40.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import mpmath
import numpy as np

import hjsolve

MP = mpmath.mp.clone()
MP.dps = 40


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
    options.add_argument("--ends", type=int, default=100, help="problems whose motions are followed to their end")
    options.add_argument("--rivals", default="", help="folder of pip install --target with lamberthub and pykep")
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
    row |= _ends(solution, q, chosen.ends)
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


def _ends(solution, q, count) -> dict[str, float]:
    """Where motions of a sample of problems end: by quadratures in doubles, and by Kepler's equation to 40 digits."""
    motions, quadratures, equation = 0, 0.0, 0.0
    for j in np.random.default_rng(2).choice(len(q["T"]), min(count, len(q["T"])), replace=False):
        r0, θ0, r1, θ1, T = (float(q[name][j]) for name in ("r0", "θ0", "r1", "θ1", "T"))
        ask = {"q0": {"r": r0, "theta": θ0}, "q1": {"r": r1, "theta": θ1}, "time": T, "turns": range(6)}

        def off(r, θ, r1=r1, θ1=θ1):
            turn = (θ - MP.mpf(θ1)) / (2 * MP.pi)
            return float(max(abs(r / MP.mpf(r1) - 1), 2 * MP.pi * abs(turn - MP.nint(turn))))

        for c in solution.two_point(**ask):
            end = c.motion.at(T)
            motions, quadratures = motions + 1, max(quadratures, off(end.q["r"], end.q["theta"]))
        for c in solution.two_point(**ask, digits=30):
            equation = max(equation, off(*_kepler(r0, θ0, c.motion.at(0).p, T)))
    return {
        "motions followed to their end": motions, "worst end point, motions in doubles": quadratures,
        "worst end point by Kepler's equation, momenta to 30 digits": equation,
    }  # fmt: skip


def _kepler(r, θ, p, T):
    """Where a conic is after a time (m = k = 1), by Kepler's equation."""
    r, T, v, h = MP.mpf(r), MP.mpf(T), MP.mpf(p["r"]), MP.mpf(p["theta"])
    energy = (v**2 + h**2 / r**2) / 2 - 1 / r
    a, e = abs(1 / (2 * energy)), MP.sqrt(1 + 2 * energy * h**2)
    sine, cosine, side = (MP.sin, MP.cos, 1) if energy < 0 else (MP.sinh, MP.cosh, -1)
    w = r * v / MP.sqrt(a) / e
    first = MP.atan2(w, (1 - r / a) / e) if energy < 0 else MP.asinh(w)
    mean = side * (first - e * sine(first)) + T / a ** MP.mpf(1.5)

    def miss(x):
        return side * (x - e * sine(x)) - mean

    low, high = first, first + MP.mpf(1)
    while miss(high) < 0:
        low, high = high, high + 1
    x = MP.findroot(miss, (low, high), solver="anderson", tol=MP.mpf(10) ** -70, maxsteps=200)

    def anomaly(x):
        return MP.atan2(MP.sqrt(abs(1 - e**2)) * sine(x), side * (cosine(x) - e))

    turned = anomaly(x) - anomaly(first)
    return side * a * (1 - e * cosine(x)), MP.mpf(θ) + (turned if h > 0 else -turned)


def _rivals(q, row) -> dict[str, float | str]:
    """Microseconds of peers for all conics of a problem, 0 to 5 turns both ways, and what they miss of these."""
    result: dict[str, float | str] = {}
    places = [np.array([np.cos(q[θ]) * q[r], np.sin(q[θ]) * q[r], 0 * q[r]]).T for r, θ in (("r0", "θ0"), ("r1", "θ1"))]
    for name, solver in (("lamberthub izzo2015", _lamberthub), ("pykep lambert_problem", _pykep)):
        try:
            call = solver()
            call(places[0][0], places[1][0], q["T"][0])
        except (ImportError, OSError) as fault:
            result[name] = f"not usable: {fault}"
            continue
        spent, conics, right = 0.0, 0, 0
        for j in range(len(q["T"])):
            begin = time.process_time()
            velocities = np.array(call(places[0][j], places[1][j], q["T"][j]))
            spent += time.process_time() - begin
            conics += len(velocities)
            h = places[0][j][0] * velocities[:, 1] - places[0][j][1] * velocities[:, 0]
            right += bool(np.any(np.abs(h - q["h"][j]) <= 1e-9 * abs(q["h"][j])))
        each = 1e6 * spent / len(q["T"])
        result[f"{name}, µs a problem"] = each
        result[f"{name}, µs a problem over hjsolve's in a batch"] = each / row["batch, µs a problem"]
        result[f"{name}, conics"] = conics
        result[f"{name}, known conics missed (1e-9)"] = len(q["T"]) - right
    return result


def _lamberthub():
    from lamberthub import izzo2015

    def call(r0, r1, T):
        found = []
        for forward in (True, False):
            for N in range(6):
                for low in (True, False)[: 1 + (N > 0)]:
                    try:
                        found.append(izzo2015(1.0, r0, r1, T, N, forward, low)[0])
                    except ValueError:  # "no feasible solution" with so many turns, or it did not converge
                        continue
        return found

    return call


def _pykep():
    try:
        import pykep.core as core
    except OSError:  # pykep 3.0.1 lacks a data file of its gym, which it reads after its compiled part is there
        core = sys.modules["pykep.core"]
    return lambda r0, r1, T: [v for back in (False, True) for v in core.lambert_problem(r0, r1, T, 1.0, back, 5).v0]


if __name__ == "__main__":
    main()
