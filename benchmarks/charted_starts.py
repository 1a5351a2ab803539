"""Starts for benchmarks/charts.py: anywhere in a box, and those that random numbers never hit.

The second kind are starts with some of X, Y, Z and of their velocities exactly 0: on planes and axes, at rest, without
angular momentum; by turns those of the user's frame and those of the web's, where foci, axes and segments lie.
"""

from __future__ import annotations

import random
import time
from collections.abc import Sequence
from functools import cache

import mpmath
import sympy as sp

import hjsolve
from benchmarks.charted_systems import SMALL, centre_of, system_named

Start = dict[str, dict[str, str]]
_ZERO = 0.45
"""How often a number is 0."""
_DRAWS, _DIGITS, _HUGE = 200, 30, 1e12


@cache
def solved(name: str) -> tuple[hjsolve.Solution, float]:
    """Return the solution of a system, and the seconds it took."""
    begin = time.process_time()
    solution = hjsolve.solve(system_named(name), coordinates="find")
    return solution, time.process_time() - begin


def anywhere(name: str, index: int, seed: int) -> Start:
    """Return the index-th random start of a system."""
    dice, size = random.Random(f"{name} {index} {seed}"), SMALL.get(name, 1.0)
    names = [c.name for c in system_named(name).coordinates]
    return {
        "q": {c: f"{dice.uniform(-size, size) + o:.3f}" for c, o in zip(names, centre_of(name), strict=False)},
        "velocity": {c: f"{dice.uniform(-0.8, 0.8) * size:.3f}" for c in names},
    }


def with_zeros(name: str, index: int, seed: int) -> Start | None:
    """Return the index-th start with zeros at which V is finite; None where none was found."""
    dice, size, system = random.Random(f"{name} {index} {seed} zeros"), SMALL.get(name, 1.0), system_named(name)
    names, chart = [c.name for c in system.coordinates], solved(name)[0].chart
    for _ in range(_DRAWS):
        place, speed = ([_number(dice, size * scale) for _ in names] for scale in (1.0, 0.8))
        if all(place) and all(speed):
            continue
        if chart is None or index % 2 or chart.kind == "normal modes":
            x, v = sp.Matrix(place) + sp.Matrix(centre_of(name)[: len(names)]), sp.Matrix(speed)
        else:
            x, v = sp.Matrix(chart.origin) + chart.frame * sp.Matrix(place), chart.frame * sp.Matrix(speed)
        if finite(name, list(x)):
            return {key: dict(zip(names, map(str, row), strict=True)) for key, row in (("q", x), ("velocity", v))}
    return None


def _number(dice: random.Random, size: float) -> sp.Rational:
    return sp.S.Zero if dice.random() < _ZERO else sp.Rational(dice.randint(-100, 100), 100) * sp.nsimplify(size)


def finite(name: str, at: Sequence[sp.Expr]) -> bool:
    """Whether V is a finite real number at a place."""
    system = system_named(name)
    value = system.potential.subs({c.symbol: a for c, a in zip(system.coordinates, at, strict=True)})
    try:
        number = complex(sp.N(value, _DIGITS))
    except (TypeError, ValueError, ZeroDivisionError):
        return False
    return abs(number) < _HUGE and abs(number.imag) < 1 / _HUGE


@cache
def without_wall(name: str) -> tuple[bool, ...]:
    """For every coordinate, whether V is finite all over the plane through the middle of the starts across it.

    "All over" are eight random places; a potential that is infinite in a plane is so at each of them.
    """
    dice, middle = random.Random(name), centre_of(name)[: len(system_named(name).coordinates)]

    def place(k: int) -> list[sp.Expr]:
        return [sp.sympify(o) if i == k else o + sp.Rational(dice.randint(1, 99), 101) * dice.choice((-1, 1))
                for i, o in enumerate(middle)]  # fmt: skip

    return tuple(all(finite(name, place(k)) for _ in range(8)) for k in range(len(middle)))


def value_of(text: str) -> mpmath.mpf:
    """Return a number of a start, to 45 digits."""
    number = sp.N(sp.sympify(text, rational=True), 45)
    return mpmath.mpf(str(number))
