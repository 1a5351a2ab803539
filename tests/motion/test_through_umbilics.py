"""Motions through umbilics and foci: against great circles, the oscillator, the middle ellipse and Newton's law."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from tests.support import entries

h = "(p*cos(alpha)**2 + r*sin(beta)**2)"
SPHERE = {
    "x": "sin(alpha)*sqrt((p + r*sin(beta)**2)/(p + r))", "y": "cos(alpha)*sin(beta)",
    "z": "cos(beta)*sqrt((r + p*cos(alpha)**2)/(p + r))",
}  # fmt: skip
ELLIPTIC = {"x": "cosh(mu)*cos(nu)", "y": "sinh(mu)*sin(nu)"}
TIMES = ["-4", "0", "1/10", "1", "3", "20"]


def sphere():
    kinetic = f"{h}/2*(dot(alpha)**2/(p*cos(alpha)**2 + r) + dot(beta)**2/(p + r*sin(beta)**2))"
    return hjsolve.System({"alpha": "angle", "beta": "angle"}, kinetic, "0", {"p": 1, "r": 2}, place=SPHERE)


def oscillator():
    k = "(sinh(mu)**2 + sin(nu)**2)"
    V = "(cosh(mu)**2*cos(nu)**2 + sinh(mu)**2*sin(nu)**2)/2"
    return hjsolve.System({"mu": "line", "nu": "angle"}, f"{k}/2*(dot(mu)**2 + dot(nu)**2)", V, place=ELLIPTIC)


def held(state, truth, digits=15):
    for axis, column in truth.items():
        for found, true, error in zip(state.place[axis], column, state.error.place[axis], strict=True):
            assert abs(mp.mpf(found) - true) <= error <= 10.0 ** (3 - digits)


@pytest.mark.parametrize(
    "v", [("4/5*sqrt(2/3)", "3/5", "-4/5*sqrt(1/3)"), ("-sqrt(2/3)", 0, "sqrt(1/3)"), (0, "-1", 0)], ids=str
)
def test_great_circles_from_an_umbilic_of_conical_coordinates(v):
    motion = hjsolve.solve(sphere()).motion(q={"alpha": "pi/2", "beta": 0}, velocity=dict(zip("xyz", v, strict=True)))
    with mp.workdps(40):
        begin = [mp.sqrt(mp.mpf(1) / 3), mp.mpf(0), mp.sqrt(mp.mpf(2) / 3)]
        speed = [mp.mpf(str(exact(x))) for x in v]
        t = [mp.mpf(x.split("/")[0]) / int(x.partition("/")[2] or 1) for x in TIMES]
        truth = {a: [x * mp.cos(s) + u * mp.sin(s) for s in t] for a, x, u in zip("xyz", begin, speed, strict=True)}
        held(motion.at(TIMES), truth)


def exact(x):
    from hjsolve.formulas.read import number

    return number(x, source="x").evalf(40)


@pytest.mark.parametrize(
    "v",
    [("3/10", "7/10"), ("-1/2", 0), *(pytest.param(v, marks=pytest.mark.nightly) for v in ((-1, "1/5"), (0, 1)))],
    ids=str,
)
def test_the_oscillator_through_the_foci_of_elliptic_coordinates(v):
    motion = hjsolve.solve(oscillator()).motion(q={"mu": 0, "nu": 0}, velocity={"x": v[0], "y": v[1]}, digits=20)
    state = motion.at(TIMES)
    with mp.workdps(40):
        t = [mp.mpf(x.split("/")[0]) / int(x.partition("/")[2] or 1) for x in TIMES]
        vx, vy = (mp.mpf(str(exact(x))) for x in v)
        truth = {"x": [mp.cos(s) + vx * mp.sin(s) for s in t], "y": [vy * mp.sin(s) for s in t]}
        held(state, truth, 20)


def test_a_motion_that_starts_elsewhere_passes_the_foci_and_does_not_come_to_rest_there():
    """Its constants say that it will: it was told to stay at the focus for ever, with an error of 1e-15."""
    solution = hjsolve.solve(oscillator())
    focus = solution.motion(q={"mu": 0, "nu": 0}, velocity={"x": "3/10", "y": "7/10"}, digits=40)
    later = focus.at("1/2")
    motion = solution.motion(
        q={n: mp.nstr(later.q[n], 40) for n in later.q}, constants=dict(focus.initial.constants),
        signs={n: int(mp.sign(later.p[n])) for n in later.p}, t0="1/2",
    )  # fmt: skip
    assert set(motion.kinds.values()) == {"asymptotic"}
    times = [-3.0, 0.25, 1.0, 4.0, 9.0]
    state = motion.at(times)
    truth = {"x": [np.cos(s) + 0.3 * np.sin(s) for s in times], "y": [0.7 * np.sin(s) for s in times]}
    for axis, column in truth.items():
        assert np.allclose(state.place[axis], column, rtol=0, atol=2e-15)


@pytest.mark.nightly
def test_every_geodesic_from_an_umbilic_is_at_the_opposite_one_after_half_the_middle_ellipse():
    """Squares of the axes 1, 2, 4: half the perimeter of the middle ellipse is 4 E(3/4); one direction is along it."""
    solution = entries.solved("triaxial-geodesics")
    with mp.workdps(40):
        half = mp.nstr(4 * mp.ellipe(mp.mpf(3) / 4), 40)
    begin = np.array([np.sqrt(1 / 3), 0, np.sqrt(8 / 3)])
    for v in (("4/5*sqrt(1/3)", "3/5", "-4/5*sqrt(2/3)"), ("sqrt(1/3)", 0, "-sqrt(2/3)"), (0, 1, 0)):
        motion = solution.motion(q={"alpha": "pi/2", "beta": 0}, velocity=dict(zip("xyz", v, strict=True)))
        state = motion.at([half, f"2*{half}"])
        for axis, x in zip("xyz", begin, strict=True):
            assert np.allclose(state.place[axis], [-x, x], rtol=0, atol=1e-7)  # places go like √t in α and β
        assert np.allclose(motion.at("0").place["z"], begin[2], rtol=0, atol=1e-15)


@pytest.mark.parametrize("t", ["7", pytest.param("-13/2", marks=pytest.mark.nightly)])
def test_geodesics_obey_newton_after_umbilics_were_passed(t):
    """ẍ is normal to the ellipsoid and n·ẍ = −ẋᵀDẋ, by second differences of 50 digits."""
    solution = entries.solved("triaxial-geodesics")
    motion = solution.motion(
        q={"alpha": "pi/2", "beta": 0}, velocity={"x": "4/5*sqrt(1/3)", "y": "3/5", "z": "-4/5*sqrt(2/3)"}, digits=50
    )
    state = motion.at([f"{t} - 1/10**12", t, f"{t} + 1/10**12"])
    with mp.workdps(70):
        step, D = mp.mpf(10) ** -12, [mp.mpf(1), mp.mpf(1) / 2, mp.mpf(1) / 4]
        x = [[mp.mpf(str(v)) for v in state.place[a]] for a in "xyz"]
        bend = [(v[2] - 2 * v[1] + v[0]) / step**2 for v in x]
        speed = [(v[2] - v[0]) / (2 * step) for v in x]
        n = [d * v[1] for d, v in zip(D, x, strict=True)]
        size = -sum(d * u**2 for d, u in zip(D, speed, strict=True)) / sum(k**2 for k in n)
        assert all(abs(b - size * k) < 1e-20 for b, k in zip(bend, n, strict=True))
        assert abs(sum(u**2 for u in speed) - 1) < 1e-20


def test_a_place_that_is_more_than_a_branch_of_the_coordinates_ends_the_motion():
    """f = cos²α and g = 2 sin²β with equal factors: the surface has the tip of a cone there."""
    system = hjsolve.System(
        {"alpha": "angle", "beta": "angle"}, "(cos(alpha)**2 + 2*sin(beta)**2)/2*(dot(alpha)**2 + dot(beta)**2)", "0"
    )
    solution = hjsolve.solve(system)
    square = solution.momentum_squared["beta"]
    other = next(s for name, c in solution.constants.items() if name != "E" for s in [c.symbol])
    E = solution.constants["E"].symbol
    zero = solved(square.subs({E: 1, "beta": 0}).subs({s: 0 for s in square.free_symbols if s.name == "beta"}), other)
    motion = solution.motion(
        q={"alpha": "1/2", "beta": 1}, constants={"E": 1, other.name: zero}, signs={"alpha": 1, "beta": 1}
    )
    state = motion.at([0.0, 0.5, 100.0])
    assert list(state.status) == ["ok", "ok", "reaches_boundary"]
    assert np.isnan(state.q["alpha"][2])


def solved(f, symbol):
    import sympy as sp

    return sp.solve(f, symbol)[0]


def test_how_to_start_at_an_umbilic_is_said_and_velocities_out_of_the_surface_are_refused():
    solution = entries.solved("triaxial-geodesics")
    place = {"alpha": "pi/2", "beta": 0}
    with pytest.raises(hjsolve.InvalidInputError, match=r'umbilic: give the velocity in space, velocity={"x"'):
        solution.motion(q=place, velocity={"alpha": 1, "beta": 0})
    with pytest.raises(hjsolve.InvalidInputError, match="not tangent"):
        solution.motion(q=place, velocity={"x": 1, "y": 0, "z": 0})
    with pytest.raises(hjsolve.InvalidInputError, match="not tangent"):
        solution.motion(q={"alpha": "0.4", "beta": "0.7"}, velocity={"x": 1, "y": 0, "z": 0})


def test_a_velocity_in_space_starts_the_motion_of_its_rates():
    solution = hjsolve.solve(oscillator())
    one = solution.motion(q={"mu": 1, "nu": "1/2"}, velocity={"x": "1/3", "y": -2})
    x, y = np.cosh(1) * np.cos(0.5), np.sinh(1) * np.sin(0.5)
    place = one.at(0.7).place
    assert abs(place["x"] - (x * np.cos(0.7) + np.sin(0.7) / 3)) < 1e-14
    assert abs(place["y"] - (y * np.cos(0.7) - 2 * np.sin(0.7))) < 1e-14


def test_what_is_not_given_is_refused_and_it_travels():
    motion = hjsolve.solve(oscillator()).motion(q={"mu": 0, "nu": 0}, velocity={"x": 0, "y": 1})
    for call in (lambda: motion.characteristic_function(1), lambda: motion.angles(1), lambda: motion.time_at("mu", 1)):
        with pytest.raises(hjsolve.InvalidInputError, match="through umbilics"):
            call()
    assert pickle.loads(pickle.dumps(motion)).at(2.0) == motion.at(2.0)


@pytest.mark.parametrize("away", [pytest.param(k, marks=pytest.mark.nightly) for k in (1e-6, 1e-7)])
def test_claims_of_geodesics_that_start_next_to_an_umbilic(away):
    """Against the same with 40 digits: within the claim, and the claim within 1000 times the error or 1e3 roundings."""
    solution = entries.solved("triaxial-geodesics")
    given = {"q": {"alpha": f"pi/2 - {away!r}", "beta": repr(0.7 * away)}, "velocity": {"alpha": "1/3", "beta": "1/2"}}
    few, many = (solution.motion(**given, digits=digits) for digits in (15, 40))
    scale = float(few.constants["E"].value) ** -0.5
    times = [0.3 * scale, 2.0 * scale, 9.0 * scale]
    found, truth = few.at(times), many.at(times)
    for axis in "xyz":
        error = np.abs([float(mp.mpf(a) - b) for a, b in zip(found.place[axis], truth.place[axis], strict=True)])
        claim = found.error.place[axis]
        assert np.all(error <= claim)
        assert np.all(claim <= 1e3 * np.maximum(np.max(error), 1e-15))


@pytest.mark.nightly
def test_a_motion_in_x_and_y_starts_at_a_focus_of_the_coordinates_found():
    """V = r⁴/4 + x²/2 + 3y²/2 separates in elliptic coordinates with foci at x = ±2: Newton's law to 25 digits."""
    system = hjsolve.System(
        {"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "(x**2 + y**2)**2/4 + x**2/2 + 3*y**2/2"
    )
    solution = hjsolve.solve(system, coordinates="find")
    given = {"q": {"x": 2, "y": 0}, "velocity": {"x": "3/10", "y": "7/10"}}
    few, many = solution.motion(**given), solution.motion(**given, digits=50)
    state = many.at(["3 - 1/10**12", 3, "3 + 1/10**12"])
    with mp.workdps(70):
        x, y = ([mp.mpf(str(v)) for v in state.q[c]] for c in "xy")
        for v, push in ((x, x[1] + (x[1] ** 2 + y[1] ** 2) * x[1]), (y, 3 * y[1] + (x[1] ** 2 + y[1] ** 2) * y[1])):
            assert abs((v[2] - 2 * v[1] + v[0]) * mp.mpf(10) ** 24 + push) < 1e-20
        start = many.at("1/10**9")
        assert abs(mp.mpf(str(start.q["x"])) - 2 - mp.mpf(3) / 10**10) < 1e-16
        assert abs(mp.mpf(str(start.q["y"])) - mp.mpf(7) / 10**10) < 1e-16
    approximate = few.at(3.0)
    assert abs(approximate.q["x"] - float(x[1])) <= approximate.error.q["x"] <= 1e-12
