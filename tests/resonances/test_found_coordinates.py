"""Tori and separatrices of systems that separate in coordinates found for them, expressed in the user's."""

import pickle

import pytest

import hjsolve
from hjsolve import System
from hjsolve.errors import InvalidInputError

PLANE = {"x": "line", "y": "line"}
KINETIC = "(dot(x)**2 + dot(y)**2)/2"


@pytest.fixture(scope="module")
def isochrone():
    return hjsolve.solve(System(PLANE, KINETIC, "-1/(1 + sqrt(1 + x**2 + y**2))"), coordinates="find")


@pytest.mark.nightly  # a family is looked through: 12 s
def test_a_resonant_torus_is_a_closed_orbit_in_x_and_y(isochrone):
    motion = isochrone.torus(ratio={"r": 3, "theta": 2}, fixed={"E": "-1/5"}, digits=20)
    closed = 3 * motion.periods["r"].value
    for t in (0, 2):
        now, later = motion.at(t), motion.at(closed + t)
        for axis in "xy":
            assert abs(now.q[axis] - later.q[axis]) < 1e-17
    state = pickle.loads(pickle.dumps(motion)).at(2)
    r2 = state.q["x"] ** 2 + state.q["y"] ** 2
    energy = (state.p["x"] ** 2 + state.p["y"] ** 2) / 2 - 1 / (1 + (1 + r2) ** 0.5)
    assert abs(energy + 0.2) < 1e-15
    assert abs(motion.as_solved.at(2).q["r"] ** 2 - r2) < 1e-17


def test_constants_and_a_place_of_the_coordinates_that_were_found(isochrone):
    given = isochrone.motion(q={"x": 1, "y": "1/2"}, velocity={"x": "1/10", "y": "2/5"}, digits=30)
    begin, constants = given.as_solved.at(0), {name: x.value for name, x in given.constants.items()}
    assert begin.p["r"] > 0
    place = {name: begin.q[name] for name in ("r", "theta")}
    again = isochrone.motion(q=place, constants=constants, signs={"r": 1}, digits=30)
    for axis in "xy":
        assert abs(again.at("2.5").q[axis] - given.at("2.5").q[axis]) < 1e-26


def test_places_of_the_user_do_not_go_with_constants(isochrone):
    with pytest.raises(InvalidInputError, match="so is q: r, theta"):
        isochrone.motion(q={"x": 1, "y": 0}, constants={"E": "-1/5", "p_theta": "1/2"})


def test_separatrices_about_two_centres_typed_in_x_and_y():
    # where p^2 of a coordinate and its slope vanish together, by the formula that the solution shows
    potential = "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)"
    solution = hjsolve.solve(System(PLANE, KINETIC, potential), coordinates="find")
    found = solution.separatrices(fixed={"E": -1})
    assert [(one.coordinate, round(one.value.value, 12)) for one in found] == [("nu", 1.25), ("nu", 1.25), ("mu", 3.0)]
    for one in found:
        F = solution.momentum_squared[one.coordinate]
        q = solution.system.coordinate(one.coordinate).symbol
        constants = {solution.constants["E"].symbol: -1, solution.constants[one.unknown].symbol: one.value.value}
        for formula in (F, F.diff(q)):
            assert abs(formula.subs(constants).subs(q, one.place.value)) < 1e-13
