"""A complete integral of the user's own against hjsolve's constants and motion, and what must not pass for it."""

from __future__ import annotations

import math

import pytest
import sympy as sp

import hjsolve

KEPLER = hjsolve.System(
    {"r": "0 < r", "theta": "angle"}, "m/2*(dot(r)**2 + r**2*dot(theta)**2)", "-k/r", {"m": 1, "k": 1}
)
OSCILLATOR = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "k/2*x**2", {"m": 2, "k": 3})
START = {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0.3", "theta": "0.9"}}


@pytest.fixture(scope="module")
def kepler():
    W = "a*theta + integral(sqrt(2*m*(c**2 + k/r) - a**2/r**2), r)"
    return hjsolve.verify(KEPLER, W=W, constants="a, c", energy="c**2"), hjsolve.solve(KEPLER)


def test_constants_of_a_solution_are_functions_of_the_users(kepler):
    answer, solution = kepler
    a, c = sp.symbols("a c", real=True)
    assert answer.constants_in(solution) == {"E": c**2, "p_theta": a}


def test_another_separation_has_other_constants():
    """p_x and p_y are functions of an energy and a direction, but not of a place that the free particle left at t = 0."""
    plane = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "0")
    turned = hjsolve.verify(plane, S="a*(x*cos(b) + y*sin(b)) - a**2*t/2", constants="a, b")
    found = turned.constants_in(hjsolve.solve(plane))
    a, b = sp.symbols("a b", real=True)
    assert sp.simplify(found["p_x"] - a * sp.cos(b)) == sp.simplify(found["p_y"] - a * sp.sin(b)) == 0
    place_to_place = hjsolve.verify(plane, S="((x - a)**2 + (y - b)**2)/(2*t)", constants="a, b")
    flaw = place_to_place.constants_in(hjsolve.solve(plane))["p_x"]
    assert isinstance(flaw, hjsolve.Flaw)
    assert flaw.part == "constants"
    assert flaw.witness.excludes_zero


def test_jacobis_equations_hold_along_the_motion(kepler):
    answer, solution = kepler
    motion = solution.motion(q=START["q"], velocity={"r": "0.9", "theta": "1.2"})  # it escapes: E = c² > 0
    found = answer.along(motion, [0.5 * k for k in range(1, 8)])
    assert found
    assert found.agrees
    assert abs(abs(found.constants["c"].value) - math.sqrt(0.9**2 / 2 + 1.2**2 / 2 - 1)) < 1e-12
    assert abs(found.constants["a"].value - 1.2) <= found.constants["a"].error
    assert 0 < found.constants["a"].error < 1e-12
    assert found.times == (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)


def test_a_bounded_motion_is_compared_on_the_branch_of_the_formula():
    answer = hjsolve.verify(OSCILLATOR, W="integral(sqrt(2*m*E - m*k*x**2), x)", constants="E")
    motion = hjsolve.solve(OSCILLATOR).motion(q={"x": "0.3"}, velocity={"x": "-1"})
    found = answer.along(motion)
    assert found
    assert len(found.times) == 12  # p > 0 half of the time
    assert abs(found.constants["E"].value - (1 + 1.5 * 0.09)) <= found.constants["E"].error


def test_the_principal_function_from_place_to_place_has_the_place_at_t_zero_as_its_constant():
    S = "sqrt(m*k)/2*((x**2 + a**2)*cos(sqrt(k/m)*t) - 2*x*a)/sin(sqrt(k/m)*t)"
    answer = hjsolve.verify(OSCILLATOR, S=S, constants="a")
    found = answer.along(hjsolve.solve(OSCILLATOR).motion(q={"x": "0.3"}, velocity={"x": "-1"}), [0.2, 0.5, 0.9, 1.4])
    assert found
    assert abs(found.constants["a"].value - 0.3) <= found.constants["a"].error


def test_the_motion_of_another_system_does_not_agree():
    answer = hjsolve.verify(OSCILLATOR, W="integral(sqrt(2*m*E - m*k*x**2), x)", constants="E")
    other = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "k/2*x**2 + x**4/10", {"m": 2, "k": 3})
    found = answer.along(hjsolve.solve(other).motion(q={"x": "0.3"}, velocity={"x": "1"}))
    assert not found
    assert found.deviations["p"] > 1e3
    assert "do not agree" in str(found)


def test_other_coordinates_and_momenta_of_the_other_sign_are_told():
    answer = hjsolve.verify(OSCILLATOR, W="integral(sqrt(2*m*E - m*k*x**2), x)", constants="E")
    pendulum = hjsolve.solve("pendulum")
    with pytest.raises(hjsolve.InvalidInputError, match="the motion is in theta, the integral in x"):
        answer.along(pendulum.motion(q={"theta": "0.3"}, velocity={"theta": "0"}))
    with pytest.raises(hjsolve.InvalidInputError, match="the solution is in theta, the integral in x"):
        answer.constants_in(pendulum)
    motion = hjsolve.solve(OSCILLATOR).motion(q={"x": "0.3"}, velocity={"x": "-1"})
    assert isinstance(answer.along(motion, [0.0, 0.01, 0.02, 0.03]), hjsolve.Undecided)
