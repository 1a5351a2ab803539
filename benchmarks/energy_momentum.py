"""Kinds of motion read off energy–momentum maps against those of motions started one by one.

For each system random points (x, y) of the map's window and random places q with P² > 0; ``map.kinds_at(x, y, q=…)``
for all at once, and ``solution.motion(…).kinds`` for each. Where the map says that no motion passes, a motion must be
refused. Run with ``python benchmarks/energy_momentum.py [points] [seed] [systems]``: named, each has as many points
as among all sixteen; exit status 1 where one differs.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import hjsolve
from hjsolve.arithmetic.floats import Float64
from hjsolve.lowering import lower

SYSTEMS: dict[str, dict[str, Any]] = {
    "kepler-planar": {}, "spherical-pendulum": {}, "lagrange-top": {"x": "p_phi"}, "two-centres-plane": {}, "stark": {},
    "kepler-spherical": {}, "kerr": {"x": "p_phi", "y": "p_t"}, "schwarzschild": {"x": "alpha_2", "y": "p_t"},
    "henon-heiles-kdv": {}, "isochrone": {}, "tube-turning-freely": {}, "smorodinsky-winternitz": {},
    "torus-geodesics": {}, "kepler-parabolic": {}, "kuzmin-kutuzov": {}, "pendulum-on-block": {},
}  # fmt: skip


def places(solution: hjsolve.Solution, name: str, values: dict[Any, Any], rng: np.random.Generator, n: int) -> Any:
    """Random places in the domain of a coordinate, near its ends and far out too."""
    domain = solution.system.coordinate(name).domain
    if domain.kind == "angle":
        return rng.uniform(-np.pi, np.pi, n)
    low, high = (None if e is None else float(e.subs(values)) for e in (domain.lower, domain.upper))
    if low is not None and high is not None:
        return low + (high - low) * rng.uniform(0.002, 0.998, n)
    if low is not None:
        return low + np.exp(rng.normal(0.0, 1.5, n))
    return rng.normal(0.0, 2.0, n)


def moving(solution: hjsolve.Solution, found: Any, name: str, x: Any, y: Any, rng: np.random.Generator) -> Any:
    """Random places, of twelve for each point the first at which P² > 0, if there is one."""
    values = dict(found.coordinates[0].values)
    symbols = [solution.system.coordinate(name).symbol, *found.coordinates[0].constants, *values]
    tape = lower([solution.momentum_squared[name]], symbols)
    chosen = places(solution, name, values, rng, len(x))
    for _ in range(12):
        with np.errstate(all="ignore"):
            square = tape.run(Float64(), [chosen, x, y, *(float(v) for v in values.values())])[0]
        chosen = np.where(np.asarray(square, float) > 0, chosen, places(solution, name, values, rng, len(x)))
    return chosen


def differing(name: str, points: int, rng: np.random.Generator) -> Iterator[tuple[str, int, int, float, float]]:
    """Compare one system: what differs, motions compared, refusals compared, seconds of the map and of the motions."""
    solution = hjsolve.solve(name)
    found = hjsolve.energy_momentum_map(solution, **SYSTEMS[name])
    (x0, x1), (y0, y1) = found.window
    x, y = rng.uniform(x0, x1, points), rng.uniform(y0, y1, points)
    q = {n: moving(solution, found, n, x, y, rng) for n in solution.coordinates}
    begin = time.process_time()
    kinds = found.kinds_at(x, y, q=q)
    quick, begin = time.process_time() - begin, time.process_time()
    wrong, moved, refused = [], 0, 0
    for i in range(points):
        told = {n: kinds[n][i] for n in kinds}
        start = {c.name: float(q[c.name][i]) if c.name in q else 0 for c in solution.system.coordinates}
        constants = {**dict(found.constants), found.x: float(x[i]), found.y: float(y[i])}
        try:
            motion = solution.motion(
                q=start, constants=constants, signs=dict.fromkeys(solution.coordinates, 1),
                want=["constants", "turning_points"],
            )  # fmt: skip
        except hjsolve.ForbiddenMotionError:
            refused += 1
            if all(told.values()):
                wrong.append(f"{name}: refused at {constants} {start}, the map says {told}")
            continue
        moved += 1
        if dict(motion.kinds) != told:
            wrong.append(f"{name}: {dict(motion.kinds)} at {constants} {start}, the map says {told}")
    yield "\n".join(wrong), moved, refused, quick, time.process_time() - begin


def main(points: int = 10_000, seed: int = 1, *names: str) -> int:
    rng = np.random.default_rng(seed)
    each, bad, total = -(-points // len(SYSTEMS)), 0, 0
    print("| system | motions | refused | differ | map, ms for all | motions, ms each |\n|---|---|---|---|---|---|")
    for name in names or SYSTEMS:
        for wrong, moved, refused, quick, slow in differing(name, each, rng):
            count = len(wrong.splitlines())
            bad, total = bad + count, total + moved + refused
            times = f"{1e3 * quick:.0f} | {1e3 * slow / each:.1f}"
            print(f"| {name} | {moved} | {refused} | {count} | {times} |", flush=True)
            if wrong:
                print(wrong, flush=True)
    print(f"{total} points, {bad} differ (seed {seed})")
    return int(bad > 0)


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:3]), *sys.argv[3:]))
