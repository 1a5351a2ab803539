"""Sums under roots, in denominators and in quotients as products of their factors, wherever that is shorter."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import sympy as sp

from hjsolve.closed_form.tidy import elliptic, factored, longer_than, operations

LONGEST, LONGEST_PART = 80, 40
"""Operations of a sum or a quotient, and of a part of a sum, that is factored: longer ones may take sympy seconds."""
_TERMS = 3
"""The fewest terms that are bracketed within a longer sum."""
_SAVED = 4
"""Operations that a bracket with a factor of one term must save; one that is a product of sums need only be shorter."""


def with_common_factors(expression: sp.Expr) -> sp.Expr:
    """Return a form with common factors taken out of radicands and denominators, and cancelled in quotients.

    The value is the same for all real symbols: a square root of a product stays the root of the product, except that
    sympy takes out of it what is known not to be negative.

    Args:
        expression: of a form.
    """
    if not expression.args:
        return expression
    made = expression.func(*map(with_common_factors, expression.args))
    if made.is_Pow and made.exp.is_Rational and (made.base.is_Add or _holds_a_sum(made)):
        return _power(made)
    return _quotient(made) if made.is_Mul else made


def _holds_a_sum(power: sp.Pow) -> bool:
    """Return whether a radicand is a product with a sum in it: √((a m + b m)/w²) is √((a + b) m/w²)."""
    return bool(power.base.is_Mul and not power.exp.is_Integer and any(f.is_Add for f in power.base.args))


@lru_cache(maxsize=4096)
def _power(power: sp.Pow) -> sp.Expr:
    if longer_than(power.base, LONGEST) or elliptic(power.base):  # K − E is written so that nothing cancels
        return power
    # E L² k⁻² m⁻¹ + ½ under a root is written (2 E L² + k² m)/…: read off at once whether it is positive
    sums = [grouped(power.base)] if power.base.is_Add else []
    base = _shortest(power.base, *sums, _in_groups(factored(power.base)))
    content, rest = base.primitive() if base is power.base and base.is_Add else base.as_coeff_Mul()
    if content < 0:  # −2(a − b) is 2(b − a)
        content, rest = -content, _turned(rest)
    if rest is sp.S.NaN or (base is power.base and content == 1):
        return power
    made = content**power.exp * rest**power.exp
    return min(made, power, key=lambda e: sp.count_ops(e) + operations(e))  # sympy does not count a quotient twice


@lru_cache(maxsize=4096)
def _quotient(product: sp.Mul) -> sp.Expr:
    """Return a product with what its numerator and its denominator have in common cancelled, if that saves a fourth."""
    product = _shortest(product, _in_groups(product))
    # arcs and the like are kept out: their length says nothing of what is saved
    whole = [f for f in product.args if _rational(f) and not elliptic(f)]
    sums = [f.as_base_exp() for f in whole if f.as_base_exp()[0].is_Add]
    rational = sp.Mul(*whole)
    # one sum has nothing to cancel with, and without a denominator nothing cancels at all
    if len(sums) < 2 or all(power > 0 for _, power in sums) or longer_than(rational, LONGEST):
        return product
    made = _in_groups(sp.factor(rational))
    if 4 * operations(made) > 3 * operations(rational):
        return product
    return made * sp.Mul(*(f for f in product.args if f not in whole))


def _rational(factor: sp.Expr) -> bool:
    """Return whether a factor is a whole power of a sum, a symbol or a number."""
    base, power = factor.as_base_exp()
    return bool(power.is_Integer and not base.is_Function)


def _in_groups(product: sp.Expr) -> sp.Expr:
    """Return a factored expression with the sums among its factors grouped."""
    factors = [f.as_base_exp() for f in sp.Mul.make_args(product)]
    sums = [grouped(base) if base.is_Add else base for base, _ in factors]
    if all(made is base for made, (base, _) in zip(sums, factors, strict=True)):
        return product
    return sp.Mul(*(made**power for made, (_, power) in zip(sums, factors, strict=True)))


def grouped(total: sp.Expr) -> sp.Expr:
    """Return a sum with the terms of one power of a symbol as a product, by the symbol that makes it shortest.

    Args:
        total: the sum.
    """
    if len(total.args) <= _TERMS or elliptic(total) or longer_than(total, LONGEST):
        return total
    symbols = sorted(total.free_symbols, key=sp.default_sort_key)
    return _shortest(total, *(sp.Add(*_brackets(total, s)) for s in symbols))


def _brackets(total: sp.Expr, symbol: sp.Symbol) -> Iterator[sp.Expr]:
    powers = dict[sp.Expr, list[sp.Expr]]()
    for term in total.args:
        powers.setdefault(term.as_powers_dict().get(symbol, sp.S.Zero), []).append(term)
    for terms in powers.values():
        yield _bracket(sp.Add(*terms)) if _TERMS <= len(terms) < len(total.args) else sp.Add(*terms)


@lru_cache(maxsize=4096)
def _bracket(part: sp.Expr) -> sp.Expr:
    """Return a sum as a product, where that is much shorter or its factors are sums; a minus sign moves inside."""
    if longer_than(part, LONGEST_PART):
        return part
    made = factored(part)
    sums = [f for f in sp.Mul.make_args(made) if f.as_base_exp()[0].is_Add and f.as_base_exp()[1].is_Integer]
    saved = operations(part) - operations(made)
    if saved < 1 or not sums or not (saved >= _SAVED or len(sums) > 1 or sums[0].is_Pow):
        return part
    # −(a − b)(c − d) is (b − a)(c − d): the minus sign goes where it makes one fewer
    odd = next((f for f in sums if f.is_Add and _mostly_negative(f)), None)
    if odd is not None and made.as_coeff_Mul()[0] < 0:
        turned = sp.Add(*(-term for term in odd.args))
        return sp.Mul(-1, *(turned if f is odd else f for f in sp.Mul.make_args(made)))
    return made


def _turned(product: sp.Expr) -> sp.Expr:
    """Return a product with the minus sign in a difference among its factors; nan where it has none."""
    factors = sp.Mul.make_args(product)
    sums = [f for f in factors if f.is_Add and any(term.could_extract_minus_sign() for term in f.args)]
    if not sums:
        return sp.S.NaN
    odd = max(sums, key=lambda f: (sum(term.could_extract_minus_sign() for term in f.args), sp.default_sort_key(f)))
    return sp.Mul(*(sp.Add(*(-term for term in odd.args)) if f is odd else f for f in factors))


def _mostly_negative(total: sp.Expr) -> bool:
    return 2 * sum(term.could_extract_minus_sign() for term in total.args) >= len(total.args)


def _shortest(first: sp.Expr, *others: sp.Expr) -> sp.Expr:
    """Return what has the fewest operations, the first where none has fewer."""
    return min((first, *others), key=operations)
