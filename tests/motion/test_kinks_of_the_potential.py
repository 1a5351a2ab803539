"""V with kinks and jumps in one coordinate: |x|, sign(x), Piecewise, roots of squares; against closed forms."""

from __future__ import annotations

from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.errors import ExpressionError, InvalidSystemError, NotConvergedError
from hjsolve.motion.motion import Motion

exact = mpmath.MPContext()
exact.dps = 50
x = sp.Symbol("x")


def moved(V: object, q: object, v: object, digits: int = 15, **parameters: object) -> Motion:
    system = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", V, {"m": 1, **parameters})
    return hjsolve.solve(system).motion(q={"x": q}, velocity={"x": v}, digits=digits)


def within(estimate: object, truth: object) -> bool:
    return bool(abs(exact.mpf(estimate.value) - truth) <= exact.mpf(estimate.error))


def beta_period(n: object) -> object:
    """T of V = |x|ⁿ, E = 1, m = 1 (Landau and Lifshitz, Mechanics, section 11, problem 2a)."""
    n = exact.mpf(n)
    return 2 * exact.sqrt(2 * exact.pi) / n * exact.gamma(1 / n) / exact.gamma(exact.mpf(1) / 2 + 1 / n)


@pytest.mark.parametrize("digits", [15, 30])
def test_a_constant_force_towards_zero_f_abs_x_is_a_motion(digits: int) -> None:
    motion = moved("F*abs(x)", 1, 0, digits, F=1)
    assert motion.kinds == {"x": "libration"}
    assert within(motion.periods["x"], 4 * exact.sqrt(2))
    assert within(motion.actions["x"], 4 * exact.sqrt(2) / (3 * exact.pi))
    assert motion.turning_points["x"][0].value == -1
    state = motion.at(3)
    truth = -1 + (3 - 2 * exact.sqrt(2)) ** 2 / 2
    assert abs(exact.mpf(state.q["x"]) - truth) <= exact.mpf(state.error.q["x"]) < 1e-13
    assert within(motion.time_at("x", "1/2"), 1)
    assert within(motion.time_at("x", "-1/2"), 2 * exact.sqrt(2) - 1)
    assert within(motion.characteristic_function(1), exact.mpf(1) / 3)


@pytest.mark.parametrize("n", ["1", "3", "5"])
@pytest.mark.parametrize("digits", [15, 30])
def test_powers_of_abs_x_have_the_periods_of_landau_and_lifshitz(n: str, digits: int) -> None:
    assert within(moved(f"abs(x)**{n}", 0, "sqrt(2)", digits).periods["x"], beta_period(n))


@pytest.mark.nightly
@pytest.mark.parametrize("n", ["3/2", "1/2", "4/3", "0.7", "pi"])
def test_powers_of_abs_x_that_are_not_analytic_on_either_side(n: str) -> None:
    value = exact.pi if n == "pi" else exact.mpf(eval_fraction(n))
    assert within(moved(f"abs(x)**({n})", 0, "sqrt(2)").periods["x"], beta_period(value))


def eval_fraction(text: str) -> object:
    number = sp.Rational(text)
    return exact.mpf(number.p) / number.q


def test_a_root_of_a_square_is_an_absolute_value() -> None:
    assert within(moved("(x**2)**(3/2)", 0, "sqrt(2)").periods["x"], beta_period(3))


def test_two_springs_joined_at_zero() -> None:
    springs = sp.Piecewise((x**2 / 2, x < 0), (2 * x**2, True))
    assert within(moved(springs, 1, 0).periods["x"], 3 * exact.pi / 2)


def test_a_step_is_passed_above_and_throws_back_below() -> None:
    assert within(moved("x**2/2 + (1 + sign(x))/8", -1, 1).periods["x"], 2 * exact.pi)
    half = moved("x**2/2 + (1 + sign(x))", -1, 1)
    assert within(half.periods["x"], exact.pi)
    assert half.turning_points["x"][1].value == 0
    later = moved("x**2/2 + 5*(1 + sign(x - 1/2))", -1, 1)
    assert within(later.periods["x"], exact.pi + 2 * exact.asin(1 / (2 * exact.sqrt(2))))


def test_a_box_with_walls_of_finite_height() -> None:
    motion = moved(sp.Piecewise((10, x < -1), (10, x > 2), (0, True)), 0, 2)
    assert within(motion.periods["x"], 3)
    assert np.allclose(motion.at([0.5, 1.0, 1.25, 2.5]).q["x"], [1, 2, 1.5, -1], rtol=0, atol=1e-13)
    assert within(motion.actions["x"], 6 / exact.pi)


def test_kinks_at_two_zeros_of_a_polynomial() -> None:
    c = exact.sqrt(exact.mpf(5) / 2)
    inner = 4 * exact.quad(lambda u: 1 / exact.sqrt(2 * (exact.mpf(1) / 2 + u * u)), [0, 1])
    outer = 4 * exact.quad(lambda y: 2 / exact.sqrt(2 * (2 * c - y * y)), [0, exact.sqrt(c - 1)])
    assert within(moved("abs(x**2 - 1)", 0, 1).periods["x"], inner + outer)


@pytest.mark.parametrize("digits", [15, 30])
def test_escapes_through_kinks_and_from_walls(digits: int) -> None:
    down = moved("-abs(x)", 1, -2, digits)
    root = exact.sqrt(2)
    late = 1 - (2 - root)
    assert down.kinds == {"x": "escape"}
    cases = [
        (down, 1, -root * late - late**2 / 2),
        (moved("(1 + sign(x))/2", -1, 2, digits), 3, root * exact.mpf(5) / 2),
        (moved("4*(1 + sign(x))", -1, 2, digits), 3, exact.mpf(-5)),
        (moved("4*(1 + sign(x))", -1, 2, digits), -2, exact.mpf(-5)),
    ]
    for motion, t, truth in cases:
        state = motion.at(t)
        assert abs(exact.mpf(state.q["x"]) - truth) <= exact.mpf(state.error.q["x"]) < 1e-12
    assert within(cases[2][0].time_at("x", "-1/4"), exact.mpf(3) / 8)


def test_a_kink_in_one_of_two_coordinates_and_in_a_central_field() -> None:
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "abs(x) + y**2/2")
    motion = hjsolve.solve(system).motion(q={"x": 1, "y": 1}, velocity={"x": 0, "y": 0})
    state = motion.at(3)
    assert abs(state.q["x"] - float(-1 + (3 - 2 * exact.sqrt(2)) ** 2 / 2)) <= state.error.q["x"]
    assert abs(state.q["y"] - float(exact.cos(3))) <= state.error.q["y"] + 2e-16


def test_ensembles_go_through_kinks_with_the_right_statuses() -> None:
    system = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "F*abs(x)", {"m": 1, "F": 2})
    batch = hjsolve.ensemble(
        system,
        q={"x": np.array([1.0, -2.0, np.nan, 0.0])},
        p={"x": np.array([0.0, 1.0, 0.0, 0.0])},
        want={"frequencies"},
    )
    assert list(batch.status) == ["ok", "ok", "not_finite", "ok"]
    truth = [exact.pi / 2, 2 * exact.pi / (4 * exact.sqrt(2 * exact.mpf("4.5")) / 2)]
    for value, error, right in zip(batch.frequencies["x"], batch.error["frequencies"]["x"], truth, strict=False):
        assert abs(value - right) <= error < 1e-15


def test_hamilton_s_equations_have_the_force_of_both_sides() -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "F*abs(x)", {"F": 2})
    rate, energy = system.rhs(), system.hamiltonian_function()
    assert [rate(0.0, [place, 4.0])[1] for place in (-1.0, 1.0)] == [2, -2]
    assert energy([-1.0, 4.0]) == 10
    assert eval_repr(system) == system


def eval_repr(system: hjsolve.System) -> hjsolve.System:
    places = {c.name: c.domain.written(c.name) for c in system.coordinates}
    values = {p.name: p.value for p in system.parameters}
    return hjsolve.System(places, str(system.kinetic), "F*x*sign(x)", values)


def test_what_a_kink_does_not_determine_is_refused() -> None:
    for start in ((0, 0), (1, "-sqrt(2)")):
        with pytest.raises(NotConvergedError, match="not determined"):
            moved("-abs(x)", *start)
    assert moved("abs(x)", 0, 0).kinds == {"x": "equilibrium"}


def test_kinks_that_couple_coordinates_or_lie_elsewhere_are_refused_with_a_cure() -> None:
    T = "(dot(x)**2 + dot(y)**2)/2"
    with pytest.raises(InvalidSystemError, match="one coordinate"):
        hjsolve.System({"x": "line", "y": "line"}, T, "abs(x - y)")
    with pytest.raises(InvalidSystemError, match="jumps by a function of y"):
        hjsolve.separate(hjsolve.System({"x": "line", "y": "line"}, T, "sign(x)*y + x**2/2"))
    coupled = hjsolve.separate(hjsolve.System({"x": "line", "y": "line"}, T, "abs(x)*y"))
    assert isinstance(coupled, hjsolve.Obstruction)
    with pytest.raises(ExpressionError):
        hjsolve.System({"x": "line"}, "abs(x)*dot(x)**2/2", "x**2")
    with pytest.raises(InvalidSystemError, match="closed_forms"):
        hjsolve.closed_forms(hjsolve.System({"x": "line"}, "dot(x)**2/2", "abs(x)"))


def test_a_report_says_what_the_sign_in_v_stands_for(tmp_path: Path) -> None:
    """V = sign_x x stood there without a word."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "abs(x - 1)")
    text = " ".join(hjsolve.report(system, tmp_path / "kink.txt", brief=True).read_text(encoding="utf-8").split())
    assert "V has kinks or jumps where these signs change" in text
    assert "= sgn(x − 1)" in text


@pytest.mark.parametrize("digits", [15, 30])
def test_w_of_an_escape_that_is_expanded_again(digits: int) -> None:
    """W = x**(3/2) 2 sqrt(2)/3 of a body that falls from rest along V = -x; its series are summed in integers."""
    system = hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "-x")
    motion = hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": "sqrt(2)"}, digits=digits)
    for t in (1, 7):
        x_then = (1 + exact.mpf(t) / exact.sqrt(2)) ** 2
        assert within(motion.characteristic_function(t), 2 * exact.sqrt(2) / 3 * (x_then ** exact.mpf(1.5) - 1))
