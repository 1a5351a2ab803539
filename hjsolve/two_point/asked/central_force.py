"""Which systems are a central force, and which a Kepler problem: T = m/2 |ẋ|² and V(|x|) in the usual coordinates.

polar (r, θ), spherical (r, θ, φ), Cartesian (x, y) or (x, y, z), by whatever names
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations

import sympy as sp

from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.system import System

RADIUS = sp.Symbol("r", positive=True)
"""The distance from the centre in ``CentralForce.potential``."""


@dataclass(frozen=True)
class CentralForce:
    """A mass in a potential that depends on the distance from a centre alone.

    Attributes:
        kind: ``polar``, ``spherical`` or ``cartesian``.
        names: coordinates in the order r, θ, φ or x, y, z.
        mass: m.
        potential: V of ``RADIUS``.
    """

    kind: str
    names: tuple[str, ...]
    mass: sp.Expr
    potential: sp.Expr


@dataclass(frozen=True)
class Attraction(CentralForce):
    """A Kepler problem.

    Attributes:
        strength: k of V = −k/r, which may be of either sign where it is a parameter.
    """

    strength: sp.Expr


@lru_cache(maxsize=64)
def attraction_of(system: System) -> Attraction | None:
    """Recognise a Kepler problem; None where the system is not one, or not in these coordinates.

    Args:
        system: as the user gave it.
    """
    force = central_force_of(system)
    if force is None:
        return None
    strength = sp.simplify(-force.potential * RADIUS)
    if strength == 0 or strength.has(RADIUS):
        return None
    return Attraction(force.kind, force.names, force.mass, force.potential, strength)


@lru_cache(maxsize=64)
def central_force_of(system: System) -> CentralForce | None:
    """Recognise a central force; None where the system is not one, or not in these coordinates.

    Args:
        system: as the user gave it.
    """
    if system.relativity is not None or system.kinks or system.functions or len(system.coordinates) not in (2, 3):
        return None
    for order in permutations(system.coordinates):
        for kind in ("cartesian", "polar" if len(order) == 2 else "spherical"):
            found = _of_kind(system, kind, order)
            if found is not None:
                return found
    return None


def _of_kind(system: System, kind: str, order: tuple[Coordinate, ...]) -> CentralForce | None:
    first = order[0]
    mass = sp.diff(system.kinetic, first.velocity, 2)
    letters = {c.symbol for c in order}
    if mass == 0 or mass.free_symbols & letters:
        return None
    if kind == "cartesian":
        factors: list[sp.Expr] = [sp.S.One] * len(order)
    else:
        radius = first.symbol
        factors = [sp.S.One, radius**2, radius**2 * sp.sin(order[1].symbol) ** 2][: len(order)]
        if any(c.domain.kind != "angle" for c in (order[-1],)) or not radius.is_positive:
            return None
    kinetic = sp.Add(*(mass / 2 * f * c.velocity**2 for f, c in zip(factors, order, strict=True)))
    if sp.expand(system.kinetic - kinetic) != 0:
        return None
    # V along the first axis, which must be V everywhere
    potential = system.potential.xreplace({first.symbol: RADIUS})
    if kind == "cartesian":
        potential = sp.simplify(potential.xreplace({c.symbol: sp.S.Zero for c in order[1:]}))
        distance = sp.sqrt(sp.Add(*(c.symbol**2 for c in order)))
        if sp.simplify(potential.xreplace({RADIUS: distance}) - system.potential) != 0:
            return None
    if potential.free_symbols & (letters - {RADIUS}):
        return None
    return CentralForce(kind, tuple(c.name for c in order), mass, potential)
