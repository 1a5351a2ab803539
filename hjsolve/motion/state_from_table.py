"""The state at many times from a table of the motion: every quantity is worked out when it is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from hjsolve.arithmetic.number_types import AtTimes, Mask, Numbers, Reals
from hjsolve.mechanics.system import velocities
from hjsolve.motion.endings import end_statuses
from hjsolve.motion.initial_data import InBits, to_bits
from hjsolve.motion.near_poles import badly_rounded, velocities_from_pairs
from hjsolve.motion.positions import (
    canonical_momenta,
    constant_index,
    evaluate_along,
    gauge_angle,
    grown,
    principal_values,
)
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State
from hjsolve.motion.state_errors import table_errors
from hjsolve.motion.tabulated import DenseOutput, OnDemand, dense_output
from hjsolve.motion.times import whole_numbers, within_doubles
from hjsolve.time_law.compiled import kernels
from hjsolve.time_law.elapsed_time import halves, relative, relative_exact
from hjsolve.time_law.torus import mean_rate

_BLOCK = 32_768
"""How many times are worked on at once: memory that is touched for the first time costs more than the arithmetic."""


def state_from_table(
    motion: SeparatedMotion,
    t: object,
    floats: Reals | None,
    exact: Sequence[InBits],
    shape: tuple[int, ...] | None,
) -> State | None:
    """Return the state at times; None where no table serves.

    Args:
        motion: the motion.
        t: the times as the user gave them.
        floats: the times, shape (m,); None where they are no floats.
        exact: the times where they are no floats.
        shape: of the state's numbers; None for one number.

    Raises:
        InvalidInputError: a time too long for two doubles.
    """
    start = to_bits(motion.t0)
    if floats is None:
        times = TableTimes(motion, len(exact), None, halves(relative_exact(exact, start, 256)))
        extremes = times.elapsed
    else:
        times = TableTimes(motion, len(floats), floats)
        extremes = relative(np.array([floats.min(), floats.max()]) if len(floats) else floats, start)
    within_doubles(extremes)
    table = dense_output(
        motion, 2 * max(-float(np.min(extremes[0], initial=0.0)), float(np.max(extremes[0], initial=1e-290)))
    )
    if table is None:
        return None
    _, whole, ended = table.argument(motion, extremes)
    whole_numbers(whole)
    return _state(motion, table, t, times, bool(ended.any()), shape)


@dataclass(frozen=True, eq=False)
class TableTimes:
    """Many times of a motion that has a table.

    Attributes:
        motion: the motion.
        size: how many they are.
        given: t, shape (m,); None where they are no doubles.
        known: t − t₀ as two doubles, shape (m,), where they are none.
    """

    motion: SeparatedMotion
    size: int
    given: Reals | None
    known: tuple[Reals, Reals] | None = None

    def _within(self, part: slice) -> tuple[Reals, Reals]:
        if self.given is not None:
            return relative(self.given[part], to_bits(self.motion.t0))
        assert self.known is not None
        return self.known[0][part], self.known[1][part]

    @cached_property
    def elapsed(self) -> tuple[Reals, Reals]:
        """Times after t₀ as two doubles, shape (m,)."""
        return self._within(slice(None))

    def values(self, table: DenseOutput, quantity: int) -> Reals:
        """Return a quantity of a table, shape (m,).

        Args:
            table: of the motion.
            quantity: its position in the table.
        """
        result = np.empty(self.size)
        kernels(self.size)  # what decides whether numba is worth loading is all of them, not a block
        for begin in range(0, self.size, _BLOCK):
            part = slice(begin, begin + _BLOCK)
            θ, _, _ = table.argument(self.motion, self._within(part))
            result[part] = table.table.evaluate([quantity], θ)[0]
        return result


def _state(
    motion: SeparatedMotion, table: DenseOutput, t: object, times: TableTimes, ends: bool, shape: tuple[int, ...] | None
) -> State:
    system = motion.solution.system
    separated = motion.solution.coordinates[0]
    angles = tuple(c.name for c in system.coordinates if c.domain.kind == "angle")
    names = tuple(c.name for c in system.coordinates)

    @cache
    def arguments() -> tuple[Reals, Reals, Mask]:
        """Arguments of the table, whole turns, and where the motion has ended."""
        return table.argument(motion, times.elapsed)

    def beyond_the_end(values: Numbers) -> Numbers:
        return np.where(arguments()[2], np.nan, values) if ends else values

    def place(name: str) -> tuple[Numbers, Numbers]:
        """A coordinate in its principal value, and the whole turns of an angle."""
        value: Numbers
        count: Numbers
        if name == separated:
            course, whole = motion.located[name].course, arguments()[1]
            value, count = times.values(table, 0), course.direction * whole if course.rotates else 0.0 * whole
        else:
            index, begin = table.waves[name]
            wave = times.values(table, index) - begin
            coordinate = system.coordinate(name)
            gauge = gauge_angle(motion, coordinate.momentum, q) if motion.solution.shift_potential != 0 else 0.0
            rate = 0 if motion.torus is None else mean_rate(motion.torus, constant_index(motion, name))
            initial = to_bits(motion.initial.values[coordinate.symbol])
            value, count = grown(initial, rate, times.elapsed, None, name in angles, wave + gauge)
        value = beyond_the_end(value)
        if name not in angles:
            return value, count
        value, more = principal_values(value)
        return value, count + more

    places = OnDemand(names, place)

    def position(name: str) -> Numbers:
        return beyond_the_end(times.values(table, 0)) if name == separated and name not in angles else places[name][0]

    q = OnDemand(names, position)

    def momentum(name: str) -> Numbers:
        shell = {separated: times.values(table, 1)} if name == separated else {}
        return canonical_momenta(motion, q, shell, [name])[name]

    p = OnDemand(names, momentum)

    def velocity(name: str) -> Numbers:
        value = evaluate_along(motion, (velocities(system)[name],), q, p)[0]
        if table.ends is None or not sharp().any():
            return value
        near = arguments()[0][sharp()]
        return velocities_from_pairs(motion, *table.places(motion, near), q, {name: value}, sharp())[name]

    @cache
    def sharp() -> Mask:
        return badly_rounded(motion, q, p)

    def errors() -> Errors:
        groups = table_errors(motion, table, arguments()[0], q, p, v, None if table.ends is None else sharp())
        return Errors(*({n: shaped(values, shape) for n, values in group.items()} for group in groups))

    def view(source: Mapping[str, Numbers], chosen: tuple[str, ...]) -> OnDemand[AtTimes]:
        return OnDemand(chosen, lambda name: shaped(source[name], shape))

    counts = OnDemand(angles, lambda name: shaped(whole_numbers(places[name][1]), shape))
    v = OnDemand(names, velocity)
    if ends:
        status = end_statuses(motion, times.elapsed, arguments()[2])
    else:
        status = np.broadcast_to(np.array("ok"), (times.size,))
    return State(t, view(q, names), view(p, names), view(v, names), counts, shaped(status, shape), errors)
