"""The orthogonal coordinates of the plane and of space with names, and the integrals that belong to them.

Every entry is h_i² up to one common constant factor, or one factor for each group of coordinates, and quadratic
integrals of the free motion as coefficients of p_i². Angular momenta are about the origin of the chart; the axis of the
chart is its z axis (x in the plane). In a meaning, {0} and {1} stand for the names of the first two coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

Expressions = tuple[sp.Expr, ...]
L, L_Z, A, L1, L2 = sp.symbols("L L_z A L_1 L_2", real=True)
P_X, P_Y, P_Z = sp.symbols("p_x p_y p_z", real=True)


@dataclass(frozen=True)
class Integral:
    """A known quadratic integral of the free motion.

    Attributes:
        symbol: how it is written.
        meaning: what it is.
        coefficients: of p_i², as functions of the chart's coordinates.
        attracted: the function that a centre of force −k/r at the origin adds to it, up to a factor; None if none.
        with_centre: what it is called then.
    """

    symbol: sp.Expr
    meaning: str
    coefficients: Callable[..., Expressions]
    attracted: Callable[..., sp.Expr] | None = None
    with_centre: str = ""


@dataclass(frozen=True)
class KnownChart:
    """Coordinates with a name.

    Attributes:
        name: what they are called.
        squares: h_i² up to a common factor.
        integrals: what is known to be conserved in free motion, and diagonal in these coordinates.
        free: the coordinates, by place, whose h_i² have a factor of their own.
    """

    name: str
    squares: Callable[..., Expressions]
    integrals: tuple[Integral, ...]
    free: frozenset[int] = frozenset()


def _parabolic(u: sp.Expr, v: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    return -(v**2) / (2 * (u**2 + v**2)), u**2 / (2 * (u**2 + v**2))


def _confocal(u: sp.Expr, v: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    below = sp.sinh(u) ** 2 + sp.sin(v) ** 2
    return -(sp.sin(v) ** 2) / below, sp.sinh(u) ** 2 / below


def _flat(u: sp.Expr, v: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    below = sp.cosh(u) ** 2 - sp.sin(v) ** 2
    return sp.sin(v) ** 2 / below, sp.cosh(u) ** 2 / below


def _confocal_algebraic(ξ: sp.Expr, η: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    product = (ξ**2 - 1) * (1 - η**2) / (ξ**2 - η**2)
    return -product, product


def _squared(ξ: sp.Expr, η: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """``_parabolic`` with ξ = u², η = v²: p_u² = 4ξ p_ξ²."""
    return -2 * ξ * η / (ξ + η), 2 * ξ * η / (ξ + η)


def _along_squared(ξ: sp.Expr, η: sp.Expr, *_: sp.Expr) -> sp.Expr:
    return (ξ - η) / (ξ + η)


def _along(u: sp.Expr, v: sp.Expr, *_: sp.Expr) -> sp.Expr:
    return (u**2 - v**2) / (u**2 + v**2)


_FOCI = "L_1 and L_2 the angular momenta about the foci: the constant of the problem of two centres"
_RUNGE_LENZ = "A the component of p x L along the axis with the coordinate ({0}**2 - {1}**2)/2"
_KEPLER = "A the component of the Runge-Lenz vector along the axis with the coordinate ({0}**2 - {1}**2)/2"
_RUNGE_LENZ_2 = "A the component of p x L along the axis with the coordinate ({0} - {1})/2"
_KEPLER_2 = "A the component of the Runge-Lenz vector along the axis with the coordinate ({0} - {1})/2"
_TOTAL = "L the total angular momentum"
_AXIAL = "L_z the angular momentum about the axis"

CHARTS = (
    KnownChart(
        "polar",
        lambda r, θ: (sp.S.One, r**2),
        (Integral(L**2, "L the angular momentum", lambda r, θ: (sp.S.Zero, sp.S.One)),),
    ),
    KnownChart("parabolic", lambda u, v: (u**2 + v**2,) * 2, (Integral(A, _RUNGE_LENZ, _parabolic, _along, _KEPLER),)),
    KnownChart(
        "elliptic", lambda u, v: (sp.sinh(u) ** 2 + sp.sin(v) ** 2,) * 2, (Integral(L1 * L2, _FOCI, _confocal),)
    ),
    KnownChart(
        "circular cylinder",
        lambda r, θ, z: (sp.S.One, r**2, sp.S.One),
        (Integral(L_Z**2, _AXIAL, lambda r, θ, z: (sp.S.Zero, sp.S.One, sp.S.Zero)),),
    ),
    KnownChart(
        "spherical",
        lambda r, θ, φ: (sp.S.One, r**2, r**2 * sp.sin(θ) ** 2),
        (
            Integral(L_Z**2, _AXIAL, lambda r, θ, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(L**2, _TOTAL, lambda r, θ, φ: (sp.S.Zero, sp.S.One, sp.sin(θ) ** -2)),
        ),
    ),
    KnownChart(
        "spherical, with latitude",
        lambda r, θ, φ: (sp.S.One, r**2, r**2 * sp.cos(θ) ** 2),
        (
            Integral(L_Z**2, _AXIAL, lambda r, θ, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(L**2, _TOTAL, lambda r, θ, φ: (sp.S.Zero, sp.S.One, sp.cos(θ) ** -2)),
        ),
    ),
    KnownChart(
        "rotational parabolic",
        lambda u, v, φ: (u**2 + v**2, u**2 + v**2, u**2 * v**2),
        (
            Integral(L_Z**2, _AXIAL, lambda u, v, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(
                A, _RUNGE_LENZ, lambda u, v, φ: (*_parabolic(u, v), (u**2 - v**2) / (2 * u**2 * v**2)), _along, _KEPLER
            ),
        ),
    ),
    KnownChart(
        "prolate spheroidal",
        lambda u, v, φ: (*((sp.sinh(u) ** 2 + sp.sin(v) ** 2,) * 2), sp.sinh(u) ** 2 * sp.sin(v) ** 2),
        (
            Integral(L_Z**2, _AXIAL, lambda u, v, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(
                L1 * L2,
                _FOCI,
                lambda u, v, φ: (
                    *_confocal(u, v),
                    1 + ((sp.cosh(u) * sp.cos(v)) ** 2 - 1) / (sp.sinh(u) * sp.sin(v)) ** 2,
                ),
            ),
        ),
    ),
    KnownChart(
        "oblate spheroidal",
        lambda u, v, φ: (*((sp.cosh(u) ** 2 - sp.sin(v) ** 2,) * 2), sp.cosh(u) ** 2 * sp.sin(v) ** 2),
        (
            Integral(L_Z**2, _AXIAL, lambda u, v, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(
                L**2 + sp.Symbol("a") ** 2 * (P_X**2 + P_Y**2),
                "L the total angular momentum and a the radius of the focal circle",
                lambda u, v, φ: (*_flat(u, v), 1 + ((sp.sinh(u) * sp.cos(v)) ** 2 + 1) / (sp.cosh(u) * sp.sin(v)) ** 2),
            ),
        ),
    ),
    KnownChart(
        "parabolic cylinder",
        lambda u, v, z: (u**2 + v**2, u**2 + v**2, sp.S.One),
        (
            Integral(
                P_Y * L_Z,
                "L_z and p_y as in the plane across the axis, where x = ({0}**2 - {1}**2)/2",
                lambda u, v, z: (*_parabolic(u, v), sp.S.Zero),
            ),
        ),
    ),
    KnownChart(
        "elliptic cylinder",
        lambda u, v, z: (*((sp.sinh(u) ** 2 + sp.sin(v) ** 2,) * 2), sp.S.One),
        (
            Integral(
                L1 * L2,
                "L_1 and L_2 the angular momenta about the focal lines",
                lambda u, v, z: (*_confocal(u, v), sp.S.Zero),
            ),
        ),
        frozenset({2}),
    ),
    KnownChart(
        "elliptic, x = a ξ η",
        lambda ξ, η: ((ξ**2 - η**2) / (ξ**2 - 1), (ξ**2 - η**2) / (1 - η**2)),
        (Integral(L1 * L2, _FOCI, _confocal_algebraic),),
    ),
    KnownChart(
        "prolate spheroidal, z = a ξ η",
        lambda ξ, η, φ: ((ξ**2 - η**2) / (ξ**2 - 1), (ξ**2 - η**2) / (1 - η**2), (ξ**2 - 1) * (1 - η**2)),
        (
            Integral(L_Z**2, _AXIAL, lambda ξ, η, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(
                L1 * L2,
                _FOCI,
                lambda ξ, η, φ: (*_confocal_algebraic(ξ, η), 1 + ((ξ * η) ** 2 - 1) / ((ξ**2 - 1) * (1 - η**2))),
            ),
        ),
    ),
    KnownChart(
        "parabolic, x = (ξ - η)/2",
        lambda ξ, η: ((ξ + η) / (4 * ξ), (ξ + η) / (4 * η)),
        (Integral(A, _RUNGE_LENZ_2, _squared, _along_squared, _KEPLER_2),),
    ),
    KnownChart(
        "rotational parabolic, z = (ξ - η)/2",
        lambda ξ, η, φ: ((ξ + η) / (4 * ξ), (ξ + η) / (4 * η), ξ * η),
        (
            Integral(L_Z**2, _AXIAL, lambda ξ, η, φ: (sp.S.Zero, sp.S.Zero, sp.S.One)),
            Integral(
                A, _RUNGE_LENZ_2, lambda ξ, η, φ: (*_squared(ξ, η), (ξ - η) / (2 * ξ * η)), _along_squared, _KEPLER_2
            ),
        ),
    ),
)


def of_dimension(n: int) -> Sequence[KnownChart]:
    """Return the charts with n coordinates.

    Args:
        n: 2 or 3 for those known; there are none of other dimensions.
    """
    return [c for c in CHARTS if c.squares.__code__.co_argcount == n]
