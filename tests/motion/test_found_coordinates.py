"""Motions in coordinates that were found, expressed in x, y, z: against Taylor series of Hamilton's equations in x, y, z."""

from __future__ import annotations

import pickle
import random

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.mechanics.system import hamiltonian
from hjsolve.mechanics.system import momenta as canonical_momenta
from tests.reference.taylor import Flow

R2, R3 = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"
PLANE = {
    "elliptic": "-1/sqrt((x-1)**2 + (y-2)**2) - 3/sqrt((x-3)**2 + (y+1)**2)",
    "polar": f"-1/{R2}",
    "parabolic": f"-1/{R2} + x/50 + y/100",
    "cartesian": "x**4 + 6*x**2*y**2 + y**4 + (x**2 + y**2)/2",
    "normal modes": "(x - y)**2/2 + x/5",
}
SPACE = {
    "prolate spheroidal": "-1/sqrt(x**2 + (y-1)**2 + (z-2)**2) - 2/sqrt((x-2)**2 + y**2 + (z+1)**2)",
    "ellipsoidal": "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2",
    "rotational parabolic": f"-1/{R3} + x/100 + y/50 + z/50",
    "conical": f"(x**2 + y**2 + z**2)**2 + (x**2 + 2*y**2 + 4*z**2)/{R3}**4",
    "normal modes": "(x - y)**2/2 + (y - z)**2/2",
}
FAST = [("elliptic", 2), ("polar", 2), ("cartesian", 2), ("normal modes", 2), ("ellipsoidal", 3), ("normal modes", 3)]
MORE = [(kind, n) for n, table in ((2, PLANE), (3, SPACE)) for kind in table if (kind, n) not in FAST]


def system_of(kind: str, n: int) -> hjsolve.System:
    kinetic = " + ".join(f"dot({q})**2/2" for q in "xyz"[:n])
    return hjsolve.System(dict.fromkeys("xyz"[:n], "line"), kinetic, (PLANE, SPACE)[n - 2][kind])


def start(n: int, seed: str) -> tuple[dict[str, str], dict[str, str]]:
    dice = random.Random(seed)
    return (
        {q: f"{dice.uniform(-1, 1):.3f}" for q in "xyz"[:n]},
        {q: f"{dice.uniform(-0.6, 0.6):.3f}" for q in "xyz"[:n]},
    )


def truth(system: hjsolve.System, q: dict[str, str], v: dict[str, str], t: float) -> list:
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    V = system.potential.replace(sp.acosh, lambda x: sp.log(x + sp.sqrt(x**2 - 1)))
    V = V.replace(sp.acos, lambda x: sp.pi / 2 - sp.atan(x / sp.sqrt(1 - x**2)))
    H = sum(p**2 for p in momenta) / 2 + V
    begin = [mp.mpf(sp.Rational(x).p) / sp.Rational(x).q for x in (*q.values(), *v.values())]
    return Flow(H, places, momenta, {}, begin, digits=22).at(mp.mpf(t))


@pytest.mark.nightly_cases("ellipsoidal-3", "polar-2")
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "n"), FAST + [pytest.param(*case, marks=pytest.mark.nightly) for case in MORE])
def test_states_in_x_y_z_agree_with_the_integrated_equations_within_their_errors(kind: str, n: int) -> None:
    system = system_of(kind, n)
    solution = hjsolve.solve(system, coordinates="find")
    assert solution.chart.kind == kind
    q, v = start(n, f"{kind} {n}")
    motion = solution.motion(q=q, velocity=v)
    assert set(motion.kinds) == set(solution.chart.coordinates)
    for t in (0.7, 3.1):
        state = motion.at(t)
        assert state.status == "ok"
        with mp.workdps(40):
            exact = truth(system, q, v, t)
            for i, c in enumerate(system.coordinates):
                assert abs(mp.mpf(state.q[c.name]) - exact[i]) <= state.error.q[c.name] <= 1e-11
                assert abs(mp.mpf(state.velocity[c.name]) - exact[n + i]) <= state.error.velocity[c.name] <= 1e-11
                assert state.p[c.name] == state.velocity[c.name]


LENS = "(x**2 + y**2)/2 - (A*sqrt(A**2 - 1)*acosh(A) + B*sqrt(1 - B**2)*(acos(B) - pi/2))/(A**2 - B**2)/5"
"""Danilov, Nagaitsev, PRST-AB 13, 084002 (2010), eq. (29), c = 1; A, B: half the sum and difference of the distances."""


@pytest.mark.nightly
@pytest.mark.slow
def test_a_lens_with_cuts_is_written_without_inverse_functions_and_ends_at_the_cuts() -> None:
    near, far = "sqrt((x - 1)**2 + y**2)", "sqrt((x + 1)**2 + y**2)"
    potential = LENS.replace("A", f"(({far} + {near})/2)").replace("B", f"(({far} - {near})/2)")
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", potential)
    solution = hjsolve.solve(system, coordinates="find")
    assert not solution.system.potential.has(sp.acos, sp.acosh, sp.sqrt)
    assert [c.domain.written(c.name) for c in solution.system.coordinates] == ["line", "0 < nu < pi"]
    q, v = {"x": "0.3", "y": "-0.1"}, {"x": "0.1", "y": "0.4"}  # through the segment between the foci
    state = solution.motion(q=q, velocity=v).at([0, "1.5"])
    with mp.workdps(40):
        exact = truth(system, q, v, 1.5)
        assert exact[1] > 0
        for i, name in enumerate("xy"):
            assert abs(mp.mpf(state.q[name][1]) - exact[i]) <= state.error.q[name][1] <= 1e-12
            assert abs(mp.mpf(state.velocity[name][1]) - exact[2 + i]) <= state.error.velocity[name][1] <= 1e-12


def test_many_digits_are_right_to_all_of_them() -> None:
    system = system_of("elliptic", 2)
    q, v = start(2, "digits")
    motion = hjsolve.solve(system, coordinates="find").motion(q=q, velocity=v, digits=30)
    state = motion.at("3/2")
    with mp.workdps(45):
        exact = truth(system, q, v, 1.5)
        for i, name in enumerate("xy"):
            assert abs(state.q[name] - exact[i]) <= max(state.error.q[name], 1e-22)  # the series are right to 22 digits
            assert state.error.q[name] <= 1e-26
            assert abs(state.velocity[name] - exact[2 + i]) <= 1e-21


@pytest.mark.nightly
@pytest.mark.slow
def test_at_the_start_the_state_is_the_one_given_in_every_octant() -> None:
    solution = hjsolve.solve(system_of("ellipsoidal", 3), coordinates="find")
    for signs in ((a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)):
        q = {n: s * x for n, s, x in zip("xyz", signs, (0.25, 0.5, 0.125), strict=True)}
        v = {"x": 0.5, "y": -0.25, "z": 0.125}
        state = solution.motion(q=q, velocity=v, want=["trajectory"]).at(0)
        for n in "xyz":
            assert abs(state.q[n] - q[n]) <= state.error.q[n] <= 1e-13
            assert abs(state.velocity[n] - v[n]) <= state.error.velocity[n] <= 1e-12


@pytest.mark.nightly_cases("m/2*(dot(x)**2 + dot(y)**2)--1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + (y - 1)**2)")
@pytest.mark.parametrize(
    ("kinetic", "potential"),
    [
        ("dot(x)**2 + 9*dot(y)**2/2", "-1/sqrt(2*x**2 + 9*y**2) + x/50"),  # masses 2 and 9
        ("m/2*(dot(x)**2 + dot(y)**2 + dot(x)*dot(y))", "(x - 2*y)**2 + y"),
        ("m/2*(dot(x)**2 + dot(y)**2)", "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + (y - 1)**2)"),
    ],
)
def test_masses_of_any_kind_are_in_velocities_momenta_and_the_motion(kinetic: str, potential: str) -> None:
    parameters = {"m": "7/3"} if "m" in kinetic else {}
    system = hjsolve.System({"x": "line", "y": "line"}, kinetic, potential, parameters)
    motion = hjsolve.solve(system, "find").motion(q={"x": "0.3", "y": "0.4"}, velocity={"x": "0.2", "y": "-0.1"})
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    H = hamiltonian(system).subs(system.defaults)
    with mp.workdps(40):
        speeds = dict(
            zip([c.velocity for c in system.coordinates], (sp.Rational(1, 5), sp.Rational(-1, 10)), strict=True)
        )
        p0 = [p.subs(speeds) for p in canonical_momenta(system).values()]
        begin = [mp.mpf(3) / 10, mp.mpf(2) / 5, *(mp.mpf(sp.N(p.subs(system.defaults), 38)) for p in p0)]
        flow = Flow(H, places, momenta, {}, begin, digits=22)
        for t in (0.0, 1.3):
            state, exact = motion.at(t), flow.at(mp.mpf(t))
            values = dict(zip([*places, *momenta], exact, strict=True))
            for k, c in enumerate(system.coordinates):
                speed = mp.mpf(sp.N(sp.diff(H, c.momentum).subs(values), 30))
                assert abs(mp.mpf(state.q[c.name]) - exact[k]) <= state.error.q[c.name] <= 1e-11
                assert abs(mp.mpf(state.p[c.name]) - exact[2 + k]) <= state.error.p[c.name] <= 1e-11
                assert abs(mp.mpf(state.velocity[c.name]) - speed) <= state.error.velocity[c.name] <= 1e-11


def test_arrays_of_times_pickling_and_the_given_coordinates_where_they_separate() -> None:
    solution = hjsolve.solve(system_of("cartesian", 2), coordinates="find")
    motion = solution.motion(q={"x": "0.3", "y": "0.1"}, p={"x": 0, "y": "0.2"})
    times = np.linspace(0, 5, 7).reshape(7, 1)
    state, again = motion.at(times), pickle.loads(pickle.dumps(motion)).at(times)
    assert state.q["x"].shape == state.error.velocity["y"].shape == (7, 1)
    assert np.array_equal(again.q["x"], state.q["x"])
    assert isinstance(motion, hjsolve.AnyMotion)
    plain = hjsolve.solve(
        hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**4 + y**2"), "find"
    )
    assert plain.chart is None
    assert set(plain.motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": 1}).kinds) == {"x", "y"}


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: hjsolve.solve(system_of("polar", 2), coordinates="look"), '"as given" or "find" is needed'),
        (lambda: hjsolve.solve(system_of("polar", 2), "find").motion(q={"x": 1, "y": 0}), "either velocity"),
        (
            lambda: hjsolve.solve(system_of("polar", 2), "find").motion(
                q={"r": 1, "theta": 0}, velocity={"x": 0, "y": 1}
            ),
            "'r' is not a coordinate",
        ),
        (
            lambda: hjsolve.solve(system_of("parabolic", 2), "find").motion(
                q={"x": 0, "y": 0}, velocity={"x": 0, "y": 1}
            ),
            "singular point",
        ),
    ],
)
def test_what_cannot_be_done_is_told(call, says: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=says):
        call()


@pytest.mark.parametrize("c", [-1, 0])
def test_parameters_for_which_the_coordinates_do_not_hold_are_refused(c: int) -> None:
    potential = "-1/sqrt((x - c)**2 + y**2) - 3/sqrt((x + c)**2 + y**2)"
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", potential, {"c": 1})
    solution, start = hjsolve.solve(system, "find"), {"q": {"x": 1, "y": 1}, "velocity": {"x": 0, "y": "1/5"}}
    assert abs(solution.motion(**start, parameters={"c": 2}).at(0).q["x"] - 1) <= 1e-14
    with pytest.raises(hjsolve.InvalidInputError, match="found for the default values"):
        solution.motion(**start, parameters={"c": c})


@pytest.mark.parametrize(
    ("coordinates", "potential", "says"),
    [
        ({"x": "line", "y": "line"}, "(x**2 + y**2)/2 + x**2*y - y**3/3", "not separable by a point transformation"),
        ({"x": "0 < x", "y": "line"}, "x*y**2", "the whole line"),
        ({"x": "line", "y": "angle"}, "x**2*cos(y)", "the whole line"),
    ],
)
def test_systems_that_separate_nowhere_are_refused_with_the_verdict(coordinates, potential: str, says: str) -> None:
    system = hjsolve.System(coordinates, "(dot(x)**2 + dot(y)**2)/2", potential)
    with pytest.raises(hjsolve.NotSeparableError, match=says) as caught:
        hjsolve.solve(system, coordinates="find")
    assert caught.value.verdict.pair


@pytest.mark.parametrize(
    ("potential", "says"),
    [
        ("-1/sqrt(x**2 + y**2 + (1 + sqrt(z**2 + 1))**2)", "quadratic"),
        ("-1/sqrt(x**2 + y**2 + (z - 1)**2) - 2/sqrt(x**2 + y**2 + (z + 1)**2) + x/10", "quadratic"),
    ],
    ids=["Miyamoto-Nagai", "two centres in a transverse field"],
)
def test_potentials_of_space_that_separate_nowhere_are_refused_with_what_was_looked_for(
    potential: str, says: str
) -> None:
    system = hjsolve.System(
        dict.fromkeys("xyz", "line"), "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", potential
    )  # fmt: skip
    with pytest.raises(hjsolve.NotSeparableError, match=says) as caught:
        hjsolve.solve(system, coordinates="find")
    assert caught.value.verdict.pair


@pytest.mark.nightly
def test_momenta_of_a_heavy_body_have_the_errors_of_momenta() -> None:
    """p = 1000 v, and so are their errors; claims of the one for the other were a thousand times too small."""
    light = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", PLANE["elliptic"])
    heavy = hjsolve.System({"x": "line", "y": "line"}, "500*(dot(x)**2 + dot(y)**2)", f"1000*({PLANE['elliptic']})")
    q, v = start(2, "heavy")
    one, other = (hjsolve.solve(s, coordinates="find").motion(q=q, velocity=v).at(3) for s in (light, heavy))
    for name in "xy":
        assert other.error.p[name] == pytest.approx(1000 * other.error.velocity[name], rel=0.5)
        assert abs(other.p[name] - 1000 * one.p[name]) <= other.error.p[name] + 1000 * one.error.p[name]


@pytest.mark.parametrize(
    ("group", "given"), [("q", 5), ("velocity", [1, 2]), ("p", "1"), ("parameters", 5)], ids=lambda x: str(x)
)
def test_what_is_no_table_of_numbers_is_refused_by_its_name(group: str, given: object) -> None:
    solution = hjsolve.solve(system_of("polar", 2), "find")
    data = {"q": {"x": 1, "y": 0}, "velocity": {"x": 0, "y": 1}} | {group: given}
    if group == "p":
        del data["velocity"]
    with pytest.raises(hjsolve.InvalidInputError, match=f"{group}: a table name → value is needed"):
        solution.motion(**data)
