"""Zeros in a bracket: from values, from values and slopes for many equations at once, and by halving."""

from __future__ import annotations

import math

import numpy as np

from hjsolve.arithmetic.root_finding import bisected, bracketed_roots, regula_falsi


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
    assert abs(regula_falsi(lambda x: x * x - 2, 0.0, 2.0) - math.sqrt(2)) <= 2**-51
    assert abs(regula_falsi(lambda x: x**3 - 5 if x < 3 else math.inf, 0.0, 4.0) - 5 ** (1 / 3)) <= 2**-50


def test_a_bracket_is_halved_as_often_as_asked_and_holds_the_place() -> None:
    low, high = bisected(lambda x: x < 1 / 3, 0.0, 1.0, 20)
    assert low < 1 / 3 <= high
    assert high - low == 2.0**-20
    assert bisected(lambda x: x > 1 / 3, 1.0, 0.0, 20) == (high, low)
