"""Which maps of nodes serve librations, by what p² does at their ends: the loop of ``libration_ends``.

p² = (q − a)(b − q) S. With W the width, W·|S′/S| at an end is W over the distance of the zero or pole next to it:
1 + ρ_d at the lower end, 1 + ρ_c at the upper one (``node_maps``), and 1/k′² = (1 + ρ_d)(1 + ρ_c).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.machine.compiling import inlined, kernel
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.crowding import EVEN

_NEAR = 3.0
"""W over the distance of what is next to a turning point, minus 1, from which it counts. Without such a thing p² is
nearly quadratic, W S′/S ≈ ∓1, and the measure is of the curvature of S alone."""
_STRETCHED = 16.0
"""(1 + ρ_d)(1 + ρ_c) from which on nodes are stretched: below, the elliptic map gains less than crowding does."""
_WARPED = 5
"""Elliptic maps have k′ = 2⁻⁵ and less, as k′² = 2^−(i + j): above, their nodes lie as near to the ends as crowded
ones."""
FROM_MIDDLE, FROM_BELOW, FROM_ABOVE = 0, 1, 2
"""Which end most nodes are seen from; the numbers that the other kernels know."""
_TALL = 100.0
"""How much larger p² may be next to one end than next to the other before that end is only seen from close by."""


@inlined
def _nearby(first: float, bend: float, sign: float, width: float) -> float:
    """Return 1 + ρ of an end: 1 where nothing is next to it."""
    ρ = abs(width * bend / (sign * first) + 1)
    return 1 + ρ if _NEAR < ρ < np.inf else 1.0


@inlined
def _fitting(lower: float, upper: float, even: bool, most: int, kinds: Integers, k: int) -> None:
    """Write the clustering and the logarithms to base 2 of 1 + ρ of the map that serves a motion."""
    # 1 + ρ as a power of two: the convergence changes little with it, the integral not at all
    i, j = int(np.rint(np.log2(lower))), int(np.rint(np.log2(upper)))
    if even:
        i = j = max(i, j)
    # k′² = 2^−(i + j) must be a power of 4, of which there are tables
    odd = (i + j) % 2
    i, j = (i + odd, j) if i >= j else (i, j + odd)
    room = 2 * most
    i, j = (min(i, most), min(j, most)) if even else (min(i, room), min(j, room))
    # too near for the tables: the nearer end gives way, and takes more nodes
    excess = max(i + j - room, 0)
    i, j = (i - excess, j) if i >= j else (i, j - excess)
    far = i + j >= 2 * _WARPED
    # the fraction of the logarithms of both ends says where in the period nearly all of the motion happens
    where = 1 + int(np.rint(4 * i / max(i + j, 1))) if far else 0
    kinds[k, 0] = EVEN + far if even else where
    kinds[k, 1], kinds[k, 2] = i, j


@inlined
def _view(lower: float, upper: float, below: float, above: float) -> int:
    """Tell how a motion is divided between its ends: what most nodes are seen from.

    What is lost at a turning point is small next to p² there, and not where p² is smaller by far. Near escape p² is
    large far out: only what is nearer to that end than its own scale, W/(1 + ρ), is seen from it.
    """
    # p² next to an end goes as far as its own scale, with this slope
    low, high = abs(lower) / below, abs(upper) / above
    if high > _TALL * low:
        return FROM_BELOW
    return FROM_ABOVE if low > _TALL * high else FROM_MIDDLE


@kernel
def maps_of_ends(
    bends: Reals, signs: Reals, even: Mask, width: Reals, most: int, alike: bool, kinds: Integers, fraction: Integers
) -> None:
    """Choose the maps of n librations.

    Args:
        bends: F′ and ½F″ of the lower and of the upper end, shape (2, 2, n).
        signs: how offsets grow away from them, shape (2,).
        even: True where the motion is even about its middle, ρ_d = ρ_c.
        width: of the motions.
        most: largest level of the tables, of k′² = 4^−level.
        alike: whether both ends are as if like the worse one.
        kinds: filled with the clustering and the logarithms to base 2 of 1 + ρ_d and 1 + ρ_c, shape (n, 3).
        fraction: filled with how much is seen from below.
    """
    for k in range(width.shape[0]):
        lower = _nearby(bends[0, 0, k], bends[0, 1, k], signs[0], width[k])
        upper = _nearby(bends[1, 0, k], bends[1, 1, k], signs[1], width[k])
        if alike:
            lower = upper = max(lower, upper)
        worst = max(lower, upper)
        if (worst * worst if even[k] else lower * upper) >= _STRETCHED:
            _fitting(lower, upper, even[k], most, kinds, k)
        else:
            kinds[k, 0], kinds[k, 1], kinds[k, 2] = EVEN if even[k] else 0, 0, 0
        # an even motion is seen from one end over half of it, and mirrored
        fraction[k] = FROM_MIDDLE if even[k] else _view(bends[0, 0, k], bends[1, 0, k], lower, upper)
