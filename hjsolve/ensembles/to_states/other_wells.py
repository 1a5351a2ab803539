"""Tori with the same actions in other wells: two minima of V, or two centres, have such, with constants that differ.

Newton's method begins once more at the place in its well, where that is told, where p², with the constants of the torus
that was found, has other maxima (p² may be negative there, see ``tori``), and where it has none, from the nearest of
those random tori that have another well beside their own. Of many orbits some do this, and the others begin at the tori
that these found. Which of several tori is meant actions do not tell: that takes a place in its well.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import place
from hjsolve.ensembles.engine.kernels.neighbours import PlacesOfWells
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.narrow_tori import ROWS
from hjsolve.ensembles.to_states.newton_on_actions import (
    CLOSE,
    FEW_DIGITS,
    SOON,
    Asked,
    Goals,
    Solved,
    constants_of_tori,
    roughly_known,
)
from hjsolve.ensembles.to_states.places_on_tori import frames_of
from hjsolve.ensembles.to_states.seeds import Seeds, alone, begun, nearest, nearest_in, some_first
from hjsolve.ensembles.to_states.tori import EXACT, AngleTask, Tori, joined
from hjsolve.ensembles.to_states.wells import Landscape, Wells, in_wells, same_tori, turns_of

_ROUNDS = 2 * SOON
"""Evaluations of J from a start in another well."""
_AS_NEAR = 2.0
"""How far off, in logarithms of actions, a random torus may be to begin with: a factor of 7."""


def in_the_wells_meant(landscape: Landscape, seeds: Seeds, solved: Solved, wanted: Asked) -> Mask:
    """Look into other wells, and leave out tori that are not where they are meant to be.

    Args:
        landscape: the system.
        seeds: random tori that librate and rotate as wanted.
        solved: the tori found of n orbits; others are written into it.
        wanted: their actions, and the wells that are meant.

    Returns:
        Which orbits have several tori where they are meant to be.
    """
    several = np.zeros(len(solved.good), dtype=bool)
    good = np.flatnonzero(solved.good)
    if len(good) and (wanted.hinted or any(landscape.several)):
        search = _Search.of(landscape, seeds, solved.take(good), wanted.take(good))
        search.run()
        several[good] = search.several
        solved.put(good, search.chosen.solved)
    return several


@dataclass(frozen=True)
class _Search:
    """A search of n orbits for their other tori.

    Attributes:
        landscape, seeds, asked: of ``in_the_wells_meant``.
        first, last, chosen: the torus that is known, the last one that is another, and the one that is where it is
            meant to be, where its ``good`` is true.
        another, several: which orbits have another torus, and which have several where they are meant to be.
        looked: the wells of which orbits' first tori have been looked at: most need not be.
    """

    landscape: Landscape
    seeds: Seeds
    asked: Asked
    first: _Known
    last: _Known
    chosen: _Known
    another: Mask
    several: Mask
    looked: Mask

    @classmethod
    def of(cls, landscape: Landscape, seeds: Seeds, solved: Solved, asked: Asked) -> _Search:
        wells = landscape.unseen(len(solved.good))
        first, last, chosen = (_Known.of(solved, wells) for _ in range(3))
        another, several, looked = np.zeros((3, len(solved.good)), dtype=bool)
        search = cls(landscape, seeds, asked, first, last, chosen, another, several, looked)
        search.fitting[:] = search.meant(first, search.everyone)
        return search

    def own(self, orbits: Integers) -> _Known:
        """Return the first tori of some orbits, with their wells."""
        new = orbits[~self.looked[orbits]]
        if len(new):
            tori, rotating = self.first.solved.tori.take(new), self.asked.goals.rotating[:, new]
            found = self.landscape.wells(tori, rotating, every=self.asked.hinted)
            for known in (self.first, self.last, self.chosen):  # the last and the chosen are the first as yet
                known.put_wells(new, found)
            self.looked[new] = True
        return self.first.take(orbits)

    @property
    def everyone(self) -> Integers:
        return np.arange(len(self.another))

    @property
    def fitting(self) -> Mask:
        """Which orbits have a torus where they are meant to be."""
        return self.chosen.solved.good

    def meant(self, found: _Known, orbits: Integers) -> Mask:
        """Return which tori of some orbits are where they are meant to be."""
        wells = found.wells
        if self.asked.hinted:
            low, high, known = _turning_points(self.landscape.task, found.solved.tori, self.asked.goals.take(orbits))
            if found is self.first:
                self.own(np.flatnonzero(~known.all(axis=0)))
            wells = [
                one._replace(low=np.where(sure, a, one.low), high=np.where(sure, b, one.high))
                for one, a, b, sure in zip(wells, low, high, known, strict=True)
            ]
        return in_wells(self.landscape.model, wells, self.asked.hints[:, orbits])

    def run(self) -> None:
        """Look for a torus where each is meant to be, for another one of some orbits, then of those next to them."""
        astray = np.flatnonzero(~self.fitting)
        tori = self.first.solved.tori.take(astray)
        hints = self.asked.hints[:, astray]
        at_hints = np.where(np.isnan(hints), tori.q, hints)
        self.from_there(astray, tori._replace(q=at_hints, ends=np.full_like(tori.ends, np.nan)))
        first, sizes, another = some_first(self.everyone)[0], self.asked.sizes, self.another
        few = np.union1d(first, np.flatnonzero(~self.fitting | alone(sizes[:, first], sizes)))
        self.look_around(few)
        known = few[another[few]]
        if len(few) == len(another) or not len(known):
            return
        # an orbit has a second torus, where it is meant to be, where one of those next to it has
        told = np.asarray(np.isfinite(self.asked.hints).all(axis=0))
        near = few[nearest(sizes[:, few], sizes)]
        beside = np.where(told, self.several[near], another[near]).any(axis=0)
        some = np.flatnonzero(beside & ~another & self.fitting)
        # it begins at the nearest not in its own well; where its place is told, that is not where it is meant to be
        self.from_apart(some[~told[some]], known)
        left = some[~another[some]]
        self.look_around(left[another[nearest(sizes, sizes[:, left])].any(axis=0)])

    def from_apart(self, some: Integers, known: Integers) -> None:
        """Look for other tori of some orbits from the nearest ones, in another well than their own, that are known."""
        sizes, model = self.asked.sizes, self.landscape.model
        pool = self.own(known).joined(self.last.take(known))
        both = Seeds(pool.solved.tori, pool.solved.actions, np.tile(sizes[:, known], 2))
        near, _ = _nearest_apart(model, self.own(some).wells, pool.wells, sizes[:, some], both.actions)
        some, near = some[near >= 0], near[near >= 0]
        self.from_there(some, *begun(both, near[None], self.asked.take(some)))

    def from_there(self, seen: Integers, begin: Tori, step: Reals | None = None) -> None:
        """Look for other tori of some orbits from others, to which a step is known or not."""
        step = np.zeros((len(self.asked.goals.unknown), len(seen))) if step is None else step
        # most lead back to the torus that is known: a few digits of the constants tell
        there = constants_of_tori(self.landscape.task, (begin, step), self.asked.goals.take(seen), _ROUNDS, rough=True)
        seen, found = self.others(seen, there)
        # of an orbit that has its torus already a second one is to exist, no more
        for some, close in ((~self.fitting[seen], CLOSE), (self.fitting[seen], FEW_DIGITS)):
            self.proved(seen[some], found.take(np.flatnonzero(some)), close)

    def proved(self, seen: Integers, found: _Known, close: float) -> None:
        """Write tori of some orbits that rough integrals have shown, if the others show them, too."""
        goals, stages = self.asked.goals.take(seen), np.full(len(seen), EXACT)
        begin = roughly_known(found.solved, goals)
        there = constants_of_tori(self.landscape.task, begin, goals, _ROUNDS, stages=stages, close=close)
        seen, found = self.others(seen, there)
        self.another[seen] = True
        self.last.put(seen, found)
        fits = np.flatnonzero(self.meant(found, seen))
        index = seen[fits]
        self.several[index[self.fitting[index]]] = True
        self.chosen.put(index, found.take(fits))

    def others(self, seen: Integers, there: Solved) -> tuple[Integers, _Known]:
        """Return which orbits have met a torus that is not known, and these tori."""
        met, model, goals = np.flatnonzero(there.good), self.landscape.model, self.asked.goals
        new, seen = there.take(met), seen[met]
        found = _Known(new, self.landscape.wells(new.tori, goals.rotating[:, seen], every=self.asked.hinted))
        apart = ~found.same(model, self.own(seen), goals.scale[seen])
        for one in (self.last, self.chosen):
            apart &= ~found.same(model, one.take(seen), goals.scale[seen])
        return seen[apart], found.take(np.flatnonzero(apart))

    def look_around(self, some: Integers) -> None:
        """Look for other tori of some orbits where p² has other maxima, and from random tori."""
        own = self.own(some)
        for seen, begin in _elsewhere(own.wells, own.solved.tori):
            self.from_there(some[seen], begin)
        left = some[~(self.another & self.fitting)[some]]
        seen, begin = _beside(self.landscape, self.seeds, self.asked.take(left), self.own(left).wells)
        self.from_there(left[seen], begin)


class _Known(NamedTuple):
    """Tori that were found of n orbits, and their wells."""

    solved: Solved
    wells: list[Wells]

    @classmethod
    def of(cls, solved: Solved, wells: Sequence[Wells]) -> _Known:
        """Return copies."""
        everyone = np.arange(len(solved.good))
        return cls(solved.take(everyone), [one.take(everyone) for one in wells])

    def take(self, index: Integers) -> _Known:
        return _Known(self.solved.take(index), [one.take(index) for one in self.wells])

    def put(self, index: Integers, other: _Known) -> None:
        self.solved.put(index, other.solved)
        self.put_wells(index, other.wells)

    def put_wells(self, index: Integers, others: Sequence[Wells]) -> None:
        for mine, theirs in zip(self.wells, others, strict=True):
            for whole, part in zip(mine, theirs, strict=True):
                whole[..., index] = part

    def joined(self, other: _Known) -> _Known:
        """Return these and others."""
        return _Known(self.solved.joined(other.solved), list(map(joined, self.wells, other.wells)))

    def same(self, model: Model, other: _Known, scale: Reals) -> Mask:
        """Return which tori are those of others."""
        return same_tori(model, self.solved, other.solved.tori, scale, (self.wells, other.wells))


def _turning_points(task: AngleTask, tori: Tori, goals: Goals) -> tuple[Reals, Reals, Mask]:
    """Return the turning points of tori, of angles those of the turn about 0, and which are known; (separated, n)."""
    size, n = tori.q.shape
    resting, none = goals.actions == 0, np.full((size, ROWS, n), np.nan)
    frames, found = frames_of(task, tori, np.ones((size, n)), goals.rotating, resting, none), np.empty((2, size, n))
    for k, coordinate in enumerate(task.model.separated):
        turns = 2 * np.pi * np.rint(tori.q[k] / (2 * np.pi)) if coordinate.periodic else 0.0
        for upper, side in enumerate(sides(coordinate)):
            found[upper, k] = place(side, frames.bases[k, 2 * upper]) - turns
    return found[0], found[1], frames.good & ~goals.rotating & ~resting


def _elsewhere(wells: Sequence[Wells], tori: Tori) -> Iterator[tuple[Integers, Tori]]:
    """Yield which tori see another well along one coordinate or several, and the same tori with a place there."""
    choices = [[tori.q[k], *(row for row in own.others if np.isfinite(row).any())] for k, own in enumerate(wells)]
    for rows in itertools.islice(itertools.product(*choices), 1, None):
        q = np.stack(rows)
        seen = np.flatnonzero(np.isfinite(q).all(axis=0))
        if len(seen):
            yield seen, tori._replace(q=q, ends=np.full_like(tori.ends, np.nan)).take(seen)


def _beside(landscape: Landscape, seeds: Seeds, asked: Asked, wells: Sequence[Wells]) -> tuple[Integers, Tori]:
    """Return which orbits have near them a seed whose well is not theirs but next to another one, and that seed."""
    around = landscape.wells(seeds.tori, seeds.shells.rotations)
    known = np.flatnonzero(np.any([own.beside for own in around], axis=0))
    if not len(known) or not asked.goals.actions.shape[1]:
        return np.zeros(0, dtype=int), seeds.tori.take(known[:0])
    there = [one.take(known) for one in around]
    near, square = _nearest_apart(landscape.model, wells, there, asked.sizes, seeds.actions[:, known])
    seen = np.flatnonzero(square <= _AS_NEAR**2)
    begin = seeds.tori.take(known[near[seen]])
    begin.values[asked.places] = asked.momenta[:, seen]
    begin.low[asked.places] = 0.0
    return seen, begin


def _nearest_apart(
    model: Model, here: Sequence[Wells], there: Sequence[Wells], sizes: Reals, known: Reals
) -> tuple[Integers, Reals]:
    """Return the torus with the nearest actions that lies in another well, and the square of how far off it is.

    Args:
        model: the system.
        here, there: wells of orbits, and of tori that are known.
        sizes, known: the actions of both.
    """
    theirs, own = (np.stack([*(x.low for x in wells), *(x.high for x in wells)]) for wells in (there, here))
    near, square = nearest_in(known, sizes, PlacesOfWells(theirs, own, turns_of(model), apart=True), 1)
    return near[0], square[0]
