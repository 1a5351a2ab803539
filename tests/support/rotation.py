"""Which cases of a long list run with a commit: some that never change, and a part that the hash of the commit chooses.

Four marks leave cases to the night (they are marked ``nightly``, which ``addopts`` in pyproject.toml deselects):

``@pytest.mark.nightly_cases("a", "b")``
    Those with these parameters, which take long.

``@pytest.mark.entries``
    The cases are entries of the catalog. Run are those of FIXED, one for each family, and one of ``len/8`` parts of the rest.
``@pytest.mark.rotating(n)``
    About n cases run, one of ``len/n`` parts. Cases that are marked nightly themselves do not count.
``pytestmark = pytest.mark.rotating_file(n)``
    About n of all tests of a file run, chosen alike.

Of the slowest tests, those of ``slow_tests.txt``, one in five runs.

The rotation is a whole number N. Parts are numbered, and part N modulo their number runs, so that the rotations 0, 1, 2, …
run every case. N comes from the commit, or from ``--rotation=N``, which runs the part of a run that failed again;
``--rotation=-1`` runs every part.
"""

from __future__ import annotations

import hashlib
import re
import subprocess
from collections import defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from tests.support import slow_tests

ROOT = Path(__file__).resolve().parents[2]
EVERY = -1
"""The rotation that leaves nothing out."""
ENTRIES = {path.stem: path.parent.name for path in sorted((ROOT / "catalog").glob("*/*.toml"))}
FIXED = {
    "Cartesian": "anisotropic-oscillator", "polar": "kepler-planar", "spherical": "kepler-spherical",
    "parabolic": "kepler-parabolic", "elliptic": "two-centres-plane", "two centres": "two-centres-space",
    "sphere": "spherical-pendulum", "Kerr": "kerr", "gyroscopic": "gyroscopic-pair", "found chart": "henon-heiles-separable",
    "refused": "henon-heiles", "extended": "relativistic-kepler",
}  # fmt: skip
"""The entry of each family that runs with every commit."""
_ENTRY = re.compile(f"({'|'.join(map(re.escape, sorted(ENTRIES, key=len, reverse=True)))})(?![a-z])")


def of_the_commit() -> int:
    """A number made of the hash of the commit that is checked out, or 0 where there is no repository or no git."""
    if not (ROOT / ".git").exists():
        return 0
    command = ["git", "-C", str(ROOT), "rev-parse", "HEAD"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, check=True, timeout=20)
    except (OSError, subprocess.SubprocessError):
        return 0
    return int(found.stdout[:6], 16)


def part(cases: Iterable[str], count: int, rotation: int, group: Callable[[str], str] = lambda case: "") -> set[str]:
    """About ``count`` of the cases; the rotations 0, 1, 2, … go through all of them, and through each group evenly."""
    ordered = sorted(cases, key=lambda case: (group(case), hashlib.sha256(case.encode()).digest()))
    parts = -(-len(ordered) // count)
    return set(ordered[rotation % parts :: parts]) if parts else set()


def entry_of(nodeid: str) -> str | None:
    """The entry of the catalog that the parameters of a test begin with, effects and quantities left out."""
    found = _ENTRY.match(nodeid.partition("[")[2])
    return found[1] if found else None


def entries(rotation: int) -> set[str]:
    """The entries of the catalog that run with a commit."""
    fixed = set(FIXED.values())
    return fixed | part(ENTRIES.keys() - fixed, 8, rotation, ENTRIES.__getitem__)


def leave_the_rest(items: list[pytest.Item], rotation: int) -> None:
    """Mark as nightly what the marks ``entries`` and ``rotating`` leave out in this rotation."""
    chosen, long = entries(rotation), defaultdict(dict)
    for item in items:
        slow = {case for mark in item.iter_markers("nightly_cases") for case in mark.args}
        if item.nodeid.partition("[")[2][:-1] in slow:
            item.add_marker(pytest.mark.nightly)
        if item.get_closest_marker("nightly") or rotation == EVERY:
            continue
        if slow_tests.left_out(item.nodeid, rotation):
            item.add_marker(pytest.mark.nightly)
            continue
        if item.get_closest_marker("entries") and entry_of(item.nodeid) not in {None, *chosen}:
            item.add_marker(pytest.mark.nightly)
        elif mark := item.get_closest_marker("rotating"):
            long[item.nodeid.partition("[")[0], mark.args[0]][item.nodeid] = item
        elif mark := item.get_closest_marker("rotating_file"):
            long[item.nodeid.partition("::")[0], mark.args[0]][item.nodeid] = item
    for (_, count), cases in long.items():
        for left in cases.keys() - part(cases, count, rotation):
            cases[left].add_marker(pytest.mark.nightly)
