"""Angle variables carry errors that hold, in the digits of the motion: against the same motion with at least 30 digits more."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from tests.support import entries

KEPLER = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}
TIMES = [0.0, 0.7, -13.25, 1234.5, 1e9]


def gap(one, other):
    """Distance of two angles modulo 2π."""
    with mp.workdps(90):
        difference = mp.mpf(one) - mp.mpf(other)
        return abs(difference - 2 * mp.pi * mp.nint(difference / (2 * mp.pi)))


def held(motion, better):
    found, truth = motion.angles(TIMES), better.angles(TIMES)
    assert set(found) == set(motion.frequencies)
    for name in found:
        for angle, true, error in zip(found[name], truth[name], found.error[name], strict=True):
            assert gap(angle, true) <= error, (name, angle, error)
            assert error <= 10.0 ** (3 - motion.digits)


@pytest.mark.nightly
@pytest.mark.parametrize("name", entries.separable_with_effects())
def test_errors_of_angles_hold_against_50_digits(name):
    given = {k: v for k, v in entries.given(name).items() if k != "digits"}
    solution = entries.solved(name)
    motion = solution.motion(**given)
    if motion.frequencies:
        held(motion, solution.motion(**given, digits=50))


@pytest.mark.parametrize("name", ["kepler-planar", "pendulum", "dumbbell-in-plane"])
def test_angles_have_the_digits_of_the_motion(name):
    given = entries.described(name).motions["default"].arguments
    solution = entries.solved(name)
    better = solution.motion(**given, digits=60)
    held(solution.motion(**given), better)
    held(solution.motion(**given, digits=30), better)


def test_the_angle_of_a_frequency_that_vanishes_has_one_sign_at_any_precision():
    """Its sign was that of the rounding of Ω = 0: with 45 digits the opposite of that with 30."""
    solution = entries.solved("charge-in-monopole-field+micz")
    given = entries.described("charge-in-monopole-field").motions["default"].arguments
    few, many = (solution.motion(**given, digits=digits).angles(0.7) for digits in (15, 45))
    assert gap(few["phi"], many["phi"]) <= few.error["phi"]


def test_angles_are_floats_and_arrays_as_before_and_a_mapping_with_errors():
    motion = hjsolve.solve("kepler-planar").motion(**KEPLER)
    one, several = motion.angles("0.5"), motion.angles(np.array([[0.5, 1.0]]))
    assert isinstance(one["r"], float)
    assert dict(one) == dict(one.value)
    assert isinstance(one.error["r"], float)
    assert several["r"].shape == several.error["r"].shape == (1, 2)
    assert several["r"][0, 0] == one["r"]
    assert one == motion.angles("0.5")


@pytest.mark.parametrize("digits", [15, 40])
@pytest.mark.parametrize("t", ["0", "7/10", "-1234567/100"])
def test_a_coordinate_that_comes_back_has_its_angle_while_another_one_escapes(digits, t):
    """x = −A cos θ with θ = θ₀ + √2 t, in closed form."""
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2 - y")
    motion = hjsolve.solve(system).motion(q={"x": "1/3", "y": 0}, velocity={"x": 1, "y": 1}, digits=digits)
    angles = motion.angles(t)
    assert set(angles) == set(motion.frequencies) == {"x"}
    with mp.workdps(80):
        rate = mp.sqrt(2)
        truth = mp.atan2(1 / rate, mp.mpf(-1) / 3) + rate * (mp.mpf(t.split("/")[0]) / int(t.partition("/")[2] or 1))
    assert gap(angles["x"], truth) <= angles.error["x"] <= 10.0 ** (3 - digits)
