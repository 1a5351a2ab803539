"""∫ N dq/P along a motion x(t), where it is a polynomial of x times √P and a multiple of ∫ dx/√P: smooth for all times.

With t = w ∫ dx/√P the root is ẋ w, of either sign as the motion turns: a(x) √P + c ∫ dx/√P is a(x(t)) w ẋ(t) + c t/w.
"""

from __future__ import annotations

import sympy as sp

from hjsolve.closed_form.elementary import Antiderivative, positive_root
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral, monotone_inverse
from hjsolve.closed_form.tidy import shortened_powers
from hjsolve.closed_form.verification import value_along

OTHER = "its equation contains another integral than the time law"


def elementary_in_time(
    own: CoordinateIntegrals, time: PieceIntegral, other: PieceIntegral, place: sp.Expr, elapsed: sp.Expr,
    start: sp.Symbol, explicit: sp.Expr,
) -> sp.Expr:  # fmt: skip
    """The integral from t₀ on.

    Args:
        own: the coordinate.
        time: its integral in the time law.
        other: the integral that is wanted.
        place: q(t).
        elapsed: t − t₀.
        start: the lower limit.
        explicit: q(t), written out.

    Raises:
        NoFormError: one of the integrals is of another kind.
    """
    first, second = time.law, other.law
    if first is None or second is None or other.curve is not time.curve or not one_root(second):
        raise NoFormError(OTHER)
    s, q, t = time.curve.substitution, time.curve.coordinate.symbol, next(e for e in elapsed.args if e.is_Symbol)
    begin = s.place.subs(q, start)

    def added(q_of_t: sp.Expr) -> sp.Expr:
        x = monotone_inverse(s.place.subs(q, q_of_t))
        root, amount = _along(first, x, begin, elapsed, t)
        a, x_ = second.algebraic, second.x
        edges = a.subs(x_, x) * root - a.subs(x_, begin) * _root_at(second, begin)
        return edges + sp.Add(*(c for c, _ in second.terms)) * amount

    value_along(own, (time, other), added(explicit), (t, start))
    return shortened_powers(added(place))


def one_root(law: Antiderivative) -> bool:
    """Whether an integral is a polynomial times √P and one function more, of the same root.

    Args:
        law: the integral.
    """
    return bool(law.algebraic.is_polynomial(law.x)) and all(term.place is None for _, term in law.terms)


def _root_at(law: Antiderivative, x: sp.Expr) -> sp.Expr:
    return positive_root(sp.sympify(law.polynomial).subs(law.x, x))


def _along(
    law: Antiderivative, x: sp.Expr, begin: sp.Expr, elapsed: sp.Expr, t: sp.Symbol
) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
    """√P with the sign that it has along the motion, and ∫ dx/√P from t₀ on."""
    if law.algebraic == 0 and len(law.terms) == 1 and law.terms[0][1].place is None:
        weight = law.terms[0][0]
        return weight * sp.diff(x, t), elapsed / weight
    P = sp.Poly(law.polynomial, law.x)
    if law.terms or law.algebraic.has(law.x) or P.degree() != 1:
        raise NoFormError(OTHER)
    grown = elapsed / law.algebraic
    return grown + _root_at(law, begin), 2 * grown / P.LC()
