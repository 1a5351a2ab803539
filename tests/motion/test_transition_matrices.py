"""Transition matrices against closed forms, variational equations and differences of motions of many digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve import System
from hjsolve.errors import InvalidInputError

many = mpmath.mp.clone()
many.dps = 40


@pytest.fixture(scope="module")
def kepler():
    return hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


def pendulum():
    return hjsolve.solve(System({"x": "angle"}, "dot(x)**2/2", "-cos(x)"))


def J(n):
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])


def assert_claims(found, truth):
    """Every entry is as near to the truth as is claimed, and no claim is idle."""
    truth = np.array(truth, dtype=object)
    true = np.abs(np.vectorize(many.convert, otypes=[object])(found.value) - truth).astype(float)
    assert (true <= found.error + 1e-25).all(), (true, found.error)
    assert found.error.max() <= 1e-13 * max(1.0, float(np.abs(truth).max()))


def by_differences(solution, motion, t, digits=42, step=15):
    """(f(h) − f(−h))/2h of motions of many digits, column after column."""
    names, initial = [c.name for c in solution.system.coordinates], motion.initial.values
    columns = []
    for group in ("q", "p"):
        for name in names:
            found = []
            for sign in (1, -1):
                base = {
                    "q": {c.name: initial[c.symbol] for c in solution.system.coordinates},
                    "p": {c.name: initial[c.momentum] for c in solution.system.coordinates},
                }
                base[group][name] += sign * sp.Rational(1, 10**step)
                state = solution.motion(**base, digits=digits).at(t)
                found.append([state.unwrapped(n) for n in names] + [state.p[n] for n in names])
            half = many.mpf(10) ** step / 2
            columns.append([(many.convert(a) - many.convert(b)) * half for a, b in zip(*found, strict=True)])
    return np.array(columns, dtype=object).T


@pytest.mark.parametrize(
    "t",
    [
        "0.7",
        pytest.param("-12", marks=pytest.mark.nightly),
        pytest.param("6283185.3", marks=pytest.mark.nightly),
        "1e9",
    ],
)
def test_oscillator_in_closed_form_after_any_time(t):
    solution = hjsolve.solve(System({"x": "line"}, "m*dot(x)**2/2", "k*x**2/2", {"m": 2, "k": "3"}))
    found = solution.motion(q={"x": "0.3"}, velocity={"x": "0.7"}).transition_matrix(t)
    ω = many.sqrt(many.mpf(3) / 2)
    c, s = many.cos(ω * many.mpf(t)), many.sin(ω * many.mpf(t))
    assert_claims(found, [[c, s / (2 * ω)], [-2 * ω * s, c]])


@pytest.mark.parametrize(
    "velocity", [{"r": "0.3", "theta": "1.2"}, pytest.param({"r": 0, "theta": "1.2"}, marks=pytest.mark.nightly)]
)
def test_kepler_by_differences(kepler, velocity):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity=velocity)
    assert_claims(motion.transition_matrix("37.5"), by_differences(kepler, motion, "37.5"))


def test_a_circle_by_differences_of_orbits_that_are_none(kepler):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 1})
    assert motion.kinds["r"] == "equilibrium"
    assert_claims(motion.transition_matrix("7.5"), by_differences(kepler, motion, "7.5"))


@pytest.mark.nightly
@pytest.mark.parametrize(
    "velocity", [{"r": "0.5", "theta": "1.5"}, {"r": "-0.5", "theta": "1.5"}, {"r": 0, "theta": "1.5"}]
)
def test_hyperbolas_by_differences(kepler, velocity):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity=velocity)
    assert_claims(motion.transition_matrix("37.5"), by_differences(kepler, motion, "37.5"))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("q", "velocity"),
    [({"r": 1}, {"r": "0.2", "phi": "1.1"}), ({"r": 1}, {"r": 0, "phi": 1}), ({"r": 1}, {"r": "0.2", "phi": "1.7"})],
)
def test_out_of_a_plane_in_which_the_motion_is_at_rest(q, velocity):
    """θ rests at π/2: libration, circle and hyperbola in the plane, and small motions out of it."""
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-spherical"))
    motion = solution.motion(q={**q, "theta": "pi/2", "phi": 0}, velocity={**velocity, "theta": 0})
    assert motion.kinds["theta"] == "equilibrium"
    assert_claims(motion.transition_matrix("25"), by_differences(solution, motion, "25"))


@pytest.mark.parametrize(
    ("q", "v"),
    [
        ("pi", "0"),
        ("0", "2"),
        pytest.param("0.5", "0.3", marks=pytest.mark.nightly),
        pytest.param("0.5", "-2.5", marks=pytest.mark.nightly),
    ],
)
def test_pendulum_by_its_variational_equation(q, v):
    """On top, on the separatrix, to and fro, over the top: δx″ = −cos x δx beside x″ = −sin x, by Taylor's method."""
    found = pendulum().motion(q={"x": q}, velocity={"x": v}).transition_matrix("4.5")
    truth = pendulum_variations(many.pi if q == "pi" else many.mpf(q), many.mpf(v), many.mpf("4.5"))
    assert_claims(found, truth)


def pendulum_variations(x, v, t, parts=24, order=30):
    """∂(x, v)(t)/∂(x, v)(0) of x″ = −sin x by Taylor series of x, sin x, cos x and two variations."""
    h, y, columns = t / parts, (x, v), ([many.mpf(1), many.mpf(0)], [many.mpf(0), many.mpf(1)])
    for _ in range(parts):
        a, b = [y[0]], [y[1]]
        s, c = [many.sin(y[0])], [many.cos(y[0])]
        δ = [([u], [w]) for u, w in columns]
        for k in range(order):
            a.append(b[k] / (k + 1))
            b.append(-s[k] / (k + 1))
            s.append(sum((i + 1) * a[i + 1] * c[k - i] for i in range(k + 1)) / (k + 1))
            c.append(-sum((i + 1) * a[i + 1] * s[k - i] for i in range(k + 1)) / (k + 1))
            for u, w in δ:
                u.append(w[k] / (k + 1))
                w.append(-sum(c[i] * u[k - i] for i in range(k + 1)) / (k + 1))
        ends = [many.polyval(row[::-1], h) for row in (a, b)]
        y = (ends[0], ends[1])
        columns = [[many.polyval(row[::-1], h) for row in pair] for pair in δ]
    return [[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]]


@pytest.mark.parametrize("name", ["kepler-planar", "spherical-pendulum"])
def test_symplectic_at_a_million_periods(name):
    motion = hjsolve.solve(hjsolve.catalog.load(name)).motion(**hjsolve.catalog.describe(name).initial.arguments)
    t = 1e6 * max(float(p.value) for p in motion.periods.values())
    found = motion.transition_matrix(t)
    M, n = found.value, len(found.value) // 2
    defect = np.abs(M.T @ J(n) @ M - J(n)).max()
    claim = (found.error.T @ np.abs(J(n) @ M) + np.abs(M.T @ J(n)) @ found.error).max()
    assert defect <= claim
    assert defect <= 1e-11 * np.abs(M).max() ** 2


def test_one_motion_after_another_multiplies_matrices(kepler):
    first = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": "0.3", "theta": "1.2"}, digits=20)
    state = first.at("11")
    then = kepler.motion(q=dict(state.q), p=dict(state.p), digits=20)
    product = then.transition_matrix("20").value @ first.transition_matrix("11").value
    direct = first.transition_matrix("31").value
    assert np.abs(product - direct).max() < 1e-16 * np.abs(direct).max()


def test_times_in_any_shape(kepler):
    motion = kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": "0.3", "theta": "1.2"})
    found = motion.transition_matrix([[0.0, 1.0], [2.0, 3.0]])
    assert found.shape == (2, 2, 4, 4)
    assert (np.abs(found.value[0, 0] - np.eye(4)) <= found.error[0, 0] + 1e-30).all()
    assert np.array_equal(found.value[1, 0], motion.transition_matrix(2.0).value)


def test_free_motion_where_every_coordinate_is_ignorable():
    solution = hjsolve.solve(System({"x": "line", "y": "line"}, "m*dot(x)**2/2 + dot(y)**2", "0", {"m": 4}))
    found = solution.motion(q={"x": 0, "y": 0}, velocity={"x": 1, "y": 2}).transition_matrix(6)
    truth = np.eye(4)
    truth[0, 2], truth[1, 3] = 1.5, 3.0
    assert np.array_equal(found.value, truth)


def test_normal_modes_told_in_the_given_coordinates():
    """exp(At) of x″ = −x − y/3, y″ = −2y − x/3."""
    system = System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2/2 + y**2 + x*y/3")
    motion = hjsolve.solve(system, coordinates="find").motion(q={"x": "0.3", "y": 1}, p={"x": 0, "y": "0.2"})
    third = many.mpf(1) / 3
    A = many.matrix([[0, 0, 1, 0], [0, 0, 0, 1], [-1, -third, 0, 0], [-third, -2, 0, 0]])
    truth = many.expm(A * many.mpf("7.5"))
    assert_claims(motion.transition_matrix("7.5"), [[truth[i, j] for j in range(4)] for i in range(4)])


@pytest.mark.nightly
def test_two_centres_told_in_the_plane():
    V = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)"
    solution = hjsolve.solve(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", V), coordinates="find")

    def end(q, p):
        state = solution.motion(q=q, p=p, digits=40).at("7.5")
        return [state.q["x"], state.q["y"], state.p["x"], state.p["y"]]

    begin = [sp.Rational(3, 10), sp.Integer(1), sp.Integer(0), sp.Rational(1, 5)]
    h, columns = sp.Rational(1, 10**14), []
    for k in range(4):
        pair = []
        for sign in (1, -1):
            moved = [x + sign * h * int(i == k) for i, x in enumerate(begin)]
            pair.append(end(dict(zip("xy", moved[:2], strict=True)), dict(zip("xy", moved[2:], strict=True))))
        columns.append(
            [(many.convert(a) - many.convert(b)) * many.mpf(10) ** 14 / 2 for a, b in zip(*pair, strict=True)]
        )
    motion = solution.motion(q={"x": "0.3", "y": 1}, p={"x": 0, "y": "0.2"})
    assert_claims(motion.transition_matrix("7.5"), np.array(columns, dtype=object).T)


def test_refusals_say_why():
    absolute = System({"x": "line"}, "dot(x)**2/2", "Abs(x)")
    with pytest.raises(InvalidInputError, match="derivatives"):
        hjsolve.solve(absolute).motion(q={"x": 1}, velocity={"x": 0}).transition_matrix(1)
    quartic = hjsolve.solve(System({"x": "line"}, "dot(x)**2/2", "x**4"))
    with pytest.raises(InvalidInputError, match="rests at a multiple zero of p²"):
        quartic.motion(q={"x": 0}, velocity={"x": 0}).transition_matrix(1)
