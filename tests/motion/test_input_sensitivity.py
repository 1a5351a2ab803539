"""The doubt that rounded input brings is told apart from the error of the computation."""

from __future__ import annotations

import math

import pytest

import hjsolve


@pytest.fixture(scope="module")
def kepler():
    return hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


def test_exact_input_leaves_no_doubt(kepler):
    uncertainty = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}).input_sensitivity()
    assert all(value == 0 for numbers in uncertainty.values() for value in numbers.values())


def test_doubt_of_the_kepler_period_is_its_derivative_times_half_an_ulp(kepler):
    """T = 2π (2 − v²)^(−3/2): dT/dv = 6π v (2 − v²)^(−5/2)."""
    v = 1.2
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": v})
    expected = 6 * math.pi * v * (2 - v * v) ** -2.5 * math.ulp(v) / 2
    assert motion.input_sensitivity()["periods"]["r"] == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.nightly
def test_near_parabolic_period_is_in_far_more_doubt_than_its_error(kepler):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 1.41421356})
    period, uncertainty = motion.periods["r"], motion.input_sensitivity()["periods"]["r"]
    assert uncertainty > 1e5 * period.error
