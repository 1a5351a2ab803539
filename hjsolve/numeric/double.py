"""Phases of very long times without loss: products reduced in double-double arithmetic.

A phase Ω·t mod 2π held in doubles loses a digit with every factor ten of t. Here Ω/2π is carried
as the sum of two doubles (32 digits) and t as one or two; the product is exact to about 106 bits
(Dekker, Numer. Math. 18 (1971) 224; Knuth, TAOCP 2, §4.2.2).
"""

from __future__ import annotations

from typing import Any

import numpy as np

_SPLITTER = 134217729.0


def split(x: Any) -> tuple[float, float]:
    """Return a many-digit number as an unevaluated sum of two doubles."""
    high = float(x)
    return high, float(x - high)


def _two_product(a: Any, b: Any) -> tuple[Any, Any]:
    p = a * b
    ca, cb = _SPLITTER * a, _SPLITTER * b
    ah, bh = ca - (ca - a), cb - (cb - b)
    al, bl = a - ah, b - bh
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


def turns(rate: tuple[float, float], time: tuple[Any, Any]) -> tuple[Any, Any]:
    """Return the whole turns and the rest, in [−½, ½], of rate·time.

    Args:
        rate: turns per unit time, as two doubles.
        time: as two doubles (arrays of the same shape).

    Returns:
        Whole number (float array) and fraction; their sum is the product to about 1e-32 relative.
    """
    p, e = _two_product(rate[0], time[0])
    e = e + (rate[0] * time[1] + rate[1] * time[0])
    whole = np.rint(p)
    rest = (p - whole) + e
    more = np.rint(rest)
    return whole + more, rest - more
