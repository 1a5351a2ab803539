"""Tori with the same actions in other wells: two minima of V, or two centres, have such, with constants that differ.

Newton's method begins once more at the place in its well, where that is told, where p², with the constants of the torus
that was found, has other maxima (p² may be negative there, see ``tori``), and where it has none, from the nearest of
those random tori that have another well beside their own. Of many orbits some do this, and the others begin at the tori
that these found. Which of several tori is meant actions do not tell: that takes a place in its well.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import place
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.narrow_tori import ROWS
from hjsolve.ensembles.to_states.newton_on_actions import SOON, Asked, Goals, Solved, constants_of_tori
from hjsolve.ensembles.to_states.places_on_tori import frames_of
from hjsolve.ensembles.to_states.seeds import Seeds, begun, nearest, nearest_apart, some_first
from hjsolve.ensembles.to_states.tori import AngleTask, Tori, joined
from hjsolve.ensembles.to_states.wells import Landscape, Wells, in_wells, same_tori

_ROUNDS = 2 * SOON
"""Evaluations of J from a start in another well."""
_AS_NEAR = 2.0
"""How far off, in logarithms of actions, a random torus may be to begin with: a factor of 7."""


def in_the_wells_meant(landscape: Landscape, seeds: Seeds, solved: Solved, wanted: Asked, hints: Reals) -> Mask:
    """Look into other wells, and leave out tori that are not where they are meant to be.

    Args:
        landscape: the system.
        seeds: random tori that librate and rotate as wanted.
        solved: the tori found of n orbits; others are written into it.
        wanted: their actions.
        hints: of each coordinate a place in the well that is meant, NaN where none is given; shape (separated, n).

    Returns:
        Which orbits have several tori where they are meant to be.
    """
    several, hinted = np.zeros(hints.shape[1], dtype=bool), bool(np.isfinite(hints).any())
    good = np.flatnonzero(solved.good)
    if not len(good) or not (hinted or any(landscape.several)):
        return several
    before, asked = solved.take(good), wanted.take(good)
    tori, after, another = before.tori, solved.take(good), np.zeros(len(good), dtype=bool)

    def wells(some: Tori, orbits: Integers) -> list[Wells]:
        return landscape.wells(some, asked.goals.rotating[:, orbits], every=hinted)

    everyone, task = np.arange(len(good)), AngleTask(landscape.model, landscape.programs)

    def meant(some: Tori, orbits: Integers, seen: Sequence[Wells]) -> Mask:
        exact = _between_turning_points(task, some, asked.goals.take(orbits), seen) if hinted else seen
        return in_wells(landscape.model, exact, hints[:, good[orbits]])

    first = wells(tori, everyone)
    solved.good[good] = meant(tori, everyone, first)

    def from_there(seen: Integers, begin: tuple[Tori, Reals]) -> None:
        # most lead back to the torus that is known: a few digits of the constants tell
        for rough in (True, False):
            there = constants_of_tori(task, begin, asked.goals.take(seen), _ROUNDS, rough=rough)
            met = np.flatnonzero(there.good)
            new, seen = there.take(met), seen[met]
            second, apart = wells(new.tori, seen), np.ones(len(seen), dtype=bool)
            # the first one, the last that was found, and the one that is where it is meant to be
            for other in (tori.take(seen), after.tori.take(seen), solved.tori.take(good[seen])):
                known = (second, wells(other, seen))
                apart &= ~same_tori(landscape.model, new, other, asked.goals.scale[seen], known)
            new, second, seen = new.take(np.flatnonzero(apart)), [one.take(apart) for one in second], seen[apart]
            begin = new.tori, _no_step(new.tori, asked)
        another[seen] = True
        after.put(seen, new)
        fits = np.flatnonzero(meant(new.tori, seen, second))
        index = good[seen[fits]]
        several[index[solved.good[index]]] = True
        solved.put(index, new.take(fits))

    def look_around(some: Integers) -> None:
        for seen, begin in _elsewhere([one.take(some) for one in first], tori.take(some)):
            from_there(some[seen], (begin, _no_step(begin, asked)))
        left = some[~(another & solved.good[good])[some]]
        seen, begin = _beside(landscape, seeds, asked.take(left), [one.take(left) for one in first])
        from_there(left[seen], (begin, _no_step(begin, asked)))

    astray = np.flatnonzero(~solved.good[good])
    at_hints = np.where(np.isnan(hints[:, good]), tori.q, hints[:, good])
    begin = tori._replace(q=at_hints, ends=np.full_like(tori.ends, np.nan)).take(astray)
    from_there(astray, (begin, _no_step(begin, asked)))
    few = np.union1d(some_first(everyone)[0], np.flatnonzero(~solved.good[good]))
    look_around(few)
    known = few[another[few]]
    if len(few) < len(everyone) and len(known):
        # an orbit has a second torus where one of those next to it has: it begins at the nearest not in its own well
        around = another[few][nearest(asked.sizes[:, few], asked.sizes)]
        some = np.flatnonzero(around.any(axis=0) & ~another & solved.good[good])
        both = Seeds(
            joined(tori.take(known), after.tori.take(known)),
            joined(before.actions.take(known), after.actions.take(known)),
            np.tile(asked.sizes[:, known], 2),
        )  # fmt: skip
        their = landscape.wells(both.tori, np.tile(asked.goals.rotating[:, known], 2))
        near, _ = _nearest_apart([one.take(some) for one in first], their, asked.sizes[:, some], both.actions)
        some, near = some[near >= 0], near[near >= 0]
        from_there(some, begun(both, near[None], asked.take(some)))
        left = some[~another[some]]
        look_around(left[another[nearest(asked.sizes, asked.sizes[:, left])].any(axis=0)])
    return several


def _no_step(tori: Tori, asked: Asked) -> Reals:
    return np.zeros((len(asked.goals.unknown), tori.q.shape[1]))


def _between_turning_points(task: AngleTask, tori: Tori, goals: Goals, wells: Sequence[Wells]) -> list[Wells]:
    """Return the wells of tori with their turning points as ends, where these are known."""
    size, n = tori.q.shape
    resting, none = goals.actions == 0, np.full((size, ROWS, n), np.nan)
    frames, found = frames_of(task, tori, np.ones((size, n)), goals.rotating, resting, none), []
    for k, one in enumerate(wells):
        low, high = (
            place(side, x) for side, x in zip(sides(task.model.separated[k]), frames.bases[k, ::2], strict=True)
        )
        turns = 2 * np.pi * np.rint(tori.q[k] / (2 * np.pi)) if task.model.separated[k].periodic else 0.0
        known = frames.good & ~goals.rotating[k] & ~resting[k]
        found.append(
            one._replace(low=np.where(known, low - turns, one.low), high=np.where(known, high - turns, one.high))
        )
    return found


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
    near, square = _nearest_apart(wells, there, asked.sizes, seeds.actions[:, known])
    seen = np.flatnonzero(square <= _AS_NEAR**2)
    begin = seeds.tori.take(known[near[seen]])
    begin.values[asked.places] = asked.momenta[:, seen]
    begin.low[asked.places] = 0.0
    return seen, begin


def _nearest_apart(
    here: Sequence[Wells], there: Sequence[Wells], sizes: Reals, known: Reals
) -> tuple[Integers, Reals]:  # fmt: skip
    """Return the torus with the nearest actions that lies in another well, and the square of how far off it is.

    Args:
        here, there: wells of orbits, and of tori that are known.
        sizes, known: the actions of both.
    """
    ends, around = (np.stack([*(x.low for x in wells), *(x.high for x in wells)]) for wells in (here, there))
    near, square = nearest_apart(known, sizes, around, ends, 1)
    return near[0], square[0]
