"""Elliptic integrals in Legendre's F, E, Π: what the forms in Carlson's functions are compared with.

The letters and the order of the branch points are those of ``hjsolve.functions.elliptic.jacobi_forms``.
"""

from __future__ import annotations

import sympy as sp

from hjsolve.functions.elliptic.branch_points import BranchPoints, Interval, NoForm, PartialFractions
from hjsolve.functions.elliptic.jacobi_forms import _Order
from hjsolve.functions.elliptic.jacobi_forms import _ζ as _zeta
from hjsolve.functions.elliptic.moments import IntegrationPath, Kinds, first_and_other_kinds, refuse, whole_path


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


def _sine2(order: _Order) -> sp.Expr:
    """sin²φ; exactly 1 where the path ends at the first of the points."""
    if order.path.whole and order.path.x == order.points[0]:
        return sp.S.One
    return order.span * order.path.S**2 / order.path.v(order.points[2])


def _legendre(R: PartialFractions, path: IntegrationPath) -> sp.Expr:
    order = _Order(path)
    m, s2, scale = order.m, _sine2(order), 2 / sp.sqrt(path.q * order.span)
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
            n = (_zeta(path, place) - _zeta(path, order.points[2])) / order.span
            inner = ((sp.elliptic_pi(n, m) if whole else sp.elliptic_pi(n, φ, m)) - F) / n
        return scale * inner / order.span

    return first_and_other_kinds(R, path, Kinds(scale * F, third))
