"""Phases of very long times without loss: whole turns taken away in double-double arithmetic.

A phase Ω·t mod 2π held in doubles loses a digit with every factor ten of t. Here Ω/2π is carried
as the sum of two doubles (32 digits) and t as one or two; the product is exact to about 106 bits
(``error_free``).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.error_free import two_product, two_sum
from hjsolve.arithmetic.number_types import Elementwise, Reals
from hjsolve.time_law.compiled import kernels

CHUNK = 8192
"""How many numbers are worked on at once, so that what is in between stays in the cache."""


def turns_and_rest(
    rate: tuple[float, float], time: tuple[Elementwise, Elementwise], start: tuple[float, float] = (0.0, 0.0)
) -> tuple[Elementwise, Elementwise]:
    """Return the whole turns and the rest, in [−½, ½], of start + rate·time.

    The rest keeps its relative accuracy when it is small: a perihelion passage is not blurred.

    Args:
        rate: turns per unit time, as two doubles.
        time: as two doubles (arrays of the same shape).
        start: turns at time zero, as two doubles.

    Returns:
        Whole number (float array) and fraction; their sum is exact to about 1e-32 relative.
    """
    upper, lower = time
    if not np.ndim(upper):
        return _turns(rate, upper, lower, start)
    whole, rest = np.empty(upper.shape), np.empty(upper.shape)
    if compiled := kernels(upper.size):
        compiled.turns(rate, upper, lower, start, whole, rest)
        return whole, rest
    for begin in range(0, len(upper), CHUNK):
        part = slice(begin, begin + CHUNK)
        whole[part], rest[part] = _turns(rate, upper[part], lower[part], start)
    return whole, rest


def _turns(
    rate: tuple[float, float], upper: Elementwise, lower: Elementwise, start: tuple[float, float]
) -> tuple[Elementwise, Elementwise]:
    p, e = two_product(rate[0], upper)
    e = e + (rate[0] * lower + rate[1] * upper)
    whole = np.rint(p)
    s, low = two_sum(p - whole, start[0])
    low = low + (e + start[1])
    more = np.rint(s + low)
    return whole + more, (s - more) + low


def principal(angle: Reals) -> tuple[Reals, Reals]:
    """Reduce to (−π, π], and count the turns taken away; float array of shape (m,).

    Args:
        angle: in radians, shape (m,).

    Returns:
        The angle in (−π, π], and the whole turns taken away; shape (m,) each.
    """
    value, count = np.empty(angle.shape), np.empty(angle.shape)
    if compiled := kernels(angle.size):
        compiled.fill_principal(np.ascontiguousarray(angle), value, count)
        return value, count
    for begin in range(0, len(angle), CHUNK):
        part = slice(begin, begin + CHUNK)
        n = np.ceil((angle[part] - np.pi) / (2 * np.pi))
        count[part] = n
        value[part] = np.where(n == 0, angle[part], angle[part] - 2 * np.pi * n)
    return value, count
