"""Slopes from a base point against quotients of differences in 80 digits."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from hjsolve.arithmetic.divided_differences import FirstDifferences
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.lowering import lower

x, c = sp.symbols("x c")
FORMULAS = [
    2 * c * sp.sinh(x) ** 2 - c**2 / sp.sinh(x) ** 2 + sp.sqrt(c + sp.cosh(x) ** 2),
    c * sp.cos(x) + sp.sin(x) ** 3 / (1 + c * sp.cos(x)),
    ((x**2 + c) ** 2 - 3 * x) / (x**2 - 2 * x + 3) ** 2,
    sp.exp(-c * x) * sp.tan(x / 3) - sp.tanh(x) / x,
]


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
@pytest.mark.parametrize("d", [1e-14, -3e-7, 0.25, -0.6])
def test_a_slope_keeps_its_digits_and_its_bound_holds(formula: sp.Expr, d: float) -> None:
    tape, base, constant = lower([formula], [x, c]), 1.375, 0.3125
    many, place = Multi(300), np.float64(base) + d
    step = many.convert(float(place)) - many.convert(base)
    far, near = (
        tape.run(many, [q, many.convert(constant)])[0] for q in (many.convert(base) + step, many.convert(base))
    )
    true = (far - near) / step
    chords = FirstDifferences(RunningError(Float64()), WithErrorBound(np.float64(float(step))))
    inputs = [chords.variable(WithErrorBound(base), WithErrorBound(place)), chords.constant(WithErrorBound(constant))]
    slope = tape.run(chords, inputs)[0].slope
    error = abs(many.convert(float(slope.value)) - true)
    assert error <= slope.error <= 1e-13 * max(abs(true), 1), (float(error), slope.error)
