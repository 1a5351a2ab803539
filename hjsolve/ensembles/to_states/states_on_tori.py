"""States of n tori at given angles, with bounds on their errors.

Each coordinate is placed by an anomaly φ (``places_on_tori``), which Newton's method moves to where the angles are as
wanted (``phases_of_angles``). Errors of q and p are those of θ and J times ∂(q, p)/∂(θ, J). The first is known from the
same matrix; the second, which is only needed to a few digits, is the difference quotient of two tori.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import place
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.angles_of_states import AnglesFound, angles_at, ignorable_slopes, matrix_of
from hjsolve.ensembles.to_states.followed_tori import FollowedTori, angles_along, followed, followed_at, turning_of
from hjsolve.ensembles.to_states.narrow_tori import narrow_librations, narrow_ones, turning_points
from hjsolve.ensembles.to_states.phases_of_angles import SETTLED, SMALL, phases_of
from hjsolve.ensembles.to_states.places_on_tori import Frames, Placed, blurred, placed, refined, width_of
from hjsolve.ensembles.to_states.short_arcs import FINE, Passages, ShortArcs, angles_by_arcs, inverses, times, wrapped
from hjsolve.ensembles.to_states.tori import DOUBLES, AngleTask, Tori

_ROUNDING_ERROR = 5.0
"""Rounding of q, over W: from where the engine reads the phase off q, sin φ > 0.43."""
_SHIFT = 2.0**-17
"""Relative change of an action for the difference quotient."""
_ALIKE = 1e-8
"""Difference of angles by rough and by other integrals, radians, up to which the rough ones do for quotients."""
_ALIKE_AS_PART = 1e-5
"""The same of short angles, over the angle."""
_QUOTIENT_STEPS = 2
"""Steps of Newton's method for turning points that moved by as much."""
_LEAST_ANGLE = 2.0**-53
"""Radians of θ of a libration, by which the lower turning point is missed."""
_SAFETY_OF_QUOTIENTS = 2.0
"""By which difference quotients are enlarged."""


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


def states_at(
    task: AngleTask, tori: Tori, frames: Frames, angles: tuple[Reals, Reals], actions: tuple[Reals, Reals]
) -> StatesOnTori:
    """Return the states of tori at angles.

    Args:
        frames: between what they move.
        angles: θ of the separated coordinates (separated, n) and of the ignorable angles (angles, n).
        actions: J of the separated coordinates, and bounds on what is not known of them; shape (separated, n).
    """
    θ = wrapped(angles[0] * frames.directions)
    # θ of a rotation is 0 opposite to the slow place, of a libration at the lower turning point
    φ = np.where(frames.rotating, tori.q * frames.directions, θ)
    # p² has no digits left at a turning point itself: the state a little later, which the residual counts
    later = np.where(~frames.rotating & (np.abs(θ) < _LEAST_ANGLE), np.copysign(_LEAST_ANGLE, θ), θ)
    rough = followed_at(task, tori, frames)
    (φ, found, at), unresolved = phases_of(task, tori, frames, rough, (later, φ))
    residual = np.abs(wrapped(θ - found.separated))
    with np.errstate(all="ignore"):
        back = inverses(matrix_of(found, at))
        loose = residual + found.errors
        # the engine takes q rounded to a double, which narrow motions see as a shift of the phase
        rounding_error = _ROUNDING_ERROR * blurred(frames, at)
        phases = times(np.abs(back), loose) + rounding_error
        own = np.abs(at.moves) * phases, np.abs(at.forces) * phases
        moved = _quotients(
            task, tori, frames, (φ, at, found, back), (*actions, unresolved & (np.abs(θ) < SMALL), rough)
        )
        q_errors = own[0] + moved[0] + 2 * EPS * np.abs(at.q)
        P_errors = own[1] + moved[1] + 8 * EPS * np.abs(at.P) + at.rounding
        turned = wrapped(angles[1] - found.ignorable)
        turned_errors = found.ignorable_errors + moved[2] + 8 * EPS * np.pi
        # an error of the phases moves the ignorable angles as well
        slopes = ignorable_slopes(task.model, found, at)
        turned_errors = turned_errors + np.einsum("ain,in->an", np.abs(slopes), phases)
    good = frames.good & found.good & (residual <= SETTLED + 2 * rounding_error).all(axis=0)
    for part in (q_errors, P_errors, turned_errors):
        good = good & np.isfinite(part).all(axis=0)
    return StatesOnTori(at.q, at.P, q_errors, P_errors, turned, turned_errors, good)


def _quotients(
    task: AngleTask, tori: Tori, frames: Frames, here: tuple[Reals, Placed, AnglesFound, Reals],
    known: tuple[Reals, Reals, Mask, FollowedTori],
) -> tuple[Reals, Reals, Reals]:  # fmt: skip
    """Return what is not known of J moves of q, P and the ignorable angles, by difference quotients at fixed θ.

    ``known`` are J, bounds on what is not known of them, which angles are integrals from the turning point, and the
    rough running integrals.
    """
    (φ, at, found, back), (size, n), (J, spread, short, rough) = here, tori.q.shape, known
    moved = [np.zeros((size, n)), np.zeros((size, n)), np.zeros((len(task.model.angles), n))]
    plain = _rough_angles(task, tori, frames, rough, (φ, short))
    with np.errstate(all="ignore"):
        apart = np.abs(wrapped(plain[0] - found.separated))
        approximate = rough.good & (apart <= np.where(short, _ALIKE_AS_PART * np.abs(found.separated), _ALIKE)).all(
            axis=0
        )
        approximate &= ~narrow_ones(frames.narrow).any(axis=0)  # the height of these is not that of the constants
    for k in range(size):
        left = (spread[k] > 0) & found.good & ~frames.resting[k]
        for roughly in (True, False):
            loose = np.flatnonzero(left & approximate if roughly else left)
            if not len(loose):
                continue
            change = np.zeros((size, len(loose)))
            change[k] = _SHIFT * np.abs(J[k, loose])
            step = times(found.inverse[loose].transpose(0, 2, 1), change)  # ∂c/∂J
            own, among = tori.take(loose).moved(np.arange(size), step), frames.take(loose)
            if roughly:
                angles, among, fine = _roughly(task, own, among, (φ[:, loose], short[:, loose]))
                left[loose[fine]] = False
            else:
                angles, among = _in_doubles(task, own, among, (φ[:, loose], short[:, loose]), J[:, loose] + change)
                fine = np.ones(len(loose), dtype=bool)
            other = placed(task, own, among, φ[:, loose])
            here_ = plain if roughly else (found.separated, found.ignorable)
            turned, rows = (wrapped(x - y[:, loose]) for x, y in zip(angles, here_, strict=True))
            turn, factor = times(back[loose], turned), _SAFETY_OF_QUOTIENTS * spread[k, loose] / change[k]
            q = other.q - at.q[:, loose] - at.moves[:, loose] * turn
            P = other.P - at.P[:, loose] - at.forces[:, loose] * turn
            for whole, part in zip(moved, (q, P, rows), strict=True):
                whole[:, loose[fine]] += (factor * np.abs(part))[:, fine]
    return moved[0], moved[1], moved[2]


def _roughly(
    task: AngleTask, tori: Tori, frames: Frames, which: tuple[Reals, Mask]
) -> tuple[tuple[Reals, Reals], Frames, Mask]:
    """Angles by rough integrals at phases on tori next to some, their turning points, and which of them are known."""
    near = followed(task, tori._replace(ends=frames.bases), series=True, turning=turning_of(frames))
    frames = frames._replace(bases=near.bases, widths=near.widths)
    return _rough_angles(task, tori, frames, near, which), frames, near.good


def _rough_angles(
    task: AngleTask, tori: Tori, frames: Frames, rough: FollowedTori, which: tuple[Reals, Mask]
) -> tuple[Reals, Reals]:
    """Angles by rough integrals, of the separated and of the ignorable coordinates; short ones by arcs."""
    φ, short = which
    separated, ignorable = angles_along(task, rough.series, φ)
    some = np.flatnonzero(short.any(axis=0) & rough.good)
    if len(some):
        passages = Passages.of(task, tori.take(some), frames.take(some), exact=False)
        own = angles_by_arcs(
            task, ShortArcs.whole(rough.series.means[..., some], passages), φ[:, some], FINE, exact=False
        )
        separated[:, some], ignorable[:, some] = own.separated, own.ignorable
    return separated, ignorable


def _in_doubles(
    task: AngleTask, tori: Tori, frames: Frames, which: tuple[Reals, Mask], J: Reals
) -> tuple[tuple[Reals, Reals], Frames]:
    """Angles by the engine, or from turning points, and the turning points, of tori that have actions J."""
    among = _moved(task, tori, frames, J)
    found = angles_at(task, tori, among, placed(task, tori, among, which[0]), DOUBLES)
    _by_short_arcs(task, tori, among, found, which)
    return (found.separated, found.ignorable), among


def _moved(task: AngleTask, tori: Tori, frames: Frames, J: Reals) -> Frames:
    """Return the turning points of tori that are next to those of some frames, and have actions J."""
    bases, widths, tight = frames.bases.copy(), frames.widths.copy(), narrow_ones(frames.narrow)
    narrow = narrow_librations(task, tori, J, np.where(tight, np.inf, 0.0), tight).rows
    for i in range(len(widths)):
        some = np.flatnonzero(tight[i])
        bases[i][:, some], widths[i, some] = turning_points(task.model.separated[i], narrow[i][:, some])
        some = np.flatnonzero(~frames.rotating[i] & ~frames.resting[i] & ~tight[i])
        if len(some):
            ends = np.stack([_doubles(task, i, bases[i][:, some], side) for side in (0, 1)])
            bases[i][:, some] = refined(task, tori.take(some), i, ends, _QUOTIENT_STEPS)
            widths[i, some] = width_of(task, i, bases[i][:, some])
    return frames._replace(bases=bases, widths=widths, narrow=narrow)


def _by_short_arcs(task: AngleTask, tori: Tori, frames: Frames, found: AnglesFound, which: tuple[Reals, Mask]) -> None:
    """Write the angles that are integrals from turning points."""
    φ, ends = which
    some = np.flatnonzero(ends.any(axis=0) & found.good)
    if len(some):
        passages = Passages.of(task, tori.take(some), frames.take(some), exact=True)
        arcs = ShortArcs.of(found.take(some).integrals, found.inverse[some], passages, φ[:, some], ends[:, some])
        own = angles_by_arcs(task, arcs, φ[:, some], FINE, exact=True)
        found.separated[:, some], found.ignorable[:, some] = own.separated, own.ignorable


def _doubles(task: AngleTask, k: int, bases: Reals, side: int) -> Reals:
    return place(sides(task.model.separated[k])[side], bases[2 * side])
