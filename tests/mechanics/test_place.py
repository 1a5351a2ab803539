"""Where a system is in space: read at the door, and told by every state with its error."""

from __future__ import annotations

import pickle

import pytest
import sympy as sp

import hjsolve
from hjsolve.errors import ExpressionError, InvalidInputError, InvalidSystemError

T, V = "(dot(r)**2 + r**2*dot(phi)**2)/2", "-1/r"
POLAR = {"r": "0 < r", "phi": "angle"}
PLACE = {"x": "r*cos(phi)", "y": "r*sin(phi)"}
TWO = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)"


@pytest.mark.parametrize(
    ("place", "error", "says"),
    [
        ({"w": "r"}, InvalidSystemError, "is not an axis"),
        ({"x": "r*cos(ph)"}, ExpressionError, "did you mean phi"),
        ({"x": "r*phi"}, InvalidSystemError, "not 2.pi-periodic in phi"),
        ({"x": "sqrt(-r)"}, ExpressionError, "real"),
        ({"x": "sqrt(1 - r)"}, InvalidSystemError, "no real value at r"),
        ({"x": "dot(r)"}, ExpressionError, "velocity"),
        (["x"], InvalidInputError, "a table"),
    ],
)
def test_a_place_that_is_none_is_refused_at_the_door(place: object, error: type, says: str) -> None:
    with pytest.raises(error, match=says):
        hjsolve.System(POLAR, T, V, place=place)


def test_states_say_where_they_are_and_how_well_it_is_known() -> None:
    """Kepler's orbit in x and y: against the same motion with the equations of x and y, 30 digits."""
    start = {"r": 1, "phi": "0.3"}, {"r": "0.1", "phi": "1.1"}
    solution = hjsolve.solve(hjsolve.System(POLAR, T, V, place=PLACE))
    state = solution.motion(q=start[0], velocity=start[1]).at([0, 1, "7.3"])
    exact = solution.motion(q=start[0], velocity=start[1], digits=40).at([0, 1, "7.3"])
    for k in range(3):
        r, φ = exact.q["r"][k], exact.q["phi"][k]
        for axis, true in (("x", r * r.context.cos(φ)), ("y", r * r.context.sin(φ))):
            off = abs(float(true - state.place[axis][k]))
            assert off <= state.error.place[axis][k] < 1e-12
            assert abs(true - exact.place[axis][k]) <= exact.error.place[axis][k] < 1e-30


def test_coordinates_called_x_and_y_are_a_place() -> None:
    system = hjsolve.System({"y": "line", "x": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2 + y**4")
    assert list(system.place) == ["x", "y"]
    state = hjsolve.solve(system).motion(q={"x": 1, "y": "0.5"}, velocity={"x": 0, "y": 0}).at(2)
    assert (state.place["x"], state.place["y"]) == (state.q["x"], state.q["y"])


def test_without_a_place_it_is_said_what_to_write() -> None:
    state = hjsolve.solve(hjsolve.System(POLAR, T, V)).motion(q={"r": 1, "phi": 0}, velocity={"r": 0, "phi": 1}).at(1)
    with pytest.raises(InvalidInputError, match="place="):
        _ = state.place
    assert state.error.place == {}


def test_a_web_that_was_found_knows_its_place() -> None:
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", TWO)
    solution = hjsolve.solve(system, coordinates="find")
    mu, nu = (solution.system.symbols[name] for name in ("mu", "nu"))
    assert solution.system.place["x"].has(sp.cosh(mu), sp.cos(nu))
    motion = solution.motion(q={"x": "0.3", "y": "0.4"}, velocity={"x": 0, "y": "0.1"})
    there, here = motion.as_solved.at(3), motion.at(3)
    for axis in "xy":
        assert abs(there.place[axis] - here.q[axis]) <= there.error.place[axis] + here.error.q[axis]
        assert here.place[axis] == here.q[axis]


def test_a_motion_through_a_pole_is_where_it_is() -> None:
    """A polar orbit of Kepler's problem stays in its plane, y = 0, and x changes its sign at the pole."""
    motion = hjsolve.solve("kepler-spherical").motion(
        q={"r": 1, "theta": "pi/2", "phi": 0}, velocity={"r": 0, "theta": "1.1", "phi": 0}
    )
    state = motion.at([0, 2, 4])
    assert state.place["x"][0] == 1
    assert state.place["x"][2] < 0
    assert max(abs(y) for y in state.place["y"]) <= max(state.error.place["y"])


def test_a_state_pickles_with_its_place_and_a_system_with_one_can_be_written_again() -> None:
    system = hjsolve.System(POLAR, T, V, place=PLACE)
    state = hjsolve.solve(system).motion(q={"r": 1, "phi": 0}, velocity={"r": 0, "phi": 1.2}).at(1)
    again = pickle.loads(pickle.dumps(state))
    assert again.place == state.place
    assert again.error.place == state.error.place
    assert eval(repr(system), {"System": hjsolve.System}) == system
