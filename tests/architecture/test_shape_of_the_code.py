"""Sizes of files and functions, and constructs that have no place here."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "hjsolve").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
# the one place that runs a generated program: written from operation codes and numbers, see tests/ensembles/test_programs.py
WRITTEN_BY_US = {"ensembles/engine/programs.py": {"exec", "compile"}}
IDS = [str(path.relative_to(ROOT / "hjsolve")) for path in SOURCES]


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of the body without the docstring."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return (body[-1].end_lineno or 0) - body[0].lineno + 1 if body else 0


def test_the_sources_are_found() -> None:
    assert len(SOURCES) > 40


@pytest.mark.parametrize("path", [*SOURCES, *TESTS], ids=lambda path: str(path.relative_to(ROOT)))
def test_files_have_at_most_400_lines(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400


@pytest.mark.parametrize("path", SOURCES, ids=IDS)
def test_functions_have_at_most_60_lines(path: Path) -> None:
    long = [(f.name, body_lines(f)) for f in ast.walk(tree_of(path)) if isinstance(f, FUNCTIONS) and body_lines(f) > 60]
    assert not long


@pytest.mark.parametrize("path", SOURCES, ids=IDS)
def test_no_star_import_no_eval_no_broad_except(path: Path) -> None:
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ImportFrom):
            assert all(alias.name != "*" for alias in node.names), f"line {node.lineno}: star import"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            allowed = WRITTEN_BY_US.get(str(path.relative_to(ROOT / "hjsolve")), set())
            banned = {"eval", "exec", "compile"} - allowed
            assert node.func.id not in banned, f"line {node.lineno}: {node.func.id}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            assert node.func.attr != "parse_expr", f"line {node.lineno}: {node.func.attr} evaluates text"
        if isinstance(node, ast.ExceptHandler):
            caught = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
            broad = [c for c in caught if c is None or (isinstance(c, ast.Name) and c.id.endswith("Exception"))]
            assert not broad, f"line {node.lineno}: broad except; clean up in `finally`"


def test_median_body_is_short() -> None:
    sizes = sorted(body_lines(f) for path in SOURCES for f in ast.walk(tree_of(path)) if isinstance(f, FUNCTIONS))
    assert sizes[len(sizes) // 2] <= 8


@pytest.mark.parametrize("path", SOURCES, ids=IDS)
def test_no_machine_path_stands_in_the_code(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"/(tmp|home|root|work)/", text)
