"""Whose precision a number is computed with: never that of ``mpmath.mp``, which belongs to the user and to every thread."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import hjsolve

PACKAGE = Path(hjsolve.__file__).parent
TYPES = {"mpf", "mpc", "matrix"}
"""What annotations may name."""
EXACT = {"libmp", "frexp", "ldexp"}
"""What knows no precision."""
HOME = "precision.py"


def uses_of_the_global_context(tree: ast.AST) -> Iterator[str]:
    """Every use of mpmath's global context in a module: a function of it, or one of its types that is called or asked for.

    Args:
        tree: the module.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "") == "mpmath":
            yield from (
                f"{node.lineno}: from mpmath import {name.name}" for name in node.names if name.name not in EXACT
            )
        if isinstance(node, ast.Call):
            named = [node.func, *node.args, *(part for a in node.args if isinstance(a, ast.Tuple) for part in a.elts)]
            yield from (f"{node.lineno}: {ast.unparse(node)}" for part in named if _of_mpmath(part))
        if isinstance(node, ast.Attribute) and _of_mpmath(node.value) and node.attr not in TYPES:
            yield f"{node.lineno}: {ast.unparse(node)}"


def _of_mpmath(node: ast.AST) -> bool:
    names = [node.value, node] if isinstance(node, ast.Attribute) else [node]
    return any(isinstance(name, ast.Name) and name.id == "mpmath" for name in names)


@pytest.mark.parametrize("text", [
    "mpmath.sqrt(2)", "mpmath.mp.dps = 50", "with mpmath.workdps(30): pass", "from mpmath import mp", "x = mpmath.mpf(2)",
    "isinstance(x, mpmath.mpf)", "isinstance(x, (int, mpmath.mpc))", "getattr(mpmath, name)", "f = mpmath.pi",
])  # fmt: skip
def test_every_use_is_seen(text: str) -> None:
    assert list(uses_of_the_global_context(ast.parse(text)))


def test_a_type_in_an_annotation_is_no_use() -> None:
    assert not list(uses_of_the_global_context(ast.parse("def f(x: mpmath.mpf) -> list[mpmath.mpc]: pass")))


def test_no_module_computes_in_the_global_context_of_mpmath() -> None:
    texts = {path.relative_to(PACKAGE).as_posix(): path.read_text() for path in sorted(PACKAGE.rglob("*.py"))}
    asked = {name: text for name, text in texts.items() if "mpmath" in text and name != HOME}
    found = {name: uses for name, text in asked.items() if (uses := list(uses_of_the_global_context(ast.parse(text))))}
    assert not found
