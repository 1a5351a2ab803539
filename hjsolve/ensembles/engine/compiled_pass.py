"""The first pass over librations as compiled loops, orbit by orbit (extra ``fast``).

The same mathematics as ``regions``, ``turning_points`` and ``midpoint_rule`` in doubles with plain anomalies; an orbit
that is not easy (a rotation, a start at rest, a slow series, a large claimed error) is left to those.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hjsolve.ensembles.engine import nodes as tables
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.constants import InitialConstants, momentum_errors
from hjsolve.ensembles.engine.lowered_solution import Model, Separated
from hjsolve.ensembles.engine.midpoint_rule import Sums, empty
from hjsolve.ensembles.engine.programs import Compiled
from hjsolve.ensembles.engine.radicand_views import Knowns
from hjsolve.ensembles.engine.resolution import room
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.strips_of_analyticity import across, covered_strip

_COUNTS = (16, 24, 32, 40, 48, 56, 64, 72, 80, 96, 112, 128)
"""Numbers of nodes: whole vectors."""

_WIDEST = _COUNTS[-1]
_UNTOLD = -2
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
        table = tables.libration_nodes(count, 0)
        last[k, :, :count], middle[k, :, :count] = table.cosines[table.last], table.cosines[table.middle][1:-1]
        cosines[k, : count - 1, :count] = table.cosines
        for fold in (1, 2):
            squares[fold - 1, k, :count], slopes[fold - 1, k, : count - 1] = tables.shifts(count, fold)
    return (
        np.array(tables.WARPS), np.array(_COUNTS), low, high, pace, last, middle, cosines, squares, slopes
    )  # fmt: skip


def begin_compiled(model: Model, made: Compiled, starts: Starts) -> InitialConstants:
    """Work out the constants in doubles; see ``constants.initial_constants``.

    Args:
        model: the lowered solution.
        made: its programs.
        starts: of n orbits.
    """
    q, p = starts.q, starts.p
    count, m = q.shape[1], len(model.constants)
    C, E, P = np.empty((m, count)), np.empty((m, count)), np.empty((len(model.separated), count))
    made.start(q, p, starts.doubt, C, E, P)
    numbers = tuple(pair.high for pair in model.numbers)
    places = q[[c.index for c in model.separated]]
    knowns = Knowns(tuple(C), tuple(E), numbers)
    return InitialConstants(places, P, starts, knowns, None, momentum_errors(model, starts))


def librations(coordinate: Separated, made: Compiled, start: InitialConstants, k: int, *, ripples: bool) -> Sums:
    """Integrate one coordinate of many orbits.

    Args:
        coordinate: the k-th separated one.
        made: the programs.
        start: of n orbits.
        k: its row.
        ripples: as in ``midpoint_rule.integrate``; whether kernels are wanted, the programs know.

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
    proof = _Proof(coordinate.plain.clearance, made.glance, lower, upper)
    even = coordinate.even & (np.abs(lower + upper) <= 1e-13 * (upper - lower))
    warps = np.where(even, tables.EVEN, 0)
    least = proof.least(np.arange(count), warps, np.zeros(count, dtype=np.int64), len(_COUNTS))
    chosen = np.zeros((2, count), dtype=np.int64)
    results = (
        sums.action, sums.action_error, sums.means, sums.mean_errors, sums.ripples, sums.ripple_errors, sums.phase,
        sums.phase_error, sums.speeds, sums.good, chosen,
    )  # fmt: skip
    made.coordinates[k].loop(ripples, start.q[k], start.P[k], C, E, lower, upper, least, warps, _tables(), results)
    crowded = np.flatnonzero(sums.good & (chosen[1] != warps))
    if len(crowded):
        size, warp = chosen[:, crowded]
        sums.good[crowded] = proof.least(crowded, warp, size, size + 1) >= 0
    return sums


@cache
def _strips() -> tuple[Any, ...]:
    """Disks over the strips of all crowdings and sizes, padded; see ``compiled_clearance``."""
    folds = [2 if warp >= tables.EVEN else 1 for warp in range(len(tables.WARPS))]
    nodes = [[tables.libration_nodes(n, 0, warp) for n in _COUNTS] for warp in range(len(folds))]
    rows = [[covered_strip(table, turning=True) for table in row] for row in nodes]
    shape = (len(folds), len(_COUNTS))
    low, high, spread = (np.zeros((*shape, max(len(one.low) for row in rows for one in row))) for _ in range(3))
    counts = np.zeros(shape, dtype=np.int64)
    for k, row in enumerate(rows):
        for m, one in enumerate(row):
            n = counts[k, m] = len(one.low)
            low[k, m, :n], high[k, m, :n], spread[k, m, :n] = one.low.real, np.abs(one.low.imag), one.spread
    enough = [[across(n, tables.WARPS[k], fold) for n in _COUNTS] for k, fold in enumerate(folds)]
    return np.array(enough), low, high, spread, counts


@dataclass(frozen=True)
class _Proof:
    """How many nodes resolve motions between turning points, by glances at the table of clearances.

    Attributes:
        clearance: of p².
        glance: the compiled loop.
        lower, upper: turning points, arrays (n,).
    """

    clearance: Clearance
    glance: Any
    lower: Any
    upper: Any

    def least(self, left: Any, warps: Any, begin: Any, end: Any) -> Any:
        """The first size that is proved to resolve some orbits, −1 for none; the table grows until it tells for all.

        Args:
            left: which orbits.
            warps: how their nodes are crowded.
            begin, end: the sizes to look at.
        """
        least = np.full(len(left), -1, dtype=np.int64)
        if self.clearance.table() is None:
            return least
        lower, upper, end = self.lower[left], self.upper[left], np.broadcast_to(end, len(left))
        known, todo, block = room(self.clearance, 0.5 * (lower + upper), upper - lower), np.arange(len(left)), _FIRST
        while len(todo):
            found = np.empty(len(todo), dtype=np.int64)
            arrays = (x[todo] for x in (lower, upper, known, warps, begin, end))
            self.glance(*arrays, *_strips(), self.clearance.table(), found)
            least[todo] = found
            todo = todo[found == _UNTOLD]
            self._fill(lower, upper, todo[:block], warps, begin, end)
            block *= 4
        return least

    def _fill(self, lower: Any, upper: Any, some: Any, warps: Any, begin: Any, end: Any) -> None:
        """Complete the table for all sizes that are looked at for some orbits."""
        _, low, high, _, counts = _strips()
        for size in range(len(_COUNTS)):
            for warp in np.unique(warps[some]):
                part = some[(warps[some] == warp) & (begin[some] <= size) & (size < end[some])]
                n, W = counts[warp, size], (upper - lower)[part, None]
                if len(part):
                    self.clearance.radius(lower[part, None] + W * (low[warp, size, :n] + 1j * high[warp, size, :n]))
