"""The same integrals in Legendre's F, E, Π, and the inverse of the first kind in Jacobi's sn and cn.

With z = σ/(x − e) the branch points lie at ζₖ = σ/(rₖ − e), ζ = 0 for ∞; from e in the direction of the interval they
come in the order ζ₁ > ζ₂ > ζ₃, and (Byrd & Friedman 237; DLMF 19.25(v))

    ∫ dx/√P = 2/√(q(ζ₁ − ζ₃)) F(φ|m),   sin²φ = (ζ₁ − ζ₃)/(z − ζ₃),   m = (ζ₂ − ζ₃)/(ζ₁ − ζ₃).

With a complex pair ξ ± iη beside ζ (Byrd & Friedman 239), H² = (ξ − ζ)² + η²:

    ∫ dx/√P = F(φ|m)/√(qH),   cos φ = (z − ζ − H)/(z − ζ + H),   m = (H + ξ − ζ)/(2H).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.functions.elliptic.branch_points import BranchPoints, Interval, NoForm, PartialFractions
from hjsolve.functions.elliptic.moments import (
    INFINITY,
    IntegrationPath,
    Kinds,
    first_and_other_kinds,
    refuse,
    whole_path,
)
from hjsolve.functions.jacobi import JacobiCN, JacobiSN


def inverse(P: BranchPoints, interval: Interval, u: sp.Expr, start: str = "lower") -> sp.Expr:
    """X for which ∫ dx/√P from the lower root of the interval (or to the upper one) is u; periodic between two roots.

    Args:
        P: the branch points.
        interval: where.
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


def legendre_complete(R: PartialFractions, P: BranchPoints, interval: Interval) -> sp.Expr | None:
    """∫ R dx/√P over the whole interval in Legendre's integrals; None where P has complex roots.

    Args:
        R: the rational function.
        P: the branch points.
        interval: where.

    Raises:
        NoForm: it diverges, or no form is known here; the text says why.
    """
    refuse(R, P)
    return None if P.pairs else _legendre(R, whole_path(P, interval))


def legendre_incomplete(
    R: PartialFractions, P: BranchPoints, interval: Interval, x: sp.Expr, start: str
) -> sp.Expr | None:
    """∫ R dx/√P from or to a root in Legendre's integrals; None where P has complex roots.

    Args:
        R: the rational function.
        P: the branch points.
        interval: where.
        x: the other end, within the interval.
        start: "lower" or "upper": the root at which the integral is zero.

    Raises:
        NoForm: no form is known here; the text says why.
    """
    refuse(R, P)
    return None if P.pairs else _legendre(R, IntegrationPath(P, interval, start, x, whole=False))


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

    @cached_property
    def sine2(self) -> sp.Expr:
        """sin²φ; exactly 1 where the path ends at the first of the points."""
        if self.path.whole and self.path.x == self.points[0]:
            return sp.S.One
        return self.span * self.path.S**2 / self.path.v(self.points[2])


def _legendre(R: PartialFractions, path: IntegrationPath) -> sp.Expr:
    order = _Order(path)
    m, s2, scale = order.m, order.sine2, 2 / sp.sqrt(path.q * order.span)
    whole = s2 == 1
    φ, Δ = sp.asin(sp.sqrt(s2)), sp.sqrt(1 - m * s2)
    F = sp.elliptic_k(m) if whole else sp.elliptic_f(φ, m)
    E = sp.elliptic_e(m) if whole else sp.elliptic_e(φ, m)

    def third(place: sp.Expr | None) -> sp.Expr:
        """Return the integral of sn²/(1 − n sn²), n from the place of the pole (Byrd & Friedman 310, 318, 337)."""
        if place == order.points[0] and whole:
            raise NoForm("the integral diverges at the end of the interval")
        if place == order.points[0]:
            inner = (Δ * sp.sqrt(s2 / (1 - s2)) - E) / (1 - m)
        elif place == order.points[1]:
            inner = ((E - (0 if whole else m * sp.sqrt(s2 * (1 - s2)) / Δ)) / (1 - m) - F) / m
        elif place == order.points[2]:
            inner = (F - E) / m
        else:
            n = (_ζ(path, place) - _ζ(path, order.points[2])) / order.span
            inner = ((sp.elliptic_pi(n, m) if whole else sp.elliptic_pi(n, φ, m)) - F) / n
        return scale * inner / order.span

    return first_and_other_kinds(R, path, Kinds(scale * F, third))
