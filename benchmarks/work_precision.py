"""Accuracy against time over the whole catalog, and how the cost of a digit grows.

    python benchmarks/work_precision.py                 run everything, write docs/work-precision.json and the figures
    python benchmarks/work_precision.py --draw          draw the figures from the JSON again
    python benchmarks/work_precision.py pendulum morse  only these entries; nothing is written

Every entry runs in a process of its own, its default motion, for at most --seconds; an entry that does not come to an
end in five times as long is recorded as such. A run that was stopped goes on where it was. The rivals need
`pip install "hjsolve[bench]"`. Times are processor time of this machine: compare the methods with each other.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

import draw_work_precision

ROOT = Path(__file__).resolve().parents[1]
DOCS, PARTIAL = ROOT / "docs", ROOT / "build" / "work-precision.partial.json"
RESULTS = DOCS / "work-precision.json"
_ONE = """
import json, sys, hjsolve
from hjsolve.reports.sections.cost import plain_rows
table = hjsolve.cost(sys.argv[1], digits=(20, 30, 50), seconds=float(sys.argv[2]), repeats=2)
print(json.dumps(plain_rows(table)))
"""


def entry(name: str, seconds: float) -> dict[str, Any]:
    """Measure one entry in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _ONE, name, str(seconds)], capture_output=True, text=True, timeout=5 * seconds,
            env=environment, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"id": name, "failed": f"not done in {5 * seconds:.0f} s"}
    if done.returncode:
        return {"id": name, "failed": done.stderr.strip().splitlines()[-1][:200]}
    return json.loads(done.stdout)


def catalog(names: list[str], seconds: float, jobs: int, keep: bool) -> list[dict[str, Any]]:
    """Measure entries, several at a time; what is done is kept, so that a run that was stopped goes on where it was."""
    done = {one["id"]: one for one in (json.loads(PARTIAL.read_text()) if keep and PARTIAL.exists() else [])}

    def one(name: str) -> None:
        result = entry(name, seconds)
        with lock:
            done[name] = result
            print(f"[{len(done)}/{len(names)}] {name}: {result.get('failed') or summary(result)}", flush=True)
            if keep:
                PARTIAL.write_text(json.dumps(list(done.values())))

    lock = threading.Lock()
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(one, [name for name in names if name not in done]))
    return [done[name] for name in names]


def summary(result: dict[str, Any]) -> str:
    return " · ".join(
        f"{row['method']} {row['digits']:g}: {row['seconds'] * 1e3:.1f} ms {row['error']:.0e}"
        for row in result["rows"]
        if row["error"] is not None and row["seconds"] is not None
    )


# ------------------------------------------------------------------------------------------------ how the cost grows
def median_time(work: Callable[[], object], repeats: int = 3) -> float:
    work()
    clock = []
    for _ in range(repeats):
        begin = time.thread_time()
        work()
        clock.append(time.thread_time() - begin)
    return statistics.median(clock)


def growth() -> dict[str, Any]:
    """Seconds and evaluations against digits, closeness to a separatrix and number of times."""
    return {"times": by_times(), "separatrix": by_separatrix(), "digits": by_digits()}


def by_digits() -> dict[str, list[dict[str, float]]]:
    import hjsolve
    from hjsolve.arithmetic.work_counter import counted

    found: dict[str, list[dict[str, float]]] = {}
    for name in ("kepler-planar", "pendulum", "lagrange-top"):
        description = hjsolve.catalog.describe(name)
        solution = hjsolve.solve(description.system)
        for certified in (False, True):
            rows = found.setdefault(f"{name}, {'certified' if certified else 'plain'}", [])
            for digits in (15, 20, 30, 50, 70, 100, 150, 200):

                def work(digits: int = digits, certified: bool = certified) -> Any:
                    return solution.motion(
                        **description.initial.arguments, digits=digits, certified=certified, want={"periods", "actions"}
                    )

                seconds = median_time(work)
                with counted() as spent:
                    work()
                rows.append({"digits": digits, "seconds": seconds, "evaluations": spent.squares + spent.kernels})
                print(name, certified, rows[-1], flush=True)
    return found


def by_separatrix() -> dict[str, list[dict[str, float]]]:
    """Return the pendulum's period at an amplitude with k'² = 1 − k² = 10^−n, from its exact energy."""
    import hjsolve
    from hjsolve.arithmetic.work_counter import counted

    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    found: dict[str, list[dict[str, float]]] = {}
    for digits in (15, 30, 60):
        rows = found.setdefault(f"{digits} digits", [])
        for n in (0.3, 1, 2, 4, 6, 8, 10, 12, 16, 20):
            gap = Fraction(10) ** -int(n) if n >= 1 else Fraction(1, 2)
            # at the lowest point: E + mgl = m l² ω²/2 = 2 m g l k², with m = l = 1, g = 9.81
            square = 4 * Fraction(981, 100) * (1 - gap)

            def work(square: Fraction = square, digits: int = digits) -> Any:
                return solution.motion(
                    q={"theta": 0}, velocity={"theta": f"sqrt({square})"}, digits=digits, want={"periods"}
                )

            seconds = median_time(work)
            with counted() as spent:
                work()
            rows.append({"gap": float(gap), "seconds": seconds, "evaluations": spent.squares + spent.kernels})
            print(digits, rows[-1], flush=True)
    return found


def by_times() -> dict[str, list[dict[str, float]]]:
    """Kepler's ellipse over a hundred revolutions, at more and more times."""
    from hjsolve.costs.own_methods import own
    from hjsolve.costs.rivals import rival_trials
    from hjsolve.costs.trial import Task
    from hjsolve.scenes import Scene
    from hjsolve.solution.quadratures import solve

    found: dict[str, list[dict[str, float]]] = {}
    for count in (2, 10, 100, 1000, 10_000, 100_000):
        scene = Scene.load({
            "system": "kepler-planar", "want": ["trajectory"], "times": {"start": 0, "stop": 1500, "count": count},
        })  # fmt: skip
        task = Task(scene, solve(scene.system), ())
        trials = [own(task, "float64", 15)] + ([own(task, "mpmath", 20)] if count <= 100 else [])
        trials += [t for t in rival_trials(task) if (t.method, t.digits) in (("DOP853", 12.0), ("heyoka", 15.6))]
        for trial in trials:
            trial.prepare()
            seconds = median_time(lambda trial=trial: trial.compute(None, time.perf_counter() + 600))
            label = f"{trial.method}, {trial.digits:g} digits"
            found.setdefault(label, []).append({"times": count, "seconds": seconds})
            print(label, found[label][-1], flush=True)
    return found


# ------------------------------------------------------------------------------------------------ the figures
def table(entries: list[dict[str, Any]]) -> None:
    print("\nmedians over the entries where a method reached every accuracy")
    for method in draw_work_precision.NAMES:
        for seconds, error, count in draw_work_precision.medians(entries, method):
            print(f"  {method:12} {10**seconds * 1e3:10.2f} ms   {10**error:8.1e}   {count} entries")
    own = [row for one in entries for row in one.get("rows", ()) if row["held"] is not None]
    print(f"claims held: {sum(row['held'] for row in own)} of {len(own)} rows")
    for one in entries:
        for row in one.get("rows", ()):
            if row["held"] is False:
                told = f"claimed {row['claimed']}, is {row['error']}"
                print(f"  broken: {one['id']} {row['method']} {row['digits']}: {told}")


def write(results: dict[str, Any]) -> None:
    """Write the JSON, one entry of the catalog a line."""
    entries = ",\n".join(json.dumps(one, ensure_ascii=False) for one in results["catalog"])
    rest = json.dumps({**results, "catalog": []}, ensure_ascii=False)
    RESULTS.write_text(rest.replace('"catalog": []', f'"catalog": [\n{entries}\n]') + "\n", encoding="utf-8")


def main() -> None:
    import hjsolve

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("entries", nargs="*")
    parser.add_argument("--seconds", type=float, default=30.0, help="for one entry (default 30)")
    parser.add_argument("--jobs", type=int, default=1, help="entries at a time (times are of the processor)")
    parser.add_argument("--draw", action="store_true", help="draw again, measure nothing")
    options = parser.parse_args()
    if options.draw:
        draw_work_precision.draw(json.loads(RESULTS.read_text(encoding="utf-8")))
        return
    names = options.entries or [*hjsolve.catalog.ids("separable"), *hjsolve.catalog.ids("extended")]
    PARTIAL.parent.mkdir(exist_ok=True)
    entries = catalog(names, options.seconds, options.jobs, not options.entries)
    table(entries)
    if options.entries:
        return
    machine = {"python": platform.python_version(), "machine": platform.machine(), "cores": os.cpu_count()}
    results = {"machine": machine, "seconds": options.seconds, "catalog": entries, "growth": growth()}
    PARTIAL.unlink()
    write(results)
    draw_work_precision.draw(results)


if __name__ == "__main__":
    main()
