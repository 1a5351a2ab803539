"""Evaluating elements at random points modulo a prime: a filter in front of exact expansion.

The image of the field under such a point respects all relations, so a value that is not 0 shows that a numerator does
not reduce to zero. A value 0 shows nothing, but is right with probability 1 − degree/prime for random points
(Schwartz 1980; Zippel 1979); the exact normal form then gives the proof.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import gcd

from hjsolve.algebra.element_point import ElementPoint
from hjsolve.algebra.field import Element, Field

_BELOW = (45, 465, 1281, 1425, 1533, 1845, 1869, 2133, 2373, 2385, 3045, 3069, 3081, 3105, 3153, 3441)
PRIMES = tuple(2**61 - k for k in _BELOW)  # all ≡ 11 modulo 12: square and cube roots are powers
ATTEMPTS = 200

Products = Sequence[Sequence[Sequence[Element]]]  # Σ Π Σ of elements


class NoRootError(ArithmeticError):
    """A radicand has no root modulo the prime at this point; try another point."""


class ModularPoint(ElementPoint):
    """Values of all generators modulo a prime; those of new generators are drawn when asked for."""

    def __init__(self, field: Field, seed: int = 0):
        super().__init__(field)
        self.prime = PRIMES[seed % len(PRIMES)]
        self._random = random.Random(7919 * seed + 17)  # noqa: S311
        self._values: dict[int, int] = {}

    def value(self, k: int) -> int:
        """Return the value of generator k."""
        if k not in self._values:
            self._draw(k)
        return self._values[k]

    def _draw(self, k: int) -> None:
        p, g = self.prime, self.field.generators[k]
        if g.kind in ("cos", "cosh"):
            t = self._random.randrange(2, p - 1)
            sign = 1 if g.kind == "cos" else -1
            scale = pow(1 + sign * t * t, -1, p)
            self._values[k] = (1 - sign * t * t) * scale % p
            for other, h in enumerate(self.field.generators):
                if h.partner == k:
                    self._values[other] = 2 * t * scale % p
        elif g.partner is not None:
            self._draw(g.partner)
        elif g.root is not None:
            self._values[k] = self._root(self.poly(g.root.radicand), g.root.order)
        else:
            self._values[k] = self._random.randrange(2, p - 1)

    def _root(self, x: int, q: int) -> int:
        """Return a q-th root modulo the prime.

        Raises:
            NoRootError: there is none.
        """
        p, n, order = self.prime, 1, q
        while order % 2 == 0:
            order //= 2
            n = n * ((p + 1) // 4) % (p - 1)
        if gcd(order, p - 1) != 1:
            raise NoRootError
        root = pow(x, n * pow(order, -1, p - 1) % (p - 1), p)
        if pow(root, q, p) != x % p:
            raise NoRootError
        return root

    def fraction(self, x: Fraction) -> int:  # noqa: D102
        return x.numerator * self.raised(x.denominator, -1) % self.prime

    def raised(self, x: int, n: int) -> int:
        """Return xⁿ.

        Raises:
            ZeroDivisionError: n is negative and x is zero modulo the prime.
        """
        if n < 0 and not x % self.prime:
            raise ZeroDivisionError("a denominator vanishes modulo the prime")
        return pow(x, n, self.prime)

    def reduced(self, x: int) -> int:  # noqa: D102
        return x % self.prime


class Filter:
    """A few points modulo primes, kept, with the values of elements there; one filter serves many questions.

    Args:
        field: the field of the elements.
        points: how many points must agree.
    """

    def __init__(self, field: Field, points: int = 2):
        self.field, self.points = field, points
        self._places: list[tuple[ModularPoint, dict[int, tuple[Element, int]]]] = []
        self._seed = 0

    def vanishes(self, products: Products) -> bool | None:
        """Return whether Σ Π Σ of the elements given vanishes at the points; None when no point could be found."""
        good = place = 0
        while good < self.points:
            if place == len(self._places):
                if self._seed == ATTEMPTS:
                    return None
                self._places.append((ModularPoint(self.field, self._seed), {}))
                self._seed += 1
            total = self._total(products, place)
            if total is None:
                del self._places[place]
                continue
            if total:
                return False
            good, place = good + 1, place + 1
        return True

    def _total(self, products: Products, place: int) -> int | None:
        """Return the value of the sum at one of the points; None where a root or a denominator fails there."""
        point, known = self._places[place]
        try:
            total = 0
            for factors in products:
                term = 1
                for elements in factors:
                    for x in elements:
                        if id(x) not in known:
                            known[id(x)] = x, point.element(x)
                    term = term * sum(known[id(x)][1] for x in elements) % point.prime
                total += term
        except (NoRootError, ZeroDivisionError):
            return None
        return total % point.prime


def products_vanish(field: Field, products: Iterable[Iterable[Element]]) -> bool | None:
    """Whether Σ Π of the elements given vanishes at random points modulo primes; None when no point could be found.

    Args:
        products: Σ Π of elements.
    """
    return Filter(field).vanishes([[[x] for x in factors] for factors in products])
