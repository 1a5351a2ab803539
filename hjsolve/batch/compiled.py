"""The first pass over librations as compiled loops, orbit by orbit (extra ``fast``).

The same mathematics as ``locate``, ``roots`` and ``quadrature`` in doubles with plain anomalies; an orbit that is not
easy (a rotation, a start at rest, a slow series, a large claimed error) is left to those.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from hjsolve.batch import nodes as tables
from hjsolve.batch.model import Model, Separated
from hjsolve.batch.programs import Compiled
from hjsolve.batch.quadrature import Region, Sums, empty
from hjsolve.batch.resolution import resolved, room
from hjsolve.batch.start import Begin
from hjsolve.batch.strips import across, strip
from hjsolve.batch.views import Knowns, Raw

_COUNTS = (16, 24, 32, 40, 48, 56, 64, 72, 80, 96, 112, 128)
"""Numbers of nodes: whole vectors."""

_WIDEST = _COUNTS[-1]
_FIRST = 64
"""Orbits for which a table of clearances is filled before the others are looked at again."""


@cache
def _tables() -> tuple[Any, ...]:
    """Nodes of all sizes side by side, padded.

    Returns:
        γ₁ and γ₂, shape (warps, 2). Sizes. ``Nodes.low``, ``high``, ``pace``, shape (warps, sizes, widest). Rows of
        cosines of the convergence test, last ones and middle ones, shape (sizes, 5 or 3, widest). All of them, shape
        (sizes, widest, widest). ``nodes.shifts``, plain and folded, shape (2, sizes, widest).
    """
    size = len(_COUNTS)
    low, high, pace = (np.zeros((len(tables.WARPS), size, _WIDEST)) for _ in range(3))
    last, middle = np.zeros((size, 5, _WIDEST)), np.zeros((size, 3, _WIDEST))
    cosines = np.zeros((size, _WIDEST, _WIDEST))
    squares, slopes = (np.zeros((2, size, _WIDEST)) for _ in range(2))
    for warp in range(len(tables.WARPS)):
        for part, places in zip((low, high, pace), tables.libration_places(_COUNTS, warp), strict=True):
            for k, row in enumerate(np.split(places, np.cumsum(_COUNTS)[:-1])):
                part[warp, k, : len(row)] = row
    for k, count in enumerate(_COUNTS):
        table = tables.libration(count, 0)
        last[k, :, :count], middle[k, :, :count] = table.cosines[table.last], table.cosines[table.middle][1:-1]
        cosines[k, : count - 1, :count] = table.cosines
        for fold in (1, 2):
            squares[fold - 1, k, :count], slopes[fold - 1, k, : count - 1] = tables.shifts(count, fold)
    return (
        np.array(tables.WARPS), np.array(_COUNTS), low, high, pace, last, middle, cosines, squares, slopes
    )  # fmt: skip


def begin_compiled(model: Model, made: Compiled, q: Any, p: Any) -> Begin:
    """Work out the constants in doubles; see ``start.begin``."""
    count, m = q.shape[1], len(model.constants)
    C, E, P = np.empty((m, count)), np.empty((m, count)), np.empty((len(model.separated), count))
    made.start(q, p, C, E, P)
    numbers = tuple(pair.high for pair in model.numbers)
    return Begin(q[[c.index for c in model.separated]], P, p, Knowns(tuple(C), tuple(E), numbers), None)


def librations(coordinate: Separated, made: Compiled, start: Begin, k: int, *, ripples: bool) -> Sums:
    """Integrate one coordinate of many orbits.

    Args:
        coordinate: the k-th separated one. made: the programs. start: of n orbits. k: its row.
        ripples: as in ``quadrature.integrate``; whether kernels are wanted, the programs know.

    Returns:
        The sums, good only where this pass was enough.
    """
    C, E = np.stack(start.knowns.constants), np.stack(start.knowns.doubt)
    count = start.q.shape[1]
    sums, ends = empty(len(C), count), np.empty((2, count))
    floors = np.array(
        [
            side * np.inf if formula is None else formula.origin.high
            for side, formula in ((-1, coordinate.lower), (1, coordinate.upper))
        ]
    )
    made.coordinates[k].search(start.q[k], start.P[k], C, floors, np.pi if coordinate.periodic else np.inf, ends)
    lower, upper = ends
    least = _least(coordinate, made.glance, lower, upper)
    chosen = np.zeros((2, count), dtype=np.int64)
    results = (
        sums.action, sums.action_error, sums.means, sums.mean_errors, sums.ripples, sums.ripple_errors, sums.phase,
        sums.phase_error, sums.speeds, sums.good, chosen,
    )  # fmt: skip
    program = made.coordinates[k]
    program.loop(
        ripples, coordinate.even, start.q[k], start.P[k], C, E, lower, upper, least, _tables(), results
    )  # fmt: skip
    crowded = np.flatnonzero(sums.good & (chosen[1] != 0) & (chosen[1] != tables.EVEN))
    if len(crowded):
        region = _region(coordinate, start, k, lower, upper).take(crowded)
        sums.good[crowded] = _resolved(region, chosen[:, crowded])
    return sums


@cache
def _strips() -> tuple[Any, ...]:
    """Disks over the strips of all sizes, for plain motions and for even ones, padded; see ``glances.glances``."""
    all_ = [
        [strip(tables.libration(count, 0, warp), turning=True) for count in _COUNTS] for warp in (0, tables.EVEN)
    ]
    widest = max(len(s.low) for row in all_ for s in row)
    low, high, spread = (np.zeros((2, len(_COUNTS), widest)) for _ in range(3))
    counts = np.zeros((2, len(_COUNTS)), dtype=np.int64)
    for k, row in enumerate(all_):
        for m, one in enumerate(row):
            n = counts[k, m] = len(one.low)
            low[k, m, :n], high[k, m, :n], spread[k, m, :n] = one.low.real, np.abs(one.low.imag), one.spread
    enough = [[across(count, (0.0, 0.0), fold) for count in _COUNTS] for fold in (1, 2)]
    return np.array(enough), low, high, spread, counts


def _least(coordinate: Separated, glance: Any, lower: Any, upper: Any) -> Any:
    """The first size that is proved to resolve each orbit, −1 for none; the table grows until it tells for all."""
    clearance = coordinate.plain.clearance
    least = np.full(len(lower), -1, dtype=np.int64)
    if clearance.table() is None:
        return least
    proved = room(clearance, 0.5 * (lower + upper), upper - lower)
    enough, low, high, spread, counts = _strips()
    left, block = np.arange(len(lower)), _FIRST
    while len(left):
        found = least[left]
        glance(
            lower[left], upper[left], proved[left], coordinate.even, enough, low, high, spread, counts,
            clearance.table(), found,
        )  # fmt: skip
        least[left] = found
        left = left[found == -2]
        for kind in range(2):  # what is looked at is looked at in full
            some = left[:block]
            for size in range(len(_COUNTS)):
                n = counts[kind, size]
                W = (upper - lower)[some, None]
                clearance.radius(lower[some, None] + W * (low[kind, size, :n] + 1j * high[kind, size, :n]))
        block *= 4
    return least


def _region(coordinate: Separated, start: Begin, k: int, lower: Any, upper: Any) -> Region:
    """The region of n orbits as numpy's passes see it."""
    view, zero, none = Raw(coordinate.plain, start.knowns), 0.0 * lower, np.zeros(len(lower), dtype=int)
    left, right = start.q[k] - lower, upper - start.q[k]
    return Region(view, view, lower, upper, upper - lower, zero, zero, none, none, start.P[k], left, right)


def _resolved(region: Region, chosen: Any) -> Any:
    """Prove what a glance at the clearance did not show; see ``resolution``."""
    good = np.zeros(len(region.width), dtype=bool)
    for size in np.unique(chosen[0]):
        part = np.flatnonzero(chosen[0] == size)
        good[part] = resolved(replace(region.take(part), warp=chosen[1, part]), _COUNTS[size])
    return good
