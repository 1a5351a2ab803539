"""S(q0, q1, t) as a formula, and what is exact where the forces are linear."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.errors import InvalidInputError


def spring():
    return hjsolve.solve(hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "m*w**2/2*x**2", {"m": 1, "w": 2}))


def test_the_oscillator_has_the_formula_of_the_book():
    solution = spring()
    function, m = solution.two_point_function(), solution.system.symbols["m"]
    w, x, x0, t = sp.symbols("w x x_0 t", real=True)
    book = m * w / 2 * (x**2 + x0**2) * sp.cot(w * t) - m * w * x * x0 / sp.sin(w * t)  # Greenwood (5-108)
    assert sp.simplify((function.principal_function - book).rewrite(sp.sin)) == 0
    assert function.at_end.determinant != 0
    assert function.at_start.constants == ("x_0",)


@pytest.mark.nightly
def test_products_of_free_falling_and_inverted_coordinates_are_proved_at_both_ends():
    system = hjsolve.System(
        {"x": "line", "y": "line", "z": "line"},
        "(dot(x)**2 + dot(y)**2 + 3*dot(z)**2)/2",
        "2*x**2 - y**2/2 + y + z + 1",
    )
    function = hjsolve.solve(system).two_point_function()
    assert set(function.start) == {"x", "y", "z"}
    # the numbers of two_point are those of the formula and of the motion
    q0, q1 = {"x": 1, "y": "1/5", "z": 1}, {"x": "1/2", "y": 2, "z": 0}
    (c,) = hjsolve.solve(system).two_point(q0=q0, q1=q1, time=2)
    point = {function.start[n]: sp.sympify(v) for n, v in q0.items()}
    point |= {sp.Symbol(n, real=True): sp.sympify(v) for n, v in q1.items()} | {sp.Symbol("t", real=True): 2}
    assert abs(float(function.principal_function.subs(point)) - c.principal_function.value) < 1e-14
    assert c.motion.principal_function(2).agrees(c.principal_function)
    assert c.conjugate_points == 1


def test_after_half_periods_q1_is_reached_by_all_motions_or_by_none():
    every = spring().two_point(q0={"x": 1}, q1={"x": -1}, time="pi/2")
    none = spring().two_point(q0={"x": 1}, q1={"x": 1}, time="pi/2")
    assert every.complete
    assert every.continua[0].free == ("the initial momentum of x",)
    assert not every.connections
    assert none.complete
    assert not none.continua
    assert not none.connections


@pytest.mark.parametrize(("time", "conjugate", "turns"), [(1, 0, 0), (2, 1, 0), (5, 3, 1)])
def test_conjugate_points_of_a_spring_are_half_periods(time, conjugate, turns):
    (c,) = spring().two_point(q0={"x": 1}, q1={"x": "1/2"}, time=time, turns=range(3))
    assert (c.conjugate_points, c.turns) == (conjugate, turns) == (int(2 * time // np.pi), int(2 * time // (2 * np.pi)))


def test_another_system_says_what_to_ask_instead():
    with pytest.raises(InvalidInputError, match="two_point"):
        hjsolve.solve(hjsolve.catalog.load("pendulum")).two_point_function()
