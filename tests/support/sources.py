"""The files of the package and their syntax trees, parsed once a process for all tests of the code itself."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@cache
def tree_of(path: Path) -> ast.Module:
    """What a file says; no test may change it."""
    return ast.parse(path.read_text(encoding="utf-8"))
