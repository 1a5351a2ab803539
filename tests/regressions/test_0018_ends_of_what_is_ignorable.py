"""A coordinate that T and V do not hold, but whose domain ends: the motion ends there and does not go on outside."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve


@pytest.mark.parametrize("digits", [15, 30])
def test_a_free_particle_stops_where_its_domain_does(digits: int) -> None:
    system = hjsolve.System({"x": "0 < x < 3", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "y**2/2")
    given = {"q": {"x": "0.7", "y": 0}, "velocity": {"x": "-0.3", "y": 1}}
    motion = hjsolve.solve(system).motion(**given, digits=digits)
    with mp.workdps(40):
        end = motion.boundary_times["x"]
        assert abs(mpf(end.value) - mpf(7) / 3) <= end.error <= mpf(10) ** (2 - digits)
    state = motion.at(["2.3", "2.4", "-7.6", "-7.7"])
    assert state.status.tolist() == ["ok", "reaches_boundary", "ok", "reaches_boundary"]
    if digits == 15:
        assert np.isnan(state.q["x"][[1, 3]]).all()
        np.testing.assert_allclose(state.q["x"][[0, 2]], [0.01, 2.98], rtol=1e-12)


def test_an_orbit_ends_at_the_edge_of_a_half_plane() -> None:
    """Kepler's ellipse from its pericentre: θ goes from 2 to π in the time of Kepler's equation."""
    system = hjsolve.System(
        {"r": "0 < r", "theta": "0 < theta < pi"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "-1/r"
    )  # fmt: skip
    motion = hjsolve.solve(system).motion(q={"r": 1, "theta": 2}, velocity={"r": 0, "theta": "1.1"})
    assert motion.kinds == {"r": "libration", "theta": "boundary"}
    found = motion.boundary_times["theta"]
    with mp.workdps(30):
        e = mpf("1.21") - 1
        a = 1 / (1 - e)
        E = 2 * mp.atan(mp.sqrt((1 - e) / (1 + e)) * mp.tan((mp.pi - 2) / 2))
        truth = a ** mpf("1.5") * (E - e * mp.sin(E))
        assert abs(mpf(found.value) - truth) <= found.error <= 1e-13


def test_it_stays_ignorable_where_the_reduction_needs_it() -> None:
    """A block under a pendulum on a rail that begins somewhere: T ties the two, so x has to be eliminated."""
    system = hjsolve.System(
        {"x": "0 < x", "theta": "angle"}, "dot(x)**2 + dot(x)*dot(theta)*cos(theta) + dot(theta)**2/2", "-cos(theta)"
    )
    assert hjsolve.solve(system).coordinates == ("theta",)
