"""Second-order slopes from a base point: small motions without cancellation.

A function is carried as its value and derivative at q₀ and its second divided difference t = f[q₀, q₀, q], q = q₀ + δ:

    f[q₀, q] = f′(q₀) + δ t,     f(q) = f(q₀) + δ f[q₀, q].

Only t is propagated: by Leibniz' rule for products and quotients, and for an elementary function Φ by
(Φ∘f)[q₀, q₀, q] = Φ[f₀, f₀, f]·f[q₀, q]² + Φ′(f₀) t, with Φ[f₀, f₀, f] from the addition theorems (Krawczyk & Neumaier,
SIAM J. Numer. Anal. 22 (1985) 604). However small δ is, t keeps its relative accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Float64, by_squaring
from hjsolve.arithmetic.number_types import Elementwise

FUNCTIONS = frozenset({"neg", "sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech", "abs"})
"""Elementary functions that have a rule."""

_SERIES = 0.7
_TERMS = 11


class SecondDifference(NamedTuple):
    """f(q₀), f′(q₀), f[q₀, q₀, q], f[q₀, q] and f(q); a constant has None but at the first."""

    base: Elementwise
    first: Elementwise = None
    second: Elementwise = None
    slope: Elementwise = None
    value: Elementwise = None


@dataclass(frozen=True)
class SecondDifferences:
    """Arithmetic on ``SecondDifference`` values.

    Attributes:
        offset: δ; base parts must broadcast against it.
    """

    offset: Elementwise

    def variable(self, place: Elementwise) -> SecondDifference:
        """Return the slope of q itself, q₀ = ``place``.

        Args:
            place: q₀.
        """
        return self._made(place, 1.0, 0.0)

    def _made(self, base: Elementwise, first: Elementwise, second: Elementwise) -> SecondDifference:
        slope = first + self.offset * second
        return SecondDifference(base, first, second, slope, base + self.offset * slope)

    def rational(self, numerator: int, denominator: int) -> SecondDifference:
        """Return a constant: it has no differences.

        Args:
            numerator, denominator: whole numbers, the second not zero.
        """
        return SecondDifference(Float64().rational(numerator, denominator))

    def pi(self) -> SecondDifference:
        return SecondDifference(np.pi)

    def add(self, x: SecondDifference, y: SecondDifference) -> SecondDifference:
        """Return x + y; differences are added.

        Args:
            x, y: functions between q₀ and q₀ + δ.
        """
        if x.first is None or y.first is None:
            other = y if x.first is None else x
            if other.first is None:
                return SecondDifference(x.base + y.base)
            return self._made(x.base + y.base, other.first, other.second)
        return self._made(x.base + y.base, x.first + y.first, x.second + y.second)

    def sub(self, x: SecondDifference, y: SecondDifference) -> SecondDifference:
        """Return x − y; differences are subtracted.

        Args:
            x, y: functions between q₀ and q₀ + δ.
        """
        return self.add(x, self.unary("neg", y))

    def mul(self, x: SecondDifference, y: SecondDifference) -> SecondDifference:
        """Return x·y, by (xy)[q₀, q₀, q] = x₀ y[q₀, q₀, q] + x′₀ y[q₀, q] + x[q₀, q₀, q] y.

        Args:
            x, y: functions between q₀ and q₀ + δ.
        """
        if x.first is None or y.first is None:
            constant, other = (x, y) if x.first is None else (y, x)
            if other.first is None:
                return SecondDifference(x.base * y.base)
            return self._made(constant.base * other.base, constant.base * other.first, constant.base * other.second)
        second = x.base * y.second + x.first * y.slope + x.second * y.value
        return self._made(x.base * y.base, x.first * y.base + x.base * y.first, second)

    def div(self, x: SecondDifference, y: SecondDifference) -> SecondDifference:
        """Solve x = h y for h = x/y: x[q₀,q₀,q] = h₀ y[q₀,q₀,q] + h′₀ y[q₀,q] + h[q₀,q₀,q] y.

        Args:
            x, y: functions between q₀ and q₀ + δ.
        """
        if y.first is None:
            return self.mul(x, SecondDifference(1.0 / y.base))
        base = x.base / y.base
        first = ((0.0 if x.first is None else x.first) - base * y.first) / y.base
        second = ((0.0 if x.second is None else x.second) - base * y.second - first * y.slope) / y.value
        return self._made(base, first, second)

    def power(self, x: SecondDifference, n: int) -> SecondDifference:
        """Return xⁿ, by squaring.

        Args:
            x: a function between q₀ and q₀ + δ.
            n: the exponent, of either sign.
        """
        if n < 0:
            return self.div(SecondDifference(1.0), self.power(x, -n))
        result: SecondDifference = by_squaring(self.mul, x, n)
        return result

    def unary(self, name: str, x: SecondDifference) -> SecondDifference:
        """Return Φ(x), by the addition theorem of Φ.

        Args:
            name: of the function Φ, one of ``tape.UNARY``.
            x: a function between q₀ and q₀ + δ.
        """
        if x.first is None:
            return SecondDifference(Float64().unary(name, x.base))
        if name == "neg":
            return SecondDifference(-x.base, -x.first, -x.second, -x.slope, -x.value)
        if name == "tan":
            return self.div(self.unary("sin", x), self.unary("cos", x))
        if name == "tanh":
            return self.div(self.unary("sinh", x), self.unary("cosh", x))
        if name == "sech":
            return self.div(SecondDifference(1.0), self.unary("cosh", x))
        if name == "abs":
            sign = np.where(x.base * x.value > 0, np.sign(x.base), np.nan)
            return self.mul(x, SecondDifference(sign))
        if name == "sqrt":
            base, here = np.sqrt(x.base), np.sqrt(x.value)
            first = x.first / (2 * base)
            second = (x.second - first * x.slope / (base + here)) / (base + here)
            return self._made(base, first, second)
        base, derivative, bend = _elementary(name, x.base, self.offset * x.slope)
        return self._made(base, derivative * x.first, bend * x.slope**2 + derivative * x.second)


def _elementary(name: str, x: Elementwise, d: Elementwise) -> tuple[Elementwise, Elementwise, Elementwise]:
    """Φ(x), Φ′(x) and Φ[x, x, x + d]."""
    match name:
        case "exp":
            e = np.exp(x)
            return e, e, e * _choose(d, _tail(d, 2, 1, 1), lambda y: (np.expm1(y) - y) / y**2)
        case "sin" | "cos":
            s, c = np.sin(x), np.cos(x)
            even = _choose(d, _tail(d, 2, 2, -1), lambda y: (1 - np.cos(y)) / y**2)
            odd = d * _choose(d, _tail(d, 3, 2, -1), lambda y: (y - np.sin(y)) / y**3)
            return (s, c, -s * even - c * odd) if name == "sin" else (c, -s, -c * even + s * odd)
        case "sinh" | "cosh":
            s, c = np.sinh(x), np.cosh(x)
            even = _choose(d, _tail(d, 2, 2, 1), lambda y: (np.cosh(y) - 1) / y**2)
            odd = d * _choose(d, _tail(d, 3, 2, 1), lambda y: (np.sinh(y) - y) / y**3)
            return (s, c, s * even + c * odd) if name == "sinh" else (c, s, c * even + s * odd)
        case "log":
            r = d / x
            return np.log(x), 1 / x, _log_tail(r) / x**2
        case _:
            raise NotImplementedError(name)


def _tail(d: Elementwise, start: int, step: int, sign: int) -> Elementwise:
    """1/start! + sign·dˢ/(start + s)! + …, s the step: the rest of a power series divided by its first power."""
    y = d**step
    total = 0.0 * d
    for k in range(_TERMS + 5 * (step == 1), -1, -1):
        total = sign**k / factorial(start + step * k) + total * y
    return total


def _choose(d: Elementwise, series: Elementwise, formula: Elementwise) -> Elementwise:
    """The series where |d| is small, the formula elsewhere."""
    far = np.abs(d) >= _SERIES
    if not np.any(far):
        return series
    return np.where(far, formula(np.where(far, d, 1.0)), series)


def _log_tail(r: Elementwise) -> Elementwise:
    """(ln(1 + r) − r)/r², by the series of artanh: ln(1 + r) = 2 artanh(y), y = r/(2 + r)."""
    y = r / (2 + r)
    square = y * y
    total = 0.0 * r
    for k in range(14, -1, -1):
        total = 2.0 / (2 * k + 3) + total * square
    series = y * total / (2 + r) ** 2 - 1 / (2 + r)
    far = np.abs(r) >= _SERIES / 2
    safe = np.where(far, r, 1.0)
    return np.where(far, (np.log1p(safe) - safe) / safe**2, series)
