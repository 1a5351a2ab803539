"""Doubles with a running bound on what their rounding has done, elementwise over numpy arrays.

A value is a pair (number, bound): the exact result for the exact inputs lies within the bound of the number, to first
order. The rounding of +, −, ×, ÷ and √ is not estimated but found by error-free transformations (Knuth, TAOCP 2,
§4.2.2; Dekker, Numer. Math. 18 (1971) 224), so that the bound is zero where the result is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from hjsolve.numeric.arithmetic import Float64
from hjsolve.numeric.double import two_product, two_sum

_EPS = 2.0**-52
_DOUBLES = Float64()
Pair = tuple[Any, Any]


@dataclass(frozen=True, slots=True)
class RunningError:
    """The arithmetic of pairs; see the module's text."""

    def rational(self, numerator: int, denominator: int) -> Pair:
        exact = Fraction(numerator, denominator)
        value = float(exact)
        return value, float(abs(exact - Fraction(value)))

    def pi(self) -> Pair:
        return np.pi, 1.3e-16

    def add(self, x: Pair, y: Pair) -> Pair:
        value, rest = two_sum(x[0], y[0])
        return value, x[1] + y[1] + _size(rest, value)

    def sub(self, x: Pair, y: Pair) -> Pair:
        return self.add(x, (-y[0], y[1]))

    def mul(self, x: Pair, y: Pair) -> Pair:
        value, rest = two_product(x[0], y[0])
        return value, np.abs(x[0]) * y[1] + np.abs(y[0]) * x[1] + x[1] * y[1] + _size(rest, value)

    def div(self, x: Pair, y: Pair) -> Pair:
        value = np.divide(x[0], y[0])
        back, rest = two_product(value, y[0])
        missed = np.abs(x[0] - back) + np.abs(rest)
        return value, (x[1] + np.abs(value) * y[1] + _size(missed, x[0])) / np.abs(y[0])

    def power(self, x: Pair, n: int) -> Pair:
        result = x
        for _ in range(abs(n) - 1):
            result = self.mul(result, x)
        return result if n > 0 else self.div((1.0, 0.0), result)

    def unary(self, name: str, x: Pair) -> Pair:
        value = _DOUBLES.unary(name, x[0])
        if name in {"neg", "abs"}:
            return value, x[1]
        moved = [np.abs(_DOUBLES.unary(name, x[0] + sign * x[1]) - value) for sign in (-1, 1)]
        return value, 2 * np.maximum(*moved) + 2 * _EPS * np.abs(value)


def _size(rest: Any, value: Any) -> Any:
    """|rest|, or an ulp of the value where the transformation overflowed."""
    return np.where(np.isfinite(rest), np.abs(rest), _EPS * np.abs(value))
