"""Looks at a table of clearances in compiled loops; see ``resolution``. Only imported where numba is."""

from __future__ import annotations

from typing import Any

from numba import njit

from hjsolve.ensembles.engine.clearance import DEEPEST, DROPPED, QUARTER
from hjsolve.ensembles.engine.elementary import OPTIONS, as_bits

_DROPPED, _QUARTER, _DEEPEST, _TURNS = DROPPED, QUARTER, DEEPEST, QUARTER << DEEPEST


@njit(**OPTIONS)
def _radius(re, im, depth, start, radii):
    """The radius in the table, 0 where it is not known yet; see ``clearance``. Without branches: they cost most."""
    size = abs(re) + im
    turn = min(int(im / size * _TURNS), _TURNS - 1) if size > 0.0 else 0
    turn = 2 * _TURNS - 1 - turn if re < 0.0 else turn
    along = as_bits(size) >> (_DROPPED - _DEEPEST)
    large = (along >> _DEEPEST) * (2 * _QUARTER) + (turn >> _DEEPEST)
    first, halved = start[large], int(depth[large])
    rest, within = _DEEPEST - halved, (1 << halved) - 1
    place = first + (((along >> rest) & within) << halved) + ((turn >> rest) & within)
    return radii[max(place, 0)]


@njit(**OPTIONS)
def _failing(a, W, low, high, spread, first, count, table):
    """The first disk of a strip that is not known, from one of them on and around; ``count`` where all are.

    −1 where the table does not tell yet.
    """
    depth, start, radii = table
    j = first
    for _ in range(count):
        radius = _radius(a + W * low[j], W * high[j], depth, start, radii)
        if radius == 0.0:
            return -1
        if not radius >= W * spread[j]:
            return j
        j = j + 1 if j + 1 < count else 0
    return count


def glances(lower, upper, room, warps, begin, end, enough, low, high, spread, counts, table, least):
    """The first size that is proved to resolve an orbit: −1 for none, −2 where the table does not tell yet.

    Args:
        lower, upper, room: of n orbits; see ``resolution.room``.
        warps, begin, end: how nodes are crowded, and the sizes that are looked at, shape (n,).
        enough: what ``room`` must be, shape (warps, sizes).
        low, high, spread: the disks, in units of b − a, shape (warps, sizes, widest).
        counts: how many of them.
        table: of clearances.
        least: where the results go.
    """
    for i in range(lower.shape[0]):
        a, W, k = lower[i], upper[i] - lower[i], warps[i]
        least[i] = -1
        if not W > 0.0:
            continue
        worst = 0.0  # how far along the strip disks are looked at first: where the last one failed
        for size in range(begin[i], end[i]):
            if room[i] >= enough[k, size]:
                least[i] = size
                break
            count = counts[k, size]
            seen = _failing(a, W, low[k, size], high[k, size], spread[k, size], int(worst * count), count, table)
            if seen < 0 or seen == count:
                least[i] = size if seen == count else -2
                break
            worst = seen / count


BOUND: tuple[Any, ...] = (glances,)
"""See ``compiled_rule.BOUND``."""
