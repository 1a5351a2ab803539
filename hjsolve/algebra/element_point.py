"""Values of field elements at one point, in any kind of numbers: modulo a prime, or in intervals.

What a point is says how its generators get their values; polynomials and elements follow from those, nothing multiplied
out.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from fractions import Fraction
from typing import Any, TypeAlias

from hjsolve.algebra import poly
from hjsolve.algebra.element import Element
from hjsolve.algebra.field import Field
from hjsolve.algebra.poly import Poly

Value: TypeAlias = Any
"""A whole number, of which only the rest modulo a prime counts, or an interval of mpmath: both have + and ·."""


class ElementPoint(ABC):
    """A point; remembers the values of powers and of bases.

    Args:
        field: the field of the elements.
    """

    def __init__(self, field: Field):
        self.field = field
        self._bases: dict[int, Value] = {}
        self._powers: dict[tuple[int, int], Value] = {}

    @abstractmethod
    def value(self, k: int) -> Value:
        """Return the value of generator k."""

    @abstractmethod
    def fraction(self, x: Fraction) -> Value:
        """Return the value of a rational number."""

    @abstractmethod
    def raised(self, x: Value, n: int) -> Value:
        """Return xⁿ; an ``ArithmeticError`` where n is negative and x may be zero."""

    @abstractmethod
    def reduced(self, x: Value) -> Value:
        """Return the same number as short as it can be written."""

    def power(self, k: int, n: int) -> Value:
        """Return the value of a power of generator k."""
        if (k, n) not in self._powers:
            self._powers[k, n] = self.raised(self.value(k), n)
        return self._powers[k, n]

    def poly(self, a: Poly) -> Value:
        """Return the value of a polynomial."""
        total, powers = self.fraction(Fraction(0)), self._powers
        for m, c in a.items():
            for pair in poly.exponents(m):
                c = c * (powers[pair] if pair in powers else self.power(*pair))
            total = total + c
        return self.reduced(total)

    def base(self, b: int) -> Value:
        """Return the value of a base of the field's elements."""
        if b not in self._bases:
            self._bases[b] = self.poly(self.field.bases[b])
        return self._bases[b]

    def element(self, x: Element) -> Value:
        """Return the value of an element.

        Raises:
            ArithmeticError: a denominator vanishes at this point, or may vanish.
        """
        value = self.fraction(x.coefficient) * self.poly(x.numerator)
        for b, e in x.factors.items():
            value = self.reduced(value * self.raised(self.base(b), e))
        return self.reduced(value)
