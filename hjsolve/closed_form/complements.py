"""Differences that lose digits in doubles, as quotients: 1 − m next to m = 1, and 1 − x₃ where a root is next to 1.

    K(m) = R_F(0, 1 − m, 1)
    E(m) = ⅓ (1 − m) [R_D(0, 1 − m, 1) + R_D(0, 1, 1 − m)]
    Π(n, m) = R_F(0, 1 − m, 1) + ⅓ n R_J(0, 1 − m, 1, 1 − n),  n > 0
    Π(n, m) = [m K(m) − n (1 − m)/(1 − n) Π(N, m)]/(m − n),  N = (m − n)/(1 − n),  n < 0

DLMF 19.25.1, 19.25.2; Abramowitz and Stegun 17.7.17: with n < 0 the terms of the former nearly cancel. With m =
(x₃ − x₂)/(x₃ − x₁) the complement is (x₂ − x₁)/(x₃ − x₁), a quotient of differences of roots. A long motion between
distant turning points has 1 − m of the order of their ratio.

With all roots of P real and named, c − x₃ = P(c)/(a (c − x₁)(c − x₂)), a the leading coefficient. Where P(c) is one
term nothing is subtracted in it: of the spherical pendulum P(1) is p_φ², and x₃ is next to 1 where the pendulum nearly
passes the vertical.
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.connected_integrals import connected
from hjsolve.closed_form.evaluation import number_of
from hjsolve.functions import CarlsonRD, CarlsonRF, CarlsonRJ

Where = Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]

COMPLETE = (sp.elliptic_k, sp.elliptic_e, sp.elliptic_pi)


def for_doubles(expression: sp.Expr, where: Where, example: Mapping[sp.Symbol, mpmath.mpf]) -> sp.Expr:
    """Return an equal expression that loses fewer digits.

    Args:
        expression: of a form.
        where: symbol → its definition.
        example: symbol → its value at a motion of the regime, of constants and of names: signs and order are its.
    """
    roots = {s: value for s, value in example.items() if isinstance(where.get(s), tuple)}
    gathered = connected(expression, where, example)
    return _by_gaps(_by_complements(gathered, where, example), where, roots)


def _by_gaps(expression: sp.Expr, where: Where, roots: Mapping[sp.Symbol, mpmath.mpf]) -> sp.Expr:
    """Write c − x as a quotient where P(c) is one term and no root between c and x can be.

    A root across c may come nearer to it than x: there the difference is the better one, at each motion anew.
    """
    defined = {s: e for s, e in where.items() if isinstance(e, sp.Expr)}
    while held := {s: e for s, e in defined.items() if s in expression.free_symbols and _gaps(e, where, roots)}:
        expression = expression.xreplace(held)
    return expression.xreplace(_gaps(expression, where, roots))


def _gaps(expression: sp.Expr, where: Where, roots: Mapping[sp.Symbol, mpmath.mpf]) -> dict[sp.Expr, sp.Expr]:
    """Return the differences in an expression that are such quotients."""
    found = dict[sp.Expr, sp.Expr]()
    for gap in expression.atoms(sp.Add):
        c, x = gap.as_coeff_Add()
        sign, x = x.as_coeff_Mul()
        meaning = where.get(x) if x.is_Symbol and c != 0 and sign in (1, -1) else None
        if not isinstance(meaning, tuple) or x not in roots:
            continue
        P, c = meaning[0], -sign * c
        others = [s for s, e in where.items() if isinstance(e, tuple) and e[0] == P and s != x]
        value = sp.factor(P.as_expr().subs(P.gen, c))
        if value.is_Add or value == 0 or len(others) != P.degree() - 1 or not all(s in roots for s in others):
            continue
        quotient = -sign * value / (P.LC() * sp.Mul(*(c - s for s in others)))
        across = [s for s in others if (roots[s] - c) * (roots[x] - c) < 0]
        if all((roots[s] - roots[x]) * (roots[x] - c) > 0 for s in others if s not in across):
            nearer = [x + s < 2 * c if roots[s] > c else x + s > 2 * c for s in across]
            found[gap] = sp.Piecewise((gap, sp.Or(*nearer)), (quotient, True)) if nearer else quotient
    return found


def _by_complements(expression: sp.Expr, where: Where, example: Mapping[sp.Symbol, mpmath.mpf]) -> sp.Expr:
    """Write complete integrals as Carlson's, by complements; the names of roots have pairs and stay."""
    defined = {s: e for s, e in where.items() if isinstance(e, sp.Expr)}
    new = dict[sp.Basic, sp.Expr]()
    for integral in expression.atoms(*COMPLETE):
        parameters = integral.args
        complete = len(parameters) == (2 if isinstance(integral, sp.elliptic_pi) else 1)
        complements = [_complement(e, defined) for e in parameters] if complete else [None]
        if all(c is not None for c in complements):
            negative = parameters[0].free_symbols <= example.keys() and number_of(parameters[0], example) < 0
            new[integral] = _carlson(integral, complements, negative=negative)
    return expression.xreplace(new)


def _complement(parameter: sp.Expr, defined: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr | None:
    """1 − m as a quotient without the 1; None where it does not cancel."""
    while parameter.free_symbols & defined.keys():
        parameter = parameter.xreplace(defined)
    above, below = sp.fraction(sp.together(parameter))
    if below == 1:
        return None
    left = sp.factor_terms(sp.expand(below - above))
    return left / below if len(sp.Add.make_args(left)) <= len(sp.Add.make_args(sp.expand(below))) else None


def _carlson(integral: sp.Expr, complements: list[sp.Expr], *, negative: bool) -> sp.Expr:
    c = complements[-1]
    if isinstance(integral, sp.elliptic_e):
        return c * (CarlsonRD(0, c, 1) + CarlsonRD(0, 1, c)) / 3
    if isinstance(integral, sp.elliptic_k):
        return CarlsonRF(0, c, 1)
    (n, m), d, K = integral.args, complements[0], CarlsonRF(0, c, 1)
    if not negative:
        return K + n * CarlsonRJ(0, c, 1, d) / 3
    return (m * K - n * c / d * (K + (m - n) / d * CarlsonRJ(0, c, 1, c / d) / 3)) / (m - n)
