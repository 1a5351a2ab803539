"""How fast something grows towards infinity: monomials in e^{λs}, s and log s, and what is left next to them."""

from __future__ import annotations

import math
from typing import NamedTuple

from hjsolve.arithmetic.number_types import Mpf

WIDENING = 2.0**-40
"""What bounds in doubles are widened by, relatively: far more than the rounding of all that is done with one."""


class UnknownGrowthError(Exception):
    """Nothing is known of a formula for all s ≥ Q."""


class Monomial(NamedTuple):
    """e^{λs} sᵏ (log s)ᵐ; greater is what grows faster."""

    rate: float | Mpf
    power: float | Mpf
    logs: float | Mpf

    def times(self, other: Monomial, n: float = 1.0) -> Monomial:
        """Return self·otherⁿ.

        Args:
            n: exponent.
        """
        return Monomial(*(a + n * b for a, b in zip(self, other, strict=True)))


CONSTANT = Monomial(0.0, 0.0, 0.0)


class Remainder(NamedTuple):
    """The remainder: a monomial and what it is multiplied by."""

    monomial: Monomial
    low: float
    high: float

    @property
    def size(self) -> float:
        return max(abs(self.low), abs(self.high))

    def times(self, other: Remainder) -> Remainder:
        """Return the product.

        Raises:
            UnknownGrowthError: the product is beyond doubles.
        """
        ends = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return widened(self.monomial.times(other.monomial), min(ends), max(ends))


class Growth(NamedTuple):
    """Terms, the fastest first, and the remainder."""

    terms: tuple[tuple[Monomial, Mpf], ...]
    rest: Remainder | None = None

    @property
    def fastest(self) -> Monomial:
        """The greatest monomial; there is one unless it is exactly zero."""
        return max([m for m, _ in self.terms[:1]] + ([self.rest.monomial] if self.rest else []))


def widened(monomial: Monomial, low: float, high: float) -> Remainder:
    """Return a remainder, widened by rounding.

    Args:
        monomial: how fast it grows.
        low, high: what the monomial is multiplied by.

    Raises:
        UnknownGrowthError: an end is not finite.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        raise UnknownGrowthError
    widening = WIDENING * max(abs(low), abs(high)) + 1e-300
    return Remainder(monomial, low - widening, high + widening)
