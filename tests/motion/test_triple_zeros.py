"""Zeros of p² that only exact arithmetic tells: triple ones, and those at θ = π/2; against closed forms."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve

exact = mpmath.MPContext()
exact.dps = 50


@pytest.mark.parametrize("digits", [15, pytest.param(30, marks=pytest.mark.nightly)])
@pytest.mark.parametrize(
    ("V", "v", "law"),
    [
        pytest.param("-x**3", "-sqrt(2)", lambda t: (1 + t / exact.sqrt(2)) ** -2, marks=pytest.mark.nightly),
        ("-x**4", "-sqrt(2)", lambda t: 1 / (1 + exact.sqrt(2) * t)),
        ("-x**6/2", "-1", lambda t: 1 / exact.sqrt(1 + 2 * t)),
    ],
)
def test_a_triple_zero_is_approached_by_a_power_of_the_time(V: str, v: str, law: object, digits: int) -> None:
    motion = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", V)).motion(
        q={"x": 1}, velocity={"x": v}, digits=digits
    )
    assert motion.kinds == {"x": "asymptotic"}
    for t in (1, 100, 10**6):
        state, truth = motion.at(t), law(exact.mpf(t))
        assert abs(exact.mpf(state.q["x"]) - truth) <= exact.mpf(state.error.q["x"]) < 1e-12 * truth


@pytest.mark.parametrize("V", ["-x**3", "-x**4"])
def test_a_body_at_rest_on_a_triple_zero_stays(V: str) -> None:
    motion = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", V)).motion(q={"x": 0}, velocity={"x": 0})
    assert motion.kinds == {"x": "equilibrium"}
    assert motion.at(10).q["x"] == 0


SCHWARZSCHILD = {"E": "-1/2", "alpha_2": 6, "p_t": "-sqrt(8/9)", "p_phi": "sqrt(12)"}


def test_the_innermost_stable_circular_orbit_of_schwarzschild_is_an_equilibrium() -> None:
    motion = hjsolve.solve("schwarzschild").motion(
        q={"t": 0, "r": 6, "theta": "pi/2", "phi": 0}, p={"t": "-sqrt(8/9)", "r": 0, "theta": 0, "phi": "sqrt(12)"}
    )
    assert motion.kinds["r"] == "equilibrium"
    state = motion.at(100)
    assert state.q["r"] == 6
    assert abs(state.q["t"] - float(100 * exact.sqrt(2))) <= state.error.q["t"]  # dt/dτ = E/(1 − 2/r)


@pytest.mark.nightly
def test_the_innermost_stable_circular_orbit_is_approached_from_inside() -> None:
    motion = hjsolve.solve("schwarzschild").motion(
        q={"t": 0, "r": 5, "theta": "pi/2", "phi": 0}, constants=SCHWARZSCHILD, signs={"r": 1}
    )
    assert motion.kinds["r"] == "asymptotic"
    state = motion.at(100)
    time = exact.quad(lambda r: 3 * (r / (6 - r)) ** exact.mpf(1.5), [5, exact.mpf(state.q["r"])])  # r'² = (6 − r)³/9r³
    assert abs(time - 100) <= 3 * (state.q["r"] / (6 - state.q["r"])) ** 1.5 * state.error.q["r"] < 1e-8


def test_a_dipole_typed_in_x_y_z_swings_on_its_circle() -> None:
    space = {"x": "line", "y": "line", "z": "line"}
    system = hjsolve.System(space, "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", "z/(x**2 + y**2 + z**2)**(3/2)")
    motion = hjsolve.solve(system, coordinates="find").motion(
        q={"x": 1, "y": 0, "z": 0}, velocity={"x": 0, "y": 0, "z": 0}
    )
    assert motion.kinds["r"] == "equilibrium"
    assert motion.kinds["theta"] == "libration"
    state = motion.at(3)  # nan came, after 20 s: θ = π/2 was a fraction next to it
    assert abs(state.q["x"] - -0.96885947) < 1e-7
    assert abs(state.q["z"] - -0.24761124) < 1e-7
    energy = sum(state.velocity[c] ** 2 for c in "xyz") / 2 + state.q["z"]
    assert abs(energy) < 1e-13
    assert abs(state.q["x"] ** 2 + state.q["z"] ** 2 - 1) < 1e-13
