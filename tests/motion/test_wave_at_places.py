"""W as a function of place and branch: its derivatives are the momenta, its differences the integrals of them."""

from __future__ import annotations

import math

import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.errors import InvalidInputError, OutsideMotionError
from tests.support import entries

pytestmark = pytest.mark.rotating_file(18)


def started(name, digits):
    return entries.solved(name).motion(**{**entries.given(name), "digits": digits})


def moved_a_little(motion):
    """A time at which nothing has turned or ended yet, to be distinguished from t₀."""
    rates = [1 / abs(float(p.value)) for p in motion.periods.values()]
    step = 0.02 / max(rates) if rates else 0.01
    ends = [abs(float(e.value)) for e in motion.boundary_times.values()]
    return sp.Rational(str(round(min([step, *(e / 50 for e in ends)]), 9)))


def unwrapped(motion, state):
    return {c.name: state.unwrapped(c.name) for c in motion.solution.system.coordinates}


def branches(motion, state):
    """The signs of the shell momenta p + A."""
    solution, found = motion.solution, {}
    values = dict(motion.initial.values)
    for c in solution.system.coordinates:
        values |= {c.symbol: sp.Float(str(state.q[c.name]), 40), c.momentum: sp.Float(str(state.p[c.name]), 40)}
    for name in solution.coordinates:
        P = sp.N((solution.system.coordinate(name).momentum + solution.shift[name]).subs(values), 30)
        if abs(P) > 1e-20:
            found[name] = 1 if P > 0 else -1
    return found


@pytest.mark.entries
@pytest.mark.nightly_cases("neumann")
@pytest.mark.parametrize("name", entries.separable_with_effects())
def test_its_derivatives_are_the_momenta(name):
    """Over the whole catalog, with 40 digits, on the branch the motion is on; and W itself is that along the motion."""
    motion = started(name, 40)
    with mp.workdps(50):
        t = motion.t0 + moved_a_little(motion)
        state = motion.as_solved.at(t)
        q, branch = unwrapped(motion, state), branches(motion, state)
        here, along = motion.characteristic_function(q=q, branch=branch), motion.characteristic_function(t)
        cycles = [2 * mp.pi * abs(motion.actions[n].value) for n in motion.solution.coordinates if n in motion.actions]
        gaps = [here.value - along.value, *(here.value - along.value + s * c for c in cycles for s in (1, -1))]
        assert min(map(abs, gaps)) <= mpf(10) ** -30 * (1 + abs(here.value))
        h = mpf(10) ** -13
        for c in motion.solution.system.coordinates:
            if motion.kinds[c.name] == "equilibrium" or abs(mpf(str(state.velocity[c.name]))) < mpf(10) ** -6:
                continue
            ends = [motion.characteristic_function(q={**q, c.name: q[c.name] + s * h}, branch=branch) for s in (1, -1)]
            slope = (ends[0].value - ends[1].value) / (2 * h)
            assert abs(slope - state.p[c.name]) <= mpf(10) ** -15 * (1 + abs(slope)), c.name


@pytest.mark.nightly_cases("two-centres-plane")
@pytest.mark.parametrize(
    "name", ["pendulum", "kepler-spherical", "lagrange-top", "two-centres-plane", "stark", "morse"]
)
def test_differences_are_quadratures_of_the_momenta(name):
    """∫ p dq by 50-digit quadrature of the printed momentum, up on one branch and down on the other."""
    motion = started(name, 45)
    solution, values = motion.solution, dict(motion.initial.values)
    values |= {solution.constants[k].symbol: v for k, v in motion.initial.constants.items()}
    base = unwrapped(motion, motion.as_solved.at(motion.t0 + moved_a_little(motion)))
    with mp.workdps(55):
        for coordinate, (lower, upper) in motion.turning_points.items():
            if lower is None or upper is None:
                continue
            q = solution.system.coordinate(coordinate).symbol
            square = solution.momentum_squared[coordinate].subs({s: v for s, v in values.items() if s != q})
            low, high = (lower.value + (upper.value - lower.value) * part for part in (mpf("0.2"), mpf("0.9")))
            known = mp.quad(sp.lambdify(q, sp.sqrt(square), "mpmath"), mp.linspace(low, high, 9))
            for sign in (1, -1):
                W = motion.characteristic_function(q={**base, coordinate: [low, high]}, branch={coordinate: sign})
                assert abs(W.value[1] - W.value[0] - sign * known) <= mpf(10) ** -38 * (1 + known)


def test_doubles_claim_no_less_than_their_error():
    q, velocity = {"r": 1, "theta": 0}, {"r": "0.1", "theta": "1.2"}
    motion = hjsolve.solve("kepler-planar").motion(q=q, velocity=velocity)
    fine = hjsolve.solve("kepler-planar").motion(q=q, velocity=velocity, digits=30)
    places = {"r": [1.05, 1.3, 2.0], "theta": [[0.5], [9.0]]}
    approximate, exact = (m.characteristic_function(q=places, branch={"r": -1}) for m in (motion, fine))
    assert approximate.value.shape == (2, 3)
    assert (abs(approximate.value - exact.value.astype(float)) <= approximate.error).all()
    assert (approximate.error <= 1e-14 * (1 + abs(approximate.value))).all()


def test_the_branches_meet_at_turning_points_and_the_start_is_zero():
    motion = hjsolve.solve("pendulum").motion(q={"theta": "0.4"}, velocity={"theta": "-1.5"})
    low, high = (end.value for end in motion.turning_points["theta"])
    up, down = (motion.characteristic_function(q={"theta": [low, high]}, branch={"theta": s}).value for s in (1, -1))
    assert up[1] == pytest.approx(down[1], rel=1e-7)
    cycle = 2 * math.pi * motion.actions["theta"].value
    assert down[0] - up[0] == pytest.approx(cycle, rel=1e-7)
    assert abs(motion.characteristic_function(q={"theta": "0.4"}, branch={"theta": -1}).value) < 1e-14


@pytest.mark.parametrize(
    ("given", "error", "says"),
    [
        ({"q": {"r": 1}}, InvalidInputError, "every coordinate"),
        ({"q": {"r": 1, "theta": 0}, "branch": {"theta": 1}}, InvalidInputError, "no branches"),
        ({"q": {"r": 1, "theta": 0}, "branch": {"r": 2}}, InvalidInputError, "not 2"),
        ({"q": {"r": 40, "theta": 0}}, OutsideMotionError, "never reaches"),
        ({"t": 1, "q": {"r": 1, "theta": 0}}, InvalidInputError, "a time t, or places q"),
        ({}, InvalidInputError, "a time t, or places q"),
    ],
)
def test_what_is_refused_says_why(given, error, says):
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    with pytest.raises(error, match=says):
        motion.characteristic_function(**given)
