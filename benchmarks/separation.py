"""How long the decision takes, with every verdict checked: ``python benchmarks/separation.py``.

Times are processor times, the best of several runs in a warm process, of ``separate`` alone; the system is made
before. The process ends with status 1 when a verdict is wrong or a promised time is exceeded: 0.2 s for two
coordinates; 1 s, 5 s, 30 s for Jacobi's ellipsoidal coordinates in 3, 4 and 5 dimensions.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from hjsolve.mechanics.system import System
from hjsolve.separation import Obstruction, Separation, separate
from tests.support.separation_cases import E3, ONE_DIMENSIONAL, REFUSED, SEVERAL, ellipsoidal

RUNS = 5
ELLIPSOIDAL_LIMITS = {3: 1.0, 4: 5.0, 5: 30.0}


def measured(system: System, runs: int = RUNS) -> tuple[object, float]:
    """Return the verdict and the best time of several runs, in seconds; one run is enough where it is slow."""
    best, verdict = float("inf"), None
    for _ in range(runs):
        start = time.process_time()
        verdict = separate(system, budget=60.0)
        best = min(best, time.process_time() - start)
        if best > 1.0:
            break
    return verdict, best


def limit(system: System) -> float:
    return 0.2 if len(system.coordinates) <= 2 else 2.0


def cases() -> list[tuple[str, System, type, float]]:
    found = [(name, s, Separation, limit(s)) for name, s in {**ONE_DIMENSIONAL, **SEVERAL, **E3}.items()]
    found += [(f"refused: {name}", s, Obstruction, limit(s)) for name, (s, _, _) in REFUSED.items()]
    for n, seconds in ELLIPSOIDAL_LIMITS.items():
        found.append((f"Jacobi ellipsoidal, n = {n}", ellipsoidal("uvwxy"[:n], "abcde"[:n]), Separation, seconds))
    return found


def main() -> int:
    separate(SEVERAL["P5-6"])
    faults = 0
    print(f"{'system':52s} {'verdict':12s} {'ms':>9s} {'limit ms':>9s}")
    for name, system, expected, seconds in cases():
        verdict, best = measured(system)
        right, fast = isinstance(verdict, expected), best <= seconds
        faults += not (right and fast)
        mark = "" if right and fast else "  <-- " + ("slow" if right else "WRONG")
        print(f"{name:52s} {type(verdict).__name__:12s} {1e3 * best:9.1f} {1e3 * seconds:9.0f}{mark}")
    print("all verdicts right and in time" if not faults else f"{faults} faults")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
