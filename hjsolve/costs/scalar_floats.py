"""Python's own floats, one number at a time: the quickest arithmetic for a single state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hjsolve.arithmetic.floats import ByOperators

_NAMES = {"abs": "fabs"}


@dataclass(frozen=True, slots=True)
class ScalarFloat(ByOperators):
    """Double precision for scalars; what leaves the domain of a function is not a number."""

    def rational(self, numerator: int, denominator: int) -> float:
        """Give a rational."""
        return numerator / denominator

    def pi(self) -> float:
        """Give π."""
        return math.pi

    def div(self, x: Any, y: Any) -> Any:
        """The quotient."""
        return x / y if y else math.nan

    def power(self, x: Any, n: int) -> Any:
        """A whole power."""
        return x**n if x or n > 0 else math.nan

    def unary(self, name: str, x: Any) -> Any:
        """An elementary function."""
        if name == "neg":
            return -x
        try:
            return getattr(math, _NAMES.get(name, name))(x)
        except (ValueError, OverflowError):
            return math.nan
