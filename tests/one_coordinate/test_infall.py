"""Falls to the end of a domain: onto a centre where p² has a pole of any order, into a black hole.

The times are those of mpmath's tanh-sinh quadrature of dr/ṙ, the spiral of −1/r² is in closed form.
"""

from __future__ import annotations

from typing import Any

import pytest
from mpmath import mp

import hjsolve
from hjsolve import catalog
from hjsolve.motion.motion import Motion

RATE, TURN = "-1/10", "1/2"


def fall(potential: str, *, digits: int = 15) -> Motion:
    plane = {"r": "0 < r", "theta": "angle"}
    system = hjsolve.System(plane, "(dot(r)**2 + r**2*dot(theta)**2)/2", potential)
    solution = hjsolve.solve(system)
    return solution.motion(q={"r": 1, "theta": 0}, velocity={"r": RATE, "theta": TURN}, digits=digits)


def time_of(slope: Any, places: list[Any]) -> Any:
    with mp.workdps(40):
        return mp.quad(lambda r: 1 / mp.sqrt(slope(r)), [mp.mpf(p) for p in places])


POTENTIALS: dict[str, Any] = {
    "-1/r**2": lambda r: -1 / r**2,
    "-1/r**3": lambda r: -1 / r**3,
    "-1/r**4": lambda r: -1 / r**4,
    "-r**(-5/2)": lambda r: -(r ** mp.mpf(-2.5)),
}


@pytest.mark.nightly_cases("-1/r**2", "-r**(-5/2)")
@pytest.mark.parametrize("potential", POTENTIALS)
def test_the_time_of_a_fall_onto_a_centre(potential: str) -> None:
    V = POTENTIALS[potential]
    with mp.workdps(40):
        E = mp.mpf(1) / 200 + mp.mpf(1) / 8 + V(mp.mpf(1))
        true = time_of(lambda r: 2 * (E - V(r)) - 1 / (4 * r * r), [0, 0.01, 1])
    end = fall(potential).boundary_times["r"]
    assert abs(end.value - true) <= end.error <= 1e-14 * true
    assert fall(potential).at(float(true) * 1.001).status == "reaches_boundary"


@pytest.mark.parametrize("digits", [15, pytest.param(30, marks=pytest.mark.nightly)])
def test_a_spiral_of_infinitely_many_turns(digits: int) -> None:
    """V = −1/r²: r² = r₀² + 2 r₀ ṙ₀ t + 2E t², and θ goes round for ever as r → 0 (Landau & Lifshitz §15, problem 3)."""
    motion = fall("-1/r**2", digits=digits)
    with mp.workdps(60):
        L, twice_E, rate = mp.mpf(1) / 2, mp.mpf(1) / 100 + mp.mpf(1) / 4 - 2, -mp.mpf(1) / 10
        root = mp.sqrt(rate**2 - twice_E)
        end = (rate + root) / -twice_E
        times = [mp.mpf("0.1"), mp.mpf("0.5"), end - mp.mpf("1e-3"), end - mp.mpf("1e-6")]
        for t in times:
            t = mp.mpf(mp.nstr(t, 40))
            state = motion.at(mp.nstr(t, 40))
            r = mp.sqrt(1 + 2 * rate * t + twice_E * t * t)
            angle = L / root * _turned(twice_E, rate, root, t)
            missed = abs(state.q["r"] - r)
            assert missed <= state.error.q["r"]
            assert abs(state.unwrapped("theta") - angle) <= state.error.q["theta"]
            assert state.error.q["r"] <= mp.mpf(10) ** (2 - digits) * mp.sqrt(1 / (end - t))


def _turned(twice_E: Any, rate: Any, root: Any, t: Any) -> Any:
    """∫₀ᵗ root dt/(1 + 2 rate t + 2E t²)."""

    def primitive(x: Any) -> Any:
        return -mp.log((twice_E * x + rate + root) / (twice_E * x + rate - root)) / 2

    return mp.re(primitive(t) - primitive(0))


def test_a_logarithmic_potential_lets_a_point_fall_through_an_integrable_pole() -> None:
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "log(r)")
    motion = hjsolve.solve(system).motion(q={"r": 1, "theta": 0}, velocity={"r": 1, "theta": 0})
    with mp.workdps(30):
        true = mp.exp(mp.mpf(1) / 2) * mp.sqrt(mp.pi / 2) * (1 + mp.erf(1 / mp.sqrt(2)))
    end = motion.boundary_times["r"]
    assert abs(end.value - true) <= end.error <= 1e-14 * true


@pytest.mark.nightly
def test_a_plunge_into_schwarzschilds_black_hole_takes_a_finite_proper_time() -> None:
    solution = hjsolve.solve(catalog.load("schwarzschild"))
    motion = solution.motion(
        q={"t": 0, "r": 8, "theta": "6/5", "phi": 0}, p={"t": -1, "r": "-1/4", "theta": "1/5", "phi": 2}
    )
    with mp.workdps(40):
        K = mp.mpf("0.04") + 4 / mp.sin(mp.mpf("1.2")) ** 2
        H = -mp.mpf(8) / 12 + mp.mpf(6) / (16 * 16) + K / 128
        true = time_of(lambda r: 1 + (2 * H - K / r**2) * (r - 2) / r, [2, 8])
    end = motion.boundary_times["r"]
    assert abs(end.value - true) <= end.error <= 1e-13 * true
    late = motion.at([float(true) * (1 - 1e-6), float(true) * 1.01])
    assert list(late.status) == ["ok", "reaches_boundary"]
    assert late.q["r"][0] - 2 < 1e-4
    assert late.q["t"][0] > 30  # far away the clock runs on for ever


def test_a_relativistic_charge_with_little_angular_momentum_falls_onto_the_centre() -> None:
    """L < k/c: p_r² = (E + k/r)² − 1 − L²/r² has a double pole (Landau & Lifshitz 2, §39)."""
    motion = hjsolve.solve(catalog.load("relativistic-kepler")).motion(
        q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1/20"}
    )
    with mp.workdps(40):
        v, k = mp.mpf(1) / 20, mp.mpf("0.1")
        γ = 1 / mp.sqrt(1 - v * v)
        E, L = γ - k, γ * v
        far = (k**2 - L**2) / (E**2 - 1)  # the other root of p² r² = (E² − 1)(r − 1)(r − far)
        true = mp.quad(lambda u: 2 * (E * (1 - u * u) + k) / mp.sqrt((1 - E**2) * (1 - u * u - far)), [0, 0.9, 1])
    end = motion.boundary_times["r"]
    assert abs(end.value - true) <= end.error <= 1e-14 * true
