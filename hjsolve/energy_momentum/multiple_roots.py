"""The distinct real roots of one polynomial with numbers as coefficients, whatever their multiplicities."""

from __future__ import annotations

import sympy as sp
from mpmath.libmp import NoConvergence

from hjsolve.errors import NotConvergedError

_DIGITS = 30
_FINEST = 2000
"""Binary digits after the point to which a root is enclosed at most: a smaller one counts as this near to zero."""


def real_roots(polynomial: sp.Poly) -> list[sp.Float]:
    """Return the distinct real roots in increasing order, to 30 digits.

    Newton's method and its relatives fail at multiple roots, so that those are made simple first. The roots of a
    polynomial with rational coefficients are then isolated exactly (Descartes' rule of signs).

    Args:
        polynomial: in one variable, with numbers as coefficients.

    Raises:
        NotConvergedError: the coefficients are irrational, and the roots did not converge.
    """
    if polynomial.degree() < 1:
        return []
    exact = polynomial if polynomial.domain.is_Exact else polynomial.to_exact()
    simple = exact.sqf_part()
    if simple.domain.is_ZZ or simple.domain.is_QQ:
        return [_middle(simple, low, high) for (low, high), _ in simple.intervals()]
    try:
        found = sp.Poly(sp.N(simple.as_expr(), 2 * _DIGITS), *simple.gens).nroots(n=_DIGITS, maxsteps=500)
    except NoConvergence:
        raise NotConvergedError(f"the roots of {sp.sstr(simple.as_expr())[:80]} did not converge") from None
    return sorted(sp.re(root) for root in found if abs(sp.im(root)) <= 1e-20 * (1e-12 + abs(root)))


def _middle(polynomial: sp.Poly, low: sp.Rational, high: sp.Rational) -> sp.Float:
    """Return the root between two rational numbers, to 30 digits of its own size."""
    bits = 64
    while high - low > max(abs(low), abs(high)) / 10 ** (_DIGITS + 2) and bits <= _FINEST:
        low, high = polynomial.refine_root(low, high, eps=sp.Rational(1, 2**bits))
        bits *= 2
    return sp.Float((low + high) / 2, _DIGITS)
