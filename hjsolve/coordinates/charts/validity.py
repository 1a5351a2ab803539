"""Where the potential written in new coordinates is the potential: a root or a logarithm has one sign on each side.

``simplify_potential`` writes √sinh²μ as sinh μ and acos(cos ν) as ν, which is right for μ > 0 and 0 < ν < π. Whether it
is on the other sides too is looked up at a point of each: it is, where V is analytic through the plane between them; or
V has a crease there, and the coordinates end at it.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import sympy as sp

from hjsolve.coordinates.charts.transform import Cartesian
from hjsolve.coordinates.webs.web import Web
from hjsolve.mechanics.system import Coordinate, System

_DIGITS = 30
_OFFSETS = (sp.Rational(37, 101), sp.Rational(53, 97), sp.Rational(41, 89))
"""Where in its range each coordinate is looked at."""
_PAIRED = ("elliptic", "elliptic cylinder", "parabolic", "parabolic cylinder", "oblate spheroidal")
"""Kinds in which (u, v) and (−u, −v), or (−u, π − v), are one point: half of the range of one of them is enough."""

Point = tuple[sp.Expr, ...]


def valid_everywhere(web: Web, cartesian: Cartesian) -> System | None:
    """Return the system of a web with ranges of the coordinates in which its potential is the one given.

    Args:
        web: a web with its transformed system.
        cartesian: the system as given.

    Returns:
        The system, where needed with a coordinate that ends at a crease of V; None where no such ranges are known.
    """
    system = web.system
    sides = [_sides(c, shift, cartesian.values) for c, shift in zip(system.coordinates, _OFFSETS, strict=False)]
    wrong = [point for point in product(*sides) if not _agree(web, cartesian, point)]
    if not wrong:
        return system
    if web.kind not in _PAIRED:
        return None
    for k in (1, 0):
        if all(point[k] < 0 for point in wrong):
            return _ended(system, k, angle=system.coordinates[k].domain.kind == "angle")
    return None


def _sides(c: Coordinate, shift: sp.Rational, values: Mapping[sp.Symbol, sp.Expr]) -> Point:
    """One point on each side of the planes that a coordinate may have for edges of its domain's parts."""
    low, high = (None if end is None else end.xreplace(dict(values)) for end in (c.domain.lower, c.domain.upper))
    if c.domain.kind == "angle":
        quarter = shift * sp.Rational(3, 2)
        return quarter, quarter - 3, 3 - quarter, -quarter
    if low is None and high is None:
        return shift, -shift
    if low is not None and high is not None:
        return low + shift * (high - low), high - shift * (high - low) / 2
    return (low + shift, low + 5 * shift) if low is not None else (high - shift, high - 5 * shift)


def _agree(web: Web, cartesian: Cartesian, point: Point) -> bool:
    """Return whether V of the web is V as given at one point, parameters at the values that decide signs."""
    at = {c.symbol: x for c, x in zip(web.system.coordinates, point, strict=True)} | dict(cartesian.values)
    place = {
        c.symbol: web.transformation[c.name].xreplace(at).evalf(_DIGITS + 10) for c in cartesian.system.coordinates
    }
    given = cartesian.system.potential.xreplace({**cartesian.values, **place}).evalf(_DIGITS + 5)
    ours = web.system.potential.xreplace(at).evalf(_DIGITS + 5)
    if given.has(sp.nan, sp.zoo, sp.oo) or ours.has(sp.nan, sp.zoo, sp.oo):
        return False
    return bool(abs(given - ours) <= sp.Float(10) ** -(_DIGITS - 8) * (1 + abs(given)))


def _ended(system: System, k: int, *, angle: bool) -> System:
    """Return the system with coordinate k positive, and smaller than π where it was an angle."""
    name = system.coordinates[k].name
    domains = {c.name: c.domain.written(c.name) for c in system.coordinates}
    domains[name] = f"0 < {name} < pi" if angle else f"0 < {name}"
    return System(domains, system.kinetic, system.potential, {p.name: p for p in system.parameters}, title=system.title)
