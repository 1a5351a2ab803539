"""Certified numbers contain the truth, and are narrow: both, for a ball that says nothing contains everything."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction

import mpmath
import pytest

import hjsolve
from hjsolve.arithmetic import ball
from hjsolve.arithmetic.work_counter import counted
from hjsolve.certified import strip_bound
from hjsolve.certified.integrands import AnomalyMap
from hjsolve.errors import InvalidInputError
from hjsolve.motion import certified

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
    with counted() as work:
        motion = pendulum(velocity={"theta": f"-2*(1+{excess})"}, digits=40)
    with mpmath.workdps(120):
        k = 1 + mpmath.mpf(excess)
        check(motion.periods["theta"], 2 * mpmath.ellipk(1 / k**2) / k, 40)
        assert motion.frequencies["theta"].value < 0
    assert work.kernels < 1000  # the adaptive quadrature takes 5600 at 1e-12


@pytest.mark.parametrize("speed", ["1.2", "1.000001", "1.4142"])
def test_certified_kepler_frequencies_are_equal_and_obey_the_third_law(speed):
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": speed}, digits=30, certified=True)
    with mpmath.workdps(100):
        E = mpmath.mpf(speed) ** 2 / 2 - 1
        check(motion.frequencies["r"], (-2 * E) ** mpmath.mpf("1.5"), 30)
        check(motion.frequencies["theta"], (-2 * E) ** mpmath.mpf("1.5"), 30)
        check(motion.actions["r"], 1 / mpmath.sqrt(-2 * E) - mpmath.mpf(speed), 24 if speed == "1.000001" else 30)


@pytest.mark.parametrize("digits", [15, 40])
@pytest.mark.parametrize(("m", "n"), [(12, 0), (6, 0), (0, 1), (0, 5), (0, 12)])
def test_certified_kepler_from_nearly_circular_to_nearly_radial(m, n, digits):
    """e = 10⁻ᵐ − 10⁻ⁿ: so small that p² in doubles is all rounding, or with the pole of p² next to a turning point."""
    e = Fraction(10) ** -m - (Fraction(10) ** -n if n else 0)
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    with counted() as work:
        motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": f"sqrt({1 + e})"}, digits=digits,
                               certified=True)  # fmt: skip
    with mpmath.workdps(digits + 80):
        exact = mpmath.mpf(e.numerator) / e.denominator
        a, L = 1 / (1 - exact), mpmath.sqrt(1 + exact)
        check(motion.periods["r"], 2 * mpmath.pi * mpmath.sqrt(a) ** 3, digits)
        check(motion.actions["r"], mpmath.sqrt(a) - L, digits)
    assert work.kernels < 60 * digits  # thousands where the quadrature has to be adaptive


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


def cycle(name, motion, map_=None, bits=200):
    """The integrands of one coordinate of a certified motion, in balls."""
    radicands = {name: motion.separated.located[name].coordinate_motion.radicand}
    line = certified.lines(radicands, motion.initial, motion.solution, bits)[name]
    with ball.working(bits):
        made = certified.cycle_of(motion.separated, name, line)
        return made if map_ is None else made.over(map_)


def swinging(gap, map_=None):
    """The integrand of the pendulum's period in balls, and the half width of its strip of analyticity (plain map)."""
    motion = pendulum(velocity={"theta": f"2*(1-{gap})"}, want=["periods"])
    amplitude = float(motion.turning_points["theta"][1].value)
    return cycle("theta", motion, map_), float(mpmath.acosh(2 * mpmath.pi / amplitude - 1))


SPREAD = AnomalyMap(7.65, 7.65)
"""The map for 1 − k = 1e-12; there the integrand has poles where q = ∞, at √½ π/κ in the middle of the motion."""


@pytest.mark.parametrize(("gap", "map_", "width"), [
    ("0.9", AnomalyMap(), 2.0), ("0.1", AnomalyMap(), 0.9), ("0.1", AnomalyMap(1.3, 1.3), 0.9), ("1e-12", SPREAD, 0.15), ("1e-3", AnomalyMap(0, 3), 0.1),
])  # fmt: skip
@pytest.mark.parametrize("bits", [2, 12, 30])
def test_the_midpoint_rule_with_few_nodes_misses_by_no_more_than_its_bound(gap, map_, width, bits):
    integrand, _ = swinging(gap, map_)
    with ball.working(200), mpmath.workdps(60):
        found = strip_bound.midpoint(
            integrand, strip_bound.bound_in_strip(integrand, width), bits, [ball.flint.arb(1)]
        )[0]
        exact = 2 * mpmath.ellipk((1 - mpmath.mpf(gap)) ** 2) / mpmath.pi
        missed = abs(certified.to_mpf(found.mid(), 200) - exact)
        assert 0 < missed <= certified.to_mpf(found.rad(), 64)


@pytest.mark.parametrize(
    ("gap", "map_", "width"), [("0.1", AnomalyMap(), 0.9), ("1e-12", SPREAD, 0.15), ("1e-3", AnomalyMap(0, 3), 0.1)]
)
def test_the_bound_holds_everywhere_in_the_strip_and_is_not_idle(gap, map_, width):
    integrand, _ = swinging(gap, map_)
    with ball.working(200), mpmath.workdps(40):
        most = float(strip_bound.bound_in_strip(integrand, width).most[0])
        k = 1 - mpmath.mpf(gap)
        b = 2 * mpmath.asin(k)

        def size(χ):
            """|dq/dχ|/|p| by mpmath alone: q from tan φ = s/c, dq/dχ by differences."""

            def q(x):
                s, c = (
                    mpmath.sinh(κ * f(x / 2)) / mpmath.sinh(κ) if κ else f(x / 2)
                    for κ, f in ((map_.lower, mpmath.sin), (map_.upper, mpmath.cos))
                )
                return b * (s * s - c * c) / (s * s + c * c)

            return abs(mpmath.diff(q, χ) / (2 * mpmath.sqrt(k * k - mpmath.sin(q(χ) / 2) ** 2)))

        generator = random.Random(3)
        places = [mpmath.mpc(generator.uniform(0.01, 3.13), width * generator.random()) for _ in range(40)]
        edge = [mpmath.mpc(mpmath.pi * (n + 0.5) / 40, width) for n in range(40)]
        assert all(size(χ) <= most for χ in places + edge)
        assert most < 40 * max(map(size, edge))


@pytest.mark.parametrize("beyond", [1.01, 1.3, 2.0])
def test_no_bound_is_given_on_a_strip_that_holds_another_zero_of_p_squared(beyond):
    integrand, width = swinging("0.1")
    with ball.working(200):
        assert strip_bound.bound_in_strip(integrand, 0.9 * width) is not None
        assert strip_bound.bound_in_strip(integrand, beyond * width) is None


def test_no_bound_is_given_on_a_strip_that_holds_the_place_where_q_is_infinite():
    integrand, _ = swinging("1e-12", SPREAD)
    with ball.working(200):
        assert strip_bound.bound_in_strip(integrand, 0.4 * math.pi / SPREAD.lower) is not None
        assert strip_bound.bound_in_strip(integrand, 0.75 * math.pi / SPREAD.lower) is None


@pytest.mark.parametrize("part", [0.8, 1.2])
def test_no_bound_is_given_on_a_strip_that_holds_a_pole(part):
    """In r = a (1 − e cos χ), the centre lies at cosh Im χ = 1/e; p² has a pole there, √p² on the edge beyond has none."""
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    motion = kepler.motion(
        q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}, parameters={"m": 1, "k": 1}, certified=True
    )
    integrand = cycle("r", motion)
    with ball.working(200):
        found = strip_bound.bound_in_strip(integrand, part * float(mpmath.acosh(1 / mpmath.mpf("0.44"))))
        assert (found is None) == (part > 1)


@pytest.mark.parametrize("excess", ["1e-2", "1e-1"])
def test_no_bound_is_given_on_a_strip_that_holds_a_complex_pair_of_zeros(excess):
    """A quartic well with E a little above the barrier: p² = 2(E − (x² − 1)²) has zeros at ±i√(√E − 1)."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "(x**2-1)**2")
    motion = hjsolve.solve(system).motion(
        q={"x": 0}, velocity={"x": f"sqrt(2*{excess})"}, certified=True, want=["periods"]
    )
    integrand = cycle("x", motion)
    E = 1 + mpmath.mpf(excess)
    b, zero = mpmath.sqrt(1 + mpmath.sqrt(E)), mpmath.sqrt(mpmath.sqrt(E) - 1)
    width = float(mpmath.asinh(zero / b))
    with ball.working(200):
        assert strip_bound.bound_in_strip(integrand, 0.8 * width) is not None
        assert strip_bound.bound_in_strip(integrand, 1.1 * width) is None
        assert strip_bound.bound_in_strip(integrand, 3 * width) is None


def test_no_bound_is_given_on_a_strip_that_holds_as_many_poles_as_zeros():
    """The argument of p² comes back then: only balls over the whole strip see the poles, at ±i/5."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2 + 1/(100*(x**2+1/25))")
    motion = hjsolve.solve(system).motion(q={"x": 0}, velocity={"x": "sqrt(3/2)"}, certified=True, want=["periods"])
    integrand = cycle("x", motion)
    b = motion.turning_points["x"][1].value
    with ball.working(200):
        assert strip_bound.bound_in_strip(integrand, 0.8 * math.asinh(0.17 / b)) is not None
        assert strip_bound.bound_in_strip(integrand, 1.5 * math.asinh(0.2 / b)) is None


@pytest.mark.parametrize(
    ("potential", "even"), [("(x**2-1)**2 - x**4/50", True), ("(x**2-1)**2 + x/1000000000", False)]
)
def test_symmetry_is_used_where_it_is_proved_and_nowhere_else(potential, even):
    """Over the barrier. A term of 1e-9 breaks the symmetry: means over a quarter of a turn would be 1e-10 off."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", potential)
    motion = hjsolve.solve(system).motion(
        q={"x": 0}, velocity={"x": "3/2"}, certified=True, digits=40, want=["periods", "actions"]
    )
    assert cycle("x", motion).symmetry == (4 if even else 2)
    with mpmath.workdps(60):
        a, b = (mpmath.mpf(end.value) for end in motion.turning_points["x"])

        def V(x):
            return (x * x - 1) ** 2 + (-(x**4) / 50 if even else x / mpmath.mpf(10) ** 9)

        E = V(mpmath.mpf(0)) + mpmath.mpf("1.125")
        middle, half = (a + b) / 2, (b - a) / 2

        def rate(φ):
            x = middle - half * mpmath.cos(φ)
            return half * mpmath.sin(φ) / mpmath.sqrt(2 * (E - V(x)))

        N = 600
        truth = 2 * mpmath.pi / N * mpmath.fsum(rate(mpmath.pi * (2 * m + 1) / (2 * N)) for m in range(N))
    check(motion.periods["x"], truth, 40)


def test_the_folds_of_a_turn_give_the_same_mean():
    motion = pendulum(velocity={"theta": "1.9"}, want=["periods", "actions"])
    whole = cycle("theta", motion)
    spinning = cycle("theta", pendulum(velocity={"theta": "2.2"}, want=["periods", "actions"]))
    assert (whole.symmetry, spinning.symmetry) == (4, 2)
    with ball.working(200):
        for integrand in (whole, spinning):
            means = [
                strip_bound.certified_means(replace(integrand, symmetry=integrand.symmetry // part), 100)
                for part in (1, 2)
            ]
            for one, other in zip(*means, strict=True):
                assert one.overlaps(other)


@pytest.mark.parametrize("potential", ["x**2/10 + exp(-x**2) + x/3", "x**2/10 + cosh(x/2) + x/3", "x**2 + asinh(x)/3"])
def test_taylor_coefficients_that_are_cut_off_are_not_taken_for_zero(potential):
    """One coefficient more than a series holds reads as 0: the remainder was lost, and a period was 1e-18 off."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", potential)
    given = {"q": {"x": "-1.3"}, "velocity": {"x": "2.5"}, "want": ["periods"]}
    solution = hjsolve.solve(system)
    found = solution.motion(**given, certified=True, digits=20)
    better = solution.motion(**given, digits=40).periods["x"]
    with mpmath.workdps(60):
        assert abs(mpmath.mpf(found.periods["x"].value) - better.value) <= found.periods["x"].error + better.error
    integrand = cycle("x", found)
    with ball.working(64):
        assert not integrand.line.taylor(ball.flint.acb(1, 1), ball.flint.ctx.cap + 1)[-1].is_finite()
