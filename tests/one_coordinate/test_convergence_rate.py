"""The midpoint rule over the anomaly converges at the geometric rate that the nearest singularity allows."""

from __future__ import annotations

import math

import mpmath
import pytest

import hjsolve
from hjsolve.arithmetic.floats import Multi
from hjsolve.one_coordinate.anomaly import libration_anomaly
from hjsolve.one_coordinate.coordinate_motion import PARTS
from hjsolve.one_coordinate.cycle_integrals import integrands
from hjsolve.one_coordinate.fourier_series import fit, midpoints


def swinging(amplitude):
    """The pendulum with m = g = l = 1, released at an amplitude."""
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    return solution.motion(q={"theta": amplitude}, velocity={"theta": 0}, parameters={"m": 1, "g": 1, "l": 1})


def period_error(motion, nodes, below=None, above=None):
    """Relative error of the period with a given number of midpoints, against the elliptic integral, at 100 digits."""
    bits, arithmetic = 400, Multi(400)
    coordinate_motion, place = motion.separated.located["theta"].coordinate_motion, motion.separated.located["theta"]
    a, b = place.lower.place(bits), place.upper.place(bits)
    anomaly = libration_anomaly(
        a, b, None if below is None else below(a, b), None if above is None else above(a, b), arithmetic
    )
    values = integrands(coordinate_motion.radicand, (False,), bits, PARTS)
    rows = [values(anomaly.place(χ, arithmetic)) for χ in midpoints(nodes, even=True, bits=bits)]
    mean = fit(rows, even=True, bits=bits)[0].mean
    with mpmath.workdps(110):
        exact = 2 * mpmath.ellipk(mpmath.sin(mpmath.mpf(b) / 2) ** 2) / mpmath.pi
        return abs(mpmath.mpf(mean) / exact - 1)


@pytest.mark.parametrize("amplitude", ["pi/2", "2", "1"])
def test_error_falls_like_the_distance_of_the_next_turning_point_says(amplitude):
    """p² vanishes next at 2π − A, where A cos χ = −(2π − A): |Im χ| = arcosh(2π/A − 1), error ~ e^(−2n |Im χ|)."""
    motion = swinging(amplitude)
    A = float(motion.turning_points["theta"][1].value)
    errors = {n: period_error(motion, n) for n in (6, 14)}
    rate = float(mpmath.log(errors[6] / errors[14])) / 8
    assert rate == pytest.approx(2 * math.acosh(2 * math.pi / A - 1), rel=0.06)


def test_elliptic_anomaly_converges_faster_near_the_separatrix():
    motion = swinging("3.1")
    plain = period_error(motion, 24)
    turn = 2 * mpmath.pi
    mapped = period_error(motion, 24, below=lambda a, b: b - turn, above=lambda a, b: a + turn)
    assert plain > 1e-6
    assert mapped < 1e-12


def test_at_most_30_nodes_for_the_pendulum_at_ninety_degrees():
    """24 are enough; 30 are proved to be."""
    motion = swinging("pi/2")
    assert 0 < motion.nodes <= 30
    exact = float(4 * mpmath.ellipk(mpmath.mpf(1) / 2))
    assert abs(motion.periods["theta"].value / exact - 1) <= 2.3e-16


@pytest.mark.parametrize(("gap", "most"), [("0.9", 16), ("0.1", 48), ("1e-6", 120), ("1e-12", 190)])
def test_nodes_grow_with_the_logarithm_of_the_distance_to_the_separatrix(gap, most):
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    motion = solution.motion(q={"theta": 0}, velocity={"theta": f"2*(1-{gap})"}, parameters={"m": 1, "g": 1, "l": 1})
    assert motion.nodes <= most
    with mpmath.workdps(60):
        exact = 4 * mpmath.ellipk((1 - mpmath.mpf(gap)) ** 2)
        assert abs(mpmath.mpf(motion.periods["theta"].value) / exact - 1) <= 2.3e-16
