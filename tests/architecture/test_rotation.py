"""What a commit waits for: entries of every family, a part that rotates until all have run, and no clock."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.support import rotation, slow_tests

TESTS = Path(__file__).resolve().parents[1]
SCRIPTS = {"tests/support/hard_table.py"}
"""They write a page and say how long that took; no test runs them."""


class Item:
    """As much of a collected test as is looked at."""

    def __init__(self, nodeid: str, *marks: pytest.Mark):
        self.nodeid, self.marks = nodeid, list(marks)

    def iter_markers(self, name: str) -> list[pytest.Mark]:
        return [mark for mark in self.marks if mark.name == name]

    def get_closest_marker(self, name: str) -> pytest.Mark | None:
        return next(iter(self.iter_markers(name)), None)

    def add_marker(self, mark: pytest.MarkDecorator) -> None:
        self.marks.append(mark.mark)


def left_out(items: list[Item], number: int) -> set[str]:
    rotation.leave_the_rest(items, number)
    return {item.nodeid for item in items if item.get_closest_marker("nightly")}


def test_an_entry_of_every_family_runs_always_and_every_entry_within_sixteen_rotations() -> None:
    fixed = set(rotation.FIXED.values())
    assert len(rotation.FIXED) == len(fixed) == 12
    chosen = [rotation.entries(number) for number in range(16)]
    assert all(fixed < found and len(found) <= 20 for found in chosen)
    assert set().union(*chosen) == set(rotation.ENTRIES)
    assert rotation.entries(3) == rotation.entries(19) != rotation.entries(4)


@pytest.mark.parametrize(("length", "count"), [(344, 40), (14, 4), (3, 5), (1, 1), (7, 7)])
def test_parts_are_about_as_long_as_asked_and_together_everything(length: int, count: int) -> None:
    cases = {f"case {i}" for i in range(length)}
    number = -(-length // count)
    parts = [rotation.part(cases, count, n) for n in range(number)]
    assert sum(map(len, parts)) == length
    assert set().union(*parts) == cases
    assert max(map(len, parts)) <= count


def test_marks_leave_their_cases_for_the_night() -> None:
    marked = {
        "slow": pytest.mark.nightly_cases("a").mark, "entries": pytest.mark.entries.mark,
        "long": pytest.mark.rotating(2).mark, "night": pytest.mark.nightly.mark,
    }  # fmt: skip
    cases = {"slow": "ab", "entries": [*rotation.ENTRIES, "no entry"], "long": "abcdef", "night": "a", "plain": "ab"}

    def items() -> list[Item]:
        return [Item(f"{f}[{c}]", *([marked[f]] if f in marked else [])) for f, names in cases.items() for c in names]

    out = left_out(items(), 7)
    assert out == left_out(items()[::-1], 7)
    assert {name for name in out if name[:5] in ("slow[", "night", "plain")} == {"slow[a]", "night[a]"}
    assert {c for c in cases["entries"] if f"entries[{c}]" not in out} == {*rotation.entries(7), "no entry"}
    assert sum(f"long[{c}]" not in out for c in "abcdef") == 2


def test_each_slow_test_runs_with_one_commit_in_five() -> None:
    slow = list(slow_tests.slow_tests())
    assert len(set(slow)) == len(slow) > 100
    out = [left_out([Item(name) for name in [*slow, "tests/a.py::quick"]], number) for number in range(6)]
    assert all(sum(name not in left for left in out[:5]) == 1 for name in slow)
    assert out[0] == out[5]
    assert not any("tests/a.py::quick" in left for left in out)
    files = {name.partition("::")[0] for name in slow}
    assert [name for name in files if not (TESTS.parent / name).exists()] == []


def test_the_list_of_slow_tests_is_made_of_what_pytest_prints() -> None:
    printed = "0.50s call     tests/a.py::b[x y]\n1.20s call     tests/b.py::c\n3s setup tests/b.py::c\n0.10s call tests/b.py::c\n9.00s call tests/docs/d.py::e"
    assert slow_tests.found_in(printed) == ["tests/b.py::c", "tests/a.py::b[x y]"]


def test_without_a_repository_or_without_git_the_rotation_is_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rotation, "ROOT", tmp_path)
    assert rotation.of_the_commit() == 0
    (tmp_path / ".git").mkdir()
    assert rotation.of_the_commit() == 0
    monkeypatch.setenv("PATH", str(tmp_path))
    assert rotation.of_the_commit() == 0


def test_no_test_reads_a_clock() -> None:
    """Speed is a ratio in benchmarks/; a test that measures seconds fails on a busy machine."""
    clocks = {"perf_counter", "process_time", "monotonic", "time", "thread_time"}
    for path in TESTS.rglob("*.py"):
        if path.relative_to(TESTS.parent).as_posix() in SCRIPTS:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not (node.module == "time" and clocks & {a.name for a in node.names}), path
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "time":
                assert node.attr not in clocks, (path, node.lineno)
