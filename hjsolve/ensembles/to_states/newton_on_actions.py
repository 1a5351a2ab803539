"""Constants of n tori from their actions: damped Newton's method on J(α) with the exact matrix ∂J/∂α.

It is the method of ``motion.tori.polish`` over arrays. Constants are held in two doubles, since near a circle or the
energy of escape J depends on digits that one double has not. A step is shortened until the largest relative residual
falls, first to nine tenths: next to a separatrix J ~ J₀ + δ ln δ, δ the distance of the constants from it, and a step
goes beyond it by δ/ln δ. Where even half of that goes beyond, again and again, J₀ is as a rule not enough, and the
search ends: no proof, some have a torus there. Orbits that do not converge are left to the search of single motions.

Residuals of full steps fall like rₖ₊₁ = κ rₖ² (Kelley, Iterative methods for linear and nonlinear equations (1995),
§5.3), so that the last step need not be tried: what it leaves is foreseen from those before it, and counted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.to_states.followed_tori import followed
from hjsolve.ensembles.to_states.tori import (
    APPROXIMATE,
    DOUBLES,
    EXACT,
    Actions,
    AngleTask,
    Tori,
    actions_of,
    joined,
    no_actions,
    unknown_of,
)

ROUNDS, SOON = 40, 9
"""Evaluations of J; and those of orbits that have another start to try."""
_SHORT_OF = 0.9
"""The fraction of a step that is tried where the whole one makes nothing better."""
_LEAST_STEP = 2.0**-8
"""The fraction of a step below which an orbit is given up: shorter ones, where they made something better, led to a
torus in one of 25 000 searches about two centres and in none of 25 600 for geodesics, and in vain again and again."""
_SHORT, _BEYOND = 0.5, 2.0
"""A fraction of a step that should make something better, and the sum of 1/residual over tori in a row where it does
not: of 15 000 orbits about two centres that converged none had one with a residual below 1.1."""
_MUCH = 4.0
"""How many times larger than all actions are to be together one is much too large: small ones are linear in E."""
_PERHAPS = 1e-2
"""Residual below which rough integrals next to a separatrix say nothing: with those in doubles four of 110 000 orbits
about two centres had a torus all the same, with residuals of 1e-4 to 1e-3; of those without one a twentieth are below.
"""
CLOSE, _FALLS = 8 * EPS, 0.25
"""Relative residual at which an orbit is done, and the part of a step by which it has to fall (Armijo's rule)."""
_FAR = 0.1
"""The part of the residual, or of the scale of all actions, by which small actions count far away."""
_NEARLY = 1e-6
"""Residual, as it is foreseen, below which p² is taken to 32 digits where doubles do not know it well."""
_FORESEEN, _KNOWN = 16.0, (0.0, 1e-13, 1e-11)
"""By how much what the last step leaves is taken larger than κ r²; and errors of J, rough, in doubles and to
32 digits, up to which it is the last."""
_ROUGHLY, _APPROXIMATE_FRACTION = 1e-8, 0.5
"""Residual of rough integrals, as it is foreseen, and fraction of a step, below which they are left."""
FEW_DIGITS = 1e-7
"""Residual at which an orbit is done whose constants are wanted to a few digits."""
_SETTLED = 1e-10
"""Residual below which a step that makes nothing better ends the search."""
_FEW = 64
"""Orbits below which turning points are not followed: for so few it takes as long as a search for them, 3 ms."""
_ACTION_OF_REST = 2.0**-80
"""J that counts as 0 next to the scale of all actions, of coordinates whose J is to be zero."""


class Goals(NamedTuple):
    """What is wanted of n orbits.

    Attributes:
        actions: J of the shell momenta, not negative; shape (separated, n).
        rotating: which coordinates go round, the same shape.
        scale: the size of all actions together, shape (n,).
        unknown: positions of the constants that are looked for.
    """

    actions: Reals
    rotating: Mask
    scale: Reals
    unknown: Integers

    def take(self, index: Integers) -> Goals:
        """Return those of some orbits."""
        return Goals(self.actions[:, index], self.rotating[:, index], self.scale[index], self.unknown)


class Asked(NamedTuple):
    """What is asked of n orbits.

    Attributes:
        goals: of the separated coordinates.
        momenta: of the ignorable angles, which are constants; shape (angles, n).
        places: positions of these among the constants.
        hints: of each coordinate a place in the well that is meant, NaN where none is given; shape (separated, n).
    """

    goals: Goals
    momenta: Reals
    places: list[int]
    hints: Reals

    @classmethod
    def of(cls, model: Model, J: Reals, momenta: Reals, pattern: tuple[bool, ...], hints: Reals | None = None) -> Asked:
        """Write what Newton's method is to reach, and which constants it may change.

        Args:
            J: actions of the separated coordinates, signed; shape (separated, n).
            momenta: of the ignorable angles.
            pattern: which coordinates are to go round.
            hints: places in the wells that are meant; None where no well is.
        """
        hints = np.full(J.shape, np.nan) if hints is None else hints
        places = [model.ignorable[name] for name in model.angles]
        unknown = np.array([j for j in range(len(model.constants)) if j not in places])
        rotating = np.broadcast_to(np.array(pattern)[:, None], J.shape)
        scale = np.abs(J).sum(axis=0) + np.abs(momenta).sum(axis=0)
        return cls(Goals(np.abs(J), rotating, scale, unknown), momenta, places, hints)

    @property
    def hinted(self) -> bool:
        """Whether a well is meant of any orbit."""
        return bool(np.isfinite(self.hints).any())

    @property
    def sizes(self) -> Reals:
        """All actions without their signs, those of the ignorable angles last."""
        return np.concatenate([self.goals.actions, np.abs(self.momenta)])

    def take(self, index: Integers) -> Asked:
        """Return those of some orbits."""
        return Asked(self.goals.take(index), self.momenta[:, index], self.places, self.hints[:, index])


class Solved(NamedTuple):
    """Tori that have the actions.

    Attributes:
        tori: of n orbits.
        actions: as the engine gives them for these constants.
        good: which have them.
        denied: where the search ended before a separatrix: as a rule no torus has the actions.
    """

    tori: Tori
    actions: Actions
    good: Mask
    denied: Mask

    @classmethod
    def none(cls, task: AngleTask, count: int) -> Solved:
        """Return places for n tori, of which none is known."""
        size, m = len(task.model.separated), len(task.model.constants)
        tori = Tori(*(np.full((*shape, count), np.nan) for shape in ((m,), (m,), (size,), (size, 4))))
        return cls(tori, no_actions(size, m, count), *np.zeros((2, count), dtype=bool))

    def take(self, index: Integers) -> Solved:
        """Return those of some orbits."""
        return Solved(self.tori.take(index), self.actions.take(index), self.good[index], self.denied[index])

    def joined(self, other: Solved) -> Solved:
        """Return these and others."""
        masks = (np.concatenate(pair) for pair in zip(self[2:], other[2:], strict=True))
        return Solved(joined(self.tori, other.tori), joined(self.actions, other.actions), *masks)

    def put(self, index: Integers, other: Solved) -> None:
        """Write those of some orbits into these.

        Args:
            index: which.
            other: theirs.
        """
        mine, theirs = ((*x.tori, *x.actions, x.good, x.denied) for x in (self, other))
        for whole, part in zip(mine, theirs, strict=True):
            whole[..., index] = part


def constants_of_tori(
    task: AngleTask, begin: tuple[Tori, Reals], goals: Goals, rounds: int = ROUNDS, *, few: int = 0,
    rough: bool = False, stages: Integers | None = None, close: float = CLOSE,
) -> Solved:  # fmt: skip
    """Find the constants of tori.

    Args:
        begin: n tori, and the first step from each, shape (unknown, n).
        goals: what is wanted.
        rounds: how often J is evaluated, at most.
        few: how many orbits may be left over by either kind of integrals that are not exact: each round has a price.
        rough: whether constants are wanted to a few digits only, by rough integrals.
        stages: integrals that each search begins with, shape (n,); None for ``APPROXIMATE``.
        close: relative residual at which an orbit is done; of rough searches ``FEW_DIGITS``.
    """
    searches = _Searches.begun(task, begin, goals, stages, FEW_DIGITS if rough else close, rough=rough)
    while searches.open.any():
        # those with the roughest integrals, while the others wait: a round costs the same for ten orbits or a hundred
        stage = searches.how[searches.open].min()
        active = np.flatnonzero(searches.open & (searches.how == stage))
        if stage < EXACT and len(active) <= few:
            searches.open[active] = False
            continue
        given = searches.trial, goals.actions == 0, goals.rotating
        found, seen = _each(task, given, active, stage, rough=rough)
        judged = searches.judged(active, stage, found, seen.values)
        searches.write(active, judged, found, seen)
        searches.choose(active, judged, rounds)
        searches.move(active[searches.open[active]])
    return searches.ended()


class _Judged(NamedTuple):
    """What an evaluation of J tells of some searches; arrays (m,).

    Attributes:
        residual: J wanted less J found, shape (separated, m).
        own: the largest, relatively.
        after: what one more step leaves of it, as it is foreseen.
        better: whether the step made something better.
        finished: whether these are the actions that are wanted.
        settled: whether rounding is reached: a full step from nearby makes nothing better.
        last: whether one more step need not be tried.
    """

    residual: Reals
    own: Reals
    after: Reals
    better: Mask
    finished: Mask
    settled: Mask
    last: Mask


@dataclass(frozen=True)
class _Searches:
    """Where Newton's method has come to for n orbits; the arrays are written into.

    Attributes:
        goals, close, rough: of ``constants_of_tori``.
        weight: what residuals are over, shape (separated, n).
        base, best: the best tori up to now, and their actions.
        step, fraction: from there, shape (unknown, n), and how much of it is tried.
        trial: the tori that are tried.
        merit, left: the largest relative residual of the best, and all residuals, shape (separated, n).
        how: by which integrals J is worked out next.
        curve: κ of rₖ₊₁ = κ rₖ².
        beyond: the sum of 1/residual over short steps in vain.
        tried: how often J was evaluated.
        open, done: which searches go on, and which have reached their goal.
    """

    goals: Goals
    close: float
    rough: bool
    weight: Reals
    base: Tori
    best: Actions
    step: Reals
    fraction: Reals
    trial: Tori
    merit: Reals
    left: Reals
    how: Integers
    curve: Reals
    beyond: Reals
    tried: Integers
    open: Mask
    done: Mask

    @classmethod
    def begun(
        cls, task: AngleTask, begin: tuple[Tori, Reals], goals: Goals, stages: Integers | None, close: float, *,
        rough: bool,
    ) -> _Searches:  # fmt: skip
        """Return searches none of which has tried anything."""
        size, n = goals.actions.shape
        weight = np.where(goals.actions == 0, _ACTION_OF_REST * goals.scale / CLOSE, goals.actions)
        base, step = Tori(*(x.copy() for x in begin[0])), begin[1].copy()
        return cls(
            goals=goals, close=close, rough=rough, weight=weight, base=base,
            best=no_actions(size, len(task.model.constants), n),
            step=step, fraction=np.ones(n), trial=base.moved(goals.unknown, step), merit=np.full(n, np.inf),
            left=np.full((size, n), np.inf), how=np.full(n, APPROXIMATE) if stages is None else stages,
            curve=np.full(n, np.inf), beyond=np.zeros(n), tried=np.zeros(n, dtype=np.int64),
            open=np.ones(n, dtype=bool), done=np.zeros(n, dtype=bool),
        )  # fmt: skip

    def judged(self, active: Integers, stage: int, found: Actions, constants: Reals) -> _Judged:
        """Compare the actions of some searches with those wanted."""
        goals, merit, fraction = self.goals.take(active), self.merit[active], self.fraction[active]
        sure = stage > APPROXIMATE
        with np.errstate(all="ignore"):
            residual = goals.actions - found.values
            unknown = unknown_of(found.slopes, constants)
            # what constants in two doubles leave open is not sought: narrow librations find their height later
            weights = np.fmax(self.weight[:, active], unknown / CLOSE)
            own = np.max(np.abs(residual) / weights, axis=0)
            # far away an action that is nearly zero counts by the size of all: else it would hold up the others
            floor = _FAR * np.fmin(self.left[:, active].max(axis=0), goals.scale)
            far, before = (np.max(np.abs(r) / (weights + floor), axis=0) for r in (residual, self.left[:, active]))
            full = (fraction == 1.0) & (merit < 1)
            self.curve[active] = np.where(full, np.fmax(own / merit**2, 1.0), self.curve[active])
            after = self.curve[active] * own**2
            known = (found.errors <= _KNOWN[stage] * weights).all(axis=0)
        # J of the harmonic libration is that of the motion only where it is to be zero
        harmonic = (found.harmonic & (goals.actions > unknown)).any(axis=0)
        finished = (sure | self.rough) & found.good & (own <= self.close) & ~harmonic
        falls = 1 - _FALLS * fraction
        better = found.good & ((own < falls * merit) | (far < falls * before) | finished)
        settled = sure & ~better & (fraction == 1.0) & (merit < _SETTLED)
        last = sure & better & ~finished & known & (_FORESEEN * after <= self.close)
        return _Judged(residual, own, after, better, finished, settled, last)

    def write(self, active: Integers, judged: _Judged, found: Actions, seen: Tori) -> None:
        """Keep the tori that are better, with the step from each; those of a last step are where it leads."""
        better, goals = judged.better, self.goals
        here = active[better]
        for whole, part in zip((*self.base, *self.best), (*seen, *found), strict=True):
            whole[..., here] = part[..., better]
        self.merit[here], self.left[:, here] = judged.own[better], np.abs(judged.residual[:, better])
        missing = _missing(goals.take(here), found.values[:, better])
        self.step[:, here] = newton_step(found.slopes[:, goals.unknown][:, :, better], missing)
        last = active[judged.last]
        _stepped(self.base, self.best, goals.take(last), (last, self.step[:, last], judged.after[judged.last]))

    def choose(self, active: Integers, judged: _Judged, rounds: int) -> None:
        """Choose the fraction of the next steps and the integrals, and which searches go on."""
        _shortened(self.fraction, self.beyond, self.merit, (active[judged.better], active[~judged.better]))
        _refined(self.how, self.merit, active, (self.fraction, judged.own, judged.after), rough=self.rough)
        self.tried[active] += 1
        ended = judged.finished | judged.settled | judged.last
        self.done[active[ended]] = True
        given_up = self.in_vain[active] | (self.tried[active] >= rounds)
        self.open[active] = ~ended & ~given_up

    @property
    def in_vain(self) -> Mask:
        """Which searches make nothing better with short steps."""
        return (self.fraction < _LEAST_STEP) | (self.beyond >= _BEYOND)

    def move(self, active: Integers) -> None:
        """Try the next step of some searches."""
        unknown = self.goals.unknown
        moved = self.base.take(active).moved(unknown, self.fraction[active] * self.step[:, active])
        for kept, new in zip(self.trial, moved, strict=True):
            kept[..., active] = new

    def ended(self) -> Solved:
        """Return what was found."""
        harmonic = self.best.harmonic & (self.goals.actions > unknown_of(self.best.slopes, self.base.values))
        finite = self.done & self.best.good & ~harmonic.any(axis=0)
        denied = ~finite & self.in_vain & (self.merit >= _PERHAPS) & (self.merit < np.inf)
        return Solved(self.base, self.best, finite, denied)


def _missing(goals: Goals, found: Reals) -> Reals:
    """Return by how much actions are to change, to first order; of much too large ones the logarithm.

    Next to the energy of escape J ~ |E|^(−1/2): a step on J itself makes |E| three times as large, whatever J is.
    """
    with np.errstate(all="ignore"):
        large = (goals.actions > 0) & (found > _MUCH * goals.scale)
        return np.where(large, found * np.log(goals.actions / found), goals.actions - found)


def _shortened(fraction: Reals, beyond: Reals, merit: Reals, which: tuple[Integers, Integers]) -> None:
    """Choose the fraction of the next steps, and count short ones in vain until a whole one helps."""
    better, worse = which
    tried = (fraction[worse] < _SHORT) & (fraction[worse] > _SHORT * _SHORT)
    beyond[worse] += np.where(tried, 1 / merit[worse], 0.0)
    beyond[better[fraction[better] >= _SHORT_OF]] = 0
    fraction[better] = 1.0
    shorter = np.where(fraction[worse] >= _SHORT_OF, 0.5, 0.25) * fraction[worse]
    fraction[worse] = np.where(fraction[worse] == 1.0, _SHORT_OF, shorter)


def _stepped(base: Tori, best: Actions, goals: Goals, known: tuple[Integers, Reals, Reals]) -> None:
    """Move tori by the last step, and count what it leaves."""
    index, step, after = known
    moved = base.take(index).moved(goals.unknown, step)
    base.values[:, index], base.low[:, index] = moved.values, moved.low
    best.values[:, index] = goals.actions
    inexact = np.einsum("kcn,cn->kn", best.slope_errors[:, goals.unknown][:, :, index], np.abs(step))
    best.errors[:, index] += _FORESEEN * after * goals.actions + inexact


def _refined(how: Integers, merit: Reals, active: Integers, seen: tuple[Reals, Reals, Reals], *, rough: bool) -> None:
    """Choose how J is worked out next: rough integrals as long as they lead on, exact ones where little is left."""
    fraction, own, after = seen
    approximate = how[active] == APPROXIMATE
    near = (np.fmin(own, _FORESEEN * after) < _ROUGHLY) & (not rough)
    through = active[approximate & (near | (fraction[active] < _APPROXIMATE_FRACTION))]
    how[through], merit[through] = DOUBLES, np.inf
    if not rough:
        how[active[(how[active] > APPROXIMATE) & (np.fmin(own, after) < _NEARLY)]] = EXACT


def roughly_known(found: Solved, goals: Goals) -> tuple[Tori, Reals]:
    """Return tori of a rough search, and the step to each that it leaves."""
    missing = goals.actions - found.actions.values
    return found.tori, newton_step(found.actions.slopes[:, goals.unknown], missing)


def _each(
    task: AngleTask, given: tuple[Tori, Mask, Mask], active: Integers, stage: int, *, rough: bool
) -> tuple[Actions, Tori]:
    """Actions of some tori by integrals of one kind, and the places inside.

    Where a few digits do, few nodes are enough even next to a separatrix, between turning points that are searched for
    and not followed: proved integrals take three times as long, and most such searches end in vain.
    """
    trial, zero, rotating = given[0].take(active), given[1][:, active], given[2][:, active]
    integrals = APPROXIMATE if rough else stage
    found, seen = no_actions(len(task.model.separated), len(task.model.constants), len(active)), trial
    left = np.ones(len(active), dtype=bool)
    if stage == APPROXIMATE:
        left[:] = (zero | rotating).any(axis=0) | ~np.isfinite(trial.ends).all(axis=(0, 1)) | (len(active) < _FEW)
        some = np.flatnonzero(~left)
        near = followed(task, trial.take(some), series=False)
        fine, left[some[~near.good]] = some[near.good], True
        found.values[:, fine], found.slopes[..., fine] = near.action[:, near.good], near.series.means[..., near.good]
        found.errors[:, fine], found.slope_errors[..., fine], found.good[fine] = 0.0, 0.0, True
        found.harmonic[:, fine] = near.harmonic[:, near.good]
        seen.ends[..., fine] = near.bases[..., near.good]
    some = np.flatnonzero(left)
    if len(some):
        part, places = actions_of(*task, trial.take(some), zero[:, some], rotating[:, some], integrals)
        for kept, new in zip(found, part, strict=True):
            kept[..., some] = new
        seen.q[:, some], seen.ends[..., some] = places.q, places.ends
    return found, seen


def newton_step(slopes: Reals, residual: Reals) -> Reals:
    """Return M⁻¹ times residuals.

    Args:
        slopes: M, shape (separated, unknown, n).
        residual: shape (separated, n).

    Returns:
        Steps, shape (unknown, n); NaN where there is no inverse.
    """
    matrix = slopes.transpose(2, 0, 1)
    with np.errstate(invalid="ignore"):
        determinant = np.linalg.det(matrix)
    fine = np.isfinite(determinant) & (determinant != 0)
    found = np.full(residual.shape, np.nan)
    if fine.any():
        found[:, fine] = np.linalg.solve(matrix[fine], residual[:, fine].T[..., None])[..., 0].T
    return found
