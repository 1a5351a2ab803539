"""Contact that ends: one-sided constraints, and the instant at which the constraint force of one of them changes sign.

A constraint g(q) ≥ 0 that a motion keeps to, g = 0, pushes along ∂g/∂q with λ ≥ 0 and cannot pull. The motion under it
is that of fewer coordinates Q, and λ(q, q̇) follows from Lagrange's equations (``coordinates.multipliers``). It ends
where λ first passes 0. Without the force g̈ = −a M⁻¹aᵀ λ(q, q̇), a = ∂g/∂q, so that the body moves off while λ goes
on to fall.

λ holds momenta, mostly as squares. Where p² = F(Q; E, …) of the separated coordinates turns it into a function of one
coordinate, its first zeros on both sides of the start are found by exclusion, as turning points are: no zero is stepped
over, and the time follows from t(Q). Elsewhere its sign is followed along the motion, and nothing is proved.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.coordinates.multipliers import constraint_forces
from hjsolve.coordinates.typed_change import short_form
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, InvalidSystemError, NotConvergedError, OutsideMotionError, required
from hjsolve.extended.change_of_frame import ChangeOfFrame
from hjsolve.extended.moving_frame_motion import CarriedOver
from hjsolve.extended.system_under_constraints import Exact, constrained, initial_data_in
from hjsolve.formulas.read import number, parse
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, momenta, velocities
from hjsolve.motion.initial_data import (
    Values,
    clean,
    complete_numbers,
    number_is_zero,
    one_of_velocity_and_p,
    parameter_values,
    sign,
    to_bits,
)
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import rounded
from hjsolve.motion.separated import start_at
from hjsolve.motion.winding import radians_of_a_unit
from hjsolve.one_coordinate.classify import ray
from hjsolve.one_coordinate.coordinate_start import CoordinateStart
from hjsolve.one_coordinate.turning_points import first_end
from hjsolve.precision import one_at_a_time
from hjsolve.scenes.crossing import as_rational, bits_of, surface_crossings
from hjsolve.scenes.lasting_constraints import RationalNumbers, solved_or_found
from hjsolve.solution.quadratures import Solution

_BITS, _BEYOND = 256, 1 + 2.0**-20
"""Bits of places where the search begins; how far beyond a turning point of the motion it goes."""
_GUARD = 10
"""Decimal digits by which the motion is more accurate than what is asked, as of states at events."""
_EXAMPLE = 'contact(system, q={"x": 0, "y": 1}, velocity={"x": 1, "y": 0}, constraints=["x**2 + y**2 >= 1"])'


@dataclass(frozen=True)
class _Typed:
    """A constraint as it was typed: g = left side − right side, and its side: 1 for ≥, −1 for ≤, 0 for =.

    An equation may hold velocities.
    """

    text: str
    equation: str
    g: sp.Expr
    side: int


@dataclass(frozen=True, repr=False)
class Released(Shown):
    """A state where contact ends, rational numbers: coordinate → q and p, parameters, and the time t0."""

    q: dict[str, sp.Expr]
    p: dict[str, sp.Expr]
    parameters: dict[str, sp.Expr]
    t0: sp.Expr


@dataclass(frozen=True, eq=False, repr=False)
class Contact(Shown):
    """A motion under one-sided constraints, and where its contact ends.

    Attributes:
        system: without the constraints.
        constraints: as they were typed.
        multipliers: one-sided constraint → λ in the coordinates and velocities that are left, ≥ 0 while it pushes; its
            force on each coordinate is λ times the slope of the larger side less the smaller one.
        along: one-sided constraint → the same in one coordinate and the constants of the motion, where that is so.
        motion: under all constraints, in the coordinates that are left (``motion.solution.system``).
        ended: the constraints that let go first, at ``time``; none where contact lasts as far as it was looked for.
        time: when; None where contact lasts.
        place: coordinate that is left → its position then.
        q, velocity: position and velocity of each coordinate of ``system`` then.
        proved: whether every earlier zero of the multipliers is excluded; otherwise their signs were sampled along the
            motion.
        released: the state of ``system`` then, exact as it is handed on to the motion that follows; None where contact
            lasts.
        until: the last time that was looked at; None for no limit.
    """

    system: System
    constraints: tuple[str, ...]
    multipliers: Mapping[str, sp.Expr]
    along: Mapping[str, sp.Expr]
    motion: Motion
    ended: tuple[str, ...]
    time: Estimate | None
    place: Mapping[str, Estimate]
    q: Mapping[str, Estimate]
    velocity: Mapping[str, Estimate]
    proved: bool
    released: Released | None
    until: sp.Expr | None = None

    def next_arc(self) -> tuple[System, dict[str, object]]:
        """Return the system in which the other constraints last, and its initial data.

        Returns:
            The system and ``q``, ``velocity`` or ``p``, ``parameters`` and ``t0`` for ``Solution.motion``, with ten
            digits more than the contact was asked for.

        Raises:
            InvalidInputError: contact does not end.
        """
        system, data, t0 = self._handed_on()
        return system, {**data, "t0": t0}

    @property
    def after(self) -> Motion:
        """The motion that follows, from ``time`` on.

        Raises:
            InvalidInputError: contact does not end.
            NotSeparableError: it separates in no coordinates.
        """
        system, data, t0 = self._handed_on()
        return _started(solved_or_found(system), data, t0, self.motion.digits)

    def _handed_on(self) -> tuple[System, dict[str, dict[str, sp.Expr]], sp.Expr]:
        state = self.released
        if state is None:
            raise InvalidInputError("the contact does not end, as far as it was looked for; nothing follows it")
        kept = [_equation(text)[0] for text in self.constraints if text not in self.ended]
        if not kept:
            return self.system, {"q": state.q, "p": state.p, "parameters": state.parameters}, state.t0
        change, symbols = constrained(self.system, kept), self.system.symbols
        at = {symbols[name]: x for name, x in {**state.q, **state.parameters}.items()} | {change.time: state.t0}
        at |= {c.momentum: state.p[c.name] for c in self.system.coordinates}
        short = RationalNumbers(max(self.motion.digits, 15) + _GUARD)
        return change.system, initial_data_in(change, at, short), state.t0


@arguments.with_known_names(_EXAMPLE)
@one_at_a_time
def contact(
    system: System | str | Path, *, q: Mapping[str, object], velocity: Mapping[str, object] | None = None,
    p: Mapping[str, object] | None = None, constraints: Sequence[str], parameters: Mapping[str, object] | None = None,
    t0: object = 0, until: object = None, digits: int = 15,
) -> Contact:  # fmt: skip
    """Find when a body leaves a surface that can push it and cannot pull.

    Args:
        system: in coordinates without the constraints; or the id or file of a catalog entry.
        q: the position at t0, every coordinate; on the constraints.
        velocity: at t0, every coordinate, along the constraints; or
        p: the momenta at t0.
        constraints: ``x**2 + y**2 >= R**2``, the outside of a cylinder; ``<=``, the inside. An equation lasts on both
            sides. At least one must be one-sided.
        parameters: values that differ from the defaults.
        t0: time of the initial data.
        until: the last time of interest; None for no limit.
        digits: relative digits of the time and the motions, float64 up to 15, ``mpf`` above.

    Returns:
        ``Contact``: constraint forces as formulas, the motion, the instant at which the first of them changes sign, and
        the motion after it.

    Raises:
        InvalidInputError: a position off the constraints, a velocity across them, or a constraint that does not push at
            the start.
        InvalidSystemError: a constraint that moves, or that was not solved for a coordinate.
        NotSeparableError: the motion under the constraints does not separate.
        NotConvergedError: a multiplier touches zero, or its zero did not converge to the digits asked.
        MissingValueError: a coordinate or a parameter without a value.

    Example:
        A particle slides down the outside of a circle from rest at 30 degrees from the top. It leaves at 2/3 of its
        height.

        >>> import hjsolve
        >>> ball = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", "m*g*y", {"m": 1, "g": 1})
        >>> top = {"q": {"x": "1/2", "y": "sqrt(3)/2"}, "velocity": {"x": 0, "y": 0}}
        >>> left = contact(ball, **top, constraints=["x**2 + y**2 >= 1"])
        >>> round(left.q["y"].value / 3**0.5 * 3, 12), left.proved
        (1.0, True)

    References:
        Greenwood, Classical Dynamics (1977), (2-48), (5-22)–(5-25); unilateral constraints, Fig. 1-6.
    """
    system = system_of(system, "contact")
    values = parameter_values(system, {} if parameters is None else parameters)
    typed = _read(system, constraints)
    at = _state(system, values, typed, q, velocity, p)
    change = constrained(system, [x.equation for x in typed])
    left = change.system
    if left.time is not None:
        raise InvalidSystemError("contact: the constraints may not move")
    begin, last = number(t0, source="t0"), None if until is None else number(until, source="until")
    data = initial_data_in(change, at | {change.time: begin}, Exact())
    solution, work = solved_or_found(left), max(arguments.whole(digits, "digits"), 15) + _GUARD
    motion, sharp = (_started(solution, data, begin, n) for n in (digits, work))
    found = constraint_forces(left)
    multipliers = {x.text: x.side * λ for x, λ in zip(typed, found.reduced, strict=True) if x.side}
    along, ends = dict[str, sp.Expr](), dict[str, Mpf]()
    for text, λ in multipliers.items():
        _refuse_pull(left, data, text, λ)
        one = _in_one_coordinate(sharp, λ)
        if one is not None:
            along[text] = one
        time = _released(sharp, λ, last) if one is None else _first_zero(sharp, text, one)
        if time is not None and (last is None or time <= to_bits(last)(bits_of(work))):
            ends[text] = time
    answer = _answer(
        change, (typed, multipliers, along), motion, sharp, ends, proved=along.keys() == multipliers.keys()
    )
    return replace(answer, until=last)


# ------------------------------------------------------------------------------------------------ what was typed
def _equation(text: str) -> tuple[str, int]:
    """Return a constraint as an equation, and its side."""
    parts = re.split(r"(>=|<=|≥|≤|=)", text)
    if len(parts) != 3:
        raise InvalidInputError(f'constraints: one equation or inequality is needed, such as "y >= 0", not {text[:60]}')
    return f"{parts[0].strip()} = {parts[2].strip()}", {">": 1, "≥": 1, "<": -1, "≤": -1, "=": 0}[parts[1][0]]


def _read(system: System, constraints: object) -> list[_Typed]:
    given = (constraints,) if isinstance(constraints, str) else constraints
    texts = tuple(given) if isinstance(given, (list, tuple)) else ()
    if not texts or not all(isinstance(x, str) for x in texts):
        raise InvalidInputError('constraints: texts are needed, such as ["x**2 + y**2 >= 1"]')
    found = []
    for n, text in enumerate(texts, 1):
        equation, side = _equation(text)
        speeds = {} if side else {c.name: c.velocity for c in system.coordinates}
        left, right = (
            parse(x, system.symbols, velocities=speeds, source=f"constraints[{n}]") for x in equation.split(" = ")
        )
        found.append(_Typed(text, equation, left - right, side))
    if not any(x.side for x in found):
        raise InvalidInputError("constraints: none is one-sided; write >= or <= where the surface can only push")
    return found


def _state(
    system: System, values: Mapping[sp.Symbol, sp.Expr], typed: Sequence[_Typed], q: Values, velocity: Values | None,
    p: Values | None,
) -> dict[sp.Symbol, sp.Expr]:  # fmt: skip
    """Return the exact state at the start, which satisfies the constraints."""
    what, given = one_of_velocity_and_p(velocity, p)
    places = complete_numbers(system.coordinates, arguments.table(q, "q", _EXAMPLE), "q")
    rates = complete_numbers(system.coordinates, given, what)
    at = dict(values) | {c.symbol: places[c.name] for c in system.coordinates}
    at |= {c.velocity if what == "velocity" else c.momentum: rates[c.name] for c in system.coordinates}
    others = momenta(system) if what == "velocity" else velocities(system)
    at |= {c.momentum if what == "velocity" else c.velocity: clean(others[c.name].subs(at)) for c in system.coordinates}
    for x in typed:
        if not number_is_zero(x.g.subs(at)):
            raise InvalidInputError(
                f'constraints: {x.text} does not hold exactly at the start; give numbers as text, such as "3/5"'
            )
        if x.g.has(*(c.velocity for c in system.coordinates)):
            continue
        speed = sp.Add(*(sp.diff(x.g, c.symbol) * c.velocity for c in system.coordinates))
        if not number_is_zero(speed.subs(at)):
            raise InvalidInputError(
                f"constraints: the velocity is not along {x.text}; hjsolve.impact says what the surface makes of it"
            )
    return at


def _started(solution: Solution, data: Mapping[str, Mapping[str, sp.Expr]], t0: sp.Expr, digits: int) -> Motion:
    return solution.motion(
        q=data["q"], velocity=data.get("velocity"), p=data.get("p"), parameters=data["parameters"], t0=t0, digits=digits
    )


# ------------------------------------------------------------------------------------------------- when it ends
def _refuse_pull(system: System, data: Mapping[str, Mapping[str, sp.Expr]], text: str, λ: sp.Expr) -> None:
    """Refuse a constraint whose force does not push at the start."""
    values = {c.symbol: data["q"][c.name] for c in system.coordinates}
    values |= {c.velocity: data["velocity"][c.name] for c in system.coordinates}
    values |= {p.symbol: data["parameters"][p.name] for p in system.parameters}
    pushed = λ.subs(values)
    if sign(pushed) <= 0:
        raise InvalidInputError(
            f"contact: {text} does not push at the start, its multiplier is {float(pushed):.6g}; the motion there is "
            "that without the constraint"
        )


def _in_one_coordinate(motion: Motion, λ: sp.Expr) -> sp.Expr | None:
    """Return λ in one coordinate and the constants of the motion; None where it is not so."""
    solution = motion.solution
    if solution.chart is not None:
        return None
    system, rates = solution.system, velocities(solution.system)
    f = λ.subs({c.velocity: rates[c.name] for c in system.coordinates}, simultaneous=True)
    for c in system.coordinates:
        if c.name not in solution.coordinates:
            f = f.xreplace({c.momentum: solution.constants[c.momentum.name].symbol})
            continue
        if c.name not in solution.momentum_squared or solution.shift[c.name] != 0:
            return None
        try:
            terms = sp.Poly(sp.expand(f), c.momentum).terms()
        except sp.PolynomialError:
            return None
        if any(n % 2 for (n,), _ in terms):
            return None
        f = sp.Add(*(a * solution.momentum_squared[c.name] ** (n // 2) for (n,), a in terms))
    f = short_form(f, domain_bounds(system.coordinates))
    return f if sum(c.symbol in f.free_symbols for c in system.coordinates) <= 1 else None


def _first_zero(motion: Motion, text: str, f: sp.Expr) -> Mpf | None:
    """Return the time at which λ, a function of one coordinate, first passes zero; proved."""
    solution, digits = motion.solution, motion.digits
    held = next((c for c in solution.system.coordinates if c.symbol in f.free_symbols), None)
    if held is None:
        return None
    start, unit = _begin(motion, held, f)
    times = list[Mpf]()
    for side, turns_at in _sides(motion, held):
        outward = ray(start, side)
        if turns_at is not None and not outward.turns:  # to a little beyond the turning point
            outward = replace(outward, reach=partial(_constant, abs(turns_at - outward.origin(_BITS)) * _BEYOND))
        end = first_end(outward, digits=digits)
        if end.kind in ("round", "infinity", "boundary"):
            continue
        place = required(end.place)(bits_of(digits)) * to_bits(unit)(bits_of(digits))
        if end.kind != "turning" or _at_a_turning_point(motion, held.name, place):
            raise NotConvergedError(
                f"contact: the multiplier of {text} touches zero at {held.name} = {float(place):.12g}; whether contact "
                f"ends there is not decided in {digits} digits"
            )
        try:
            times.append(motion.time_at(held.name, as_rational(place, digits)).value)
        except OutsideMotionError:
            continue
    return min(times, default=None)


def _constant(value: Mpf, _bits: int) -> Mpf:
    return value


def _begin(motion: Motion, held: Coordinate, f: sp.Expr) -> tuple[CoordinateStart, sp.Expr]:
    """Return where the search for zeros of f begins, and the unit of the coordinate: an angle where f repeats."""
    solution, initial, q = motion.solution, motion.initial, held.symbol
    known = {solution.constants[n].symbol: value for n, value in initial.constants.items()}
    known |= {p.symbol: initial.values[p.symbol] for p in solution.system.parameters}
    rate = radians_of_a_unit(f, q, initial.values) if held.domain.kind == "line" else None
    if rate is None:
        return start_at(solution, held.name, f, known, initial.values[q]), sp.S.One
    start = start_at(solution, held.name, f.xreplace({q: q / rate}), known, initial.values[q] * rate)
    return replace(start, angle=True), 1 / rate


def _sides(motion: Motion, held: Coordinate) -> Iterator[tuple[int, Mpf | None]]:
    """Yield the sides on which the motion goes on, each with its turning point; None where there is none."""
    speed = sign(velocities(motion.solution.system)[held.name].subs(motion.initial.values))
    here = to_bits(motion.initial.values[held.symbol])(bits_of(motion.digits))
    lower, upper = (
        None if x is None else here.context.convert(x.value) for x in motion.turning_points.get(held.name, (None, None))
    )
    near = here.context.mpf(10) ** (5 - motion.digits) * (1 + abs(here))
    for side, end, behind in ((-1, lower, upper), (1, upper, lower)):
        starts_there = end is not None and abs(end - here) <= near
        if not starts_there and (speed in (0, side) or behind is not None):
            yield side, end


def _at_a_turning_point(motion: Motion, name: str, place: Mpf) -> bool:
    ends = motion.turning_points.get(name, (None, None))
    tolerance = place.context.mpf(10) ** (5 - motion.digits) * (1 + abs(place))
    return any(x is not None and abs(place - x.value) <= tolerance for x in ends)


def _released(motion: Motion, λ: sp.Expr, last: sp.Expr | None) -> Mpf | None:
    """Return the time of the first change of sign that samples along the motion show."""
    rates = velocities(motion.solution.system_as_given)
    system = motion.solution.system_as_given
    surface = λ.subs({c.velocity: rates[c.name] for c in system.coordinates}, simultaneous=True)
    return next(surface_crossings(motion, surface, last), None)


# ------------------------------------------------------------------------------------------------------ answers
def _answer(
    change: ChangeOfFrame,
    formulas: tuple[Sequence[_Typed], Mapping[str, sp.Expr], Mapping[str, sp.Expr]],
    motion: Motion, sharp: Motion, ends: Mapping[str, Mpf], *, proved: bool,
) -> Contact:  # fmt: skip
    """Put together what was found: the state at the earliest time, carried over to the system without constraints."""
    typed, multipliers, along = formulas
    texts, digits, work = tuple(x.text for x in typed), motion.digits, sharp.digits
    if not ends:
        return Contact(change.original, texts, multipliers, along, motion, (), None, {}, {}, {}, proved, None)
    time = min(ends.values())
    together = time.context.mpf(10) ** (8 - work) * max(1, abs(time))
    ended = tuple(text for text, t in ends.items() if t - time <= together)
    exact = as_rational(time, work)
    state = sharp.at(exact)
    free = CarriedOver(change, sharp.initial.values, work).state(state, exact)
    given = sharp.initial.values
    q, p = ({n: as_rational(x, work) for n, x in group.items()} for group in (free.q, free.p))
    released = Released(q, p, {x.name: given[x.symbol] for x in change.original.parameters}, exact)

    def shown(group: Mapping[str, Mpf]) -> dict[str, Estimate]:
        return {name: rounded(x, digits) for name, x in group.items()}

    place = shown({name: state.unwrapped(name) for name in state.q})
    return Contact(
        change.original, texts, multipliers, along, motion, ended, rounded(time, digits), place, shown(free.q),
        shown(free.velocity), proved, released,
    )  # fmt: skip
