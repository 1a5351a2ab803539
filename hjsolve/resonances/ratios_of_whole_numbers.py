"""The simplest ratios of whole numbers in an interval."""

from __future__ import annotations

from fractions import Fraction
from math import ceil, floor

_GREATEST, _MANY = 12, 6
"""Largest denominator that is looked at, and how many ratios are given."""


def simplest_ratios(low: float, high: float) -> list[str]:
    """Return ratios between two numbers, those of the smallest whole numbers first, such as "3:2".

    Args:
        low, high: the ends, positive.
    """
    found: list[Fraction] = []
    for n in range(1, _GREATEST + 1):
        first = ceil(low * n)
        found += [Fraction(m, n) for m in range(first, min(floor(high * n), first + _MANY) + 1) if m > 0]
    simple = sorted(dict.fromkeys(found), key=lambda r: (r.numerator + r.denominator, r))
    return [f"{r.numerator}:{r.denominator}" for r in simple[:_MANY]]
