"""Sizes of files and functions, and constructs that have no place here. One test a rule; a failure lists who breaks it."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

import hjsolve
from hjsolve.errors import of_kind
from tests.support.sources import ROOT, tree_of

SOURCES = sorted((ROOT / "hjsolve").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
# the one place that runs a generated program: written from operation codes and numbers, see tests/ensembles/test_programs.py
WRITTEN_BY_US = {"hjsolve/ensembles/engine/programs.py": {"exec", "compile"}}


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of the body without the docstring."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return (body[-1].end_lineno or 0) - body[0].lineno + 1 if body else 0


def forbidden(tree: ast.Module, allowed: set[str]) -> Iterator[str]:
    """What must not stand in a file: star imports, eval and its like, excepts that catch everything."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and any(alias.name == "*" for alias in node.names):
            yield f"line {node.lineno}: star import"
        if isinstance(node, ast.Assert):
            yield f"line {node.lineno}: assert, which -O takes away; see `required` and `of_kind` in hjsolve.errors"
        if isinstance(node, ast.Call):
            called = node.func.id if isinstance(node.func, ast.Name) else ""
            if called in {"eval", "exec", "compile"} - allowed:
                yield f"line {node.lineno}: {called}"
            if isinstance(node.func, ast.Attribute) and node.func.attr == "parse_expr":
                yield f"line {node.lineno}: parse_expr evaluates text"
        if isinstance(node, ast.ExceptHandler):
            caught = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
            if any(c is None or (isinstance(c, ast.Name) and c.id.endswith("Exception")) for c in caught):
                yield f"line {node.lineno}: broad except; clean up in `finally`"


def test_the_sources_are_found() -> None:
    assert len(SOURCES) > 40


def test_files_have_at_most_500_lines() -> None:
    lines = {named(path): len(path.read_text(encoding="utf-8").splitlines()) for path in [*SOURCES, *TESTS]}
    assert not {path: count for path, count in lines.items() if count > 500}


@pytest.mark.nightly
def test_functions_have_at_most_60_lines() -> None:
    long = [
        (named(path), f.name, body_lines(f))
        for path in SOURCES
        for f in ast.walk(tree_of(path))
        if isinstance(f, FUNCTIONS) and body_lines(f) > 60
    ]
    assert not long


def test_no_star_import_no_eval_no_broad_except_no_assert() -> None:
    assert not [
        f"{named(path)}, {what}"
        for path in SOURCES
        for what in forbidden(tree_of(path), WRITTEN_BY_US.get(named(path), set()))
    ]


def hidden_imports(tree: ast.Module) -> list[int]:
    """Lines that import a module of ours by its name in a text, which no contract on imports sees."""
    return [
        node.lineno
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and "import_module" in ast.unparse(node.func) and node.args
        and isinstance(node.args[0], ast.Constant) and str(node.args[0].value).startswith("hjsolve")
    ]  # fmt: skip


def test_no_import_is_hidden_in_a_text() -> None:
    assert not {named(path): lines for path in SOURCES if (lines := hidden_imports(tree_of(path)))}
    assert hidden_imports(ast.parse('importlib.import_module("hjsolve.plots").plotted()')) == [1]


def test_an_invariant_holds_without_assertions() -> None:
    code = "from hjsolve.errors import of_kind, required; print(required(0), of_kind('', str)); required(None)"
    said = subprocess.run([sys.executable, "-O", "-c", code], capture_output=True, text=True, check=False, cwd=ROOT)
    assert said.stdout == "0 \n"
    assert "InternalError: a value is missing" in said.stderr
    with pytest.raises(hjsolve.InternalError, match="a str is needed here, not int"):
        of_kind(3, str)


def test_the_rule_against_eval_sees_what_it_forbids() -> None:
    text = "from os import *\neval('1')\nsympy.parse_expr('x')\ntry:\n    pass\nexcept (ValueError, Exception):\n    pass\nassert 1\n"
    said = list(forbidden(ast.parse(text), set()))
    assert [what.split(":")[0] for what in sorted(said)] == ["line 1", "line 2", "line 3", "line 6", "line 8"]


def without_a_noun(tree: ast.Module) -> list[str]:
    """Constants of a module that name an amount, but not of what."""
    targets = [target for node in tree.body if isinstance(node, ast.Assign) for target in node.targets]
    return [
        name.id
        for target in targets
        for name in ast.walk(target)
        if isinstance(name, ast.Name) and name.id.lstrip("_") in {"MOST", "STEPS", "HALVINGS", "SAFETY"}
    ]


def test_constants_say_of_what_they_are() -> None:
    assert not {named(path): names for path in SOURCES if (names := without_a_noun(tree_of(path)))}
    assert without_a_noun(ast.parse("_MOST, _FEW = 3, 1\nMOST_NODES = 4")) == ["_MOST"]


@pytest.mark.nightly
def test_median_body_is_short() -> None:
    sizes = sorted(body_lines(f) for path in SOURCES for f in ast.walk(tree_of(path)) if isinstance(f, FUNCTIONS))
    assert sizes[len(sizes) // 2] <= 8


def test_no_machine_path_stands_in_the_code() -> None:
    assert not [named(path) for path in SOURCES if re.search(r"/(tmp|home|root|work)/", path.read_text("utf-8"))]


def used_twice(trees: dict[str, ast.Module]) -> dict[str, list[str]]:
    """Public classes, also those inside classes, by name, where more than one bears it."""
    homes = defaultdict(list)
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                homes[node.name].append(path)
    return {name: paths for name, paths in homes.items() if len(paths) > 1}


def test_the_name_of_a_public_class_is_used_once_in_the_package() -> None:
    assert not used_twice({named(path): tree_of(path) for path in SOURCES})


def test_a_second_class_of_the_same_name_is_found() -> None:
    trees = {
        "a.py": ast.parse("class Torus: ...\nclass _Own: ..."),
        "b.py": ast.parse("class Torus: ...\nclass _Own: ..."),
    }
    assert used_twice(trees) == {"Torus": ["a.py", "b.py"]}


NAMED_LIKE_THEIR_VERB = {
    "main", "closed_forms", "energy_momentum_map", "surface_of_section", "chart_map", "charted_starts",
    "node_maps",
}  # fmt: skip
"""Files named after a public verb, and some of the ensembles; their rooms export no function of these names."""


def test_a_file_does_not_bear_the_name_of_its_function() -> None:
    """Else ``room.name`` is the file or the function by the order of imports."""
    same = {
        path.stem for path in SOURCES
        if any(isinstance(f, FUNCTIONS) and f.name == path.stem for f in tree_of(path).body)
    }  # fmt: skip
    assert same <= NAMED_LIKE_THEIR_VERB
