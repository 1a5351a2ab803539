"""Complete integrals by the complement of the parameter, for doubles: next to m = 1 the difference 1 − m loses digits.

    K(m) = R_F(0, 1 − m, 1)
    E(m) = ⅓ (1 − m) [R_D(0, 1 − m, 1) + R_D(0, 1, 1 − m)]
    Π(n, m) = R_F(0, 1 − m, 1) + ⅓ n R_J(0, 1 − m, 1, 1 − n)

DLMF 19.25.1, 19.25.2. With m = (x₃ − x₂)/(x₃ − x₁) the complement is (x₂ − x₁)/(x₃ − x₁), a quotient of differences of
roots. A long motion between distant turning points has 1 − m of the order of their ratio.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.functions import CarlsonRD, CarlsonRF, CarlsonRJ

COMPLETE = (sp.elliptic_k, sp.elliptic_e, sp.elliptic_pi)


def by_complements(expression: sp.Expr, where: Mapping[sp.Symbol, object]) -> sp.Expr:
    """Return an equal expression whose complete integrals of named roots are Carlson's, by complements.

    Args:
        expression: of a form.
        where: symbol → its definition; the names of roots have pairs and stay.
    """
    defined = {s: e for s, e in where.items() if isinstance(e, sp.Expr)}
    new = dict[sp.Basic, sp.Expr]()
    for integral in expression.atoms(*COMPLETE):
        parameters = integral.args
        complete = len(parameters) == (2 if isinstance(integral, sp.elliptic_pi) else 1)
        complements = [_complement(e, defined) for e in parameters] if complete else [None]
        if all(c is not None for c in complements):
            new[integral] = _carlson(integral, complements)
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


def _carlson(integral: sp.Expr, complements: list[sp.Expr]) -> sp.Expr:
    c = complements[-1]
    if isinstance(integral, sp.elliptic_e):
        return c * (CarlsonRD(0, c, 1) + CarlsonRD(0, 1, c)) / 3
    if isinstance(integral, sp.elliptic_k):
        return CarlsonRF(0, c, 1)
    return CarlsonRF(0, c, 1) + integral.args[0] * CarlsonRJ(0, c, 1, complements[0]) / 3
