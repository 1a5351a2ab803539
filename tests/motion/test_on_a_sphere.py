"""Motions on spheres in coordinates found, expressed in the user's angles: against Taylor series of L̇ = −x × ∇V, ẋ = L × x."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.errors import InvalidInputError, NotSeparableError
from tests.coordinates.test_find_coordinates_sphere import ANGLES, ROUND, on_sphere, random_rotation, seen_from
from tests.reference.taylor import Flow

PLACE = sp.symbols("x y z", real=True)
MOMENTA = sp.symbols("a b c", real=True)
WEBS = {
    "neumann": ("conical", lambda A, B, C: f"({A}**2 + 3*{B}**2 + 7*{C}**2)/2"),
    "kepler": ("spherical", lambda A, B, C: f"-{C}/sqrt({A}**2 + {B}**2)"),
}


def turned(name: str, seed: int):
    """A system in axes turned at random, and its V in space."""
    rotation = random_rotation(Random(seed))
    kind, write = WEBS[name]
    inside = sp.sympify(write("A", "B", "C"), locals=dict(zip("ABC", sp.symbols("A B C"), strict=True)))
    seen = (rotation * sp.Matrix(PLACE)).T.tolist()[0]
    return kind, on_sphere(write(*seen_from(rotation))), inside.subs(dict(zip(sp.symbols("A B C"), seen, strict=True)))


def flow(V, q, velocity) -> Flow:
    """The motion of H = (x × p)²/2 + V(x), which stays on |x| = 1 and is that of the sphere."""
    L = sp.Matrix(PLACE).cross(sp.Matrix(MOMENTA))
    θ, φ, θ1, φ1 = (mp.mpf(q["theta"]), mp.mpf(q["phi"]), mp.mpf(velocity["theta"]), mp.mpf(velocity["phi"]))
    s, c = mp.sin(θ), mp.cos(θ)
    x = [s * mp.cos(φ), s * mp.sin(φ), c]
    v = [c * mp.cos(φ) * θ1 - x[1] * φ1, c * mp.sin(φ) * θ1 + x[0] * φ1, -s * θ1]
    return Flow(sp.expand(L.dot(L)) / 2 + V, list(PLACE), list(MOMENTA), {}, [*x, *v], digits=28)


def assert_within_errors(state, x, p) -> None:
    """θ, φ, their velocities and momenta are those of a point of space, within the errors claimed."""
    along = mp.fdot(x, p)
    v = [b - along * a for a, b in zip(x, p, strict=True)]
    ρ, spin = mp.hypot(x[0], x[1]), x[0] * v[1] - x[1] * v[0]
    rates = {"theta": -v[2] / ρ, "phi": spin / ρ**2}
    exact = {"q": {"theta": mp.atan2(ρ, x[2]), "phi": mp.atan2(x[1], x[0])}, "velocity": rates,
             "p": {"theta": rates["theta"], "phi": spin}}  # fmt: skip
    assert state.status == "ok"
    for group, truth in exact.items():
        for name, value in truth.items():
            assert abs(mp.mpf(getattr(state, group)[name]) - value) <= getattr(state.error, group)[name]


@pytest.mark.nightly_cases("neumann")
@pytest.mark.parametrize("name", ["neumann", pytest.param("kepler", marks=pytest.mark.nightly)])
def test_random_motions_agree_with_the_equations_in_space_within_their_errors(name: str) -> None:
    kind, system, V = turned(name, 3)
    solution = hjsolve.solve(system, coordinates="find")
    assert solution.chart.kind == kind
    dice = Random(name)
    for _ in range(3 if name == "neumann" else 1):  # the series of the other takes ten seconds
        q = {"theta": f"{dice.uniform(0.2, 2.9):.3f}", "phi": f"{dice.uniform(-3, 3):.3f}"}
        velocity = {"theta": f"{dice.uniform(-1, 1):.3f}", "phi": f"{dice.uniform(-1, 1):.3f}"}
        motion = solution.motion(q=q, velocity=velocity)
        with mp.workdps(45):
            exact = flow(V, q, velocity)
            for t in ("0.75", "4"):
                found = exact.at(mp.mpf(t))
                state = motion.at(t)
                assert_within_errors(state, found[:3], found[3:])
                assert max(state.error.q.values()) < 1e-11


@pytest.mark.nightly
def test_a_motion_runs_close_by_the_pole_of_the_given_angles() -> None:
    """Started along the meridian 10⁻⁶ off, it passes the pole; φ turns by π there, and every digit is accounted for."""
    _, system, V = turned("neumann", 3)
    solution = hjsolve.solve(system, coordinates="find")
    q, velocity = {"theta": "0.000001", "phi": "0.3"}, {"theta": "-1", "phi": "1000"}
    motion = solution.motion(q=q, velocity=velocity)
    with mp.workdps(45):
        exact = flow(V, q, velocity)
        for t in ("0.000001", "0.000002", "0.5"):
            found = exact.at(mp.mpf(t))
            state = motion.at(t)
            assert_within_errors(state, found[:3], found[3:])
            assert state.error.q["theta"] < 1e-12  # by acos it would be 1e-8
    assert abs(motion.at("0.5").q["phi"] - motion.at(0).q["phi"]) > 3


@pytest.mark.nightly
def test_many_digits_are_right() -> None:
    _, system, V = turned("neumann", 3)
    q, velocity = {"theta": "1.1", "phi": "0.4"}, {"theta": "0.3", "phi": "0.9"}
    state = hjsolve.solve(system, coordinates="find").motion(q=q, velocity=velocity, digits=30).at("1.5")
    with mp.workdps(45):
        found = flow(V, q, velocity).at(mp.mpf("1.5"))
        exact = mp.atan2(found[1], found[0]), mp.atan2(mp.hypot(found[0], found[1]), found[2])
        for value, name in zip(exact, ("phi", "theta"), strict=True):
            assert state.error.q[name] <= 1e-26
            assert abs(state.q[name] - value) <= 1e-24


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "place"), [("b", "pi/2 - theta"), ("theta", "theta")])
def test_latitude_colatitude_mass_and_radius_are_the_same_motion(name: str, place: str) -> None:
    """m R² = 6 in another order of the names: V six times as large gives the same places."""
    _, system, _ = turned("neumann", 3)
    reference = hjsolve.solve(system, coordinates="find").motion(
        q={"theta": "1.1", "phi": "0.4"}, velocity={"theta": "0.3", "phi": "0.9"}
    )
    theta = sp.Symbol("theta")
    old = {c.symbol: sp.Symbol(c.name) for c in system.coordinates}
    V = sp.sympify(str(system.potential.xreplace(old))).subs(theta, sp.sympify(place).subs(theta, sp.Symbol(name)))
    coordinates = {"phi": "angle", name: "-pi/2 < b < pi/2" if name == "b" else "0 < theta < pi"}
    ρ = "cos(b)" if name == "b" else "sin(theta)"
    other = hjsolve.System(
        coordinates, f"m*R**2*(dot({name})**2 + {ρ}**2*dot(phi)**2)/2", f"m*R**2*({V})", {"m": "3/2", "R": 2}
    )
    start, sign = (sp.pi / 2 - sp.Rational("1.1"), -1) if name == "b" else (sp.Rational("1.1"), 1)
    motion = hjsolve.solve(other, coordinates="find").motion(
        q={name: start, "phi": "0.4"}, velocity={name: sign * sp.Rational("0.3"), "phi": "0.9"}
    )
    times = np.linspace(0, 9, 7)
    ours, theirs = motion.at(times), reference.at(times)
    shift = math.pi / 2 if name == "b" else 0.0
    for found, expected, error in (
        (ours.q["phi"], theirs.q["phi"], ours.error.q["phi"] + theirs.error.q["phi"]),
        (ours.q[name], shift + sign * theirs.q["theta"], ours.error.q[name] + theirs.error.q["theta"] + 3e-16),
        (ours.p["phi"], 6 * theirs.p["phi"], ours.error.p["phi"] + 6 * theirs.error.p["phi"] + 3e-15),
        (ours.p[name], 6 * sign * theirs.p["theta"], ours.error.p[name] + 6 * theirs.error.p["theta"] + 3e-15),
    ):
        assert np.all(np.abs(found - expected) <= error)


@pytest.mark.nightly
def test_what_is_not_done_on_a_sphere_is_said() -> None:
    mercator = hjsolve.System({"q": "line", "l": "angle"}, "(dot(q)**2 + dot(l)**2)/cosh(q)**2/2",
                              "tanh(q)**2 + cos(l)**2/cosh(q)**2/3")  # fmt: skip
    with pytest.raises(NotSeparableError, match="from the pole or the equator"):
        hjsolve.solve(mercator, coordinates="find")
    _, system, _ = turned("neumann", 3)
    start = {name: np.array([0.5, 0.6]) for name in ANGLES}
    with pytest.raises(InvalidInputError, match="ensembles are not started in the angles of a sphere"):
        hjsolve.ensemble(system, q=start, velocity=start, coordinates="find")
    half = hjsolve.System({**ANGLES, "theta": "0 < theta < pi/2"}, ROUND, system.potential)
    with pytest.raises(NotSeparableError):
        hjsolve.solve(half, coordinates="find")
