"""The table of tools in docs/theorem.md: each Python name, option, report section and page that it names exists."""

from __future__ import annotations

import argparse
import re
from functools import reduce
from pathlib import Path

import pytest

import hjsolve
from hjsolve.command_line.parser import command_parser

ROOT = Path(__file__).resolve().parents[2]
SECTIONS = "\n".join(path.read_text() for path in (ROOT / "hjsolve" / "reports" / "sections").glob("*.py"))


def _rows() -> list[list[str]]:
    text = (ROOT / "docs" / "theorem.md").read_text().split("## Where each tool is")[1].split("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith("|")][2:]
    return [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines]


def _options(command: str) -> set[str]:
    parser = command_parser()
    kinds = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    return {name for action in kinds.choices[command]._actions for name in action.option_strings}


def test_no_tool_is_left_out() -> None:
    names = {row[1].split(".")[-1] for row in _rows()}
    wanted = "verify two_point change_coordinates poisson_bracket canonical System impact gyroscopic_modes solve"
    assert {*wanted.split(), "from_hamiltonian", "constraint_forces", "contact"} <= names


@pytest.mark.parametrize("row", _rows(), ids=lambda row: row[0])
def test_what_a_row_names_exists(row: list[str]) -> None:
    _, python, command, section, page = row
    assert callable(reduce(getattr, python.split(".")[1:], hjsolve))
    if command != "–":
        name, *options = command.split()[1:]
        assert {*options} <= _options(name)
    if section != "–":
        assert re.search(rf'Section\(\s*"{section}"', SECTIONS)
    before, _, after = (ROOT / "docs" / page).read_text().partition("## Where each tool is")
    told = before + after.partition("\n## ")[2]  # the table itself is no page of a tool
    assert python.split(".")[-1] in told
