"""The first pass over librations as compiled loops, orbit by orbit (extra ``fast``).

The same mathematics as ``locate``, ``roots`` and ``quadrature`` in doubles with plain anomalies; an orbit that is not
easy (a rotation, a start at rest, a slow series, a large claimed error) is left to those.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hjsolve.batch import nodes as tables
from hjsolve.batch.model import Model, Separated
from hjsolve.batch.programs import Programs, programs, start_program
from hjsolve.batch.quadrature import Sums, empty
from hjsolve.batch.start import Begin
from hjsolve.batch.views import Knowns

_COUNTS = tuple(count for count in tables.COUNTS if count <= 128)
_WIDEST = _COUNTS[-1]


@dataclass(frozen=True, eq=False)
class Tables:
    """Nodes of all sizes side by side, padded.

    Attributes:
        counts: sizes. warps: γ₁, γ₂. low, high, pace: see ``Nodes``, shape (warps, sizes, widest).
        last, middle: rows of cosines of the convergence test, shape (sizes, 5, widest), (sizes, 3, widest).
        cosines: all of them, shape (sizes, widest, widest).
        squares, slopes: see ``nodes.shifts``; plain and folded, shape (2, sizes, widest).
    """

    counts: Any
    warps: Any
    low: Any
    high: Any
    pace: Any
    last: Any
    middle: Any
    cosines: Any
    squares: Any
    slopes: Any


@cache
def _tables() -> Tables:
    size = len(_COUNTS)
    low, high, pace = (np.zeros((len(tables.WARPS), size, _WIDEST)) for _ in range(3))
    last, middle = np.zeros((size, 5, _WIDEST)), np.zeros((size, 3, _WIDEST))
    cosines = np.zeros((size, _WIDEST, _WIDEST))
    squares, slopes = (np.zeros((2, size, _WIDEST)) for _ in range(2))
    for k, count in enumerate(_COUNTS):
        table = tables.libration(count, 0)
        for warp in range(len(tables.WARPS)):
            other = tables.libration(count, 0, warp)
            low[warp, k, :count], high[warp, k, :count], pace[warp, k, :count] = other.low, other.high, other.pace
        last[k, :, :count], middle[k, :, :count] = table.cosines[table.last], table.cosines[table.middle][1:-1]
        cosines[k, : count - 1, :count] = table.cosines
        for fold in (1, 2):
            squares[fold - 1, k, :count], slopes[fold - 1, k, : count - 1] = tables.shifts(count, fold)
    return Tables(
        np.array(_COUNTS), np.array(tables.WARPS), low, high, pace, last, middle, cosines, squares, slopes
    )  # fmt: skip


def begin_compiled(model: Model, q: Any, p: Any) -> Begin:
    """Work out the constants in doubles; see ``start.begin``."""
    count, m = q.shape[1], len(model.constants)
    C, E, P = np.empty((m, count)), np.empty((m, count)), np.empty((len(model.separated), count))
    start_program(model)(q, p, C, E, P)
    numbers = tuple(pair.high for pair in model.numbers)
    return Begin(q[[c.index for c in model.separated]], P, p, Knowns(tuple(C), tuple(E), numbers), None)


def librations(model: Model, coordinate: Separated, start: Begin, k: int, *, kernels: bool, ripples: bool) -> Sums:
    """Integrate one coordinate of many orbits.

    Args:
        model: of the system. coordinate: the k-th separated one. start: of n orbits. k: its row.
        kernels, ripples: as in ``quadrature.integrate``.

    Returns:
        The sums, good only where this pass was enough.
    """
    count, m = start.q.shape[1], len(model.constants)
    sums = empty(m, count)
    numbers = tuple(pair.high for pair in model.numbers)
    made = programs(coordinate, m, numbers, kernels)
    floors = np.array(
        [
            side * np.inf if formula is None else formula.origin.high
            for side, formula in ((-1, coordinate.lower), (1, coordinate.upper))
        ]
    )
    C, E = np.stack(start.knowns.constants), np.stack(start.knowns.doubt)
    ends, table = np.empty((2, count)), _tables()
    search, loop = _loops(made, kernels, ripples)
    search(start.q[k], start.P[k], C, floors, np.pi if coordinate.periodic else np.inf, ends)
    loop(
        start.q[k], start.P[k], C, E, coordinate.even, table.warps, table.counts, table.low, table.high, table.pace,
        table.last, table.middle, table.cosines, table.squares, table.slopes, sums.action, sums.action_error,
        sums.means, sums.mean_errors, sums.ripples, sums.ripple_errors, sums.phase, sums.phase_error, sums.speeds,
        sums.good, ends[0], ends[1],
    )  # fmt: skip
    return sums


@cache
def _loops(made: Programs, kernels: bool, ripples: bool) -> tuple[Any, Any]:
    from hjsolve.batch.loops import kernel
    from hjsolve.batch.searches import ends

    return ends(made), kernel(made, kernels, ripples)
