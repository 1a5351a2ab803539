"""Complex programs of the machine against mpmath: values within the bounds that are carried along with them."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.arithmetic.machine.complex_writer import AnalyticWriter, ComplexRunningError, ComplexValue, ComplexWriter
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.writer import InstructionWriter
from hjsolve.arithmetic.running_error import WithErrorBound
from hjsolve.lowering import lower

many = mpmath.mp.clone()
many.dps = 40

z, c = sp.symbols("z c")
FORMULAS = {
    "quotients and powers": (z**3 - c / (z**2 + 2)) / (z - 3 * c) ** 2,
    "next to a zero": (z - c) * (z + c) - z**2 + c**2 * (1 + z / 10**6),
    "root": sp.sqrt(z**2 - 4 * c),
    "exponential and logarithm": sp.exp(-(z**2)) * sp.log(c + z**2) + sp.log(1 + z / 1000),
    "circular": sp.sin(3 * z) / sp.cos(z) + sp.tan(z / 2) - c / sp.sin(z) ** 2,
    "hyperbolic": sp.sinh(z) ** 2 - c / sp.cosh(z) + sp.tanh(z) + c / sp.sinh(z) ** 2,
    "inverse and small": sp.asinh(z * (1 + 1 / (1 + z)) / 2) / z - sp.asinh(z) / z + sp.asin(z) / z,
    "inverse": sp.asinh(z) + sp.atan(z / 3) + sp.acosh(z + 4) + sp.atanh(z / 7) + sp.asin(z / 5) + sp.acos(z / 6),
}


def programs(formula):
    tape = lower([formula], [z, c])
    plain, bounded = InstructionWriter(), InstructionWriter()
    re, im, known = plain.inputs(3)
    (value,) = tape.run(AnalyticWriter(plain), [ComplexValue(re, im), ComplexValue(known)])
    re, im, known = bounded.inputs(3)
    inputs = [WithErrorBound(ComplexValue(re, im)), WithErrorBound(ComplexValue(known))]
    (result,) = tape.run(ComplexRunningError(ComplexWriter(bounded)), inputs)
    return plain.code([value.re, value.im]), bounded.code([result.value.re, result.value.im, result.error.re])


@pytest.mark.parametrize("name", FORMULAS)
def test_values_lie_within_their_bounds_and_bounds_are_near(name):
    rng = np.random.default_rng(5)
    size = 10.0 ** rng.uniform(-6, 0.3, 200)
    at = size * np.exp(1j * rng.uniform(-1.5, 1.5, 200))
    known = rng.uniform(0.5, 2, 200)
    code, bounded = programs(FORMULAS[name])
    re, im = run_rows(code, [], np.stack([at.real, at.imag, known]))
    same_re, same_im, bound = run_rows(bounded, [], np.stack([at.real, at.imag, known]))
    names = ("exp", "log", "sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "asin", "acos",
             "atan")  # fmt: skip
    exact = sp.lambdify((z, c), FORMULAS[name], modules=[{own: getattr(many, own) for own in names}])
    ratios = []
    for k in range(len(at)):
        truth = exact(many.mpc(at[k]), many.mpf(known[k]))
        for value in (complex(re[k], im[k]), complex(same_re[k], same_im[k])):
            assert abs(many.mpc(value) - truth) <= bound[k] * (1 + 1e-9)
        ratios.append(bound[k] / (abs(complex(truth)) + 1e-300))
    assert np.median(ratios) < 1e-13 or name == "next to a zero"


def test_what_is_real_costs_no_complex_operation():
    writer, other = InstructionWriter(), InstructionWriter()
    x, y = (ComplexValue(v) for v in writer.inputs(2))
    a = ComplexWriter(writer)
    found = a.div(a.mul(x, y), a.add(x, a.power(y, 3)))
    u, v = other.inputs(2)
    assert found.im is None
    assert writer.code([found.re]) == other.code([other.div(other.mul(u, v), other.add(u, other.power(v, 3)))])


def test_a_size_in_a_formula_is_analytic():
    writer = InstructionWriter()
    re, im = writer.inputs(2)
    found = AnalyticWriter(writer).unary("abs", ComplexValue(re, im))
    made = run_rows(writer.code([found.re, found.im]), [], np.array([[-2.0, 3.0], [1.0, 1.0]]))
    assert made.tolist() == [[2.0, 3.0], [-1.0, 1.0]]
