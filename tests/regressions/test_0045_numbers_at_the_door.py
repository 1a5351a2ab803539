"""Extreme places, odd arrays of times, and steep functions that overflowed: an answer or one clear error."""

import math

import mpmath
import numpy as np
import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)

KEPLER = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


def on_a_line(potential):
    return hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", potential))


@pytest.mark.parametrize("r", ["1e-200", "1e-300", "5e-324"])
def test_times_beyond_doubles_are_refused_in_one_line(r):
    start = {"q": {"r": r, "theta": 0}, "p": {"r": 0, "theta": 1}}
    with pytest.raises(hjsolve.NotConvergedError, match="beyond doubles"):
        KEPLER.motion(**start)
    ends = KEPLER.motion(**start, want=["turning_points"]).turning_points["r"]
    assert abs(ends[0].value - float(r)) <= ends[0].error


@pytest.mark.nightly_cases("1e60")
@pytest.mark.parametrize("r", ["1e20", "1e60"])
def test_a_fall_from_far_away_turns_at_its_perihelion(r):
    """It was said to reach the centre, from 1e150 on."""
    motion = KEPLER.motion(q={"r": r, "theta": 0}, p={"r": 0, "theta": 1}, want=["kinds", "periods", "turning_points"])
    with mpmath.workdps(400):
        E = 1 / (2 * mpmath.mpf(r) ** 2) - 1 / mpmath.mpf(r)
        period = 2 * mpmath.pi / (-2 * E) ** mpmath.mpf(1.5)
        assert abs(motion.periods["r"].value - period) <= motion.periods["r"].error
    assert motion.kinds["r"] == "libration"


def test_where_a_turning_point_is_too_near_an_end_it_is_said():
    with pytest.raises(hjsolve.NotConvergedError, match=r"powers of two nearer to an end of its domain"):
        KEPLER.motion(q={"r": "1e300", "theta": 0}, p={"r": 0, "theta": 1})


MOTION = KEPLER.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": "1.1"})


@pytest.mark.parametrize("door", [MOTION.at, MOTION.angles])
@pytest.mark.parametrize(
    ("times", "says"),
    [
        ([[1, 2], [3]], "rows of this one have different lengths"),
        (np.ma.array([1.0, 2.0], mask=[False, True]), "masked"),
        ({1, 2}, "a number or an array of numbers is needed"),
        ((t for t in (1, 2)), "a number or an array of numbers is needed"),
        (1e20, "more than 2\\*\\*60 turns"),
        (1e300, "beyond 1e\\+290"),
    ],
)
def test_times_that_are_none_are_refused_in_one_line(door, times, says):
    with pytest.raises(hjsolve.InvalidInputError, match=says):
        door(times)


def test_a_time_of_too_many_turns_is_refused_with_many_digits_too():
    motion = KEPLER.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": "1.1"}, digits=20)
    for time in ("1e25", "1e400"):
        with pytest.raises(hjsolve.InvalidInputError):
            motion.at(time)


def test_empty_times_give_empty_states():
    linear = hjsolve.from_hamiltonian("q + p", {"q": "line"}).motion(q={"q": 1}, p={"q": 1})
    for motion, name in ((MOTION, "r"), (linear, "q")):
        assert motion.at(np.zeros((0, 3))).q[name].shape == (0, 3)


def test_a_steep_step_inside_is_worked_out_as_it_is_written():
    """Addition theorems made sinh(768)·sinh(…) − cosh(768)·cosh(…) of its denominator, which was zero in any digits."""
    motion = on_a_line("1-cos(x) - 0.165*tanh((x-0.045303)/5.9e-05)").motion(
        q={"x": "0.5"}, velocity={"x": "0.9"}, want=["turning_points"]
    )
    low, high = (end.value for end in motion.turning_points["x"])
    E = 0.405 + 1 - math.cos(0.5) - 0.165
    assert high == pytest.approx(math.acos(1 - E - 0.165), rel=1e-14)
    assert low == pytest.approx(-math.acos(1 - E + 0.165), rel=1e-14)


@pytest.mark.nightly_cases("1000000", "10000")
@pytest.mark.parametrize("scale", [10, 10**4, 10**6])
def test_a_sum_of_steep_functions_stays_a_sum(scale):
    potential = f"tanh({scale}*(x-1/3)) + exp({scale}*(y-1/7))/(1+exp({scale}*(y-1/7))) + 1/cosh({scale}*(x+1/5))**2"
    system = hjsolve.System({"x": "line", "y": "line"}, "dot(x)**2/2+dot(y)**2/2", potential)
    solution = hjsolve.solve(system)
    motion = solution.motion(q={"x": 1, "y": 1}, velocity={"x": 2, "y": 1}, want=["constants"])
    s = mpmath.mpf(scale)
    E = 2.5 + mpmath.tanh(2 * s / 3) + 1 / (1 + mpmath.exp(-6 * s / 7)) + mpmath.sech(6 * s / 5) ** 2
    assert motion.constants["E"].value == pytest.approx(float(E), rel=1e-15)
    x, y = (system.coordinate(name).symbol for name in "xy")
    assert solution.momentum_squared["x"].free_symbols.isdisjoint({y})
    assert solution.momentum_squared["y"].free_symbols.isdisjoint({x})


@pytest.mark.nightly
def test_an_exponential_of_an_exponential_far_out_does_not_take_for_ever():
    motion = on_a_line("exp(-exp(x))").motion(q={"x": 0}, velocity={"x": 1})
    low = motion.turning_points["x"][0]
    true = math.log(-math.log(0.5 + math.exp(-1)))
    assert abs(low.value - true) <= low.error + 1e-15


def test_a_pole_in_the_way_is_said_to_be_one():
    for potential in ("-1/x", "-1/x**2", "log(x**2)"):
        with pytest.raises(hjsolve.HJSolveError, match=r"pole|divides by zero"):
            on_a_line(potential).motion(q={"x": 1}, velocity={"x": -1})


def test_an_orbit_too_far_out_is_not_said_to_divide_by_zero():
    """The perihelion was hit at r = 0 by rounding, and an ensemble said `outside_domain`."""
    with pytest.raises(hjsolve.NotConvergedError, match="powers of two nearer to an end of its domain"):
        KEPLER.motion(q={"r": "1e300", "theta": 0}, p={"r": 0, "theta": 1}, want=["actions"])
    found = hjsolve.ensemble(KEPLER, {"r": [1e300], "theta": 0}, {"r": 0.0, "theta": 1.0}, want={"actions"})
    assert found.status.item() == "not_converged"
