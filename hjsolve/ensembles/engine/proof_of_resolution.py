"""Proof that the nodes of an orbit resolve p² and its kernels, so that nothing can hide between them.

The midpoint rule judges itself by its last coefficients (``kernels.midpoint_rule``): that says nothing of a dip
narrower than the distance of the nodes. So the rule is only believed where p² is proved to be known between the nodes:
its parts (``clearance``) are analytic in the strip about the nodes (``strips_of_analyticity``) and do not grow there.
Their coefficients then fall geometrically from the first one on, and what is beyond the nodes is less than the rounding
that claims count.

What is left are zeros of p² near the way, branch points of the integrands that clearances do not show. They cannot
hide, because S = p²/((q − a)(b − q)) is a function that its values at the nodes determine: where it nearly vanishes it
does so over several nodes, and the integrands, which go like S^(±½), then have last coefficients that do not fall.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.number_types import Complexes, Integers, Reals
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.kernels.clearance_tables import NOT_COVERED, UNTOLD, glances
from hjsolve.ensembles.engine.kernels.types import Clearances, Motions
from hjsolve.ensembles.engine.node_maps import COUNTS, NodeMaps

_FIRST = 64
"""Orbits for which a table of clearances is filled before the others are looked at again."""

_NARROW = 0.03
"""Width of a motion over its distance from the origin: sixteen of the narrowest cells of a table, which are 2⁻⁹ of that
(two bits of the size, halved ``DEEPEST`` times). A wider motion is told by its cells."""
_ALONG = np.linspace(-0.5, 0.5, 5)
"""Places of a motion from end to end, at which functions are looked at next to its disk."""
_HELD = COUNTS.index(40)
"""Size of the tables for which a small motion gets a disk of its own."""


def room(clearance: Clearance, middle: Reals, width: Reals) -> Reals:
    """Return the radius of the disk about the middle of a motion in which p² is known, in units of half its width.

    Args:
        clearance: of p².
        middle: offset of (a + b)/2 in the formula.
        width: b − a; arrays (n,).
    """
    with np.errstate(all="ignore"):
        return clearance.radius(middle) / (0.5 * width)


def least_at_a_glance(
    maps: NodeMaps, clearance: Clearance, constants: tuple[Reals, ...], middle: Reals, width: Reals
) -> Integers:
    """Return the first size that one disk about the middle of a motion proves to be enough, −1 for none."""
    known = np.nan_to_num(room(clearance, middle, width), nan=-1.0)
    # the disk about the middle that holds the whole strip, one radius for each size: one look at the table does for
    # most
    enough = maps.strips.enough[0]
    least = np.searchsorted(-enough, -known)
    some = np.flatnonzero((least > _HELD) & (width < _NARROW * np.abs(middle)))
    # a motion far narrower than its distance from the origin gets a disk that is proved for it alone
    if len(some):  # cells are too large for it
        x, W = middle[some, None], width[some, None]
        chosen = tuple(c[some] for c in constants)
        held = clearance.holds(chosen, x, 0.5 * enough[_HELD] * W, x + W * _ALONG)
        least[some[held]] = _HELD
    least[least == len(COUNTS)] = -1
    return least


@dataclass(frozen=True)
class ResolutionProof:
    """How many nodes resolve motions between turning points, by glances at the tables of clearances.

    Attributes:
        maps: that the motions name.
        motions: of n orbits.
        below, above: clearances in the views of the lower and of the upper half.
    """

    maps: NodeMaps
    motions: Motions
    below: Clearance
    above: Clearance

    def least(self, left: Integers, maps: Integers, span: Integers) -> Integers:
        """Return the first size that is proved to resolve some orbits, −1 for none.

        The tables grow until they tell for all.

        Args:
            left: which orbits.
            maps: how their nodes are placed.
            span: the sizes to look at, first and end, shape (2, len(left)); the first ones move on.
        """
        least = np.full(len(left), -1, dtype=np.int64)
        if self.below.table() is None or self.above.table() is None:
            return least
        lower, W = self.motions.lower[left], self.motions.width[left]
        known = room(self.below, lower + 0.5 * self.motions.signs[0] * W, W)
        todo, block, last = np.flatnonzero(W > 0), _FIRST, np.empty(0, dtype=np.int64)
        while len(todo):
            low, high = (Clearances(*side.table()) for side in (self.below, self.above))  # type: ignore[misc]
            glances(self.motions, left, maps, todo, known, span, self.maps.strips, low, high, least)
            found = least[todo]
            bare = todo[found == NOT_COVERED]
            # strips are covered as they are met, once for all orbits
            for map_, size in set(zip(maps[bare].tolist(), span[0, bare].tolist(), strict=True)):
                self.maps.cover(map_, size)
            untold = todo[found == UNTOLD][:block]
            filled = untold * len(COUNTS) + span[0, untold]
            if len(filled) and np.array_equal(filled, last):  # places on the edge of a cell, which roundings move
                least[untold] = -1
            last = filled
            self._fill(left[untold], maps[untold], span[0, untold])
            todo = todo[(least[todo] == UNTOLD) | (least[todo] == NOT_COVERED)]
            # the first orbits fill most of the table for the others
            block *= 4
        return least

    def _fill(self, some: Integers, maps: Integers, sizes: Integers) -> None:
        """Complete the tables for some orbits."""
        strips, motions = self.maps.strips, self.motions
        codes, low, high = maps * len(COUNTS) + sizes, [np.empty(0, dtype=complex)], [np.empty(0, dtype=complex)]
        for code in np.unique(codes):
            part = some[codes == code]
            count, below, start = strips.counts[:, code // len(COUNTS), code % len(COUNTS)]
            window, W = slice(start, start + count), motions.width[part, None]
            z = strips.along[window] + 1j * strips.away[window]
            barrier_top = motions.barrier_top[part, None]
            near, far = _moved(z[:below], barrier_top), _moved(z[below:], 1 / barrier_top)
            low.append((motions.lower[part, None] + W * _seen(near, motions.signs[0])).ravel())
            high.append((motions.upper[part, None] + W * _seen(far, motions.signs[1])).ravel())
        self.below.radius(np.concatenate(low))  # all at once: what a table costs is calls of numpy
        self.above.radius(np.concatenate(high))


def _moved(z: Complexes, barrier_top: Reals) -> Complexes:
    """Take places along with the crest, as ``clearance_tables`` does; above the real axis."""
    found: Complexes = barrier_top * z / (1 + (barrier_top - 1) * z)
    return np.asarray(found.real + 1j * np.abs(found.imag))


def _seen(z: Complexes, sign: float) -> Complexes:
    return np.asarray(sign * z.real + 1j * z.imag)
