"""Bounces that change only signs: one free motion serves them all, however many there are.

Between two bounces every coordinate is where the free motion has it at a time of its own (its clock), forwards or
backwards (``reflecting_walls``). At a wall the clock of the coordinate that hits it stops and runs the other way; the
others go on. So a bounce costs a few sums: when the free motion passes a wall is worked out once for all (``passes``).
An ignorable coordinate φ carried by k is φ = c + σ d φ°(τₖ): φ° of the free motion at the clock τₖ that runs in the
direction d, σ the sign of pᵩ, c changed at each bounce such that φ does not jump. Every sum adds what it leaves open to
``uncertainty`` and ``place_rounding``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy as sp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import required
from hjsolve.mechanics.system import velocities
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.positions import constant_index
from hjsolve.scenes.crossing import bits_of
from hjsolve.scenes.events import Event, Pending
from hjsolve.scenes.passage_times import Carried, Passes, passes
from hjsolve.scenes.reflecting_walls import Mirrors
from hjsolve.time_law.torus import mean_rate

Candidate = tuple[Mpf, Pending, Callable[["Now"], None]]


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """One arc of a bouncing motion, by the free motion it is part of.

    Attributes:
        begin: its time.
        uncertainty: a bound on the error of that and of the clocks.
        clocks: of the separated coordinates: times of the free motion.
        places: of the ignorable coordinates at ``begin``; the offset c for one that is carried.
        place_rounding: a bound on their error.
        signs: of the clocks' directions, then of the ignorable momenta, against the free motion.
    """

    begin: Mpf
    uncertainty: Mpf | int
    clocks: tuple[Mpf, ...]
    places: tuple[Mpf, ...]
    place_rounding: Mpf | int
    signs: tuple[int, ...]


@dataclass
class Now:
    """Where the walk along a bouncing motion is; names as in ``Flight``, by coordinate."""

    time: Mpf
    clock: dict[str, Mpf]
    place: dict[str, Mpf]
    sign: dict[str, int]
    uncertainty: Mpf | int = 0
    place_rounding: Mpf | int = 0
    landed: dict[str, Any] = field(default_factory=dict)

    def flight(self) -> Flight:
        """Freeze it."""
        signs = (*(self.sign[n] for n in self.clock), *(self.sign[n] for n in self.place))
        clocks, places = tuple(self.clock.values()), tuple(self.place.values())
        return Flight(self.time, self.uncertainty, clocks, places, self.place_rounding, signs)


class Free:
    """A free motion, and when it passes the places that events stand at.

    In its methods ``now`` is where the walk is; it is changed.

    Args:
        motion: with many digits, started at t₀ = 0.
        mirrors: what may be turned round.
    """

    def __init__(self, motion: Motion, mirrors: Mirrors):
        self.motion, self.mirrors = motion, mirrors
        self.context = multiprecision(bits_of(motion.digits))
        self.unit = self.context.mpf(10) ** (2 - motion.digits)
        self.separated = tuple(motion.solution.coordinates)
        self.ignorable = tuple(n for n in mirrors.carrier)
        self._passes: dict[tuple[str, sp.Expr], Passes] = {}
        self._angles: dict[tuple[str, Passes, int], Mpf] = {}

    def __reduce__(self) -> tuple[type[Free], tuple[Motion, Mirrors]]:
        return Free, (self.motion, self.mirrors)

    @cached_property
    def carrier(self) -> dict[str, str]:
        """Ignorable coordinate → the one that carries it, where that does not rest."""
        located = self.motion.separated.located
        pairs = ((n, c) for n, c in self.mirrors.carrier.items() if c is not None)
        return {name: c for name, c in pairs if not located[c].coordinate_motion.rests}

    @cached_property
    def rates(self) -> dict[str, Mpf]:
        """The constant rates of ignorable coordinates."""
        found, motion = {}, self.motion
        for name in self.ignorable:
            if name in self.carrier:
                continue
            torus = motion.separated.torus
            if self.mirrors.carrier[name] is not None and torus is not None:
                found[name] = self.context.convert(mean_rate(torus, constant_index(motion.separated, name)))
            else:
                value = velocities(motion.solution.system)[name].xreplace(dict(motion.initial.values))
                found[name] = self.context.convert(to_bits(value)(self.context.prec))
        return found

    @cached_property
    def carried(self) -> dict[str, Carried]:
        """Ignorable coordinates that walls may stand at, as functions of their carriers' phases."""
        if self.motion.separated.torus is None:
            return {}
        bounded = {
            n: c
            for n, c in self.carrier.items()
            if self.motion.separated.located[c].coordinate_motion.cycle is not None
        }
        return {name: Carried(self.motion, name, c) for name, c in bounded.items()}

    def serves(self, events: Sequence[Event]) -> bool:
        """Tell whether the clocks never end and every place that events stand at can be looked up.

        Args:
            events: all that may happen.
        """
        if any(e.surface is not None for e in events):
            return False
        for place in self.motion.separated.located.values():
            if any(place.coordinate_motion.ends(side) in {"boundary", "fall"} for side in (1, -1)):
                return False
        placed = {e.coordinate for e in events if e.coordinate in self.carrier}
        return all(name in self.carried and self.carried[name].monotone for name in placed)

    def passes(self, name: str, value: sp.Expr) -> Passes:
        """Return when the free motion has a separated coordinate at a place; looked up the second time.

        Args:
            value: the place, exact.
        """
        key = (name, value)
        if key not in self._passes:
            self._passes[key] = passes(self.motion, name, value)
        return self._passes[key]

    def angle(self, name: str, clock: Mpf) -> Mpf:
        """Return a carried coordinate of the free motion at a clock, in radians with its whole turns.

        Args:
            clock: time of the free motion.
        """
        return self.context.convert(self.motion.at(clock).unwrapped(name))

    def angle_landed(self, name: str, landed: tuple[Passes, int, int]) -> Mpf:
        """Return the same at a passage; the state is looked up the second time.

        Args:
            landed: the passages of its carrier, which of them, and whole turns to be added.
        """
        found, index, turns = landed
        key = (name, found, index)
        if key not in self._angles:
            self._angles[key] = self.angle(name, found.times[index])
        return self._angles[key] + (turns * self.turn(name) if turns else 0)

    def start(self, time: Mpf) -> Now:
        """Return the beginning: all clocks at zero."""
        values, system = self.motion.initial.values, self.motion.solution.system
        zero = self.context.mpf(0)
        place = {
            n: zero if n in self.carrier else self.context.convert(
                to_bits(values[system.coordinate(n).symbol])(self.context.prec)) for n in self.ignorable
        }  # fmt: skip
        sign = dict.fromkeys((*self.separated, *self.ignorable), 1)
        return Now(self.context.convert(time), dict.fromkeys(self.separated, zero), place, sign)

    def back(self, flight: Flight) -> Now:
        """Return the beginning of a flight."""
        clock = dict(zip(self.separated, flight.clocks, strict=True))
        place = dict(zip(self.ignorable, flight.places, strict=True))
        sign = dict(zip((*self.separated, *self.ignorable), flight.signs, strict=True))
        return Now(flight.begin, clock, place, sign, flight.uncertainty, flight.place_rounding)

    # ------------------------------------------------------------------------------------------ what comes next
    def candidate(self, now: Now, pending: Pending, tolerance: Mpf) -> Candidate | None:
        """Find when an event at a place is next met, and how to be exactly there.

        Args:
            now: where the walk is.
            pending: the event, and how many passages it still lets by.
            tolerance: times closer than this to now do not count.
        """
        name, value = required(pending.event.coordinate), required(pending.event.value)
        if name in now.clock:
            return self._own(now, pending, name, value, tolerance)
        target = self.context.convert(to_bits(value)(self.context.prec))
        turn = 2 * self.context.pi if self.motion.solution.system.coordinate(name).domain.kind == "angle" else None
        return (self._uniform if name in self.rates else self._carried)(now, pending, name, target, turn, tolerance)

    def _own(self, now: Now, pending: Pending, name: str, value: sp.Expr, tolerance: Mpf) -> Candidate | None:
        found = self.passes(name, value)
        hit = found.beside(now.clock[name], now.sign[name], tolerance)
        if hit is None:
            return None
        there, index, turns = hit

        def land(now: Now) -> None:
            now.clock[name], now.landed[name] = there, (found, index, turns)
            now.uncertainty += 2 * (1 + abs(turns)) * found.error

        return now.time + abs(there - now.clock[name]), pending, land

    def _uniform(
        self, now: Now, pending: Pending, name: str, target: Mpf, turn: Mpf | None, tolerance: Mpf
    ) -> Candidate | None:
        rate = now.sign[name] * self.rates[name]
        if not rate:
            return None
        distance = (target - now.place[name]) / rate
        if turn is not None:
            each = turn / abs(rate)
            distance -= each * self.context.floor((distance - tolerance) / each)
        elif distance <= tolerance:
            return None
        there = now.place[name] + distance * rate if turn is not None else target

        def land(now: Now) -> None:
            now.place[name] = there
            now.uncertainty += self.unit * distance

        return now.time + distance, pending, land

    def _carried(
        self, now: Now, pending: Pending, name: str, target: Mpf, turn: Mpf | None, tolerance: Mpf
    ) -> Candidate | None:
        carried, carrier = self.carried[name], self.carrier[name]
        side = now.sign[name] * now.sign[carrier]
        offset, clock = now.place[name], now.clock[carrier]
        ahead = now.sign[name] * (1 if carried.turn > 0 else -1)
        here = offset + side * carried.near(clock)
        if turn is None:
            goals = [target]
        else:
            first = target + turn * ahead * self.context.ceil(ahead * (here - target) / turn - 0.01)
            goals = [first, first + ahead * turn]
        for goal in goals:
            if now.landed.get(name) == goal:
                continue
            there, error = carried.time(side * (goal - offset))
            if now.sign[carrier] * (there - clock) > tolerance:
                break
        else:
            return None

        def land(now: Now) -> None:
            if carrier not in now.landed:
                now.clock[carrier] = there
            now.uncertainty += error
            now.place_rounding += self.unit * abs(goal)
            now.landed[name] = goal

        return now.time + abs(there - clock), pending, land

    # ------------------------------------------------------------------------------------------ what happens
    def advance(self, now: Now, time: Mpf) -> None:
        """Let all clocks run until a time.

        Args:
            time: of the scene, later than now.
        """
        step = time - now.time
        for name in now.clock:
            now.clock[name] += now.sign[name] * step
        for name, rate in self.rates.items():
            now.place[name] += now.sign[name] * rate * step
        now.time, now.landed = time, {}
        now.uncertainty += self.unit * abs(step)

    def reflect(self, now: Now, name: str) -> None:
        """Turn a coordinate round where it stands, after ``advance`` and its landing."""
        if name in now.clock:
            for other, carrier in self.carrier.items():
                if carrier == name:
                    angle = self.angle_landed(other, now.landed[name])
                    now.place[other] += 2 * now.sign[other] * now.sign[name] * angle
                    now.place_rounding += 4 * self.unit * (1 + abs(angle))
        elif name in self.carrier:
            now.place[name] = 2 * now.landed[name] - now.place[name]
        now.sign[name] = -now.sign[name]

    def reduce(self, now: Now) -> None:
        """Take whole periods from the clocks of librations, so that many of them cost no digits."""
        for name, clock in now.clock.items():
            period = self.motion.periods.get(name) if self.motion.kinds[name] == "libration" else None
            turns = 0 if period is None else int(self.context.nint(clock / period.value))
            if period is None or not turns:
                continue
            now.clock[name] -= turns * period.value
            now.uncertainty += abs(turns) * period.error
            for other, carrier in self.carrier.items():
                if carrier == name:
                    now.place[other] += now.sign[other] * now.sign[name] * turns * self.turn(other)

    def turn(self, name: str) -> Mpf:
        """Return what a carried coordinate gains in a period of the one that carries it."""
        coordinate_motion = required(self.motion.separated.located[self.carrier[name]].coordinate_motion.cycle)
        return (
            -2
            * self.context.pi
            * self.context.convert(coordinate_motion.growth(constant_index(self.motion.separated, name)))
        )

    def state(self, now: Now) -> tuple[dict[str, sp.Expr | Mpf], dict[str, sp.Expr | Mpf], dict[str, int]]:
        """Positions, angles in (−π, π]; momenta; turns of the angles. Exact where constant, else in many digits."""
        q: dict[str, sp.Expr | Mpf] = {}
        p: dict[str, sp.Expr | Mpf] = {}
        turns: dict[str, int] = {}
        values, system = self.motion.initial.values, self.motion.solution.system
        for name in self.separated:
            c = system.coordinate(name)
            q[name], p[name] = values[c.symbol], values[c.momentum]
            if not self.motion.separated.located[name].coordinate_motion.rests:
                state = self.motion.at(now.clock[name])
                q[name], p[name] = state.q[name], now.sign[name] * state.p[name]
                if name in state.turns:
                    turns[name] = int(state.turns[name])
        for name in self.ignorable:
            p[name] = now.sign[name] * values[system.coordinate(name).momentum]
            q[name] = now.place[name]
            if name in self.carrier:
                carrier = self.carrier[name]
                q[name] += now.sign[name] * now.sign[carrier] * self.angle(name, now.clock[carrier])
        for c in system.coordinates:
            if c.domain.kind == "angle" and c.name not in turns:
                turns[c.name] = 0
                if not isinstance(q[c.name], sp.Expr):
                    pi = self.context.pi
                    turns[c.name] = int(self.context.ceil((q[c.name] - pi) / (2 * pi)))
                    q[c.name] -= 2 * pi * turns[c.name]
        return q, p, turns


def signed(free: Free, signs: Sequence[int]) -> Mapping[str, int]:
    """Return the signs of a flight by coordinate, those that change no number of a motion left at 1."""
    names = (*free.separated, *free.ignorable)
    kinds = free.motion.kinds
    return {n: 1 if kinds[n] in ("libration", "equilibrium") else s for n, s in zip(names, signs, strict=True)}
