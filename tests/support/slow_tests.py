"""Which tests take longest: one in five of them runs with a commit, another one with the next.

``slow_tests.txt`` lists those of a third of a second and more, slowest first. It is made of what runs print:

    python -m pytest -n 2 --durations=0 --durations-min=0.3 > durations.txt; python -m tests.support.slow_tests durations.txt

One run knows its own rotation. Texts of several runs may stand in the file, of all with ``--rotation=-1``.
"""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path

LIST = Path(__file__).with_suffix(".txt")
ONE_IN = 5
ALWAYS = ("tests/architecture/", "tests/docs/")
"""What every commit runs, however long it takes: threads that start cold, the examples of README."""
_LONG = re.compile(r"\s*([\d.]+)s call +(tests/.+)")


@cache
def slow_tests() -> dict[str, int]:
    """Return the place of each slow test in the list."""
    return {line: place for place, line in enumerate(LIST.read_text(encoding="utf-8").splitlines())}


def left_out(nodeid: str, rotation: int) -> bool:
    """Whether a test is slow and another commit's: neighbours in the list, which take equally long, go to five parts."""
    place = slow_tests().get(nodeid)
    return place is not None and place % ONE_IN != rotation % ONE_IN


def found_in(durations: str) -> list[str]:
    """Return the slow tests among the durations that pytest prints, slowest first, each once."""
    rows = [(float(m[1]), m[2]) for line in durations.splitlines() if (m := _LONG.fullmatch(line))]
    longest = dict.fromkeys(nodeid for _, nodeid in sorted(rows, key=lambda row: -row[0]))
    return [nodeid for nodeid in longest if not nodeid.startswith(ALWAYS)]


if __name__ == "__main__":
    listed = found_in(Path(sys.argv[1]).read_text(encoding="utf-8"))
    LIST.write_text("\n".join(listed) + "\n", encoding="utf-8")
    print(f"{len(listed)} tests")
