"""Generated programs hold nothing but operation codes and numbers, and compute what the tape computes."""

from __future__ import annotations

import re

import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.programs import _coordinate_text, _start_text, compiled_programs
from hjsolve.motion.initial_data import parameter_values

WORDS = {
    "def", "return", "for", "in", "range", "if", "else", "x", "c", "e", "q", "p", "i", "j", "r", "a", "b", "W", "C", "E", "doubt",
    "P", "value", "slope", "bend", "fill", "doubts", "pack", "start", "buffer", "low", "high", "pace", "count", "shape",
    "anchor", "relative", "first", "last", "lower", "d", "abs", "out", "place", "mask", "base", "offset", "g",
    "search", "ends", "loop", "orbits", "True", "False",
    "sincos", "sinhcosh", "sqrt_", "exp_", "log_", "abs_", "tan_", "tanh_", "atan_",
}  # fmt: skip


@pytest.mark.parametrize("name", ["pendulum", "two-centres-plane", "oscillator-tan", "spherical-staeckel", "morse"])
def test_a_program_has_only_our_words(name: str) -> None:
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    model = lowered_model(solution, parameter_values(solution.system, {}))
    numbers = tuple(pair.high for pair in model.numbers)
    texts = [_start_text(model)] + [_coordinate_text(c, len(model.constants), numbers, True) for c in model.separated]
    for text in texts:
        words = set(re.findall(r"[A-Za-z_]\w*", re.sub(r"\d+\.?\d*e[-+]?\d+", "0", text)))
        assert {w for w in words if not re.fullmatch(r"((low|high)_)?(t\d+_\d|[cesx]\d+|b)", w)} <= WORDS


def test_only_known_codes_are_written() -> None:
    with pytest.raises(ValueError, match="__import__"):
        PythonSource().unary("__import__", "x")


@pytest.mark.parametrize("name", ["two-centres-plane", "spherical-staeckel", "oscillator-tan"])
def test_a_program_computes_what_its_tape_computes(name: str) -> None:
    pytest.importorskip("numba")
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    model = lowered_model(solution, parameter_values(solution.system, {}))
    numbers = tuple(pair.high for pair in model.numbers)
    constants = tuple(-0.3 + 0.37 * k for k in range(len(model.constants)))
    for coordinate in model.separated:
        made = compiled_programs(coordinate, len(constants), numbers, True)
        expected = coordinate.plain.squared.run(Float64(), [0.7, *constants, *numbers])[0]
        assert np.isclose(made.value(0.7, constants)[0], expected, rtol=1e-14, atol=0)
