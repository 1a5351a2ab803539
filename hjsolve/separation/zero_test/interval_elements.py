"""Enclosing Σ Π Σ of field elements at a rational point, nothing multiplied out and nothing differentiated again.

The exact twin of ``algebra.modular``: the generators are enclosed as the real functions they stand for, so that an
enclosure that excludes zero proves that the sum is not the zero function, however large it would be when written out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element, Field
from hjsolve.algebra.intervals import Interval, Walk, enclose_inverse, finite, rational
from hjsolve.algebra.modular import Products
from hjsolve.algebra.poly import Budget, Poly
from hjsolve.separation.zero_test.interval_evaluation import Region, Witness, search


def find_witness_of_products(field: Field, products: Products, region: Region, budget: Budget) -> Witness | None:
    """Search rational points of the region for one where Σ Π Σ of the elements is enclosed away from zero.

    Args:
        products: Σ Π Σ of elements.
        region: where the points are taken from.
    """
    used = {k for factors in products for terms in factors for x in terms for k in x.generators}
    atoms = sp.Tuple(*(field.generators[k].atom for k in sorted(used)))
    return search(partial(enclose_products, field, products), region.points(atoms), budget)


def enclose_products(
    field: Field, products: Products, point: Mapping[sp.Expr, sp.Rational], precision: int
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Lower and upper bound of Σ Π Σ of elements at a point.

    Args:
        products: Σ Π Σ of elements.
        point: symbol, or function left undetermined, → rational value.

    Raises:
        NoEnclosureError: a generator has no real value there, or a denominator may vanish.
    """
    return finite(lambda: _Values(field, point, precision).products(products))


class _Values:
    """One evaluation: remembers the values of generators, their powers and bases."""

    def __init__(self, field: Field, point: Mapping[sp.Expr, sp.Rational], precision: int):
        self.field, self.precision = field, precision
        self.walk = Walk(point, precision)
        self.powers: dict[tuple[int, int], Interval] = {}
        self.bases: dict[int, Interval] = {}
        self.elements: dict[int, Interval] = {}

    def products(self, products: Products) -> Interval:
        """Σ Π Σ."""
        return self._sum(
            self._product(self._sum(map(self.element, terms)) for terms in factors) for factors in products
        )

    def element(self, x: Element) -> Interval:
        """One element; the same object is evaluated once."""
        if id(x) not in self.elements:
            c = rational(x.coefficient.numerator, x.coefficient.denominator, self.precision)
            parts = [c, self._poly(x.numerator), *(self._base(b, e) for b, e in x.factors.items())]
            self.elements[id(x)] = self._product(parts)
        return self.elements[id(x)]

    def _base(self, b: int, e: int) -> Interval:
        if b not in self.bases:
            self.bases[b] = self._poly(self.field.bases[b])
        power = libmp.mpi_pow_int(self.bases[b], abs(e), self.precision)
        return enclose_inverse(power, self.precision) if e < 0 else power

    def _poly(self, a: Poly) -> Interval:
        return self._sum(
            self._product([rational(c, 1, self.precision), *map(self._power, poly.exponents(m))]) for m, c in a.items()
        )

    def _power(self, pair: tuple[int, int]) -> Interval:
        if pair not in self.powers:
            value = self.walk(self.field.generators[pair[0]].atom)
            self.powers[pair] = libmp.mpi_pow_int(value, pair[1], self.precision)
        return self.powers[pair]

    def _sum(self, terms: Iterable[Interval]) -> Interval:
        total = rational(0, 1, self.precision)
        for term in terms:
            total = libmp.mpi_add(total, term, self.precision)
        return total

    def _product(self, factors: Iterable[Interval]) -> Interval:
        total = rational(1, 1, self.precision)
        for factor in factors:
            total = libmp.mpi_mul(total, factor, self.precision)
        return total
