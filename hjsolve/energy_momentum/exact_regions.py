"""Where a coordinate can move with given constants, and how, decided by the exact search for turning points.

This is what a motion of these constants would find (``one_coordinate.classify``), without its integrals: for single
points, for those that doubles leave in doubt, and for coordinates whose P² no variable makes a polynomial.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import sympy as sp

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import required
from hjsolve.motion.separated import start_at
from hjsolve.one_coordinate.allowed_regions import AllowedRegion, every_region
from hjsolve.one_coordinate.classify import locate
from hjsolve.one_coordinate.coordinate_start import CoordinateStart
from hjsolve.one_coordinate.turning_points import End
from hjsolve.solution.quadratures import Solution

_SHIFTS = (0, "1/97", "-3/89", "17/83")


class KindOfRegion(NamedTuple):
    """One interval on which a coordinate can move.

    Attributes:
        kind: of the motions in it, a word of ``Motion.kinds``.
        low, high: its ends; None where there is none on that side.
    """

    kind: str
    low: float | None
    high: float | None


def regions_with_kinds(
    solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], place: sp.Expr
) -> tuple[KindOfRegion, ...]:
    """Find every interval on which P² ≥ 0, in order of q, with the kind of its motions.

    Args:
        values: symbol → exact number, of every constant and parameter.
        place: where the search begins, inside the domain.

    Raises:
        NotConvergedError: P² could not be decided somewhere.
    """
    for shift in _SHIFTS:
        start = at_place(solution, name, values, place + sp.Rational(shift) * (1 + abs(place)) * _room(solution, name))
        if start.radicand.value(start.place(256), 256) != 0:
            break
    return tuple(
        KindOfRegion(_kind(start, region), _number(region.lower), _number(region.upper))
        for region in every_region(start, 15)
    )


def _room(solution: Solution, name: str) -> sp.Expr:
    """Return how far a place may be shifted: less where the domain has ends."""
    domain = solution.system.coordinate(name).domain
    return sp.S.One if domain.lower is None and domain.upper is None else sp.Rational(1, 64)


def at_place(solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], place: sp.Expr) -> CoordinateStart:
    """Begin at a place of a coordinate, on its way up.

    Args:
        values: symbol → exact number, of every constant and parameter.
        place: exact.
    """
    start = start_at(solution, name, solution.momentum_squared[name], values, place)
    return replace(start, parts=frozenset[str]())


def _kind(start: CoordinateStart, region: AllowedRegion) -> str:
    """Return the kind of the motions in a region.

    Between turning points without more ado, else as a motion would find it.
    """
    lower, upper = region
    if lower.kind == upper.kind == "round":
        return "rotation"
    if lower.kind == upper.kind == "turning":
        return "libration"
    if lower.place is not None and upper.place is not None and lower.place(256) == upper.place(256):
        return "equilibrium"
    return str(locate(replace(start, place=partial(_inside, lower, upper, start)), 15).course.kind)


def _inside(lower: End, upper: End, start: CoordinateStart, bits: int) -> Mpf:
    """Return a place in a region, at any precision."""
    ends = [None if end.place is None else end.place(bits) for end in (lower, upper)]
    a, b = ends
    if a is not None and b is not None:
        return (a + b) / 2
    if a is None and b is None:
        return start.place(bits)
    end = required(a if a is not None else b)
    step = 1 + abs(end)
    return end + step if b is None else end - step


def _number(end: End) -> float | None:
    return None if end.place is None else float(end.place(64))
