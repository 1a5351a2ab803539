"""√(g l³)/l² is √(g/l), and √(g l A)/A is √(g l/A) where A > 0 in the regime: one root in place of a quotient."""

from __future__ import annotations

from collections import Counter

import sympy as sp

from hjsolve.closed_form.regime import Regime, sign_is_fixed
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import elliptic, operations
from hjsolve.precision import mp


def under_one_root(made: Regime, expression: sp.Expr) -> sp.Expr:
    """Return a form with factors of a radicand that stand outside of its root too taken into the root.

    Factors of even powers have no sign; the product of those of odd powers must have one sign in the regime.

    Args:
        made: the regime.
        expression: of a form, real for the motions of the regime.
    """
    if not any(e.is_Mul and _square_roots(e) for e in expression.atoms(sp.Mul)):
        return expression
    at = Signs(made.example, mp.mpf(0))
    return expression.replace(lambda e: e.is_Mul and bool(_square_roots(e)), lambda e: _taken_in(e, made, at))


def _square_roots(product: sp.Expr) -> list[sp.Pow]:
    """Return the factors √R and 1/√R, R a product with a factor that a regime may give a sign."""
    return [
        f
        for f in product.args
        if f.is_Pow and abs(f.exp) == sp.S.Half and (f.base.is_Mul or f.base.is_Pow) and not elliptic(f)
    ]


def _taken_in(product: sp.Expr, made: Regime, at: Signs) -> sp.Expr:
    for root in _square_roots(product):
        inside = {f.as_base_exp()[0] for f in sp.Mul.make_args(root.base)}
        inside = {base for base in inside if not base.is_number}
        powers = Counter[sp.Expr]()
        for factor in product.args:
            base, power = factor.as_base_exp()
            if base in inside and power.is_Integer:
                powers[base] += int(power)
        odd = sp.Mul(*(base for base, power in powers.items() if power % 2))
        if not powers or not odd.free_symbols <= at.numbers.keys() or not sign_is_fixed(made.relations, odd):
            continue
        sign = at.there(odd) if odd != 1 else 1
        moved = sp.Mul(*(base**power for base, power in powers.items()))
        inner: sp.Expr = sp.Mul(root.base, *(base ** (power / root.exp) for base, power in powers.items()))
        upright = inner**root.exp
        if root.exp < 0 and sp.denom(inner) != 1 and not sp.numer(inner).is_Add and not sp.denom(inner).is_Add:
            upright = sp.sqrt(1 / inner)  # 1/√(g/l) is √(l/g)
        whole = sign * sp.Mul(*(f for f in product.args if f is not root)) / moved * upright
        if sign != 0 and operations(whole) < operations(product):
            return _taken_in(whole, made, at) if whole.is_Mul else whole
    return product
