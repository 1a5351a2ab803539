"""Arcs of numbers next to ±1 by a tangent, in doubles: asin x = atan2(x, √(1 − x²)), with 1 − x² factored.

asin x has half of the digits of x where x is next to 1, because the rounding of x is all that is left of 1 − x². Of
Kepler's orbit x = (kmr − p²)/(r √m √(2Ep² + k²m)), which is next to 1 all along a nearly radial orbit (p → 0); with
x = N/D, D² − N² = p² (2Emr² + 2kmr − p²) has no difference left but the radicand, zero at turning points alone.
Likewise acos x = atan2(√(1 − x²), x), and acosh x = asinh √(x² − 1).

W of an oscillator is ½ q p + (E/ω) asin(q/a): next to a turning point both terms vary as p, and W as p³. With
asin(q/a) = atan2(q, √(D² − N²)/D), D² − N² the radicand of p, the rounding of p drops out of their sum.
"""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType

import sympy as sp

from hjsolve.closed_form.named_quantities import written_out
from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.tidy import elliptic, longer_than, operations

_LONGEST = 40
"""Operations of an argument that is squared and factored: a longer one may take sympy seconds."""
_LONGER = 10
"""Operations by which D² − N² may be longer than N and D."""


def arcs_by_tangents(
    expression: sp.Expr, where: Where = MappingProxyType({}), radicands: frozenset[sp.Expr] = frozenset()
) -> sp.Expr:
    """Return an equal expression with its arcs by tangents, wherever 1 − x² loses fewer digits factored.

    Args:
        expression: of a form, or a definition.
        where: symbol → its definition: of the amplitude a of an oscillator, a² = E²/k² − p²/km.
        radicands: sums below roots of the forms of a regime, as ``radicands_of`` returns them.
    """
    return expression.replace(_is_arc, lambda arc: _by_tangent(arc, where, radicands))


def radicands_of(expressions: Iterable[sp.Expr]) -> frozenset[sp.Expr]:
    """Return the sums below square roots, expanded, with both signs.

    Args:
        expressions: forms of a regime.
    """
    bases = {p.base for e in expressions for p in e.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2}
    sums = set[sp.Expr]()
    for base in bases:
        if base.free_symbols and not elliptic(base) and not longer_than(base, _LONGEST):
            sums |= _sums(sp.factor(base))
    return frozenset(sums | {sp.expand(-e) for e in sums})


def _sums(product: sp.Expr) -> set[sp.Expr]:
    return {sp.expand(f) for f in sp.Mul.make_args(product) if f.is_Add}


def _is_arc(e: sp.Expr) -> bool:
    return isinstance(e, (sp.asin, sp.acos, sp.acosh)) and bool(e.free_symbols)


def _by_tangent(arc: sp.Expr, where: Where, radicands: frozenset[sp.Expr]) -> sp.Expr:
    x = arc.args[0]
    square = _rest_of_square(x, where, radicands)
    if square is None:
        return arc
    other = sp.sqrt(sp.Abs(square))  # the modulus, since next to a turning point rounding gives it either sign
    if isinstance(arc, sp.acosh):
        return sp.asinh(other)
    return sp.atan2(x, other) if isinstance(arc, sp.asin) else sp.atan2(other, x)


def _rest_of_square(x: sp.Expr, where: Where, radicands: frozenset[sp.Expr]) -> sp.Expr | None:
    """Return 1 − x² as a quotient of products; else None.

    Fewer terms must be left than D² and N² have, or it must split, or be a radicand of the forms.
    """
    if elliptic(x) or longer_than(x, _LONGEST) or x.has(sp.Piecewise):
        return None
    N, D = sp.fraction(sp.together(x))
    rest, most = sp.expand(D**2 - N**2), operations(N) + operations(D) + _LONGER
    if rest == 0 or longer_than(rest, 4 * _LONGEST):
        return None
    explicit = written_out(rest, where)
    if explicit != rest and not longer_than(explicit, 4 * _LONGEST) and not _has_root_of_sum(explicit):
        made = sp.factor(explicit)  # what a name hides cancels exactly: e² − 1 of a nearly radial orbit
        if not longer_than(made, most):
            return made / D**2
    terms, made = sum(len(sp.Add.make_args(sp.expand(e**2))) for e in (D, N)), sp.factor(rest)
    known = bool(radicands) and _sums(made) <= radicands
    if (known or not (made.is_Add and len(made.args) >= terms)) and not longer_than(made, most):
        return made / D**2
    # of x = (u + √D)/v both factors are of that kind, and have a conjugate
    return (D - N) * (D + N) / D**2 if _has_root_of_sum(N) else None


def _has_root_of_sum(e: sp.Expr) -> bool:
    return any(p.base.is_Add and p.exp == sp.S.Half for p in e.atoms(sp.Pow))
