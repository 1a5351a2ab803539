"""Certified numbers contain the truth, and are narrow: both, for a ball that says nothing contains everything."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve
from hjsolve import certified
from hjsolve.errors import InvalidInputError
from hjsolve.numeric import ball

pytest.importorskip("flint")


def pendulum(**arguments):
    """The pendulum with m = g = l = 1, through the lowest point with speed 2k."""
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    return solution.motion(q={"theta": 0}, parameters={"m": 1, "g": 1, "l": 1}, certified=True, **arguments)


def check(estimate, truth, digits):
    """The truth lies within the error, and the error is what was asked."""
    assert estimate.certified
    with mpmath.workdps(digits + 60):
        assert abs(mpmath.mpf(estimate.value) - truth) <= mpmath.mpf(estimate.error)
        assert 0 < estimate.error <= abs(truth) * mpmath.mpf(10) ** -min(digits, 15.5 if digits == 15 else digits)


@pytest.mark.parametrize("digits", [15, 50, 100])
@pytest.mark.parametrize("gap", ["0.9", "0.1", "1e-6", "1e-12"])
def test_certified_pendulum_period_and_action_contain_the_elliptic_closed_forms(digits, gap):
    motion = pendulum(velocity={"theta": f"2*(1-{gap})"}, digits=digits)
    with mpmath.workdps(2 * digits + 60):
        m = (1 - mpmath.mpf(gap)) ** 2
        K, E = mpmath.ellipk(m), mpmath.ellipe(m)
        check(motion.periods["theta"], 4 * K, digits)
        check(motion.actions["theta"], 8 / mpmath.pi * (E - (1 - m) * K), digits)
        check(motion.turning_points["theta"][1], 2 * mpmath.asin(mpmath.sqrt(m)), digits)


@pytest.mark.parametrize("excess", ["1", "1e-6", "1e-12"])
def test_certified_rotation_just_above_the_separatrix(excess):
    motion = pendulum(velocity={"theta": f"-2*(1+{excess})"}, digits=40)
    with mpmath.workdps(120):
        k = 1 + mpmath.mpf(excess)
        check(motion.periods["theta"], 2 * mpmath.ellipk(1 / k**2) / k, 40)
        assert motion.frequencies["theta"].value < 0


@pytest.mark.parametrize("speed", ["1.2", "1.000001", "1.4142"])
def test_certified_kepler_frequencies_are_equal_and_obey_the_third_law(speed):
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": speed}, digits=30, certified=True)
    with mpmath.workdps(100):
        E = mpmath.mpf(speed) ** 2 / 2 - 1
        check(motion.frequencies["r"], (-2 * E) ** mpmath.mpf("1.5"), 30)
        check(motion.frequencies["theta"], (-2 * E) ** mpmath.mpf("1.5"), 30)
        check(motion.actions["r"], 1 / mpmath.sqrt(-2 * E) - mpmath.mpf(speed), 24 if speed == "1.000001" else 30)


def test_two_certified_precisions_overlap_for_three_separated_coordinates():
    entry = hjsolve.catalog.describe("spherical-staeckel")
    solution = hjsolve.solve(entry.system)
    low, high = (solution.motion(**entry.initial.arguments, certified=True, digits=d) for d in (15, 40))
    for name, estimate in low.frequencies.items():
        better = high.frequencies[name]
        assert abs(mpmath.mpf(estimate.value) - better.value) <= estimate.error + better.error
        assert better.error < 1e-39 * abs(better.value)


def test_a_motion_that_escapes_is_refused_with_its_name():
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    with pytest.raises(InvalidInputError, match="r is in escape"):
        kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 2}, certified=True)


def swinging(gap):
    """The integrand of the pendulum's period in balls, and the half width of its strip of analyticity."""
    motion = pendulum(velocity={"theta": f"2*(1-{gap})"})
    with ball.working(200):
        inputs = [certified.exact_ball(v) for v in (*motion.initial.constants.values(), *certified._parameters(motion))]
        integrand = certified._integrand(motion, "theta", inputs, 200)
    amplitude = float(motion.turning_points["theta"][1].value)
    return integrand, mpmath.acosh(2 * mpmath.pi / amplitude - 1)


@pytest.mark.parametrize("gap", ["0.9", "0.1"])
@pytest.mark.parametrize("bits", [4, 12, 30])
def test_the_midpoint_rule_with_few_nodes_misses_by_no_more_than_its_bound(gap, bits):
    integrand, _ = swinging(gap)
    with ball.working(200), mpmath.workdps(60):
        found = ball._midpoints(integrand, 0, bits, ball.flint.arb(1))
        exact = 2 * mpmath.ellipk((1 - mpmath.mpf(gap)) ** 2) / mpmath.pi
        missed = abs(certified.to_mpf(found.mid(), 200) - exact)
        assert 0 < missed <= certified.to_mpf(found.rad(), 64)


def test_no_bound_is_given_on_a_strip_that_holds_a_singularity():
    integrand, width = swinging("0.1")
    with ball.working(200):
        assert ball._most(integrand, 0, float(0.3 * width)) is not None
        assert ball._most(integrand, 0, float(1.01 * width)) is None
