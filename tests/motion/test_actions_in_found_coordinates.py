"""Motions from actions and angles where the coordinates were found: told in the user's own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve

XY = {"x": "line", "y": "line"}
XYZ = {**XY, "z": "line"}
T2, T3 = "(dot(x)**2 + dot(y)**2)/2", "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"
SPRINGS = "(x**2 + y**2 + (x - y)**2)/2"
FIELDS: dict[str, tuple[dict[str, str], str, str]] = {
    "isochrone": (XY, T2, "-1/(1 + sqrt(1 + x**2 + y**2))"),
    "two centres": (XY, T2, "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)"),
    "normal modes": (XY, T2, SPRINGS),
    "turned axes": (XY, T2, "x**4 + y**4 + 6*x**2*y**2 + x**2 + y**2"),
    "field and centre": (XY, T2, "-1/sqrt(x**2 + y**2) + x/100"),
    "in space": (XYZ, T3, "-1/(1 + sqrt(1 + x**2 + y**2 + z**2))"),
}
QUICK = ("isochrone", "normal modes")


@pytest.mark.nightly_cases(*[name for name in FIELDS if name not in QUICK])
@pytest.mark.parametrize("name", FIELDS)
def test_actions_and_angles_of_a_motion_give_it_back(name: str) -> None:
    """The same motion is started from q and velocity, which knows nothing of actions."""
    coordinates, T, V = FIELDS[name]
    solution = hjsolve.solve(hjsolve.System(coordinates, T, V), coordinates="find")
    q = dict(zip(coordinates, ("0.3", "1.2", "0.2"), strict=False))
    motion = solution.motion(q=q, velocity=dict(zip(coordinates, ("0.2", "0.4", "0.1"), strict=False)))
    actions = {n: x.value for n, x in motion.actions.items()}
    angles = {n: float(np.asarray(x)) for n, x in motion.angles(0).items()}
    kinds = {n: k for n, k in motion.kinds.items() if n in solution.coordinates}
    found = solution.motion(actions=actions, angles=angles, kinds=kinds)
    assert found.kinds == motion.kinds
    for t in (0, 0.5, 3):
        expected, state = motion.at(t), found.at(t)
        assert set(state.q) == set(coordinates)
        for n in coordinates:
            for group in ("q", "p", "velocity"):
                a, b = getattr(expected, group)[n], getattr(state, group)[n]
                assert abs(a - b) <= 4e-15 * (1 + t) + getattr(state.error, group)[n]


def test_normal_modes_at_thirty_digits() -> None:
    """E = J1 w1 + J2 w2 with the frequencies 1 and sqrt(3), and the modes (x + y)/sqrt(2), (x - y)/sqrt(2)."""
    solution = hjsolve.solve(hjsolve.System(XY, T2, SPRINGS), coordinates="find")
    J = {"mode_1": "1/2", "mode_2": "1/4"}
    motion = solution.motion(actions=J, digits=30)
    with mp.workdps(45):
        w = sorted(mp.mpf(x.value) for x in motion.frequencies.values())
        assert abs(w[0] - 1) + abs(w[1] - mp.sqrt(3)) < mpf(10) ** -28
        frequency = {n: mpf(motion.frequencies[n].value) for n in J}
        E = frequency["mode_1"] / 2 + frequency["mode_2"] / 4
        assert abs(mpf(motion.constants["E"].value) - E) < mpf(10) ** -28
        for t in ("0", "7/5"):
            state = motion.at(t)
            x, y, u, v = (mpf(g[n]) for g in (state.q, state.velocity) for n in "xy")
            energies = {1.0: ((u + v) ** 2 + (x + y) ** 2) / 4, 3.0: ((u - v) ** 2 + 3 * (x - y) ** 2) / 4}
            for n, fraction in (("mode_1", mpf(1) / 2), ("mode_2", mpf(1) / 4)):
                own = energies[float(round(float(frequency[n]) ** 2))]
                assert abs(own - fraction * frequency[n]) < mpf(10) ** -27


def test_a_motion_from_actions_is_started_anew_in_the_users_coordinates() -> None:
    solution = hjsolve.solve(hjsolve.System(*FIELDS["isochrone"]), coordinates="find")
    given: dict[str, Any] = {"actions": {"r": "0.1", "theta": "0.4"}, "angles": {"r": "0.3"}}
    motion = solution.motion(**given)
    assert set(motion.again(20, {}).at(1).q) == {"x", "y"}
    with pytest.raises(hjsolve.InvalidInputError, match="known are r, theta"):
        solution.motion(actions={"x": 1, "y": 1})
    with pytest.raises(hjsolve.InvalidInputError, match="actions="):
        solution.motion(actions={"r": 1, "theta": 1}, velocity={"x": 1, "y": 1})


def test_tori_about_either_of_two_centres_are_both_told_and_a_place_chooses() -> None:
    """Newton's method went downhill into the deeper well, and the torus about the other centre was never seen."""
    coordinates, T, V = FIELDS["two centres"]
    solution = hjsolve.solve(hjsolve.System(coordinates, T, V), coordinates="find")
    motion = solution.motion(q={"x": "0.7", "y": "0.9"}, velocity={"x": "0.1", "y": "0.5"})
    actions = {n: x.value for n, x in motion.actions.items()}
    with pytest.raises(hjsolve.InvalidInputError, match=r"several tori .* nu libration from -1.07.* to 1.07"):
        solution.motion(actions=actions)
    found = solution.motion(actions=actions, q={"x": "0.7", "y": "0.9"})
    for name, constant in motion.constants.items():
        assert abs(found.constants[name].value - constant.value) <= 1e-13 * abs(constant.value)
    other = solution.motion(actions=actions, q={"x": -1, "y": "0.3"})
    assert other.constants["E"].value < 2 * motion.constants["E"].value
