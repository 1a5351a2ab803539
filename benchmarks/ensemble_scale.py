"""Many orbits: rate on one and on two threads, and the memory of a million.

``python benchmarks/ensemble_scale.py [repeats] [--json FILE]``. Generic bound orbits in the Kuzmin-Kutuzov galaxy of
the catalog. Rates are medians of interleaved runs of the same orbits; the results of both are compared bit for bit.
Peak memory is that of a fresh process that makes the orbits, computes actions, frequencies and angles of all, and holds
the result. Orbits that the vectorised engine hands back are left as they are: the statuses, printed, count them.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from typing import Any

import numpy as np

import hjsolve

SYSTEM, WANT = "kuzmin-kutuzov", ("actions", "frequencies", "angles")
LIMITS = {"two threads over one": 1.7, "peak memory of 10⁶ orbits, GB": 1.5}

_MEMORY = """
import resource, sys
sys.path.insert(0, {folder!r})
from ensemble_scale import orbits, WANT, SYSTEM
import hjsolve
q, p = orbits({count})
few = ({{n: x[:2000] for n, x in group.items()}} for group in (q, p))
hjsolve.ensemble(SYSTEM, *few, want=WANT, fallback=False)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
batch = hjsolve.ensemble(SYSTEM, q, p, want=WANT, fallback=False)
print(before * 1024, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024, *batch.summary().items(), sep="|")
"""


def orbits(count: int, seed: int = 7) -> tuple[dict[str, Any], dict[str, Any]]:
    """Bound orbits around the entry's own motion: places and momenta spread by a third."""
    entry = hjsolve.catalog.describe(SYSTEM)
    start = entry.motions["default"]
    motion = hjsolve.solve(entry.system).motion(**start.arguments)
    state = motion.at(0)
    generator = np.random.default_rng(seed)
    spread = lambda x: x * generator.uniform(0.8, 1.2, count) if x else generator.uniform(-0.05, 0.05, count)  # noqa: E731
    return ({n: spread(float(x)) for n, x in state.q.items()}, {n: spread(float(x)) for n, x in state.p.items()})


def seconds(q: dict[str, Any], p: dict[str, Any], threads: int) -> tuple[float, Any]:
    """Wall time of one ensemble, and its result."""
    begin = time.perf_counter()
    batch = hjsolve.ensemble(SYSTEM, q, p, want=WANT, threads=threads, fallback=False)
    return time.perf_counter() - begin, batch


def rates(repeats: int, count: int = 100_000) -> dict[str, Any]:
    """Rates on one and two threads, interleaved."""
    q, p = orbits(count)
    seconds({n: x[:2000] for n, x in q.items()}, {n: x[:2000] for n, x in p.items()}, 1)
    times: dict[int, list[float]] = {1: [], 2: []}
    found = {}
    for _ in range(repeats):
        for threads, spent in times.items():
            took, found[threads] = seconds(q, p, threads)
            spent.append(took)
    same = all(found[1].columns[n].tobytes() == found[2].columns[n].tobytes() for n in found[1].columns)
    one, two = (statistics.median(times[k]) for k in (1, 2))
    return {
        "orbits": count, "µs per orbit, one thread": 1e6 * one / count, "µs per orbit, two threads": 1e6 * two / count,
        "two threads over one": one / two, "same bits": same, "statuses": found[1].summary(),
    }  # fmt: skip


def memory(count: int = 1_000_000) -> dict[str, Any]:
    """Peak memory of a process that treats so many orbits."""
    from pathlib import Path

    code = _MEMORY.format(folder=str(Path(__file__).parent), count=count)
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split("|")
    return {"before, GB": int(printed[0]) / 1e9, "peak memory of 10⁶ orbits, GB": int(printed[1]) / 1e9}


def main() -> int:
    """Print the figures; 1 when a limit is broken."""
    arguments = [a for a in sys.argv[1:] if a.isdigit()]
    figures = {**rates(int(arguments[0]) if arguments else 5), **memory()}
    for name, value in figures.items():
        limit = f"   must be {'≥' if 'over' in name else '≤'} {LIMITS[name]}" if name in LIMITS else ""
        print(f"{name:<34} {value:.4g}{limit}" if isinstance(value, float) else f"{name:<34} {value}")
    if "--json" in sys.argv:
        from pathlib import Path

        text = json.dumps(figures, indent=1, ensure_ascii=False)
        Path(sys.argv[sys.argv.index("--json") + 1]).write_text(text + "\n")
    broken = figures["two threads over one"] < 1.7 or figures["peak memory of 10⁶ orbits, GB"] > 1.5
    return int(broken or not figures["same bits"])


if __name__ == "__main__":
    raise SystemExit(main())
