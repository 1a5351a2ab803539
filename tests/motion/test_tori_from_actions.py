"""Motions from actions and angles: against closed forms E(J), and back to the states that initial data give."""

from __future__ import annotations

import re

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from tests.support import entries

KEPLER = {"q": {"r": 1, "theta": "0.3"}, "velocity": {"r": "0.1", "theta": "1.2"}}
SPHERICAL = {"q": {"theta": "1", "phi": "0.4"}, "velocity": {"theta": "0.2", "phi": "1"}}
ROUND = {"q": {"theta": "0.2"}, "velocity": {"theta": "9"}}
BACK = {"q": {"theta": "0.2"}, "velocity": {"theta": "-9"}}
LIBRATION = {"q": {"theta": "0.2"}, "velocity": {"theta": "1.2"}}
TIME = "1.5"
BOUNDED = {"libration", "rotation", "equilibrium", "ignorable"}


def way_back(solution, motion, digits=15, parameters=None):
    """The motion with the actions of another, and its angles at a time, started there."""
    angles = motion.angles(TIME)
    return solution.motion(
        actions={name: J.value for name, J in motion.actions.items()}, angles=dict(angles.value), t0=TIME,
        q={name: float(x) for name, x in motion.at(TIME).q.items()},
        kinds={name: kind for name, kind in motion.kinds.items() if kind != "ignorable"}, digits=digits,
        parameters=parameters,
    )  # fmt: skip


def gap(one, other, *, angle):
    """Distance, of angles modulo 2π."""
    with mp.workdps(60):
        difference = mp.mpf(one) - mp.mpf(other)
        return float(abs(difference - 2 * mp.pi * mp.nint(difference / (2 * mp.pi)) if angle else difference))


def returns(solution, motion, back, allowed):
    """Whether actions, angles and the state are those of the motion they came from."""
    assert back.kinds == motion.kinds
    for name, J in motion.actions.items():
        found = back.actions[name]
        assert abs(found.value - J.value) <= found.error + J.error, name
    given, found = motion.angles(TIME), back.angles(TIME)
    for name in given:
        assert gap(given[name], found[name], angle=True) <= given.error[name] + found.error[name], name
    state, again = motion.at(TIME), back.at(TIME)
    sizes = {"q": 1.0, "p": max(abs(float(x)) for x in state.p.values()) or 1.0}
    for group, size in sizes.items():
        for name, x in getattr(state, group).items():
            angle = group == "q" and solution.system.coordinate(name).domain.kind == "angle"
            assert gap(x, getattr(again, group)[name], angle=angle) <= allowed * max(size, abs(float(x))), (group, name)


@pytest.mark.parametrize(("J_r", "L"), [("0.2", "1"), ("0.7", "-0.3"), ("1e-20", 2), (0, 1), (0, -1), (3, "0.05")])
def test_kepler_has_the_energy_of_the_closed_form(J_r, L):
    motion = entries.solved("kepler-planar").motion(actions={"r": J_r, "theta": L}, angles={"theta": "0.5"}, digits=30)
    with mp.workdps(50):
        E = -1 / (2 * (mp.mpf(J_r) + abs(mp.mpf(L))) ** 2)
        assert abs(motion.constants["E"].value - E) <= 1e-30 * abs(E)
        frequency = 1 / (mp.mpf(J_r) + abs(mp.mpf(L))) ** 3
        assert abs(motion.frequencies["r"].value - frequency) <= 1e-29 * frequency
        assert abs(motion.angles(0)["theta"] - mp.mpf("0.5")) <= motion.angles(0).error["theta"] + 1e-30
    assert motion.kinds["r"] == ("equilibrium" if J_r == 0 else "libration")


@pytest.mark.nightly
def test_kepler_in_space_from_delaunay_actions():
    """Planar, inclined and polar-circular tori have E = −1/(2 (J_r + J_θ + |J_φ|)²)."""
    solution = entries.solved("kepler-spherical")
    for J in (
        {"r": 0, "theta": 0, "phi": 1},
        {"r": "0.3", "theta": 0, "phi": -1},
        {"r": 0, "theta": "0.4", "phi": "0.2"},
    ):
        motion = solution.motion(actions=J)
        total = sum(abs(float(x)) for x in J.values())
        assert motion.constants["E"].value == pytest.approx(-1 / (2 * total**2), rel=4e-16)
        assert [motion.actions[name].value for name in J] == [float(x) for x in J.values()]


@pytest.mark.parametrize("initial", [LIBRATION, ROUND, BACK])
def test_pendulum_returns_on_both_sides_of_the_separatrix(initial):
    solution = entries.solved("pendulum")
    motion = solution.motion(**initial)
    returns(solution, motion, way_back(solution, motion), 1e-14)


def test_thirty_digits_return():
    solution = entries.solved("pendulum")
    motion = solution.motion(**ROUND, digits=30)
    returns(solution, motion, way_back(solution, motion, 30), 1e-28)


@pytest.mark.parametrize("name", ["kepler-planar", "spherical-pendulum", "two-centres-space"])
def test_states_return(name):
    given = {"kepler-planar": KEPLER, "spherical-pendulum": SPHERICAL}
    arguments = given.get(name) or {**entries.described(name).motions["default"].arguments}
    solution = entries.solved(name)
    motion = solution.motion(**arguments)
    returns(solution, motion, way_back(solution, motion), 1e-13)


def test_the_bottom_of_a_well_is_a_rest():
    motion = entries.solved("pendulum").motion(actions={"theta": 0})
    assert motion.kinds["theta"] == "equilibrium"
    assert motion.actions["theta"].value == 0
    assert motion.frequencies["theta"].value == pytest.approx(np.sqrt(9.81), rel=4e-16)


def test_several_wells_are_listed_and_a_place_or_kind_chooses():
    well = entries.solved("double-well")
    with pytest.raises(hjsolve.InvalidInputError, match=r"several tori.*to -0\.873.*from 0\.873"):
        well.motion(actions={"x": "0.01"})
    right, left = (well.motion(actions={"x": "0.01"}, q={"x": x}) for x in (1, -1))
    assert right.turning_points["x"][0].value == -left.turning_points["x"][1].value > 0
    pendulum = entries.solved("pendulum")
    with pytest.raises(hjsolve.InvalidInputError, match=r"several tori.*libration.*rotation"):
        pendulum.motion(actions={"theta": "7.97"})
    assert pendulum.motion(actions={"theta": "7.97"}, kinds={"theta": "libration"}).kinds["theta"] == "libration"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"actions": {"r": 1}}, "no value for theta"),
        ({"actions": {"r": 1, "phi": 1}}, "known are r, theta"),
        ({"actions": {"r": -1, "theta": 1}}, "librations need J >= 0"),
        ({"actions": {"r": 1, "theta": 1}, "p": {"r": 0}}, "p: is not used"),
        ({"actions": {"r": 1, "theta": 1}, "kinds": {"r": "orbit"}}, "one of libration"),
        ({"q": {"r": 1, "theta": 0}, "angles": {"r": 1}}, "angles: is not used"),
        ({"velocity": {"r": 1}}, "no q="),
    ],
)
def test_bad_input_names_what_is_wrong(arguments, words):
    with pytest.raises(hjsolve.InvalidInputError, match=words):
        entries.solved("kepler-planar").motion(**arguments)


def line(V, *more):
    names = ("x", *more)
    T = " + ".join(f"dot({n})**2" for n in names)
    return hjsolve.solve(hjsolve.System(dict.fromkeys(names, "line"), f"({T})/2", V))


DOUBLE, TRIPLE, CUBIC = "x**4/4 - x**2/2", "x**2*(x**2 - 1)**2", "x**2/2 - x**3/3"


@pytest.mark.parametrize(
    ("V", "J", "least_and_most"),
    [
        # areas at the barrier: of a well 4/3, of a side well √3/2·4√2/9, of the middle one twice that; of the cubic 6/5
        (DOUBLE, "0.3", [2 / (3 * np.pi), 4 / (3 * np.pi)]),
        pytest.param(DOUBLE, "-1", [2 / (3 * np.pi), 4 / (3 * np.pi)], marks=pytest.mark.nightly),
        pytest.param(CUBIC, "1", [3 / (5 * np.pi)], marks=pytest.mark.nightly),
        pytest.param(TRIPLE, "0.2", [0.06498, 0.12995, 0.2599], marks=pytest.mark.nightly),
    ],
)
def test_actions_that_no_torus_has_are_refused_with_the_range(V, J, least_and_most):
    with pytest.raises(hjsolve.InvalidInputError, match="there are about") as refused:
        line(V).motion(actions={"x": J})
    told = {float(x) for x in re.findall(r"(?:from|to) ([0-9.]+)", str(refused.value))} - {0.0}
    np.testing.assert_allclose(sorted(told), least_and_most, rtol=1e-2, atol=0)


def test_no_pendulum_rotates_slower_than_on_its_separatrix():
    with pytest.raises(hjsolve.InvalidInputError, match=r"no bounded .*to 7\.98 .*rotations with abs\(J_theta\) from 3\.99 on"):
        entries.solved("pendulum").motion(actions={"theta": "3.98"}, kinds={"theta": "rotation"})


@pytest.mark.nightly
def test_all_wells_are_listed_and_each_is_chosen_by_a_place_in_it():
    triple = line(TRIPLE)
    with pytest.raises(hjsolve.InvalidInputError, match="several tori") as refused:
        triple.motion(actions={"x": "0.01"})
    assert str(refused.value).count("x libration") == 3
    for place in (-1, 0, 1):
        lower, upper = triple.motion(actions={"x": "0.01"}, q={"x": place}).turning_points["x"]
        assert lower.value < place < upper.value
    with pytest.raises(hjsolve.InvalidInputError, match="no torus with these actions is there"):
        triple.motion(actions={"x": "0.01"}, q={"x": "0.5"})


@pytest.mark.nightly
def test_wells_of_two_coordinates_are_all_listed():
    plane = line(f"{DOUBLE} + y**2*(y**2 - 1)**2", "y")
    J = {"x": "0.05", "y": "0.01"}
    for hint, count in (({}, 6), ({"x": 1}, 3), ({"y": 0}, 2)):
        with pytest.raises(hjsolve.InvalidInputError, match="several tori") as refused:
            plane.motion(actions=J, q=hint)
        assert str(refused.value).count("y libration") == count
    points = plane.motion(actions=J, q={"x": -1, "y": 1}).turning_points
    assert points["x"][1].value < 0 < points["y"][0].value


NOT_FOUND = {
    "henon-heiles-kdv": "the search finds no start from which Newton's method reaches the torus",
}


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.xfail(strict=True, raises=hjsolve.InvalidInputError, reason=NOT_FOUND[n]))
        if n in NOT_FOUND
        else n
        for n in entries.separable()
    ],
)
def test_every_bounded_motion_of_the_catalog_returns(name):
    solution = entries.solved(name)
    given = {**entries.described(name).motions["default"].arguments}
    given.pop("digits", None)
    motion = solution.motion(**given)
    names = {c.name for c in solution.system.coordinates}
    if set(motion.actions) != names or set(motion.frequencies) != names or not set(motion.kinds.values()) <= BOUNDED:
        pytest.skip("no torus")
    returns(solution, motion, way_back(solution, motion, parameters=given.get("parameters")), 1e-12)


def pendulum_action(rest):
    """J of the libration of dot(x)²/2 − cos x with modulus k, k² = 1 − rest: (8/π) (E(k) − (1 − k²) K(k))."""
    return 8 / mp.pi * (mp.ellipe(1 - rest) - rest * mp.ellipk(1 - rest))


@pytest.mark.parametrize(
    "rest", ["1e-5", *(pytest.param(rest, marks=pytest.mark.nightly) for rest in ("1e-9", "1e-12", "1e-17"))]
)
@pytest.mark.parametrize("line", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_librations_next_to_a_separatrix_have_their_actions(rest, line):
    solution = hjsolve.solve(hjsolve.System({"x": "line" if line else "angle"}, "dot(x)**2/2", "-cos(x)"))
    with mp.workdps(60):
        J, E = pendulum_action(mp.mpf(rest)), 1 - 2 * mp.mpf(rest)
        motion = solution.motion(actions={"x": J}, kinds={"x": "libration"}, digits=30)
        found = motion.constants["E"]
        assert abs(found.value - E) <= found.error < 2e-30
    with pytest.raises(hjsolve.SeveralToriError, match=r"libration.*rotation"):
        solution.motion(actions={"x": J})


@pytest.mark.parametrize("gap", ["-1e-12", pytest.param("1e-12", marks=pytest.mark.nightly)])
def test_double_wells_next_to_their_crest_have_their_actions(gap):
    # E = V(0) ± a little: three starts lead to the one torus above
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4 - x**2/2"))
    motion = solution.motion(q={"x": 1}, constants={"E": gap}, signs={"x": 1})
    back = solution.motion(actions={"x": motion.actions["x"].value}, q={"x": 1})
    assert float(back.constants["E"]) == pytest.approx(float(gap), rel=1e-2, abs=0)  # J in doubles knows no more
    assert abs(back.actions["x"].value - motion.actions["x"].value) <= 2e-16


# two centres (k₁ = 1, k₂ = ½): J_ξ, J_η, p_φ, θ_ξ, θ_η. A small action was said to have no torus: after a step J_η is off
# by the square of what J_ξ was off by. Of the second the phases were not found: it passes a centre with ∂θ/∂χ = 7e-10.
NEXT_TO_CENTRES = [
    ((11.016941068799339, 6.5383789614839285e-24, 0.0010072288023636033), (0.4, 1.3)),
    ((23.883866354637266, 0.0015088643821132765, 0.0011199014957508767), (-4.297912695343918e-12, 2.820754068766745)),
]


@pytest.mark.parametrize(("actions", "angles"), NEXT_TO_CENTRES)
def test_orbits_next_to_a_centre_have_their_tori(actions, angles):
    J, θ = dict(zip(("xi", "eta", "phi"), actions, strict=True)), dict(zip(("xi", "eta"), angles, strict=True))
    motion = hjsolve.solve("two-centres-space").motion(actions=J, angles=θ)
    for name, asked in J.items():
        found = motion.actions[name]
        assert abs(found.value - asked) <= found.error + 1e-15 * asked
    for name, asked in θ.items():
        found = motion.angles(0)
        assert gap(found[name], asked, angle=True) <= found.error[name] + 1e-15
    batch = hjsolve.ensemble(
        "two-centres-space", actions={c: [x] for c, x in J.items()}, angles=θ, want={"state"}, fallback=False
    )
    state = motion.at(0)
    for name in ("xi", "eta"):
        assert abs(batch.q[name][0] - state.q[name]) <= batch.error["q"][name][0] + state.error.q[name]


# an atom in a bond, SI: nothing of it is 1e-6 wide or wider, and its actions were said to have no torus
BOND = {"D": "7.4e-19", "a": "1.9e10", "m": "1.6e-27"}
MORSE_IN_METRES = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "D*(1 - exp(-a*x))**2", BOND)


@pytest.mark.parametrize("J", ["1e-36", "5e-35", "2e-33", "2.56e-33"])
def test_actions_of_an_atom_in_metres_have_their_torus(J):
    """E = ω J − (ω J)²/4D with ω = a √(2 D/m) (Morse 1929)."""
    motion = hjsolve.solve(MORSE_IN_METRES).motion(actions={"x": J}, want=["actions"])
    with mp.workdps(40):
        D, a, m = (mp.mpf(BOND[name]) for name in BOND)
        w = a * mp.sqrt(2 * D / m) * mp.mpf(J)
        exact = w - w**2 / (4 * D)
        assert abs(motion.constants["E"].value - exact) <= motion.constants["E"].error


def test_wells_an_angstrom_apart_are_listed():
    values = {"D": "7e-20", "b": "1e-10", "m": "1.6e-27"}
    wells = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "D*(x**2/b**2 - 1)**2", values)
    with pytest.raises(hjsolve.InvalidInputError, match="several tori") as said:
        hjsolve.solve(wells).motion(actions={"x": "1e-34"})
    assert str(said.value).count("libration from") == 2


def test_an_action_that_there_is_beyond_the_search_is_not_said_to_be_out_of_range():
    """V ~ −1/x² far out: J grows like −ln(−E)/(√2·2) without bound, and J = 100 belongs to E near −1e-190."""
    well = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "-1/(1 + x**2)"))
    with pytest.raises(hjsolve.InvalidInputError, match=r"x 100 was not found, though there are about .* from 0 on"):
        well.motion(actions={"x": 100})
    with pytest.raises(hjsolve.InvalidInputError, match="no bounded motion with x -1 was found"):
        well.motion(actions={"x": -1})
