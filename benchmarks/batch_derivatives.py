"""Derivatives of many orbits: what they cost next to the values, and whether every claim holds.

    python -m benchmarks.batch_derivatives price [--orbits 20000]
    python -m benchmarks.batch_derivatives claims [--motions 10000] [--seconds 3600] [--seed 1]

``price``: processor time of ``ensemble_derivatives`` over that of ``ensemble`` with actions and frequencies, one
thread, least of three each, in turns. ``claims``: random central fields, none of the catalog: sums of a
harmonic, a logarithmic, a Kepler and a narrow Gaussian term, lengths from 1e−3 to 1e3, from nearly circular to nearly
radial; against ``Motion.derivatives`` to 30 digits. Status 1 where an error is larger than was claimed.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np

import hjsolve
from benchmarks import galaxy_families as stars
from hjsolve.errors import HJSolveError

number = mpmath.mp.clone()
number.dps = 40
_AT_ONCE = 40
"""Random motions in one field."""
Array = Any


def galaxy_orbits(rows: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Places and momenta of stars in prolate coordinates."""
    u, w, pu, pw, pφ = stars.prolate(rows).T
    return {"u": u, "w": w, "phi": 0 * u}, {"u": pu, "w": pw, "phi": pφ}


def cases(count: int) -> Iterator[tuple[str, Any, dict[str, Array], dict[str, Array]]]:
    """Yield the five families, a disc with a halo, and orbits round the first one of catalog entries."""
    galaxy = stars.galaxy()
    for name in stars.FAMILIES:
        yield name, galaxy, *galaxy_orbits(stars.family(name, count))
    yield "disc and halo", galaxy, *galaxy_orbits(stars.disc_and_halo(count))
    rng = np.random.default_rng(1)
    for name in ("isochrone", "spherical-pendulum", "two-centres-space"):
        solution = hjsolve.solve(hjsolve.catalog.load(name))
        start = solution.motion(**hjsolve.catalog.describe(name).initial.arguments).initial.values
        q = {c.name: float(start[c.symbol]) * rng.uniform(0.9, 1.1, count) for c in solution.system.coordinates}
        p = {c.name: float(start[c.momentum]) * rng.uniform(0.8, 1.2, count) for c in solution.system.coordinates}
        yield name, solution, q, p


def price(count: int) -> None:
    """Print the table."""
    print("| orbits | values, µs | derivatives, µs | ratio | ok |\n|---|---|---|---|---|")
    for name, solution, q, p in cases(count):
        times: dict[str, list[float]] = {"values": [], "derivatives": []}
        for turn in range(4):
            begin = time.process_time()
            hjsolve.ensemble(solution, q, p, want={"actions", "frequencies"}, threads=1)
            middle = time.process_time()
            found = hjsolve.ensemble_derivatives(solution, q, p, threads=1)
            if turn:
                times["values"].append(middle - begin)
                times["derivatives"].append(time.process_time() - middle)
        values, derivatives = (1e6 * min(t) / count for t in times.values())
        ok = float((found.status == "ok").mean())
        print(f"| {name} | {values:.1f} | {derivatives:.1f} | {derivatives / values:.1f} | {ok:.2%} |", flush=True)


def field(rng: random.Random) -> tuple[Any, dict[str, Array], dict[str, Array]]:
    """Return a random field and random motions in it."""
    scale = 10.0 ** rng.uniform(-3, 3)
    r = f"(r/{scale!r})"
    parts = [
        f"{rng.uniform(0.1, 2)!r}*{r}**2", f"{rng.uniform(0.1, 2)!r}*log({rng.uniform(0.05, 2)!r} + {r}**2)",
        f"-{rng.uniform(0.2, 3)!r}/{r}", f"{rng.uniform(-0.5, 0.5)!r}*exp(-({r} - 1)**2/{rng.uniform(0.01, 0.3)!r})",
    ]  # fmt: skip
    chosen = rng.sample(parts, rng.randint(1, 3))
    system = hjsolve.System(
        {"r": "0 < r", "phi": "angle"}, "dot(r)**2/2 + r**2*dot(phi)**2/2", " + ".join(chosen)
    )  # fmt: skip
    places = np.array([scale * 10.0 ** rng.uniform(-1, 1) for _ in range(_AT_ONCE)])
    radial = np.array([rng.choice((0.0, 1.0)) * 10.0 ** rng.uniform(-8, 0) for _ in range(_AT_ONCE)])
    turning = np.array([10.0 ** rng.uniform(-3, 0.5) for _ in range(_AT_ONCE)])
    return hjsolve.solve(system), {"r": places, "phi": 0 * places}, {"r": radial, "phi": turning * places}


def judged(solution: Any, q: dict[str, Array], p: dict[str, Array], k: int, found: Any) -> tuple[list[str], float]:
    """Claims that do not hold for one motion, and its largest error over the size of the derivative."""
    start = {group: {n: float(x[k]) for n, x in own.items()} for group, own in (("q", q), ("p", p))}
    one = solution.motion(**start, digits=30).derivatives({"actions", "frequencies"}, {"constants"})
    broken, worst = [], 0.0
    for quantity, names in found.value.items():
        for name, constants in names.items():
            for constant, column in constants.items():
                truth = number.convert(one.value[quantity][name][constant])
                error = abs(number.mpf(float(column[k])) - truth)
                claim = float(found.error[quantity][name][constant][k])
                if truth:
                    worst = max(worst, float(error / abs(truth)))
                if error > claim + 1e-25 * (1 + abs(truth)):
                    broken.append(f"{start} {quantity} {name} {constant}: {float(error):.2g}, claimed {claim:.2g}")
    return broken, worst


def claims(motions: int, seconds: float, seed: int) -> int:
    """Print false claims, and how many there are."""
    begin, done, lost, faults, errors, index = time.monotonic(), 0, 0, 0, [0.0], 0
    while done < motions and time.monotonic() - begin < seconds:
        solution, q, p = field(random.Random(f"batch/{seed}/{index}"))
        index += 1
        found = hjsolve.ensemble_derivatives(solution, q, p, threads=1)
        lost += int((found.status == "not_converged").sum())
        for k in np.flatnonzero(found.status == "ok"):
            if time.monotonic() - begin > seconds:
                break
            try:
                broken, worst = judged(solution, q, p, int(k), found)
            except HJSolveError:
                continue
            done, faults = done + 1, faults + len(broken)
            errors.append(worst)
            for line in broken:
                print(index - 1, solution.system.potential, line, flush=True)
    median, most = np.quantile(errors, [0.5, 0.99])
    print(f"{done} motions in {index} fields, {lost} not converged: {faults} claims do not hold; relative errors "
          f"{median:.1e} (median), {most:.1e} (99 %)")  # fmt: skip
    return 1 if faults else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=("price", "claims"))
    parser.add_argument("--orbits", type=int, default=20_000)
    parser.add_argument("--motions", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.part == "claims":
        return claims(options.motions, options.seconds, options.seed)
    price(options.orbits)
    return 0


if __name__ == "__main__":
    sys.exit(main())
