"""Times as the user gave them: any number of digits in, two doubles or many digits out.

t − t₀ of doubles t and t₀ in two doubles is exact: s = fl(t − t₀), e = (t − (s − (s − t))) − (t₀ + (s − t)) (Knuth).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hjsolve.arithmetic.error_free import split
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.time_law.compiled import kernels
from hjsolve.time_law.phase_reduction import CHUNK


def relative(times: Reals, start: Callable[[int], Mpf]) -> tuple[Reals, Reals]:
    """Return t − t₀ as two doubles for float times.

    Args:
        times: float array, shape (m,).
        start: t₀ at any precision.
    """
    high, low = split(start(160))
    if not np.isfinite(high):
        return times - high, 0.0 * times
    upper, lower = np.empty(times.shape), np.empty(times.shape)
    if compiled := kernels(times.size):
        compiled.fill_relative(times, high, low, upper, lower)
        return upper, lower
    for begin in range(0, len(times), CHUNK):
        part = slice(begin, begin + CHUNK)
        # two_sum of the time and −t₀ (high part): t − t₀ next to 0 keeps the digits of t₀ that no double holds
        difference = times[part] - high
        error = difference - times[part]
        upper[part] = difference
        lower[part] = (times[part] - (difference - error)) - (high + error) - low
    return upper, lower


def relative_exact(times: Sequence[Callable[[int], Mpf]], start: Callable[[int], Mpf], bits: int) -> list[Mpf]:
    """Return t − t₀ in many digits.

    Args:
        times: rules that give each t in any number of binary digits.
        start: the same of t₀.
        bits: binary digits wanted.
    """
    return [t(bits) - start(bits) for t in times]


def halves(numbers: Sequence[Mpf]) -> tuple[Reals, Reals]:
    """Return many-digit numbers as two double arrays.

    Args:
        numbers: mpmath's.

    Returns:
        High and low parts, shape (m,) each; their sum is the number to about 32 digits.
    """
    pairs = [split(x) for x in numbers]
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])
