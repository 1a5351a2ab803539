"""Motions of H = a(q) p + b(q): ∫ dq/a = t − t₀ by quadrature, inverted by Newton's method; p from H = E.

Where a(q) vanishes at the start q rests and p follows its own linear equation. The formulas are in
``hjsolve.extended.linear_hamiltonian``. Digits are carried well beyond those asked, so the error stated covers the
quadrature, the inversion and the rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.arithmetic.root_finding import newton
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, NotConvergedError, OutsideMotionError
from hjsolve.extended.one_freedom import Beginning, LinearInMomentum
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import complete_numbers, to_bits, values_of
from hjsolve.motion.shapes import state_of_one
from hjsolve.motion.state import State

_FLOAT_DIGITS, _GUARD_BITS, _LOST_BITS = 15, 96, 48
_MOST_STEPS, _FIRST_STEPS = 2000, 64
"""Steps at most, and after which it is asked whether they will do; in each q or dq/dt changes by a factor."""
_MOST_HALVINGS = 8192

Sizes = tuple[Mpf, Mpf, Mpf]
"""What the roundings of q, p and dq/dt are relative to."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearMotion(Shown):
    """A motion of H = a(q) p + b(q).

    Attributes:
        problem: the Hamiltonian.
        kinds: ``escape``: q moves in one direction for ever; ``equilibrium`` where a(q) vanishes at the start.
        constants: E.
        digits: asked for.
        q, p, t0: exact initial data.
        values: parameter → exact value.
    """

    problem: LinearInMomentum
    kinds: Mapping[str, str]
    constants: Mapping[str, Estimate]
    digits: int
    q: sp.Expr
    p: sp.Expr
    t0: sp.Expr
    values: Mapping[sp.Symbol, sp.Expr]

    def at(self, t: object) -> State:
        """Return the state at a time or at an array of times; NaN where the motion has left its domain.

        Args:
            t: a time or an array of times.
        """
        return state_of_one(self.problem.coordinate, t, self._state)

    def reach(self, t: object) -> tuple[float | Mpf, float | Mpf]:
        """Return (q, p) at one time, angles with all their turns.

        Args:
            t: one time.

        Raises:
            OutsideMotionError: the motion does not come so far.
        """
        bits = bits_for(self.digits, _GUARD_BITS)
        place, p, _, _ = self._reached(number(t, source="t"), bits, multiprecision(bits))
        return (place, p) if self.digits > _FLOAT_DIGITS else (float(place), float(p))

    def _state(self, t: sp.Expr) -> tuple[object, ...]:
        """(q, p, q̇, their errors, status, turns)."""
        bits = bits_for(self.digits, _GUARD_BITS)
        context = multiprecision(bits)
        try:
            place, p, v, sizes = self._reached(t, bits, context)
        except OutsideMotionError:
            lost = context.nan if self.digits > _FLOAT_DIGITS else float("nan")
            return *[lost] * 6, "reaches_boundary", 0
        turns = 0
        if self.problem.coordinate.domain.kind == "angle":
            turns = int(context.ceil((place - context.pi) / (2 * context.pi)))
            place -= 2 * context.pi * turns
        small = context.mpf(2) ** (_LOST_BITS - bits)
        if self.digits > _FLOAT_DIGITS:
            return place, p, v, *(small * size for size in sizes), "ok", turns
        errors = (float(small * s) + EPS * abs(float(x)) for s, x in zip(sizes, (place, p, v), strict=True))
        return float(place), float(p), float(v), *errors, "ok", turns

    def _reached(self, t: sp.Expr, bits: int, context: Context) -> tuple[Mpf, Mpf, Mpf, Sizes]:
        """q, p, q̇ and the sizes of what was added up in them."""
        problem, name = self.problem, self.problem.coordinate.name
        start, first, elapsed = (to_bits(x)(bits) for x in (self.q, self.p, t - self.t0))
        tape = lower([problem.rate, problem.rest], [problem.coordinate.symbol, *self.values])
        numbers = [to_bits(value)(bits) for value in self.values.values()]

        def run(x: Mpf) -> list[Mpf]:
            return tape.run(Multi(bits), [x, *numbers])

        a0, b0 = run(start)
        if not a0:
            return start, *self._at_rest(start, first, elapsed, bits, context)
        ends = _Ends.of(problem, self.values, bits)
        place = _moved(lambda x: run(x)[0], start, elapsed, context, name, ends)
        a, b = run(place)
        momentum = (a0 * first + b0 - b) / a
        sizes = (1 + abs(place), 1 + (abs(a0 * first) + abs(b0) + abs(b)) / abs(a), 1 + abs(a))
        return place, momentum, a, sizes

    def _at_rest(self, start: Mpf, first: Mpf, elapsed: Mpf, bits: int, context: Context) -> tuple[Mpf, Mpf, Sizes]:
        """q̇ = a(q) = 0: q rests, while ṗ = −a′p − b′ with constant a′, b′."""
        q = self.problem.coordinate.symbol
        slopes = [sp.diff(f, q) for f in (self.problem.rate, self.problem.rest)]
        tape = lower(slopes, [q, *self.values])
        k, c = tape.run(Multi(bits), [start, *(to_bits(value)(bits) for value in self.values.values())])
        shrunk = -context.expm1(-k * elapsed) / k if k else elapsed
        p = first - (k * first + c) * shrunk
        sizes = (1 + abs(start), 1 + abs(first) + (abs(k * first) + abs(c)) * abs(shrunk), context.mpf(1))
        return p, context.mpf(0), sizes


@dataclass(frozen=True)
class _Ends:
    lower: Mpf | None
    upper: Mpf | None

    @classmethod
    def of(cls, problem: LinearInMomentum, values: Mapping[sp.Symbol, sp.Expr], bits: int) -> _Ends:
        coordinate = problem.coordinate
        domain = coordinate.domain
        pair = (None, None) if domain.kind == "angle" else (domain.lower, domain.upper)
        return cls(*(None if end is None else to_bits(end.xreplace(dict(values)))(bits) for end in pair))

    def hold(self, place: Mpf) -> bool:
        return (self.lower is None or place > self.lower) and (self.upper is None or place < self.upper)


def start_linear_motion(problem: LinearInMomentum, begin: Beginning) -> LinearMotion:
    """Start a motion; see ``StartedByMomenta.motion``."""
    q, p, parameters, t0, _ = begin
    name, digits = problem.coordinate.name, arguments.digits(begin.digits)
    places, momenta = (complete_numbers([problem.coordinate], group, what) for what, group in (("q", q), ("p", p)))
    values = values_of(problem.parameters, parameters)
    place, momentum = places[name], momenta[name]
    bits = bits_for(digits, _GUARD_BITS)
    if not _Ends.of(problem, values, bits).hold(to_bits(place)(bits)):
        raise InvalidInputError(f"q.{name}: {place} is not inside the domain of {name}")
    at = {**values, problem.coordinate.symbol: place, problem.coordinate.momentum: momentum}
    energy = to_bits(problem.hamiltonian.xreplace(at))(bits)
    rests = not to_bits(problem.rate.xreplace(at))(bits)
    if digits <= _FLOAT_DIGITS:
        E = Estimate(float(energy), EPS * (1 + abs(float(energy))))
    else:
        E = Estimate(energy, energy.context.mpf(2) ** (_LOST_BITS - bits) * (1 + abs(energy)))
    kinds = {name: "equilibrium" if rests else "escape"}
    return LinearMotion(problem, kinds, {"E": E}, digits, place, momentum, number(t0, source="t0"), values)


def _moved(rate: Callable[[Mpf], Mpf], start: Mpf, elapsed: Mpf, context: Context, name: str, domain: _Ends) -> Mpf:
    """Solve ∫ dq/a = elapsed by Newton's method: the derivative of the left side is 1/a itself."""
    place, left, before, longest = start, elapsed, context.inf, context.inf
    for count in range(_MOST_STEPS):
        if not left:
            return place
        longest = _longest(rate, place, 1 if left > 0 else -1, 4 * longest)
        if count % _FIRST_STEPS == 0:
            if 0.9 * before < longest < 1.1 * before and abs(left) > _MOST_STEPS * longest:
                break
            before = longest
        far = abs(place) > 2**30 and longest < abs(left) / 2**20
        if far and _longest(rate, 2 * place, 1, longest) < 0.999 * longest:
            raise OutsideMotionError(f"{name} reaches infinity in a finite time")
        step = left if abs(left) <= longest else (longest if left > 0 else -longest)
        place, left = _step(rate, place, step, context, name), left - step
        if not domain.hold(place):
            raise OutsideMotionError(f"{name} reaches an end of its domain")
    raise NotConvergedError(
        f"{name}: until that time it grows, or approaches an equilibrium, by too many orders of magnitude; choose a "
        "time closer to t0"
    )


def _longest(rate: Callable[[Mpf], Mpf], place: Mpf, direction: int, most: Mpf) -> Mpf:
    """Return a time, at most ``most``, in which 1 + |q| and dq/dt at most double or halve, judged at its end."""
    here = rate(place)
    if not here:
        return abs(place) * 0
    longest = min((1 + abs(place)) / abs(here) / 2, most)
    for _ in range(_MOST_HALVINGS):
        if 0.5 <= rate(place + direction * longest * here) / here <= 2:
            break
        longest /= 2
    return longest


def _step(rate: Callable[[Mpf], Mpf], place: Mpf, step: Mpf, context: Context, name: str) -> Mpf:
    def off(q: Mpf) -> Mpf:
        return (context.quad(lambda x: 1 / rate(x), [place, q]) - step) * rate(q)

    close = context.mpf(2) ** (24 - context.prec) * abs(step)
    found = newton(off, place + rate(place) * step, lambda q: close * abs(rate(q)), 60)
    if found is None:
        raise OutsideMotionError(f"{name} approaches a zero of a(q) and never reaches it")
    return found
