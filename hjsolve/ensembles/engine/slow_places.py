"""Where a rotation is slow, and how much its nodes crowd there.

p² of a rotation has pairs of zeros beside the real line, slow ± i·gap. Elliptic anomalies, q = slow + 2 am − π, carry
one such pair far away and leave fewer nodes for the rest of the turn; where p² has a second slow place both count.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.nodes import MOST
from hjsolve.ensembles.engine.radicand_views import DirectEvaluation

_FARTHEST_STEP = 0.2
_OTHER = 3
"""Points of the grid from the slow place on at which another one may be."""


def slow_places(raw: DirectEvaluation, values: Reals, grid: Reals) -> tuple[Reals, Reals]:
    """Return where p² is least, its first least value on a grid being improved by Newton's method on F′; and the gap.

    Args:
        raw: p² of n orbits.
        values: of it on the grid, shape (n, points).
        grid: angles, equally spaced over a turn.

    Returns:
        The places, and the distances √(2F/F″) of the zeros of p² from the real line, NaN where there are none near.
    """
    least = values.min(axis=1, keepdims=True)
    slow = grid[np.argmax(values <= least + 1e-9 * np.abs(values).max(axis=1, keepdims=True), axis=1)]
    going = np.ones(len(slow), dtype=bool)
    with np.errstate(all="ignore"):
        for _ in range(8):
            _, first, second = raw.jet(slow)
            step = first / second
            going &= (second > 0) & (np.abs(step) < _FARTHEST_STEP)
            slow = np.where(going, slow - step, slow)
        value, _, second = raw.jet(slow)
        gap = np.sqrt(2 * value / second)
    return slow, np.where(going & np.isfinite(gap), gap, np.nan)


def other_gaps(values: Reals, grid: Reals, slow: Reals) -> Reals:
    """Return √(2F/F″) of the least of all slow places but one, from three points of a grid; infinite for none.

    Args:
        values: of p², shape (n, points).
        grid: angles, equally spaced over a turn.
        slow: the place that does not count, shape (n,).
    """
    before, after = np.roll(values, 1, axis=1), np.roll(values, -1, axis=1)
    spacing = 2 * np.pi / len(grid)
    away = np.abs((grid - slow[:, None] + np.pi) % (2 * np.pi) - np.pi) > _OTHER * spacing
    with np.errstate(all="ignore"):
        bend, slope = before - 2 * values + after, 0.5 * (after - before)
        bottom = np.maximum(values - 0.5 * slope**2 / bend, 0.0)
        gaps = spacing * np.sqrt(2 * bottom / bend)
    return np.where(away & (values <= before) & (values <= after) & (bend > 0), gaps, np.inf).min(axis=1)


def level_of(gap: Reals, other: Reals) -> Integers:
    """Return l of k′ = 2^−l with which elliptic anomalies take fewest nodes.

    Without a second slow place the zeros of p² go where dn has its poles. With one the best level is that at which the
    narrowest strip, of the zeros beside either place or of the poles, is widest.

    Args:
        gap: distance of the zeros of p² at the slow place, NaN for none; shape (n,).
        other: the same at the second slow place, infinite for none.
    """
    complement = np.where(np.isfinite(gap), (gap / 2) ** 2 / (1 + (gap / 2) ** 2), 1.0)
    level = np.clip(np.where(complement < 0.125, np.rint(-np.log2(complement) / 2), 0), 0, MOST).astype(int)
    several = np.flatnonzero((level > 0) & np.isfinite(other))
    if len(several):
        faster, poles = _levels()
        near, far = gap[several, None], other[several, None]
        strip = np.minimum(np.minimum(near * 2.0 ** np.arange(MOST + 1), far) / faster, poles)
        level[several] = np.minimum(level[several], strip.argmax(axis=1))
    return level


@cache
def _levels() -> tuple[Reals, Reals]:
    """2K/π, by which q runs faster than χ far from the slow place, and π K′/K, where dn has its poles, of all levels."""
    small = 2.0 ** -np.arange(MOST + 1)
    complement, large = _mean(small), _mean(np.sqrt(np.maximum(1 - small**2, 0.0)))
    with np.errstate(divide="ignore"):
        return 1 / complement, np.pi * complement / large


def _mean(start: Reals) -> Reals:
    """The arithmetic-geometric mean with 1; 2K/π = 1/mean(k′) (DLMF 19.8.5)."""
    a, b = np.ones_like(start), start
    for _ in range(64):
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return a
