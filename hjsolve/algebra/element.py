"""An element of the field of functions, and the generators it is made of; see ``algebra.field``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Protocol

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.poly import Poly


@dataclass(frozen=True)
class RootRelation:
    """Relation of a generator g: g^order = radicand, the radicand free of g and later generators."""

    order: int
    radicand: Poly


@dataclass(frozen=True)
class Generator:
    """One generator of the field.

    Attributes:
        atom: the sympy expression it stands for.
        kind: symbol, cos, sin, cosh, sinh, root or other (taken as independent).
        root: the relation it obeys, or None.
        partner: number of the cosine that goes with a sine (cosh with sinh), else None.
        low, high: bounds of its value on the domain; None is infinite.
    """

    atom: sp.Expr
    kind: str
    root: RootRelation | None = None
    partner: int | None = None
    low: Fraction | None = None
    high: Fraction | None = None


class ElementArithmetic(Protocol):
    """What an element asks of the field that it belongs to; ``field.Field`` is it.

    Attributes:
        bases: polynomials that are factors of elements, by number.
        generators: by number.
    """

    bases: list[Poly]
    generators: list[Generator]

    def coerce(self, value: Element | int | Fraction) -> Element:
        """Read a number as an element."""

    def total(self, elements: Sequence[Element]) -> Element:
        """Sum."""

    def product(self, elements: Sequence[Element]) -> Element:
        """Product."""

    def power(self, x: Element, n: int) -> Element:
        """xⁿ."""


@dataclass(frozen=True, eq=False)
class Element:
    """An element of a ``Field``; made by a reader, by the field and by arithmetic."""

    field: ElementArithmetic
    coefficient: Fraction
    numerator: Poly
    factors: dict[int, int]

    @property
    def is_zero(self) -> bool:
        """Whether the numerator reduces to zero: a proof that this is the zero function."""
        return not self.numerator

    def __add__(self, other: Element | int | Fraction) -> Element:
        return self.field.total([self, self.field.coerce(other)])

    def __neg__(self) -> Element:
        return Element(self.field, -self.coefficient, self.numerator, self.factors)

    def __sub__(self, other: Element | int | Fraction) -> Element:
        return self.field.total([self, -self.field.coerce(other)])

    def __mul__(self, other: Element | int | Fraction) -> Element:
        return self.field.product([self, self.field.coerce(other)])

    __radd__ = __add__
    __rmul__ = __mul__

    def __truediv__(self, other: Element | int | Fraction) -> Element:
        return self.field.product([self, self.field.coerce(other) ** -1])

    def __pow__(self, n: int) -> Element:
        return self.field.power(self, n)

    @cached_property
    def bases(self) -> list[tuple[Poly, int]]:
        """Base polynomials with their exponents."""
        return [(self.field.bases[b], e) for b, e in self.factors.items()]

    @cached_property
    def generators(self) -> frozenset[int]:
        """Numbers of the generators that occur."""
        seen = poly.support(self.numerator)
        for base, _ in self.bases:
            seen |= poly.support(base)
        return frozenset(k for k, _ in poly.exponents(seen))

    def depends_on(self, symbol: sp.Symbol) -> bool:
        """Return whether the symbol occurs in any generator present.

        Args:
            symbol: a coordinate or parameter.
        """
        return any(symbol in self.field.generators[k].atom.free_symbols for k in self.generators)
