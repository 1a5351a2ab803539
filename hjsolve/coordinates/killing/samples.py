"""The derivatives of a potential at random regular points, exactly; the same for every family of tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from random import Random

import sympy as sp

from hjsolve.algebra.shared_parts import derivatives
from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.constant_field import FieldElement, Ground
from hjsolve.coordinates.killing.radical_algebra import (
    Element,
    Generators,
    PointAlgebra,
    ZeroDivisorError,
    collected_generators,
    prepared,
)
from hjsolve.errors import InternalError

_MOST_POINTS = 200


class Samples:
    """The derivatives of V at one random regular point after another, worked out when they are first asked for.

    Attributes:
        values: the derivatives, prepared.
        made_of: what they are made of.
    """

    def __init__(self, values: Sequence[sp.Expr], made_of: Generators):
        self.values, self.made_of = values, made_of
        self._random, self._left = Random(20161), _MOST_POINTS  # noqa: S311
        self._known: list[tuple[list[FieldElement], list[Element]]] = []

    def with_constants(self, ground: Ground) -> Samples:
        """Return samples at the same points, with constants in another field.

        Args:
            ground: the field, or values of the letters.
        """
        return Samples(self.values, replace(self.made_of, ground=ground))

    def at(self, k: int) -> tuple[list[FieldElement], list[Element]]:
        """Return the k-th point, in numbers of the field of constants, and the derivatives there.

        Raises:
            InternalError: there are no regular points.
        """
        while len(self._known) <= k:
            if not self._left:
                raise InternalError("find_coordinates: no regular points of the potential were found")
            check_time()
            self._left -= 1
            algebra = PointAlgebra(self.made_of, self._random)
            try:
                elements = [algebra.evaluate(value) for value in self.values]
            except (ZeroDivisorError, ZeroDivisionError):
                continue
            numbers = self.made_of.ground.numbers
            self._known.append(([numbers.convert(value) for value in algebra.plain.values()], elements))
        return self._known[k]


@lru_cache(maxsize=8)
def samples_of(V: sp.Expr, x: tuple[sp.Symbol, ...]) -> Samples:
    """Return the samples of a potential, the same for every family of tensors.

    Args:
        V: potential V(x).
        x: Cartesian coordinates.
    """
    values = prepared(derivatives(V, x), x)
    return Samples(values, collected_generators(values, x))
