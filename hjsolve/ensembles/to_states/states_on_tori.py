"""States of n tori at given angles, with bounds on their errors.

Each coordinate is placed by an anomaly φ (``places_on_tori``). The engine gives θ there, and Newton's method with

    ∂θₖ/∂φᵢ = Σⱼ (∂J/∂c)⁻¹ₖⱼ kᵢⱼ/pᵢ dqᵢ/dφᵢ

moves them to the angles wanted. Errors of q and p are those of θ and J times ∂(q, p)/∂(θ, J). The first is known from
the same matrix; the second, which is only needed to a few digits, is the difference quotient of two tori.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.actions_and_angles import combine_integrals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, place
from hjsolve.ensembles.engine.kernels.types import Modes, Sums, no_sums
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.places_on_tori import AngleTask, Frames, Placed, placed, refined, width_of
from hjsolve.ensembles.to_states.short_arcs import (
    Integrals,
    ShortArcs,
    angles_by_arcs,
    inverses,
    phases_by_arcs,
    times,
    wrapped,
)
from hjsolve.ensembles.to_states.tori import Tori, coordinate_at

_TIMED = Modes(chords=False, kernels=True, oscillations=True, shifts=False)
_ROUNDS, _LEAST_STEP = 60, 2.0**-30
"""Evaluations of θ, and the share of a step below which an orbit is given up."""
_LONGEST = 1.0
"""Radians that a phase moves in one step, at most."""
_CLOSE = 4e-15
"""Residual of angles, radians, at which an orbit is done."""
_NEARLY = 1e-8
"""The same, as long as p² is in doubles."""
_SETTLED = 1e-9
"""Residual below which a step that makes nothing better ends the search."""
_STARTS = 8
"""Phases next to either turning point from which Newton's method begins again."""
_KNOWN, _SMALL = 1e-11, 0.1
"""Error of a phase above which angles below the second, radians, come from integrals over short arcs."""
_TINY, _BEGIN = 1e-3, 0.3
"""Angle, radians, below which arcs come first, and the phase at which they then begin."""
_BLUR = 5.0
"""Rounding of q, over W: from where the engine reads the phase off q, sin φ > 0.43."""
_SHIFT = 2.0**-17
"""Relative change of an action for the difference quotient."""
_QUOTIENT_STEPS = 2
"""Steps of Newton's method for turning points that moved by as much."""
_SAFETY = 2.0
"""By which difference quotients are enlarged."""


class AnglesFound(NamedTuple):
    """Angles of n states.

    Attributes:
        separated, errors: θ of the separated coordinates in the sense of their rotation, and bounds; (separated, n).
        ignorable, ignorable_errors: of the ignorable ones that are angles, where these are at 0; (angles, n).
        inverse: (∂J/∂c)⁻¹, shape (n, separated, separated).
        integrals: of the engine, ∂J/∂c and the running ones.
        good: which are known.
    """

    separated: Reals
    errors: Reals
    ignorable: Reals
    ignorable_errors: Reals
    inverse: Reals
    integrals: Integrals
    good: Mask

    def put(self, index: Integers, other: AnglesFound, which: Mask) -> None:
        """Write some of others into these.

        Args:
            index: their places here.
            other: the others.
            which: which of them.
        """
        for mine, theirs in zip(self._flat(), other._flat(), strict=True):
            mine[..., index] = theirs[..., which]

    def _flat(self) -> tuple[Reals | Mask, ...]:
        """Return views of all arrays whose last axis is that of the orbits."""
        separated, errors, ignorable, ignorable_errors, inverse, integrals, good = self
        return separated, errors, ignorable, ignorable_errors, inverse.transpose(1, 2, 0), *integrals, good


class StatesOnTori(NamedTuple):
    """States; arrays (separated, n), of ignorable angles (angles, n).

    Attributes:
        q, P: of the separated coordinates.
        q_errors, P_errors: bounds on their errors.
        angles, angle_errors: ignorable angles.
        good: which are known.
    """

    q: Reals
    P: Reals
    q_errors: Reals
    P_errors: Reals
    angles: Reals
    angle_errors: Reals
    good: Mask


def angles_at(task: AngleTask, tori: Tori, frames: Frames, at: Placed, *, exact: bool) -> AnglesFound:
    """Return the angles of states on tori, by the engine.

    Args:
        task: the system.
        tori: of n orbits.
        frames: between what they move.
        at: the states.
        exact: whether p² is taken to 32 digits where doubles do not know it well.
    """
    model, (size, n) = task.model, at.q.shape
    sums, good = [], np.ones(n, dtype=bool)
    for k in range(size):
        one = coordinate_at(*task, tori._replace(q=at.q), k, at.P[k])
        total = no_sums(len(model.constants), n)
        moving = np.flatnonzero(~frames.resting[k])
        if len(moving):
            part, _, _ = integrated(one.take(moving), _TIMED, exact=exact, places=False)
            total.put(moving, part)
        still = np.flatnonzero(frames.resting[k])
        if len(still):
            total.put(still, _resting_sums(one.take(still), at.rates[k][:, still]))
        good &= total.good
        sums.append(total)
    q = np.zeros((len(model.names), n))
    for k, coordinate in enumerate(model.separated):
        q[coordinate.index] = at.q[k]
    torus = combine_integrals(model, sums, frames.directions, q, angles=True)
    means = np.stack([s.means for s in sums])
    with np.errstate(all="ignore"):
        inverse = np.full((n, size, size), np.nan)
        matrix = means[:, :size].transpose(2, 1, 0)
        fine = (
            good & np.isfinite(matrix).all(axis=(1, 2)) & (np.linalg.det(np.where(np.isfinite(matrix), matrix, 0)) != 0)
        )
        inverse[fine] = np.linalg.inv(matrix[fine])
    rows = [torus.angles[c.name] for c in model.separated]
    others = [torus.angles[name] for name in model.angles]
    empty = np.zeros((0, n))
    separated = np.stack([row[0] for row in rows]) * frames.directions
    good = fine & np.isfinite(separated).all(axis=0)
    return AnglesFound(
        separated, np.stack([row[1] for row in rows]), np.stack([x for x, _ in others]) if others else empty,
        np.stack([e for _, e in others]) if others else empty, inverse, _integrals(sums), good,
    )  # fmt: skip


def _integrals(sums: list[Sums]) -> Integrals:
    """∂J/∂c, and G = phase times that plus the oscillations."""
    means, errors, oscillations, roundings, speeds = (
        np.stack([getattr(s, part) for s in sums])
        for part in ("means", "mean_errors", "oscillations", "oscillation_errors", "speeds")
    )
    phases, phase_errors = (np.stack([getattr(s, part) for s in sums])[:, None] for part in ("phase", "phase_error"))
    running_errors = errors * np.abs(phases) + roundings + np.abs(speeds) * phase_errors
    return Integrals(means, errors, means * phases + oscillations, running_errors)


def _resting_sums(one: CoordinateOfOrbits, rates: Reals) -> Sums:
    sums = no_sums(len(one.constants), len(one.q))
    sums.means[:] = sums.speeds[:] = rates
    sums.mean_errors[:] = 8 * EPS * np.abs(rates)
    for zero in ("action", "action_error", "oscillations", "oscillation_errors", "phase", "phase_error"):
        getattr(sums, zero)[...] = 0.0
    sums.good[:] = np.isfinite(rates).all(axis=0)
    return sums


def states_at(
    task: AngleTask, tori: Tori, frames: Frames, angles: tuple[Reals, Reals], actions: tuple[Reals, Reals]
) -> StatesOnTori:
    """Return the states of tori at angles.

    Args:
        task: the system.
        tori: of n orbits.
        frames: between what they move.
        angles: θ of the separated coordinates (separated, n) and of the ignorable angles (angles, n).
        actions: J of the separated coordinates, and bounds on what is not known of them; shape (separated, n).
    """
    θ = wrapped(angles[0] * frames.directions)
    # θ of a rotation is 0 opposite to the slow place, of a libration at the lower turning point
    φ = np.where(frames.rotating, tori.q * frames.directions, θ)
    close = _close_to_ends(task, tori, frames, θ, φ)
    rest = np.flatnonzero(~close)
    if len(rest):
        φ[:, rest] = _nearly(task, tori.take(rest), frames.take(rest), θ[:, rest], φ[:, rest])
    here = _phases(task, tori, frames, (θ, φ), exact=True)
    vague = _vague(frames, here, θ)
    φ, found, at = _by_arcs(task, tori, frames, here, (θ, vague))
    residual = np.abs(wrapped(θ - found.separated))
    with np.errstate(all="ignore"):
        back = inverses(_matrix(found, at))
        loose = residual + found.errors
        # the engine takes q rounded to a double, which narrow motions see as a shift of the phase
        between = ~frames.rotating & ~frames.resting
        blur = np.where(between, _BLUR * EPS * np.abs(at.q) / frames.widths, 0.0)
        phases = times(np.abs(back), loose) + blur
        own = np.abs(at.moves) * phases, np.abs(at.forces) * phases
        moved = _quotients(task, tori, frames, (φ, at, found, back), (*actions, vague & (np.abs(θ) < _SMALL)))
        q_errors = own[0] + moved[0] + 2 * EPS * np.abs(at.q)
        P_errors = own[1] + moved[1] + 8 * EPS * np.abs(at.P)
        turned = wrapped(angles[1] - found.ignorable)
        turned_errors = found.ignorable_errors + moved[2] + 8 * EPS * np.pi
        # an error of the phases moves the ignorable angles as well
        turned_errors = turned_errors + _ignorable_rates(task.model, found, at, phases)
    good = frames.good & found.good & (residual <= _SETTLED + 2 * blur).all(axis=0)
    for part in (q_errors, P_errors, turned_errors):
        good = good & np.isfinite(part).all(axis=0)
    return StatesOnTori(at.q, at.P, q_errors, P_errors, turned, turned_errors, good)


def _close_to_ends(task: AngleTask, tori: Tori, frames: Frames, θ: Reals, φ: Reals) -> Mask:
    """Write the phases of small angles, by arcs alone; return which were found."""
    found: Mask = frames.good & ~(frames.rotating | frames.resting).any(axis=0) & (np.abs(θ) < _TINY).any(axis=0)
    some = np.flatnonzero(found)
    if not len(some):
        return found
    own, among, goal = tori.take(some), frames.take(some), θ[:, some]
    begin = np.where(np.abs(goal) < _TINY, np.copysign(_BEGIN, goal), φ[:, some])
    engine = angles_at(task, own, among, placed(task, own, among, begin), exact=False)
    arcs = ShortArcs.of(engine.integrals, engine.inverse, begin, np.abs(goal) < _SMALL)
    moved, known = phases_by_arcs(task, own, among, arcs, (goal, begin))
    φ[:, some[known]] = moved[:, known]
    found[some[~known]] = False
    return found


def _nearly(task: AngleTask, tori: Tori, frames: Frames, θ: Reals, φ: Reals) -> Reals:
    """Phases of angles, by the engine in doubles."""
    φ, found, _ = _phases(task, tori, frames, (θ, φ), exact=False)
    far = np.flatnonzero(frames.good & ~(np.abs(wrapped(θ - found.separated)).max(axis=0) < _NEARLY))
    if len(far):
        among = frames.take(far)
        start = _nearest_start(task, tori.take(far), among, θ[:, far])
        φ[:, far], *_ = _phases(task, tori.take(far), among, (θ[:, far], start), exact=False)
    return φ


_Here = tuple[Reals, AnglesFound, Placed]


def _vague(frames: Frames, here: _Here, θ: Reals) -> Mask:
    """Tell which phases the engine's angles leave open, of orbits that librate in all coordinates."""
    _, found, at = here
    with np.errstate(all="ignore"):
        loose = np.abs(wrapped(θ - found.separated)) + found.errors
        known = np.asarray(times(np.abs(inverses(_matrix(found, at))), loose).max(axis=0) <= _KNOWN)
    moving = ~(frames.rotating | frames.resting).any(axis=0) & found.good
    vague: Mask = np.asarray(moving & ~known & (np.abs(θ) < _SMALL).any(axis=0), dtype=bool)
    return vague


def _by_arcs(task: AngleTask, tori: Tori, frames: Frames, here: _Here, which: tuple[Reals, Mask]) -> _Here:
    """Move vague states to their angles by integrals over short arcs."""
    (φ, found, at), (θ, vague) = here, which
    some = np.flatnonzero(vague)
    if not len(some):
        return here
    own, among = tori.take(some), frames.take(some)
    known = Integrals._make(x[..., some] for x in found.integrals)
    arcs = ShortArcs.of(known, found.inverse[some], φ[:, some], np.abs(θ[:, some]) < _SMALL)
    moved, _ = phases_by_arcs(task, own, among, arcs, (θ[:, some], φ[:, some]))
    better = angles_by_arcs(task, own, among, arcs, moved, proved=True)
    φ[:, some] = moved
    for whole, part in zip(at, placed(task, own, among, moved), strict=True):
        whole[..., some] = part
    for name, part in better._asdict().items():
        getattr(found, name)[..., some] = part
    return φ, found, at


def _matrix(found: AnglesFound, at: Placed) -> Reals:
    """∂θ/∂φ, shape (n, separated, separated)."""
    size = at.q.shape[0]
    rates = at.rates[:, :size].transpose(2, 1, 0)  # (n, constant, coordinate)
    return found.inverse @ rates


def _phases(
    task: AngleTask, tori: Tori, frames: Frames, given: tuple[Reals, Reals], *, exact: bool
) -> tuple[Reals, AnglesFound, Placed]:
    """Phases at which the separated coordinates have given angles, by damped Newton's method from other phases."""
    (θ, base), m, close = given, len(task.model.constants), _CLOSE if exact else _NEARLY
    size, n = θ.shape
    base = base.copy()
    trial, step = base.copy(), np.zeros((size, n))
    share, merit = np.ones(n), np.full(n, np.inf)
    angles = len(task.model.angles)
    shapes = (size, n), (size, n), (angles, n), (angles, n), (n, size, size)
    integrals = Integrals._make(np.full((size, m, n), np.nan) for _ in range(4))
    best = AnglesFound._make((*(np.full(shape, np.nan) for shape in shapes), integrals, np.zeros(n, dtype=bool)))
    kept = Placed._make((*(np.full((size, n), np.nan) for _ in range(4)), np.full((size, m, n), np.nan)))
    active = np.flatnonzero(frames.good)
    for _ in range(_ROUNDS):
        if not len(active):
            break
        own, among = tori.take(active), frames.take(active)
        at = placed(task, own, among, trial[:, active])
        found = angles_at(task, own, among, at, exact=exact)
        residual = wrapped(θ[:, active] - found.separated)
        size_ = np.max(np.abs(residual), axis=0)
        # what the engine's rounding leaves open of θ no step makes better
        finished = found.good & (np.abs(residual) <= np.fmax(close, found.errors)).all(axis=0)
        better = found.good & ((size_ < (1 - 0.25 * share[active]) * merit[active]) | finished)
        settled = ~better & (share[active] == 1.0) & (merit[active] < _SETTLED)
        here = active[better]
        base[:, here], merit[here] = trial[:, here], size_[better]
        for whole, part in zip(kept, at, strict=True):
            whole[..., here] = part[..., better]
        best.put(here, found, better)
        matrices = inverses(_matrix(found, at)[better])
        newton = times(matrices, residual[:, better])
        with np.errstate(all="ignore"):
            step[:, here], share[here] = newton, np.fmin(1.0, _LONGEST / np.max(np.abs(newton), axis=0))
        share[active[~better]] *= 0.25
        active = active[~finished & ~settled & (share[active] >= _LEAST_STEP)]
        trial[:, active] = base[:, active] + share[active] * step[:, active]
    return base, best, kept


def _nearest_start(task: AngleTask, tori: Tori, frames: Frames, θ: Reals) -> Reals:
    """Return the phases next to turning points whose angles are nearest: for motions that hardly leave an end."""
    best, merit = θ.copy(), np.full(θ.shape[1], np.inf)
    for k in range(θ.shape[0]):
        for upper in (False, True):
            for power in range(1, _STARTS + 1):
                φ = θ.copy()
                near = np.pi * 2.0 ** -(1.5 * power)
                φ[k] = np.copysign(np.pi - near if upper else near, θ[k])
                at = placed(task, tori, frames, φ)
                found = angles_at(task, tori, frames, at, exact=False)
                with np.errstate(invalid="ignore"):
                    away = np.abs(wrapped(θ - found.separated)).max(axis=0)
                better = found.good & (away < merit) & ~frames.rotating[k]
                best[:, better], merit[better] = φ[:, better], away[better]
    return best


def _ignorable_rates(model: Model, found: AnglesFound, at: Placed, phases: Reals) -> Reals:
    """Return what errors of the phases do to the ignorable angles."""
    rows: list[Reals] = []
    for name in model.angles:
        j = model.ignorable[name]
        # dθ_φ/dφᵢ at fixed q_φ: rates of its own kernel less the mean growth along θ
        slope = at.rates[:, j] - np.einsum("kn,nki->in", found.integrals.means[:, j], _matrix(found, at))
        rows.append(np.sum(np.abs(slope) * phases, axis=0))
    return np.stack(rows) if rows else np.zeros((0, at.q.shape[1]))


def _quotients(
    task: AngleTask, tori: Tori, frames: Frames, here: tuple[Reals, Placed, AnglesFound, Reals],
    known: tuple[Reals, Reals, Mask],
) -> tuple[Reals, Reals, Reals]:  # fmt: skip
    """Return what is not known of J moves of q, P and the ignorable angles, by difference quotients at fixed θ.

    ``known`` are J, bounds on what is not known of them, and which angles are integrals from the turning point.
    """
    (φ, at, found, back), (size, n), (J, spread, short) = here, tori.q.shape, known
    moved = [np.zeros((size, n)), np.zeros((size, n)), np.zeros((len(task.model.angles), n))]
    unknown = np.arange(size)
    inverse = found.inverse.transpose(0, 2, 1)  # ∂c/∂J
    for k in range(size):
        loose = np.flatnonzero((spread[k] > 0) & found.good & ~frames.resting[k])
        if not len(loose):
            continue
        change = np.zeros((size, len(loose)))
        change[k] = _SHIFT * np.abs(J[k, loose])
        own = tori.take(loose).moved(unknown, times(inverse[loose], change))
        among = frames.take(loose)
        bases, widths = among.bases.copy(), among.widths.copy()
        for i in range(size):
            some = np.flatnonzero(~among.rotating[i] & ~among.resting[i])
            if len(some):
                ends = np.stack([_doubles(task, i, bases[i][:, some], side) for side in (0, 1)])
                bases[i][:, some] = refined(task, own.take(some), i, ends, _QUOTIENT_STEPS)
                widths[i, some] = width_of(task, i, bases[i][:, some])
        among = among._replace(bases=bases, widths=widths)
        other = placed(task, own, among, φ[:, loose])
        angles = angles_at(task, own, among, other, exact=False)
        _by_short_arcs(task, own, among, angles, (φ[:, loose], short[:, loose]))
        turn = times(back[loose], wrapped(angles.separated - found.separated[:, loose]))
        factor = _SAFETY * spread[k, loose] / change[k]
        moved[0][:, loose] += factor * np.abs(other.q - at.q[:, loose] - at.moves[:, loose] * turn)
        moved[1][:, loose] += factor * np.abs(other.P - at.P[:, loose] - at.forces[:, loose] * turn)
        rows = wrapped(angles.ignorable - found.ignorable[:, loose])
        moved[2][:, loose] += factor * np.abs(rows)
    return moved[0], moved[1], moved[2]


def _by_short_arcs(task: AngleTask, tori: Tori, frames: Frames, found: AnglesFound, which: tuple[Reals, Mask]) -> None:
    """Write the angles that are integrals from turning points."""
    φ, ends = which
    some = np.flatnonzero(ends.any(axis=0) & found.good)
    if len(some):
        known = Integrals._make(x[..., some] for x in found.integrals)
        arcs = ShortArcs.of(known, found.inverse[some], φ[:, some], ends[:, some])
        own = angles_by_arcs(task, tori.take(some), frames.take(some), arcs, φ[:, some], proved=False)
        found.separated[:, some], found.ignorable[:, some] = own.separated, own.ignorable


def _doubles(task: AngleTask, k: int, bases: Reals, side: int) -> Reals:
    return place(sides(task.model.separated[k])[side], bases[2 * side])
