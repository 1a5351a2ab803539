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
    elapsed = None if floats is not None else halves(relative_exact(exact, start, 256))
    given = floats if floats is not None else np.arange(len(exact))
    if floats is not None:
        extremes = relative(np.array([floats.min(), floats.max()]) if len(floats) else floats, start)
    else:
        assert elapsed is not None
        extremes = elapsed
    within_doubles(extremes)
    table = dense_output(
        motion, 2 * max(-float(np.min(extremes[0], initial=0.0)), float(np.max(extremes[0], initial=1e-290)))
    )
    if table is None:
        return None
    _, whole, ended = table.argument(motion, extremes)
    whole_numbers(whole)
    return _state(motion, table, t, TableTimes(motion, table, given, elapsed), bool(ended.any()), shape)


@dataclass(frozen=True, eq=False)
class TableTimes:
    """Many times of a motion that has a table.

    Attributes:
        motion: the motion.
        table: its table.
        given: times as doubles, shape (m,); only their number counts where ``known`` is there.
        known: t − t₀ as two doubles, shape (m,), where the times are no doubles.
    """

    motion: SeparatedMotion
    table: DenseOutput
    given: Numbers
    known: tuple[Reals, Reals] | None

    def _within(self, part: slice) -> tuple[Reals, Reals]:
        if self.known is not None:
            return self.known[0][part], self.known[1][part]
        return relative(self.given[part], to_bits(self.motion.t0))

    @cached_property
    def elapsed(self) -> tuple[Reals, Reals]:
        """Times after t₀ as two doubles, shape (m,)."""
        return self._within(slice(None))

    @cached_property
    def arguments(self) -> tuple[Reals, Reals, Mask]:
        """Arguments of the table, whole turns, and where the motion has ended; shape (m,)."""
        return self.table.argument(self.motion, self.elapsed)

    def values(self, quantity: int) -> Reals:
        """Return a quantity of the table, shape (m,).

        Args:
            quantity: its position in the table.
        """
        table = self.table.table
        if "arguments" in self.__dict__:
            return table.evaluate([quantity], self.arguments[0])[0]
        result = np.empty(len(self.given))
        kernels(len(result))  # what decides whether numba is worth loading is all of them, not a block
        for begin in range(0, len(result), _BLOCK):
            part = slice(begin, begin + _BLOCK)
            θ, _, _ = self.table.argument(self.motion, self._within(part))
            result[part] = table.evaluate([quantity], θ)[0]
        return result


def _state(
    motion: SeparatedMotion, table: DenseOutput, t: object, times: TableTimes, ends: bool, shape: tuple[int, ...] | None
) -> State:
    system = motion.solution.system
    separated = motion.solution.coordinates[0]
    angles = tuple(c.name for c in system.coordinates if c.domain.kind == "angle")
    names = tuple(c.name for c in system.coordinates)

    def beyond_the_end(values: Numbers) -> Numbers:
        return np.where(times.arguments[2], np.nan, values) if ends else values

    def place(name: str) -> tuple[Numbers, Numbers]:
        """A coordinate in its principal value, and the whole turns of an angle."""
        value: Numbers
        count: Numbers
        if name == separated:
            course, whole = motion.located[name].course, times.arguments[1]
            value, count = times.values(0), course.direction * whole if course.rotates else 0.0 * whole
        else:
            index, begin = table.waves[name]
            wave = times.values(index) - begin
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
        return beyond_the_end(times.values(0)) if name == separated and name not in angles else places[name][0]

    q = OnDemand(names, position)

    def momentum(name: str) -> Numbers:
        shell = {separated: times.values(1)} if name == separated else {}
        return canonical_momenta(motion, q, shell, [name])[name]

    p = OnDemand(names, momentum)

    def velocity(name: str) -> Numbers:
        value = evaluate_along(motion, (velocities(system)[name],), q, p)[0]
        if table.ends is None or not sharp().any():
            return value
        near = times.arguments[0][sharp()]
        return velocities_from_pairs(motion, *table.places(motion, near), q, {name: value}, sharp())[name]

    @cache
    def sharp() -> Mask:
        return badly_rounded(motion, q, p)

    def errors() -> Errors:
        groups = table_errors(motion, table, times.arguments[0], q, p, v, None if table.ends is None else sharp())
        return Errors(*({n: shaped(values, shape) for n, values in group.items()} for group in groups))

    def view(source: Mapping[str, Numbers], chosen: tuple[str, ...]) -> OnDemand[AtTimes]:
        return OnDemand(chosen, lambda name: shaped(source[name], shape))

    counts = OnDemand(angles, lambda name: shaped(whole_numbers(places[name][1]), shape))
    v = OnDemand(names, velocity)
    if ends:
        status = end_statuses(motion, times.elapsed, times.arguments[2])
    else:
        status = np.broadcast_to(np.array("ok"), (len(times.given),))
    return State(t, view(q, names), view(p, names), view(v, names), counts, shaped(status, shape), errors)
