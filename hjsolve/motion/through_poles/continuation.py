"""Ends of domains that are ends of the coordinates only: decided by the form of T and V.

Where M_φφ = M_θθ (θ − e)² + … vanishes at θ = e, the metric near e is that of a plane in polar coordinates, and θ < e
with φ is the place 2e − θ with φ + π. If V and the other coefficients of T are even about e and finite there, nothing
happens to a motion that passes e: with p_φ = 0 it stays in the plane of φ and φ + π, and is one of the system without
φ in which θ runs on. Polar and spherical coordinates at r = 0 and at the axis, spheroidal and rotational parabolic
ones at theirs, and surfaces of revolution at their poles are all of this kind.

Where T ties φ to other velocities (a spinning black hole drags φ along), or holds it linearly (a magnetic field), φ
moves though p_φ = 0, and is not left out: with

    H′ = H − ½ (gᵠᵠ − 1) p_φ²

in place of H nothing is infinite at the pole, every equation of motion is the same where p_φ = 0, and the conditions of
separability hold as before, since the coefficient of p_φ² is a constant now.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from hjsolve.errors import required
from hjsolve.mechanics.kinetic_energy import inverse_of_mass_matrix
from hjsolve.mechanics.system import Coordinate, System, kinetic_rest, linear_terms, mass_matrix
from hjsolve.separation import Zero, is_zero

_SECONDS = 3.0
_INFINITE = (sp.zoo, sp.nan, sp.oo, -sp.oo)


@dataclass(frozen=True)
class Reflection:
    """Where a continued coordinate turns back into the given one: its poles, None where an end is none."""

    lower: sp.Expr | None
    upper: sp.Expr | None


@dataclass(frozen=True)
class Continuation:
    """A system with an angle whose momentum is zero, its coordinates continued through their poles.

    Attributes:
        system: in which they run on.
        angle: whose momentum is zero; it jumps by π at the poles.
        reflections: coordinate continued → its poles.
        carried: whether the angle moves all the same, and is a coordinate of ``system``; else it is left out there.
    """

    system: System
    angle: str
    reflections: Mapping[str, Reflection]
    carried: bool = False


@lru_cache(maxsize=128)
def continued_coordinates(system: System, angle: str) -> Continuation | None:
    """Continue the coordinates of a system through the poles of an angle.

    Args:
        system: in which the angle is ignorable.
        angle: its name.

    Returns:
        The continued system; None where no coordinate has a pole of this angle that is of the coordinates only.
    """
    φ = system.coordinate(angle)
    rest = [c for c in system.coordinates if c.name != angle]
    if φ.domain.kind != "angle" or not rest or system.relativity is not None:
        return None
    # beyond a pole r and θ have either sign: what was assumed of them must not simplify roots
    real = {c.symbol: sp.Symbol(c.name, real=True) for c in system.coordinates}
    M, index = mass_matrix(system).xreplace(real), {c.name: k for k, c in enumerate(system.coordinates)}
    A = sp.ImmutableMatrix([a.xreplace(real) for a in linear_terms(system)])
    V = (system.potential - kinetic_rest(system)).xreplace(real)
    k = index[angle]
    if (M.free_symbols | A.free_symbols | V.free_symbols) & {real[φ.symbol]}:
        return None
    reflections = {}
    for c in rest:
        parts = _Parts(M, A, V, k, index[c.name], real[c.symbol])
        poles = [end is not None and parts.has_pole(end) for end in (c.domain.lower, c.domain.upper)]
        if any(poles):
            reflections[c.name] = Reflection(c.domain.lower if poles[0] else None, c.domain.upper if poles[1] else None)
    # a field, or a term with another velocity, drags φ along although p_φ = 0: then it stays a coordinate
    carried = any(a != 0 for a in A) or any(M[k, j] != 0 for j in range(M.rows) if j != k)
    domains = {c.name: _domain(c, reflections.get(c.name)) for c in (system.coordinates if carried else rest)}
    if not reflections or None in domains.values():
        return None
    kinetic, potential = system.kinetic.xreplace({φ.velocity: sp.S.Zero} | real), system.potential.xreplace(real)
    if carried:
        kinetic, potential = _regular(M, A, V, k, [c.velocity for c in system.coordinates])
    coupled = any(M[k, j] != 0 for j in range(M.rows) if j != k)
    continued = System(
        {name: domain for name, domain in domains.items() if domain is not None},
        kinetic, potential, {p.name: p for p in system.parameters}, title=system.title,
        signature="indefinite" if coupled else system.signature,
    )  # fmt: skip
    return Continuation(continued, angle, reflections, carried)


def _regular(
    M: sp.ImmutableMatrix, A: sp.ImmutableMatrix, V: sp.Expr, k: int, velocities: Sequence[sp.Symbol]
) -> tuple[sp.Expr, sp.Expr]:
    """T and V of H′, with 1 in place of gᵠᵠ: H = ½ (p − A)ᵀ G (p − A) + V is expanded in p and composed again."""
    G = inverse_of_mass_matrix(M)
    slope, rest = -(G * A), V + (A.T * G * A)[0, 0] / 2
    metric = sp.Matrix(G)
    # p_φ = 0 leaves nothing of ½ gᵠᵠ p_φ², which is infinite at the pole: any other number may stand there
    metric[k, k] = sp.S.One
    mass = inverse_of_mass_matrix(sp.ImmutableMatrix(metric))
    linear, v = -(mass * slope), sp.ImmutableMatrix(velocities)
    return (v.T * mass * v)[0, 0] / 2 + (linear.T * v)[0, 0], rest - (linear.T * metric * linear)[0, 0] / 2


@dataclass(frozen=True)
class _Parts:
    """T = ½ q̇ᵀM q̇ + A·q̇ and V as seen from one coordinate: φ is number k, the coordinate number i with the symbol θ."""

    M: sp.MatrixBase
    A: sp.MatrixBase
    V: sp.Expr
    k: int
    i: int
    θ: sp.Symbol

    def has_pole(self, end: sp.Expr) -> bool:
        """Return whether an end is one of the coordinates only."""
        G, own = self.M[self.k, self.k], self.M[self.i, self.i]
        if self.A[self.i] != 0 or any(self.M[self.i, j] != 0 for j in range(self.M.rows) if j != self.i):
            return False
        if any(e.has(*_INFINITE) for e in self._values(end)):
            return False
        if not all(self._vanishes(self._at(f, end)) for f in (*self.M.row(self.k), self.A[self.k])):
            return False
        # ds² = m(dθ² + (θ − end)² dφ²) + …: polar coordinates about a regular place, no cone
        bend = self._at(sp.diff(G, self.θ, 2), end) / 2
        return self._vanishes(bend - self._at(own, end)) and all(
            self._vanishes(f - f.xreplace({self.θ: 2 * end - self.θ})) for f in (*self.M, *self.A, self.V)
        )

    def _at(self, f: sp.Expr, end: sp.Expr) -> sp.Expr:
        return f.subs(self.θ, end)

    def _values(self, end: sp.Expr) -> list[sp.Expr]:
        return [self._at(f, end) for f in (*self.M, *self.A, self.V)]

    def _vanishes(self, f: sp.Expr) -> bool:
        return bool(f == 0 or (not f.has(*_INFINITE) and isinstance(is_zero(f, budget=_SECONDS), Zero)))


def _domain(c: Coordinate, reflection: Reflection | None) -> str | None:
    """Return the domain of a coordinate after it is continued.

    None where it has two poles that are not half a turn apart.
    """
    if reflection is None:
        return c.domain.written(c.name)
    low, high = c.domain.lower, c.domain.upper
    if reflection.lower is not None and reflection.upper is not None:
        return "angle" if sp.simplify(reflection.upper - reflection.lower - sp.pi) == 0 else None
    if reflection.lower is not None:
        return "line" if high is None else f"{sp.sstr(2 * reflection.lower - high)} < {c.name} < {sp.sstr(high)}"
    return "line" if low is None else f"{sp.sstr(low)} < {c.name} < {sp.sstr(2 * required(reflection.upper) - low)}"
