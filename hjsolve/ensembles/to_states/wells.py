"""The wells that tori lie in, seen on samples of p², and where p² has other maxima."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import offset, place
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.programs import SystemPrograms, sides
from hjsolve.ensembles.to_states.newton_on_actions import Solved
from hjsolve.ensembles.to_states.tori import AngleTask, Tori

_VALUES = 1 << 20
"""Values of p² that are held at once."""
_SAME = 1e-6
"""How far apart, over the size of all actions, constants of one torus may be: what Newton's method leaves, and more."""
_MARGIN = 1e-9
"""By what part of itself a place may lie beyond a turning point, as for single motions."""
_BESIDE_ENDS = 0.02
"""By what part of its width the well of a torus may reach beyond its turning points, which are those of a torus next to
it on the way."""
_WELLS = 4
"""How many other wells of one coordinate are looked at."""


class Wells(NamedTuple):
    """The well of one coordinate that each of n tori lies in, on samples.

    Attributes:
        low, high: ends of it, shape (n,).
        others: places of other maxima of p², shape (wells, n); NaN where there are fewer.
        beside: where p² > 0 at one of them: another well, with the same constants.
    """

    low: Reals
    high: Reals
    others: Reals
    beside: Mask

    def take(self, index: Integers | Mask) -> Wells:
        """Return those of some tori."""
        return Wells._make(x[..., index] for x in self)


class Landscape(NamedTuple):
    """A system, and the places at which p² is looked at.

    Attributes:
        model, programs: the system.
        grids: of each separated coordinate, ascending.
        several: which coordinates have several wells, as far as seeds tell.
    """

    model: Model
    programs: SystemPrograms
    grids: Sequence[Reals]
    several: tuple[bool, ...]

    @classmethod
    def of(cls, model: Model, programs: SystemPrograms, grids: Sequence[Reals], seeds: Tori) -> Landscape:
        """Look which coordinates of tori have several wells.

        Args:
            grids: places that show the domain of each coordinate.
            seeds: tori of all kinds.
        """
        everywhere = cls(model, programs, grids, (True,) * len(grids))
        found = everywhere.wells(seeds, np.zeros(seeds.q.shape, dtype=bool))
        return everywhere._replace(several=tuple(bool(one.beside.any()) for one in found))

    @property
    def task(self) -> AngleTask:
        """The system with its programs."""
        return AngleTask(self.model, self.programs)

    def wells(self, tori: Tori, rotating: Mask, *, every: bool = False) -> list[Wells]:
        """Return the wells of all coordinates.

        Args:
            rotating: which go round, shape (separated, n): all of a turn is their well.
            every: whether wells are told from one another: the ends of an only one are wanted, and all that are alike.
        """
        found = self.unseen(tori.q.shape[1])
        for k, (grid, one) in enumerate(zip(self.grids, found, strict=True)):
            moving = np.flatnonzero(~rotating[k]) if self.several[k] or every else np.zeros(0, dtype=int)
            span = max(1, _VALUES // len(grid))
            for begin in range(0, len(moving), span):
                some = moving[begin : begin + span]
                for whole, part in zip(one, self._seen(tori.take(some), k, every=every), strict=True):
                    whole[..., some] = part
        return found

    def unseen(self, count: int) -> list[Wells]:
        """Return the wells of tori that were not looked at: all of each coordinate.

        Args:
            count: tori.
        """
        return [
            Wells(
                np.full(count, -np.inf), np.full(count, np.inf), np.full((_WELLS, count), np.nan),
                np.zeros(count, dtype=bool),
            )
            for _ in self.grids
        ]  # fmt: skip

    def _seen(self, tori: Tori, k: int, *, every: bool) -> Wells:
        """Return the wells of one coordinate: between the last samples before and after its place with p² ≤ 0."""
        grid, coordinate, count = self.grids[k], self.model.separated[k], tori.q.shape[1]
        size, index = len(grid), np.arange(len(grid))
        code, formula = self.programs.coordinates[k].views[0].slopes, sides(coordinate)[0]
        given = np.empty((1 + len(tori.values), count, size))
        given[0], given[1:] = offset(formula, grid), tori.values[:, :, None]
        with np.errstate(all="ignore"):
            F, slope, *_ = run_rows(code, self.programs.parameters, given.reshape(len(given), -1))
        turns = 2 * np.pi * np.rint(tori.q[k] / (2 * np.pi)) if coordinate.periodic else 0.0
        own = tori.q[k] - turns  # in the middle of the grid
        beyond, places = ~(F.reshape(count, size) > 0), own[:, None]
        before = np.where(beyond & (grid < places), index, 0).max(axis=1)
        after = np.where(beyond & (grid > places), index, size - 1).min(axis=1)
        low, high = np.fmin(grid[before], own), np.fmax(grid[after], own)
        # a barrier may lie between two samples, or beyond the last: turning points, where they are known, are nearer
        ends = [place(side, x) - turns for side, x in zip(sides(coordinate), tori.ends[k][::2], strict=True)]
        with np.errstate(invalid="ignore"):
            around, room = (ends[0] <= own) & (own <= ends[1]), _BESIDE_ENDS * (ends[1] - ends[0])
        limit = np.where(beyond[:, 0] | (before > 0), low, -np.inf)
        low = np.where(around, np.fmax(limit, ends[0] - room), low)
        limit = np.where(beyond[:, -1] | (after < size - 1), high, np.inf)
        high = np.where(around, np.fmin(limit, ends[1] + room), high)
        # maxima by the slope: p² itself shows no wells that are below the rounding of its constants
        rises = (formula.sign * slope).reshape(count, size) > 0
        row, column = np.nonzero(rises[:, :-1] & ~rises[:, 1:])
        middle, floor, ceiling = 0.5 * (grid[column] + grid[column + 1]), low[row], high[row]
        # the last sample below the well, and the first above it: its own maximum may lie between two samples
        first, last = np.searchsorted(grid, low, side="right") - 1, np.searchsorted(grid, high)
        first, last = np.maximum(before, first), np.minimum(after, last)
        outside = (column + 1 <= first[row]) | (column >= last[row])
        if coordinate.periodic:  # each maximum once, the one next above the lower end of the well
            turned = middle + 2 * np.pi * np.ceil((floor - middle) / (2 * np.pi))
            outside &= (turned > ceiling) & (middle >= 0)
        elif coordinate.even and not every:  # seen from a well about 0 the others are alike in pairs
            outside &= (middle > 0) | ~((floor < 0) & (ceiling > 0))
        row, column, middle = row[outside], column[outside], middle[outside]
        rank = np.arange(len(row)) - np.searchsorted(row, row)  # among those of the same torus
        others, kept = np.full((_WELLS, count), np.nan), rank < _WELLS
        others[rank[kept], row[kept]] = middle[kept]
        here, beside = F.reshape(count, size), np.zeros(count, dtype=bool)
        beside[row[(here[row, column] > 0) | (here[row, column + 1] > 0)]] = True
        return Wells(low, high, others, beside)


def same_tori(model: Model, one: Solved, other: Tori, scale: Reals, seen: tuple[list[Wells], list[Wells]]) -> Mask:
    """Return which tori are the same: constants that give the same actions, to first order, and wells that overlap.

    Args:
        model: the system.
        one, other: n tori each, that librate and rotate alike.
        scale: the size of all actions together, shape (n,).
        seen: wells of the ones and of the others.
    """
    with np.errstate(all="ignore"):
        apart = np.abs(np.einsum("kcn,cn->kn", one.actions.slopes, one.tori.values - other.values))
        alike = (apart <= _SAME * scale).all(axis=0)
        for coordinate, a, b in zip(model.separated, *seen, strict=True):
            turns = 2 * np.pi * np.rint((a.low + a.high - b.low - b.high) / (4 * np.pi)) if coordinate.periodic else 0.0
            apart = (b.high + turns <= a.low) | (a.high <= b.low + turns)
            alike &= ~apart
    return np.asarray(alike)


def turns_of(model: Model) -> Reals:
    """Return the period of every separated coordinate, 0 for none.

    Args:
        model: the system.
    """
    return np.array([2 * np.pi if coordinate.periodic else 0.0 for coordinate in model.separated])


def in_wells(model: Model, wells: Sequence[Wells], hints: Reals) -> Mask:
    """Return which tori move, along every coordinate, where they are meant to.

    Args:
        wells: where they move.
        hints: a place in the well, shape (separated, n); NaN where none is given.
    """
    found = np.ones(hints.shape[1], dtype=bool)
    for coordinate, own, q in zip(model.separated, wells, hints, strict=True):
        with np.errstate(invalid="ignore"):
            margin = _MARGIN * (np.abs(own.low) + np.abs(own.high))
            if coordinate.periodic:
                q = np.where(np.isfinite(own.low), q + 2 * np.pi * np.ceil((own.low - margin - q) / (2 * np.pi)), q)
            found &= np.isnan(q) | ~((q < own.low - margin) | (q > own.high + margin))
    return found
