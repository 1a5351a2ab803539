"""Enclosing what is made of jets of field elements at a rational point: no derivative is written down.

The exact twin of ``algebra.modular``: the generators are enclosed as the real functions they stand for, so that an
enclosure that excludes zero proves that a condition does not hold, however large it would be when written out. A shell
with thousands of terms has a condition with millions; its value at a point costs no more than a few evaluations of the
shell.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

import mpmath
import sympy as sp
from mpmath.ctx_iv import MPIntervalContext

from hjsolve.algebra.element_jets import ElementJet, ElementJets
from hjsolve.algebra.element_point import ElementPoint, Value
from hjsolve.algebra.field import Element, Field
from hjsolve.algebra.intervals import NoEnclosureError, Walk, finite, rational
from hjsolve.algebra.reader import Reader
from hjsolve.separation.zero_test.interval_evaluation import Region, Witness, search

Condition = Callable[[ElementJets, Sequence[ElementJet]], Value]
"""What may not vanish, of jets of some elements."""


def find_witness_by_jets(
    reader: Reader, symbols: Sequence[sp.Symbol], elements: Sequence[Element], condition: Condition, region: Region
) -> Witness | None:
    """Search rational points of the region for one where a condition is enclosed away from zero.

    Args:
        reader: differentiates the generators.
        symbols: what is differentiated by.
        elements: what the condition is of.
        condition: of their jets.
        region: where the points are taken from.
    """
    held = _with_derivatives(reader, symbols, elements)
    atoms = sp.Tuple(*(reader.field.generators[k].atom for k in sorted(held)))

    def enclosure(point: Mapping[sp.Expr, sp.Rational], precision: int) -> tuple[mpmath.mpf, mpmath.mpf]:
        place = IntervalPoint(reader.field, point, precision)
        jets = ElementJets(reader, symbols, place)
        return finite(lambda: place.numbers.mpf(condition(jets, [jets.element(x) for x in elements]))._mpi_)

    return search(enclosure, region.points(atoms), reader.field.budget)


def _with_derivatives(reader: Reader, symbols: Sequence[sp.Symbol], elements: Sequence[Element]) -> set[int]:
    """Return the generators of elements and of their first and second derivatives."""
    new = held = {k for x in elements for k in x.generators}
    for _ in range(2):
        new = {l for k in new for q in symbols for l in reader.generator_diff(k, q).generators}
        held = held | new
    return held


class IntervalPoint(ElementPoint):
    """A rational point; values are enclosures.

    Args:
        field: the field of the elements.
        point: symbol, or function left undetermined, → rational value.
        precision: in bits.
    """

    def __init__(self, field: Field, point: Mapping[sp.Expr, sp.Rational], precision: int):
        super().__init__(field)
        self.walk, self.numbers = Walk(point, precision), _intervals(precision)

    def value(self, k: int) -> Value:
        """Return the value of generator k.

        Raises:
            NoEnclosureError: it has no real value at this point.
        """
        return self.numbers.make_mpf(self.walk(self.field.generators[k].atom))

    def fraction(self, x: Fraction) -> Value:  # noqa: D102
        return self.numbers.make_mpf(rational(x.numerator, x.denominator, self.walk.precision))

    def raised(self, x: Value, n: int) -> Value:
        """Return xⁿ.

        Raises:
            NoEnclosureError: n is negative and x may be zero.
        """
        if n < 0 and 0 in x:
            raise NoEnclosureError("division by an interval that contains zero")
        return x**n

    def reduced(self, x: Value) -> Value:  # noqa: D102
        return x


@lru_cache
def _intervals(precision: int) -> MPIntervalContext:
    """Return intervals of mpmath with a precision of their own, which nothing changes."""
    context = MPIntervalContext()
    context.prec = precision
    return context
