"""Looks at tables of clearances: which number of nodes is proved to resolve an orbit; see ``proof_of_resolution``.

N nodes resolve a function that is analytic over |Im χ| ≤ a with 2aN ≥ ``strips_of_analyticity.EXPONENT`` (Trefethen &
Weideman, SIAM Review 56 (2014) 385, Theorem 3.1); the tables hold the disks that cover such strips.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.machine.compiling import inlined, kernel
from hjsolve.arithmetic.machine.intrinsics import as_bits
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.types import Clearances, Motions, Strips

DROPPED = 50
"""Bits of a double that do not tell its cell: what is left are the exponent and two more."""
QUARTER = 4
"""Cells in a quarter of a turn."""
DEEPEST = 7
"""How often a cell may be halved in both directions."""
_DROPPED, _QUARTER, _DEEPEST, _TURNS = DROPPED, QUARTER, DEEPEST, QUARTER << DEEPEST
NOT_COVERED, UNTOLD = -3, -2
"""In place of a size: its strip is not covered yet; a table does not tell yet. −1 is: no size is enough."""


@inlined
def _radius(re: float, im: float, table: Clearances) -> float:
    """Return the radius in the table, 0 where it is not known yet; see ``clearance``. Without branches.

    They cost most.
    """
    size = abs(re) + im
    turn = min(int(im / size * _TURNS), _TURNS - 1) if size > 0.0 else 0
    # the left half plane has cells of its own, numbered on from the right one's
    turn = 2 * _TURNS - 1 - turn if re < 0.0 else turn
    along = as_bits(size) >> (_DROPPED - _DEEPEST)
    large = (along >> _DEEPEST) * (2 * _QUARTER) + (turn >> _DEEPEST)
    first, halved = table.start[large], int(table.depth[large])
    # cell numbers at the finest division, shifted to that of this large cell
    rest, within = _DEEPEST - halved, (1 << halved) - 1
    place = first + (((along >> rest) & within) << halved) + ((turn >> rest) & within)
    return table.radii[max(place, 0)]


@inlined
def _moved(along: float, away: float, spread: float, barrier_top: float) -> tuple[float, float, float]:
    """Take a disk z along with the crest: z′ = crest z/T, T = 1 + (crest − 1) z; infinite where T may vanish in it.

    Two places are crest (z₂ − z₁)/(T₁ T₂) apart.
    """
    more = barrier_top - 1.0
    re, im = 1.0 + more * along, more * away
    square = re * re + im * im
    size = np.sqrt(square)
    nearest = size - abs(more) * spread
    if not nearest > 0.0:
        return along, away, np.inf
    x = barrier_top * (along * re + away * im) / square
    y = barrier_top * (away * re - along * im) / square
    return x, abs(y), barrier_top * spread / (size * nearest)


@inlined
def _failing(motions: Motions, i: int, place: tuple[int, int], first: int, strips: Strips, low: Clearances,
             high: Clearances) -> int:  # fmt: skip
    """Return the first disk of a strip that is not known, from one of them on and around; ``count`` where all are.

    −1 where the table does not tell yet.
    """
    W, (m, size) = motions.width[i], place
    count, below, start = strips.counts[0, m, size], strips.counts[1, m, size], strips.counts[2, m, size]
    j, barrier_top = first, motions.barrier_top[i]
    for _ in range(count):
        k = start + j
        along, away, spread = strips.along[k], strips.away[k], strips.spread[k]
        if barrier_top != 1.0:
            along, away, spread = _moved(along, away, spread, barrier_top if j < below else 1.0 / barrier_top)
            if spread == np.inf:  # there is no place to look at
                return j
        if j < below:
            radius = _radius(motions.lower[i] + motions.signs[0] * W * along, W * away, low)
        else:
            radius = _radius(motions.upper[i] + motions.signs[1] * W * along, W * away, high)
        if radius == 0.0:
            return -1
        if not radius >= W * spread:
            return j
        # from the disk that failed last, and around: the next size fails at the same place, if at all
        j = j + 1 if j + 1 < count else 0
    return count


@kernel
def glances(motions: Motions, orbits: Integers, maps: Integers, todo: Integers, room: Reals, span: Integers,
            strips: Strips, low: Clearances, high: Clearances, least: Integers) -> None:  # fmt: skip
    """Return the first size that is proved to resolve an orbit: −1 for none, −2 where a table does not tell yet.

    Args:
        motions: of all orbits.
        orbits, maps: those that are asked for, and how their nodes are placed, shape (n,).
        todo: which of these are looked at.
        room: see ``proof_of_resolution.room``, shape (n,).
        span: the sizes that are looked at, first and end, shape (2, n). The first moves on to where the tables failed.
        strips: the disks.
        low, high: tables for the views of the lower and of the upper half.
        least: where the results go, shape (n,); −3 where a strip is not covered yet.
    """
    for t in todo:
        i, m = orbits[t], maps[t]
        least[t] = -1
        if not motions.width[i] > 0.0:
            continue
        worst = 0.0  # how far along the strip disks are looked at first: where the last one failed
        for size in range(span[0, t], span[1, t]):
            if room[t] >= strips.enough[m, size]:
                least[t] = size
                break
            count = strips.counts[0, m, size]
            span[0, t] = size
            if count < 0:
                least[t] = NOT_COVERED
                break
            seen = _failing(motions, i, (m, size), int(worst * count), strips, low, high)
            if seen < 0 or seen == count:
                least[t] = size if seen == count else UNTOLD
                break
            worst = seen / count
