"""Coordinates of systems with letters, and of systems given in cylindrical coordinates."""

from __future__ import annotations

from math import cos, hypot, sin

import pytest

from hjsolve import NotSeparableError, System, find_coordinates, solve

pytestmark = pytest.mark.rotating_file(4)

_KUZMIN = "-GM/sqrt({}+z**2+a**2+c**2+2*sqrt(a**2*c**2+c**2*{}+a**2*z**2))"
_LETTERS = {"GM": 1, "a": 1, "c": "1/2"}
_SPACE = {"x": "line", "y": "line", "z": "line"}
_T3 = "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"


def test_a_galaxy_with_letters_in_cylindrical_coordinates_moves_as_in_x_y_z() -> None:
    square = "(x**2+y**2)"
    flat = System(_SPACE, _T3, _KUZMIN.format(square, square), _LETTERS)
    round_ = System(
        {"R": "0 < R", "phi": "angle", "z": "line"}, "(dot(R)**2 + R**2*dot(phi)**2 + dot(z)**2)/2",
        _KUZMIN.format("R**2", "R**2"), _LETTERS,
    )  # fmt: skip
    found = solve(round_, "find")
    assert found.chart is not None
    assert found.chart.kind == "prolate spheroidal"
    start = {"R": 1.2, "phi": 0.5, "z": 0.3}
    a = found.motion(q=start, velocity={"R": 0.1, "phi": 0.48, "z": 0.2}, velocity_frame="orthonormal").at(3)
    c, s = cos(0.5), sin(0.5)
    b = solve(flat, "find").motion(
        q={"x": 1.2 * c, "y": 1.2 * s, "z": 0.3}, velocity={"x": 0.1 * c - 0.48 * s, "y": 0.1 * s + 0.48 * c, "z": 0.2}
    ).at(3)  # fmt: skip
    assert abs(a.q["R"] - hypot(b.q["x"], b.q["y"])) < 1e-13
    assert abs(a.q["z"] - b.q["z"]) < 1e-13


def test_a_refusal_with_letters_names_the_values_at_which_the_system_separates() -> None:
    system = System(
        {"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "(A*x**2 + B*y**2)/2 + x**2*y + C*y**3",
        {"A": 1, "B": 1, "C": "1/3"},
    )  # fmt: skip
    with pytest.raises(NotSeparableError, match=r"at A = 1, B = 1, C = 1/3 it separates in cartesian coordinates"):
        solve(system, "find")


def test_what_a_budget_does_not_decide_is_said() -> None:
    found = find_coordinates(System(_SPACE, _T3, "-m/sqrt(x**2+y**2+(z-d)**2)", {"m": 1, "d": 1}), budget=0)
    assert found.undecided.startswith("Not decided in 0 s")
    assert not found.complete
