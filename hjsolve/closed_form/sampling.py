"""Samples of motions: places and momenta drawn at random, and the exact constants they have."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter
from hjsolve.motion.rational_values import rational_value
from hjsolve.precision import mp
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True)
class Sample:
    """One motion: exact values.

    Attributes:
        values: symbol → value, of every parameter and every constant.
        places: separated coordinate → where the motion is.
    """

    values: Mapping[sp.Symbol, sp.Expr]
    places: Mapping[str, sp.Expr]


def samples(
    solution: Solution, count: int, seed: int, fixed: Mapping[sp.Symbol, sp.Expr] | None = None
) -> Iterator[Sample]:
    """Draw motions: the first half with the default parameters, the others with random ones.

    Args:
        solution: what is solved.
        count: how many places are tried.
        seed: of the random numbers.
        fixed: constants that are functions of the others: constant → what it is.
    """
    system, draw = solution.system, random.Random(seed)  # noqa: S311
    for turn in range(count):
        parameters = {p.symbol: _parameter(p, draw, own=turn % 2 == 0) for p in system.parameters}
        phase = dict(parameters)
        drawn = {c: _place(c, parameters, draw) for c in system.coordinates}
        if any(place is None for place in drawn.values()):
            continue
        for c, place in drawn.items():
            phase[c.symbol] = place
            phase[c.momentum] = sp.Rational(draw.choice((-1, 1)) * draw.randint(1, 60), draw.choice((6, 20, 60)))
        values = dict(parameters)
        for constant in solution.constants.values():
            exact = rational_value(constant.expression, phase)
            values[constant.symbol] = near(constant.expression.xreplace(phase)) if exact is None else exact
        if not all(value.is_Rational for value in values.values()):
            continue
        for symbol, expression in (fixed or {}).items():
            values[symbol] = near(expression.xreplace(values))
        places = {name: phase[system.coordinate(name).symbol] for name in solution.coordinates}
        if _moves(solution, values, places):
            yield Sample(values, places)


def _moves(solution: Solution, values: Mapping[sp.Symbol, sp.Expr], places: Mapping[str, sp.Expr]) -> bool:
    """Return whether every squared momentum is positive."""
    where = {solution.system.coordinate(name).symbol: place for name, place in places.items()}
    numbers = many_digits({**values, **where}, 30)
    with mp.workdps(30):
        squares = [number_of(solution.momentum_squared[name], numbers) for name in places]
    return all(not isinstance(square, mp.mpc) and square > 0 for square in squares)


def near(value: sp.Expr) -> sp.Expr:
    """Return a rational number within 1e-9 of a number; itself where it is one; nan where it is not real."""
    if value.is_Rational:
        return value
    number = sp.N(value, 12)
    return sp.Rational(str(number)) if number.is_real and number.is_finite else sp.nan


def _parameter(parameter: Parameter, draw: random.Random, *, own: bool) -> sp.Expr:
    if own and parameter.value is not None:
        return near(parameter.value)
    size = sp.Rational(draw.randint(5, 40), 20)
    default = sp.S.One if parameter.value is None else parameter.value
    if parameter.value is not None and default != 0:
        return near(default * size)
    return -size if parameter.assume == "negative" else size


def _place(coordinate: Coordinate, parameters: Mapping[sp.Symbol, sp.Expr], draw: random.Random) -> sp.Expr | None:
    """Return a place of the domain; None where these parameters leave none."""
    domain, part = coordinate.domain, sp.Rational(draw.randint(1, 99), 100)
    if domain.kind == "angle":
        return near((2 * part - 1) * sp.pi)
    low = None if domain.lower is None else domain.lower.xreplace(dict(parameters))
    high = None if domain.upper is None else domain.upper.xreplace(dict(parameters))
    if any(end is not None and not sp.N(end).is_real for end in (low, high)):
        return None
    if low is None and high is None:
        return sp.Rational(draw.randint(-80, 80), draw.choice((20, 40)))
    if low is not None and high is not None:
        return near(low + (high - low) * part)
    away = sp.Rational(draw.randint(1, 120), draw.choice((20, 40, 60)))
    return near(low + away) if low is not None else near(high - away)
