"""Zeros in a bracket: from values, from values and slopes for many equations at once, and by halving."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from mpmath import mp

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import (
    bisected,
    bracketed_root,
    bracketed_roots,
    interpolated_root,
    newton,
    stationary,
    stationary_places,
)


def test_many_equations_at_once_are_solved_to_the_last_bits_from_anywhere_in_their_brackets() -> None:
    goals = np.linspace(0.0, 6.2, 300)
    start = np.random.default_rng(5).uniform(-1.0, 8.0, 300)

    def kepler(E: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return E - 0.97 * np.sin(E) - goals, 1 - 0.97 * np.cos(E)

    E, residual, slope = bracketed_roots(kepler, start, np.full(300, -1.0), np.full(300, 8.0))
    assert np.all(np.abs(residual) <= 4e-15)
    assert np.all(np.abs(E - 0.97 * np.sin(E) - goals) <= 4e-15)
    assert np.array_equal(slope, 1 - 0.97 * np.cos(E))


def test_values_alone_give_the_last_bits_and_an_end_may_have_none() -> None:
    def zero(f: Callable[[float], float], low: float, high: float) -> float:
        return interpolated_root(f, (low, high), (f(low), f(high)), width=EPS)

    assert abs(zero(lambda x: x * x - 2, 0.0, 2.0) - math.sqrt(2)) <= 2**-51
    assert abs(zero(lambda x: x**3 - 5 if x < 3 else math.inf, 0.0, 4.0) - 5 ** (1 / 3)) <= 2**-50
    asked = []
    zero(lambda x: (asked.append(x), math.exp(x) - 1e-3)[1], -300.0, 1.0)
    assert len(asked) < 60, "a digit should not cost as much as by halving"


def test_newtons_method_from_nearby_ends_at_the_last_bits_or_says_that_it_does_not() -> None:
    with mp.workdps(60):
        two = mp.mpf(2)
        root = newton(lambda x: (x * x - two) / (2 * x), mp.mpf("1.4"), mp.mpf(10) ** -50, 12)
        assert abs(root - mp.sqrt(2)) < mp.mpf(10) ** -58
    assert newton(lambda x: (x * x + 1) / (2 * x), 0.5, 1e-15, 40) is None
    assert newton(lambda _: None, 0.5, 1e-15, 40) is None
    # steps that rounding keeps at 1e-9 end it where that is allowed, and only there
    sizes = iter([1e-3, 1e-9, 1e-9, 1e-9, 1e-9])
    assert newton(lambda _: next(sizes), 1.0, 1e-15, 3, rough=1e7) == 1 - 1e-3 - 1e-9 - 1e-9
    assert newton(lambda _: 1e-9, 1.0, 1e-15, 3) is None
    assert newton(lambda _: 1e-9, 1.0, 1e-15, 3, ended=True) == 1 - 1e-9 - 1e-9 - 1e-9


def test_a_stationary_place_is_found_from_nearby_and_not_beyond_what_is_allowed() -> None:
    def jet(x: float) -> tuple[float, float, float]:
        return math.cos(x), -math.sin(x), -math.cos(x)

    assert abs(stationary(jet, 3.0, lambda bend, _: bend > 0, 1e-15) - math.pi) <= 4e-16
    assert stationary(jet, 0.5, lambda bend, _: bend > 0, 1e-15) is None
    assert stationary(jet, 3.0, lambda _, x: abs(x - 3) < 0.1, 1e-15) is None
    x, fine, bend = stationary_places(lambda x: (np.cos(x), -np.sin(x), -np.cos(x)), np.array([3.0, 0.5, 2.0]), 0.5, 8)
    assert list(fine) == [True, False, False]
    assert abs(x[0] - math.pi) <= 4e-16
    assert abs(bend[0] - 1) <= 4e-16
    assert list(x[1:]) == [0.5, 2.0]


@pytest.mark.parametrize(("start", "rising"), [(None, None), ("0.1", True), ("-2.9", None)])
def test_a_root_in_a_bracket_has_all_digits_whatever_the_start_and_next_to_zero(
    start: str | None, rising: bool | None
) -> None:
    context = multiprecision(200)

    def function(x: Mpf) -> tuple[Mpf, Mpf]:
        return x - context.sin(x) * 0.9, 1 - 0.9 * context.cos(x)

    begin = None if start is None else context.mpf(start)
    asked = []
    root = bracketed_root(lambda x: (asked.append(x), function(x))[1], -3, 2, 200, start=begin, rising=rising, size=1)
    assert abs(root) <= context.mpf(2) ** -190
    assert len(asked) < 25
    falling = bracketed_root(lambda x: (1 - x * x, -2 * x), context.mpf("0.5"), 3, 200, start=begin and 2 * context.one)
    assert abs(falling - 1) <= context.mpf(2) ** -190


def test_a_bracket_is_halved_as_often_as_asked_and_holds_the_place() -> None:
    low, high = bisected(lambda x: x < 1 / 3, 0.0, 1.0, 20)
    assert low < 1 / 3 <= high
    assert high - low == 2.0**-20
    assert bisected(lambda x: x > 1 / 3, 1.0, 0.0, 20) == (high, low)
