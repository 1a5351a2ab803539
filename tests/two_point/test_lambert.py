"""Lambert's problem: every conic through two places, against Lagrange's equation and Kepler's to 40 digits."""

from __future__ import annotations

from functools import cache

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError
from hjsolve.scenes.extrapolated_flow import PARTS
from hjsolve.two_point.asked.question import read_question
from hjsolve.two_point.search.flow import RegularFlow

MP = mpmath.mp.clone()
MP.dps = 40


@cache
def kepler():
    return hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


def after(q, p, T):
    """Where a body is after a time (m = k = 1), by Stumpff's functions and the universal variable, to 40 digits."""
    r0, _ = q
    vr, h = p[0], p[1]
    x, y = MP.mpf(r0), MP.mpf(0)
    vx, vy = MP.mpf(vr), MP.mpf(h) / r0
    alpha = 2 / x - (vx**2 + vy**2)
    σ = x * vx

    def stumpff(z):
        if abs(z) < MP.mpf(10) ** -8:
            return [MP.nsum(lambda j, k=k: (-z) ** j / MP.factorial(2 * j + k), [0, 12]) for k in (2, 3)]
        s = MP.sqrt(abs(z))
        if z > 0:
            return (1 - MP.cos(s)) / z, (s - MP.sin(s)) / s**3
        return (1 - MP.cosh(s)) / z, (MP.sinh(s) - s) / s**3

    def time(χ):
        c, d = stumpff(alpha * χ**2)
        return σ * χ**2 * c + (1 - x * alpha) * χ**3 * d + x * χ

    low, high = MP.mpf(0), MP.mpf(1)
    while time(high) < T:
        high *= 2
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if time(middle) < T else (low, middle)
    χ = MP.findroot(lambda u: time(u) - T, (low, high), solver="anderson", tol=MP.mpf(10) ** -60)
    c, d = stumpff(alpha * χ**2)
    f, g = 1 - χ**2 * c / x, T - χ**3 * d
    X, Y = f * x + g * vx, f * y + g * vy
    return MP.sqrt(X**2 + Y**2), MP.atan2(Y, X)


def refined(q0, q1, T, p):
    """Momenta near some that lead to q1 exactly."""
    p = [MP.mpf(float(v)) for v in p]

    def miss(p):
        r, θ = after([q0[0], 0], p, T)
        turn = (θ - (q1[1] - q0[1])) / (2 * MP.pi)
        return MP.matrix([r - q1[0], 2 * MP.pi * (turn - MP.nint(turn))])

    for _ in range(3):
        y, h = miss(p), MP.mpf(10) ** -18
        columns = [miss([p[0] + h, p[1]]) - y, miss([p[0], p[1] + h]) - y]
        J = MP.matrix([[columns[0][0] / h, columns[1][0] / h], [columns[0][1] / h, columns[1][1] / h]])
        step = MP.lu_solve(J, -y)
        p = [p[0] + step[0], p[1] + step[1]]
    assert MP.norm(miss(p)) < MP.mpf(10) ** -28
    return p


def problems(n, seed):
    rng = np.random.default_rng(seed)
    q0 = {"r": 10 ** rng.uniform(-0.5, 0.5, n), "theta": rng.uniform(-3, 3, n)}
    q1 = {"r": 10 ** rng.uniform(-0.5, 0.5, n), "theta": rng.uniform(-3, 3, n)}
    return q0, q1, 10 ** rng.uniform(-1, 2, n)


@pytest.mark.parametrize("rows", [3, pytest.param(400, marks=pytest.mark.nightly)])
def test_momenta_are_within_their_errors_of_momenta_that_lead_to_q1_by_keplers_equation(rows):
    q0, q1, T = problems(rows, 5)
    table = kepler().two_point(q0=q0, q1=q1, time=T, turns=range(6))
    chosen = np.random.default_rng(1).choice(len(table), rows, replace=False)
    for i in chosen:
        j = table.problem[i]
        places = [[MP.mpf(float(q["r"][j])), MP.mpf(float(q["theta"][j]))] for q in (q0, q1)]
        p = [table.p0["r"].value[i], table.p0["theta"].value[i]]
        exact = refined(*places, MP.mpf(float(T[j])), p)
        assert abs(exact[0] - MP.mpf(p[0])) <= table.p0["r"].error[i]
        assert abs(exact[1] - MP.mpf(p[1])) <= table.p0["theta"].error[i]


@pytest.mark.parametrize("count", [12, pytest.param(300, marks=pytest.mark.nightly)])
def test_there_are_as_many_conics_as_lagranges_equation_has_roots(count):
    q0, q1, T = problems(count, 7)
    table = kepler().two_point(q0=q0, q1=q1, time=T, turns=range(1, 6))
    r0, r1, θ = q0["r"], q1["r"], (q1["theta"] - q0["theta"]) % (2 * np.pi)
    c = np.sqrt(r0**2 + r1**2 - 2 * r0 * r1 * np.cos(θ))
    s = (r0 + r1 + c) / 2
    u = np.linspace(0, 1, 40_001)[1:-1]  # α/2π along all ellipses, from one that is nearly a parabola to the other
    for j in range(count):
        for way, sweep in ((1, θ[j]), (-1, 2 * np.pi - θ[j])):
            α = 2 * np.pi * u
            a = s[j] / (2 * np.sin(α / 2) ** 2)
            β = 2 * np.arcsin(np.sqrt((s[j] - c[j]) / (2 * a))) * (1 if sweep < np.pi else -1)
            for N in range(1, 6):
                t = a**1.5 * (2 * np.pi * N + α - β - np.sin(α) + np.sin(β))
                expected = int(np.sum(np.diff(np.sign(t - T[j])) != 0))
                rows = (table.problem == j) & (table.way == way) & (table.turns == N)
                assert rows.sum() == expected


@pytest.mark.parametrize("turns", [0, 1])
def test_derivatives_of_S_are_the_momenta_and_the_energy(turns):
    T, h = 30.0, 1e-5
    base = [1.0, 0.0, 2.0, 1.5, T]
    moved = [base] + [[*base[:k], base[k] + d, *base[k + 1 :]] for k in range(5) for d in (h, -h)]
    columns = np.array(moved).T
    table = kepler().two_point(
        q0={"r": columns[0], "theta": columns[1]},
        q1={"r": columns[2], "theta": columns[3]},
        time=columns[4],
        turns=turns,
    )
    count = int(np.sum(table.problem == 0))
    S = table.principal_function.value.reshape(11, count)
    slopes = [(S[2 * k + 1] - S[2 * k + 2]) / (2 * h) for k in range(5)]
    first = slice(0, count)
    expected = [
        -table.p0["r"].value[first], -table.p0["theta"].value[first], table.p1["r"].value[first],
        table.p1["theta"].value[first], -table.energy.value[first],
    ]  # fmt: skip
    for slope, value in zip(slopes, expected, strict=True):
        np.testing.assert_allclose(slope, value, rtol=2e-8, atol=0)


@pytest.mark.nightly
def test_the_motion_runs_from_one_place_to_the_other_and_has_the_same_S():
    found = kepler().two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": "pi/2"}, time=30, turns=range(2))
    assert found.complete
    assert [c.turns for c in found] == [0, 0, 1, 1, 1, 1]
    for c in found:
        state = c.motion.at(30)
        assert abs(state.q["r"] - 2) <= 2e-14
        assert abs(state.q["theta"] - np.pi / 2) <= 1e-14
        assert abs(state.p["r"] - c.p1["r"].value) <= c.p1["r"].error + state.error.p["r"]
        assert c.motion.principal_function(30).agrees(c.principal_function)
        assert c.motion.constants["E"].agrees(c.energy)


def passed(solution, connections, **asked):
    """Conjugate points along connections, by their variations."""
    question, values = read_question(solution, parameters=None, digits=15, **asked)
    flow = RegularFlow(question, values)
    p = np.array([[float(e.value) for e in c.p0.values()] for c in connections]).T
    return flow.run(p, tolerance=1e-12, parts=PARTS, count=True).index.tolist()


@pytest.mark.parametrize("turns", [0, pytest.param(range(1, 4), marks=pytest.mark.nightly)])
def test_conjugate_points_are_those_that_the_variations_pass(turns):
    asked = {"q0": {"r": 1, "theta": 0}, "q1": {"r": 1.3, "theta": 3}, "time": 45, "turns": turns}
    found = kepler().two_point(**asked)
    assert passed(kepler(), found, **asked) == [c.conjugate_points for c in found]


@pytest.mark.nightly
def test_conjugate_points_in_space_count_the_half_turns_too():
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-spherical"))
    q0, q1 = {"r": 1, "theta": "1.2", "phi": 0}, {"r": 2, "theta": 1, "phi": 1}
    asked = {"q0": q0, "q1": q1, "time": 20, "turns": range(2)}
    found = solution.two_point(**asked)
    assert passed(solution, found, **asked) == [c.conjugate_points for c in found]
    for c in found:
        state = c.motion.at(20)
        assert abs(state.q["r"] - 2) < 1e-13
        assert abs(state.q["phi"] - 1) < 1e-13


def test_places_in_one_direction_are_joined_on_the_line_alone():
    found = kepler().two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": 0}, time=3, turns=range(3))
    assert len(found) == 1
    assert found[0].p0["theta"].value == 0
    state = found[0].motion.at(3)
    assert abs(state.q["r"] - 2) < 1e-14
    assert found[0].motion.principal_function(3).agrees(found[0].principal_function)


def test_half_a_turn_in_the_plane_has_one_conic_each_way():
    found = kepler().two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": "pi"}, time=3, turns=0)
    one, other = (c.p0 for c in found)
    assert one["theta"].value == -other["theta"].value
    assert one["r"].value == other["r"].value


@pytest.mark.parametrize("shift", ["-1e-9", "0", "1e-9"])
def test_next_to_the_parabola_the_energy_passes_zero(shift):
    # from r = 1 at the pericentre of a parabola (v² = 2) a quarter turn takes √2·(1 + 1/3)
    T = f"4*sqrt(2)/3 + {shift}"
    c = kepler().two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": "pi/2"}, time=T, turns=0)[0]
    assert c.energy.error < 1e-14
    if shift == "0":
        assert abs(c.energy.value) <= c.energy.error
        assert abs(c.p0["theta"].value - np.sqrt(2)) <= c.p0["theta"].error
    else:
        assert np.sign(c.energy.value) == -np.sign(float(shift))
        assert abs(c.energy.value) < 1e-8


def test_the_same_place_after_a_period_is_a_continuum_and_its_least_time_is_that_of_the_fall():
    place = {"r": 1, "theta": 0}
    found = kepler().two_point(q0=place, q1=place, time="2*pi", turns=1)
    assert len(found) == 0
    assert found.continua[0].free == ("the direction of the velocity at q0",)
    assert abs(found.continua[0].energy.value + 0.5) <= 1e-15
    none = kepler().two_point(q0=place, q1=place, time="0.1", turns=1)
    assert not none.continua
    assert abs(none.least_time.value - 2 * np.pi / np.sqrt(8)) < 1e-15


def test_below_the_least_time_there_is_none_and_above_it_there_are_two():
    ask = {"q0": {"r": 1, "theta": 0}, "q1": {"r": 2, "theta": 1}, "turns": 1}
    least = kepler().two_point(**ask, time=1).least_time.value
    counts = [len(kepler().two_point(**ask, time=least * (1 + d))) for d in (-1e-12, 1e-12)]
    assert counts == [0, 4] or counts == [0, 2]


def test_opposite_places_in_space_leave_the_plane_free():
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-spherical"))
    q1 = {"r": "1.5", "theta": "pi - 1.2", "phi": "pi"}
    found = solution.two_point(q0={"r": 1, "theta": "1.2", "phi": 0}, q1=q1, time=20, turns=range(2))
    assert len(found) == 0
    assert {c.free for c in found.continua} == {("the plane of the orbit",)}
    assert len(found.continua) == 3


@pytest.mark.nightly
def test_thirty_digits():
    c = kepler().two_point(q0={"r": 1, "theta": 0}, q1={"r": 2, "theta": 1}, time=40, turns=1, digits=30)[0]
    assert abs(c.motion.at(40).q["r"] - 2) < 1e-28


@pytest.mark.parametrize(
    "change",
    [
        {"time": 0},
        {"time": -1},
        {"turns": -1},
        {"turns": []},
        {"turns": "all"},
        {"q1": {"r": 1}},
        {"q1": {"r": -1, "theta": 0}},
    ],
)
def test_bad_input_is_one_error(change):
    good = {"q0": {"r": 1, "theta": 0}, "q1": {"r": 2, "theta": 1}, "time": 3, "turns": 0}
    with pytest.raises(InvalidInputError):
        kepler().two_point(**{**good, **change})
