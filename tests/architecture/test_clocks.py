"""No result depends on how fast the machine is: clocks are read only where a limit of time is what is asked for, or where time is shown."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.support.sources import ROOT, tree_of

PACKAGE = ROOT / "hjsolve"
READS = {"monotonic", "perf_counter", "process_time", "thread_time", "time", "perf_counter_ns", "time_ns"}
LIMITS = {
    "algebra/poly.py": "budgets of exact arithmetic: the user's seconds, and processor time of the thread",
    "algebra/relations.py": "processor time of the thread for relations between generators",
    "algebra/time_limit.py": "deadlines of searches",
    "closed_form/time_limit.py": "processor time of the thread for a derivation",
    "one_coordinate/time_along_a_path.py": "processor time of the thread; what is not decided in it is an error",
    "coordinates/find.py": "the user's budget, and the seconds that are shown",
    "separation/decision.py": "seconds that are shown",
    "reports/content.py": "seconds that are shown",
    "ensembles/kernels_on_disk.py": "seconds of compiling that are shown",
    "display/progress.py": "when a bar of progress appears",
}
"""Files that read a clock, and what for. What is measured for its own sake is in ``MEASURE``."""
MEASURE = ("costs/", "scenes/", "explorer/", "sweeps/", "command_line/")


def reads(path: Path) -> bool:
    """Whether a file reads a clock.

    Args:
        path: of a module.
    """
    names = set()
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.module == "time":
            return True
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "time":
            names.add(node.attr)
    return bool(names & READS)


def test_only_these_files_read_a_clock():
    found = {str(p.relative_to(PACKAGE)) for p in PACKAGE.rglob("*.py") if reads(p)}
    assert {name for name in found if not name.startswith(MEASURE)} == set(LIMITS)


def test_processor_time_of_the_whole_process_limits_nothing():
    """It counts other threads, so that what is decided would depend on what they do."""
    for name in LIMITS:
        if not name.startswith("ensembles/"):
            assert "time.process_time" not in (PACKAGE / name).read_text(), name
