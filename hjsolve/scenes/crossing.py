"""When a coordinate passes a surface, to all digits asked: from t(q) or by walking, then Newton's method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Mpf, Reals
from hjsolve.arithmetic.root_finding import bisected, newton
from hjsolve.errors import NotConvergedError, OutsideMotionError, required
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.mechanics.system import hamiltonian, velocities
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import State

_CHUNK, _LONGEST_WALK = 512, 400


def bits_of(digits: int) -> int:
    """Binary digits for decimal ones, with some to spare."""
    return bits_for(digits, 32)


def crossings(motion: Motion, name: str, value: sp.Expr, horizon: sp.Expr | None, skip: int = 0) -> Iterator[Mpf]:
    """Give the times at which a coordinate passes a value after the start, one after the other.

    A passage at the very start does not count: that is where the last event happened. A surface that the motion only
    touches is passed by no sign change and is left out by a coordinate that has to be walked along.

    Args:
        motion: at least as many digits as the times shall have.
        name: of the coordinate.
        value: the surface, exact; an angle passes it once a turn.
        horizon: the last time of interest; None for no limit.
        skip: leave out so many; where t(q) is known nothing is computed for them.

    Yields:
        Times as ``mpf``.
    """
    start = to_bits(motion.t0)(bits_of(motion.digits))
    tolerance = multiprecision(64).mpf(10) ** (8 - motion.digits) * max(1, abs(start))
    if name in motion.separated.located:
        first = next(_known(motion, name, value, 0), None)
        at_start = first is not None and first[0] - start <= tolerance
        approximate, skip = _known(motion, name, value, skip + at_start), 0
    else:
        approximate = _walked(motion, name, value, horizon)
    for guess, error in approximate:
        time = guess if error < tolerance / 1000 else sharpened(motion, name, value, guess)
        if horizon is not None and time > to_bits(horizon)(bits_of(motion.digits)):
            return
        if time - start > tolerance:
            if not skip:
                yield time
            skip = max(skip - 1, 0)


def _known(motion: Motion, name: str, value: sp.Expr, passage: int) -> Iterator[tuple[Mpf, Mpf]]:
    """From t(q), passage by passage, beginning with one of them."""
    while True:
        try:
            time = motion.time_at(name, value, passage)
        except OutsideMotionError:
            return
        yield multiprecision(bits_of(motion.digits)).convert(time.value), abs(time.error)
        passage += 1


def _walked(motion: Motion, name: str, value: sp.Expr, horizon: sp.Expr | None) -> Iterator[tuple[Mpf, Mpf]]:
    """From changes of sign along the motion; an ignorable coordinate need not be monotone."""
    quick = motion.solution.motion(**restart(motion), digits=15, want={"trajectory"})
    turning = motion.solution.system.coordinate(name).domain.kind == "angle"
    target, start = float(to_bits(value)(64)), float(to_bits(motion.t0)(64))
    context = multiprecision(bits_of(motion.digits))

    def level(times: Reals) -> Reals:
        off = quick.at(times).unwrapped(name) - target
        return np.floor(off / (2 * np.pi)) if turning else (off >= 0).astype(float)

    for times in _weighted_rates(quick, start, None if horizon is None else float(to_bits(horizon)(64))):
        levels = level(times)
        for k in np.nonzero(np.diff(levels))[0]:
            yield context.convert(float(_halved(level, times[k], times[k + 1], levels[k]))), context.mpf(1)
        if np.isnan(quick.at(float(times[-1])).q[name]):
            return


def surface_crossings(motion: Motion, surface: sp.Expr, horizon: sp.Expr | None) -> Iterator[Mpf]:
    """Give the times at which a motion passes the surface g(q, p) = 0 after the start, one after the other.

    Args:
        motion: at least as many digits as the times shall have.
        surface: g, of coordinates, momenta and parameters.
        horizon: the last time of interest; None for no limit.

    Yields:
        Times as ``mpf``.
    """
    if motion.solution.chart is None:
        quick = motion.solution.motion(**restart(motion), digits=15, want={"trajectory"})
    else:  # started in the coordinates that the system was given in
        quick = required(motion.again)(15, {"want": {"trajectory"}})
    function = _OnSurface(motion, surface)
    start, context = to_bits(motion.t0)(bits_of(motion.digits)), multiprecision(bits_of(motion.digits))
    tolerance = context.mpf(10) ** (8 - motion.digits) * max(1, abs(start))

    def level(times: Reals) -> Reals:
        return (function.level(quick.at(times)) >= 0).astype(float)

    for times in _weighted_rates(quick, float(start), None if horizon is None else float(to_bits(horizon)(64))):
        levels = level(times)
        for k in np.nonzero(np.diff(levels))[0]:
            guess = context.convert(float(_halved(level, times[k], times[k + 1], levels[k])))
            time = function.sharpened(guess)
            if horizon is not None and time > to_bits(horizon)(bits_of(motion.digits)):
                return
            if time - start > tolerance:
                yield time
        if not np.isfinite(function.level(quick.at(np.array([times[-1]])))).all():
            return


class _OnSurface:
    """g(q, p) along a motion, in doubles and in all its digits; ġ = ∂g/∂q ∂H/∂p − ∂g/∂p ∂H/∂q.

    Args:
        motion: in the coordinates of g.
        surface: g.
    """

    def __init__(self, motion: Motion, surface: sp.Expr):
        system = motion.solution.system_as_given
        H, rates, held = hamiltonian(system), velocities(system), surface.free_symbols
        slopes = {c.symbol: rates[c.name] for c in system.coordinates}
        slopes |= {c.momentum: -sp.diff(H, c.symbol) for c in system.coordinates if c.momentum in held}
        speed = sp.Add(*(sp.diff(surface, s) * f for s, f in slopes.items()))
        self._names = [c.name for c in system.coordinates]
        self._motion = motion
        variables = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
        fixed = {p.symbol: motion.initial.values[p.symbol] for p in system.parameters}
        self._value, self._speed = (lower([f.xreplace(fixed)], variables) for f in (surface, speed))

    def level(self, state: State) -> Reals:
        """Return g in doubles."""
        places = [np.asarray(x, dtype=float) for x in self._state(state)]
        with np.errstate(all="ignore"):
            return np.broadcast_to(self._value.run(Float64(), places)[0], places[0].shape)

    def _state(self, state: State) -> list[AtTimes]:
        return [*(state.unwrapped(name) for name in self._names), *(state.p[name] for name in self._names)]

    def sharpened(self, time: Mpf) -> Mpf:
        """Newton's method on g(q(t), p(t)) = 0, the state from the motion in all its digits."""
        digits = self._motion.digits
        bits = bits_of(digits)
        context = multiprecision(bits)

        def step(time: Mpf) -> Mpf | None:
            places = [context.convert(x) for x in self._state(self._motion.at(time))]
            speed = self._speed.run(Multi(bits), places)[0]
            return self._value.run(Multi(bits), places)[0] / speed if speed else None

        return _passed(step, time, digits, "the motion touches the surface and does not pass it")


def _weighted_rates(motion: Motion, start: float, horizon: float | None) -> Iterator[Reals]:
    """Yield times close enough to see every passage, in pieces that share their ends."""
    rates = [abs(float(f.value)) for f in motion.frequencies.values()]
    if rates:
        step = 0.04 / max(rates)
        for n in range(_LONGEST_WALK):
            first = start + n * _CHUNK * step
            if horizon is not None and first > horizon:
                return
            yield first + step * np.arange(_CHUNK + 1.0)
    elif horizon is not None:
        yield start + (horizon - start) * np.arange(4 * _CHUNK + 1) / (4 * _CHUNK)
        return
    else:
        yield start + np.concatenate([[0.0], 1e-3 * 1.02 ** np.arange(3000)])
    raise NotConvergedError(
        "no passage was found in the time searched; say when to stop, by times of a scene or until of a contact"
    )


def _halved(level: Callable[[Reals], Reals], low: float, high: float, before: float) -> float:
    """Bisect until Newton's method will do."""
    low, high = bisected(lambda x: bool(level(np.array([x]))[0] == before), low, high, 24)
    return (low + high) / 2


def sharpened(motion: Motion, name: str, value: sp.Expr, time: Mpf) -> Mpf:
    """Newton's method on q(t) = value, q from the motion in all its digits.

    Args:
        motion: the free motion of the arc.
        name: coordinate.
        value: position; for an angle modulo 2π.
        time: near the crossing.

    Returns:
        The time of the crossing, to the digits of the motion.

    Raises:
        NotConvergedError: the coordinate touches the value and does not pass it.
    """
    bits = bits_of(motion.digits)
    context = multiprecision(bits)
    target, turn = to_bits(value)(bits), 2 * context.pi
    turning = motion.solution.system.coordinate(name).domain.kind == "angle"

    def step(time: Mpf) -> Mpf | None:
        state = motion.at(time)
        off = context.convert(state.q[name]) - target
        off -= turn * context.nint(off / turn) if turning else 0
        speed = context.convert(state.velocity[name])
        return off / speed if speed else None

    return _passed(step, time, motion.digits, f"{name} touches {float(target):.12g} and does not pass")


def _passed(step: Callable[[Mpf], Mpf | None], time: Mpf, digits: int, touched: str) -> Mpf:
    """Return the time of a passage to the digits of the motion, by Newton's method from nearby."""
    goal = multiprecision(bits_of(digits)).mpf(10) ** (5 - digits)
    found = newton(step, time, lambda t: goal * max(1, abs(t)), 12, rough=1000)
    if found is None:
        raise NotConvergedError(f"{touched}; the event has no definite time")
    return found


def restart(motion: Motion) -> dict[str, Any]:
    """Return the arguments that start the same motion again.

    Returns:
        Keywords of ``Solution.motion``.
    """
    system, values = motion.solution.system, motion.initial.values
    return {
        "q": {c.name: values[c.symbol] for c in system.coordinates},
        "p": {c.name: values[c.momentum] for c in system.coordinates},
        "parameters": {p.name: values[p.symbol] for p in system.parameters},
        "t0": motion.t0,
    }


def as_rational(value: float | Mpf, digits: int) -> sp.Expr:
    """Return an ``mpf``, rounded to so many digits, as the rational number it is.

    Args:
        value: mpmath's number.
        digits: decimal digits to round it to.
    """
    return number(multiprecision(bits_of(digits)).mpf(value) * 1, source="state")
