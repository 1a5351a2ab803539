"""The kind of a motion that does not come back says what it does in the end, not what it came from."""

from __future__ import annotations

import pytest

from hjsolve import System, solve


def kind(domain: str, potential: str, x: object, velocity: object) -> str:
    motion = solve(System({"x": domain}, "dot(x)**2/2", potential)).motion(q={"x": x}, velocity={"x": velocity})
    assert bool(motion.boundary_times) == (motion.kinds["x"] == "boundary")
    return motion.kinds["x"]


@pytest.mark.parametrize(
    ("potential", "x", "velocity", "expected"),
    [
        ("-1/x", 1, 2, "escape"),  # thrown out of the centre for ever
        ("-1/x", 1, -2, "boundary"),
        ("-1/x", 1, 1, "boundary"),  # rises, turns, falls
        ("1/x", 1, -2, "escape"),
        ("x**3/3 - x", "1/2", "sqrt(2)*sqrt(2/3 + 11/24)", "boundary"),  # the energy of the maximum at x = -1
        ("-x**2/2", "1/2", "1/2", "escape"),  # away from the top of a barrier
        ("-x**2/2", "1/2", "-1/2", "asymptotic"),  # the domain ends at the top itself
    ],
)
def test_a_motion_has_the_kind_of_its_future(potential: str, x: object, velocity: object, expected: str) -> None:
    assert kind("0 < x", potential, x, velocity) == expected


def test_a_motion_that_leaves_the_top_of_a_barrier_escapes_and_one_that_climbs_it_is_asymptotic() -> None:
    assert kind("line", "1/cosh(x)**2", 1, "sqrt(2)*tanh(1)") == "escape"
    assert kind("line", "1/cosh(x)**2", -1, "sqrt(2)*tanh(1)") == "asymptotic"


def test_a_radial_orbit_thrown_outward_escapes_and_has_ended_before() -> None:
    plane = System({"r": "0 < r", "phi": "angle"}, "(dot(r)**2+r**2*dot(phi)**2)/2", "-1/r")
    motion = solve(plane).motion(q={"r": 1, "phi": 0}, velocity={"r": 2, "phi": 0})
    assert motion.kinds["r"] == "escape"
    assert motion.boundary_times == {}
    assert motion.at(-5.0).status == "reaches_boundary"
