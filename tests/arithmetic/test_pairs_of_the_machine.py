"""Numbers in two doubles, on the machine and over arrays, against mpmath."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from hjsolve.arithmetic import double_double as over_arrays
from hjsolve.arithmetic.machine.pairs import FUNCTIONS

PAIRS: dict[str, Callable[..., Any]] = {n: f for n, f in FUNCTIONS.items() if n.startswith("pair_")}

CASES: list[tuple[str, tuple[float, float]]] = [
    ("exp", (-30, 30)), ("sinhcosh", (-30, 30)), ("sincos", (-40, 40)), ("tan", (-1.5, 1.5)),
    ("tanh", (-5, 5)), ("sech", (-20, 20)), ("log", (1e-3, 1e3)), ("asin", (-0.99, 0.99)),
    ("acos", (-0.99, 0.99)), ("atan", (-9, 9)), ("asinh", (-9, 9)), ("acosh", (1.01, 9)),
    ("atanh", (-0.99, 0.99)), ("sqrt", (1e-3, 1e3)), ("abs", (-3, 3)),
]  # fmt: skip
RULES: dict[str, tuple[Callable[..., Any], ...]] = {
    "sinhcosh": (mpmath.sinh, mpmath.cosh),
    "sincos": (mpmath.sin, mpmath.cos),
    "abs": (abs,),
}


def pairs(rng: np.random.Generator, ends: tuple[float, float], count: int) -> list[tuple[float, float]]:
    high = rng.uniform(*ends, count)
    return [(float(x), float(x * y * 2.0**-54)) for x, y in zip(high, rng.uniform(-1, 1, count), strict=True)]


@pytest.mark.rotating(3)
@pytest.mark.parametrize("functions", [PAIRS, vars(over_arrays)], ids=["lanes", "arrays"])
@pytest.mark.parametrize(("name", "ends"), CASES, ids=lambda x: x if isinstance(x, str) else "")
def test_functions_have_a_hundred_bits(name: str, ends: tuple[float, float], functions: dict[str, Any]) -> None:
    rng = np.random.default_rng(5)
    with mpmath.workprec(300):
        for x, low in pairs(rng, ends, 60):
            found = [float(part) for part in functions[f"pair_{name}"](x, low)]
            for k, rule in enumerate(RULES.get(name, (getattr(mpmath, name, None),))):
                expected = rule(mpmath.mpf(x) + mpmath.mpf(low))
                error = mpmath.mpf(found[2 * k]) + mpmath.mpf(found[2 * k + 1]) - expected
                size = 1 if name in {"sincos", "tan", "acos", "log"} else abs(expected)
                assert abs(error) <= mpmath.mpf(2) ** -98 * size, (x, low)


def test_small_sines_keep_their_digits() -> None:
    with mpmath.workprec(300):
        for x in (1e-3, 1e-8, -1e-150):
            for name, rule in (("sinhcosh", mpmath.sinh), ("sincos", mpmath.sin)):
                high, low, *_ = PAIRS[f"pair_{name}"](x, 0.0)
                assert abs(mpmath.mpf(high) + mpmath.mpf(low) - rule(x)) <= mpmath.mpf(2) ** -98 * abs(mpmath.mpf(x))


@pytest.mark.parametrize("name", ["sincos", "sinhcosh"])
def test_functions_nearby_have_a_hundred_bits_or_are_nan(name: str) -> None:
    rng = np.random.default_rng(7)
    with mpmath.workprec(400):
        for x in (*map(float, rng.uniform(-9, 9, 30)), 1e-9, -1e-14, 1.5707963267948966):
            at = PAIRS[f"pair_{name}"](x, 0.0)
            for d in map(float, 2.0 ** rng.uniform(-90, -34, 9) * rng.choice([-1, 1], 9)):
                low = d * 2.0**-55
                found = PAIRS[f"pair_{name}_near"](*at, d, low)
                for k, rule in enumerate(RULES[name]):
                    expected = rule(mpmath.mpf(x) + mpmath.mpf(d) + mpmath.mpf(low))
                    error = mpmath.mpf(found[2 * k]) + mpmath.mpf(found[2 * k + 1]) - expected
                    size = abs(expected) + abs(rule(mpmath.mpf(x))) if name == "sinhcosh" or k == 0 else 1
                    assert abs(error) <= mpmath.mpf(2) ** -98 * size, (x, d)
            assert np.isnan(PAIRS[f"pair_{name}_near"](*at, 2.0**-33, 0.0)).all()


@pytest.mark.parametrize("name", ["add", "mul", "div"])
def test_operations_have_a_hundred_bits(name: str) -> None:
    rng = np.random.default_rng(6)
    rule = {"add": lambda a, b: a + b, "mul": lambda a, b: a * b, "div": lambda a, b: a / b}[name]
    with mpmath.workprec(300):
        for (x, x_low), (y, y_low) in zip(pairs(rng, (0.1, 9), 60), pairs(rng, (0.1, 9), 60), strict=True):
            high, low = PAIRS[f"pair_{name}"](x, x_low, y, y_low)
            expected = rule(mpmath.mpf(x) + mpmath.mpf(x_low), mpmath.mpf(y) + mpmath.mpf(y_low))
            assert abs(mpmath.mpf(high) + mpmath.mpf(low) - expected) <= mpmath.mpf(2) ** -101 * abs(expected)


def test_the_exponential_of_what_is_far_below_zero_is_zero() -> None:
    # exp(−1e10 x²) made the constants of a narrow dip nan
    assert tuple(PAIRS["pair_exp"](-1e10, 0.0)) == (0.0, 0.0)
    assert tuple(PAIRS["pair_exp"](1e10, 0.0)) == (np.inf, 0.0)
    assert np.isnan(PAIRS["pair_exp"](np.nan, 0.0)[0])


@pytest.mark.parametrize("functions", [PAIRS, vars(over_arrays)], ids=["lanes", "arrays"])
def test_functions_that_are_flat_far_out_have_their_limits(functions: dict[str, Any]) -> None:
    for x in (-1e4, -710.0, 710.0, 1e4):
        assert tuple(map(float, functions["pair_tanh"](x, 0.0))) == (np.sign(x), 0.0)
        assert tuple(map(float, functions["pair_sech"](x, 0.0))) == (0.0, 0.0)


def test_arrays_and_lanes_have_the_same_bits() -> None:
    rng = np.random.default_rng(8)
    for name, ends in CASES:
        if name in {"log", "asin", "acos", "atan", "asinh", "acosh", "atanh"}:  # they begin with a double of numpy's
            continue
        given = pairs(rng, ends, 60)
        found = getattr(over_arrays, f"pair_{name}")(*np.array(given).T)
        assert np.array_equal(np.array([PAIRS[f"pair_{name}"](*x) for x in given]).T, np.array(found))
