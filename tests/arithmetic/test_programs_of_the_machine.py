"""Codes that the writer makes: they compute what their tapes compute, and parameters are no part of them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.divided_differences import SecondDifference
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.writer import InstructionWriter
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.programs import parameter_rows, sides, system_programs
from hjsolve.ensembles.engine.programs_of_small_motions import has_slopes
from hjsolve.motion.initial_data import parameter_values
from tests.reference.second_differences import in_doubles


def known(name: str, **values: object):
    """The lowered solution of an entry, and its programs."""
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    model = lowered_model(solution, parameter_values(solution.system, values))
    return model, system_programs(model, kernels=True)


@pytest.mark.nightly_cases("spherical-staeckel")
@pytest.mark.parametrize("name", ["two-centres-plane", "oscillator-tan", "morse", "spherical-staeckel"])
def test_a_program_computes_what_its_tape_computes(name: str) -> None:
    model, made = known(name)
    numbers = [pair.high for pair in model.numbers]
    constants = [-0.3 + 0.37 * k for k in range(len(model.constants))]
    places = np.array([0.7, 0.31, 1.2])
    given = np.stack([places, *(np.full(3, c) for c in constants)])
    for coordinate, programs in zip(model.separated, made.coordinates, strict=True):
        for formula, view in zip(sides(coordinate), programs.views, strict=True):
            expected = formula.squared.run(Float64(), [places, *constants, *numbers])[0]
            np.testing.assert_allclose(run_rows(view.bend, made.parameters, given)[0], expected, rtol=1e-14, atol=0)
        if not has_slopes(coordinate.plain):
            continue
        for x in (-0.2, 1e-3, 0.3):
            slopes = in_doubles(x)
            inputs = [slopes.variable(0.7), *(SecondDifference(k) for k in (*constants, *numbers))]
            expected = coordinate.plain.squared.run(slopes, inputs)[0].second
            rows = np.array([[x, *constants, 0.7, 0.0, 0.0, 0.0, 0.0]]).T
            (found,) = run_rows(programs.small.value, made.parameters, rows)
            np.testing.assert_allclose(found, expected, rtol=1e-13, atol=0)


def test_a_new_value_of_a_parameter_makes_no_new_program() -> None:
    (one, first), (other, second) = known("kepler-planar"), known("kepler-planar", k=3)
    assert parameter_rows(one.numbers) != parameter_rows(other.numbers)
    assert first.start is second.start
    assert all(a.views[0].fill is b.views[0].fill for a, b in zip(first.coordinates, second.coordinates, strict=True))


def test_only_known_operations_are_written() -> None:
    writer = InstructionWriter()
    with pytest.raises(ValueError, match="__import__"):
        writer.called("__import__", writer.input())


def test_lanes_do_not_depend_on_each_other() -> None:
    """Bit for bit the same in any company, at any place in a block."""
    model, made = known("spherical-pendulum")
    rng = np.random.default_rng(5)
    given = rng.uniform(0.2, 1.3, (1 + len(model.constants), 301))
    code = made.coordinates[0].views[0].bend
    all_of_them = run_rows(code, made.parameters, given)
    for some in (slice(0, 1), slice(7, 20), slice(150, 301), slice(None, None, -1)):
        np.testing.assert_array_equal(run_rows(code, made.parameters, given[:, some]), all_of_them[:, some])


def test_a_thread_gets_its_program_again_and_no_other_one_at_work_with_it() -> None:
    writer = InstructionWriter()
    x, y = writer.inputs(2)
    (a,) = writer.parameters(1)
    code = writer.code([writer.add(writer.mul(x, y), a)])
    kept = code.program(16, (2.0,))
    assert code.program(16, (2.0,)) is kept
    others = [code.program(16, (2.0,), 1), code.program(16, (3.0,)), code.program(24, (2.0,))]
    with ThreadPoolExecutor(1) as pool:
        others.append(pool.submit(code.program, 16, (2.0,)).result())
    for other in others:
        assert not np.shares_memory(other.registers, kept.registers)
    for program in (kept, *others):
        assert program.registers.ctypes.data % 64 == 0
    given = np.array([[1.5, -2.0], [4.0, 0.25]])
    for factor, expected in ((1.0, [8.0, 1.5]), (2.0, [26.0, 0.0])):  # what is left in the registers is not seen
        assert run_rows(code, (2.0,), factor * given)[0].tolist() == expected
