"""Terms linear in the velocities in any gauge: against closed forms of the uniform field, and against Newton's law."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve

START = {"x": "1/3", "y": "-1/2", "z": 0}
SPEED = {"x": 1, "y": "1/4", "z": "1/2"}
GAUGES = {
    "symmetric": "(x*dot(y) - y*dot(x))",
    "skew": "(x*dot(y) - y*dot(x)) + 3*x**2*y**2*dot(x) + 2*x**3*y*dot(y)",
    "with z": "(x*dot(y) - y*dot(x)) + z*cos(x)*dot(x) + sin(x)*dot(z)",
}
"""a·ẋ of F = 2 along z."""


def found(gauge, V, names="xyz"):
    T = " + ".join(f"dot({c})**2/2" for c in names)
    return hjsolve.System(dict.fromkeys(names, "line"), f"{T} + {gauge}", V, parameters={"E": 1})


def drifting(t, E):
    """x of ẍ = E + 2 ẑ × …: circles of frequency 2 round a centre that drifts with (E × B)/B²."""
    x, y, vx, vy = mp.mpf(1) / 3, mp.mpf(-1) / 2, mp.mpf(1), mp.mpf(1) / 4
    drift = mp.mpc(E[1], -E[0]) / 2
    w = (mp.mpc(vx, vy) - drift) / mp.mpc(0, -2)
    z = mp.mpc(x, y) + drift * t + w * (mp.expj(-2 * t) - 1)
    return z.real, z.imag


@pytest.mark.parametrize("gauge", GAUGES.values(), ids=GAUGES)
@pytest.mark.parametrize(("V", "E"), [("0", (0, 0)), ("-E*x", (1, 0)), ("-E*(x + 2*y)", (1, 2))])
def test_a_uniform_field_in_any_gauge(gauge, V, E):
    motion = hjsolve.solve(found(gauge, V), coordinates="find").motion(q=START, velocity=SPEED)
    times = [-3.5, 0, 1, 20]
    states = motion.at(times)
    for m, t in enumerate(times):
        with mp.workdps(40):
            truth = (*drifting(mp.mpf(t), E), mp.mpf(t) / 2)
            for name, true in zip("xyz", truth, strict=True):
                assert abs(states.q[name][m] - true) <= states.error.q[name][m] <= 1e-12


@pytest.mark.parametrize("gauge", GAUGES.values(), ids=GAUGES)
def test_momenta_are_those_of_the_gauge_given(gauge):
    """p − a = ẋ, and started by p the motion is the same."""
    system = found(gauge, "cos(x + y)/3 + z**2/2")
    solution = hjsolve.solve(system, coordinates="find")
    state = solution.motion(q=START, velocity=SPEED).at("1.75")
    a = hjsolve.System(dict.fromkeys("xyz", "line"), " + ".join(f"dot({c})**2/2" for c in "xyz") + " + " + gauge, "0")
    at = {c.symbol: state.q[c.name] for c in a.coordinates} | {
        c.velocity: state.velocity[c.name] for c in a.coordinates
    }
    for c in a.coordinates:
        own = float(a.kinetic.diff(c.velocity).subs(at))
        assert abs(state.p[c.name] - own) <= state.error.p[c.name] + 1e-15 * 10
    start = solution.motion(q=START, velocity=SPEED).at(0)
    again = solution.motion(q=START, p={c: repr(float(start.p[c])) for c in "xyz"}).at("1.75")
    assert np.allclose([again.q[c] for c in "xyz"], [state.q[c] for c in "xyz"], rtol=0, atol=1e-13)


def test_the_motion_in_a_field_that_is_not_uniform_obeys_newton():
    """ẍ = ẏ F, ÿ = −ẋ F − ∂V/∂y with F = ∂ₓa_y − ∂ᵧaₓ = x, checked by differences of 50 digits."""
    refused = found("x**2*dot(y)/3 - x*y*dot(x)/3", "y/4", "xy")  # F allows shifts along y alone, V along x alone
    with pytest.raises(hjsolve.NotSeparableError):
        hjsolve.solve(refused, coordinates="find")
    motion = hjsolve.solve(found("x**2*dot(y)/3 - x*y*dot(x)/3", "x/4", "xy"), coordinates="find").motion(
        q={"x": "1/2", "y": 1}, velocity={"x": 1, "y": "-1/3"}, digits=50
    )
    steps = motion.at(["999999999999/1000000000000", 1, "1000000000001/1000000000000"])
    with mp.workdps(60):
        x, y = ([mp.mpf(str(e)) for e in steps.q[c]] for c in "xy")
        vx, vy = (mp.mpf(str(steps.velocity[c][1])) for c in "xy")
        for q, force in ((x, vy * x[1] - mp.mpf(1) / 4), (y, -vx * x[1])):
            assert abs((q[2] - 2 * q[1] + q[0]) * mp.mpf(10) ** 24 - force) < 1e-20


def test_ensembles_and_single_motions_agree_in_another_gauge():
    solution = hjsolve.solve(found(GAUGES["symmetric"], "x**2/2 + x**4/8 + z**2"), coordinates="find")
    q = {"x": [0.3, -1.2], "y": [0.1, 2.0], "z": [0.5, 0.7]}
    v = {"x": [0.4, 0.2], "y": [-0.9, 0.6], "z": [0.0, 1.0]}
    p = {"x": np.subtract(v["x"], q["y"]), "y": np.add(v["y"], q["x"]), "z": v["z"]}
    by_speed = hjsolve.ensemble(solution, q=q, velocity=v, want={"actions"}, compiled=False)
    by_p = hjsolve.ensemble(solution, q=q, p=p, want={"actions"}, compiled=False)
    for k in range(2):
        one = solution.motion(q={c: q[c][k] for c in "xyz"}, velocity={c: v[c][k] for c in "xyz"})
        for name in one.actions:
            for batch in (by_speed, by_p):
                assert abs(batch.actions[name][k] - one.actions[name].value) <= 1e-14


def test_w_depends_on_the_gauge_and_is_not_given():
    motion = hjsolve.solve(found(GAUGES["symmetric"], "-E*x"), coordinates="find").motion(q=START, velocity=SPEED)
    with pytest.raises(hjsolve.InvalidInputError, match=r"depend on the gauge.*as_solved"):
        motion.characteristic_function(1)
    assert motion.as_solved.characteristic_function(1).value


@pytest.mark.parametrize(("gauge", "V"), [
    (GAUGES["symmetric"], "x**4 + y**4"),
    pytest.param(GAUGES["symmetric"], "-1/sqrt(x**2 + y**2 + z**2)", marks=pytest.mark.nightly),  # Zeeman, in space
    ("x*dot(y)/sqrt(x**2 + y**2)", "(x**2 + y**2)**2 + z**2"),  # F = y²/ρ³
])  # fmt: skip
def test_where_nothing_leaves_the_forces_alone_it_is_said(gauge, V):
    with pytest.raises(hjsolve.NotSeparableError, match="in any gauge"):
        hjsolve.solve(found(gauge, V), coordinates="find")


ABOUT = {
    "symmetric gauge": ("x*dot(y)/4 - y*dot(x)/4", "-E/sqrt(x**2 + y**2)", "xy", "polar"),
    "Landau's gauge": ("-y*dot(x)/2", "-E/sqrt(x**2 + y**2)", "xy", "polar"),
    "Fock and Darwin": ("x*dot(y)/2", "E*(x**2 + y**2)/2", "xy", "polar"),
    "another centre": ("(x - 1)*dot(y)/2", "E*((x - 1)**2 + (y + 2)**2)**2 + z**2", "xyz", "circular cylinder"),
    "another axis": ("x*dot(z)/2", "-E/sqrt(x**2 + z**2) + y**4", "xyz", "circular cylinder"),
}


@pytest.mark.nightly_cases("another centre", "another axis", "Fock and Darwin")
@pytest.mark.parametrize("name", ABOUT)
def test_a_field_along_the_axis_of_the_forces(name):
    """Newton's law by differences of 40 digits: ẍ = F × ẋ − ∇V; the momentum about the axis, by hand, is the action."""
    gauge, V, names, kind = ABOUT[name]
    solution = hjsolve.solve(found(gauge, V, names), coordinates="find")
    assert solution.chart.kind == kind
    q, velocity = dict(zip(names, ("4/3", "1/5", "1/7"))), dict(zip(names, ("1/10", "9/10", "-3/10")))
    motion = solution.motion(q=q, velocity=velocity, digits=50)
    steps = motion.at(["1999999999999/1000000000000", 2, "2000000000001/1000000000000"])
    system = solution.system_as_given
    x, v = ([c.symbol for c in system.coordinates], [c.velocity for c in system.coordinates])
    L = system.kinetic - system.potential.subs({"E": 1})
    with mp.workdps(60):
        at = {s: sp.Float(str(steps.q[c][1]), 60) for s, c in zip(x, names, strict=True)}
        at |= {s: sp.Float(str(steps.velocity[c][1]), 60) for s, c in zip(v, names, strict=True)}
        for k, c in enumerate(names):
            force = sp.diff(L, x[k]) - sum(sp.diff(L, v[k], x[i]) * v[i] for i in range(len(names)))
            law = mp.mpf(str(sp.N(force.subs({p.symbol: 1 for p in system.parameters}).subs(at), 60)))
            place = [mp.mpf(str(e)) for e in steps.q[c]]
            assert abs((place[2] - 2 * place[1] + place[0]) * mp.mpf(10) ** 24 - law) < 1e-20


@pytest.mark.nightly
def test_a_monopole_and_a_centre_typed_in_cartesian_coordinates():
    """Dirac's a = g (x ẏ − y ẋ)/(r (r + z)): the motion is on a cone (Poincaré 1896); p_φ is conserved in any gauge."""
    a = "(x*dot(y) - y*dot(x))/(x**2 + y**2 + z**2 + z*sqrt(x**2 + y**2 + z**2))/4"
    solution = hjsolve.solve(found(a, "-1/sqrt(x**2 + y**2 + z**2)"), coordinates="find")
    assert solution.chart.kind == "spherical"
    motion = solution.motion(q={"x": 1, "y": "1/5", "z": "3/10"}, velocity={"x": "1/10", "y": "9/10", "z": "1/5"})
    states = motion.at(np.linspace(0, 20, 9))
    x, v = (np.array([group[c] for c in "xyz"], dtype=float) for group in (states.q, states.velocity))
    cone = np.cross(x, v, axis=0) - x / np.linalg.norm(x, axis=0) / 4  # L − e g r̂, constant
    assert np.allclose(cone, cone[:, :1], rtol=0, atol=1e-12)


def test_the_map_of_a_motion_in_a_field_is_symplectic_in_the_users_momenta():
    solution = hjsolve.solve(found("-y*dot(x)/2", "E*(x**2 + y**2)/2 + (x**2 + y**2)**2", "xy"), coordinates="find")
    motion = solution.motion(q={"x": 1, "y": "1/5"}, velocity={"x": "1/3", "y": "1/2"})
    M, Z = (
        motion.transition_matrix(3.0).value,
        np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]]),
    )
    assert np.allclose(M.T @ Z @ M, Z, rtol=0, atol=1e-12)


def test_motions_in_a_field_pass_the_axis():
    """p about the axis is zero where ẏ = −x/4: an oscillator in the frame that turns with half the field's frequency."""
    solution = hjsolve.solve(found("(x*dot(y) - y*dot(x))/4", "E*(x**2 + y**2)/2", "xy"), coordinates="find")
    states = solution.motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": "-1/4"}).at([1.0, 7.3])
    for m, t in enumerate((1.0, 7.3)):
        with mp.workdps(30):
            truth = mp.cos(mp.sqrt(mp.mpf(17) / 16) * t) * mp.expj(-mp.mpf(t) / 4)
            for name, true in (("x", truth.real), ("y", truth.imag)):
                assert abs(states.q[name][m] - true) <= states.error.q[name][m] <= 1e-12


@pytest.mark.parametrize(("names", "z"), [("xy", ""), ("xyz", ""), ("xyz", " + z**2")], ids=["plane", "along z", "space"])
def test_the_restricted_problem_of_three_bodies_is_refused(names, z):
    """The slopes of V at many places are surds; exact elimination of all of them at once had no end."""
    first, second = (f"sqrt((x + {at})**2 + y**2{z})" for at in ("mu", "mu - 1"))
    T = "((x' - y)**2 + (y' + x)**2)/2" + (" + z'**2/2" if "z" in names else "")
    rotating = hjsolve.System(dict.fromkeys(names, "line"), T, f"-(1 - mu)/{first} - mu/{second}", {"mu": "0.01215"})
    with pytest.raises(hjsolve.NotSeparableError, match="in any gauge"):
        hjsolve.solve(rotating, coordinates="find")
