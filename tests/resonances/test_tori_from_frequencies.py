"""Tori from frequencies and ratios, separatrices, and Kerr's geodesics by p, e and x: against closed forms."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError
from hjsolve.resonances.kerr_elements import kerr_constants

PLANE = {"r": "0 < r", "theta": "angle"}
POLAR = "(dot(r)**2 + r**2*dot(theta)**2)/2"
mp = mpmath.MPContext()
mp.dps = 40


@pytest.fixture(scope="module")
def isochrone():
    return hjsolve.solve(hjsolve.System(PLANE, POLAR, "-1/(1 + sqrt(1 + r**2))"))


@pytest.fixture(scope="module")
def kerr():
    return hjsolve.solve(hjsolve.catalog.load("kerr"))


def ratio(motion, one, other):
    return abs(motion.frequencies[one].value / motion.frequencies[other].value)


@pytest.mark.nightly_cases("5-3", "3-2")
@pytest.mark.parametrize(("r", "theta"), [(3, 2), (5, 3), pytest.param(19, 10, marks=pytest.mark.nightly)])
def test_a_resonance_of_the_isochrone(isochrone, r, theta):
    """Ω_r/Ω_θ = 2/(1 + L/√(L² + 4)) (Binney and Tremaine, Galactic Dynamics, (3.227b))."""
    motion = isochrone.torus(ratio={"r": r, "theta": theta}, fixed={"E": "-1/5"})
    s = 2 * mp.mpf(theta) / r - 1
    L = 2 * s / mp.sqrt(1 - s**2)
    assert abs(float(motion.constants["p_theta"].value - L)) <= motion.constants["p_theta"].error <= 1e-15
    np.testing.assert_allclose(ratio(motion, "r", "theta"), r / theta, rtol=4e-16, atol=0)


@pytest.mark.nightly
def test_one_frequency_of_the_isochrone(isochrone):
    """Ω_r = (−2E)^{3/2} (3.226)."""
    motion = isochrone.torus(frequencies={"r": "0.3"}, fixed={"p_theta": "1/2"})
    assert abs(float(motion.constants["E"].value + cube_root_squared("0.3") / 2)) <= motion.constants["E"].error


def cube_root_squared(text):
    return mp.mpf(text) ** (mp.mpf(2) / 3)


@pytest.mark.nightly
def test_both_frequencies_of_the_isochrone(isochrone):
    found = isochrone.torus(frequencies={"r": "0.3", "theta": "0.18"}, digits=25)
    for motion in found if isinstance(found, tuple) else (found,):
        for name, value in (("E", cube_root_squared("0.3") / 2), ("p_theta", 1 / mp.sqrt(6))):
            constant = motion.constants[name]
            assert abs(abs(mp.mpf(constant.value)) - value) <= constant.error <= 1e-24


@pytest.mark.nightly
def test_a_ratio_is_proved_between_two_certified_motions(isochrone):
    motion = isochrone.torus(ratio={"r": 3, "theta": 2}, fixed={"E": "-1/5"}, certified=True)
    assert motion.frequencies["r"].certified
    np.testing.assert_allclose(motion.constants["p_theta"].value, np.sqrt(0.5), rtol=3e-16, atol=0)


@pytest.mark.nightly
def test_pendulum_of_one_frequency_swings_or_goes_round():
    """Ω = π √(g/l)/(2 K(k)) swinging, π √(g/l)/(k K(1/k)) … going round, k² = (E + g)/2g."""
    motions = hjsolve.solve("pendulum").torus(frequencies={"theta": "0.9"}, parameters={"g": 1, "l": 1, "m": 1})
    assert [motion.kinds["theta"] for motion in motions] == ["libration", "rotation"]
    for motion in motions:
        k2 = (1 + mp.mpf(motion.constants["E"].value)) / 2
        librations = k2 < 1
        rate = mp.pi / (2 * mp.ellipk(k2)) if librations else mp.pi * mp.sqrt(k2) / mp.ellipk(1 / k2)
        np.testing.assert_allclose(float(rate), 0.9, rtol=2e-15, atol=0)
    one = hjsolve.solve("pendulum").torus(
        frequencies={"theta": "0.9"}, parameters={"g": 1, "l": 1, "m": 1}, kinds={"theta": "rotation"}
    )
    assert one.kinds["theta"] == "rotation"


@pytest.mark.nightly
def test_what_no_torus_has_is_an_error_that_says_what_there_is(isochrone):
    kepler = hjsolve.solve("kepler-planar")
    with pytest.raises(InvalidInputError, match=r"goes from 1\.4\d* to 2; simple ratios there are 3:2"):
        isochrone.torus(ratio={"r": 5, "theta": 2}, fixed={"E": "-1/5"})
    with pytest.raises(InvalidInputError, match="every motion with E = -1/5 has Ω_r : Ω_theta = 1 : 1"):
        kepler.torus(ratio={"r": 1, "theta": 1}, fixed={"E": "-1/5"})
    with pytest.raises(InvalidInputError, match="2 unknown constants"):
        isochrone.torus(ratio={"r": 3, "theta": 2})
    with pytest.raises(InvalidInputError, match="one of them"):
        isochrone.torus(fixed={"E": "-1/5"})
    with pytest.raises(InvalidInputError, match="'phi' has no frequency"):
        isochrone.torus(ratio={"r": 3, "phi": 2}, fixed={"E": "-1/5"})
    with pytest.raises(InvalidInputError, match="a positive number is needed"):
        isochrone.torus(frequencies={"r": -1}, fixed={"E": "-1/5"})


@pytest.mark.nightly
def test_frequencies_of_kepler_s_problem_belong_to_no_isolated_torus():
    with pytest.raises(InvalidInputError, match="does not belong to isolated tori"):
        hjsolve.solve("kepler-planar").torus(frequencies={"r": 1, "theta": 1})


def test_separatrices_of_a_yukawa_field_and_of_three_wells():
    """E and L of the barrier: V_eff = V_eff' = 0 by Newton's method in 40 digits."""
    yukawa = hjsolve.solve(hjsolve.System(PLANE, POLAR, "-exp(-r)/r"))
    (low, high) = yukawa.separatrices(fixed={"E": "1/100"})
    assert float(low.value.value) == -float(high.value.value)

    def level(r, L):
        return L**2 / (2 * r**2) - mp.exp(-r) / r

    r, L = mp.findroot(
        lambda r, L: [level(r, L) - mp.mpf(1) / 100, mp.diff(lambda x: level(x, L), r)], (3.6, 0.68)
    )  # fmt: skip
    assert abs(float(high.value.value - L)) <= high.value.error + 1e-16
    assert abs(float(high.place.value - r)) <= high.place.error + 1e-15
    wells = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2*(x - 1)**2*(x + 2)**2/3 + x/7"))
    barrier_tops = [mp.findroot(lambda x: mp.diff(lambda y: y**2 * (y - 1) ** 2 * (y + 2) ** 2 / 3 + y / 7, x), x0)
              for x0 in (0.61, -1.2)]  # fmt: skip
    found = wells.separatrices()
    for one, x in zip(found, barrier_tops, strict=True):
        np.testing.assert_allclose(float(one.place.value), float(x), rtol=1e-15, atol=0)
    with pytest.raises(InvalidInputError, match="must leave one"):
        yukawa.separatrices()


def test_the_separatrix_of_kerr_s_geodesics():
    """6 + 2e without spin; the innermost stable circle of Bardeen, Press and Teukolsky, ApJ 178 (1972) 347, (2.21)."""
    for e in ("0", "1/3", "0.95"):
        assert hjsolve.separatrix(0, e, "0.3").value == pytest.approx(6 + 2 * float(mp.mpf(eval(e))), rel=1e-15)
    for a in ("0.3", "0.9", "0.998"):
        s = mp.mpf(a)
        z1 = 1 + mp.cbrt(1 - s**2) * (mp.cbrt(1 + s) + mp.cbrt(1 - s))
        z2 = mp.sqrt(3 * s**2 + z1**2)
        for x in (1, -1):
            expected = 3 + z2 - x * mp.sqrt((3 - z1) * (3 + z1 + 2 * z2))
            found = hjsolve.separatrix(a, 0, x, digits=30)
            assert abs(found.value - expected) <= found.error <= 1e-28
    with pytest.raises(InvalidInputError, match="0 <= a < 1"):
        hjsolve.separatrix(1, 0, 1)


def test_constants_of_kerr_s_geodesics_give_the_turning_points_back(kerr):
    p, e, x = (mp.mpf(s) for s in ("10", "0.4", "-0.6"))
    found = kerr_constants(mp.mpf("0.9"), p, e, x, 100)
    motion = kerr.motion(
        q={"t": 0, "r": 10, "theta": "pi/2", "phi": 0}, signs={"r": 1, "theta": 1}, parameters={"a": "0.9"},
        constants={"E": "-1/2", "p_t": -found.energy, "p_phi": found.angular_momentum,
                   "alpha_2": (found.carter + (mp.mpf("0.9") * found.energy) ** 2 + found.angular_momentum**2) / 2},
    )  # fmt: skip
    low, high = motion.turning_points["r"]
    assert abs(float(low.value) - float(p / (1 + e))) <= 2e-15 * 7
    assert abs(float(high.value) - float(p / (1 - e))) <= 2e-15 * 17
    np.testing.assert_allclose(np.sin(float(motion.turning_points["theta"][0].value)), 0.6, rtol=4e-16, atol=0)


@pytest.mark.nightly
def test_a_resonance_of_nearly_circular_geodesics(kerr):
    """Ω_r/Ω_φ = √(1 − 6/r + 8a r^{−3/2} − 3a²/r²) of circles, nearly equatorial (Okazaki, Kato and Fukue, PASJ 39 (1987) 457)."""
    motion = kerr.torus(ratio={"r": 1, "phi": 2}, fixed={"a": "0.5", "e": "1e-5", "x": "0.99999999"})
    a = mp.mpf("0.5")
    r = mp.findroot(lambda r: 1 - 6 / r + 8 * a / r**1.5 - 3 * a**2 / r**2 - mp.mpf(1) / 4, 6.5)
    np.testing.assert_allclose(float(motion.turning_points["r"][0].value) * (1 + 1e-5), float(r), rtol=1e-7, atol=0)


@pytest.mark.nightly
@pytest.mark.parametrize(("r", "theta", "a", "e", "x"), [(2, 3, "0.9", "0.3", "0.5"), (1, 20, "0.5", "0.3", "-0.5")])
def test_a_resonance_of_kerr_s_geodesics_to_the_separatrix(kerr, r, theta, a, e, x):
    motion = kerr.torus(ratio={"r": r, "theta": theta}, fixed={"a": a, "e": e, "x": x})
    np.testing.assert_allclose(ratio(motion, "r", "theta"), r / theta, rtol=1e-14, atol=0)


def test_wells_that_join_above_a_barrier_have_their_tori_too():
    """Only the motion above the barrier was found: the wells below it were forgotten where they join."""
    wells = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4 - x**2/2 + x/20")
    found = hjsolve.solve(wells).torus(frequencies={"x": "1.2"})
    assert [(motion.turning_points["x"][0].value > 0, motion.turning_points["x"][1].value > 0) for motion in found] == [
        (False, False), (True, True), (False, True),
    ]  # fmt: skip
    for motion in found:
        low, high = (end.value for end in motion.turning_points["x"])
        anomaly = (np.arange(400) + 0.5) * np.pi / 400
        x = (low + high) / 2 - (high - low) / 2 * np.cos(anomaly)
        p = np.sqrt(2 * (motion.constants["E"].value - x**4 / 4 + x**2 / 2 - x / 20))
        np.testing.assert_allclose(1 / np.mean(np.sin(anomaly) / p * (high - low) / 2), 1.2, rtol=1e-9, atol=0)


def rate_between(V, E, low, high, nodes=2000):
    """Return 2π/∮ dx/p by the midpoint rule in the anomaly, x = (low + high)/2 − (high − low)/2 cos χ."""
    anomaly = (np.arange(nodes) + 0.5) * np.pi / nodes
    x = (low + high) / 2 - (high - low) / 2 * np.cos(anomaly)
    return 1 / np.mean(np.sin(anomaly) / np.sqrt(2 * (E - V(x))) * (high - low) / 2)


@pytest.mark.nightly
@pytest.mark.parametrize("nearness", [1e-4, 1e-6, 1e-9])
def test_two_tori_next_to_the_least_frequency(nearness):
    """Ω(E) falls and rises again: next to its minimum the equation is met twice between two values of a grid."""
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2 - x**4/10 + x**6/100"))
    places = np.linspace(1.976, 1.977, 2001)
    rates = hjsolve.ensemble(solution, q={"x": places}, p={"x": 0.0}, want={"frequencies"}).frequencies["x"]
    asked = float(rates.min()) * (1 + nearness)
    found = solution.torus(frequencies={"x": asked})
    assert len(found) == 2
    turning = []
    for motion in found:
        low, high = (end.value for end in motion.turning_points["x"])
        rate = rate_between(lambda x: x**2 / 2 - x**4 / 10 + x**6 / 100, motion.constants["E"].value, low, high)
        np.testing.assert_allclose(rate, asked, rtol=1e-9, atol=0)
        turning.append(high)
    assert turning[0] < places[np.argmin(rates)] < turning[1]


@pytest.mark.nightly
def test_two_wells_and_what_goes_round_have_a_torus_each():
    """The top of the barrier lies between samples: wells on both sides of it do not join below it."""
    solution = hjsolve.solve(hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-3/10*cos(x) - cos(2*x)"))
    found = solution.torus(frequencies={"x": "0.6"})
    assert [motion.kinds["x"] for motion in found] == ["libration", "libration", "rotation"]
    top = 1.01125
    assert [float(motion.constants["E"].value) > top for motion in found] == [False, False, True]
    wells = [sorted(float(end.value) for end in motion.turning_points["x"]) for motion in found[:2]]
    assert sorted(np.cos(np.mean(ends)) > 0 for ends in wells) == [False, True]
    for motion in found:
        E = motion.constants["E"].value
        if motion.kinds["x"] == "libration":
            rate = rate_between(
                lambda x: -3 * np.cos(x) / 10 - np.cos(2 * x), E, *(end.value for end in motion.turning_points["x"])
            )
        else:
            x = np.arange(4000) * 2 * np.pi / 4000
            rate = 1 / np.mean(1 / np.sqrt(2 * (E + 3 * np.cos(x) / 10 + np.cos(2 * x))))
        np.testing.assert_allclose(rate, 0.6, rtol=1e-9, atol=0)
