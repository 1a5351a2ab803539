"""Polynomials of the coordinates inside a potential, expanded so that what cancels does."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.webs.orthonormal_frames import tidy_constant


def flattened(expression: sp.Expr, X: Sequence[sp.Symbol]) -> sp.Expr:
    """Expand every polynomial in X inside an expression, with tidy coefficients, so that what cancels does.

    Args:
        expression: with polynomials in X inside of functions.
        X: Cartesian coordinates.
    """
    check_time()
    if not expression.free_symbols & set(X) or expression in X:
        return expression
    if expression.is_polynomial(*X):
        terms = sp.Poly(sp.expand(expression), *X).terms()
        return sp.Add(
            *(tidy_constant(c) * sp.prod([q**e for q, e in zip(X, powers, strict=True)]) for powers, c in terms)
        )
    if expression.is_Add:
        smooth = [term for term in expression.args if term.is_polynomial(*X)]
        rest = [flattened(term, X) for term in expression.args if not term.is_polynomial(*X)]
        return sp.Add(flattened(sp.Add(*smooth), X), *rest)
    return expression.func(*(flattened(argument, X) for argument in expression.args))
