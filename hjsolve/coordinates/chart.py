"""Separated coordinates of a system given in others: what was found, as a value.

    x = origin + frame · X(u),     T = m/2 Σ h_k²(u) u̇_k²

u are the separated coordinates, X those of the web in its own frame, x the user's; on a sphere x is the unit vector of
the user's angles (``charts.outer_map``), and X(u) that of the web's. ``simplest_chart`` finds it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp

from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.charts.outer_map import OuterMap
from hjsolve.coordinates.results import Vector
from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import System
from hjsolve.separation import Separation


@dataclass(frozen=True, repr=False)
class Chart(Shown):
    """Separated coordinates of a system given in others; motions are started and expressed in the user's own.

    Attributes:
        kind: as in ``Geometry.kind``, or ``normal modes``.
        coordinates: names of the separated coordinates.
        transformation: the user's coordinate → expression in the separated ones.
        remark: what the reader should know: which coordinates are the same point, what was taken to be positive.
        reason: why these coordinates.
        original: the user's system.
        system: the system in the separated coordinates.
        separation: the certificate of that system.
        origin: of x = origin + frame · X(u).
        frame: of x = origin + frame · X(u).
        symbols: u, the separated coordinates.
        place: X(u).
        scale: h_k²(u) of T = m/2 Σ h_k² u̇_k², without differences that cancel.
        mass: m.
        lengths: named constants of X(u).
        outer: how x is tied to the user's coordinates: the identity, two angles on a sphere, or polar, cylindrical or
            spherical coordinates.
        independent: number of independent integrals quadratic in the momenta, energy included, that were found; more
            than coordinates: frequencies obey relations with whole numbers (``superintegrable.py``). 0: not counted.
        linear: a(u) of the terms Σ aₖ u̇ₖ of T in u; empty where there are none.
        gauge: Λ(u); ∫ p·dq of the user's p is that of p_u and the growth of Λ.
    """

    kind: str
    coordinates: tuple[str, ...]
    transformation: Mapping[str, sp.Expr]
    remark: str
    reason: str
    original: System
    system: System = field(repr=False)
    separation: Separation = field(repr=False)
    origin: Vector = field(repr=False)
    frame: sp.ImmutableMatrix = field(repr=False)
    symbols: tuple[sp.Symbol, ...] = field(repr=False)
    place: Vector = field(repr=False)
    scale: Vector = field(repr=False)
    mass: sp.Expr = field(repr=False)
    lengths: Mapping[str, sp.Expr] = field(repr=False)
    outer: OuterMap = field(repr=False)
    independent: int = 0
    linear: Vector = field(default=(), repr=False)
    gauge: sp.Expr = sp.S.Zero

    @property
    def space(self) -> System:
        """The user's system in Cartesian coordinates; itself where it is given in these, or on a sphere."""
        return self.outer.space if isinstance(self.outer, CurvilinearMap) else self.original
