"""The state at many times from a table of the motion: every quantity is worked out when it is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import AtTimes, Counts, Mask, Numbers, Reals
from hjsolve.errors import required
from hjsolve.mechanics.system import velocities
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
from hjsolve.time_law.open_motion import reaching
from hjsolve.time_law.torus import mean_rate

_BLOCK = 32_768
"""How many times are worked on at once: memory that is touched for the first time costs more than the arithmetic."""


def tabulated_state(
    motion: SeparatedMotion, t: object, floats: Reals | None, exact: Sequence[InBits], shape: tuple[int, ...] | None
) -> State | None:
    """Return the state at times; None where no table serves.

    Args:
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
    # only the extremes: too many turns, or an end of the motion, show there first
    _, whole, ended = table.argument(motion, extremes)
    whole_numbers(whole)
    return _state(_Quantities(motion, table, times, bool(ended.any())), t, shape)


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
        known = required(self.known)
        return known[0][part], known[1][part]

    @cached_property
    def elapsed(self) -> tuple[Reals, Reals]:
        """Times after t₀ as two doubles, shape (m,)."""
        return self._within(slice(None))

    def values(self, table: DenseOutput, quantity: int) -> Reals:
        """Return a quantity of a table, shape (m,).

        Args:
            quantity: its position in the table.
        """
        result = np.empty(self.size)
        kernels(self.size)  # what decides whether numba is worth loading is all of them, not a block
        for begin in range(0, self.size, _BLOCK):
            part = slice(begin, begin + _BLOCK)
            # the argument is made anew for each block: to keep it for all would take more memory than the result
            θ, _, _ = table.argument(self.motion, self._within(part))
            result[part] = table.table.evaluate([quantity], θ)[0]
        return result


@dataclass(frozen=True, eq=False)
class _Quantities:
    """What a state is made of, each worked out when it is first read.

    Attributes:
        motion: the motion.
        table: its table.
        times: when.
        ends: whether the motion has ended at some of them.
    """

    motion: SeparatedMotion
    table: DenseOutput
    times: TableTimes
    ends: bool

    @cached_property
    def arguments(self) -> tuple[Reals, Counts, Mask]:
        """Arguments of the table, whole turns, and where the motion has ended."""
        return self.table.argument(self.motion, self.times.elapsed)

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(c.name for c in self.motion.solution.system.coordinates)

    @cached_property
    def angles(self) -> tuple[str, ...]:
        return tuple(c.name for c in self.motion.solution.system.coordinates if c.domain.kind == "angle")

    @property
    def separated(self) -> str:
        return self.motion.solution.coordinates[0]

    @cached_property
    def places(self) -> OnDemand[tuple[Numbers, Counts]]:
        """Coordinates in their principal values, and the whole turns of angles."""
        return OnDemand(self.names, self._place)

    @cached_property
    def q(self) -> OnDemand[Numbers]:
        return OnDemand(self.names, self._position)

    @cached_property
    def p(self) -> OnDemand[Numbers]:
        return OnDemand(self.names, self._momentum)

    @cached_property
    def velocity(self) -> OnDemand[Numbers]:
        return OnDemand(self.names, self._velocity)

    @cached_property
    def sharp(self) -> Mask | None:
        """Where velocities come from distances to the turning points; None where these are not held."""
        return None if self.table.ends is None else badly_rounded(self.motion, self.q, self.p)

    def until_the_end(self, values: Numbers) -> Numbers:
        """Return numbers with nan at times after the end of the motion.

        Args:
            values: of shape (m,).
        """
        return np.where(self.arguments[2], np.nan, values) if self.ends else values

    def _position(self, name: str) -> Numbers:
        if name == self.separated and name not in self.angles:
            value, cycle = self.times.values(self.table, 0), self.motion.located[name].coordinate_motion.cycle
            if cycle is not None and cycle.rotates:
                value = value + cycle.length_of_turns(self.arguments[1], value)
            return self.until_the_end(value)
        return self.places[name][0]

    def _place(self, name: str) -> tuple[Numbers, Counts]:
        motion = self.motion
        value: Numbers
        count: Counts
        if name == self.separated:
            coordinate_motion, whole = motion.located[name].coordinate_motion, self.arguments[1]
            value, count = (
                self.times.values(self.table, 0),
                coordinate_motion.direction * whole if coordinate_motion.rotates else 0 * whole,
            )
        else:
            index, begin = self.table.waves[name]
            wave = self.times.values(self.table, index) - begin
            coordinate = motion.solution.system.coordinate(name)
            gauge = gauge_angle(motion, coordinate.momentum, self.q) if motion.solution.shift_potential != 0 else 0.0
            rate = 0 if motion.torus is None else mean_rate(motion.torus, constant_index(motion, name))
            initial = to_bits(motion.initial.values[coordinate.symbol])
            value, count = grown(initial, rate, self.times.elapsed, None, name in self.angles, wave + gauge)
        value = self.until_the_end(value)
        if name not in self.angles:
            return value, count
        # the oscillation may carry an angle over ±π though its growth was reduced
        value, more = principal_values(value)
        return value, count + more

    def _momentum(self, name: str) -> Numbers:
        shell = {name: self.times.values(self.table, 1)} if name == self.separated else {}
        return self.until_the_end(canonical_momenta(self.motion, self.q, shell, [name])[name])

    def _velocity(self, name: str) -> Numbers:
        motion, sharp = self.motion, self.sharp
        value = evaluate_along(motion, (velocities(motion.solution.system)[name],), self.q, self.p)[0]
        value = self.until_the_end(value)
        if sharp is None or not sharp.any():
            return value
        # only the times next to a pole, where a place in doubles has lost what the velocity depends on
        near = self.table.places(motion, self.arguments[0][sharp])
        return velocities_from_pairs(motion, *near, self.q, {name: value}, sharp)[name]


def _state(found: _Quantities, t: object, shape: tuple[int, ...] | None) -> State:
    def view(source: Mapping[str, Numbers]) -> OnDemand[AtTimes]:
        return OnDemand(found.names, lambda name: shaped(source[name], shape))

    def errors() -> Errors:
        groups = table_errors(
            found.motion, found.table, found.arguments[0], found.q, found.p, found.velocity, found.sharp
        )  # fmt: skip
        return Errors(
            *({n: shaped(found.until_the_end(values), shape) for n, values in group.items()} for group in groups)
        )

    turns = OnDemand(found.angles, lambda name: shaped(whole_numbers(found.places[name][1]), shape))
    if found.ends:
        status = end_statuses(found.motion, found.times.elapsed, found.arguments[2])
    else:
        status = np.broadcast_to(np.array("ok"), (found.times.size,))
    return State(t, view(found.q), view(found.p), view(found.velocity), turns, shaped(status, shape), errors)


def end_statuses(motion: SeparatedMotion, time: tuple[Reals, Reals], ended: Mask) -> NDArray[np.str_]:
    """Return the status of a motion at times.

    Args:
        time: high and low parts of the times relative to t₀, shape (m,).
        ended: where the phases have ended, shape (m,).

    Returns:
        ``ok``; ``reaches_boundary`` past the end of a domain or of all time (infinity in a finite time);
        ``not_converged`` where an unbounded motion is beyond the greatest phase that is integrated. Shape (m,).
    """
    status = np.full(ended.shape, "ok", dtype="<U16")
    for direction in (1, -1):
        chosen = ended & (direction * time[0] > 0)
        if chosen.any():
            # panels reach as far as the latest time asked for, so that an end beyond is not missed
            span = 2 * float(np.max(np.abs(time[0][chosen])))
            status[chosen] = "reaches_boundary" if _ends(motion, direction, span) else "not_converged"
    status[ended & (time[0] == 0)] = "reaches_boundary"
    return status


def _ends(motion: SeparatedMotion, direction: int, span: float) -> bool:
    """Return True where some coordinate has an end in that direction of time."""
    scheme = motion.scheme
    if scheme is None:
        return False
    for i, coordinate_motion in enumerate(scheme.coordinate_motions):
        whole = reaching(coordinate_motion, scheme, span, i)
        if whole.finished(direction) or (
            whole.ends(direction) == "asymptote" and np.isfinite(whole.limits()[direction > 0])
        ):
            return True
    return False
