"""A polar orbit of Kerr's hole (p_φ = 0) ended at the axis, and so did a charge in a magnetic field on its way through it."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.number_types import Reals

pytestmark = pytest.mark.rotating_file(2)

POLAR = {"p_t": "-0.97", "p_theta": "3.8"}


def polar(spin: str, digits: int = 15) -> hjsolve.Motion:
    start = {"t": 0, "r": 8, "theta": "pi/2", "phi": "0.3"}
    momenta = {"t": POLAR["p_t"], "r": "0.02", "theta": POLAR["p_theta"], "phi": 0}
    return hjsolve.solve("kerr").motion(q=start, p=momenta, parameters={"a": spin}, digits=digits)


def in_kerr_schild_coordinates(spin: float, times: Reals) -> tuple[Reals, Reals, Reals]:
    """The same orbit in Cartesian coordinates that are regular on the axis, by Runge and Kutta: r, θ, φ.

    H = ½ (η^ab − f l^a l^b) p_a p_b (Kerr and Schild 1965); φ of Boyer and Lindquist is φ′ − ∫ a/Δ dr.
    """
    integrate = pytest.importorskip("scipy.integrate")
    a, r, φ, p_t = spin, 8.0, 0.3, -0.97
    Δ = r * r - 2 * r + a * a
    place = np.array([r * np.cos(φ) - a * np.sin(φ), r * np.sin(φ) + a * np.cos(φ), 0.0])
    jacobian = np.array([[np.cos(φ), 0, -place[1]], [np.sin(φ), 0, place[0]], [0, -r, 0]])
    momenta = np.linalg.solve(jacobian.T, np.array([0.02 - p_t * 2 * r / Δ, 3.8, 0.0]))

    def energy(y: Reals) -> complex:
        x, p = y[:3], y[3:]
        s = x @ x - a * a
        r2 = (s + np.sqrt(s * s + 4 * a * a * x[2] ** 2)) / 2
        ρ = np.sqrt(r2)
        along = np.array([(ρ * x[0] + a * x[1]) / (r2 + a * a), (ρ * x[1] - a * x[0]) / (r2 + a * a), x[2] / ρ])
        f = 2 * ρ**3 / (r2 * r2 + a * a * x[2] ** 2)
        return complex((p @ p - p_t**2 - f * (along @ p - p_t) ** 2) / 2)

    def slopes(_: float, y: Reals) -> Reals:
        gradient = np.array([energy(y + 1e-200j * unit).imag / 1e-200 for unit in np.eye(6)])
        return np.concatenate([gradient[3:], -gradient[:3]])

    begin = np.concatenate([place, momenta])
    found = integrate.solve_ivp(slopes, (0, times[-1]), begin, "DOP853", times, rtol=1e-12, atol=1e-12).y
    s = found[0] ** 2 + found[1] ** 2 + found[2] ** 2 - a * a
    radii = np.sqrt((s + np.sqrt(s * s + 4 * a * a * found[2] ** 2)) / 2)
    inner, outer = 1 - np.sqrt(1 - a * a), 1 + np.sqrt(1 - a * a)
    dragged = a / (outer - inner) * np.log((radii - outer) / (radii - inner))
    azimuths = np.angle((found[0] + 1j * found[1]) / (radii + 1j * a)) - dragged + dragged[0]
    return radii, np.arccos(found[2] / radii), azimuths


@pytest.mark.nightly_cases("0.9")
@pytest.mark.parametrize("spin", ["0.9", "-0.37"])
def test_a_polar_orbit_of_kerr_goes_through_the_axis(spin: str) -> None:
    times = np.linspace(0.0, 300.0, 13)
    motion = polar(spin)
    assert motion.kinds == {"t": "ignorable", "r": "libration", "theta": "rotation", "phi": "ignorable"}
    state = motion.at(times)
    radii, polar_angles, azimuths = in_kerr_schild_coordinates(float(spin), times)
    np.testing.assert_allclose(state.q["r"], radii, rtol=0, atol=2e-10)
    np.testing.assert_allclose(state.q["theta"], polar_angles, rtol=0, atol=2e-10)
    np.testing.assert_allclose(np.exp(1j * state.q["phi"]), np.exp(1j * azimuths), rtol=0, atol=2e-10)
    assert set(np.sign(state.velocity["theta"])) == {-1.0, 1.0}


@pytest.mark.nightly
def test_claims_of_a_polar_orbit_hold_against_thirty_digits() -> None:
    times = [0, 40, 77, 150, 1000, "1e5"]
    state, truth = polar("0.9").at(times), polar("0.9", digits=30).at(times)
    assert all(status == "ok" for status in state.status)
    for name in ("t", "r", "theta", "phi"):
        for values, errors, true in (
            (state.q, state.error.q, truth.q),
            (state.p, state.error.p, truth.p),
            (state.velocity, state.error.velocity, truth.velocity),
        ):
            away = np.abs(np.array([float(x - y) for x, y in zip(values[name], true[name], strict=True)]))
            assert np.all(away <= errors[name])
            assert np.all(errors[name] <= 1e-9)


@pytest.mark.nightly
def test_a_polar_orbit_is_the_limit_of_orbits_beside_the_axis() -> None:
    beside = hjsolve.solve("kerr").motion(
        q={"t": 0, "r": 8, "theta": "pi/2", "phi": "0.3"}, p={"t": "-0.97", "r": "0.02", "theta": "3.8", "phi": "1e-9"}
    )
    through, near = polar("0.9"), beside
    assert abs(through.frequencies["theta"].value - near.frequencies["theta"].value) < 1e-10
    for t in (30, 100, 250):
        for name in ("t", "r", "theta"):
            assert abs(through.at(t).q[name] - near.at(t).q[name]) < 1e-6
        turned = complex(np.exp(1j * (through.at(t).unwrapped("phi") - near.at(t).unwrapped("phi"))))
        assert abs(turned - 1) < 1e-6


def test_the_time_of_an_azimuth_that_jumps_is_refused_in_true_words() -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="phi: jumps by pi at the poles"):
        polar("0.9").time_at("phi", 1)


def test_a_charge_goes_through_the_axis_of_a_magnetic_field() -> None:
    """ṙ, φ̇, ż in a field along z: with p_φ = 0 a helix through the axis, in closed form."""
    field = hjsolve.System(
        {"r": "0 < r", "phi": "angle", "z": "line"},
        "(dot(r)**2 + r**2*dot(phi)**2 + dot(z)**2)/2 + B*r**2*dot(phi)/2",
        "0",
        {"B": 2},
    )
    motion = hjsolve.solve(field).motion(q={"r": 1, "phi": 0, "z": 0}, velocity={"r": "0.5", "phi": -1, "z": 1})
    for t in (0.3, 1.0, 2.5, 40.0):
        state = motion.at(t)
        true = 1 + (0.5 - 1j) * (cmath.exp(-2j * t) - 1) / -2j
        assert abs(cmath.rect(state.q["r"], state.q["phi"]) - true) < 1e-13
        assert state.status == "ok"
        assert abs(state.q["z"] - t) < 1e-13
        speed = (state.velocity["r"] + 1j * state.q["r"] * state.velocity["phi"]) * cmath.exp(1j * state.q["phi"])
        assert abs(speed - (0.5 - 1j) * cmath.exp(-2j * t)) < 1e-12
