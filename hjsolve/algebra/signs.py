"""Signs that hold on the whole domain, proved by rational interval arithmetic over the ranges of the generators.

Weak: an unknown sign is a common answer. What it does say is a proof, up to the boundary of the domain (≥ 0, not > 0).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.poly import Poly

if TYPE_CHECKING:
    from hjsolve.algebra.field import Field

Bounds = tuple[sp.Expr | None, sp.Expr | None]
Range = tuple[Fraction | None, Fraction | None]
ANYTHING: Range = (None, None)


def atom_bounds(atom: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> Range:
    """Return the bounds of an atom on the domain; None where there is none.

    Args:
        atom: a symbol, or a function of symbols.
        bounds: symbol → (lower, upper) end of its open interval.
    """
    if isinstance(atom, sp.Symbol):
        lower, upper = bounds.get(atom, (None, None))
        low, high = _rational_below(lower), _rational_above(upper)
        if atom.is_nonnegative and (low is None or low < 0):
            low = Fraction(0)
        if atom.is_nonpositive and (high is None or high > 0):
            high = Fraction(0)
        return low, high
    if isinstance(atom, (sp.sin, sp.cos)):
        return _circular(atom, bounds)
    if isinstance(atom, sp.cosh):
        return Fraction(1), None
    if isinstance(atom, sp.sinh):
        return _sign_range(atom.args[0], bounds)
    if atom.is_nonnegative:
        return Fraction(0), None
    return ANYTHING


def _circular(atom: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> Range:
    """Sin and cos of one bounded coordinate times a number, on the quarter turns where their sign is known."""
    coefficient, symbol = atom.args[0].as_coeff_Mul()
    lower, upper = bounds.get(symbol, (None, None)) if isinstance(symbol, sp.Symbol) else (None, None)
    whole: Range = (Fraction(-1), Fraction(1))
    if lower is None or upper is None or not coefficient.is_positive:
        return whole
    ends = [sp.expand(coefficient * end / sp.pi) for end in (lower, upper)]
    if not all(end.is_Rational for end in ends):
        return whole
    shift = Fraction(0) if isinstance(atom, sp.sin) else Fraction(1, 2)
    a, b = (Fraction(int(end.p), int(end.q)) + shift for end in ends)
    half_turn = a.__floor__()
    if b > half_turn + 1:
        return whole
    return (Fraction(0), Fraction(1)) if half_turn % 2 == 0 else (Fraction(-1), Fraction(0))


def _sign_range(x: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> Range:
    coefficient, symbol = x.as_coeff_Mul()
    low, high = atom_bounds(symbol, bounds) if isinstance(symbol, sp.Symbol) else ANYTHING
    if coefficient.is_negative:
        low, high = (None if high is None else -high), (None if low is None else -low)
    return (Fraction(0) if low is not None and low >= 0 else None), (
        Fraction(0) if high is not None and high <= 0 else None
    )


def _rational_below(x: sp.Expr | None) -> Fraction | None:
    """Return a rational number not above x, None when x is not a number."""
    if x is None or not x.is_number:
        return Fraction(0) if x is not None and x.is_nonnegative else None
    if x.is_Rational:
        return Fraction(int(x.p), int(x.q))
    return Fraction(int(sp.floor(x * 1024)), 1024)


def _rational_above(x: sp.Expr | None) -> Fraction | None:
    below = _rational_below(None if x is None else -x)
    return None if below is None else -below


def sign_of(field: Field, a: Poly, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """+1 where a ≥ 0 on the whole domain is proved, −1 where a ≤ 0 is, else 0.

    Args:
        field: of the polynomial.
        bounds: symbol → (lower, upper) end of its open interval.
    """
    low, high = _range_of(field, a)
    if low is not None and low >= 0:
        return 1
    if high is not None and high <= 0:
        return -1
    return _sign_after_shift(field, a, bounds)


def _sign_after_shift(field: Field, a: Poly, bounds: Mapping[sp.Symbol, Bounds]) -> int:
    """Sign of a after q = lower + t or q = upper − t (t ≥ 0) in each coordinate: all terms of one sign is a proof."""
    for k in poly.generators(a):
        symbol = field.generators[k].atom
        for end, side in zip(bounds.get(symbol, (None, None)), (1, -1), strict=True):
            shift = None if end is None else _as_poly(field, end)
            if shift is None or poly.exponent(poly.support(shift), k):
                continue
            shifted = _substitute(field, a, k, poly.add(shift, poly.variable(k), side))
            low, high = _range_of(field, shifted, positive=k)
            if low is not None and low >= 0:
                return 1
            if high is not None and high <= 0:
                return -1
    return 0


def _as_poly(field: Field, end: sp.Expr) -> Poly | None:
    """Return an end that is an integer or ± a symbol of the field, as a polynomial."""
    c, symbol = end.as_coeff_Mul()
    if end.is_Integer:
        return poly.constant(int(end))
    k = field.number_of(symbol)
    return None if k is None or not c.is_Integer else poly.scale(poly.variable(k), int(c))


def _substitute(field: Field, a: Poly, k: int, value: Poly) -> Poly:
    total: Poly = {}
    for m, c in a.items():
        e = poly.exponent(m, k)
        term: Poly = {m - (e << (poly.BITS * k)): c}
        for _ in range(e):
            term = poly.mul(term, value, field.budget)
        total = poly.add(total, term)
    return total


def _range_of(field: Field, a: Poly, positive: int | None = None) -> Range:
    """Interval extension of a polynomial over the ranges of its generators."""
    total: Range = (Fraction(0), Fraction(0))
    for m, c in a.items():
        term: Range = (Fraction(c), Fraction(c))
        for k, e in poly.exponents(m):
            g = field.generators[k]
            base: Range = (Fraction(0), None) if k == positive else (g.low, g.high)
            term = _times(term, _power(base, e))
        total = _plus(total[0], term[0]), _plus(total[1], term[1])
        if total == ANYTHING:
            break
    return total


def _plus(a: Fraction | None, b: Fraction | None) -> Fraction | None:
    return None if a is None or b is None else a + b


def _power(x: Range, n: int) -> Range:
    low, high = x
    if n % 2 == 0:
        if low is not None and low >= 0:
            return low**n, None if high is None else high**n
        if high is not None and high <= 0:
            return high**n, None if low is None else low**n
        return Fraction(0), None if low is None or high is None else max(-low, high) ** n
    return None if low is None else low**n, None if high is None else high**n


def _times(x: Range, y: Range) -> Range:
    """Product of two ranges with infinite ends; 0·∞ is 0, as it is for ends of ranges."""
    finite, infinite = list[Fraction](), set[int]()
    for i, a in enumerate(x):
        for j, b in enumerate(y):
            if a is not None and b is not None:
                finite.append(a * b)
            elif sign := _sign_of_end(a, i) * _sign_of_end(b, j):
                infinite.add(sign)
            else:
                finite.append(Fraction(0))
    low = None if -1 in infinite else min(finite, default=Fraction(0))
    high = None if 1 in infinite else max(finite, default=Fraction(0))
    return low, high


def _sign_of_end(end: Fraction | None, upper: int) -> int:
    """Return the sign of an end of a range; None is +∞ at the upper end and −∞ at the lower one."""
    if end is None:
        return 1 if upper else -1
    return (end > 0) - (end < 0)
