"""Where a rotation is slow, and how its nodes crowd there.

p² of a rotation has pairs of zeros next to the real line, slow ± i·gap. Elliptic anomalies, q = slow + 2 am − π, carry
one such pair far away and leave fewer nodes for the rest of the turn; where p² has two slow places, see also
``turned_circle``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.minima_over_a_turn import Valleys
from hjsolve.ensembles.engine.nodes import MOST_LEVEL
from hjsolve.ensembles.engine.turned_circle import reach
from hjsolve.one_coordinate.barriers import EQUAL_BARRIERS, barrier_order


@dataclass(frozen=True)
class SlowPlaces:
    """How the nodes of n rotations crowd; arrays (n,).

    Attributes:
        centre: the slow place, or half way between two.
        opposite: the place opposite to the slower one, less the centre.
        level: l in k′ = 2^−l.
        several: 1 where nodes crowd at two places (int array).
        ratio: m of ``turned_circle`` there, else 0.
        least: the least p²; where it is not positive the motion does not go round.
    """

    centre: Reals
    opposite: Reals
    level: Integers
    several: Integers
    ratio: Reals
    least: Reals

    def take(self, index: Integers) -> SlowPlaces:
        """Return those of some of the rotations."""
        return SlowPlaces(**{name: getattr(self, name)[index] for name in self.__dataclass_fields__})


def slow_places(valleys: Valleys) -> SlowPlaces:
    """Choose the anomaly.

    Args:
        valleys: where p² is least, of n rotations.
    """
    slow, other, gap, least, greatest = (
        valleys.place, valleys.other, valleys.gap, valleys.least, valleys.greatest
    )  # fmt: skip
    there = np.isfinite(other)
    far = np.where(there & np.isfinite(valleys.far), valleys.far, np.inf)
    lowest = np.where(there, valleys.lowest, np.inf)
    alike = np.abs(lowest - least) <= EQUAL_BARRIERS * greatest
    # the same barrier as for single motions, from which angles are counted
    swapped = np.isfinite(far) & np.where(alike, barrier_order(other) < barrier_order(slow), lowest < least)
    slow, other = np.where(swapped, other, slow), np.where(swapped, slow, other)
    gap, far = np.where(swapped, far, gap), np.where(swapped, np.nan_to_num(gap, nan=np.inf), far)
    level, width = _one(gap, far)
    # the shorter way round
    between = (other - slow + np.pi) % (2 * np.pi) - np.pi
    ratio = np.tan(0.25 * np.abs(between))
    deeper, wider = _two(np.fmin(gap, far) / np.sin(0.5 * np.abs(between)), ratio)
    # the map whose strip is wider needs fewer nodes
    both = np.isfinite(far) & (wider > width)
    half = np.where(both, 0.5 * between, 0.0)
    return SlowPlaces(
        centre=slow + half,
        opposite=np.pi - half,
        level=np.where(both, deeper, level),
        several=both.astype(int),
        ratio=np.where(both, ratio, 0.0),
        least=np.fmin(least, lowest),
    )


def _one(gap: Reals, other: Reals) -> tuple[Integers, Reals]:
    """Return the level with which nodes that crowd at one place are fewest, and half the width of the strip in χ.

    Without a second slow place the zeros of p² go where dn has its poles. With one the best level is that at which the
    narrowest strip, of the zeros next to either place or of the poles, is widest.
    """
    complement = np.where(np.isfinite(gap), (gap / 2) ** 2 / (1 + (gap / 2) ** 2), 1.0)
    level = np.clip(np.where(complement < 0.125, np.rint(-np.log2(complement) / 2), 0), 0, MOST_LEVEL).astype(int)
    faster, poles = _levels()
    width = poles[level]
    some = np.flatnonzero((level > 0) & np.isfinite(other))
    if len(some):
        strip = np.minimum(
            np.minimum(gap[some, None] * 2.0 ** np.arange(MOST_LEVEL + 1), other[some, None]) / faster, poles
        )
        level[some], width[some] = strip.argmax(axis=1), strip.max(axis=1)
    return level, width


def _two(gap: Reals, ratio: Reals) -> tuple[Integers, Reals]:
    """Return the same for nodes that crowd at two places; the gap is the smaller one, in θ."""
    with np.errstate(all="ignore"):
        wanted = np.rint(-np.log2(0.5 * np.nan_to_num(gap, nan=1.0, posinf=1.0)))
        level = np.clip(wanted, 0, MOST_LEVEL).astype(int)
        faster, poles = _levels()
        return level, np.minimum(0.5 * poles[level], reach(ratio) / faster[level])


@cache
def _levels() -> tuple[Reals, Reals]:
    """Of all levels 2K/π, by which q runs faster than χ far from the slow place, and π K′/K, where dn has its poles."""
    small: Reals = 2.0 ** -np.arange(MOST_LEVEL + 1, dtype=float)
    complement, large = _mean(small), _mean(np.sqrt(np.maximum(1 - small**2, 0.0)))
    with np.errstate(divide="ignore"):
        return 1 / complement, np.pi * complement / large


def _mean(start: Reals) -> Reals:
    """Return the arithmetic-geometric mean with 1; 2K/π = 1/mean(k′) (DLMF 19.8.5)."""
    a, b = np.ones_like(start), start
    for _ in range(64):
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return a
