"""q(t) of a motion: the time law inverted, angles unwound, errors carried along."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Numbers
from hjsolve.motion.near_poles import badly_rounded, sharpened_velocities
from hjsolve.motion.phases import Phases, courses_of, phases_at
from hjsolve.motion.positions import coordinate_velocities, positions_at
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, separated_motion
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State
from hjsolve.motion.state_errors import errors_of_state
from hjsolve.motion.state_from_table import end_statuses, tabulated_state
from hjsolve.motion.tabulated import FEWEST, needs_table
from hjsolve.motion.times import read_times, whole_numbers


def state_at_times(motion: SeparatedMotion, t: object, digits: int | None = None) -> State:
    """Return the state at a time or times; see ``Motion.at``.

    Args:
        t: time or times.
        digits: digits wanted of the phases; those of the motion where None.
    """
    shape, floats, exact = read_times(t)
    if motion.digits <= FLOAT_DIGITS and (needs_table(motion) or (floats is not None and len(floats) >= FEWEST)):
        tabulated = tabulated_state(motion, t, floats, exact, shape)
        if tabulated is not None:
            return tabulated
    phases = phases_at(motion, floats, exact)
    wanted = digits or motion.digits
    if lacking := _lacking(motion, phases, wanted):
        given = motion.solution, motion.initial, motion.t0
        more = separated_motion(*given, motion.digits + lacking, motion.parts)
        return state_at_times(more, t, wanted)
    q, p, whole = positions_at(motion, phases)
    v = coordinate_velocities(motion, q, p)
    sharp = None if phases.exact is not None else badly_rounded(motion, q, p)
    if sharp is not None and sharp.any():
        v = sharpened_velocities(motion, courses_of(motion, phases), [x.astype(float) for x in phases.χ], q, v, sharp)
    status = end_statuses(motion, phases.time, phases.ended)
    turns = {name: whole_numbers(n) for name, n in whole.items()}
    for group in (q, p, v):
        for name, values in group.items():
            group[name] = np.where(phases.ended, np.nan, values) if phases.ended.any() else values

    def reshaped(group: Mapping[str, Numbers]) -> dict[str, AtTimes]:
        return {name: shaped(values, shape) for name, values in group.items()}

    def errors() -> Errors:
        return Errors(*(reshaped(group) for group in errors_of_state(motion, phases, q, p, whole, sharp)))

    return State(
        t,
        reshaped(q),
        reshaped(p),
        reshaped(v),
        {name: shaped(n, shape) for name, n in turns.items()},
        shaped(status, shape),
        errors,
    )


def _lacking(motion: SeparatedMotion, phases: Phases, wanted: int) -> int:
    """Digits that the series must have more: where dt/dχ is far below its mean, a phase has fewer than its time."""
    if phases.exact is None or motion.digits > 3 * wanted:
        return 0
    worst = max((max(errors, default=0) for errors in phases.errors), default=0)
    if worst * multiprecision(64).mpf(10) ** (wanted - 1) <= 1:
        return 0
    return wanted + 2 + int(multiprecision(64).log10(worst))
