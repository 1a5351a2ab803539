"""What a user waits for: fresh processes, medians of repeated runs. ``python benchmarks/cold_start.py [repeats]``.

Prints one line a command: median, fastest and slowest wall time in seconds, and the limit it must keep.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LIMITS = {
    "python -c pass": ([sys.executable, "-c", "pass"], None),
    "import hjsolve": ([sys.executable, "-c", "import hjsolve"], 0.2),
    "hjsolve --help": ([sys.executable, "-m", "hjsolve", "--help"], None),
    "hjsolve check kepler-planar": ([sys.executable, "-m", "hjsolve", "check", "kepler-planar"], 2.0),
    "hjsolve check henon-heiles": ([sys.executable, "-m", "hjsolve", "check", "henon-heiles"], None),
    "hjsolve report kepler-planar -o k.html": (
        [sys.executable, "-m", "hjsolve", "report", "kepler-planar", "-o", "k.html"],
        8.0,
    ),
}


def seconds(command: list[str], folder: Path) -> float:
    """Run a command once in a folder of its own."""
    begin = time.perf_counter()
    done = subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    spent = time.perf_counter() - begin
    if done.returncode not in {0, 1}:
        raise SystemExit(done.stderr.decode())
    return spent


def measure(repeats: int) -> dict[str, list[float]]:
    """Run all commands in turn, so that a busy moment of the machine hits them alike."""
    times: dict[str, list[float]] = {name: [] for name in LIMITS}
    with tempfile.TemporaryDirectory() as folder:
        for round_number in range(repeats + 1):
            for name, (command, _) in LIMITS.items():
                spent = seconds(command, Path(folder))
                if round_number:  # the first round warms the disk
                    times[name].append(spent)
    return times


def main() -> int:
    """Print the table; 1 when a limit is broken."""
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    broken = 0
    for name, times in measure(repeats).items():
        limit = LIMITS[name][1]
        middle = statistics.median(times)
        broken += limit is not None and middle > limit
        shown = f"limit {limit:.1f}" if limit is not None else ""
        print(f"{name:<40} median {middle:.3f}  min {min(times):.3f}  max {max(times):.3f}  {shown}")
    return int(broken > 0)


if __name__ == "__main__":
    raise SystemExit(main())
