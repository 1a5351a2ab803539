"""Logarithms in a field, with all their relations log(ab) = log a + log b.

Wherever log y is defined it is Σ e log|b| over the factors b^e of y, whatever their signs. So every logarithm is a
vector of exponents, over prime numbers and base polynomials; roots count by their fractions, exponentials by their
exponents. One that depends linearly on those before is written in them, the others are generators.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element, Generator
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reading import FieldReader
from hjsolve.algebra.signs import atom_bounds

MAX_FACTORED = 10**15
Key = tuple[str, int]
Vector = dict[Key, Fraction]


@dataclass(frozen=True)
class _Row:
    """A logarithm in echelon form: its exponents, the first of which is 1, and its value as an element."""

    pivot: Key
    vector: Vector
    value: Element


class Logarithms:
    """The logarithms of one reader."""

    def __init__(self, reader: FieldReader):
        self.reader = reader
        self._rows: list[_Row] = []

    def of(self, atom: sp.Expr, y: Element) -> Element:
        """Return the logarithm of y, which is written ``atom`` where it is a new generator.

        Args:
            atom: the expression a generator stands for.
            y: an element, positive on the domain.
        """
        vector, exponent = self._vector(y)
        value = exponent
        for row in self._rows:
            if c := vector.get(row.pivot):
                vector = _combined(vector, row.vector, -c)
                value = value + row.value * c
        if not vector:
            return value
        low, high = atom_bounds(atom, self.reader.bounds)
        own = self.reader.adjoined(Generator(atom, "other", low=low, high=high))
        pivot = min(vector)
        c = vector[pivot]
        new = _Row(pivot, {key: e / c for key, e in vector.items()}, (own - value) * (1 / c))
        self._rows.append(new)
        return own

    def _vector(self, y: Element) -> tuple[Vector, Element]:
        """Return the exponents of y, and what the exponentials among its factors add."""
        field, vector = self.reader.field, Vector()
        exponent = field.zero
        for n, sign in ((y.coefficient.numerator, 1), (y.coefficient.denominator, -1)):
            factors = sp.factorint(abs(n)) if abs(n) < MAX_FACTORED else {abs(n): 1}
            for prime, e in factors.items():
                if prime != 1:
                    _add(vector, ("number", int(prime)), Fraction(sign * e))
        y = field.factored(y)
        for b, e in y.factors.items():
            exponent = exponent + self._add_base(vector, b, Fraction(e))
        return {key: e for key, e in vector.items() if e}, exponent

    def _add_base(self, vector: Vector, b: int, e: Fraction) -> Element:
        """Add a base polynomial to the vector, or give the exponent of one that is an exponential."""
        field = self.reader.field
        base: Poly = field.bases[b]
        if len(base) == 1:
            k = poly.generators(base)[0]
            g = field.generators[k]
            if isinstance(g.atom, sp.exp):
                return self.reader.element(g.atom.args[0]) * e
            if g.kind == "root" and g.root is not None:
                inner, exponent = self._vector(field.from_poly(g.root.radicand))
                for key, power in inner.items():
                    _add(vector, key, power * e / g.root.order)
                return exponent * (e / g.root.order)
        _add(vector, ("base", b), e)
        return field.zero


def _add(vector: Vector, key: Key, e: Fraction) -> None:
    vector[key] = vector.get(key, Fraction(0)) + e


def _combined(a: Vector, b: Vector, c: Fraction) -> Vector:
    keys = {*a, *b}
    found = {key: a.get(key, Fraction(0)) + c * b.get(key, Fraction(0)) for key in keys}
    return {key: e for key, e in found.items() if e}
