"""What every web that ``find_coordinates`` gives must satisfy, checked by numbers of 40 digits."""

from __future__ import annotations

import random
from collections.abc import Iterable

import mpmath
import sympy as sp

from hjsolve import System
from hjsolve.coordinates.results import Web

PLANE = {"x": "line", "y": "line"}
SPACE = {"x": "line", "y": "line", "z": "line"}
KINETIC = {2: "(dot(x)**2 + dot(y)**2)/2", 3: "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"}


def particle(n: int, potential: str | sp.Expr, parameters: dict[str, object] | None = None) -> System:
    """A particle of mass one in the plane or in space."""
    return System(PLANE if n == 2 else SPACE, KINETIC[n], potential, parameters or {})


def place(web: Web, seed: int, values: dict[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """A rational point of the domain of a web."""
    chance = random.Random(seed)
    point: dict[sp.Symbol, sp.Expr] = {}
    for q in web.system.coordinates:
        fraction = sp.Rational(chance.randint(11, 89), 100)
        low, high = (None if end is None else end.xreplace(values) for end in (q.domain.lower, q.domain.upper))
        if low is not None and high is not None:
            point[q.symbol] = low + (high - low) * fraction
        elif low is not None:
            point[q.symbol] = low + 2 * fraction
        else:
            point[q.symbol] = 2 * fraction if high is None else high - 2 * fraction
    return point


def same_motion(original: System, web: Web, seed: int = 5) -> None:
    """T and V of the transformed system are those of the original one in the new coordinates."""
    values = {
        p.symbol: p.value if p.value is not None else sp.Integer(i + 2) for i, p in enumerate(original.parameters)
    }
    point = place(web, seed, values)
    speeds = {q.velocity: sp.Rational(3 + 2 * i, 7) for i, q in enumerate(web.system.coordinates)}
    old = {}
    for q in original.coordinates:
        x = web.transformation[q.name]
        old[q.symbol] = x.xreplace(values).xreplace(point).evalf(60)
        slope = sum(sp.diff(x, u.symbol) * speeds[u.velocity] for u in web.system.coordinates)
        old[q.velocity] = sp.sympify(slope).xreplace(values).xreplace(point).evalf(60)
    for mine, its in ((original.kinetic, web.system.kinetic), (original.potential, web.system.potential)):
        expected = mine.xreplace(values).xreplace(old).evalf(50)
        found = its.xreplace(values).xreplace(point).xreplace(speeds).evalf(50)
        assert found.is_real, (web.kind, found)
        assert abs(mpmath.mpf(str(expected - found))) <= mpmath.mpf(10) ** -38 * max(
            1, abs(mpmath.mpf(str(expected)))
        ), web.kind


def points(vectors: Iterable[Iterable[object]]) -> set[tuple[sp.Expr, ...]]:
    """Exact points as a set, to compare without an order."""
    return {tuple(sp.nsimplify(c) if isinstance(c, float) else sp.sympify(c) for c in v) for v in vectors}


def along(axis: Iterable[sp.Expr], direction: Iterable[object]) -> bool:
    """Whether two vectors are parallel."""
    return bool(sp.Matrix([list(axis), [sp.sympify(c) for c in direction]]).rank(simplify=True) == 1)
