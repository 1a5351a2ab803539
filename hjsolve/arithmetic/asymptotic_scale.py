"""How fast something grows towards infinity: monomials in e^{λs}, s and log s, and what is left beside them."""

from __future__ import annotations

from typing import NamedTuple

from hjsolve.arithmetic.number_types import Mpf


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
            other: another one.
            n: exponent.
        """
        return Monomial(*(a + n * b for a, b in zip(self, other, strict=True)))


class Remainder(NamedTuple):
    """The remainder: a monomial and what it is multiplied by."""

    monomial: Monomial
    low: float
    high: float

    @property
    def size(self) -> float:
        return max(abs(self.low), abs(self.high))


class Growth(NamedTuple):
    """Terms, the fastest first, and the remainder."""

    terms: tuple[tuple[Monomial, Mpf], ...]
    rest: Remainder | None = None
