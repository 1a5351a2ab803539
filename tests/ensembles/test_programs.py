"""Generated programs hold nothing but operation codes and numbers, and compute what the tape computes."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.arithmetic.second_differences import SecondDifference, in_doubles
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.program_texts import small_text, start_text, view_text
from hjsolve.ensembles.engine.programs import Loop, compiled, sides
from hjsolve.ensembles.engine.regions import has_slopes
from hjsolve.motion.initial_data import parameter_values

WORDS = {
    "def", "return", "for", "in", "range", "x", "c", "e", "q", "p", "i", "j", "r", "b", "s", "d", "f", "W", "C", "E", "L", "P", "g", "low", "spread",
    "value", "bend", "slopes", "fill", "uncertainties", "relative", "bounds", "start", "buffer", "near", "far", "derivative", "stop", "shape",
    "abs", "out", "place", "size", "mask", "h", "along", "z", "base", "offset", "start0", "square0", "first0", "doubt0", "width0", "origin", "span",
    "slope", "if", "else", "pair_add", "pair_mul", "pair_div", "pair_sqrt", "pair_sincos", "pair_sinhcosh", "pair_exp", "pair_tan", "pair_atan",
    "sincos", "sinhcosh", "sqrt_", "exp_", "log_", "abs_", "tan_", "tanh_", "atan_",
    "given", "made", "cell", "first", "k", "min",
    "sincos_bends", "sinhcosh_bends", "exp_bend", "log_bend", "common_sign",
}  # fmt: skip


@pytest.mark.parametrize("name", ["pendulum", "two-centres-plane", "oscillator-tan", "spherical-staeckel", "morse"])
def test_a_program_has_only_our_words(name: str) -> None:
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    model = lowered_model(solution, parameter_values(solution.system, {}))
    numbers = tuple(pair.high for pair in model.numbers)
    count = len(model.constants)
    texts = [start_text(model)]
    for coordinate in model.separated:
        texts += [view_text(formula, count, numbers, True) for formula in sides(coordinate)]
        texts += [small_text(coordinate.plain, count, model.numbers, True)] if has_slopes(coordinate.plain) else []
    for text in texts:
        words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"\d+\.?\d*e[-+]?\d+", "0", text)))
        assert {w for w in words if not re.fullmatch(r"t\d+_\d|[bcegsx]\d+", w)} <= WORDS


def test_only_known_codes_are_written() -> None:
    with pytest.raises(ValueError, match="__import__"):
        PythonSource().unary("__import__", "x")


@pytest.mark.nightly_cases("two-centres-plane")
@pytest.mark.parametrize("name", [
    "two-centres-plane", "oscillator-tan", pytest.param("spherical-staeckel", marks=pytest.mark.nightly),
])  # fmt: skip
def test_a_program_computes_what_its_tape_computes(name: str) -> None:
    pytest.importorskip("numba")
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    model = lowered_model(solution, parameter_values(solution.system, {}))
    numbers = tuple(pair.high for pair in model.numbers)
    constants = np.array([-0.3 + 0.37 * k for k in range(len(model.constants))])
    made = compiled(model, kernels=True)
    for coordinate, programs in zip(model.separated, made.coordinates, strict=True):
        for formula, view in zip(sides(coordinate), (programs.below, programs.above), strict=True):
            expected = formula.squared.run(Float64(), [0.7, *constants, *numbers])[0]
            assert np.isclose(view.value(0.7, constants), expected, rtol=1e-14, atol=0)
        if not has_slopes(coordinate.plain):
            continue
        for x in (-0.2, 1e-3, 0.3):
            slopes = in_doubles(x)
            inputs = [slopes.variable(0.7), *(SecondDifference(k) for k in (*constants, *numbers))]
            expected = coordinate.plain.squared.run(slopes, inputs)[0].second
            known = np.array([*constants, 0.7, 0.0, 0.0, 0.0, 0.0])
            assert np.isclose(programs.small().value(x, known), expected, rtol=1e-13, atol=0)


class _Row(NamedTuple):
    values: Any
    scale: float


def _weighted(row: Any, weights: Any, out: Any) -> None:
    for j in range(out.shape[0]):
        out[j] = row.scale * row.values[j] * weights[j]


def test_a_loop_is_used_for_the_arguments_it_was_compiled_for() -> None:
    """What is remembered of a call never serves arguments of another type: strides, item sizes, tuples, read-only."""
    numba = pytest.importorskip("numba")
    loop, x = Loop(numba.njit(_weighted), ()), np.arange(1.0, 13.0)
    frozen = x.copy()
    frozen.setflags(write=False)
    kinds = [x, x[::2], x[::-1], frozen, x.astype(np.float32), x.astype(np.int32), x.reshape(6, 2)[:, 1], x > 5]
    for values, weights, scale in [*((v, x, 2.0) for v in kinds), *((x, w, 3) for w in kinds[1:3])] * 2:
        out = np.empty(6)
        loop(_Row(values, scale), weights, out)
        assert (out == float(scale) * values[:6].astype(float) * weights[:6]).all()
