"""The inverse of the integral of the first kind in Jacobi's sn and cn.

With z = σ/(x − e) the branch points lie at ζₖ = σ/(rₖ − e), ζ = 0 for ∞; from e in the direction of the interval they
come in the order ζ₁ > ζ₂ > ζ₃, and (Byrd & Friedman 237; DLMF 19.25(v))

    ∫ dx/√P = 2/√(q(ζ₁ − ζ₃)) F(φ|m),   sin²φ = (ζ₁ − ζ₃)/(z − ζ₃),   m = (ζ₂ − ζ₃)/(ζ₁ − ζ₃).

With a complex pair ξ ± iη beside ζ (Byrd & Friedman 239), H² = (ξ − ζ)² + η²:

    ∫ dx/√P = F(φ|m)/√(qH),   cos φ = (z − ζ − H)/(z − ζ + H),   m = (H + ξ − ζ)/(2H).

Where e = 0, √x is an odd function of the integral, smooth through the zeros of x: sn/√(ζ₁ − ζ₃ cn²), or, with
(1 − cn 2v)/(1 + cn 2v) = sn² v dn² v/cn² v, sn dn/√(ζ sn² dn² + H cn²) of half the argument.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.functions.elliptic.branch_points import BranchPoints, Interval, NoForm, PartialFractions
from hjsolve.functions.elliptic.moments import INFINITY, IntegrationPath, refuse
from hjsolve.functions.jacobi import JacobiCN, JacobiDN, JacobiSN


def inverse(P: BranchPoints, interval: Interval, u: sp.Expr, start: str = "lower") -> sp.Expr:
    """X for which ∫ dx/√P from the lower root of the interval (or to the upper one) is u; periodic between two roots.

    Args:
        P: the branch points.
        u: the value of the integral.
        start: "lower" or "upper": the root that x is at where u = 0.

    Raises:
        NoForm: P has no real root to begin at.
    """
    refuse(PartialFractions(()), P)
    path = IntegrationPath(P, interval, start, None, whole=False)
    if P.pairs:
        (α, β), (r, *_) = P.pairs[0], path.others
        square = (α - path.e) ** 2 + β**2
        ζ, ξ, η = _ζ(path, r), path.σ * (α - path.e) / square, β / square
        H = sp.sqrt((ξ - ζ) ** 2 + η**2)
        c = JacobiCN(sp.sqrt(path.q * H) * u, (H + ξ - ζ) / (2 * H))
        return path.e + path.σ * (1 - c) / (ζ * (1 - c) + H * (1 + c))
    order = _Order(path)
    s2 = JacobiSN(sp.sqrt(path.q * order.span) * u / 2, order.m) ** 2
    return path.e + path.σ * s2 / (_ζ(path, order.points[2]) * s2 + order.span)


def odd_root_of_inverse(P: BranchPoints, interval: Interval, u: sp.Expr) -> sp.Expr:
    """√x, with the sign of u next to u = 0, for which ∫ dx/√P from the lower root x = 0 of the interval is u.

    Args:
        P: the branch points; 0 is the lower end of the interval.
        interval: where P > 0.
        u: the value of the integral.

    Raises:
        NoForm: 0 is not its lower end.
    """
    refuse(PartialFractions(()), P)
    path = IntegrationPath(P, interval, "lower", None, whole=False)
    if path.e != 0:
        raise NoForm("the interval does not begin at zero")
    if P.pairs:
        (ξ, η), (r, *_) = P.pairs[0], path.others
        square, ζ = ξ**2 + η**2, _ζ(path, r)
        H = sp.sqrt((ξ / square - ζ) ** 2 + (η / square) ** 2)
        given = sp.sqrt(path.q * H) * u / 2, (H + ξ / square - ζ) / (2 * H)
        s, c, d = JacobiSN(*given), JacobiCN(*given), JacobiDN(*given)
        return s * d / sp.sqrt(ζ * s**2 * d**2 + H * c**2)
    order = _Order(path)
    given = sp.sqrt(path.q * order.span) * u / 2, order.m
    first, third = (_ζ(path, order.points[k]) for k in (0, 2))
    return JacobiSN(*given) / sp.sqrt(first - third * JacobiCN(*given) ** 2)


def _ζ(path: IntegrationPath, place: sp.Expr | None) -> sp.Expr:
    return sp.S.Zero if place is INFINITY else path.σ / (place - path.e)


@dataclass(frozen=True)
class _Order:
    """The three other branch points in the order ζ₁ > ζ₂ > ζ₃."""

    path: IntegrationPath

    @cached_property
    def points(self) -> tuple[sp.Expr | None, ...]:
        below, above = self.path.P.real[: self.path.index], self.path.P.real[self.path.index + 1 :]
        middle = (INFINITY,) if self.path.P.degree == 3 else ()
        return (*above, *middle, *below) if self.path.σ > 0 else (*below[::-1], *middle, *above[::-1])

    @cached_property
    def span(self) -> sp.Expr:
        """ζ₁ − ζ₃."""
        return _ζ(self.path, self.points[0]) - _ζ(self.path, self.points[2])

    @cached_property
    def m(self) -> sp.Expr:
        return (_ζ(self.path, self.points[1]) - _ζ(self.path, self.points[2])) / self.span
