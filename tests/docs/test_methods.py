"""The page of methods: every row names a file that exists, and every room that computes numbers is on it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/methods.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| question")]
PATH = re.compile(r"`([\w/]+\.py)`")
WITHOUT_A_METHOD = {
    "catalog", "command_line", "display", "explorer", "plots", "reports", "sweeps", "units",
}  # fmt: skip
"""Rooms that read, write or draw."""


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.split("|")[1].strip())
def test_a_row_has_five_cells_and_names_files_that_exist(row: str) -> None:
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert len(cells) == 5
    assert cells[0]
    assert cells[1]
    assert PATH.findall(cells[2])
    assert [path for path in PATH.findall(row) if not (ROOT / "hjsolve" / path).is_file()] == []


def test_every_room_with_a_method_is_on_the_page() -> None:
    rooms = {path.parent.name for path in (ROOT / "hjsolve").glob("*/__init__.py")}
    assert rooms - {path.partition("/")[0] for path in PATH.findall(PAGE)} == WITHOUT_A_METHOD


def test_the_tour_meets_ten_nouns_in_files_that_define_them() -> None:
    tour = (ROOT / "docs/tour.md").read_text(encoding="utf-8")
    nouns = re.findall(r"^\| `(\w+)` \|.*`(hjsolve/[\w/]+\.py)` \|$", tour, flags=re.MULTILINE)
    assert len(nouns) == 10
    assert [noun for noun, path in nouns if f"\nclass {noun}" not in (ROOT / path).read_text(encoding="utf-8")] == []
