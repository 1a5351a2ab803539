"""Formulas in other units: the same numbers, over powers of two."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import pytest
import sympy as sp

from hjsolve.arithmetic.block_exponents import NOTHING, Results, Unit, exponent_of, tape_in_units
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


def _moved(formulas: list[sp.Expr], places: tuple[int, ...], wanted: list[int] | None = None) -> Results:
    return tape_in_units(lower(formulas, [x, y, k]), [Unit(e) for e in places], wanted)


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
@pytest.mark.parametrize("places", [(0, 0, 0), (-301, -296, 300), (413, 417, -409), (-7, -7, 2), (-90, -3, 0)])
def test_a_value_in_other_units_is_the_value_over_a_power_of_two(formula: sp.Expr, places: tuple[int, ...]) -> None:
    many, given = Multi(2000), (1.3, 0.71, 1.9)
    values = [many.convert(v) * many.convert(2) ** e for v, e in zip(given, places, strict=True)]
    moved, (base,), (exponent,) = _moved([formula], places)
    (truth,) = lower([formula], [x, y, k]).run(many, values)
    (found,) = moved.run(many, [many.convert(v) for v in given])
    assert abs(found * many.convert(2) ** exponent + base - truth) <= abs(truth) * many.convert(2) ** -300
    (asked,) = _moved([formula], places, [exponent + 3]).tape.run(many, [many.convert(v) for v in given])
    assert abs(asked * many.convert(2) ** (exponent + 3) - truth) <= abs(truth) * many.convert(2) ** -300


def test_numbers_that_doubles_do_not_hold_are_of_order_one_in_their_own_units() -> None:
    e, f = exponent_of(1e-90), exponent_of(1e-20)
    moved, _, exponents = _moved([x**-3 / y**3, x**3 * x**3], (e, f, 0))
    found = moved.run(Float64(), [math.ldexp(1e-90, -e), math.ldexp(1e-20, -f), 1.0])
    for value, exponent, truth in zip(found, exponents, ("1e330", "1e-540"), strict=True):
        assert 1e-3 < abs(value) < 1e3
        assert abs(mpmath.ldexp(mpmath.mpf(float(value)), exponent) / mpmath.mpf(truth) - 1) < 1e-14


SMALL = [
    1 / (1 + sp.sqrt(1 + x**2)), sp.exp(-(x**2)), sp.log(1 + x**2), sp.cos(x), sp.cosh(x), (2 + x) ** 3, sp.sin(1 + x),
    sp.cos(2 + x), sp.sinh(1 + x), sp.sqrt(3 + x) ** -3, sp.log(sp.cos(x)), x / (2 - x), sp.exp(1 + x) / (5 + x**2),
    sp.sin(x) - x, sp.tan(x), sp.atan(x) * y, sp.tanh(x), sp.asinh(x) + sp.atanh(x), sp.sqrt(sp.exp(x) + 3) + sp.pi, abs(x - 2),
]  # fmt: skip


@pytest.mark.parametrize("formula", SMALL, ids=str)
@pytest.mark.parametrize("e", [-40, -300])
def test_what_a_value_differs_by_from_a_number_has_all_its_digits(formula: sp.Expr, e: int) -> None:
    many = Multi(4000)
    moved, (base,), (exponent,) = _moved([formula], (e, 0, 0))
    here, there = (lower([formula], [x, y, k]).run(many, [many.convert(v), 1, 1])[0] for v in (0, 1.3 * 2.0**e))
    truth = (there - here) / many.convert(2) ** exponent
    (found,) = moved.run(Float64(), [1.3, 1.0, 1.0])
    assert abs(base - here) <= many.convert(2) ** -3000
    # of sin x - x only the first term is known beforehand to cancel, and that is no number
    assert abs(many.convert(float(found)) - truth) <= 1e-14 * (1 if formula == sp.sin(x) - x else abs(truth))


def test_zero_has_no_size_and_parameters_are_numbers() -> None:
    assert exponent_of(0.0) == NOTHING
    moved, _, (exponent,) = _moved([x * y + k], (NOTHING, 5, 40))
    assert (moved.run(Float64(), [0.0, 0.5, 0.5])[0], exponent) == (0.5, 40)
    third = Fraction(1, 3)
    inputs = [Unit(-60), Unit(), Unit(value=third)]
    moved, (base,), (exponent,) = tape_in_units(lower([sp.sqrt(k + x)], [x, y, k]), inputs)
    assert float(base) == math.sqrt(third)
    found = moved.run(Float64(), [0.7, 1.0, math.ldexp(1 / 3, -exponent_of(1 / 3))])[0]
    assert abs(math.ldexp(found, exponent) * 2 * math.sqrt(third) / math.ldexp(0.7, -60) - 1) < 1e-14
