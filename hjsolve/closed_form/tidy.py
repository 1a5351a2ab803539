"""Small rewritings of results: p²/|p| is |p|, E √(−E) is −(−E)^(3/2); exact for real symbols."""

from __future__ import annotations

import sympy as sp

from hjsolve.functions import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ

ELLIPTIC = (
    sp.elliptic_k, sp.elliptic_f, sp.elliptic_e, sp.elliptic_pi, CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ,
)  # fmt: skip
"""The integrals that occur in forms."""
LONGEST = 150
"""Operations above which a form with elliptic integrals is left as it is."""


def elliptic(expression: sp.Expr) -> bool:
    """Whether an expression holds elliptic integrals: such are not multiplied out, which takes for ever.

    Args:
        expression: of a form.
    """
    return bool(expression.has(*ELLIPTIC))


def shortened_powers(expression: sp.Expr) -> sp.Expr:
    """Write products of powers of s, −s and |s| shorter.

    Args:
        expression: real, of real symbols.
    """
    if elliptic(expression) and sp.count_ops(expression) > LONGEST:
        return expression
    return expression.replace(lambda e: e.is_Mul, _product)


def _product(product: sp.Expr) -> sp.Expr:
    powers = dict[sp.Expr, sp.Expr]()
    for factor in sp.Mul.make_args(product):
        base, power = factor.as_base_exp()
        powers[base] = powers.get(base, sp.S.Zero) + power
    for base in list(powers):
        if isinstance(base, sp.Abs) and (inner := base.args[0]) in powers and powers[inner].is_Integer:
            n = powers.pop(inner)
            powers[base] += n
            if n % 2:
                powers[sp.sign(inner)] = sp.S.One
        elif -base in powers and powers[-base].is_Integer and not powers[base].is_Integer:
            n = powers.pop(-base)
            powers[base] += n
            powers[sp.S.NegativeOne] = powers.get(sp.S.NegativeOne, sp.S.Zero) + n
    return sp.Mul(*(base**power for base, power in powers.items()))
