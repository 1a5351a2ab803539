"""Looks at a table of clearances in compiled loops; see ``resolution``. Only imported where numba is."""

from __future__ import annotations

from typing import Any

from numba import njit

from hjsolve.batch.clearance import DROPPED, QUARTER
from hjsolve.batch.elementary import OPTIONS, as_bits
from hjsolve.batch.nodes import EVEN

_DROPPED, _QUARTER, _EVEN = DROPPED, QUARTER, EVEN


@njit(**OPTIONS)
def _radius(re, im, depth, start, radii):
    """The radius in the table, 0 where it is not known yet; see ``clearance``."""
    size = abs(re) + im
    share = im / size if size > 0.0 else 0.0
    turn = min(int(share * _QUARTER), _QUARTER - 1)
    bits = as_bits(size)
    large = (bits >> _DROPPED) * (2 * _QUARTER) + (2 * _QUARTER - 1 - turn if re < 0.0 else turn)
    first = start[large]
    if first < 0:
        return 0.0
    halved = depth[large]
    if halved == 0:
        return radii[first]
    along = bits >> (_DROPPED - halved)
    cells = _QUARTER << halved
    turn = min(int(share * cells), cells - 1)
    turn = 2 * cells - 1 - turn if re < 0.0 else turn
    within = (1 << halved) - 1
    return radii[first + ((along & within) << halved) + (turn & within)]


@njit(**OPTIONS)
def _look(a, W, low, high, spread, count, table):
    """1 where all disks of a strip are known, 0 where not, −1 where the table does not tell yet."""
    depth, start, radii = table
    for j in range(count):
        radius = _radius(a + W * low[j], W * high[j], depth, start, radii)
        if radius == 0.0:
            return -1
        if not radius >= W * spread[j]:
            return 0
    return 1


def glances(lower, upper, room, even, enough, low, high, spread, counts, table, least):
    """The first size that is proved to resolve an orbit: −1 for none, −2 where the table does not tell yet.

    Args:
        lower, upper, room: of n orbits; see ``resolution.room``.
        even: True where motions about 0 are even.
        enough: what ``room`` must be, shape (2, sizes); the second row is for even motions.
        low, high, spread: the disks, in units of b − a, shape (2, sizes, widest). counts: how many, shape (2, sizes).
        table: of clearances. least: where the results go.
    """
    for i in range(lower.shape[0]):
        a, W = lower[i], upper[i] - lower[i]
        kind = 1 if even and abs(lower[i] + upper[i]) <= 1e-13 * W else 0
        least[i] = -1
        if not W > 0.0:
            continue
        for size in range(enough.shape[1]):
            if room[i] >= enough[kind, size]:
                least[i] = size
                break
            seen = _look(a, W, low[kind, size], high[kind, size], spread[kind, size], counts[kind, size], table)
            if seen != 0:
                least[i] = size if seen > 0 else -2
                break


BOUND: tuple[Any, ...] = (glances,)
"""See ``rules.BOUND``."""
