"""Python's own floats, one number at a time: the quickest arithmetic for a single state."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hjsolve.arithmetic.floats import ByOperators

_NAMES = {"abs": "fabs"}


@dataclass(frozen=True, slots=True)
class ScalarFloat(ByOperators):
    """Double precision for scalars; what leaves the domain of a function is not a number."""

    def rational(self, numerator: int, denominator: int) -> float:
        """Return the float next to a fraction."""
        return numerator / denominator

    def pi(self) -> float:
        """Give π."""
        return math.pi

    def div(self, x: float, y: float) -> float:
        """Return x/y; nan for a zero y."""
        return x / y if y else math.nan

    def power(self, x: float, n: int) -> float:
        """Return xⁿ; nan for a pole."""
        return x**n if x or n > 0 else math.nan

    def unary(self, name: str, x: float) -> float:
        """Return a function of x; nan outside its domain."""
        if name == "neg":
            return -x
        try:
            return float(getattr(math, _NAMES.get(name, name))(x))
        except (ValueError, OverflowError):
            return math.nan
