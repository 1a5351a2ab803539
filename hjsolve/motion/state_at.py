"""q(t) of a motion: the time law inverted, angles unwound, errors carried along."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Mask, Numbers, Reals
from hjsolve.mechanics.system import velocities
from hjsolve.motion.endings import end_statuses
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.near_poles import badly_rounded, sharpened_velocities, velocities_from_pairs
from hjsolve.motion.phases import Phases, courses_of, phases_at
from hjsolve.motion.positions import (
    canonical_momenta,
    constant_index,
    coordinate_velocities,
    evaluate_along,
    gauge_angle,
    grown,
    positions_at,
    principal_values,
)
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, separated_motion
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State
from hjsolve.motion.state_errors import errors_of_state, table_errors
from hjsolve.motion.tabulated import FEWEST, DenseOutput, OnDemand, dense_output, needs_table
from hjsolve.motion.times import read_times, whole_numbers, within_doubles
from hjsolve.time_law.elapsed_time import halves, relative, relative_exact
from hjsolve.time_law.torus import mean_rate


def state_at_times(motion: SeparatedMotion, t: object, digits: int | None = None) -> State:
    """Return the state at a time or times; see ``Motion.at``.

    Args:
        motion: the motion.
        t: time or times.
        digits: digits wanted of the phases; those of the motion where None.
    """
    shape, floats, exact = read_times(t)
    if motion.digits <= FLOAT_DIGITS and (needs_table(motion) or (floats is not None and len(floats) >= FEWEST)):
        start = to_bits(motion.t0)
        time = relative(floats, start) if floats is not None else halves(relative_exact(exact, start, 256))
        within_doubles(time)
        table = dense_output(
            motion, 2 * max(-float(np.min(time[0], initial=0.0)), float(np.max(time[0], initial=1e-290)))
        )
        if table is not None:
            return _tabulated(motion, table, t, time, shape)
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


def _tabulated(
    motion: SeparatedMotion, table: DenseOutput, t: object, time: tuple[Reals, Reals], shape: tuple[int, ...] | None
) -> State:
    """The state from a table: every quantity is worked out when it is read."""
    system = motion.solution.system
    θ, whole, ended = table.argument(motion, time)
    whole_numbers(whole)
    separated = motion.solution.coordinates[0]
    angles = tuple(c.name for c in system.coordinates if c.domain.kind == "angle")
    names = tuple(c.name for c in system.coordinates)

    def place(name: str) -> tuple[Numbers, Numbers]:
        value: Numbers
        count: Numbers
        if name == separated:
            course = motion.located[name].course
            value, count = table.table.evaluate([0], θ)[0], course.direction * whole if course.rotates else 0.0 * whole
        else:
            index, begin = table.waves[name]
            wave = table.table.evaluate([index], θ)[0] - begin
            coordinate = system.coordinate(name)
            gauge = gauge_angle(motion, coordinate.momentum, q) if motion.solution.shift_potential != 0 else 0.0
            rate = 0 if motion.torus is None else mean_rate(motion.torus, constant_index(motion, name))
            value, count = grown(
                to_bits(motion.initial.values[coordinate.symbol]), rate, time, None, name in angles, wave + gauge
            )
        if ended.any():
            value = np.where(ended, np.nan, value)
        if name not in angles:
            return value, count
        value, more = principal_values(value)
        return value, count + more

    places = OnDemand(names, place)
    q = OnDemand(names, lambda name: places[name][0])

    def momentum(name: str) -> Numbers:
        shell = {separated: table.table.evaluate([1], θ)[0]} if name == separated else {}
        return canonical_momenta(motion, q, shell, [name])[name]

    p = OnDemand(names, momentum)

    def velocity(name: str) -> Numbers:
        value = evaluate_along(motion, (velocities(system)[name],), q, p)[0]
        if table.ends is None or not sharp().any():
            return value
        return velocities_from_pairs(motion, *table.places(motion, θ[sharp()]), q, {name: value}, sharp())[name]

    @cache
    def sharp() -> Mask:
        return badly_rounded(motion, q, p)

    def errors() -> Errors:
        groups = table_errors(motion, table, θ, q, p, v, None if table.ends is None else sharp())
        return Errors(*({n: shaped(values, shape) for n, values in group.items()} for group in groups))

    def view(source: Mapping[str, Numbers], chosen: tuple[str, ...]) -> OnDemand[AtTimes]:
        return OnDemand(chosen, lambda name: shaped(source[name], shape))

    counts = OnDemand(angles, lambda name: shaped(whole_numbers(places[name][1]), shape))
    v = OnDemand(names, velocity)
    status = end_statuses(motion, time, ended) if ended.any() else np.broadcast_to(np.array("ok"), ended.shape)
    return State(t, view(q, names), view(p, names), view(v, names), counts, shaped(status, shape), errors)
