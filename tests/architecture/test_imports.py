"""Imports point one way, no room escapes the contract, and nothing lies loose next to the rooms."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LOOSE = {"__init__", "__main__", "_version", "arguments", "errors", "jax", "lowering", "precision"}


def rooms() -> set[str]:
    return {path.parent.name for path in (ROOT / "hjsolve").glob("*/__init__.py")}


def contracts() -> list[dict[str, list[str]]]:
    configuration = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return list(configuration["tool"]["importlinter"]["contracts"])


def test_import_contracts_hold() -> None:
    code = "import sys; from importlinter.cli import lint_imports_command; sys.argv = ['lint-imports']; lint_imports_command()"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stdout[-3000:] + run.stderr[-2000:]
    assert "0 broken" in run.stdout


def test_nothing_lies_loose_beside_the_rooms() -> None:
    assert {path.stem for path in (ROOT / "hjsolve").glob("*.py")} == LOOSE


def test_every_room_has_a_floor() -> None:
    named = {name for floor in contracts()[0]["layers"] for name in floor.replace("|", " ").split()}
    assert named == rooms() | LOOSE - {"__init__"}


def test_every_room_of_exact_formulas_is_under_the_contract_that_forbids_numpy() -> None:
    """The floors under the arithmetic are symbolic; those that compute are above it, or forbid sympy."""
    floors, symbolic, numeric = contracts()
    below = floors["layers"][floors["layers"].index("arithmetic") + 1 :]
    exact = {f"hjsolve.{name}" for floor in below for name in floor.replace("|", " ").split()} - {
        f"hjsolve.{name}" for name in LOOSE
    }
    assert exact == set(symbolic["source_modules"])
    assert not exact & set(numeric["source_modules"])


def test_every_room_says_what_it_is_for() -> None:
    """Three to six lines: what goes in, what comes out, which file to read first."""
    for room in sorted(rooms()):
        text = (ROOT / "hjsolve" / room / "__init__.py").read_text(encoding="utf-8").split('"""')[1].strip()
        assert 3 <= len(text.splitlines()) <= 7, room
        assert "In:" in text, room
        assert "Out:" in text, room
        assert "first" in text, room


def test_every_room_has_its_tests() -> None:
    assert rooms() <= {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")}
