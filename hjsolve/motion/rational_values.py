"""Formulas at rational places by fractions alone: what sympy's substitution gives, in a tenth of the time.

Decimals and floats are rational, and so are momenta and constants of most motions that start from them. Where a value
is not (sin 0.3), nothing is guessed: the caller is told so and asks sympy.

Tapes run in fractions, exactly, as long as everything stays one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import sympy as sp

from hjsolve.arithmetic.floats import ByOperators
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import lower

_AT_ZERO = {
    **dict.fromkeys(("sin", "tan", "asin", "atan", "sinh", "tanh", "asinh", "atanh"), Fraction(0)),
    **dict.fromkeys(("cos", "cosh", "sech", "exp"), Fraction(1)),
}


class IrrationalError(ArithmeticError):
    """A value that is not a fraction, or not seen to be one."""


@dataclass(frozen=True, slots=True)
class Rationals(ByOperators):
    """Exact arithmetic with fractions.

    Raises:
        IrrationalError: a value is not a fraction, or not seen to be one.
        ZeroDivisionError: a division by zero.
    """

    def rational(self, numerator: int, denominator: int) -> Fraction:
        """Return a fraction."""
        return Fraction(numerator, denominator)

    def pi(self) -> Fraction:
        """Refuse π, which is not a fraction.

        Raises:
            IrrationalError: always.
        """
        raise IrrationalError

    def power(self, x: Fraction, n: int) -> Fraction:
        """Return xⁿ."""
        return x**n

    def unary(self, name: str, x: Fraction) -> Fraction:
        """Return a function of one variable where its value is seen to be a fraction.

        Raises:
            IrrationalError: the value is not a fraction, or not seen to be one.
        """
        if name == "neg":
            return -x
        if name == "abs":
            return abs(x)
        if name == "sqrt" and x >= 0:
            root = Fraction(math.isqrt(x.numerator), math.isqrt(x.denominator))
            if root * root == x:
                return root
        if not x and name in _AT_ZERO:
            return _AT_ZERO[name]
        raise IrrationalError


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
