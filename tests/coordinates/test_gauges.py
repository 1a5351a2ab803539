"""Terms linear in the velocities in any gauge: against closed forms of the uniform field, and against Newton's law."""

from __future__ import annotations

import numpy as np
import pytest
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


def test_where_no_shift_leaves_the_forces_alone_it_is_said():
    with pytest.raises(hjsolve.NotSeparableError, match="in any gauge"):
        hjsolve.solve(found(GAUGES["symmetric"], "x**4 + y**4"), coordinates="find")
