"""Arcs of numbers next to ±1 by a tangent, in doubles: asin x = atan2(x, √(1 − x²)), with 1 − x² factored.

asin x has half of the digits of x where x is next to 1, because the rounding of x is all that is left of 1 − x². Of
Kepler's orbit x = (kmr − p²)/(r √m √(2Ep² + k²m)), which is next to 1 all along a nearly radial orbit (p → 0); with
x = N/D, D² − N² = p² (2Emr² + 2kmr − p²) has no difference left but the radicand, zero at turning points alone.
Likewise acos x = atan2(√(1 − x²), x), and acosh x = asinh √(x² − 1).
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from hjsolve.closed_form.tidy import elliptic, longer_than, operations

_LONGEST = 40
"""Operations of an argument that is squared and factored: a longer one may take sympy seconds."""
_LONGER = 10
"""Operations by which D² − N² may be longer than N and D."""


def arcs_by_tangents(expression: sp.Expr) -> sp.Expr:
    """Return an equal expression with its arcs by tangents, wherever 1 − x² loses fewer digits factored.

    Args:
        expression: of a form, or a definition.
    """
    return expression.replace(_is_arc, _by_tangent)


def _is_arc(e: sp.Expr) -> bool:
    return isinstance(e, (sp.asin, sp.acos, sp.acosh)) and bool(e.free_symbols)


def _by_tangent(arc: sp.Expr) -> sp.Expr:
    x = arc.args[0]
    for square in _rest_of_square(x):
        if isinstance(arc, sp.acosh):
            return sp.asinh(sp.sqrt(sp.Abs(square)))
        other = sp.sqrt(sp.Abs(square))  # the modulus, since next to a turning point rounding gives it either sign
        return sp.atan2(x, other) if isinstance(arc, sp.asin) else sp.atan2(other, x)
    return arc


def _rest_of_square(x: sp.Expr) -> Iterator[sp.Expr]:
    """1 − x² as a quotient of products, if fewer terms are left than D² and N² have, or it splits into factors."""
    if elliptic(x) or longer_than(x, _LONGEST) or x.has(sp.Piecewise):
        return
    N, D = sp.fraction(sp.together(x))
    squares = [sp.expand(D**2), sp.expand(N**2)]
    rest = sp.expand(squares[0] - squares[1])
    if rest == 0 or longer_than(rest, 4 * _LONGEST):
        return
    terms = sum(len(sp.Add.make_args(s)) for s in squares)
    made = sp.factor(rest)
    if made.is_Add and len(made.args) >= terms:
        return
    if not longer_than(made, operations(N) + operations(D) + _LONGER):
        yield made / D**2
