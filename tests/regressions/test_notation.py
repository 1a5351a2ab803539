"""A physicist's own notation is the same system as the plain one, up to the motion."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)


def test_a_pendulum_of_dynamicsymbols_is_the_pendulum_typed_with_primes_and_the_one_typed_plainly():
    import sympy as sp
    from sympy.physics.mechanics import dynamicsymbols

    m, g, l = sp.symbols("m g l")
    theta, time = dynamicsymbols("theta"), dynamicsymbols._t
    numbers = {"m": 1, "g": 1, "l": 1}
    made = [
        hjsolve.System({"theta": "angle"}, kinetic, potential, numbers)
        for kinetic, potential in (
            (m * l**2 / 2 * theta.diff(time) ** 2, -m * g * l * sp.cos(theta)),
            ("m l^2 theta'^2/2", "-m g l cos(theta)"),
            ("m/2*l**2*θ'^2", "-m g l*cos(θ)"),
            ("m/2*l**2*dot(theta)**2", "-m*g*l*cos(theta)"),
        )
    ]
    assert made[0] == made[1] == made[2] == made[3]


@pytest.mark.parametrize(("potential", "start"), [("x^2 + 1/(x^2)^(1/3)", -1), ("x^2 + abs(x)^(-2/3)", 1)])
def test_a_real_root_is_the_same_on_both_sides_of_zero(potential, start):
    """x² + |x|^(−2/3), from rest at ±1 (E = 2): with z = |x|^(2/3), z p² = 2 (1 − z)(z − a)(z² + (1 + a) z + 1/a)."""
    motion = hjsolve.solve(hjsolve.System({"x": "line"}, "x'^2/2", potential)).motion(q={"x": start}, velocity={"x": 0})
    with mpmath.workdps(30):
        a = mpmath.findroot(lambda z: z**3 + z**2 + z - 1, mpmath.mpf("0.54"))

        def rate(angle):
            z = (1 + a) / 2 - (1 - a) / 2 * mpmath.cos(angle)
            return 3 * z / mpmath.sqrt(2 * (z**2 + (1 + a) * z + 1 / a))

        period, inner = mpmath.quad(rate, [0, mpmath.pi / 2, mpmath.pi]), mpmath.sqrt(a**3)
    got = motion.periods["x"]
    assert motion.kinds["x"] == "libration"
    assert abs(got.value - float(period)) <= got.error + 1e-13 * got.value
    assert sorted(abs(float(point.value)) for point in motion.turning_points["x"]) == pytest.approx(
        [float(inner), 1.0], rel=1e-14, abs=0
    )


@pytest.mark.parametrize(("potential", "n"), [("abs(x)^(5/2)", "5/2"), ("(x^2)^(2/3)", "4/3"), ("(x^2)^(8/3)", "16/3")])
@pytest.mark.nightly_cases("(x^2)^(2/3)-4/3", "(x^2)^(8/3)-16/3")
def test_a_motion_through_the_cusp_of_a_real_root_has_the_period_of_its_power(potential, n):
    """T = √8 √π Γ(1 + 1/n)/Γ(1/2 + 1/n) for V = |x|ⁿ, E = 1 (Landau and Lifshitz, Mechanics, §11)."""
    motion = hjsolve.solve(hjsolve.System({"x": "line"}, "x'^2/2", potential)).motion(q={"x": 1}, velocity={"x": 0})
    power = 1 / mpmath.mpf(int(n.split("/")[0])) * int(n.split("/")[1])
    truth = mpmath.sqrt(8 * mpmath.pi) * mpmath.gamma(1 + power) / mpmath.gamma(power + 0.5)
    got = motion.periods["x"]
    assert abs(got.value - float(truth)) <= got.error + 3e-16 * got.value


def test_a_potential_of_the_polar_angle_typed_in_cartesian_coordinates_separates_in_polar_ones():
    plane = hjsolve.System({"x": "line", "y": "line"}, "x'^2/2 + y'^2/2", "cos(4*atan2(y, x))/(x^2 + y^2) + x^2 + y^2")
    assert [web.kind for web in hjsolve.find_coordinates(plane).webs] == ["polar"]
