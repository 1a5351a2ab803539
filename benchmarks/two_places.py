"""Two places and a time where nothing is proved: how many motions are found, and that each is one.

    python -m benchmarks.two_places --problems 50

A random motion of each system gives q0, q1 and T, so that one answer is known. Each motion found is run once more by an
integrator that shares nothing with hjsolve (DOP853 of scipy), and must end at q1, within 1e-7 and ten times what its
end moves by between the tolerances 1e-11 and 1e-13: next to a centre the integrator itself loses digits.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.errors import HJSolveError

PLANE = {"x": "line", "y": "line"}


def systems() -> dict[str, tuple[hjsolve.Solution, dict[str, tuple[float, float]], float, tuple[float, float]]]:
    """Name → solution, ranges of places, largest speed, range of times."""
    stark = hjsolve.System(PLANE, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt(x**2 + y**2) - x/20")
    centres = hjsolve.System(
        PLANE, "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt((x - 1)**2 + y**2) - 1/(2*sqrt((x + 1)**2 + y**2))"
    )
    vinti = hjsolve.catalog.load("vinti")
    return {
        "stark": (hjsolve.solve(stark, coordinates="find"), {"x": (-2, 2), "y": (0.5, 2)}, 1.0, (1, 6)),
        "two centres": (hjsolve.solve(centres, coordinates="find"), {"x": (-2, 2), "y": (0.5, 2)}, 1.0, (1, 6)),
        "vinti": (hjsolve.solve(vinti), _around(vinti), 1.0, (0.5, 3)),
        "spherical pendulum": (
            hjsolve.solve(hjsolve.catalog.load("spherical-pendulum")),
            {"theta": (0.4, 2), "phi": (-3, 3)}, 3.0, (0.3, 1.5),
        ),
        "ellipsoid": (
            hjsolve.solve(hjsolve.catalog.load("triaxial-geodesics")),
            _around(hjsolve.catalog.load("triaxial-geodesics")), 1.0, (0.3, 1.5),
        ),
    }  # fmt: skip


def _around(system: hjsolve.System) -> dict[str, tuple[float, float]]:
    """Places about those of the entry's own motion."""
    start = system.initial.q if hasattr(system, "initial") else {}
    result = {}
    for c in system.coordinates:
        low, high = (None if e is None else float(e.subs(system.defaults)) for e in (c.domain.lower, c.domain.upper))
        at = float(start.get(c.name, 0) or 0)
        if c.domain.kind == "angle":
            result[c.name] = (-3.0, 3.0)
        elif low is not None and high is not None:
            result[c.name] = (low + 0.2 * (high - low), high - 0.2 * (high - low))
        elif low is not None:
            result[c.name] = (low + 1, low + 2.5)
        else:
            result[c.name] = (at - 1, at + 1)
    return result


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--problems", type=int, default=50)
    options.add_argument("--only", default="")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    for name, (solution, ranges, speed, times) in systems().items():
        if chosen.only and chosen.only != name:
            continue
        _campaign(name, solution, ranges, speed, times, chosen.problems, chosen.seed)


def _campaign(name, solution, ranges, speed, times, problems, seed) -> None:
    rng = np.random.default_rng(seed)
    system = solution.system if solution.chart is None else solution.chart.original
    rhs = system.rhs()
    found = missed = motions = wrong = refused = 0
    worst, spent, done = 0.0, 0.0, 0
    while done < problems:
        q0 = {c: round(float(rng.uniform(*ranges[c])), 6) for c in ranges}
        velocity = {c: round(float(rng.normal()) * speed, 6) for c in ranges}
        T = round(float(rng.uniform(*times)), 6)
        try:
            known = solution.motion(q=q0, velocity=velocity)
            state = known.at(T)
            q1 = {c: float(state.q[c]) for c in ranges}
            p0 = {c: float(known.at(0).p[c]) for c in ranges}
            if state.status != "ok":
                continue
        except HJSolveError:
            continue
        done += 1
        begin = time.process_time()
        try:
            answer = solution.two_point(q0=q0, q1=q1, time=T, turns=range(4))
        except HJSolveError as fault:
            refused += 1
            print(name, "refused:", str(fault)[:100], file=sys.stderr)
            continue
        spent += time.process_time() - begin
        motions += len(answer)
        size = max(abs(x) for x in p0.values())
        hit = any(all(abs(c.p0[n].value - p0[n]) < 1e-6 * size for n in p0) for c in answer)
        found, missed = found + hit, missed + (not hit)
        if not hit:
            print(name, "missed:", q0, velocity, T, "found", len(answer), answer.complete.statement, file=sys.stderr)
        for c in answer:
            y0 = [*q0.values(), *(float(c.p0[n].value) for n in q0)]
            end, approximate = (
                solve_ivp(rhs, (0, T), y0, method="DOP853", rtol=r, atol=r / 10).y[:, -1] for r in (1e-13, 1e-11)
            )
            off = np.array([end[i] - q1[n] for i, n in enumerate(q0)])
            angle = np.array([k.domain.kind == "angle" for k in system.coordinates])
            off = np.where(angle, off - 2 * np.pi * np.rint(off / (2 * np.pi)), off)
            error = float(np.max(np.abs(off)))
            unsure = 10 * float(np.max(np.abs(end - approximate)[: len(q0)]))
            worst = max(worst, error if unsure < 1e-7 else 0.0)
            wrong += error > 1e-7 + unsure
    row = {"system": name, "problems": problems, "known motion found": found, "missed": missed, "refused": refused,
           "motions": motions, "wrong": wrong, "worst end point where DOP853 is sure of it": worst,
           "seconds each": round(spent / max(problems, 1), 2)}  # fmt: skip
    print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
