"""Motions of any H(q, p) of one degree of freedom that come back: period, action, turning points, states.

The curve H = E is followed branch by branch (``one_coordinate.level_curve``); the formulas are in
``hjsolve.extended.linear_hamiltonian``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import BoundTape
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.extended.one_freedom import Beginning, NonlinearInMomentum
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import InBits, complete_numbers, number_is_zero, to_bits, values_of
from hjsolve.motion.shapes import state_of_one
from hjsolve.motion.state import State
from hjsolve.motion.times import whole_numbers
from hjsolve.one_coordinate.level_curve import Curve, Orbit, followed

_FLOAT_DIGITS, _GUARDS, _SPARE = 15, (96, 192, 384, 768), 64


@dataclass(frozen=True, eq=False, repr=False)
class LevelMotion(Shown):
    """A motion of a general H(q, p).

    Attributes:
        problem: the Hamiltonian.
        digits: asked for.
        kinds: name → ``libration``, ``rotation`` or ``equilibrium``.
        constants: E.
        turning_points: name → (least, greatest) q of a libration.
        actions: name → J = (1/2π) ∮ p dq along the motion; signed like its direction for a rotation.
        periods, frequencies: name → T and 2π/T; none where it rests.
        q, p, t0: exact initial data.
        orbit: the curve H = E once round; None where it rests.
        rates: H_q, H_p and their derivatives along the motion, at the precision worked in.
    """

    problem: NonlinearInMomentum
    digits: int
    kinds: Mapping[str, str]
    constants: Mapping[str, Estimate]
    turning_points: Mapping[str, tuple[Estimate, Estimate]]
    actions: Mapping[str, Estimate]
    periods: Mapping[str, Estimate]
    frequencies: Mapping[str, Estimate]
    q: sp.Expr
    p: sp.Expr
    t0: sp.Expr
    orbit: Orbit | None
    rates: BoundTape

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times.

        Args:
            t: a time or an array of times.

        Raises:
            InvalidInputError: times that are no numbers, or more than 2**60 periods away.
        """
        return state_of_one(self.problem.coordinate, t, self._state)

    def _state(self, t: sp.Expr) -> tuple[object, ...]:
        """(q, p, q̇, their errors, status, turns)."""
        bits = self.rates.arithmetic.bits  # type: ignore[attr-defined]
        context = multiprecision(bits)
        q, p, turns, uncertainty = to_bits(self.q)(bits), to_bits(self.p)(bits), 0, context.zero
        if self.orbit is not None:
            T = self.orbit.period
            elapsed = to_bits(t - self.t0)(bits + 64)
            whole = int(whole_numbers(np.array([context.floor(elapsed / T)], dtype=object))[0])
            q, p = self.orbit.at(elapsed - whole * T)
            q += 2 * context.pi * whole * self.orbit.turns
            uncertainty = (abs(whole) + 1) * (self.orbit.period_error + abs(T) * context.mpf(2) ** (_SPARE - bits))
        if self.problem.coordinate.domain.kind == "angle":
            turns = int(context.ceil((q - context.pi) / (2 * context.pi)))
            q -= 2 * context.pi * turns
        falls, rate, *second = self.rates.run(q, p)
        errors = self._errors(uncertainty, (rate, falls, *second), context.mpf(2) ** (_SPARE - bits))
        if self.digits > _FLOAT_DIGITS:
            small = context.mpf(10) ** -self.digits
            bounds = [e + small * abs(x) for e, x in zip(errors, (q, p, rate), strict=True)]
            return q, p, rate, *bounds, "ok", turns
        plain = [float(x) for x in (q, p, rate)]
        return *plain, *(float(e) + EPS * abs(x) for e, x in zip(errors, plain, strict=True)), "ok", turns

    def _errors(self, uncertainty: Mpf, slopes: tuple[Mpf, ...], spacing: Mpf) -> tuple[Mpf, Mpf, Mpf]:
        """Return the errors of q, p and q̇ from that of time, to second order, and from the rounding of the curve."""
        if self.orbit is None:
            return uncertainty, uncertainty, uncertainty
        rate, falls, more, bend = (abs(slope) for slope in slopes)
        T, (wide, high) = self.orbit.period, self.orbit.extents
        return (
            2 * (rate + bend * uncertainty) * uncertainty + spacing * wide,
            2 * (falls + more * uncertainty) * uncertainty + spacing * high,
            2 * bend * uncertainty + spacing * (rate + bend * T + wide / T),
        )


def start_on_level(problem: NonlinearInMomentum, begin: Beginning) -> LevelMotion:
    """Start a motion; see ``StartedByMomenta.motion``."""
    q, p, parameters, t0, _ = begin
    coordinate, digits = problem.coordinate, arguments.digits(begin.digits)
    name = coordinate.name
    places, momenta = complete_numbers([coordinate], q, "q"), complete_numbers([coordinate], p, "p")
    values = values_of(problem.parameters, arguments.table(parameters, "parameters"))
    place, momentum = places[name], momenta[name]
    domain = coordinate.domain
    at = {**values, coordinate.symbol: place, coordinate.momentum: momentum}
    E = problem.hamiltonian.xreplace(at)
    if not E.is_finite or not E.is_real:
        raise InvalidInputError("initial data: H is not a real number there")
    slopes = [sp.diff(problem.hamiltonian, s) for s in (coordinate.symbol, coordinate.momentum)]
    start, rests = number(t0, source="t0"), all(number_is_zero(slope.xreplace(at)) for slope in slopes)
    curve = _curve(problem, slopes, values, E, (place, momentum), digits)
    bits, rates = curve.bits, _rates(problem, slopes, values, curve.bits)
    point = to_bits(place)(bits), to_bits(momentum)(bits)
    ends = [None if end is None else to_bits(end.xreplace(values))(bits) for end in (domain.lower, domain.upper)]
    if any(end is not None and side * (point[0] - end) <= 0 for end, side in zip(ends, (1, -1), strict=True)):
        raise InvalidInputError(f"q.{name}: {place} is not inside the domain of {name}")
    orbit = None
    if not rests:
        orbit = followed(curve, *point, (ends[0], ends[1]), angle=coordinate.domain.kind == "angle")
    kinds, constants, turning, actions, periods, frequencies = _numbers(name, orbit, to_bits(E)(bits), digits, bits)
    return LevelMotion(
        problem, digits, kinds, constants, turning, actions, periods, frequencies, place, momentum, start, orbit, rates
    )


def _curve(
    problem: NonlinearInMomentum, slopes: list[sp.Expr], values: Mapping[sp.Symbol, sp.Expr], E: sp.Expr,
    point: tuple[sp.Expr, sp.Expr], digits: int,
) -> Curve:  # fmt: skip
    """H = E, in enough binary digits for what cancels in H."""
    pair, known = (problem.coordinate.symbol, problem.coordinate.momentum), [to_bits(v) for v in values.values()]
    tape, energy = lower([problem.hamiltonian, *slopes], [*pair, *values]), to_bits(E)
    for guard in _GUARDS:
        curve = Curve(tape, partial(_in_bits, known), energy, digits, bits_for(digits, guard))
        x, y = (to_bits(v)(curve.bits) for v in point)
        h, along, across = curve.at(0, x, y)
        size = abs(x * along) + abs(y * across) or abs(along) + abs(across)
        if abs(h) <= size * multiprecision(64).mpf(2) ** (24 - curve.bits) or not size:
            return curve
    raise NotConvergedError("the terms of H cancel at the start beyond what any precision tried makes up for")


def _in_bits(known: list[InBits], bits: int) -> list[Mpf]:
    return [value(bits) for value in known]


def _rates(
    problem: NonlinearInMomentum, slopes: list[sp.Expr], values: Mapping[sp.Symbol, sp.Expr], bits: int
) -> BoundTape:
    """H_q, H_p, and their derivatives along the motion."""
    q, p = problem.coordinate.symbol, problem.coordinate.momentum
    second = [sp.diff(f, q) * slopes[1] - sp.diff(f, p) * slopes[0] for f in slopes]
    tape = lower([*slopes, *second], [q, p, *values])
    return tape.bind(Multi(bits), [to_bits(v)(bits) for v in values.values()])


def _numbers(name: str, orbit: Orbit | None, E: Mpf, digits: int, bits: int) -> tuple[Mapping[str, Any], ...]:
    """Kinds, constants, turning points, actions, periods and frequencies."""
    context = multiprecision(bits)

    def estimate(value: Mpf | int, error: Mpf | float = 0) -> Estimate:
        if digits > _FLOAT_DIGITS:
            return Estimate(value, error + abs(value) * context.mpf(10) ** -digits, nodes=nodes)
        return Estimate(float(value), float(error) + abs(float(value)) * EPS, nodes=nodes)

    nodes = 0 if orbit is None else sum(piece.nodes for piece in orbit.pieces)
    energy = {"E": estimate(E)}
    if orbit is None:
        return {name: "equilibrium"}, energy, {}, {name: estimate(context.zero)}, {}, {}
    T, off = orbit.period, orbit.period_error
    J, rounding_error = orbit.action
    small = context.mpf(2) ** (_SPARE - bits)
    turns = {}
    if orbit.ends is not None:
        low, high = orbit.ends
        turns = {name: (estimate(low, small * (high - low)), estimate(high, small * (high - low)))}
    rate = 2 * context.pi / T
    return (
        {name: "rotation" if orbit.turns else "libration"}, energy, turns,
        {name: estimate(J * (orbit.turns or 1), rounding_error)}, {name: estimate(T, off)},
        {name: estimate(rate, 2 * rate * off / T)},
    )  # fmt: skip
