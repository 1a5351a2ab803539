"""What a user can import says what it takes, what it gives and when it fails."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import re
from pathlib import Path

import pytest

import hjsolve
from tests.support.sources import tree_of

CALLABLES = [
    name
    for name in hjsolve.__all__
    if callable(getattr(hjsolve, name))
    and not (inspect.isclass(getattr(hjsolve, name)) and issubclass(getattr(hjsolve, name), Exception))
]
FUNCTIONS = [name for name in CALLABLES if inspect.isfunction(getattr(hjsolve, name))]
VALUES = [name for name in CALLABLES if inspect.isclass(getattr(hjsolve, name))]


@pytest.mark.parametrize("name", sorted(hjsolve.__all__))
def test_every_public_name_has_a_docstring(name: str) -> None:
    if name != "__version__":
        assert (inspect.getdoc(getattr(hjsolve, name)) or "").strip()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_tell_arguments_returns_and_errors(name: str) -> None:
    text = inspect.getdoc(getattr(hjsolve, name)) or ""
    parameters = list(inspect.signature(getattr(hjsolve, name)).parameters)
    for heading in (["Args:"] if parameters else []) + ["Returns:", "Raises:"]:
        assert heading in text, f"{name} lacks {heading}"
    for parameter in parameters:
        assert parameter in text, f"{name} does not tell about {parameter}"


@pytest.mark.parametrize("name", VALUES)
def test_values_tell_their_fields(name: str) -> None:
    value = getattr(hjsolve, name)
    text = inspect.getdoc(value) or ""
    for field in getattr(value, "__dataclass_fields__", {}):
        if not field.startswith("_"):
            assert field in text, f"{name} does not tell about {field}"


PACKAGE = Path(hjsolve.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
QUOTED = re.compile(r"``((?:[a-z_]\w*\.)+)(\w+)``")
VALUES_TOO = {"catalog", "motion", "orbits", "solution", "turning_points"}
"""Names of files that are also names of what a user holds or of columns of a table: ``solution.motion``.

In a file itself its name is that of a value.
"""


def places(name: str) -> list[Path]:
    """Files and rooms of this name."""
    return [
        path.parent if path.name == "__init__.py" else path for path in SOURCES if name in (path.stem, path.parent.name)
    ]


def defined(path: Path, name: str) -> bool:
    """Whether a file or room has something of this name at its top, or a file of this name in it."""
    if path.is_dir():
        return (path / name).is_dir() or (path / f"{name}.py").exists() or defined(path / "__init__.py", name)
    found: set[str] = set()
    for node in tree_of(path).body:
        match node:
            case ast.FunctionDef() | ast.ClassDef():
                found.add(node.name)
            case ast.Assign() | ast.AnnAssign():
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                found.update(target.id for target in targets if isinstance(target, ast.Name))
            case ast.ImportFrom():
                found.update(alias.asname or alias.name for alias in node.names)
    return name in found


def leads_nowhere(path: Path, stem: str, name: str) -> bool:
    """Whether ``stem.name``, quoted in a file, is about a file that has no such name, or about a file that is not."""
    *rooms, head = stem.rstrip(".").split(".")
    if name == "py":
        return not list(path.parent.rglob(f"{head}.py"))
    if rooms[:1] == ["hjsolve"] or head == "hjsolve":
        try:
            pkgutil.resolve_name(f"{stem}{name}")
        except (ImportError, AttributeError):
            return True
        return False
    if head in VALUES_TOO or head == path.stem:
        return False
    return bool(places(head)) and not any(defined(place, name) for place in places(head))


@pytest.mark.parametrize(
    ("stem", "name", "is_false"),
    [
        ("one_coordinate.", "resolution", False),
        ("one_coordinate.", "surely_not_there", True),
        ("midpoint_rule.", "dot", False),
        ("midpoint_rule.", "surely_not_there", True),
        ("hjsolve.solution.laws.", "check", False),
        ("hjsolve.solution.laws.", "surely_not_there", True),
        ("surely_not_there.", "py", True),
    ],
)
def test_the_search_for_false_references_finds_them(stem: str, name: str, is_false: bool) -> None:
    assert leads_nowhere(PACKAGE / "lowering.py", stem, name) == is_false


def test_what_docstrings_refer_to_is_there() -> None:
    """A file that was renamed leaves its old name in the docstrings of others."""
    false = [
        f"{path.relative_to(PACKAGE.parent)}: ``{found[1]}{found[2]}``"
        for path in SOURCES
        for found in QUOTED.finditer(path.read_text(encoding="utf-8"))
        if leads_nowhere(path, found[1], found[2])
    ]
    assert not false, "\n".join(false)
