"""Strict signs on an open domain, proved term by term: +1, −1, or 0 where nothing is proved."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.algebra.signs import Bounds


def strict_sign(x: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """Return the sign that an expression has everywhere on an open domain, 0 where none is proved.

    Args:
        x: real expression.
        bounds: symbol → (lower, upper) end of its open interval; None is infinite.
    """
    if x.is_positive:
        return 1
    if x.is_negative:
        return -1
    if isinstance(x, sp.Symbol):
        return _of_symbol(bounds.get(x, (None, None)))
    if isinstance(x, sp.Mul):
        return int(sp.prod(strict_sign(factor, bounds) for factor in x.args))
    if isinstance(x, sp.Pow):
        return _of_power(x, bounds)
    if isinstance(x, (sp.exp, sp.cosh)):
        return 1
    if isinstance(x, (sp.sinh, sp.tanh, sp.asinh, sp.atan)):
        return strict_sign(x.args[0], bounds)
    if isinstance(x, (sp.sin, sp.cos)):
        return _circular(x, bounds)
    if isinstance(x, sp.Add):
        return _of_sum(x, bounds)
    return 0


def _of_symbol(ends: Bounds) -> int:
    lower, upper = ends
    if lower is not None and lower.is_nonnegative:
        return 1
    return -1 if upper is not None and upper.is_nonpositive else 0


def _of_power(x: sp.Pow, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    sign = strict_sign(x.base, bounds)
    if x.exp.is_odd or sign == 1:
        return sign
    return 1 if sign and x.exp.is_even else 0


def _circular(x: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """Sin or cos of a number times one coordinate whose interval is within one half turn of one sign."""
    coefficient, symbol = x.args[0].as_coeff_Mul()
    lower, upper = bounds.get(symbol, (None, None)) if isinstance(symbol, sp.Symbol) else (None, None)
    if lower is None or upper is None or not coefficient.is_positive:
        return 0
    shift = sp.S.Zero if isinstance(x, sp.sin) else sp.S.Half
    low, high = (sp.expand(coefficient * end / sp.pi) + shift for end in (lower, upper))
    if not (low.is_Rational and high.is_Rational):
        return 0
    turn = sp.floor(low)
    return 0 if high > turn + 1 else (1 if turn % 2 == 0 else -1)


def _of_sum(x: sp.Add, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """All terms of one sign, some of them perhaps zero; or one coordinate counted from an end of its interval."""
    for direct in (x, _from_ends(x, bounds)):
        terms = [(strict_sign(t, bounds), _square(t, bounds)) for t in sp.Add.make_args(direct)]
        for sign in (1, -1):
            if any(s == sign for s, _ in terms) and all(sign in (s, weak) for s, weak in terms):
                return sign
    return 0


def _from_ends(x: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> sp.Expr:
    """Return the sum with q = lower + s, s > 0, multiplied out."""
    moved = {
        q: low + sp.Dummy(q.name, positive=True)
        for q, (low, _) in bounds.items()
        if low is not None and low != 0 and q in x.free_symbols
    }
    return sp.expand(x.xreplace(moved)) if moved else x


def _square(term: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """Return the sign of a term that may vanish: a coefficient of one sign times even powers."""
    rest = [f for f in sp.Mul.make_args(term) if not (f.is_Pow and f.exp.is_even and f.exp.is_positive)]
    return strict_sign(sp.Mul(*rest), bounds)
