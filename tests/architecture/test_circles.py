"""No circle of imports between files, nor between rooms and sub-rooms: also none for types, and none inside functions."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import pytest

from tests.support.sources import ROOT, tree_of

UPWARD = {
    ("hjsolve.solution.quadratures", "hjsolve.motion.charted.begin"),
    ("hjsolve.solution.quadratures", "hjsolve.motion.motion"),
    ("hjsolve.solution.quadratures", "hjsolve.extended.explicit_time"),
    ("hjsolve.solution.quadratures", "hjsolve.two_point.ask"),
    ("hjsolve.solution.quadratures", "hjsolve.two_point.asked.answers"),
    ("hjsolve.solution.quadratures", "hjsolve.two_point.kepler.arrays"),
    ("hjsolve.solution.quadratures", "hjsolve.two_point.linear"),
    ("hjsolve.solution.quadratures", "hjsolve.resonances.question"),
    ("hjsolve.solution.quadratures", "hjsolve.resonances.found_tori"),
    ("hjsolve.solution.quadratures", "hjsolve.resonances.double_zeros"),
    ("hjsolve.mechanics.system", "hjsolve.coordinates.constraints"),
    ("hjsolve.motion.motion", "hjsolve.motion.in_units"),
}
"""``Solution.motion``, ``two_point``, ``torus`` and ``separatrices`` call up, and name what they give: solving loads no numerical library.

``solve`` calls up where T or V holds the time: a frame is looked for, in which the system is solved again.
``System(constraints=…)`` calls up: whether a constraint is integrable is for the zero test to prove.
``Motion.to_units`` calls up, and names what it gives: a motion without units needs none of it.
"""
Graph = Mapping[str, set[str]]


@cache
def files() -> dict[str, Path]:
    """Module → file."""
    found = {}
    for path in sorted((ROOT / "hjsolve").rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if path.stem == "__init__" else parts)] = path
    return found


@cache
def home(base: str, name: str) -> str | None:
    """The file that ``from base import name`` takes a name from: through the rooms' own re-exports."""
    if f"{base}.{name}" in files():
        return f"{base}.{name}"
    if base in files() and files()[base].stem == "__init__":
        for node in ast.walk(tree_of(files()[base])):
            if isinstance(node, ast.ImportFrom) and node.module and name in {a.asname or a.name for a in node.names}:
                return home(node.module, name)
    return base if base in files() else None


@cache
def imports() -> dict[str, set[str]]:
    """File → files it imports at any depth of the text, types included; ``__init__`` of a room left out."""
    graph: dict[str, set[str]] = {}
    for module, path in files().items():
        if path.stem != "__init__":
            taken = {
                home(node.module, alias.name)
                for node in ast.walk(tree_of(path))
                if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("hjsolve")
                for alias in node.names
            }
            graph[module] = {m for m in taken if m and m != module and files()[m].stem != "__init__"}
    return graph


def reached(graph: Graph, begin: str) -> set[str]:
    """All nodes that arrows lead to."""
    seen, left = set[str](), [begin]
    while left:
        for node in graph.get(left.pop(), set()) - seen:
            seen.add(node)
            left.append(node)
    return seen


def circles(graph: Graph) -> set[frozenset[str]]:
    """Sets of nodes that lead to each other."""
    far = {node: reached(graph, node) for node in graph}
    return {
        frozenset(other for other in far[node] if node in far.get(other, set())) for node in graph if node in far[node]
    }


def without(graph: Graph, arrows: Iterable[tuple[str, str]]) -> dict[str, set[str]]:
    """The graph less some arrows."""
    left_out = set(arrows)
    return {node: {other for other in taken if (node, other) not in left_out} for node, taken in graph.items()}


def room(module: str) -> str:
    """The room or sub-room of a file, or the file itself where it lies next to the rooms."""
    inner = module.split(".")[1:]
    return ".".join(inner[:-1] if len(inner) > 1 else inner)


def rooms(graph: Graph) -> dict[str, set[str]]:
    """Room or sub-room → those it imports from."""
    found: dict[str, set[str]] = {}
    for module, taken in graph.items():
        found.setdefault(room(module), set()).update({room(m) for m in taken} - {room(module)})
    return found


@pytest.mark.nightly
def test_no_circle_of_files() -> None:
    assert circles(without(imports(), UPWARD)) == set()


def test_no_circle_of_rooms_and_sub_rooms() -> None:
    assert circles(rooms(without(imports(), UPWARD))) == set()


def test_the_upward_calls_are_there() -> None:
    assert all(above in imports()[below] for below, above in UPWARD)


def test_a_circle_is_found() -> None:
    graph = {"a.x": {"b.y"}, "b.y": {"c.z"}, "c.z": {"b.y"}, "d": {"a.x"}}
    assert circles(graph) == {frozenset({"b.y", "c.z"})}
    assert circles(without(graph, [("c.z", "b.y")])) == set()
