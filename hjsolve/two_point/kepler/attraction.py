"""Which systems are a Kepler problem: T = m/2 |ẋ|² and V = −k/|x| in the plane or in space, in usual coordinates.

polar (r, θ), spherical (r, θ, φ), Cartesian (x, y) or (x, y, z), by whatever names
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations

import sympy as sp

from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.system import System


@dataclass(frozen=True)
class Attraction:
    """A Kepler problem.

    Attributes:
        kind: ``polar``, ``spherical`` or ``cartesian``.
        names: coordinates in the order r, θ, φ or x, y, z.
        mass: m.
        strength: k of V = −k/r, which may be of either sign where it is a parameter.
    """

    kind: str
    names: tuple[str, ...]
    mass: sp.Expr
    strength: sp.Expr


@lru_cache(maxsize=64)
def attraction_of(system: System) -> Attraction | None:
    """Recognise a Kepler problem; None where the system is not one, or not in these coordinates.

    Args:
        system: as the user gave it.
    """
    if system.relativity is not None or system.kinks or system.functions or len(system.coordinates) not in (2, 3):
        return None
    for order in permutations(system.coordinates):
        kinds = ["cartesian", "polar" if len(order) == 2 else "spherical"]
        for kind in kinds:
            found = _of_kind(system, kind, order)
            if found is not None:
                return found
    return None


def _of_kind(system: System, kind: str, order: tuple[Coordinate, ...]) -> Attraction | None:
    first = order[0]
    mass = sp.diff(system.kinetic, first.velocity, 2)
    if mass == 0 or mass.free_symbols & {c.symbol for c in order}:
        return None
    if kind == "cartesian":
        factors: list[sp.Expr] = [sp.S.One] * len(order)
        radius = sp.sqrt(sp.Add(*(c.symbol**2 for c in order)))
    else:
        radius = first.symbol
        factors = [sp.S.One, radius**2, radius**2 * sp.sin(order[1].symbol) ** 2][: len(order)]
        if any(c.domain.kind != "angle" for c in (order[-1],)) or not radius.is_positive:
            return None
    kinetic = sp.Add(*(mass / 2 * f * c.velocity**2 for f, c in zip(factors, order, strict=True)))
    if sp.expand(system.kinetic - kinetic) != 0:
        return None
    strength = sp.simplify(-system.potential * radius)
    if strength == 0 or strength.free_symbols & {c.symbol for c in order}:
        return None
    return Attraction(kind, tuple(c.name for c in order), mass, strength)
