"""The last attempt to prove an expression zero: as a constant, or coefficient by coefficient in one of its variables.

The normal form of ``Field`` knows the relations of its generators, but not all relations between roots, logarithms and
inverse functions on a domain. What it leaves is a polynomial in generators; where the coefficients of all monomials
without one of the variables vanish as functions of that variable alone (``one_variable``), all of it does.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.algebra import poly
from hjsolve.algebra.constants import constant_is_zero
from hjsolve.algebra.elementary import at_one_place
from hjsolve.algebra.field import Element
from hjsolve.algebra.one_variable import vanishes
from hjsolve.algebra.poly import Budget, Poly, WorkLimitError
from hjsolve.algebra.reader import Reader
from hjsolve.algebra.signs import Bounds

SECONDS = 10.0
MAX_COEFFICIENTS = 12
BoundsOf = Mapping[sp.Symbol, Bounds]


def proved_zero(x: sp.Expr, bounds: BoundsOf, budget: Budget) -> bool:
    """Return a proof that an expression is zero wherever it is defined; False is not a proof of anything.

    Args:
        bounds: symbol → (lower, upper) end of its open interval.
        budget: of the exact computation.
    """
    own = budget.part(SECONDS, budget.terms)
    try:
        if x.has(AppliedUndef, sp.Derivative, sp.Subs, sp.Integral):
            return False
        symbols = sorted(x.free_symbols, key=str)
        if len(symbols) <= 1:
            return _function_vanishes(x, symbols, bounds, own)
        reader = Reader([x], bounds, own)
        return element_vanishes(reader, reader.element(x), own)
    except (WorkLimitError, ZeroDivisionError):
        return False


def element_vanishes(reader: Reader, x: Element, budget: Budget) -> bool:
    """Return a proof that an element of a field is zero wherever it is defined; False is not a proof of anything.

    Args:
        reader: of the field; it knows the domain.
        x: the element.
        budget: of the exact computation.

    Raises:
        WorkLimitError: the budget is used up.
    """
    symbols = sorted({s for k in x.generators for s in reader.field.generators[k].atom.free_symbols}, key=str)
    return x.is_zero or any(_by_coefficients(reader, x.numerator, s, budget) for s in symbols)


def _by_coefficients(reader: Reader, a: Poly, symbol: sp.Symbol, budget: Budget) -> bool:
    """Return whether the coefficients of all monomials in generators of other variables vanish as functions of one."""
    generators = reader.field.generators
    groups: dict[int, Poly] = {}
    for m, c in a.items():
        other = sum(
            e << (poly.BITS * k) for k, e in poly.exponents(m) if not generators[k].atom.free_symbols <= {symbol}
        )
        groups.setdefault(other, {})[m - other] = c
    if len(groups) > MAX_COEFFICIENTS:
        return False
    return all(_function_vanishes(reader.write_poly(b), [symbol], reader.bounds, budget) for b in groups.values())


def _function_vanishes(x: sp.Expr, symbols: list[sp.Symbol], bounds: BoundsOf, budget: Budget) -> bool:
    if not x.free_symbols:
        return constant_is_zero(at_one_place(x)) is True
    (symbol,) = symbols
    ends = bounds.get(symbol, (None, None))
    if any(e is not None and e.free_symbols for e in ends):
        return False
    return vanishes(x, symbol, (_end(ends[0], symbol, lower=True), _end(ends[1], symbol, lower=False)), budget)


def _end(end: sp.Expr | None, symbol: sp.Symbol, *, lower: bool) -> sp.Expr | None:
    """Return the end of the interval, or 0 where the symbol's own assumption says so."""
    if end is None and (symbol.is_nonnegative if lower else symbol.is_nonpositive):
        return sp.S.Zero
    return end
