"""Librations that pass slowly over a crest of the potential: where it is, and how nodes crowd about it.

F = p² has a pair of zeros q_c ± iε next to the motion. With q = a + W x, x = sin²(φ/2), they lie on a circle, at ±φ_c
± iδ, and a Möbius transformation x/(1 − x) = m X/(1 − X), m = (q_c − a)/(b − q_c), takes both to the middle of it,
X = sin²(θ/2) with θ = ±π/2 ± iδ/sin φ_c. There

    θ = am(2K χ/π | k²),   dθ/dχ = 2K/π dn,   dn = k′ at θ = π/2,

moves nodes together as ``rotation_anomalies`` does about the slow place of a rotation: the pair of zeros is as far from
the real χ as the poles of am where k′ is half its distance (DLMF 22.2.2, 22.16.1).

The same nodes serve where a pair of singularities of the potential itself lies next to the motion, as √(1 + q²) has
them for wide motions: where the clearance of p² (``clearance``) is least, and how wide it is, say where.

``lower`` are the lower turning points, offsets in the view of the lower half, ``width`` is b − a.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.arithmetic.root_finding import stationary_places
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, place, squares
from hjsolve.ensembles.engine.kernels.crowding import BARRIER_TOP
from hjsolve.ensembles.engine.nodes import MOST_LEVEL
from hjsolve.ensembles.engine.programs import sides

_POINTS = 48
_GRID = np.sin(np.pi * (np.arange(_POINTS) + 0.5) / (2 * _POINTS)) ** 2
"""Fractions of a motion, evenly spaced in the anomaly, between which valleys of p² are looked for. Half and twice as
many change statuses of none of 20 000 orbits, and last bits about two centres only."""
_NEWTON_STEPS = 8
_FARTHEST_STEP = 0.1
"""Newton's steps for the place of a barrier top (4 and 16 give the same bits), and the longest one, over the width of
the motion: three spacings of the grid in the middle."""
_THIRDS = 24
"""Steps in which a bracket of the least clearance loses a third each."""
_WIDE = 1.0
"""Distance δ/sin φ_c of the zeros above which no crest is seen."""


class BarrierTops(NamedTuple):
    """Motions that pass over a crest, or by a pair of singularities.

    Attributes:
        orbits: which they are, shape (n,).
        maps: how their nodes are placed, as ``node_maps.NodeMaps.index`` takes it, shape (n, 3).
        places: (q_c − a)/(b − q_c), shape (n,).
    """

    orbits: Integers
    maps: Integers
    places: Reals


def barrier_tops(one: CoordinateOfOrbits, lower: Reals, width: Reals) -> BarrierTops:
    """Find the crests that motions pass most slowly."""
    formula, code = sides(one.coordinate)[0], one.programs.views[0].bend
    n, sign = len(width), formula.sign
    with np.errstate(all="ignore"):
        grid = lower[:, None] + sign * width[:, None] * _GRID
        given = np.concatenate([grid.ravel()[None], np.repeat(one.constants, _POINTS, axis=1)])
        values = run_rows(code, one.parameters, given)[0].reshape(n, _POINTS)
        valley = np.zeros(values.shape, dtype=bool)
        valley[:, 1:-1] = (values[:, 1:-1] <= values[:, :-2]) & (values[:, 1:-1] <= values[:, 2:])
        orbit, point = np.nonzero(valley)
        some = one.take(orbit)
        x, W = grid[orbit, point], width[orbit]

        def jet(x: Reals) -> Reals:
            return run_rows(code, one.parameters, np.stack([x, *some.constants]))

        x, fine, bend = stationary_places(jet, x, _FARTHEST_STEP * W, _NEWTON_STEPS)
        # ε = √(2F/F″); F on the crest from 32 digits, since E − V is small there
        gap = np.sqrt(2 * squares(some, place(formula, x)) / bend)
        low = sign * (x - lower[orbit]) / W
        # δ/sin φ_c: with x = sin²(φ/2), dx = ½ sin φ dφ and sin²φ = 4x(1 − x)
        gap = gap / (2 * W * low * (1 - low))
    return _narrowest(orbit, low, np.where(fine, gap, np.inf))


def singular_pairs(one: CoordinateOfOrbits, lower: Reals, width: Reals) -> BarrierTops:
    """Find where motions pass nearest by singularities of p²."""
    formula, n = sides(one.coordinate)[0], len(width)
    radius, sign = formula.clearance.radius, formula.sign

    def clear(fractions: Reals) -> Reals:
        """Return the clearance at some fractions of each motion, over its width."""
        return radius(lower[:, None] + sign * width[:, None] * fractions) / width[:, None]

    if formula.clearance.table() is None:
        return _narrowest(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0))
    with np.errstate(all="ignore"):
        nearest = np.argmin(clear(np.broadcast_to(_GRID, (n, _POINTS)))[:, 1:-1], axis=1) + 1
        low, high = _GRID[nearest - 1], _GRID[nearest + 1]
        for _ in range(_THIRDS):
            fractions = np.stack([low + (high - low) / 3, high - (high - low) / 3], axis=1)
            # the clearance has kinks: thirds of a bracket, no derivative
            first, second = clear(fractions).T
            low, high = np.where(first > second, fractions[:, 0], low), np.where(first > second, high, fractions[:, 1])
        middle = 0.5 * (low + high)
        gap = clear(middle[:, None])[:, 0] / (2 * middle * (1 - middle))
    return _narrowest(np.arange(n), middle, gap)


def _narrowest(orbit: Integers, low: Reals, gap: Reals) -> BarrierTops:
    """Return for each orbit the pair with the least distance ``gap``, (q_c − a)/W being ``low``."""
    fine = (low > 0) & (low < 1) & (gap < _WIDE) & (gap > 0)
    slowest = np.flatnonzero(fine)[np.argsort(gap[fine], kind="stable")]
    orbits, first = np.unique(orbit[slowest], return_index=True)
    chosen = slowest[first]
    level = np.clip(np.rint(-np.log2(0.5 * gap[chosen])), 1, MOST_LEVEL).astype(np.int64)
    maps = np.stack([np.full(len(level), BARRIER_TOP), level, level], axis=1)
    return BarrierTops(orbits, maps, low[chosen] / (1 - low[chosen]))
