"""Ends of a domain that an angle never sees the end of, and motions too far out for doubles."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from tests.support.ending_at_poles import ending_at_poles


def test_a_fall_into_the_centre_ends_in_time_while_the_angle_winds_for_ever():
    """V = −b/(2r²) with L² < b: r² = r₀² + 2 r₀ v t + 2 E t², and θ grows like the logarithm of the time left."""
    system = hjsolve.System(
        {"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "-b/(2*r**2)", {"b": 2}
    )
    motion = hjsolve.solve(system).motion(q={"r": 1, "theta": 0}, velocity={"r": "-0.3", "theta": 1})
    assert motion.kinds["r"] == "boundary"
    with mp.workdps(40):
        v = mp.mpf(-3) / 10
        twice = v**2 + 1 - 2  # 2E
        end = (-2 * v - mp.sqrt(4 * v**2 - 4 * twice)) / (2 * twice)
        found = motion.boundary_times["r"]
        assert abs(mp.mpf(found.value) - end) <= found.error <= 1e-13
        for fraction in (0.5, 0.999, 0.9999999):
            t = fraction * found.value
            state = motion.at(t)
            r = mp.sqrt(1 + 2 * v * mp.mpf(t) + twice * mp.mpf(t) ** 2)
            θ = mp.quad(lambda s: 1 / (1 + 2 * v * s + twice * s * s), mp.linspace(0, mp.mpf(t), 9))
            assert abs(mp.mpf(state.q["r"]) - r) <= state.error.q["r"]
            assert abs(mp.mpf(state.unwrapped("theta")) - θ) <= state.error.q["theta"] <= 1e-6
    assert motion.at(1.01 * found.value).status == "reaches_boundary"


def test_an_end_of_the_domain_that_no_time_suffices_for_is_asymptotic():
    """T = ½ (q̇/q)²: q = e^(−t)."""
    system = hjsolve.System({"q": "0 < q"}, "dot(q)**2/(2*q**2)", "0*q")
    motion = hjsolve.solve(system).motion(q={"q": 1}, velocity={"q": -1})
    assert motion.kinds["q"] == "asymptotic"
    state = motion.at(np.array([0.3, 20.0]))
    with mp.workdps(30):
        for k, t in enumerate((0.3, 20.0)):
            assert abs(mp.mpf(state.q["q"][k]) - mp.exp(-mp.mpf(t))) <= state.error.q["q"][k]


@pytest.mark.nightly
def test_too_far_out_is_not_an_end():
    """x = e^t passes 10³⁰⁰ at t = 691."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "-x**2/2")
    motion = hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": 1})
    state = motion.at(np.concatenate([np.linspace(0, 600, 4000), [1000.0]]))
    assert list(state.status[[0, -1]]) == ["ok", "not_converged"]
    assert np.isnan(state.q["x"][-1])


def test_past_its_end_a_motion_in_many_digits_says_so_too():
    """Newton's method in 30 digits was asked for phases that are not there."""
    system = hjsolve.System({"r": "0 < r"}, "dot(r)**2/2", "r")
    motion = hjsolve.solve(system).motion(q={"r": 1}, velocity={"r": 0}, digits=30)
    state = motion.at(["1/2", 2])  # r = 1 − t²/2
    assert list(state.status) == ["ok", "reaches_boundary"]
    assert abs(state.q["r"][0] - mp.mpf(7) / 8) <= state.error.q["r"][0] <= mp.mpf("1e-28")
    assert mp.isnan(state.q["r"][1])


def test_an_end_that_is_not_reached_before_infinity_has_no_time():
    """A free particle on a line through no pole: θ runs towards one, and gets only π/2 on from where it is nearest."""
    solution = hjsolve.solve(hjsolve.catalog.load("free-particle-spherical"))
    motion = ending_at_poles(
        solution, q={"r": 1, "theta": "1.3", "phi": 0}, velocity={"r": "0.3", "theta": "0.1", "phi": 0}
    )
    assert motion.kinds["theta"] == "boundary"
    assert motion.boundary_times == {}
    away = motion.at(1e9)
    assert away.status == "ok"
    assert 1.3 < away.q["theta"] < np.pi / 2 + 1.3
