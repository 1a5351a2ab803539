"""How often the code says ``Any``: the counts may fall, and are then lowered here; they do not grow."""

from __future__ import annotations

import ast

import pytest

from tests.support.sources import ROOT, tree_of

MOST = {"ensembles": (150, 30), "elsewhere": (250, 24)}
"""Part of the package → uses of ``Any``, and functions that return it.

What has a type of its own is in ``arithmetic/number_types.py``: arrays, numbers of many digits, what is told at times.
"""


def uses(tree: ast.Module) -> int:
    return sum(isinstance(node, ast.Name) and node.id == "Any" for node in ast.walk(tree))


def returning(tree: ast.Module) -> int:
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
    return sum(isinstance(f.returns, ast.Name) and f.returns.id == "Any" for f in functions)


def trees(part: str) -> list[ast.Module]:
    files = sorted((ROOT / "hjsolve").rglob("*.py"))
    own = ROOT / "hjsolve" / "ensembles"
    inside = [path for path in files if (own in path.parents) == (part == "ensembles")]
    return [tree_of(path) for path in inside]


@pytest.mark.nightly_cases("elsewhere")
@pytest.mark.parametrize("part", MOST)
def test_any_is_not_said_more_often(part: str) -> None:
    found = trees(part)
    assert sum(map(uses, found)) <= MOST[part][0]
    assert sum(map(returning, found)) <= MOST[part][1]


def test_the_counts_see_what_they_count() -> None:
    tree = ast.parse("def f(x: Any, y: list[Any]) -> Any: ...\ndef g() -> dict[str, Any]: ...\nz: int = 1")
    assert (uses(tree), returning(tree)) == (4, 1)
