"""The regularisation serves any potential a user may type: random analytic ones, against mpmath's tanh-sinh rule."""

from __future__ import annotations

import os

import pytest
from hypothesis import assume, given, note, settings
from hypothesis import strategies as st
from mpmath import mp

import hjsolve
from hjsolve.errors import NotConvergedError
from tests.support.random_potentials import (
    ROUNDING_ERROR,
    coefficient,
    confining,
    degenerate,
    line,
    positive,
    potentials,
)

NIGHTLY = os.environ.get("HYPOTHESIS_PROFILE") == "nightly"
pytestmark = [pytest.mark.timeout(7200)] if NIGHTLY else []


def examples(count):
    return settings(max_examples=60 * count if NIGHTLY else count)


def moving(potential, place, speed, **more):
    """A unit mass in a potential."""
    system = hjsolve.System(coordinates={"x": "line"}, kinetic="dot(x)**2/2", potential=potential)
    return hjsolve.solve(system).motion(q={"x": place}, velocity={"x": speed}, **more)


def holds(estimate, truth):
    """The truth lies within the claimed error, which is at most a few units in the fourteenth digit."""
    error = abs(mp.mpf(estimate.value) - truth)
    note(f"{estimate} against {mp.nstr(truth, 20)}: {mp.nstr(error, 3)}")
    assert error <= estimate.error
    assert estimate.error <= 1e-13 * abs(truth) + 1e-300


@pytest.mark.nightly
@examples(8)
@given(confining, coefficient("-2", "2"), positive)
def test_a_confined_mass_has_the_turning_points_period_action_and_states_of_the_integrals(potential, place, speed):
    with mp.workdps(50):
        curve, _ = line(potential, place, speed)
        ends = curve.turning()
        assume(ends is not None and None not in ends and not degenerate(curve, ends))
        motion = moving(potential, place, speed)
        assert motion.kinds == {"x": "libration"}
        for ours, truth in zip(motion.turning_points["x"], ends, strict=True):
            assert abs(mp.mpf(ours.value) - truth) <= ours.error
        half = curve.time(*ends)
        holds(motion.periods["x"], 2 * half)
        holds(motion.actions["x"], curve.mean(lambda _: 1, *ends))
        since = curve.time(ends[0], curve.start)
        for fraction in (0.13, 0.71, 3.4):
            t = fraction * motion.periods["x"].value
            state = motion.at(t)
            q, v = mp.mpf(state.q["x"]), mp.mpf(state.velocity["x"])
            note(f"{t=} {state.q} {state.error.q}")
            if not ends[0] < q < ends[1]:
                assert min(abs(q - end) for end in ends) <= state.error.q["x"]
                continue
            there = curve.time(ends[0], q)
            phase = there if v > 0 else 2 * half - there
            late = (since + mp.mpf(t) - phase) / (2 * half)
            late = abs(late - mp.nint(late)) * 2 * half
            assert late * mp.sqrt(curve.square(q)) <= state.error.q["x"] * (1 + mp.mpf("1e-6")) + mp.mpf("1e-25")
            assert abs(abs(v) - mp.sqrt(curve.square(q))) <= state.error.velocity["x"] + late_speed(curve, q, state)


def late_speed(curve, q, state):
    """What the error of q may add to the speed that belongs to it."""
    here = mp.sqrt(abs(curve.square(q)))
    return abs(here - mp.sqrt(abs(curve.square(q + state.error.q["x"])))) + abs(
        here - mp.sqrt(abs(curve.square(q - state.error.q["x"])))
    )


@examples(4)
@pytest.mark.slow
@given(potentials, coefficient("-2", "2"), positive)
def test_whatever_the_potential_the_kind_is_right_and_an_escape_keeps_its_time(potential, place, speed):
    with mp.workdps(40):
        curve, _ = line(potential, place, speed)
        ends = curve.turning()
        assume(ends is not None and not degenerate(curve, ends))
        try:
            motion = moving(potential, place, speed)
        except NotConvergedError:
            assume(False)  # honest; how often is counted in the campaign
        assume(
            motion.kinds["x"] not in {"ignorable", "rotation"}
        )  # a constant potential; a periodic one has its own tests
        bounded = None not in ends
        assert (motion.kinds["x"] == "libration") == bounded
        if not bounded:
            assert motion.kinds["x"] in {"escape", "boundary"}
            for ours, truth in zip(motion.turning_points["x"], ends, strict=True):
                assert (ours is None) == (truth is None)
                assert ours is None or abs(mp.mpf(ours.value) - truth) <= ours.error
            if ends[1] is None:
                state = motion.at(0.4)
                if state.status != "ok":
                    return
                passed = curve.time(curve.start, mp.mpf(state.q["x"]))
                late = abs(passed - mp.mpf(0.4))
                assert late * mp.sqrt(curve.square(mp.mpf(state.q["x"]))) <= state.error.q["x"]


@pytest.mark.nightly
@examples(4)
@given(confining, coefficient("-2", "2"), positive)
def test_thirty_digits_mean_thirty(potential, place, speed):
    with mp.workdps(70):
        curve, _ = line(potential, place, speed)
        ends = curve.turning()
        assume(ends is not None and None not in ends and not degenerate(curve, ends))
        motion = moving(potential, place, speed, digits=30)
        period, truth = motion.periods["x"], 2 * curve.time(*ends)
        assert abs(period.value - truth) <= period.error <= mp.mpf("1.01e-30") * truth


@pytest.mark.nightly
@examples(5)
@given(confining, coefficient("-2", "2"), positive, st.sampled_from([15, 24, 40]))
def test_proved_numbers_hold_the_truth(potential, place, speed, digits):
    pytest.importorskip("flint", reason="needs the extra certified")
    with mp.workdps(2 * digits + 20):
        curve, _ = line(potential, place, speed)
        ends = curve.turning()
        assume(ends is not None and None not in ends and not degenerate(curve, ends))
        motion = moving(potential, place, speed, digits=digits, certified=True, want=["turning_points", "periods"])
        period = 2 * curve.time(*ends)
        found = [(end, ours, mp.zero) for end, ours in zip(ends, motion.turning_points["x"], strict=True)]
        found.append((period, motion.periods["x"], mp.eps**ROUNDING_ERROR * period))
        for truth, ours, rounding_error in found:
            note(f"{ours} against {mp.nstr(truth, digits + 10)}")
            assert ours.certified
            assert abs(mp.mpf(ours.value) - truth) <= ours.error + rounding_error
            assert ours.error <= mp.mpf(10) ** -digits * max(abs(truth), 1) * (16 if digits == 15 else 2)
