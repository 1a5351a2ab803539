"""Terms of p² that cancel, or nearly: barriers of the same power, and tops whose two momenta are equal."""

from __future__ import annotations

import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve import System, solve
from hjsolve.errors import ForbiddenMotionError
from hjsolve.motion.motion import Motion

pytestmark = pytest.mark.rotating_file(5)

PLANE = {"r": "0 < r", "phi": "angle"}


def top(potential: str = "cos(theta)", **start: object) -> Motion:
    system = System(
        {"theta": "0 < theta < pi", "phi": "angle", "psi": "angle"},
        "(dot(theta)**2+dot(phi)**2*sin(theta)**2)/2+(dot(psi)+dot(phi)*cos(theta))**2/2",
        potential,
    )
    return solve(system).motion(**start)


@pytest.mark.parametrize("excess", ["1e-6", "1e-12", "1e-16", "1e-20"])
def test_kepler_with_an_inverse_square_turns_at_its_true_pericentre(excess: str) -> None:
    """L = 1 and b = (1 − x)/2 leave L² = x: the period of r is 2π/(2 − x)^{3/2}, the pericentre x/(2 − x)."""
    system = System(PLANE, "(dot(r)**2+r**2*dot(phi)**2)/2", "-1/r - (1 - x)/(2*r**2)", parameters={"x": excess})
    motion = solve(system).motion(q={"r": 1, "phi": 0}, velocity={"r": 0, "phi": 1})
    with mp.workdps(60):
        x = mpf(sp.Rational(excess).p) / sp.Rational(excess).q
        period, lower = motion.periods["r"], motion.turning_points["r"][0]
        assert abs(period.value - 2 * mp.pi / (2 - x) ** mpf("1.5")) <= period.error
        assert abs(lower.value - x / (2 - x)) <= lower.error <= 1e-21


def test_an_inverse_square_that_cancels_exactly_leaves_kepler_without_a_barrier() -> None:
    system = System(PLANE, "(dot(r)**2+r**2*dot(phi)**2)/2", "-1/r - 1/(2*r**2)")
    motion = solve(system).motion(q={"r": 1, "phi": 0}, velocity={"r": 0, "phi": 1})
    time = motion.boundary_times["r"]
    with mp.workdps(40):
        assert abs(time.value - mp.pi / mp.sqrt(8)) <= time.error


def test_a_top_that_tends_to_the_vertical_does_so_as_its_formula() -> None:
    """1/cos θ = 1 + sech t."""
    rate = "2/sqrt(3)"
    motion = top(q={"theta": "pi/3", "phi": 0, "psi": 0}, velocity={"theta": 0, "phi": rate, "psi": rate})
    assert motion.kinds["theta"] == "asymptotic"
    with mp.workdps(40):
        for t in (-2.0, 0.5, 3.0, 12.0):
            state = motion.at(t)
            assert abs(state.q["theta"] - mp.acos(1 / (1 + mp.sech(mpf(t))))) <= state.error.q["theta"] <= 1e-13


@pytest.mark.parametrize("apart", ["1e-9", "1e-14", "1e-20"])
def test_a_top_with_nearly_equal_momenta_turns_next_to_the_vertical(apart: str) -> None:
    """Truth: the cubic (2E − p_φ² − 2x)(1 − x²) − (p_ψ − p_φ x)² of x = cos θ at 60 digits, and its integral."""
    p_φ, p_ψ = sp.Rational("1.5"), sp.Rational("1.5") + sp.Rational(apart)
    motion = top(q={"theta": "pi/3", "phi": 0, "psi": 0}, p={"theta": 2, "phi": p_φ, "psi": p_ψ})
    lower, upper = motion.turning_points["theta"]
    with mp.workdps(60):
        a, b = (mpf(x.p) / x.q for x in (p_φ, p_ψ))
        energy = (4 + b**2 + (a - b / 2) ** 2 / mpf("0.75")) / 2 + mpf("0.5")  # p_θ²/2 + (…)²/(2 sin²) + p_ψ²/2 + V
        cubic = [2, -(2 * energy - b**2) - b**2, 2 * a * b - 2, (2 * energy - b**2) - a**2]
        roots = sorted(mp.re(x) for x in mp.polyroots(cubic, maxsteps=500, extraprec=800))
        assert abs(lower.value - mp.acos(roots[1])) <= lower.error + mpf(10) ** -28
        assert abs(upper.value - mp.acos(roots[0])) <= upper.error
        period = motion.periods["theta"]
        m = (roots[1] - roots[0]) / (roots[2] - roots[0])
        assert abs(period.value - 4 * mp.ellipk(m) / mp.sqrt(2 * (roots[2] - roots[0]))) <= period.error


def test_the_constants_of_a_top_that_no_motion_has_are_told_with_the_region_allowed() -> None:
    system = System(
        {"theta": "0 < theta < pi", "phi": "angle", "psi": "angle"},
        "J1/2*(dot(theta)**2+dot(phi)**2*sin(theta)**2)+J3/2*(dot(psi)+dot(phi)*cos(theta))**2",
        "M*g*l*cos(theta)",
        parameters={"J1": 1, "J3": 2, "M": "0.5", "l": "0.05", "g": "9.8"},
    )
    constants = {"E": "12.009", "p_phi": "1.48", "p_psi": "6.86"}
    with pytest.raises(ForbiddenMotionError) as caught:
        solve(system).motion(q={"theta": "0.2", "phi": 0, "psi": 0}, constants=constants, signs={"theta": 1})
    low, high = caught.value.regions[0]
    assert low is not None
    assert high is not None
    assert abs(low - 1.2690293543713606) < 1e-14
    assert abs(high - 1.4495242931) < 1e-10


def test_a_tangent_of_the_half_angle_may_be_typed_as_a_quotient() -> None:
    motions = [
        solve(System({"x": "0 < x < pi"}, "dot(x)**2/2", V)).motion(q={"x": 1}, velocity={"x": "-0.1"})
        for V in ("(1 - cos(x))/sin(x)", "tan(x/2)")
    ]
    first, second = (motion.boundary_times["x"] for motion in motions)
    assert first.agrees(second)
    assert first.error < 1e-13
