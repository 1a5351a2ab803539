"""Fresh processes with empty folders for machine code, whose threads do every job of ``thread_jobs`` at once.

    python -m tests.support.cold_starts STARTS THREADS NUMBA

What a thread gives that one thread alone does not give is printed, as it is and as it must be; the exit status is 1
then. NUMBA is ``numba`` (20 s a start) or ``plain`` (5 s).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile

from tests.support.thread_jobs import JOBS


def started(threads: int, numba: str) -> dict:
    """What a fresh process tells.

    Args:
        threads: that do every job at once.
        numba: ``numba`` or ``plain``.
    """
    with tempfile.TemporaryDirectory() as folder:
        settings = {**os.environ, "HJSOLVE_CACHE_DIR": folder, "PYTHONHASHSEED": "0"}
        command = [sys.executable, "-m", "tests.support.thread_jobs", str(threads), numba, *JOBS]
        run = subprocess.run(command, capture_output=True, text=True, env=settings, check=True)
    return json.loads(run.stdout)


def main(starts: int, threads: int, numba: str) -> int:
    """Start, compare and print; gives the number of starts that differ."""
    (alone,), differing = started(1, numba)["told"], 0
    for n in range(starts):
        found = started(threads, numba)
        different = {(job, one[job]) for one in found["told"] for job in JOBS if one[job] != alone[job]}
        for job, text in sorted(different):
            print(f"start {n}, {job}:\n  {text}\n  must be\n  {alone[job]}", flush=True)
        unkept = [name for name, good in found["kept"].items() if not good]
        if unkept:
            print(f"start {n}: not left as found: {', '.join(unkept)}", flush=True)
        differing += bool(different or unkept)
        print(f"{n + 1} starts × {threads} threads, {numba}: {differing} differ", end="\r", flush=True)
    print()
    return differing


if __name__ == "__main__":
    sys.exit(1 if main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]) else 0)
