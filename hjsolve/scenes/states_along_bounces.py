"""The states along many bounces at once: every coordinate is read from one free motion, at a time of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Integers, Mpf, Numbers, Reals
from hjsolve.mechanics.system import hamiltonian
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.positions import coordinate_velocities, evaluate_along, principal_values
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.state import Errors, State
from hjsolve.motion.state_errors import velocity_errors
from hjsolve.scenes.reflections import Flight, Free
from hjsolve.time_law.elapsed_time import halves


@dataclass(frozen=True, eq=False)
class Along:
    """Times on the flights of one free motion.

    Attributes:
        free: the free motion in many digits.
        motion: the same to the digits of the scene, started at t₀ = 0.
        flights: the arcs.
        which: the arc of each time, shape (m,).
        times: as given.
        elapsed: since the arc began.
    """

    free: Free
    motion: Motion
    flights: Sequence[Flight]
    which: Integers
    times: Numbers
    elapsed: Any

    @property
    def many(self) -> bool:
        """Whether numbers are of more digits than doubles."""
        return self.motion.digits > FLOAT_DIGITS

    def gather(self, pick: Callable[[Flight], Mpf | int]) -> tuple[Numbers, Numbers | int]:
        """Return a number of every flight at the times, as a high part and what is left.

        Args:
            pick: gives the number of one flight, in many digits.

        Returns:
            Shape (m,) each.
        """
        numbers = [pick(flight) for flight in self.flights]
        if self.many:
            return np.array(numbers, dtype=object)[self.which], 0
        high = np.array([float(x) for x in numbers])
        low = np.array([float(x - h) for x, h in zip(numbers, high, strict=True)])
        return high[self.which], low[self.which]

    def floats(self, pick: Callable[[Flight], Mpf | int]) -> Reals:
        """Return a number of every flight at the times, rounded.

        Args:
            pick: gives the number of one flight, in many digits.

        Returns:
            Doubles, shape (m,).
        """
        return np.array([float(pick(flight)) for flight in self.flights])[self.which]


def along(free: Free, motion: Motion, flights: Sequence[Flight], which: Integers, times: Numbers) -> State:
    """Work out the states at times on the flights of a free motion.

    Args:
        free: the free motion in many digits, which the flights are of.
        motion: the same to the digits of the scene, started at t₀ = 0.
        flights: the arcs.
        which: the arc of each time, shape (m,).
        times: float array of shape (m,), or exact numbers above 15 digits.

    Returns:
        The states; angles in (−π, π], with all their whole turns.
    """
    here = Along(free, motion, flights, which, times, None)
    begin, rest = here.gather(lambda f: f.begin)
    if here.many:
        elapsed = np.array([to_bits(t)(free.context.prec) for t in times], dtype=object) - begin
    else:
        high, low = (times, 0.0) if times.dtype == float else halves([to_bits(t)(free.context.prec) for t in times])
        elapsed = (high - begin) + (low - rest)
    here = Along(free, motion, flights, which, times, elapsed)
    clocks = {name: _clock(here, k) for k, name in enumerate(free.separated)}
    free_states = {name: motion.at(clock) for name, clock in clocks.items()}
    q, p, turns = _places(here, free_states)
    velocity = coordinate_velocities(motion.separated, q, p)
    status = np.full(len(which), "ok", dtype="<U16")
    for state in free_states.values():
        status = np.where(state.status == "ok", status, state.status)

    def errors() -> Errors:
        return _errors(here, clocks, free_states, q, p, velocity)

    return State(times, q, p, velocity, turns, status, errors)


def _clock(here: Along, k: int) -> Numbers:
    """Return times of the free motion for one separated coordinate."""
    high, low = here.gather(lambda f: f.clocks[k])
    sign = np.array([f.signs[k] for f in here.flights])[here.which]
    return high + (sign * here.elapsed + low)


def _places(here: Along, states: dict[str, State]) -> tuple[dict[str, Numbers], dict[str, Numbers], dict[str, Numbers]]:
    """Positions, momenta, whole turns."""
    free, system = here.free, here.motion.solution.system
    q: dict[str, Numbers] = {}
    p: dict[str, Numbers] = {}
    turns: dict[str, Numbers] = {}
    signs = {name: np.array([f.signs[k] for f in here.flights])[here.which]
             for k, name in enumerate((*free.separated, *free.ignorable))}  # fmt: skip
    for name in free.separated:
        q[name], p[name] = states[name].q[name], signs[name] * states[name].p[name]
        if name in states[name].turns:
            turns[name] = states[name].turns[name]
    for j, name in enumerate(free.ignorable):
        angle, turn = system.coordinate(name).domain.kind == "angle", 2 * free.context.pi
        whole = np.zeros(len(here.which), dtype=int)
        if angle:
            each = [int(free.context.nint(f.places[j] / turn)) for f in here.flights]
            whole = np.array(each, dtype=int)[here.which]
            rests = dict(zip(map(id, here.flights), each, strict=True))
            high, low = here.gather(lambda f, j=j, rests=rests, turn=turn: f.places[j] - turn * rests[id(f)])  # type: ignore[misc]
        else:
            high, low = here.gather(lambda f, j=j: f.places[j])  # type: ignore[misc]
        if name in free.carrier:
            carrier = free.carrier[name]
            side = signs[name] * signs[carrier]
            grown = side * states[carrier].q[name]
            if angle:
                whole = whole + side * states[carrier].turns[name]
        else:
            rate = free.rates[name]
            grown = signs[name] * (rate if here.many else float(rate)) * here.elapsed
        q[name] = high + (grown + low)
        if angle:
            q[name], more = principal_values(q[name])
            turns[name] = whole + more.astype(int)
        constant = to_bits(here.motion.initial.values[system.coordinate(name).momentum])(free.context.prec)
        p[name] = signs[name] * (constant if here.many else float(constant)) + 0 * q[name]
    names = [c.name for c in system.coordinates]
    return {k: q[k] for k in names}, {k: p[k] for k in names}, {k: turns[k] for k in names if k in turns}


def _errors(
    here: Along,
    clocks: Mapping[str, Numbers],
    states: dict[str, State],
    q: Mapping[str, Numbers],
    p: Mapping[str, Numbers],
    velocity: Mapping[str, Numbers],
) -> Errors:
    """Return those of the free motion; what the clocks and places are in doubt; the rounding of their sums."""
    free, system = here.free, here.motion.solution.system
    unit = EPS if not here.many else float(multiprecision(64).mpf(10) ** (1 - here.motion.digits))
    uncertainty, place_rounding = here.floats(lambda f: f.uncertainty), here.floats(lambda f: f.place_rounding)
    elapsed = np.abs(here.elapsed.astype(float))
    H = hamiltonian(system)
    forces = evaluate_along(here.motion.separated, tuple(-sp.diff(H, c.symbol) for c in system.coordinates), q, p)
    force = dict(zip(q, (np.abs(np.asarray(f, dtype=float)) for f in forces), strict=True))
    speed = {name: np.abs(np.asarray(v, dtype=float)) for name, v in velocity.items()}
    late = {name: uncertainty + unit * (elapsed + np.abs(clock.astype(float))) for name, clock in clocks.items()}
    dq: dict[str, Numbers] = {}
    dp: dict[str, Numbers] = {}
    for name in free.separated:
        error = states[name].error
        dq[name] = np.asarray(error.q[name], dtype=float) + speed[name] * late[name]
        dp[name] = np.asarray(error.p[name], dtype=float) + force[name] * late[name]
    for j, name in enumerate(free.ignorable):
        size = np.abs(q[name].astype(float)) + here.floats(lambda f, j=j: abs(f.places[j]))  # type: ignore[misc]
        if system.coordinate(name).domain.kind == "angle":
            size = np.full(len(here.which), 3 * np.pi)
        dq[name] = place_rounding + 4 * unit * size
        if name in free.carrier:
            carrier = free.carrier[name]
            dq[name] = dq[name] + np.asarray(states[carrier].error.q[name], dtype=float) + speed[name] * late[carrier]
        else:
            dq[name] = dq[name] + speed[name] * (uncertainty + 4 * unit * elapsed)
        dp[name] = unit * np.abs(p[name].astype(float))
    names = list(q)
    dq, dp = {k: dq[k] for k in names}, {k: dp[k] for k in names}
    return Errors(dq, dp, velocity_errors(here.motion.separated, q, p, dq, dp, unit))
