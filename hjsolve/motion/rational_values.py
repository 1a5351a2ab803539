"""Formulas at rational places by fractions alone: what sympy's substitution gives, in a tenth of the time.

Decimals and floats are rational, and so are momenta and constants of most motions that start from them. Where a value
is not (sin 0.3), nothing is guessed: the caller is told so and asks sympy.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache

import sympy as sp

from hjsolve.arithmetic.rationals import IrrationalError, Rationals
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import lower


def rational_value(formula: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Rational | None:
    """Return a formula at a place if all that occurs is rational, else None.

    Args:
        formula: in the symbols of ``values``.
        values: symbol → exact number.
    """
    symbols = _symbols(formula)
    numbers = [values[s] for s in symbols if s in values]
    if len(numbers) < len(symbols) or not all(x.is_Rational for x in numbers):
        return None
    try:
        found = _tape(formula, symbols).run(Rationals(), [Fraction(int(x.p), int(x.q)) for x in numbers])[0]
    except (IrrationalError, ZeroDivisionError, InvalidInputError):  # sympy knows more, or what to say
        return None
    return sp.Rational(found.numerator, found.denominator)


@lru_cache(maxsize=1024)
def _symbols(formula: sp.Expr) -> tuple[sp.Symbol, ...]:
    return tuple(sorted(formula.free_symbols, key=str))


@lru_cache(maxsize=1024)
def _tape(formula: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> Tape:
    return lower([formula], symbols)
