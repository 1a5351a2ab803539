"""Walls that take energy: their bounces accumulate at a finite time, which is a named event with its error."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp

from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.scenes import Scene
from tests.support.billiards import wall

pytestmark = pytest.mark.rotating_file(2)

LINE = {"coordinates": [{"name": "z", "domain": "line"}], "kinetic": "dot(z)**2/2"}
PLANE = {"coordinates": [{"name": c, "domain": "line"} for c in "xz"], "kinetic": "dot(x)**2/2 + dot(z)**2/2"}


def dropped(e: str, potential: str = "10*z", **more: Any) -> Any:
    """From rest at 5/4; on 10 z the floor is met after 1/2 with the speed 5."""
    table = {
        "system": {**LINE, "potential": potential}, "initial": {"q": {"z": "1.25"}, "velocity": {"z": "0"}},
        "want": ["constants", "trajectory"], "times": {"start": 0, "stop": 6, "count": 25},
        "events": [wall("z", "0", restitution=e, name="floor")],
    }  # fmt: skip
    return Scene.load({**table, **more}).run()


def height(t: Any, e: Any) -> Any:
    """The bouncing ball: after bounce n the speed 5 eⁿ and a flight of 5 eⁿ/5."""
    begin, speed = mp.mpf(1) / 2, mp.mpf(5)
    if t < begin:
        return mp.mpf("1.25") - 5 * t * t
    while speed > mp.mpf(10) ** -30:
        speed *= e
        if t < begin + speed / 5:
            return speed * (t - begin) - 5 * (t - begin) ** 2
        begin += speed / 5
    return mp.zero


@pytest.mark.nightly_cases("4/5")
@pytest.mark.parametrize("e", ["4/5", "1/2", "0.3", "0"])
def test_a_ball_comes_to_rest_at_the_limit_of_the_geometric_series(e: str) -> None:
    run = dropped(e)
    with mp.workdps(40):
        ratio = mp.mpf(Fraction(e).numerator) / Fraction(e).denominator
        limit = mp.mpf(1) / 2 + ratio / (1 - ratio)
        assert abs(mp.mpf(run.rest.time.value) - limit) <= run.rest.time.error < 1e-15
        assert run.rest.q["z"].value == 0
        assert abs(run.rest.p["z"].value) <= run.rest.p["z"].error < 1e-15
        for k, t in enumerate(run.trajectory.t):
            true = height(mp.mpf(float(t)), ratio)
            assert abs(mp.mpf(run.trajectory.q["z"][k]) - true) <= run.trajectory.error.q["z"][k] < 1e-13
            assert (run.trajectory.status[k] == "at_rest") == (t > limit - mp.mpf(10) ** -25)
    assert run.arcs[-1].events[-1].kind == "rest"
    assert "keeps the body" in str(run.arcs[-1].events[-1])
    assert "rests there" in str(run.rest)


def test_each_bounce_leaves_the_square_of_the_restitution_of_the_energy() -> None:
    run = dropped("4/5")
    energies = [arc.quantities["constants"]["E"].value for arc in run.arcs[:6]]
    assert max(abs(b / a - 0.64) for a, b in itertools.pairwise(energies)) < 1e-14


def test_a_wall_on_a_curved_well_is_extrapolated_as_well() -> None:
    """V = z²/2 + z: from rest the flights are arcs of cos t; the limit by an infinite sum over them in 40 digits."""
    run = dropped("0.6", "z**2/2 + z", times={"start": 0, "stop": 12, "count": 7})
    with mp.workdps(40):
        speed, time = mp.sqrt(mp.mpf("2.25") ** 2 - 1), mp.acos(1 / mp.mpf("2.25"))
        for _ in range(200):
            speed *= mp.mpf("0.6")
            time += 2 * mp.atan(speed)  # z + 1 = cos t + v sin t is 1 again after twice the phase of its maximum
        assert abs(mp.mpf(run.rest.time.value) - time) <= run.rest.time.error < 1e-15


@pytest.mark.nightly
def test_what_else_moves_is_where_it_is_at_the_limit_and_the_scene_ends() -> None:
    run = Scene.load({
        "system": {**PLANE, "potential": "10*z + x**2/2"}, "initial": {"q": {"x": "1", "z": "1.25"},
        "velocity": {"x": "0", "z": "0"}}, "want": ["trajectory"], "times": ["0.7", "4"],
        "events": [wall("z", "0", restitution="1/2")],
    }).run()  # fmt: skip
    assert abs(run.rest.time.value - 1.5) <= run.rest.time.error < 1e-15
    assert abs(run.rest.q["x"].value - np.cos(1.5)) < 1e-15
    assert abs(run.rest.p["x"].value + np.sin(1.5)) < 1e-15
    assert list(run.trajectory.status) == ["ok", "ended"]
    assert np.isnan(run.trajectory.q["x"][1])
    assert np.isnan(run.trajectory.error.q["x"][1])


def test_nothing_is_kept_where_no_force_presses() -> None:
    """On z²/2 with the wall in the middle each flight takes π, however slow: the bounces go on."""
    run = dropped("1/2", "z**2/2")
    assert run.rest is None
    assert len(run.arcs) == 3
    ceiling = dropped("0", initial={"q": {"z": "-1"}, "velocity": {"z": "5"}}, times=["0.1", "1"])
    assert ceiling.rest is None  # it loses its speed at z = 0 and falls again
    with mp.workdps(30):
        fall = 1 - (5 - mp.sqrt(5)) / 10
        assert abs(ceiling.trajectory.q["z"][1] + 5 * fall**2) < 1e-14


def test_an_impulse_before_the_limit_is_not_passed_over() -> None:
    push = {"kind": "impulse", "at": {"t": "1.4"}, "momentum": {"z": "3"}}
    run = dropped("1/2", events=[wall("z", "0", restitution="1/2"), push])
    assert any(event.kind == "impulse" for arc in run.arcs for event in arc.events)
    assert run.rest.time.value > 1.9


def test_a_start_at_rest_on_a_wall_is_asked_for_its_side() -> None:
    with pytest.raises(InvalidInputError, match="its side is not determined"):
        dropped("1", initial={"q": {"z": "0"}, "velocity": {"z": "0"}})


@pytest.mark.nightly
def test_events_that_never_end_are_told_early() -> None:
    with pytest.raises(NotConvergedError, match="shorten the scene"):
        dropped("1/2", "z**2/2", times=["1e20"])
