"""Motions with p_φ = 0 through poles, axes and r = 0: in the given coordinates and in those that were found."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.motion.through_poles.continuation import continued_coordinates
from tests.reference.taylor import Flow
from tests.support import hard_exact

pytestmark = pytest.mark.rotating_file(9)

R2, R3 = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"


def entry(name: str):
    return hjsolve.solve(hjsolve.catalog.load(name))


@pytest.mark.parametrize(("speed", "kind"), [("-1", "libration"), ("3", "rotation")])
def test_a_spherical_pendulum_swings_over_its_poles(speed: str, kind: str) -> None:
    motion = entry("spherical-pendulum").motion(
        q={"theta": 1, "phi": "1/2"}, velocity={"theta": speed, "phi": 0}, parameters={"g": 1}
    )
    assert motion.kinds == {"theta": kind, "phi": "ignorable"}
    with mp.workdps(50):
        k = mp.sqrt((mpf(speed) ** 2 / 2 + 1 - mp.cos(1)) / 2)
        turn = -1 if float(speed) < 0 else 1
        begin = mp.findroot(lambda t: hard_exact.pendulum(k, t)[0] - turn, turn * mpf("0.5"))
        for t in ("0.3", "1.7", "2.9", "7.5", "1e3", "-4.2"):
            state = motion.at(t)
            angle, rate = (turn * x for x in hard_exact.pendulum(k, begin + mpf(t)))
            angle = hard_exact.principal(angle)
            side = 1 if angle >= 0 else -1
            assert abs(mpf(state.q["theta"]) - abs(angle)) <= state.error.q["theta"] <= 1e-12
            assert abs(mpf(state.velocity["theta"]) - side * rate) <= state.error.velocity["theta"] <= 1e-12
            azimuth = mpf("0.5") if side > 0 else mpf("0.5") - mp.pi
            assert abs(hard_exact.principal(mpf(state.q["phi"]) - azimuth)) <= state.error.q["phi"] <= 1e-14
        period = hard_exact.pendulum_period(k)
        assert abs(mpf(motion.periods["theta"].value) - period) <= motion.periods["theta"].error


def test_a_polar_kepler_orbit_is_the_planar_one_at_any_time() -> None:
    polar = entry("kepler-spherical").motion(
        q={"r": 1, "theta": "pi/2", "phi": 0}, velocity={"r": 0, "theta": "1.1", "phi": 0}
    )
    plane = entry("kepler-planar").motion(q={"r": 1, "theta": "pi/2"}, velocity={"r": 0, "theta": "1.1"})
    times = np.linspace(-30, 3000, 40)
    one, other = polar.at(times), plane.at(times)
    assert np.all(one.status == "ok")
    x, z = (
        one.q["r"] * np.sin(one.q["theta"]) * np.cos(one.q["phi"]),
        one.q["r"] * np.cos(one.q["theta"]),
    )
    bound = 2 * (one.error.q["r"] + one.q["r"] * (one.error.q["theta"] + other.error.q["theta"]) + other.error.q["r"])
    assert np.all(abs(x - other.q["r"] * np.sin(other.q["theta"])) <= bound)
    assert np.all(abs(z - other.q["r"] * np.cos(other.q["theta"])) <= bound)
    assert np.all(bound <= 1e-12)
    assert polar.frequencies["theta"].value == plane.frequencies["theta"].value
    assert set(polar.constants) == {"E", "alpha_2", "p_phi", "p_theta"}
    again = pickle.loads(pickle.dumps(polar)).at(times)
    assert np.array_equal(again.q["phi"], one.q["phi"])


def test_an_ellipsoid_geodesic_over_both_poles_keeps_on() -> None:
    motion = entry("oblate-geodesics").motion(q={"beta": 0, "lambda_": 0}, velocity={"beta": 1, "lambda_": 0})
    assert motion.kinds == {"beta": "rotation", "lambda_": "ignorable"}
    period = motion.periods["beta"].value
    state = motion.at([0.0, period / 2, period, 0.75 * period])
    assert np.all(abs(state.q["beta"][:3]) <= 1e-13)
    assert np.all(abs(np.cos(state.q["lambda_"][:3]) - [1, -1, 1]) <= 1e-13)
    assert abs(state.q["beta"][3] + np.pi / 2) <= 1e-13


def test_many_digits_through_a_pole() -> None:
    motion = entry("spherical-pendulum").motion(
        q={"theta": 1, "phi": 0}, velocity={"theta": -1, "phi": 0}, parameters={"g": 1}, digits=30
    )
    state = motion.at("5/2")
    with mp.workdps(50):
        k = mp.sqrt((mpf("1.5") - mp.cos(1)) / 2)
        begin = mp.findroot(lambda t: hard_exact.pendulum(k, t)[0] + 1, mpf("-0.5"))
        angle = -hard_exact.pendulum(k, begin + mpf("2.5"))[0]
        assert abs(state.q["theta"] - abs(angle)) <= state.error.q["theta"] <= 1e-27


FOUND = {
    "polar, through the centre": ("(x**2 + y**2)**2", ("0.3", "0.1"), ("0.3", "0.1")),
    "polar, from the centre": ("(x**2 + y**2)**2", ("0", "0"), ("0.3", "0.1")),
    "spherical, through the centre": ("(x**2 + y**2 + z**2)**2", ("0.3", "0.1", "0.7"), ("0.6", "0.2", "1.4")),
    "spherical, from the centre": ("(x**2 + y**2 + z**2)**2", ("0", "0", "0"), ("0.3", "0.1", "0.2")),
    "rotational parabolic, through the axis": (f"-1/{R3} + z/10", ("0.3", "0.1", "0.7"), ("0.3", "0.1", "0.1")),
    "rotational parabolic, from the axis": (f"-1/{R3} + z/10", ("0", "0", "0.7"), ("0.3", "0.1", "0.1")),
    "prolate, from the middle": (
        "-1/sqrt(x**2 + y**2 + (z - 1)**2) - 1/sqrt(x**2 + y**2 + (z + 1)**2)", ("0", "0", "0"), ("0.3", "0.5", "0"),
    ),
    "prolate, through the axis": (
        "-1/sqrt(x**2 + y**2 + (z - 1)**2) - 1/sqrt(x**2 + y**2 + (z + 1)**2)",
        ("0.4", "0.3", "0.5"), ("0.8", "0.6", "0.1"),
    ),
}  # fmt: skip


@pytest.mark.nightly_cases(
    "prolate, through the axis", "rotational parabolic, from the axis", "rotational parabolic, through the axis",
    "spherical, through the centre",
)  # fmt: skip
@pytest.mark.slow
@pytest.mark.parametrize("name", FOUND)
def test_found_coordinates_are_passed_through_their_axes_and_centres(name: str) -> None:
    potential, place, speed = FOUND[name]
    names = "xyz"[: len(place)]
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    system = hjsolve.System(dict.fromkeys(names, "line"), kinetic, potential)
    motion = hjsolve.solve(system, "find").motion(
        q=dict(zip(names, place, strict=True)), velocity=dict(zip(names, speed, strict=True))
    )
    with mp.workdps(40):
        begin = [mpf(sp.Rational(x).p) / sp.Rational(x).q for x in (*place, *speed)]
        places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
        flow = Flow(sum(p**2 for p in momenta) / 2 + system.potential, places, momenta, {}, begin, digits=22)
        for t in (0.0, 0.9, 2.3, 4.1):
            state, exact = motion.at(t), flow.at(mpf(t))
            assert state.status == "ok"
            for k, q in enumerate(names):
                assert abs(mpf(state.q[q]) - exact[k]) <= state.error.q[q] <= 1e-12
                assert abs(mpf(state.velocity[q]) - exact[len(names) + k]) <= state.error.velocity[q] <= 1e-11


def test_a_collision_stays_an_event() -> None:
    line = {"x": "line", "y": "line"}
    kepler = hjsolve.solve(hjsolve.System(line, "(dot(x)**2 + dot(y)**2)/2", f"-1/{R2}"), "find")
    fall = kepler.motion(q={"x": "0.6", "y": "0.8"}, velocity={"x": 0, "y": 0})
    assert abs(fall.boundary_times["r"].value - np.pi / np.sqrt(8)) <= fall.boundary_times["r"].error
    assert list(fall.at([1, 2]).status) == ["ok", "reaches_boundary"]
    stark = hjsolve.solve(hjsolve.System(line, "(dot(x)**2 + dot(y)**2)/2", f"-1/{R2} + x/1000000"), "find")
    fall = stark.motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": 0})
    assert "boundary" in fall.kinds.values()
    (time,) = fall.boundary_times.values()
    assert abs(time.value - np.pi / np.sqrt(8)) <= 1e-5
    state = fall.at([1, -1, 2, -2])
    assert list(state.status) == ["ok", "ok", "reaches_boundary", "reaches_boundary"]
    assert np.all(np.isnan(state.q["x"]) == [False, False, True, True])


@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential", "angle", "continued"),
    [
        ({"r": "0 < r", "phi": "angle"}, "dot(r)**2 + r**2*dot(phi)**2", "r**4", "phi", {"r": "line"}),
        ({"r": "0 < r", "phi": "angle"}, "dot(r)**2 + r**2*dot(phi)**2", "-1/r", "phi", None),  # V is infinite
        ({"r": "0 < r", "phi": "angle"}, "dot(r)**2 + r**2*dot(phi)**2", "r**3", "phi", None),  # V is not even
        ({"r": "0 < r", "phi": "angle"}, "dot(r)**2 + r**2*dot(phi)**2/4", "r**4", "phi", None),  # a cone
        ({"r": "0 < r < 2", "phi": "angle"}, "dot(r)**2 + sin(r)**2*dot(phi)**2", "0", "phi", {"r": "-2 < r < 2"}),
        (
            {"theta": "0 < theta < pi", "phi": "angle"},
            "dot(theta)**2 + sin(theta)**2*dot(phi)**2", "cos(theta)", "phi", {"theta": "angle"},
        ),
        (
            {"theta": "0 < theta < pi", "phi": "angle"},
            "dot(theta)**2 + sin(theta)**2*dot(phi)**2", "1/sin(theta)**2", "phi", None,
        ),
        (
            {"u": "0 < u", "v": "0 < v", "phi": "angle"},
            "(u**2 + v**2)*(dot(u)**2 + dot(v)**2) + u**2*v**2*dot(phi)**2", "-2/(u**2 + v**2)", "phi",
            {"u": "line", "v": "line"},
        ),
    ],
)  # fmt: skip
def test_the_form_of_t_and_v_decides_what_is_a_pole(coordinates, kinetic, potential, angle, continued) -> None:
    found = continued_coordinates(hjsolve.System(coordinates, kinetic, potential), angle)
    if continued is None:
        assert found is None
    else:
        assert {c.name: c.domain.written(c.name) for c in found.system.coordinates} == continued
