"""Times as the user gave them: any number of digits in, two doubles or many digits out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from hjsolve.numeric.double import split


def relative(times: Any, start: Callable[[int], Any]) -> tuple[Any, Any]:
    """Return t − t₀ as two doubles for float times.

    Args:
        times: float array, shape (m,).
        start: t₀ at any precision.
    """
    high, low = split(start(160))
    difference = times - high
    part = difference - times
    return difference, (times - (difference - part)) - (high + part) - low


def relative_exact(times: Sequence[Callable[[int], Any]], start: Callable[[int], Any], bits: int) -> list[Any]:
    """Return t − t₀ in many digits."""
    return [t(bits) - start(bits) for t in times]


def halves(numbers: Sequence[Any]) -> tuple[Any, Any]:
    """Return many-digit numbers as two double arrays."""
    pairs = [split(x) for x in numbers]
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])
