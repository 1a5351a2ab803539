"""Phases of n states whose angles are given: damped Newton's method on θ(φ), from rough integrals to exact ones.

Residuals of full steps fall like rₖ₊₁ = κ rₖ², as in ``newton_on_actions``, so that the last step need not be tried:
what it leaves is foreseen from those before it, and counted. Where θ is small next to its rounding, integrals over
short arcs take the place of the engine's (``short_arcs``).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.to_states.angles_of_states import AnglesFound, angles_at, matrix_of
from hjsolve.ensembles.to_states.followed_tori import FollowedTori, phases_along, series_of
from hjsolve.ensembles.to_states.narrow_tori import narrow_ones
from hjsolve.ensembles.to_states.places_on_tori import Frames, Placed, blurred, placed
from hjsolve.ensembles.to_states.short_arcs import (
    PROVED,
    Integrals,
    Passages,
    ShortArcs,
    angles_by_arcs,
    inverses,
    phases_by_arcs,
    times,
    wrapped,
)
from hjsolve.ensembles.to_states.tori import APPROXIMATE, DOUBLES, EXACT, AngleTask, Tori

_ROUNDS, _LEAST_STEP = (12, 40, 16), 2.0**-30
"""Evaluations of θ by integrals of each kind, and the fraction of a step below which an orbit is given up."""
_LONGEST = 1.0
"""Radians that a phase moves in one step, at most."""
_CLOSE = 4e-15
"""Residual of angles, radians, at which an orbit is done."""
_NEARLY = 1e-8
"""The same, as long as p² is in doubles."""
_FORESEEN = 16.0
"""By how much what the last step leaves is taken larger than κ r²."""
SETTLED = 1e-9
"""Residual below which a step that makes nothing better ends the search."""
_STARTS = 8
"""Phases next to either turning point from which Newton's method begins again."""
_KNOWN, SMALL = 1e-11, 0.1
"""Error of a phase above which angles below the second, radians, come from integrals over short arcs."""
_TINY, _BEGIN = 1e-3, 0.3
"""Angle, radians, below which arcs come first, and the phase at which they then begin."""

Here = tuple[Reals, AnglesFound, Placed]
"""Phases of states, their angles, and the states."""


def phases_of(
    task: AngleTask, tori: Tori, frames: Frames, rough: FollowedTori, given: tuple[Reals, Reals]
) -> tuple[Here, Mask]:
    """Find the phases with given angles.

    Args:
        frames: between what they move.
        rough: their running integrals, as far as these are known.
        given: angles, shape (separated, n), and phases to begin with, which are changed.

    Returns:
        Phases, angles and states there, and which angles the engine leaves open, so that short arcs gave them.
    """
    (θ, φ), curve = given, np.full(given[0].shape[1], np.inf)
    ended = rough.good & ~frames.rotating.any(axis=0)  # arcs begin at turning points
    tiny = ended & (np.abs(θ) < _TINY).any(axis=0)
    found = _from_turning_points(task, tori, frames, rough, (θ, φ, np.flatnonzero(tiny)))
    some = np.flatnonzero(rough.good & ~found)
    if len(some):
        moved = np.ascontiguousarray(φ[:, some])
        curve[some], found_ = phases_along(series_of(rough, some), θ[:, some], moved)
        φ[:, some] = np.where(found_, moved, φ[:, some])
        found[some[found_]] = True
    left = np.flatnonzero(ended & ~found & ~tiny)
    found |= _from_turning_points(task, tori, frames, rough, (θ, φ, left))
    rest = np.flatnonzero(~found)
    if len(rest):
        φ[:, rest], curve[rest] = _nearly(task, tori.take(rest), frames.take(rest), θ[:, rest], φ[:, rest])
    begin = φ
    φ, angles, at, curve, seen = _phases(task, tori, frames, (θ, φ, curve), EXACT)
    unresolved = _unresolved(frames, (φ, angles, at), np.abs(wrapped(θ - angles.separated)) + angles.errors, θ)
    return _by_arcs(task, tori, frames, (φ, angles, at), (θ, begin, seen, unresolved)), unresolved


def _from_turning_points(
    task: AngleTask, tori: Tori, frames: Frames, rough: FollowedTori, given: tuple[Reals, Reals, Integers]
) -> Mask:
    """Write the phases of some orbits by arcs from their turning points; return which were found."""
    (θ, φ, some), found = given, np.zeros(given[0].shape[1], dtype=bool)
    if not len(some):
        return found
    goal = θ[:, some]
    begin = np.where(np.abs(goal) < _TINY, np.copysign(_BEGIN, goal), φ[:, some])
    passages = Passages.of(task, tori.take(some), frames.take(some), exact=False)
    arcs = ShortArcs.whole(rough.series.means[..., some], passages)
    moved, known = phases_by_arcs(task, arcs, (goal, begin), exact=False)
    φ[:, some[known]] = moved[:, known]
    found[some[known]] = True
    return found


def _nearly(task: AngleTask, tori: Tori, frames: Frames, θ: Reals, φ: Reals) -> tuple[Reals, Reals]:
    """Phases of angles, by rough integrals, in doubles where these do not lead there; and κ of ``_phases``."""
    unknown = np.full(θ.shape[1], np.inf)
    φ, found, _, curve, _ = _phases(task, tori, frames, (θ, φ, unknown), APPROXIMATE)
    far = np.flatnonzero(frames.good & ~(np.abs(wrapped(θ - found.separated)).max(axis=0) < _NEARLY))
    if len(far):
        among = frames.take(far)
        start = _nearest_start(task, tori.take(far), among, θ[:, far])
        φ[:, far], _, _, curve[far], _ = _phases(task, tori.take(far), among, (θ[:, far], start, unknown[far]), DOUBLES)
    return φ, curve


def _unresolved(frames: Frames, here: Here, loose: Reals, θ: Reals) -> Mask:
    """Tell which phases the engine's angles leave open, if θ does, of orbits that librate in all coordinates."""
    _, found, at = here
    with np.errstate(all="ignore"):
        known = np.asarray(times(np.abs(inverses(matrix_of(found, at))), loose).max(axis=0) <= _KNOWN)
    moving = ~(frames.rotating | frames.resting | narrow_ones(frames.narrow)).any(axis=0) & found.good
    unresolved: Mask = np.asarray(moving & ~known & (np.abs(θ) < SMALL).any(axis=0), dtype=bool)
    return unresolved


def _by_arcs(task: AngleTask, tori: Tori, frames: Frames, here: Here, which: tuple[Reals, Reals, Reals, Mask]) -> Here:
    """Move unresolved states to their angles by integrals over short arcs, from where the engine gave G."""
    (φ, found, at), (θ, begin, seen, unresolved) = here, which
    some = np.flatnonzero(unresolved)
    if not len(some):
        return here
    own, among = tori.take(some), frames.take(some)
    known = Integrals._make(x[..., some] for x in found.integrals)
    passages = Passages.of(task, own, among, exact=True)
    arcs = ShortArcs.of(known, found.inverse[some], passages, seen[:, some], np.abs(θ[:, some]) < SMALL)
    # the engine's steps follow its rounding: where it began is nearer
    moved, _ = phases_by_arcs(task, arcs, (θ[:, some], begin[:, some]), exact=True)
    better = angles_by_arcs(task, arcs, moved, PROVED, exact=True)
    φ[:, some] = moved
    for whole, part in zip(at, placed(task, own, among, moved, bounds=True), strict=True):
        whole[..., some] = part
    for name, part in better._asdict().items():
        getattr(found, name)[..., some] = part
    return φ, found, at


def _phases(
    task: AngleTask, tori: Tori, frames: Frames, given: tuple[Reals, Reals, Reals], how: int
) -> tuple[Reals, AnglesFound, Placed, Reals, Reals]:
    """Phases at which the separated coordinates have given angles, by damped Newton's method from other phases.

    Residuals of full steps fall like rₖ₊₁ = κ rₖ², as those of ``newton_on_actions``; κ is given and returned, and at
    last the phases to which ``integrals`` belong: the last step moves angles only.
    """
    (θ, base, curve), m, close = given, len(task.model.constants), _CLOSE if how == EXACT else _NEARLY
    size, n = θ.shape
    base, curve, seen = base.copy(), curve.copy(), base.copy()
    trial, step, back = base.copy(), np.zeros((size, n)), np.full((n, size, size), np.nan)
    fraction, merit = np.ones(n), np.full(n, np.inf)
    angles = len(task.model.angles)
    shapes = (size, n), (size, n), (angles, n), (angles, n), (n, size, size)
    integrals = Integrals._make(np.full((size, m, n), np.nan) for _ in range(4))
    best = AnglesFound._make((*(np.full(shape, np.nan) for shape in shapes), integrals, np.zeros(n, dtype=bool)))
    kept = Placed._make((*np.full((4, size, n), np.nan), np.full((size, m, n), np.nan), *np.full((2, size, n), np.nan)))
    active = np.flatnonzero(frames.good)
    for _ in range(_ROUNDS[how]):
        if not len(active):
            break
        own, among = tori.take(active), frames.take(active)
        at = placed(task, own, among, trial[:, active], bounds=how == EXACT)
        found = angles_at(task, own, among, at, how)
        residual = wrapped(θ[:, active] - found.separated)
        size_ = np.max(np.abs(residual), axis=0)
        # what the engine's rounding leaves open of θ no step makes better, nor what that of q does, which it is given
        with np.errstate(all="ignore"):
            rounding_error = times(np.abs(matrix_of(found, at)), blurred(among, at))
        finished = found.good & (np.abs(residual) <= np.fmax(close, np.fmax(found.errors, rounding_error))).all(axis=0)
        # next to a separatrix residuals say nothing: the step that is left, by the slopes of the last, is to be shorter
        # (natural monotonicity; Deuflhard, Newton Methods for Nonlinear Problems (2004), §3.3)
        with np.errstate(invalid="ignore"):
            left = np.max(np.abs(times(back[active], residual)), axis=0)
            before = np.max(np.abs(step[:, active]), axis=0)
        better = found.good & (~np.isfinite(left) | (left < (1 - 0.25 * fraction[active]) * before) | finished)
        settled = ~better & (fraction[active] == 1.0) & (merit[active] < SETTLED)
        with np.errstate(all="ignore"):
            full = (fraction[active] == 1.0) & (merit[active] < 1)
            curve[active] = np.where(full, np.fmax(size_ / merit[active] ** 2, 1.0), curve[active])
            after = _FORESEEN * curve[active] * size_**2
        last = better & ~finished & (after <= close) & (how == EXACT)
        # what the engine's rounding leaves open is left to arcs at once
        open_ = better & (how == EXACT) & _unresolved(among, (trial[:, active], found, at), found.errors, θ[:, active])
        last &= ~open_
        here = active[better]
        base[:, here], seen[:, here], merit[here] = trial[:, here], trial[:, here], size_[better]
        for whole, part in zip(kept, at, strict=True):
            whole[..., here] = part[..., better]
        best.put(here, found, better)
        matrices = inverses(matrix_of(found, at)[better])
        newton, back[here] = times(matrices, residual[:, better]), matrices
        with np.errstate(all="ignore"):
            step[:, here], fraction[here] = newton, np.fmin(1.0, _LONGEST / np.max(np.abs(newton), axis=0))
        fraction[active[~better]] *= 0.25
        last &= fraction[active] == 1.0
        some = active[last]
        if len(some):
            base[:, some] += step[:, some]
            known = some, base[:, some], step[:, some]
            _stepped(task, tori.take(some), frames.take(some), (best, kept), known)
        active = active[~finished & ~settled & ~last & ~open_ & (fraction[active] >= _LEAST_STEP)]
        trial[:, active] = base[:, active] + fraction[active] * step[:, active]
    return base, best, kept, curve, seen


def _stepped(
    task: AngleTask, tori: Tori, frames: Frames, known: tuple[AnglesFound, Placed],
    last: tuple[Integers, Reals, Reals],
) -> None:  # fmt: skip
    """Move states by the last step: G by the trapezoidal rule, whose difference from R δφ is counted."""
    (best, kept), (index, φ, step) = known, last
    before, there = best.take(index), placed(task, tori, frames, φ, bounds=True)
    old, new = kept.rates[..., index], there.rates
    G, open_ = 0.5 * ((new + old) * step[:, None]).sum(axis=0), 0.5 * np.abs((new - old) * step[:, None]).sum(axis=0)
    size = len(step)
    best.separated[:, index] += times(before.inverse, G[:size])
    best.errors[:, index] += times(np.abs(before.inverse), open_[:size])
    for k, name in enumerate(task.model.angles):
        j = task.model.ignorable[name]
        along = times(before.inverse.transpose(0, 2, 1), before.integrals.means[:, j])
        best.ignorable[k, index] += G[j] - np.sum(along * G[:size], axis=0)
        best.ignorable_errors[k, index] += open_[j] + np.sum(np.abs(along) * open_[:size], axis=0)
    for whole, part in zip(kept, there, strict=True):
        whole[..., index] = part


def _nearest_start(task: AngleTask, tori: Tori, frames: Frames, θ: Reals) -> Reals:
    """Return the phases next to turning points whose angles are nearest: for motions that hardly leave an end."""
    size, n = θ.shape
    near = np.pi * 2.0 ** (-1.5 * np.arange(1, _STARTS + 1))
    tried = np.tile(θ[:, None], (1, size * 2 * _STARTS, 1))  # of one coordinate after the other, and either end
    for k, part in enumerate(np.split(tried, size, axis=1)):
        part[k] = np.copysign(np.concatenate([near, np.pi - near])[:, None], θ[k])
    each = np.tile(np.arange(n), size * 2 * _STARTS)
    own, among, φ = tori.take(each), frames.take(each), tried.reshape(size, -1)
    found = angles_at(task, own, among, placed(task, own, among, φ), DOUBLES)
    rotating = np.repeat(frames.rotating, 2 * _STARTS, axis=0)
    with np.errstate(invalid="ignore"):
        away = np.abs(wrapped(θ[:, each] - found.separated)).max(axis=0).reshape(-1, n)
    away = np.where(found.good.reshape(-1, n) & ~rotating, away, np.inf)
    best = away.argmin(axis=0)
    nearest = tried[:, best, np.arange(n)]
    return np.where(np.isfinite(away.min(axis=0)), nearest, θ)
