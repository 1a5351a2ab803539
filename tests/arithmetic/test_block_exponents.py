"""Formulas in other units: the same numbers, over powers of two."""

from __future__ import annotations

import math

import mpmath
import pytest
import sympy as sp

from hjsolve.arithmetic.block_exponents import NOTHING, exponent_of, tape_in_units
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.lowering import lower

x, y, k = sp.symbols("x y k", positive=True)
FORMULAS = [
    2 * (y + 3 * k / x) - sp.Rational(1, 7) / x**2,
    sp.sqrt(x**2 + y**2 / k) - sp.pi * x,
    sp.sin(x / y) * k**3 / x,
    (x - y) ** 3 / (x + y),
    sp.exp(-x * k) + sp.log(y),
]


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
@pytest.mark.parametrize("places", [(0, 0, 0), (-301, -296, 300), (413, 417, -409), (-7, -7, 2)])
def test_a_value_in_other_units_is_the_value_over_a_power_of_two(formula: sp.Expr, places: tuple[int, ...]) -> None:
    tape, many = lower([formula], [x, y, k]), Multi(2000)
    values = [many.convert(v) * many.convert(2) ** e for v, e in zip((1.3, 0.71, 1.9), places, strict=True)]
    moved, (exponent,) = tape_in_units(tape, places)
    (truth,) = tape.run(many, values)
    (found,) = moved.run(many, [many.convert(v) for v in (1.3, 0.71, 1.9)])
    assert abs(found * many.convert(2) ** exponent - truth) <= abs(truth) * many.convert(2) ** -1800
    (asked,) = tape_in_units(tape, places, [exponent + 3])[0].run(many, [many.convert(v) for v in (1.3, 0.71, 1.9)])
    assert asked * 8 == found


def test_numbers_that_doubles_do_not_hold_are_of_order_one_in_their_own_units() -> None:
    e = exponent_of(1e-90)
    tape = lower([x**-3 / y**3, x**3 * x**3], [x, y])
    moved, exponents = tape_in_units(tape, (e, exponent_of(1e-20)))
    found = moved.run(Float64(), [math.ldexp(1e-90, -e), math.ldexp(1e-20, -exponent_of(1e-20))])
    for value, exponent, truth in zip(found, exponents, ("1e330", "1e-540"), strict=True):
        assert 1e-3 < abs(value) < 1e3
        assert abs(mpmath.ldexp(mpmath.mpf(float(value)), exponent) / mpmath.mpf(truth) - 1) < 1e-14


def test_zero_has_no_size() -> None:
    assert exponent_of(0.0) == NOTHING
    moved, (exponent,) = tape_in_units(lower([x * y + k], [x, y, k]), (NOTHING, 5, 40))
    assert (moved.run(Float64(), [0.0, 0.5, 0.5])[0], exponent) == (0.5, 40)
