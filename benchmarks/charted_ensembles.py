"""What it costs that an ensemble is given in x, y, z: the map alone, and ensembles with and without it.

    python benchmarks/charted_ensembles.py [ORBITS] [NAME …]

For every system: random starts in x, y, z; the processor time of the ensemble in x, y, z, of the ensemble of the same
orbits in the separated coordinates, their difference, and the map alone, in µs an orbit,
medians of nine calls of each in turn; and how many orbits the doubles of each make good. One thread, no fallback.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import hjsolve
from benchmarks.charted_systems import PLANE, SPACE, centre_of, system_named
from hjsolve.ensembles.charted import chart_map
from hjsolve.ensembles.charted.charted_starts import charted_starts
from hjsolve.ensembles.engine import build
from hjsolve.motion.initial_data import parameter_values

_NAMES = (
    "two centres, turned", "Kepler", "Stark, tilted", "quartic 1:6:1", "Garnier, turned", "two centres", "Kepler 3D",
    "Stark, tilted 3D", "Garnier 3D", "oblate (Vinti)",
)  # fmt: skip
_WANT = ("actions", "frequencies")


def _in_turn(calls: list[Callable[[], Any]], count: int, repeats: int = 9) -> tuple[list[float], list[Any]]:
    """Median processor times in µs an orbit of calls that take turns, after one that does not count; their results."""
    given, times = [call() for call in calls], [[0.0] * repeats for _ in calls]
    for k in range(repeats):
        for call, own in zip(calls, times, strict=True):
            begin = time.process_time()
            call()
            own[k] = time.process_time() - begin
    return [statistics.median(own) / count * 1e6 for own in times], given


def measure(name: str, count: int) -> str:
    """Return a row of the table."""
    system = system_named(name)
    solution = hjsolve.solve(system, coordinates="find")
    if solution.chart is None:
        return f"{name} | as given"
    dice, names = np.random.default_rng(1), [c.name for c in system.coordinates]
    q = {c: dice.uniform(-1, 1, count) + o for c, o in zip(names, centre_of(name), strict=False)}
    v = {c: dice.uniform(-0.5, 0.5, count) for c in names}
    engine = build(solution, frozenset(_WANT))
    chart = chart_map(solution, engine.model, parameter_values(solution.system, {}), "velocity")
    x, w = np.stack(list(q.values())), np.stack(list(v.values()))
    starts = charted_starts(chart, x, w)
    own, given = hjsolve.solve(solution.system), engine.model.names
    there = {"q": dict(zip(given, starts.q, strict=True)), "p": dict(zip(given, starts.p, strict=True))}
    options = {"want": _WANT, "fallback": False, "threads": 1}
    calls = [
        lambda: hjsolve.ensemble(solution, q=q, velocity=v, **options),
        lambda: hjsolve.ensemble(own, **there, **options),
        lambda: charted_starts(chart, x, w),
    ]
    (mine, theirs, map_cost), batches = _in_turn(calls, count)
    good = [int(np.count_nonzero(b.codes == 0)) for b in batches[:2]]
    times = f"{mine:.1f} ({good[0]}) | {theirs:.1f} ({good[1]}) | {mine - theirs:.1f} | {map_cost:.2f}"
    return f"{name} | {solution.chart.kind} | {times}"


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    chosen = [n for n in (*PLANE, *SPACE) if any(a in n for a in sys.argv[2:])] or _NAMES
    columns = "x y z, µs (good) | separated (good) | x y z add | of it the map"
    print(f"system | web | {columns}")
    for name in chosen:
        print(measure(name, count), flush=True)


if __name__ == "__main__":
    main()
