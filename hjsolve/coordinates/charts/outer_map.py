"""From points of space to the user's coordinates: the identity in flat space, two angles on a sphere.

    flat      x = q,                                    m ẋ = p − a(q),  a of terms linear in the velocities
    sphere    n = (ρ cos φ, ρ sin φ, Z), ρ² + Z² = 1,   m ṅ = m J M⁻¹ p,    J = ∂n/∂q, M = m JᵀJ

and back, with nothing that cancels next to a pole: u = atan2(ρ, ±Z) or atan2(±Z, ρ), φ = atan2(Y, X),

    u̇ = ∓Ż/ρ or ±Ż/ρ,    φ̇ = (X Ẏ − Y Ẋ)/ρ²,    p_u = m u̇,    p_φ = m (X Ẏ − Y Ẋ).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import sympy as sp

from hjsolve.coordinates.webs.web import Vector
from hjsolve.mechanics.system import System, linear_terms, mass_matrix

AZIMUTH, HEIGHT, COLATITUDE, LATITUDE = "azimuth", "height", "colatitude", "latitude"
FROM_AXIS, FROM_CENTRE = "radius from the axis", "radius from the centre"
Rates = tuple[list[sp.Expr], list[sp.Expr]]
"""q̇ and p."""


@dataclass(frozen=True)
class OuterMap:
    """How points x are tied to the user's coordinates q: here x = q.

    Attributes:
        place: x(q).
        momentum: m ẋ in q and p.
        masses: the mass matrix M(q), p = M q̇ + a(q).
        linear: a(q) of T₁ = aᵀq̇; empty where T has no such terms.
    """

    place: Vector
    momentum: Vector
    masses: sp.ImmutableMatrix
    linear: Vector = field(default=(), kw_only=True)

    def rates(self, x: Sequence[sp.Expr], speed: Sequence[sp.Expr]) -> Rates:
        """Return q̇ and p of a point and its velocity."""
        at = dict(zip(self.place, x, strict=True))
        a = [e.xreplace(at) for e in self.linear] or [sp.S.Zero] * len(speed)
        rows = zip(self.masses.tolist(), a, strict=True)
        return list(speed), [sp.Add(own, *(m * v for m, v in zip(row, speed, strict=True))) for row, own in rows]


@dataclass(frozen=True)
class SphereMap(OuterMap):
    """How points of the unit sphere are tied to a colatitude or latitude u and an azimuth φ.

    Attributes:
        meridian: index of u; φ is the other one.
        latitude: whether sin u = ±Z, else cos u = ±Z.
        sense: that sign.
        mass: m of T = m/2 ṅ·ṅ.
    """

    meridian: int
    latitude: bool
    sense: int
    mass: sp.Expr

    @property
    def roles(self) -> tuple[str, ...]:
        """What each of the user's coordinates is."""
        pair = (LATITUDE if self.latitude else COLATITUDE, AZIMUTH)
        return pair if self.meridian == 0 else pair[::-1]

    def rates(self, x: Sequence[sp.Expr], speed: Sequence[sp.Expr]) -> Rates:
        """Return q̇ and p of a point and its velocity."""
        square, spin = x[0] ** 2 + x[1] ** 2, x[0] * speed[1] - x[1] * speed[0]
        along = (self.sense if self.latitude else -self.sense) * speed[2] / sp.sqrt(square)
        q, p = [along, spin / square], [self.mass * along, self.mass * spin]
        return (q, p) if self.meridian == 0 else (q[::-1], p[::-1])


def flat_map(system: System) -> OuterMap:
    """Return the map of a system in Cartesian coordinates.

    Args:
        system: with a constant mass matrix.
    """
    q, a = system.coordinates, linear_terms(system)
    momentum = tuple(c.momentum - e for c, e in zip(q, a, strict=True))
    return OuterMap(
        tuple(c.symbol for c in q), momentum, mass_matrix(system), linear=tuple(a) if any(e != 0 for e in a) else ()
    )


def sphere_map(system: System, mass: sp.Expr, normal: Vector) -> SphereMap | None:
    """Return the map of a system on a sphere; None where its coordinates are no latitude and azimuth, or end early.

    Args:
        system: of two coordinates.
        mass: m of T = m/2 ṅ·ṅ.
        normal: n(q), about the third axis.
    """
    for k in (0, 1):
        u, φ = system.coordinates[k], system.coordinates[1 - k]
        forms = {f * s: (f == sp.sin(u.symbol), s) for f in (sp.cos(u.symbol), sp.sin(u.symbol)) for s in (1, -1)}
        if normal[2] not in forms or φ.domain.kind != "angle":
            continue
        latitude, sense = forms[normal[2]]
        ends = (-sp.pi / 2, sp.pi / 2) if latitude else (sp.S.Zero, sp.pi)
        ρ = sp.cos(u.symbol) if latitude else sp.sin(u.symbol)
        round_about = (ρ * sp.cos(φ.symbol), ρ * sp.sin(φ.symbol))
        if (u.domain.lower, u.domain.upper) != ends or tuple(normal[:2]) != round_about:
            continue
        M = mass_matrix(system)
        J = sp.Matrix(normal).jacobian([c.symbol for c in system.coordinates])
        p = [c.momentum / sp.simplify(M[i, i] / mass) for i, c in enumerate(system.coordinates)]
        return SphereMap(tuple(normal), tuple(J * sp.Matrix(p)), M, k, latitude, sense, mass)
    return None
