"""Where a rotation is slow, and how its nodes crowd there.

p² of a rotation has pairs of zeros next to the real line, slow ± i·gap. Elliptic anomalies, q = slow + 2 am − π, carry
one such pair far away and leave fewer nodes for the rest of the turn; where p² has two slow places, see also
``turned_circle``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.arithmetic.root_finding import stationary_places
from hjsolve.ensembles.engine.nodes import MOST_LEVEL
from hjsolve.ensembles.engine.turned_circle import reach
from hjsolve.one_coordinate.barriers import EQUAL_BARRIERS, barrier_order

Jet = Callable[[Reals], tuple[Reals, Reals, Reals]]
"""F, F′ and F″ at a place of each of n orbits."""

_FARTHEST_STEP = 0.2
"""Of Newton's method, radians: the spacing 2π/32 of the grid it begins on. Farther away another point is nearer."""
_AWAY = 3
"""Points of the grid from the slow place on at which another one may be."""


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


def slow_places(jet: Jet, values: Reals, grid: Reals) -> SlowPlaces:
    """Find where p² is least, by Newton's method on F′ from the least values on a grid, and choose the anomaly.

    Args:
        jet: of p².
        values: of it on the grid, shape (n, points).
        grid: angles, equally spaced over a turn.
    """
    bottom = values.min(axis=1, keepdims=True)
    # the first of equal barriers, whatever rounding says of their order
    first = np.argmax(values <= bottom + 1e-9 * np.abs(values).max(axis=1, keepdims=True), axis=1)
    slow, gap, least = _refined(jet, grid[first])
    second, there = _second(values, grid, slow)
    other, far, lowest = _refined(jet, grid[second])
    far, lowest = np.where(there & np.isfinite(far), far, np.inf), np.where(there, lowest, np.inf)
    alike = np.abs(lowest - least) <= EQUAL_BARRIERS * np.abs(values).max(axis=1)
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


def _refined(jet: Jet, place: Reals) -> tuple[Reals, Reals, Reals]:
    """Return a place where F is least, the distance √(2F/F″) of zeros from the real line, NaN for none near, and F."""
    place, going, _ = stationary_places(jet, place, _FARTHEST_STEP, 8)
    with np.errstate(all="ignore"):
        value, _, second = jet(place)
        gap = np.sqrt(2 * value / second)
    return place, np.where(going & np.isfinite(gap), gap, np.nan), value


def _second(values: Reals, grid: Reals, slow: Reals) -> tuple[Integers, Mask]:
    """Return the point of the grid at the bottom of the narrowest of all other valleys, and whether there is one."""
    before, after = np.roll(values, 1, axis=1), np.roll(values, -1, axis=1)
    away = np.abs((grid - slow[:, None] + np.pi) % (2 * np.pi) - np.pi) > _AWAY * 2 * np.pi / len(grid)
    bend = before - 2 * values + after
    with np.errstate(all="ignore"):
        # F at the bottom of the parabola through three points, over its second difference: the distance of its zeros,
        # squared
        gaps = values / bend - 0.125 * ((after - before) / bend) ** 2
    gaps = np.where(away & (values <= before) & (values <= after) & (bend > 0), gaps, np.inf)
    point = gaps.argmin(axis=1)
    return point, np.isfinite(gaps[np.arange(len(gaps)), point])


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
