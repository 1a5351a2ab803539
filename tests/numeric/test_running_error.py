"""Doubles with a running error: the bound holds, is zero where nothing is rounded, and is not far from the truth."""

from __future__ import annotations

import numpy as np
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.lowering import lower
from hjsolve.numeric.arithmetic import Multi
from hjsolve.numeric.running_error import RunningError

x, y = sp.symbols("x y", real=True)
FORMULAS = [
    x**2 * y, (x + y) ** 3 / 7, y / sp.sqrt(1 - x**2 / 16), x * sp.cos(y) - y * sp.sin(x), sp.exp(x - y) / 3 + sp.pi,
    x - y * (1 + x / 1000), sp.log(2 + x**2) * y, 1 / x - 1 / y,
]  # fmt: skip
NUMBERS = st.floats(0.1, 3.9)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=5))
def test_the_bound_holds(points: list[tuple[float, float]]) -> None:
    tape = lower(FORMULAS, [x, y])
    left, right = np.array(points).T
    found = tape.run(RunningError(), [(left, 0.0), (right, 0.0)])
    for k, (a, b) in enumerate(points):
        exact = tape.run(Multi(300), [Multi(300).convert(a), Multi(300).convert(b)])
        for formula, (value, bound), true in zip(FORMULAS, found, exact):
            missed = abs(Multi(300).convert(float(np.broadcast_to(value, left.shape)[k])) - true)
            claimed = np.broadcast_to(bound, left.shape)[k]
            assert missed <= claimed * (1 + 1e-12), (formula, a, b)
            assert claimed <= 1e-13 * (1 + abs(float(true))), (formula, a, b)


def test_the_bound_is_zero_where_nothing_is_rounded() -> None:
    tape = lower([x * y, 8 * x + y / 4, x**2 - y, x / y, -x], [x, y])
    for _, bound in tape.run(RunningError(), [(np.array([3.0, 5.0]), 0.0), (np.array([0.5, 4.0]), 0.0)]):
        assert (np.asarray(bound) == 0).all()


def test_an_inexact_input_is_carried_along() -> None:
    (value, bound), = lower([x * y - 1], [x, y]).run(RunningError(), [(0.1, 1e-3), (10.0, 0.0)])
    assert abs(value) < 1e-15
    assert 1e-2 <= bound < 1.1e-2
