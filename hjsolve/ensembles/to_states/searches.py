"""Tori of many orbits from those that are known: Newton's method begins at the nearest actions, in the well meant.

Tori in two wells may have the same actions and constants that differ: where a place in a well is told, neighbours are
tori between whose turning points it lies. Of many orbits some are solved from random tori, and the others from these.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import place
from hjsolve.ensembles.engine.kernels.neighbours import PlacesOfWells
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.newton_on_actions import (
    ROUNDS,
    SOON,
    Asked,
    Goals,
    Solved,
    constants_of_tori,
    roughly_known,
)
from hjsolve.ensembles.to_states.seeds import Seeds, alone, begun, nearest, some_first
from hjsolve.ensembles.to_states.tori import DOUBLES, EXACT, AngleTask, Tori
from hjsolve.ensembles.to_states.wells import turns_of

_LEFT_OVER = 20
"""The last of so many orbits start again together with others."""
_AGAIN = 3
"""How often orbits that are left over start again from the nearest that are solved."""
_DENIED = 2
"""Searches that ended before a separatrix, after which an orbit is not sought again at last: of 1 300 geodesics and
195 orbits about two centres none was found then, of those denied once one of 126."""


def found_from_seeds(task: AngleTask, seeds: Seeds, wanted: Asked, *, everyone: bool) -> tuple[Solved, Mask]:
    """Find constants of tori from the nearest seeds; of many orbits those of some, where the others begin.

    Args:
        task: the system.
        seeds: random tori that librate and rotate as wanted.
        wanted: actions.
        everyone: whether all orbits are sought, or only those next to one that has a torus of this kind.

    Returns:
        The tori, and which were sought.
    """
    goals, sizes = wanted.goals, wanted.sizes
    solved, sought = Solved.none(task, sizes.shape[1]), np.ones(sizes.shape[1], dtype=bool)
    few, rest = some_first(np.arange(sizes.shape[1]))
    for part in (few, rest):
        if part is rest and len(rest):  # these begin at those, which lie where the batch does
            found = few[solved.good[few]]
            seeds = seeds.joined(Seeds(solved.tori.take(found), solved.actions.take(found), sizes[:, found]))
            if not everyone:
                beside = solved.good[few[nearest(sizes[:, few], sizes[:, rest])]].any(axis=0)
                sought[rest] = beside | alone(sizes[:, few], sizes[:, rest])
        some = part[sought[part]]
        begin = begun(seeds, _neighbours(task.model, seeds, wanted.take(some)), wanted.take(some))
        solved.put(some, constants_of_tori(task, begin, goals.take(some), SOON, few=len(some) // _LEFT_OVER))
    return solved, sought


def found_again(task: AngleTask, seeds: Seeds, wanted: Asked, solved: Solved, which: Mask) -> None:
    """Find tori that took long, or were not sought, from the nearest that were found.

    Args:
        task, seeds, wanted: as for ``found_from_seeds``.
        solved: its tori, written into.
        which: orbits whose tori are looked for, if they have none yet.
    """
    goals, everything = wanted.goals, wanted.sizes
    new, denied = np.ones(len(which), dtype=bool), solved.denied.astype(np.int64)
    for attempt in range(_AGAIN):
        good = np.flatnonzero(solved.good)
        last = attempt == _AGAIN - 1 or not len(good)
        lost = np.flatnonzero(~solved.good & which & ~(last & (denied >= _DENIED)))
        if not len(lost) or (attempt and not len(good)):  # from the same tori a search ends as it did
            break
        pool = Seeds(solved.tori.take(good), solved.actions.take(good), everything[:, good]) if len(good) else seeds
        near = _neighbours(task.model, pool, wanted.take(lost))[: 1 if last else None]
        if not last:  # between the same neighbours a search ends as it did
            changed = new[good[near]].any(axis=0)
            lost, near = lost[changed], near[:, changed]
        begin = begun(pool, near, wanted.take(lost))
        solved.put(lost, _roughly_first(task, begin, goals.take(lost), last=last))
        denied[lost] += solved.denied[lost]
        new = solved.good.copy()
        new[good] = False


def _roughly_first(task: AngleTask, begin: tuple[Tori, Reals], goals: Goals, *, last: bool) -> Solved:
    """Find the constants of tori most of which do not exist: a few digits of them tell at a third of the price."""
    rounds = ROUNDS if last else SOON
    found = constants_of_tori(task, begin, goals, rounds, rough=True)
    # at last the same search with proved integrals, where rough ones say nothing
    some = np.flatnonzero((found.good | ~found.denied) if last else found.good)
    met, goals = found.good[some], goals.take(some)
    known, own = roughly_known(found.take(some), goals), (begin[0].take(some), begin[1][:, some])
    start = Tori(*(np.where(met, *both) for both in zip(known[0], own[0], strict=True)))
    stages = np.where(met, EXACT, DOUBLES)
    found.good[:] = False
    found.put(some, constants_of_tori(task, (start, np.where(met, known[1], own[1])), goals, rounds, stages=stages))
    return found


def _neighbours(model: Model, seeds: Seeds, wanted: Asked) -> Integers:
    """Return which seeds are near the actions of orbits, and in the well that is meant; shape (neighbours, n)."""
    near = nearest(seeds.actions, wanted.sizes)
    if not wanted.hinted or not len(near):
        return near
    there = [
        place(side, x)
        for upper in (0, 1)
        for coordinate, ends in zip(model.separated, seeds.tori.ends, strict=True)
        for side, x in [(sides(coordinate)[upper], ends[2 * upper])]
    ]
    here = np.concatenate([wanted.hints, wanted.hints])
    mine = nearest(seeds.actions, wanted.sizes, PlacesOfWells(np.stack(there), here, turns_of(model), apart=False))
    # fewer than are wanted count again; where there are none at all, those of other wells do
    return np.where(mine[0] < 0, near, np.where(mine < 0, mine[0], mine))
