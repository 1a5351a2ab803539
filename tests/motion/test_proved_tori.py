"""Tori proved from their actions: every enclosure holds the closed form, or what many more digits give."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.motion.tori import from_actions
from tests.support import entries

pytest.importorskip("flint", reason="needs the extra certified")

ASKED = {
    "kepler": ("kepler-planar", {"actions": {"r": "0.7", "theta": "-0.3"}}),
    "nearly circular": ("kepler-planar", {"actions": {"r": "1e-12", "theta": "1"}}),
    "libration": ("pendulum", {"actions": {"theta": "3.5"}}),
    "rotation": ("pendulum", {"actions": {"theta": "-9"}}),
    "next to the separatrix": ("pendulum", {"actions": {"theta": "7.97"}, "kinds": {"theta": "libration"}}),
    "well": ("double-well", {"actions": {"x": "0.01"}, "q": {"x": -1}}),
    "sphere": ("spherical-pendulum", {"actions": {"theta": "0.3", "phi": "-1"}}),
    "inclined": ("kepler-spherical", {"actions": {"r": "0.3", "theta": "0.2", "phi": "-1"}}),
}


def all_values(motion):
    """Every enclosed number by name."""
    for group in ("constants", "actions", "frequencies", "periods"):
        yield from ((group, name, x) for name, x in getattr(motion, group).items())
    for name, ends in motion.turning_points.items():
        yield from (("turning_points", (name, k), x) for k, x in enumerate(ends) if x is not None)


@pytest.mark.nightly_cases("nearly circular", "libration", "next to the separatrix", "well", "sphere", "inclined")
@pytest.mark.parametrize("case", ASKED)
def test_every_proved_number_holds_what_many_digits_give(case):
    name, asked = ASKED[case]
    solution = entries.solved(name)
    proved, fine = solution.motion(**asked, certified=True), solution.motion(**asked, digits=40)
    truth = {(group, name): x.value for group, name, x in all_values(fine)}
    seen = 0
    for group, name, x in all_values(proved):
        assert x.certified, (group, name)
        with mp.workdps(60):
            assert abs(mp.mpf(x.value) - mp.mpf(truth[group, name])) <= x.error, (group, name)
        assert x.error <= 2e-15 * abs(x.value) + 1e-300, (group, name)
        seen += 1
    assert seen == len(truth)


def test_thirty_digits_of_kepler_are_proved():
    motion = entries.solved("kepler-planar").motion(actions={"r": "0.7", "theta": "-0.3"}, certified=True, digits=30)
    energy, rate = motion.constants["E"], motion.frequencies["r"]
    with mp.workdps(60):  # E = −1/(2 (J + |L|)²), Ω = 1/(J + |L|)³
        assert abs(energy.value + mp.mpf("0.5")) <= energy.error <= 1e-30
        assert abs(rate.value - 1) <= rate.error <= 1e-29
    assert energy.certified
    assert rate.certified


def test_states_are_at_the_angles_given():
    asked = {"actions": {"r": "0.7", "theta": "1.3"}, "angles": {"r": "0.4", "theta": "-1"}}
    solution = entries.solved("kepler-planar")
    one, other = solution.motion(**asked, certified=True).at("1.5"), solution.motion(**asked).at("1.5")
    assert (one.q, one.p) == (other.q, other.p)


def test_a_coordinate_at_rest_is_not_proved_and_says_so():
    with pytest.raises(hjsolve.InvalidInputError, match="r is in equilibrium"):
        entries.solved("kepler-planar").motion(actions={"r": 0, "theta": 1}, certified=True)


@pytest.mark.parametrize("factor", ["1.000000001", "1.01"])
def test_a_torus_is_proved_for_the_actions_given_to_the_proof_or_not_at_all(monkeypatch, factor):
    """The box is about where J(α) is what was asked: from next to it the step leads there, from afar nowhere."""
    plain = from_actions.proved_torus

    def of_others(motion, goal, given, curves, digits):
        return plain(
            motion, replace(goal, actions=[J * sp.Rational(factor) for J in goal.actions]), given, curves, digits
        )

    monkeypatch.setattr(from_actions, "proved_torus", of_others)

    def found():
        return entries.solved("kepler-planar").motion(actions={"r": "0.7", "theta": "0.3"}, certified=True)

    if factor == "1.01":
        with pytest.raises(hjsolve.NotConvergedError, match="could not be proved"):
            found()
        return
    energy = found().constants["E"]
    with mp.workdps(40):
        E = -1 / (2 * (mp.mpf("0.7") * mp.mpf(factor) + mp.mpf("0.3")) ** 2)
        assert abs(energy.value - E) <= energy.error <= 1e-15
