"""Tapes run in fractions, exactly, as long as everything stays one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from hjsolve.arithmetic.floats import ByOperators

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
