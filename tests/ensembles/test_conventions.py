"""Actions and angles as galpy and Agama count them: their numbers, and the limit L_z → 0."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve import InvalidInputError, System, ensemble

KUZMIN = "-GM/sqrt(R**2+z**2+a**2+c**2+2*sqrt(a**2*c**2+c**2*R**2+a**2*z**2))"
LETTERS = {"GM": 1, "a": 1, "c": "1/2"}
CYLINDER = "(dot(R)**2 + R**2*dot(phi)**2 + dot(z)**2)/2"
SPHERE = "(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)/2"
WANT = {"actions", "frequencies", "angles", "turning_points"}
# galpy 1.12: actionAngleStaeckel(KuzminKutuzovStaeckelPotential(amp=1, ac=2, Delta=sqrt(3)/2)), actionAngleIsochrone(b=1)
# at R = 1.2, v_R = 0.1, L_z = ±0.5, z = 0.3, v_z = 0.2, phi = 0.5: J_R, J_z, Omega_R, Omega_z, θ_R, θ_φ of either sign, θ_z
GALPY = {
    "mu": (0.01510009, 0.05652388, 0.5860044, 0.4664508, 1.46093425, 0.28595167, 0.71404833, 0.45151997),
    "r": (0.03409247, 0.05652942, 0.40612521, 0.25749949, 0.67355516, 0.27247359, 0.72752641, 0.30938433),
}

# Agama 1.0: ActionFinder(Potential(type="Isochrone", mass=1, scaleRadius=1)) at R = 1.2, phi = 0.5, z = 0.3, v_R = 0.1,
# and v_phi, v_z: actions, angles and frequencies of r, z and phi
AGAMA = {
    (0.5 / 1.2, 0.2): (
        (0.0340924743611, 0.0565294241997, 0.5), (0.673555162398, 0.309384328607, 0.272473585867),
        (0.406125206897, 0.257499492869, 0.257499492869),
    ),
    (0.5 / 1.2, -0.2): (
        (0.0179802263889, 0.0818290126833, 0.5), (0.29041718718, 2.55603009235, 0.348018922713),
        (0.406125206897, 0.25978496074, 0.25978496074),
    ),
    (-0.5 / 1.2, 0.2): (
        (0.0340924743611, 0.0565294241997, -0.5), (0.673555162398, 0.309384328607, 0.727526414133),
        (0.406125206897, 0.257499492869, -0.257499492869),
    ),
    (-0.5 / 1.2, -0.2): (
        (0.0179802263889, 0.0818290126833, -0.5), (0.29041718718, 2.55603009235, 0.651981077287),
        (0.406125206897, 0.25978496074, -0.25978496074),
    ),
    (0.0, 0.2): (
        (0.0663619862075, 0.21, None), (2.18830892402, 6.19157022399, None), (0.613516553945, 0.338791795332, None),
    ),
}  # fmt: skip


def kuzmin(R, z, v_R, v_T, v_z):
    system = System({"R": "0 <= R", "phi": "angle", "z": "line"}, CYLINDER, KUZMIN, LETTERS)
    return ensemble(
        system, q={"R": R, "phi": 0.5, "z": z}, velocity={"R": v_R, "phi": v_T, "z": v_z}, coordinates="find",
        velocity_frame="orthonormal", want=WANT,
    )  # fmt: skip


def isochrone(R, z, v_R, v_T, v_z):
    system = System({"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}, SPHERE, "-1/(1+sqrt(1+r**2))")
    r, theta = np.hypot(R, z), np.arctan2(R, z)
    return ensemble(
        system, q={"r": r, "theta": theta, "phi": 0.5}, velocity_frame="orthonormal", want=WANT,
        velocity={"r": (R * v_R + z * v_z) / r, "theta": (z * v_R - R * v_z) / r, "phi": v_T},
    )  # fmt: skip


@pytest.mark.nightly_cases("kuzmin-names0")
@pytest.mark.parametrize(("stars", "names"), [(kuzmin, ("mu", "nu")), (isochrone, ("r", "theta"))])
def test_they_are_galpys_numbers(stars, names):
    n = np.ones(2)
    batch = stars(1.2 * n, 0.3 * n, 0.1 * n, np.array([0.5, -0.5]) / 1.2, 0.2 * n).in_conventions("galpy")
    radial, vertical = names
    columns = [
        batch.actions[radial], batch.actions[vertical], batch.frequencies[radial], batch.frequencies[vertical],
        batch.angles[radial], batch.angles["phi"], batch.angles[vertical],
    ]  # fmt: skip
    J_R, J_z, rate, rate_z, w_R, forth, back, w_z = GALPY[radial]
    expected = ((J_R, J_z, rate, rate_z, w_R, forth, w_z), (J_R, J_z, rate, rate_z, w_R, back, w_z))
    assert np.allclose(np.array(columns).T, expected, rtol=0, atol=1e-8)


@pytest.mark.nightly
@pytest.mark.parametrize(("stars", "names"), [(kuzmin, ("mu", "nu")), (isochrone, ("r", "theta"))])
def test_orbits_without_angular_momentum_have_the_values_of_the_limit(stars, names):
    """J_mu jumps by a factor of 2 where L_z is 0 exactly; a turning orbit through the poles has a sign."""
    R, z, v_R = np.array([1.2, 1.2, 0.9, 0.2]), np.array([0.3, 0.3, -0.4, 1.1]), np.array([0.1, -0.3, 0.2, 0.05])
    v_z = np.array([0.2, -0.2, 0.3, -0.1])
    exact, near = (stars(R, z, v_R, np.full(4, v_T), v_z) for v_T in (0.0, 1e-9))
    assert (exact.status == "ok").all()
    limit, other = exact.in_conventions("galpy"), near.in_conventions("galpy")
    assert any(
        not np.allclose(getattr(exact, group)[name], getattr(near, group)[name], rtol=1e-6)
        for group in ("actions", "frequencies") for name in names
    )  # fmt: skip
    for group in ("actions", "frequencies", "angles"):
        for name in names:
            difference = getattr(limit, group)[name] - getattr(other, group)[name]
            if group == "angles":
                difference = np.angle(np.exp(1j * difference))
            assert np.max(np.abs(difference)) < 1e-6, (group, name, difference)
    assert all(((angle >= 0) & (angle < 2 * np.pi)).all() for name, angle in other.angles.items())


def isochrone(v_phi, v_z):
    R, z, v_R = 1.2, 0.3, 0.1
    r = np.hypot(R, z)
    system = System({"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}, SPHERE, "-1/(1 + sqrt(1 + r**2))")
    return ensemble(
        system, q={"r": np.full(1, r), "theta": np.arctan2(R, z), "phi": 0.5}, velocity_frame="orthonormal", want=WANT,
        velocity={"r": (R * v_R + z * v_z) / r, "theta": (z * v_R - R * v_z) / r, "phi": v_phi},
    )  # fmt: skip


@pytest.mark.parametrize("velocity", AGAMA)
def test_agama_s_actions_angles_and_frequencies(velocity):
    found = isochrone(*velocity).in_conventions("agama")
    for group, values in zip(("actions", "angles", "frequencies"), AGAMA[velocity], strict=True):
        for name, value in zip(("r", "theta", "phi"), values, strict=True):
            if value is not None:
                np.testing.assert_allclose(getattr(found, group)[name], value, rtol=1e-8, atol=0)


@pytest.mark.nightly
def test_what_is_not_known_is_asked_for():
    R = np.ones(1)
    batch = kuzmin(R, 0.1 * R, 0 * R, 0.5 * R, 0 * R)
    with pytest.raises(InvalidInputError, match='"galpy" and "agama" are known'):
        batch.in_conventions("gala")
    plane = ensemble("kepler-planar", q={"r": R, "theta": 0}, velocity={"r": 0, "theta": 1}, want="actions")
    with pytest.raises(InvalidInputError, match="which coordinates are the radial and the vertical one"):
        plane.in_conventions("galpy")
