"""Orbits in the equatorial plane of a Stäckel galaxy, in found coordinates: against the same orbit as a central motion."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.motion.exact_numbers import number_is_zero

TIMES = [0.5, 9, 200]


@pytest.mark.nightly
def test_an_orbit_in_the_equatorial_plane():
    """The polynomial in ν has integers of hundreds of digits, which sympy's zero test tried to factor."""
    galaxy = hjsolve.System(
        {"R": "0 < R", "phi": "angle", "z": "line"},
        "(R'^2 + R^2*phi'^2 + z'^2)/2",
        "-GM/sqrt(R^2 + z^2 + a^2 + c^2 + 2*sqrt(a^2*c^2 + c^2*R^2 + a^2*z^2))",
        {"GM": 1, "a": "1.5", "c": 1},
    )
    q, velocity = {"R": 1, "phi": 0, "z": 0}, {"R": "0.1", "phi": "0.3", "z": 0}
    state = hjsolve.solve(galaxy, coordinates="find").motion(q=q, velocity=velocity).at(TIMES)
    plane = hjsolve.System(
        {"R": "0 < R", "phi": "angle"}, "(R'^2 + R^2*phi'^2)/2", "-1/(sqrt(R^2 + a^2) + 1)", {"a": "1.5"}
    )
    central = hjsolve.solve(plane).motion(q={"R": 1, "phi": 0}, velocity={"R": "0.1", "phi": "0.3"}).at(TIMES)
    for name in ("R", "phi"):
        off, claimed = np.abs(state.q[name] - central.q[name]), state.error.q[name] + central.error.q[name]
        assert np.all(off <= claimed)
        assert np.all(claimed < 1e-11)
    assert np.all(np.abs(state.q["z"]) <= state.error.q["z"])


def test_a_number_of_long_integers_is_zero_or_not():
    """n (√(3 + 2√2) − 1 − √2) = 0, with n of 401 digits, and the same with a last digit far behind the point."""
    long = sp.Integer(10) ** 400 + 7
    nested = sp.Add(long * sp.sqrt(3 + 2 * sp.sqrt(2)), -long, -long * sp.sqrt(2), evaluate=False)
    assert number_is_zero(nested)
    assert not number_is_zero(nested + sp.Rational(1, 10**900))
