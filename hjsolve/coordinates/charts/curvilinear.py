"""Systems given in polar, cylindrical or spherical coordinates, recognised by T, and the same systems in x, y, z.

    polar        x = r (cos φ, sin φ),                               h = 1, r
    cylindrical  x = (R cos φ, R sin φ, z),                          h = 1, R, 1
    spherical    x = r (sin θ cos φ, sin θ sin φ, cos θ),            h = 1, r, r sin θ    (or a latitude)

T = m/2 Σ h² q̇². Back from x and ẋ, with ρ² = x² + y², r² = ρ² + z²:

    ρ̇ = (x ẋ + y ẏ)/ρ,   φ̇ = (x ẏ − y ẋ)/ρ²,   ṙ = x·ẋ/r,   θ̇ = (z ρ̇ − ρ ż)/r²
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import permutations
from typing import ClassVar

import sympy as sp

from hjsolve.coordinates.charts.outer_map import (
    AZIMUTH,
    COLATITUDE,
    FROM_AXIS,
    FROM_CENTRE,
    HEIGHT,
    LATITUDE,
    OuterMap,
    Rates,
)
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import System, kinetic_rest, linear_terms, mass_matrix

_CIRCULAR = (sp.tan, sp.cot, sp.sec, sp.csc)


@dataclass(frozen=True)
class CurvilinearMap(OuterMap):
    """How points of the plane or of space are tied to polar, cylindrical or spherical coordinates.

    Attributes:
        roles: what each of the user's coordinates is.
        scales: h of each, with T = m/2 Σ h² q̇².
        mass: m.
        space: the same system in x, y, z.
        sense: as of ``SphereMap``; heights are those of z.
    """

    sense: ClassVar[int] = 1
    roles: tuple[str, ...]
    scales: tuple[sp.Expr, ...]
    mass: sp.Expr
    space: System

    def rates(self, x: Sequence[sp.Expr], speed: Sequence[sp.Expr]) -> Rates:
        """Return q̇ and p of a point and its velocity; on the axis that of R and φ count as zero."""
        square, spin = x[0] ** 2 + x[1] ** 2, x[0] * speed[1] - x[1] * speed[0]
        ρ, outward = sp.sqrt(square), x[0] * speed[0] + x[1] * speed[1]
        on_axis = square == 0
        out = sp.S.Zero if on_axis else outward / ρ
        found = {AZIMUTH: (sp.S.Zero if on_axis else spin / square, spin), FROM_AXIS: (out, out)}
        if len(x) == 3:
            r2 = square + x[2] ** 2
            r = sp.sqrt(r2)
            along = (outward + x[2] * speed[2]) / r
            turn = x[2] * out - ρ * speed[2]
            found |= {
                HEIGHT: (speed[2], speed[2]), FROM_CENTRE: (along, along),
                COLATITUDE: (turn / r2, turn), LATITUDE: (-turn / r2, -turn),
            }  # fmt: skip
        pairs = [found[role] for role in self.roles]
        return [rate for rate, _ in pairs], [self.mass * p for _, p in pairs]

    def in_given_coordinates(self, x: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
        """Return the user's coordinates of a point, as formulas."""
        square = x[0] ** 2 + x[1] ** 2
        found = {AZIMUTH: sp.atan2(x[1], x[0]), FROM_AXIS: _root(square)}
        if len(x) == 3:
            ρ = _root(square)
            found |= {
                HEIGHT: x[2], FROM_CENTRE: _root(square + x[2] ** 2),
                COLATITUDE: sp.atan2(ρ, x[2]), LATITUDE: sp.atan2(x[2], ρ),
            }  # fmt: skip
        return tuple(found[role] for role in self.roles)


def _root(square: sp.Expr) -> sp.Expr:
    return sp.sqrt(sp.factor(sp.trigsimp(sp.expand(square))))


@cache
def curvilinear_map(system: System) -> CurvilinearMap | None:
    """Return how a system given in polar, cylindrical or spherical coordinates is tied to x, y, z.

    Returns:
        The map; None where T is not that of a particle in such coordinates with their whole domain.

    Raises:
        InvalidSystemError: T is, but V holds an angle otherwise than in sines and cosines.
    """
    n = len(system.coordinates)
    if n not in (2, 3) or any(linear_terms(system)) or kinetic_rest(system) != 0 or system.relativity is not None:
        return None
    M = mass_matrix(system)
    if not M.is_diagonal() or all(not M[i, i].free_symbols & set(_symbols(system)) for i in range(n)):
        return None
    for order in permutations(range(n)):
        for roles in _layouts(n):
            assigned = dict(zip(roles, order, strict=True))
            if _fits(system, M, assigned):
                return _map(system, M, assigned)
    return None


def _symbols(system: System) -> list[sp.Symbol]:
    return [c.symbol for c in system.coordinates]


def _layouts(n: int) -> list[tuple[str, ...]]:
    if n == 2:
        return [(FROM_AXIS, AZIMUTH)]
    return [(FROM_AXIS, AZIMUTH, HEIGHT), (FROM_CENTRE, COLATITUDE, AZIMUTH), (FROM_CENTRE, LATITUDE, AZIMUTH)]


def _fits(system: System, M: sp.MatrixBase, assigned: Mapping[str, int]) -> bool:
    domains = {role: system.coordinates[i].domain for role, i in assigned.items()}
    radius = next(domains[role] for role in (FROM_AXIS, FROM_CENTRE) if role in domains)
    ends = {
        AZIMUTH: domains[AZIMUTH].kind == "angle",
        HEIGHT: HEIGHT not in domains or domains[HEIGHT].kind == "line",
        COLATITUDE: COLATITUDE not in domains or _ends(domains[COLATITUDE]) == (0, sp.pi),
        LATITUDE: LATITUDE not in domains or _ends(domains[LATITUDE]) == (-sp.pi / 2, sp.pi / 2),
    }
    if not all(ends.values()) or _ends(radius) != (0, None):
        return False
    scales, mass = _scales(system, assigned), M[(i := _radial(assigned)), i]
    return not mass.free_symbols & set(_symbols(system)) and all(
        sp.simplify(M[k, k] - mass * h**2) == 0 for k, h in enumerate(scales)
    )


def _ends(domain: object) -> tuple[object, object]:
    return getattr(domain, "lower", None), getattr(domain, "upper", None)


def _radial(assigned: Mapping[str, int]) -> int:
    return assigned[FROM_AXIS] if FROM_AXIS in assigned else assigned[FROM_CENTRE]


def _scales(system: System, assigned: Mapping[str, int]) -> list[sp.Expr]:
    q = {role: system.coordinates[i].symbol for role, i in assigned.items()}
    r = q.get(FROM_AXIS, q.get(FROM_CENTRE))
    ρ = r * sp.sin(q[COLATITUDE]) if COLATITUDE in q else r * sp.cos(q[LATITUDE]) if LATITUDE in q else r
    scale = {FROM_AXIS: sp.S.One, FROM_CENTRE: sp.S.One, HEIGHT: sp.S.One, COLATITUDE: r, LATITUDE: r, AZIMUTH: ρ}
    return [scale[role] for role, _ in sorted(assigned.items(), key=lambda item: item[1])]


def _map(system: System, M: sp.MatrixBase, assigned: Mapping[str, int]) -> CurvilinearMap:
    roles = tuple(role for role, _ in sorted(assigned.items(), key=lambda item: item[1]))
    q = {role: system.coordinates[i].symbol for role, i in assigned.items()}
    scales = _scales(system, assigned)
    ρ, r = scales[assigned[AZIMUTH]], q.get(FROM_CENTRE)
    place = [ρ * sp.cos(q[AZIMUTH]), ρ * sp.sin(q[AZIMUTH])]
    if r is not None:
        place.append(r * (sp.cos(q[COLATITUDE]) if COLATITUDE in q else sp.sin(q[LATITUDE])))
    elif HEIGHT in q:
        place.append(q[HEIGHT])
    mass = M[(i := _radial(assigned)), i]
    J = sp.Matrix(place).jacobian(_symbols(system))
    p = sp.Matrix([c.momentum / h**2 for c, h in zip(system.coordinates, scales, strict=True)])
    momentum = tuple((J * p).applyfunc(sp.expand))
    return CurvilinearMap(tuple(place), momentum, M, roles, tuple(scales), mass, _in_space(system, q, mass, len(place)))


def _in_space(system: System, q: Mapping[str, sp.Symbol], mass: sp.Expr, n: int) -> System:
    """Return the same system in x, y, z."""
    old = {s: sp.Dummy(s.name, real=True) for s in q.values()}
    q = {role: old[s] for role, s in q.items()}
    taken = {p.name for p in system.parameters}
    names = [name if name not in taken else next(f"{name}_{k}" for k in range(1, 99)) for name in "xyz"[:n]]
    X = sp.symbols(names, real=True)
    square = sp.Add(*(x**2 for x in X[:2]))
    ρ, r = sp.sqrt(square), sp.sqrt(square + X[2] ** 2) if n == 3 else sp.sqrt(square)
    rules: dict[sp.Expr, sp.Expr] = {sp.cos(q[AZIMUTH]): X[0] / ρ, sp.sin(q[AZIMUTH]): X[1] / ρ}
    if COLATITUDE in q:
        rules |= {sp.cos(q[COLATITUDE]): X[2] / r, sp.sin(q[COLATITUDE]): ρ / r}
    if LATITUDE in q:
        rules |= {sp.sin(q[LATITUDE]): X[2] / r, sp.cos(q[LATITUDE]): ρ / r}
    lengths = {FROM_AXIS: ρ, FROM_CENTRE: r, HEIGHT: X[-1]}
    angles = [q[role] for role in (AZIMUTH, COLATITUDE, LATITUDE) if role in q]
    V = _short_angles(system.potential.xreplace(old), angles)
    V = V.xreplace(rules).subs({q[role]: e for role, e in lengths.items() if role in q}, simultaneous=True)
    left = V.free_symbols & set(q.values())
    if left:
        raise InvalidSystemError(
            f"find_coordinates: V holds {', '.join(sorted(s.name for s in left))} otherwise than in sines and cosines; "
            "write it so, or the system in x, y, z"
        )
    speeds = [sp.Symbol(f"dot({name})", real=True) for name in names]
    kinetic = mass / 2 * sp.Add(*(v**2 for v in speeds))
    return System(dict.fromkeys(names, "line"), kinetic, V, {p.name: p for p in system.parameters}, title=system.title)


def _short_angles(V: sp.Expr, angles: Sequence[sp.Symbol]) -> sp.Expr:
    """Write functions of multiples of the angles, and of their sums with constants, by sines and cosines of each."""

    def of_angle(f: sp.Basic) -> bool:
        return isinstance(f, (sp.sin, sp.cos, *_CIRCULAR)) and bool(f.free_symbols & set(angles))

    return V.replace(of_angle, lambda f: sp.expand_trig(f.rewrite(sp.cos, sp.sin) if isinstance(f, _CIRCULAR) else f))


def scale_factors(system: System) -> tuple[sp.Expr, ...] | None:
    """Return h of T = m/2 Σ h² q̇², lengths per unit of each coordinate; None where T does not determine them.

    Args:
        system: in polar, cylindrical, spherical or Cartesian coordinates.
    """
    curved = curvilinear_map(system)
    if curved is not None:
        return curved.scales
    M = mass_matrix(system)
    if (
        M.is_diagonal()
        and len({M[i, i] for i in range(M.rows)}) == 1
        and not M[0, 0].free_symbols & set(_symbols(system))
    ):
        return (sp.S.One,) * M.rows
    return None
