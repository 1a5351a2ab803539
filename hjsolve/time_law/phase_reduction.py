"""Phases of very long times without loss: whole turns taken away in double-double arithmetic.

A phase Ω·t mod 2π held in doubles loses a digit with every factor ten of t. Here Ω/2π is carried
as the sum of two doubles (32 digits) and t as one or two; the product is exact to about 106 bits
(``error_free``).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.error_free import TOO_MANY, two_product, two_sum
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.time_law.compiled import kernels

CHUNK = 8192
"""How many numbers are worked on at once, so that what is in between stays in the cache."""


def turns_and_rest(
    rate: tuple[float, float], time: tuple[Reals, Reals], start: tuple[float, float] = (0.0, 0.0)
) -> tuple[Integers, Reals]:
    """Return the whole turns and the rest, in [−½, ½], of start + rate·time.

    The rest keeps its relative accuracy when it is small: a perihelion passage is not blurred.

    Args:
        rate: turns per unit time, as two doubles.
        time: as two doubles, shape (m,).
        start: turns at time zero, as two doubles.

    Returns:
        Whole number (64-bit integers: a double holds those up to 2**53 only; ± ``TOO_MANY`` where there are as many)
        and fraction, shape (m,) each; their sum is exact to about 1e-32 relative.
    """
    upper, lower = time
    whole, rest = np.empty(upper.shape, dtype=np.int64), np.empty(upper.shape)
    if compiled := kernels(upper.size):
        compiled.turns(rate, upper, lower, start, whole, rest)
        return whole, rest
    for begin in range(0, len(upper), CHUNK):
        part = slice(begin, begin + CHUNK)
        whole[part], rest[part] = _turns(rate, upper[part], lower[part], start)
    return whole, rest


def _turns(rate: tuple[float, float], upper: Reals, lower: Reals, start: tuple[float, float]) -> tuple[Integers, Reals]:
    # p + e is the exact product of the two high parts
    p, e = two_product(rate[0], upper)
    e = e + (rate[0] * lower + rate[1] * upper)
    # p − rint(p) is exact (Sterbenz): the fraction keeps every bit of the product
    whole = np.rint(p)
    s, low = two_sum(p - whole, start[0])
    low = low + (e + start[1])
    # start and low parts may carry over once more
    more = np.rint(s + low)
    return _counted(whole, more), (s - more) + low


def _counted(whole: Reals, more: Reals | float = 0.0) -> Integers:
    """Return the sum of whole numbers as integers; ± ``TOO_MANY`` beyond them, 0 for nan."""
    held = np.abs(whole) < TOO_MANY
    count = np.where(held, whole, 0.0).astype(np.int64) + np.where(held, more, 0.0).astype(np.int64)
    return np.where(held | np.isnan(whole), count, np.where(whole < 0, -TOO_MANY, TOO_MANY))


def grown_by(rate: tuple[float, float], time: tuple[Reals, Reals], rest: Reals | float) -> Reals:
    """Return rate·time + rest, rounded as its last sum is.

    Args:
        rate: as two doubles.
        time: as two doubles, shape (m,).
        rest: what is added, shape (m,).
    """
    upper, lower = time
    p, e = two_product(rate[0], upper)
    # the largest term comes last: one rounding of the sum, at its own size
    return p + (rest + (e + (rate[0] * lower + rate[1] * upper)))


def principal(angle: Reals) -> tuple[Reals, Integers]:
    """Reduce to (−π, π], and count the turns taken away.

    Args:
        angle: in radians, shape (m,).

    Returns:
        The angle in (−π, π], and the whole turns taken away (0 for nan); shape (m,) each.
    """
    value, count = np.empty(angle.shape), np.empty(angle.shape, dtype=np.int64)
    if compiled := kernels(angle.size):
        compiled.fill_principal(np.ascontiguousarray(angle), value, count)
        return value, count
    for begin in range(0, len(angle), CHUNK):
        part = slice(begin, begin + CHUNK)
        # ceil and not rint: π stays π, −π is taken up a turn
        n = np.ceil((angle[part] - np.pi) / (2 * np.pi))
        count[part] = _counted(n)
        value[part] = np.where(n == 0, angle[part], angle[part] - 2 * np.pi * n)
    return value, count
