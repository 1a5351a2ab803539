"""An Estimate is a number: whatever is computed with it, its error bounds the true one."""

from __future__ import annotations

import operator
import pickle
import random
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve import Estimate, HJSolveError, InvalidInputError
from hjsolve.arithmetic.floats import multiprecision

MANY = multiprecision(2600)
"""The arithmetic of the truth: enough digits that doubles of any size are added exactly."""
BINARY = {
    "+": (operator.add, MANY.fadd), "-": (operator.sub, MANY.fsub), "*": (operator.mul, MANY.fmul),
    "/": (operator.truediv, MANY.fdiv), "hypot": (np.hypot, lambda x, y: MANY.sqrt(x * x + y * y)),
    "atan2": (np.arctan2, MANY.atan2), "max": (np.maximum, max), "min": (np.minimum, min),
    "%": (operator.mod, lambda x, y: x - y * MANY.floor(x / y)),
}  # fmt: skip
NAMES = {
    "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh",
    "absolute": "fabs", "rad2deg": "degrees", "deg2rad": "radians", "log2": "", "log10": "", "cbrt": "", "square": "",
    "reciprocal": "", "negative": "",
}  # fmt: skip
OWN = {
    "log2": lambda x: MANY.log(x) / MANY.log(2), "log10": lambda x: MANY.log(x) / MANY.log(10), "square": lambda x: x * x,
    "cbrt": lambda x: MANY.sign(x) * MANY.cbrt(abs(x)), "reciprocal": lambda x: 1 / x, "negative": lambda x: -x,
}  # fmt: skip
ONE = sorted({
    "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "sinh", "cosh", "tanh", *NAMES,
})  # fmt: skip


def truth(name: str, x: mpmath.mpf) -> mpmath.mpf:
    return OWN[name](x) if name in OWN else getattr(MANY, NAMES.get(name) or name)(x)


def drawn(source: random.Random, many: bool = False, wide: float = 20.0) -> tuple[Estimate, mpmath.mpf]:
    """An estimate of any size and doubt, and a true number within it, often at its ends."""
    size = source.choice([0, 1, 1, 1, wide])
    value = source.choice([-1, 1]) * source.uniform(0.5, 9) * 10.0 ** source.uniform(-size, size)
    error = source.choice([0.0, abs(value) * 10.0 ** source.uniform(-18, 0.5), 10.0 ** source.uniform(-18, 0)])
    if many:
        c = multiprecision(200)
        value, error = c.mpf(value) / 3, c.mpf(error) * c.mpf(10) ** source.choice([-40, -20, 0])
    place = source.choice([-1, 1, 0, source.uniform(-1, 1)])
    return Estimate(value, error), MANY.convert(value) + MANY.convert(place) * MANY.convert(error)


def inside(result: Estimate, true: mpmath.mpf) -> bool:
    return bool(abs(MANY.convert(result.value) - true) <= MANY.convert(result.error) + abs(true) * MANY.mpf(2) ** -2500)


@pytest.mark.parametrize("many", [False, True])
@pytest.mark.parametrize("name", sorted(BINARY))
def test_the_error_of_an_operation_bounds_the_true_one(name: str, many: bool) -> None:
    source, answered = random.Random(f"{name}{many}"), 0
    ours, exact = BINARY[name]
    for _ in range(400):
        (a, x), (b, y) = drawn(source, many), drawn(source, many and source.random() < 0.5)
        try:
            result = ours(a, b)
        except InvalidInputError:
            continue
        answered += 1
        assert inside(result, exact(x, y)), (a, b, result)
    assert answered > 100


@pytest.mark.rotating(3)
@pytest.mark.parametrize("name", ONE)
def test_the_error_of_a_function_bounds_the_true_one(name: str) -> None:
    source, answered = random.Random(name), 0
    for i in range(300):
        e, x = drawn(source, many=i % 4 == 0, wide=2.3 if name in {"exp", "sinh", "cosh", "expm1", "tanh"} else 9)
        if name in {"arcsin", "arccos", "arctanh"} and source.random() < 0.7:
            e, x = e / 10, x / 10
        try:
            result = getattr(np, name)(e)
        except InvalidInputError:
            continue
        true = truth(name, x)
        if isinstance(true, MANY.mpc) or not MANY.isfinite(true):
            continue  # the true number is not where the function is real
        answered += 1
        assert inside(result, true), (e, x, result)
    assert answered > 60


@pytest.mark.parametrize("exponent", [2, 3, -1, -2, 7, 0, 0.5, 2.5, -0.3, Fraction(1, 3), None])
def test_the_error_of_a_power_bounds_the_true_one(exponent: float | None) -> None:
    source, answered = random.Random(str(exponent)), 0
    for i in range(200):
        (a, x), (b, y) = drawn(source, many=i % 4 == 0, wide=5), drawn(source, wide=1)
        if exponent is not None:
            b, y = (
                exponent,
                MANY.mpf(exponent.numerator) / exponent.denominator
                if isinstance(exponent, Fraction)
                else MANY.convert(exponent),
            )
        try:
            result = a**b
        except InvalidInputError:
            continue
        true = MANY.power(x, y)
        if isinstance(true, MANY.mpc):
            continue
        answered += 1
        assert inside(result, true), (a, b, result)
    assert answered > 50


def test_the_error_is_no_larger_than_its_first_order_and_a_rounding() -> None:
    source = random.Random(1)
    for _ in range(300):
        value, error = source.uniform(0.3, 1.2), 10.0 ** source.uniform(-14, -9)
        e = Estimate(value, error)
        for name, slope in (
            ("sin", np.cos(value)),
            ("log", 1 / value),
            ("sqrt", 0.5 / np.sqrt(value)),
            ("exp", np.exp(value)),
        ):
            result = getattr(np, name)(e)
            assert result.error <= 1.0001 * slope * error + abs(result.value) * 2.0**-53 + 1e2 * error**2


CORRELATED = {
    "x - x": lambda x: x - x, "x / x": lambda x: x / x, "x * x - 2 * x": lambda x: x * x - 2 * x,
    "x**3 - x * x * x": lambda x: x**3 - x * x * x, "1 / (1 + x * x) - x": lambda x: 1 / (1 + x * x) - x,
}  # fmt: skip


@pytest.mark.parametrize("name", CORRELATED)
def test_operands_may_depend_on_each_other(name: str) -> None:
    source, answered = random.Random(name), 0
    for i in range(200):
        e, x = drawn(source, many=i % 3 == 0, wide=3)
        try:
            result = CORRELATED[name](e)
        except InvalidInputError:
            continue
        answered += 1
        assert inside(result, CORRELATED[name](x)), (e, x, result)
    assert answered > 80


def test_where_there_is_no_bound_it_is_said() -> None:
    for broken in (
        lambda: 1 / Estimate(1e-17, 1e-16), lambda: Estimate(1.0, 0.1) / 0, lambda: np.sqrt(Estimate(-1.0, 0.5)),
        lambda: np.log(Estimate(1e-3, 1e-2)), lambda: np.tan(Estimate(1.5, 0.2)), lambda: Estimate(-2.0, 0.1) ** 0.5,
        lambda: np.arctan2(Estimate(0.0, 0.1), -1), lambda: Estimate(2.99, 0.1) % 3, lambda: Estimate(1.0, 0.0).agrees("1"),
    ):  # fmt: skip
        with pytest.raises(HJSolveError):
            broken()


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_a_wave_over_more_than_half_a_turn(name: str) -> None:
    source = random.Random(name)
    for _ in range(300):
        value, error, place = source.uniform(-40, 40), source.uniform(1, 7), source.uniform(-1, 1)
        x = MANY.convert(value) + MANY.convert(error) * place
        assert inside(getattr(np, name)(Estimate(value, error)), truth(name, x))


def test_a_root_near_zero_reaches_down_to_zero() -> None:
    root = np.sqrt(Estimate(1e-17, 1e-16))
    assert root.value - root.error <= 0
    assert root.value + root.error >= np.sqrt(1.1e-16)


def test_exact_numbers_stay_exact() -> None:
    assert (Estimate(0.5, 0.0) * 6 - 1) / 2 == 1
    assert np.cos(Estimate(0.0, 0.0)) == 1
    assert np.sqrt(Estimate(2.25, 0.0)) == 1.5
    assert (Estimate(1.0, 0.0) / 3).error > 0
    assert Estimate(1.0, 0.0) + Decimal("0.5") == Fraction(3, 2)


@pytest.mark.parametrize("other", [
    3, 2.5, Fraction(1, 3), Decimal("0.1"), np.float64(2), np.int64(3), np.float32(0.1), sp.Rational(1, 3), sp.Integer(2),
    mpmath.mpf("0.1"), Estimate(2.0, 0.25),
])  # fmt: skip
def test_numbers_of_every_kind_stand_on_either_side(other: object) -> None:
    e = Estimate(7.25, 0.125)
    for operation in (operator.add, operator.sub, operator.mul, operator.truediv):
        assert isinstance(operation(e, other), Estimate)
        assert isinstance(operation(other, e), Estimate)
        assert operation(other, e).error > 0
    assert e > other
    assert other < e
    assert e != other


def test_what_is_no_real_number_is_left_to_python() -> None:
    e = Estimate(7.25, 0.125)
    for other in ("2", 1j, None, [1.0]):
        with pytest.raises(TypeError):
            _ = e + other
    assert e != "7.25"


def test_comparisons_hold_for_every_number_within_the_errors() -> None:
    e = Estimate(3.0, 0.5)
    assert e < 3.75
    assert not e < 3.25
    assert not e > 3.25
    assert e.agrees(3.25)
    assert not e.agrees(3.75)
    assert e.agrees(Estimate(3.75, 0.25))
    assert e == Estimate(3.0, 0.5, nodes=5)
    assert e != 3.0
    assert Estimate(3.0, 0.0) == 3
    assert len({e, Estimate(3.0, 0.5), Estimate(3.0, 0.0), 3.0}) == 2
    assert sorted([Estimate(2.0, 0.1), Estimate(1.0, 0.1)])[0].value == 1.0
    assert (np.array([2.0, 4.0]) < e).tolist() == [True, False]


def test_no_digit_above_a_double_is_lost() -> None:
    c = multiprecision(300)
    third = Estimate(c.mpf(1) / 3, c.mpf(10) ** -60)
    assert abs(MANY.convert((third * 3).value) - 1) < MANY.mpf(10) ** -80
    assert (third * 3).error < c.mpf(10) ** -59
    assert np.asarray(third).dtype == object
    assert f"{third:.50f}" == "0." + 50 * "3"
    assert f"{third:S}".startswith("0." + 55 * "3")
    assert pickle.loads(pickle.dumps(third * 2)) == third * 2
    assert np.exp(Estimate(1000.0, 0.0)) > 1e308  # beyond doubles it goes on


def test_arrays() -> None:
    e = Estimate(2.0, 0.25)
    assert np.asarray(e) == 2.0
    assert np.asarray([e, e]).dtype == float
    times = np.linspace(0, 1, 3) * e
    assert [t.value for t in times] == [0.0, 1.0, 2.0]
    assert [t.error for t in times] == [0.0, 0.125, 0.25]
    assert float(e) == 2.0


@pytest.mark.parametrize(("value", "error", "text"), [
    (7.41629871, 2.4e-7, "7.4162987(3)"), (1234.0, 56.0, "1.23(6)e3"), (6.02214076e23, 1.2e16, "6.02214076(13)e23"),
    (1.0, 0.0, "1.0"), (0.1, 0.3, "0.1(3)"), (-0.28, 6e-17, "-0.28000000000000003(7)"), (0.0, 1.85e-9, "0.0(19)e-9"),
    (1e-20, 3.5e-5, "0.00000(4)"), (0.30000000000000004, 0.0, "0.30000000000000004"), (2.0, float("inf"), "2(unknown)"),
])  # fmt: skip
def test_the_short_form(value: float, error: float, text: str) -> None:
    assert f"{Estimate(value, error):S}" == text


def test_the_short_form_contains_the_truth() -> None:
    source = random.Random(3)
    for _ in range(500):
        e, x = drawn(source)
        text = f"{e:S}"
        digits, _, rest = text.partition("(")
        if not rest:
            continue
        units, _, power = rest.partition(")")
        shift = MANY.mpf(10) ** int(power[1:] or 0)
        last = MANY.mpf(10) ** -len(digits.partition(".")[2])
        assert abs(MANY.mpf(digits) * shift - x) <= int(units) * last * shift, (e, text)


def test_formats() -> None:
    e = Estimate(1234.5678, 2.4e-7, certified=True, nodes=7)
    assert f"{e:.2f}" == "1234.57"
    assert f"{e:12.3e}" == "   1.235e+03"
    assert str(e) == f"{e}" == "1234.5678 ± 2.4e-7"
    assert repr(e) == "Estimate(1234.5678, error=2.4e-7, certified=True, nodes=7)"
    assert eval(repr(e)) == e
    assert e._repr_latex_() == "$1234.5678000(3)$"
    assert Estimate(1e-30, 2.5e-40)._repr_latex_() == r"$1.0000000000(3) \times 10^{-30}$"
    with pytest.raises(ValueError, match="format"):
        f"{e:Q}"
