"""Small rewritings of results: p²/|p| is |p|, E √(−E) is −(−E)^(3/2); exact for real symbols."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import sympy as sp

from hjsolve.algebra.factoring import factored as factors_of_polynomial
from hjsolve.functions import (
    CarlsonRC,
    CarlsonRCIm,
    CarlsonRCRe,
    CarlsonRD,
    CarlsonRF,
    CarlsonRJ,
    CarlsonRJIm,
    CarlsonRJRe,
)

ELLIPTIC = (
    sp.elliptic_k, sp.elliptic_f, sp.elliptic_e, sp.elliptic_pi, CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ,
    CarlsonRCRe, CarlsonRCIm, CarlsonRJRe, CarlsonRJIm,
)  # fmt: skip
"""The integrals that occur in forms."""
LONGEST = 150
"""Operations above which a form with elliptic integrals is left as it is."""
_FACTORED = 80
"""Operations up to which the coefficient of an integral is factored."""
_MANY_TERMS, _MOST_SYMBOLS = 5, 12
"""Terms of a sum from which on its factors are sought letter by letter, and letters up to which they are."""


def elliptic(expression: sp.Expr) -> bool:
    """Return whether an expression holds elliptic integrals: such are not multiplied out, which takes for ever.

    Args:
        expression: of a form.
    """
    return bool(expression.has(*ELLIPTIC))


def longer_than(expression: sp.Expr, limit: float) -> bool:
    """Return whether a formula has more operations than a limit.

    Args:
        expression: of a form.
        limit: of operations.
    """
    return operations(expression, limit) > limit


def operations(expression: sp.Expr, limit: float = math.inf) -> int:
    """Return how many operations a formula has; sympy's count looks at every sign, and takes seconds.

    Args:
        expression: of a form.
        limit: beyond which they are not counted.
    """
    count, waiting = 0, [expression]
    while waiting and count <= limit:
        one = waiting.pop()
        count += max(len(one.args) - 1, 1) if one.args else 0
        waiting.extend(one.args)
    return count


def multiplied_out(expression: sp.Expr, limit: float = LONGEST) -> sp.Expr:
    """Return a product multiplied out, but not a long one, and not inside functions.

    Args:
        expression: of a form.
        limit: of operations, above which it is given back.
    """
    if longer_than(expression, limit):
        return expression
    inside = {f: sp.Dummy(real=True) for f in _outermost(expression)}
    return sp.expand(expression.xreplace(inside)).xreplace({name: f for f, name in inside.items()})


def _outermost(expression: sp.Expr) -> set[sp.Expr]:
    """Return the functions in a formula that are in no other."""
    # |s| and sign s are factors like others: products with them are multiplied out
    if isinstance(expression, sp.Function) and not isinstance(expression, (sp.Abs, sp.sign)):
        return {expression}
    return set().union(*(_outermost(part) for part in expression.args))


_GAMMA = {sp.gamma(-sp.Rational(1, 4)): -4 * sp.sqrt(2) * sp.pi / sp.gamma(sp.Rational(1, 4))}
"""K(1/2) by Γ(1/4), as books write it."""


def shortened_powers(expression: sp.Expr) -> sp.Expr:
    """Write products of powers of s, −s and |s| shorter.

    Args:
        expression: real, of real symbols.
    """
    expression = expression.xreplace(_GAMMA)
    if elliptic(expression) and longer_than(expression, LONGEST):
        return expression
    return expression.replace(lambda e: e.is_Mul, _product)


def collected(expression: sp.Expr) -> sp.Expr:
    """Return a linear combination of elliptic integrals with each written once, its coefficient in factors.

    What has the opposite coefficient, as an integral has at its lower limit, stands in the same bracket.

    Args:
        expression: of a form; of any that is not linear in them it is given back.
    """
    # F(φ) − F(φ₀) of each integral has one coefficient twice: one bracket in place of two products
    coefficients = linear_in(expression, lambda _: True)
    if coefficients is None or len(coefficients) < 2:
        return expression
    rest = sp.Add(*(_factored(term) for term in sp.Add.make_args(coefficients.pop(sp.S.One, sp.S.Zero))))
    rest = min((rest, _factored(rest)), key=sp.count_ops)
    factored = {one: _factored(c) for one, c in coefficients.items() if c != 0}
    brackets = dict[sp.Expr, sp.Expr]()
    for one, c in sorted(factored.items(), key=lambda pair: sp.default_sort_key(pair[0])):
        if -c in brackets:
            brackets[-c] -= one
        else:
            brackets[c] = brackets.get(c, sp.S.Zero) + one
    return rest + sp.Add(*(c * bracket for c, bracket in brackets.items()))


def linear_in(e: sp.Expr, wanted: Callable[[sp.Expr], bool]) -> dict[sp.Expr, sp.Expr] | None:
    """Return an expression as a sum, integral or 1 → its coefficient; None of what is not linear in the integrals.

    Args:
        e: of a form.
        wanted: whether a function is one of the integrals.
    """

    def held(part: sp.Expr) -> bool:
        return any(map(wanted, part.atoms(*ELLIPTIC)))

    if not held(e):
        return {sp.S.One: e}
    if isinstance(e, ELLIPTIC):
        return {e: sp.S.One} if wanted(e) else None
    if e.is_Mul:
        factors = [f for f in e.args if held(f)]
        inner = linear_in(factors[0], wanted) if len(factors) == 1 else None
        rest = sp.Mul(*(f for f in e.args if f is not factors[0]))
        return None if inner is None else {one: rest * c for one, c in inner.items()}
    if not e.is_Add:
        return None
    found = dict[sp.Expr, sp.Expr]()
    for term in e.args:
        inner = linear_in(term, wanted)
        if inner is None:
            return None
        for one, c in inner.items():
            found[one] = found.get(one, sp.S.Zero) + c
    return found


@lru_cache(maxsize=1024)
def _factored(coefficient: sp.Expr) -> sp.Expr:
    if not coefficient.is_Add and not any(f.is_Add for f in coefficient.args):
        return shortened_powers(coefficient)
    return shortened_powers(coefficient if longer_than(coefficient, _FACTORED) else factored(coefficient))


def factored(total: sp.Expr) -> sp.Expr:
    """Return an expression in factors, like sympy, which seeks those of P = a r⁴ + … + c for 16 s though it has none.

    Args:
        total: of a form.
    """
    P = total.as_poly() if total.is_Add and len(total.args) >= _MANY_TERMS else None
    if P is None or not all(g.is_Symbol for g in P.gens) or len(P.gens) > _MOST_SYMBOLS:
        return sp.factor(total)
    return factors_of_polynomial(total, _MOST_SYMBOLS)


def in_factors(expression: sp.Expr) -> sp.Expr:
    """Return a rational expression as one quotient in factors.

    Args:
        expression: rational in symbols and roots.
    """
    return sp.factor(sp.cancel(sp.together(expression)))


def one_and_product(value: sp.Expr) -> sp.Expr:
    """Return 1 + a product, as books write the square of an eccentricity: 1 + 2EL²/mk²; a sum, where that is shorter.

    Args:
        value: rational in symbols and roots.
    """
    value = sp.cancel(sp.together(value))
    return min(sp.expand(value), 1 + sp.factor(value - 1), key=sp.count_ops)


def plain_roots(expression: sp.Expr) -> sp.Expr:
    """Return a sum with √s in place of s/√s, each root once.

    Args:
        expression: of constants, linear in each root.
    """
    held = [p for p in expression.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2]
    roots = {p.base: sp.Dummy(positive=True) for p in held}
    # s^{k + 1/2} is √s sᵏ: then the sum is linear in each √s, and what is rational cancels
    plain = expression.xreplace({p: roots[p.base] * p.base ** (p.exp - sp.S.Half) for p in held})
    terms = sp.collect(sp.expand(plain), [*roots.values()], evaluate=False)
    short = sp.Add(*(sp.cancel(sp.together(c)) * r for r, c in terms.items()))
    return sp.factor(short).xreplace({r: sp.sqrt(base) for base, r in roots.items()})


def square_root(radicand: sp.Expr) -> sp.Expr:
    """√ of what is positive where a form holds, with the absolute values of its squared factors taken out.

    Args:
        radicand: rational in real symbols.
    """
    outside, inside = sp.S.One, sp.S.One
    for factor in sp.Mul.make_args(sp.factor(radicand)):
        base, power = factor.as_base_exp()
        # √(a² b) is |a| √b: the sign of a is that of a regime, and is not known here
        if power.is_Integer and not base.is_number:
            outside *= sp.Abs(base) ** (power // 2)
            inside *= base ** (power % 2)
        else:
            inside *= factor
    return outside * sp.sqrt(inside)


def _product(product: sp.Expr) -> sp.Expr:
    powers = dict[sp.Expr, sp.Expr]()
    for factor in sp.Mul.make_args(product):
        base, power = factor.as_base_exp()
        # of real s: s²/|s| is |s|, s³/|s| is s |s|, and (−s)^{n + 1/2} takes the whole powers of s
        powers[base] = powers.get(base, sp.S.Zero) + power
    for base in list(powers):
        if isinstance(base, sp.Abs) and (inner := base.args[0]) in powers and powers[inner].is_Integer:
            n = powers.pop(inner)
            powers[base] += n
            # sⁿ = |s|ⁿ sign(s)ⁿ
            if n % 2:
                powers[sp.sign(inner)] = sp.S.One
        elif -base in powers and powers[-base].is_Integer and not powers[base].is_Integer:
            n = powers.pop(-base)
            powers[base] += n
            powers[sp.S.NegativeOne] = powers.get(sp.S.NegativeOne, sp.S.Zero) + n
    return sp.Mul(*(base**power for base, power in powers.items()))
