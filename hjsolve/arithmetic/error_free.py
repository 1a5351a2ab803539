"""Error-free transformations: sums and products of doubles with what their rounding left out.

Knuth, TAOCP 2, §4.2.2; Dekker, Numer. Math. 18 (1971) 224. All of it works elementwise on floats and on arrays.

Arguments are doubles or arrays of them.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from hjsolve.arithmetic.number_types import Elementwise, Numeric

_SPLITTER = 134217729.0
TOO_MANY = 2**62
"""The count that stands for all counts from it on: integers of 64 bits hold no more."""


class Pair(NamedTuple):
    """A number high + low, |low| at most half a unit in the last place of high; floats or arrays."""

    high: Elementwise
    low: Elementwise


def split(x: Numeric) -> Pair:
    """Round a many-digit number to two doubles."""
    high = float(x)
    return Pair(high, float(x - high))


def exact(value: Fraction) -> Pair:
    """Round a fraction to two doubles."""
    high = float(value)
    return Pair(high, float(value - Fraction(high)))


def two_sum(a: Elementwise, b: Elementwise) -> Pair:
    """Return a + b exactly (Knuth)."""
    s = a + b
    part = s - a
    return Pair(s, (a - (s - part)) + (b - part))


def moved(base: Pair, more: Elementwise) -> Pair:
    """Return base + more in two doubles.

    Args:
        base: in two doubles.
    """
    s, e = two_sum(base.high, more)
    return Pair(*two_sum(s, e + base.low))


def quick_two_sum(a: Elementwise, b: Elementwise) -> Pair:
    """Return a + b exactly, where |a| ≥ |b| (Dekker)."""
    s = a + b
    return Pair(s, b - (s - a))


def two_product(a: Elementwise, b: Elementwise) -> Pair:
    """Return a·b exactly, for sizes below about 10²⁹² (Dekker)."""
    p = a * b
    ca, cb = _SPLITTER * a, _SPLITTER * b
    ah, bh = ca - (ca - a), cb - (cb - b)
    al, bl = a - ah, b - bh
    return Pair(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
