"""What it costs that an ensemble is given in x, y, z: the map alone, and ensembles with and without it.

    python benchmarks/charted_ensembles.py [ORBITS] [NAME …]

For every system: random starts in x, y, z; the processor time of the map to the separated coordinates, of the ensemble
in x, y, z, and of the ensemble of the same orbits in the separated coordinates, in µs an orbit, in numpy and compiled
(where numba is there), and how many orbits the doubles of each make good. One thread, no fallback.
"""

from __future__ import annotations

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
from hjsolve.ensembles.engine.programs import available
from hjsolve.motion.initial_data import parameter_values

_NAMES = (
    "two centres, turned", "Kepler", "Stark, tilted", "quartic 1:6:1", "Garnier, turned", "two centres", "Kepler 3D",
    "Stark, tilted 3D", "Garnier 3D", "oblate (Vinti)",
)  # fmt: skip
_WANT = ("actions", "frequencies")


def _least(run: Callable[[], Any], count: int, repeats: int = 3) -> tuple[float, Any]:
    """The least processor time in µs an orbit, and the result."""
    times, result = [], run()
    for _ in range(repeats):
        begin = time.process_time()
        result = run()
        times.append(time.process_time() - begin)
    return min(times) / count * 1e6, result


def measure(name: str, count: int) -> str:
    """A row of the table."""
    system = system_named(name)
    solution = hjsolve.solve(system, coordinates="find")
    if solution.chart is None:
        return f"{name} | as given"
    dice, names = np.random.default_rng(1), [c.name for c in system.coordinates]
    q = {c: dice.uniform(-1, 1, count) + o for c, o in zip(names, centre_of(name), strict=False)}
    v = {c: dice.uniform(-0.5, 0.5, count) for c in names}
    engine = build(solution, frozenset(_WANT), compiled=False)
    chart = chart_map(solution, engine.model, parameter_values(solution.system, {}), "velocity")
    x, w = np.stack(list(q.values())), np.stack(list(v.values()))
    map_cost, starts = _least(lambda: charted_starts(chart, x, w), count)
    own, given = hjsolve.solve(solution.system), engine.model.names
    row = f"{name} | {solution.chart.kind} | {map_cost:.2f}"
    for compiled in (False, True) if available() else (False,):
        options = {"want": _WANT, "fallback": False, "compiled": compiled, "threads": 1}
        there = {"q": dict(zip(given, starts.q, strict=True)), "p": dict(zip(given, starts.p, strict=True))}
        with_map, mine = _least(lambda o=options: hjsolve.ensemble(solution, q=q, velocity=v, **o), count)
        without, theirs = _least(lambda o=options, t=there: hjsolve.ensemble(own, **t, **o), count)
        good = [int(np.count_nonzero(b.codes == 0)) for b in (mine, theirs)]
        row += f" | {with_map:.1f} ({good[0]}) | {without:.1f} ({good[1]})"
    return row


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    chosen = [n for n in (*PLANE, *SPACE) if any(a in n for a in sys.argv[2:])] or _NAMES
    print("system | web | map µs | numpy, x y z µs (good) | numpy, separated | compiled, x y z | compiled, separated")
    for name in chosen:
        print(measure(name, count), flush=True)


if __name__ == "__main__":
    main()
