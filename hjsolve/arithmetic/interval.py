"""Interval arithmetic: what a formula can be over a whole cell, as proof that it has no zero there.

End points are numpy arrays: float64 for the fast pass, objects holding ``mpf`` where doubles cannot
decide. Every result is widened by a few units in the last place, more than the rounding of the
operation below it, so that the enclosure holds without directed rounding. A formula that leaves
its domain gives the whole line, never an error: "nothing is known here".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hjsolve.algebra.ranges import RISING
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Truth


class Interval(NamedTuple):
    """Lower and upper ends, arrays of the same shape."""

    low: Elementwise
    high: Elementwise


def hull(x: Interval, y: Interval) -> Interval:
    """Return the least interval that holds both."""
    return Interval(np.minimum(x.low, y.low), np.maximum(x.high, y.high))


def exact(x: Elementwise) -> Interval:
    """Return doubles as intervals of length zero.

    Args:
        x: a double, or an array of them.
    """
    x = np.asarray(x, dtype=float)
    return Interval(x, x)


def over_shape(x: Interval, shape: tuple[int, ...]) -> Interval:
    """Return an interval for every place of an array.

    Args:
        x: of a shape that broadcasts to it.
        shape: of the array.
    """
    return Interval(np.broadcast_to(x.low, shape), np.broadcast_to(x.high, shape))


def meet(x: Interval, y: Interval) -> Interval:
    """Return what two intervals have in common, of which each holds the same number."""
    return Interval(np.maximum(x.low, y.low), np.minimum(x.high, y.high))


@dataclass(frozen=True)
class Intervals:
    """Interval arithmetic over a plain arithmetic.

    Attributes:
        plain: ``Float64()``, or ``Multi(bits)`` whose numbers then stand in object arrays.
    """

    plain: Float64 | Multi

    @cached_property
    def unit(self) -> float | Mpf:
        """Relative widening of one operation."""
        return self.plain.few_units

    def point(self, x: float | Mpf) -> Interval:
        """Enclose a number that the plain arithmetic may have to round.

        Args:
            x: a float, or a number of many digits.
        """
        number, exact = self.plain.held(x)
        return Interval(number, number) if exact else self._wide(number, number)

    def _wide(self, low: Elementwise, high: Elementwise) -> Interval:
        with np.errstate(all="ignore"):
            low, high = self.plain.widened(low, high)
            both = low + high
        if not np.any(both != both):
            return Interval(low, high)
        lost = (low != low) | (high != high)
        return Interval(np.where(lost, -np.inf, low), np.where(lost, np.inf, high))

    def rational(self, numerator: int, denominator: int) -> Interval:
        """Return an interval that holds a fraction; of length zero where a double holds it exactly."""
        value = np.array(self.plain.rational(numerator, denominator))
        exact = denominator & (denominator - 1) == 0 and abs(numerator) < 2**53
        return Interval(value, value) if exact else self._wide(value, value)

    def pi(self) -> Interval:
        value = np.array(self.plain.pi())
        return self._wide(value, value)

    def add(self, x: Interval, y: Interval) -> Interval:
        """Return an interval that holds every x + y."""
        with np.errstate(all="ignore"):
            return self._wide(np.add(x.low, y.low), np.add(x.high, y.high))

    def sub(self, x: Interval, y: Interval) -> Interval:
        """Return an interval that holds every x − y."""
        with np.errstate(all="ignore"):
            return self._wide(np.subtract(x.low, y.high), np.subtract(x.high, y.low))

    def mul(self, x: Interval, y: Interval) -> Interval:
        """Return an interval that holds every x·y: between the least and the greatest product of ends."""
        with np.errstate(all="ignore"):
            if self.plain.minimum_keeps_nan:
                products = [a * b for a in x for b in y]
                low = _least(products)
                if not np.any(low != low):
                    return self._wide(low, _greatest(products))
            products = [_product(a, b) for a in x for b in y]
            return self._wide(_least(products), _greatest(products))

    def div(self, x: Interval, y: Interval) -> Interval:
        """Return an interval that holds every x/y; the whole line where y may be zero."""
        straddles = (y.low <= 0) & (y.high >= 0)
        with np.errstate(all="ignore"):
            inverse = Interval(1 / np.where(straddles, 1, y.high), 1 / np.where(straddles, 1, y.low))
            result = self.mul(x, self._wide(*inverse))
        return Interval(np.where(straddles, -np.inf, result.low), np.where(straddles, np.inf, result.high))

    def power(self, x: Interval, n: int) -> Interval:
        """Return an interval that holds every xⁿ; not negative for an even n."""
        if n < 0:
            return self.div(self.rational(1, 1), self.power(x, -n))
        with np.errstate(all="ignore"):
            a, b = x.low**n, x.high**n
        if n % 2:
            return self._wide(a, b)
        inside = (x.low <= 0) & (x.high >= 0)
        return self._wide(np.where(inside, 0, np.minimum(a, b)), np.maximum(a, b))

    def unary(self, name: str, x: Interval) -> Interval:
        """Return an interval that holds every value of a function; the whole line outside its domain."""
        if name == "neg":
            return Interval(-x.high, -x.low)
        if name == "abs":
            inside = (x.low <= 0) & (x.high >= 0)
            a, b = abs(x.low), abs(x.high)
            return Interval(np.where(inside, 0, np.minimum(a, b)), np.maximum(a, b))
        if name in RISING:
            return self._rising(name, x, *RISING[name])
        return _OTHERS[name](self, x)

    def _call(self, name: str, x: Elementwise) -> Elementwise:
        with np.errstate(all="ignore"):
            return self.plain.over_array(name, x)

    def _rising(self, name: str, x: Interval, left: float, right: float) -> Interval:
        outside = (x.low < left) | (x.high > right)
        low, high = (
            np.where(outside, 0.5 if right == 1 else 2, x.low),
            np.where(outside, 0.5 if right == 1 else 2, x.high),
        )
        result = self._wide(self._call(name, low), self._call(name, high))
        return Interval(np.where(outside, -np.inf, result.low), np.where(outside, np.inf, result.high))

    def _sine(self, x: Interval, name: str) -> Interval:
        """Return the range of sin or cos: the values at the ends, and ±1 where a maximum lies inside."""
        turn, quarter = 2 * self.plain.pi(), self.plain.pi() / 2
        maximum = quarter if name == "sin" else 0 * quarter
        a, b = self._call(name, x.low), self._call(name, x.high)
        widening = 8 * self.unit * (1 + np.maximum(abs(x.low), abs(x.high)))

        def contains(point: float | Mpf) -> Truth:
            with np.errstate(all="ignore"):
                return _floor((x.high - point + widening) / turn) >= _floor((x.low - point - widening) / turn) + 1

        everything = np.logical_not((x.high - x.low) < turn) | (a != a) | (b != b)  # one number has a Python bool here
        top, bottom = everything | contains(maximum), everything | contains(maximum + turn / 2)
        low, high = self._wide(np.minimum(a, b), np.maximum(a, b))
        return Interval(np.where(bottom, -1, low), np.where(top, 1, high))

    def _tangent(self, x: Interval) -> Interval:
        return self.div(self._sine(x, "sin"), self._sine(x, "cos"))

    def _cosh(self, x: Interval) -> Interval:
        size = self.unary("abs", x)
        return self._wide(self._call("cosh", size.low), self._call("cosh", size.high))

    def _sech(self, x: Interval) -> Interval:
        size = self.unary("abs", x)
        return self._wide(self._call("sech", size.high), self._call("sech", size.low))

    def _acos(self, x: Interval) -> Interval:
        return self.sub(self.div(self.pi(), self.rational(2, 1)), self.unary("asin", x))


_OTHERS: dict[str, Callable[[Intervals, Interval], Interval]] = {
    "sin": lambda field, x: field._sine(x, "sin"),
    "cos": lambda field, x: field._sine(x, "cos"),
    "tan": Intervals._tangent,
    "cosh": Intervals._cosh,
    "sech": Intervals._sech,
    "acos": Intervals._acos,
}


def _floor(x: Elementwise) -> Elementwise:
    if getattr(x, "dtype", np.dtype(float)).kind == "O":
        return np.frompyfunc(lambda v: v.context.floor(v) if v == v and abs(v) != np.inf else v, 1, 1)(x)
    return np.floor(x)


def _product(a: Elementwise, b: Elementwise) -> Elementwise:
    """a·b with 0·∞ = 0: an infinite end stands for "unbounded", not for a value."""
    p = np.multiply(a, b)  # an mpf asked to take an array writes the array out before it declines
    return np.where((a == 0) | (b == 0), 0, p)


def _least(values: list[Elementwise]) -> Elementwise:
    result = values[0]
    for v in values[1:]:
        result = np.minimum(result, v)
    return result


def _greatest(values: list[Elementwise]) -> Elementwise:
    result = values[0]
    for v in values[1:]:
        result = np.maximum(result, v)
    return result
