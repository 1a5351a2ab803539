"""Cold processes whose threads all begin at once: how many give another bit than one thread alone.

    python -m benchmarks.cold_threads [RUNS] [--threads 4] [--minutes M] [--plain] [--empty] [--jobs NAME ...]

Each run is a fresh process (``tests.support.thread_jobs``); the machine code of ensembles is on disk unless ``--empty``
gives every run an empty folder, which is compiled anew and takes minutes. ``--plain`` hides numba. Exit status 1 where
a run differs, or does not end well.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

JOBS = ("motion", "ensemble", "50 digits", "certified", "functions", "separate")
ROOT = Path(__file__).resolve().parents[1]


def run(threads: int, options: argparse.Namespace, folder: str | None) -> dict[str, object] | str:
    """Return what the jobs of one fresh process told, or how it ended."""
    settings = {**os.environ, "PYTHONHASHSEED": "0"} | ({"HJSOLVE_CACHE_DIR": folder} if folder else {})
    command = [sys.executable, "-m", "tests.support.thread_jobs", str(threads)]
    done = subprocess.run(
        [*command, "plain" if options.plain else "numba", *options.jobs], capture_output=True, text=True, check=False,
        cwd=ROOT, env=settings,
    )  # fmt: skip
    return json.loads(done.stdout) if done.returncode == 0 else f"ended with {done.returncode}: {done.stderr[-300:]}"


def differences(found: dict[str, object] | str, expected: dict[str, str]) -> list[str]:
    """Return what differs from one thread alone."""
    if isinstance(found, str):
        return [found]
    wrong = {job for one in found["told"] for job in expected if one[job] != expected[job]}  # type: ignore[attr-defined]
    return sorted(wrong) + [f"{name} is not left as it was" for name, kept in found["kept"].items() if not kept]  # type: ignore[attr-defined]


def main() -> int:
    """Run and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="?", type=int, default=200)
    parser.add_argument("--threads", type=int, default=4)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so many")
    parser.add_argument("--plain", action="store_true", help="without numba")
    parser.add_argument("--empty", action="store_true", help="an empty folder of machine code for every run")
    parser.add_argument("--jobs", nargs="+", default=list(JOBS))
    options = parser.parse_args()
    begin, bad, count = time.monotonic(), 0, 0
    alone = run(1, options, None)
    if isinstance(alone, str):
        print(f"one thread alone {alone}")
        return 1
    (expected,) = alone["told"]  # type: ignore[misc]
    for count in range(1, options.runs + 1):
        with tempfile.TemporaryDirectory() as folder:
            found = differences(run(options.threads, options, folder if options.empty else None), expected)
        bad += bool(found)
        if found:
            print(f"run {count}: {', '.join(found)}", flush=True)
        if time.monotonic() - begin > 60 * options.minutes:
            break
    print(f"{count} cold starts of {options.threads} threads, {bad} with a difference")
    return int(bad > 0)


if __name__ == "__main__":
    raise SystemExit(main())
