"""Ends of domains that are ends of the coordinates only: decided by the form of T and V.

Where M_φφ = M_θθ (θ − e)² + … vanishes at θ = e, the metric near e is that of a plane in polar coordinates, and θ < e
with φ is the place 2e − θ with φ + π. If V and the other coefficients of T are even about e and finite there, nothing
happens to a motion that passes e: with p_φ = 0 it stays in the plane of φ and φ + π, and is one of the system without
φ in which θ runs on. Polar and spherical coordinates at r = 0 and at the axis, spheroidal and rotational parabolic
ones at theirs, and surfaces of revolution at their poles are all of this kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from hjsolve.mechanics.system import Coordinate, System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.separation import Zero, is_zero

_SECONDS = 3.0
_INFINITE = (sp.zoo, sp.nan, sp.oo, -sp.oo)


@dataclass(frozen=True)
class Fold:
    """Where a continued coordinate turns back into the given one: its poles, None where an end is none."""

    lower: sp.Expr | None
    upper: sp.Expr | None


@dataclass(frozen=True)
class Continuation:
    """A system without an angle whose momentum is zero, its coordinates continued through their poles.

    Attributes:
        system: in which they run on.
        dropped: the angle left out.
        folds: coordinate continued → its poles.
    """

    system: System
    dropped: str
    folds: Mapping[str, Fold]


@lru_cache(maxsize=128)
def continued_coordinates(system: System, dropped: str) -> Continuation | None:
    """Continue the coordinates of a system through the poles of an angle.

    Args:
        system: in which the angle is ignorable.
        dropped: name of the angle.

    Returns:
        The continued system; None where no coordinate has a pole of this angle that is of the coordinates only.
    """
    φ = system.coordinate(dropped)
    rest = [c for c in system.coordinates if c.name != dropped]
    if φ.domain.kind != "angle" or not rest or system.relativity is not None or system.signature != "definite":
        return None
    real = {c.symbol: sp.Symbol(c.name, real=True) for c in system.coordinates}
    M, index = mass_matrix(system).xreplace(real), {c.name: k for k, c in enumerate(system.coordinates)}
    V = (system.potential - kinetic_rest(system)).xreplace(real)
    k = index[dropped]
    if any(a != 0 for a in linear_terms(system)) or any(M[k, j] != 0 for j in range(M.rows) if j != k):
        return None
    if (M.free_symbols | V.free_symbols) & {real[φ.symbol]}:
        return None
    folds = {}
    for c in rest:
        parts = _Parts(M, V, k, index[c.name], real[c.symbol])
        poles = [end is not None and parts.has_pole(end) for end in (c.domain.lower, c.domain.upper)]
        if any(poles):
            folds[c.name] = Fold(c.domain.lower if poles[0] else None, c.domain.upper if poles[1] else None)
    domains = {c.name: _domain(c, folds.get(c.name)) for c in rest}
    if not folds or None in domains.values():
        return None
    kinetic = system.kinetic.xreplace({φ.velocity: sp.S.Zero}).xreplace(real)
    continued = System(
        {name: domain for name, domain in domains.items() if domain is not None},
        kinetic, system.potential.xreplace(real), {p.name: p for p in system.parameters}, title=system.title,
    )  # fmt: skip
    return Continuation(continued, dropped, folds)


@dataclass(frozen=True)
class _Parts:
    """T and V as seen from one coordinate: φ is number k, the coordinate number i with the symbol θ."""

    M: sp.MatrixBase
    V: sp.Expr
    k: int
    i: int
    θ: sp.Symbol

    def has_pole(self, end: sp.Expr) -> bool:
        """Whether an end is one of the coordinates only."""
        G, own = self.M[self.k, self.k], self.M[self.i, self.i]
        if any(self.M[self.i, j] != 0 for j in range(self.M.rows) if j != self.i):
            return False
        if not self._vanishes(self._at(G, end)) or any(e.has(*_INFINITE) for e in self._values(end)):
            return False
        bend = self._at(sp.diff(G, self.θ, 2), end) / 2
        return self._vanishes(bend - self._at(own, end)) and all(
            self._vanishes(f - f.xreplace({self.θ: 2 * end - self.θ})) for f in (*self.M, self.V)
        )

    def _at(self, f: sp.Expr, end: sp.Expr) -> sp.Expr:
        return f.subs(self.θ, end)

    def _values(self, end: sp.Expr) -> list[sp.Expr]:
        return [self._at(f, end) for f in (*self.M, self.V)]

    def _vanishes(self, f: sp.Expr) -> bool:
        return bool(f == 0 or (not f.has(*_INFINITE) and isinstance(is_zero(f, budget=_SECONDS), Zero)))


def _domain(c: Coordinate, fold: Fold | None) -> str | None:
    """The domain of a coordinate after it is continued; None where it has two poles that are not half a turn apart."""
    if fold is None:
        return c.domain.written(c.name)
    low, high = c.domain.lower, c.domain.upper
    if fold.lower is not None and fold.upper is not None:
        return "angle" if sp.simplify(fold.upper - fold.lower - sp.pi) == 0 else None
    if fold.lower is not None:
        return "line" if high is None else f"{sp.sstr(2 * fold.lower - high)} < {c.name} < {sp.sstr(high)}"
    assert fold.upper is not None
    return "line" if low is None else f"{sp.sstr(low)} < {c.name} < {sp.sstr(2 * fold.upper - low)}"
