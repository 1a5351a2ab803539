"""One coordinate: branches, enclosures of times of travel, and completeness against shooting."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.arithmetic.interval import Interval
from hjsolve.two_point.one_freedom.high_energies import far_time
from hjsolve.two_point.one_freedom.line_branches import branches
from hjsolve.two_point.one_freedom.proved_search import TravelTimes, all_energies
from hjsolve.two_point.one_freedom.travel_time import Line, across, outward

Q = sp.Symbol("q", real=True)
INF = float("inf")


def pendulum():
    return Line(Q, -sp.cos(Q), 1 / sp.sqrt(2), {}, (-INF, INF), 2 * np.pi)


def quarter(E, start):
    """The time of a pendulum from a place to its upper turning point, by q = b − z²."""
    b = np.arccos(-E)
    x, w = np.polynomial.legendre.leggauss(200)
    z = np.sqrt(b - start) * (x + 1) / 2
    return float(np.sum(w * 2 * z / np.sqrt(2 * (E + np.cos(b - z * z)))) * np.sqrt(b - start) / 2)


def test_branches_between_two_places_are_numbered_by_direction_and_turning_points():
    found = [(b.sign, b.direct, b.upper, b.lower, b.turns) for b in branches(1, 0)]
    assert found == [(1, 1, 0, 0, 0), (1, 1, 1, 0, 0), (-1, 1, 0, 1, 0), (-1, 1, 1, 1, 0)]
    assert [b.turns for b in branches(0, 1)] == [0, 1, 1, 0, 1, 1]


@pytest.mark.parametrize("E", [-0.5, 0.0, 0.9])
def test_times_to_the_turning_point_and_their_slopes_are_enclosed(E):
    part = outward(pendulum(), 1.0, 1, Interval(E, E), 384)
    slope = (quarter(E + 1e-6, 1.0) - quarter(E - 1e-6, 1.0)) / 2e-6
    assert part.turns
    assert part.time.low <= quarter(E, 1.0) <= part.time.high < part.time.low * 1.01
    assert part.slope.low <= slope <= part.slope.high
    wide = outward(pendulum(), 1.0, 1, Interval(E, E + 0.01), 96)
    for at in (E, E + 0.005, E + 0.01):
        assert wide.time.low <= quarter(at, 1.0) <= wide.time.high


def test_a_direct_way_is_faster_the_more_energy_there_is():
    part = across(pendulum(), 0.3, 1.0, Interval(0.0, 0.1), 96)
    x, w = np.polynomial.legendre.leggauss(60)
    q = 0.65 + 0.35 * x
    true = [float(np.sum(w / np.sqrt(2 * (E + np.cos(q)))) * 0.35) for E in (0.0, 0.05, 0.1)]
    assert part.slope.high < 0
    assert all(part.time.low <= t <= part.time.high for t in true)


def test_above_the_barrier_a_pendulum_does_not_turn():
    assert outward(pendulum(), 1.0, 1, Interval(1.1, 2.0), 96).turns is False


@pytest.mark.parametrize("gap", [1e-8, 1e-13])
def test_the_time_to_a_turning_point_is_long_next_to_the_barrier(gap):
    # with V = −cos q: from q the time to the turning point near π is ∫ dq/√(2(E − V)), and E = 1 − gap
    E = 1 - gap
    part = outward(pendulum(), 2.9, 1, Interval(E, E + gap / 2), 384)
    t = np.linspace(0, np.arccosh((np.pi - 2.9) / np.sqrt(2 * gap)), 20_001)
    x = np.sqrt(2 * gap) * np.cosh(t)  # π − q, and E − V = x²/2 − gap to a part in x²
    dx = np.sqrt(2 * gap) * np.sinh(t)
    exact = 2 * np.sin(x / 2) ** 2 - gap
    true = np.trapezoid(np.where(exact > 0, dx / np.sqrt(2 * np.maximum(exact, 1e-300)), 1.0), t)
    assert 0.55 * true < part.time.low < true


def test_times_at_all_high_energies_are_bounded_for_a_quartic_and_for_a_weight():
    quartic = Line(Q, Q**4 / 4 - Q**2 / 2, 1 / sp.sqrt(2), {}, (-INF, INF), 0.0)
    bound = far_time(quartic, 1.0, 1, 1e9).time.high
    assert outward(quartic, 1.0, 1, Interval(4e9, 4e9), 384).time.high < bound < 0.1
    weight = Line(Q, Q, 1 / sp.sqrt(2), {}, (-INF, INF), 0.0)
    assert far_time(weight, 1.0, 1, 1e9).time.low > 1e3


def shot(system, q0, q1, T, most, starts):
    """Momenta that lead to q1, by sign changes of the miss along a fine row of momenta; classical Runge–Kutta."""
    rhs = system.rhs()
    p = np.linspace(-most, most, starts)
    y = np.array([np.full(starts, q0), p])
    steps = int(400 * T)
    h = T / steps
    for _ in range(steps):
        a = rhs(0, y)
        b = rhs(0, y + h / 2 * a)
        c = rhs(0, y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rhs(0, y + h * c))
    k = np.floor((y[0] - q1) / (2 * np.pi))
    cells = np.flatnonzero(np.diff(k))
    return [(p[i], p[i + 1]) for i in cells for _ in range(int(abs(k[i + 1] - k[i])))]


@pytest.mark.nightly
@pytest.mark.parametrize(("q0", "q1", "T"), [("0.3", "1", 2), ("-1/2", "1/2", 3), ("2", "2", "2.5"), ("3", "-1", 4)])
def test_a_pendulum_to_five_turns_is_complete_against_shooting(q0, q1, T):
    system = hjsolve.catalog.load("pendulum")
    found = hjsolve.solve(system).two_point(q0={"theta": q0}, q1={"theta": q1}, time=T, turns=range(6), budget=1000)
    assert found.complete
    # to five turns: momenta below those that turn six times
    fastest = max(abs(c.p0["theta"].value) for c in found)
    cells = shot(system, float(sp.Rational(q0)), float(sp.Rational(q1)), float(T), 1.02 * fastest, 60_001)
    own = sorted(c.p0["theta"].value for c in found)
    inside = [(a, b) for a, b in cells if any(a - 1e-3 <= p <= b + 1e-3 for p in own)]
    assert len(inside) == len(cells) == len(own)


@pytest.mark.nightly
def test_a_double_well_is_complete_and_each_motion_ends_at_q1():
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4 - x**2/2")
    found = hjsolve.solve(system).two_point(q0={"x": "-1/2"}, q1={"x": 1}, time=5, turns=range(2), budget=1000)
    assert found.complete
    assert len(found) == 8
    for c in found:
        state = c.motion.at(5)
        assert abs(state.q["x"] - 1) < 1e-13
        assert abs(state.p["x"] - c.p1["x"].value) <= c.p1["x"].error


def test_all_energies_of_a_bounded_problem_are_isolated():
    times = TravelTimes(pendulum(), 0.3, 1.0)
    proof = all_energies(times, list(branches(1, 0)), 9.0, 1.0)
    assert not proof.undecided
    assert len(proof.energies) == 3
    for energy in proof.energies:
        E = energy.value
        D = across(times.line, 0.3, 1.0, Interval(E, E), 1536).time
        U, L = (outward(times.line, at, s, Interval(E, E), 1536).time for at, s in ((1.0, 1), (0.3, -1)))
        b = energy.branch
        total = [b.direct * d + 2 * b.upper * u + 2 * b.lower * low for d, u, low in zip(D, U, L, strict=True)]
        assert total[0] < 9.0 * 1.001
        assert total[1] > 9.0 * 0.999


def test_a_proof_that_runs_out_of_time_leaves_the_rest_to_a_search():
    pendulum_ = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    found = pendulum_.two_point(q0={"theta": "0.3"}, q1={"theta": 1}, time=2, budget=0)
    assert not found.complete
    assert "budget=" in str(found.complete)
    assert len(found) >= 1
