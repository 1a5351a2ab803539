"""Many bounces: against closed forms, against one motion an arc, and what they cost, counted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp

from hjsolve.errors import NotConvergedError
from hjsolve.scenes import Scene, arcs
from tests.support import billiards
from tests.support.billiards import wall

PLANE = {"coordinates": [{"name": "x", "domain": "line"}, {"name": "y", "domain": "line"}],
         "kinetic": "dot(x)**2/2 + dot(y)**2/2"}  # fmt: skip
SYSTEMS: dict[str, tuple[dict[str, Any], billiards.Truth, int]] = {
    "ball": (billiards.BALL, billiards.ball, 1500), "box": (billiards.BOX, billiards.box, 1500),
    "quartic": (billiards.QUARTIC, billiards.quartic, 5000), "circle": (billiards.CIRCLE, billiards.circle, 600),
    "sector": (billiards.SECTOR, billiards.sector, 60),
}  # fmt: skip


def ran(table: dict[str, Any], stop: Any, count: int = 41, **more: Any) -> Any:
    """A scene with its constants and its trajectory."""
    return Scene.load({**table, "want": ["constants", "trajectory"], "times": {"start": 0, "stop": stop, "count": count},
                       **more}).run()  # fmt: skip


@pytest.mark.parametrize("name", SYSTEMS)
def test_states_after_many_bounces_are_within_their_claims_of_the_closed_form(name: str) -> None:
    table, truth, stop = SYSTEMS[name]
    run = ran(table, f"{stop}.7", 13)
    assert len(run.arcs) > {"circle": 200, "sector": 50}.get(name, 1000)
    with mp.workdps(40):
        worst, false = violations = billiards.violations(run, truth)
    assert false == 0, violations
    assert worst < 1e-14
    assert max(np.max(run.trajectory.error.q[n]) for n in run.trajectory.q) < 1e-12


@pytest.mark.parametrize("name", ["ball", "sector"])
def test_the_same_in_thirty_digits(name: str) -> None:
    table, truth, _ = SYSTEMS[name]
    run = ran(table, 70, 5, accuracy={"digits": 30})
    with mp.workdps(60):
        worst, false = billiards.violations(run, truth)
    assert false == 0
    assert worst < mp.mpf(10) ** -29


def test_the_energy_of_the_last_arc_is_that_of_the_first() -> None:
    run = ran(billiards.BALL, 1500)
    first, last = (run.quantity("constants", arc=k)["E"] for k in (0, -1))
    assert first == last
    assert abs(last.value - 12.3075) <= last.error < 1e-14


def test_the_times_of_bounces_are_within_their_claims() -> None:
    run = ran(billiards.BALL, 1500)
    with mp.workdps(40):
        g, v0 = mp.mpf("9.81"), mp.mpf("0.3")
        up = mp.sqrt(v0**2 + 2 * g * mp.mpf("1.25"))
        for k, arc in enumerate(run.arcs[:-1]):
            assert (
                abs(mp.mpf(arc.ends.value) - ((v0 + up) / g + 2 * k * up / g))
                <= arc.ends.error
                <= 4e-16 * arc.ends.value
            )


@pytest.mark.parametrize("name", ["ball", "box", "circle"])
def test_ten_times_the_bounces_evaluate_no_integral_more(name: str) -> None:
    table, _, _ = SYSTEMS[name]
    few, many = (ran(table, stop, 2) for stop in (30, 300))
    assert len(many.arcs) > 8 * len(few.arcs)
    for part in ("squares", "kernels"):  # a digit more for ten times the time
        assert getattr(many.work, part) <= 1.3 * getattr(few.work, part)
    assert many.work.places <= few.work.places + 8


MIXED: dict[str, dict[str, Any]] = {
    "oscillators": {"system": {**PLANE, "potential": "x**2/2 + y**4/4"},
                    "initial": {"q": {"x": "0.3", "y": "0.1"}, "velocity": {"x": "0.7", "y": "0.45"}},
                    "events": [wall("x", "0.5"), wall("y", "-1/3"), wall("x", "-0.7")]},
    "corridor": {"system": {**PLANE, "potential": "9*y"},
                 "initial": {"q": {"x": "0.3", "y": "1"}, "velocity": {"x": "0.7", "y": "0.45"}},
                 "events": [wall("x", "0"), wall("x", "1"), wall("y", "0")]},
    "turning field": {"system": "isotropic-oscillator-polar", "effects": ["magnetic-field"],
                      "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0.3", "theta": "0.8"}},
                      "events": [wall("r", "1.02")]},
    "going round": {"system": "pendulum", "initial": {"q": {"theta": "0"}, "velocity": {"theta": "8"}},
                    "events": [wall("theta", "1")]},
    "hill": {"system": {"coordinates": [{"name": "x", "domain": "line"}], "kinetic": "dot(x)**2/2",
                        "potential": "-x**2/2"},
             "initial": {"q": {"x": "-1"}, "velocity": {"x": "2"}}, "events": [wall("x", "1"), wall("x", "-3/2")]},
    "circular": {"system": "kepler-planar", "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0", "theta": "1"}},
                 "events": [wall("theta", "1"), wall("theta", "-1")]},
    "pushed": {"system": "kepler-planar", "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0.1", "theta": "1.1"}},
               "events": [wall("r", "1.2"),
                          {"kind": "impulse", "at": {"coordinate": "theta", "value": "1", "passage": 1}, "momentum": {"r": "0.1"}},
                          {"kind": "impulse", "at": {"t": "3.3"}, "momentum": {"theta": "-0.05"}}]},
}  # fmt: skip


@pytest.mark.nightly_cases("corridor", "pushed")
@pytest.mark.parametrize("name", MIXED)
def test_bounces_by_sign_are_bounces_with_new_constants(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stop = "2.5" if name == "corridor" else 4
    quick = ran(MIXED[name], stop, 9)
    monkeypatch.setattr(arcs, "mirrors", lambda _: None)
    slow = ran(MIXED[name], stop, 9)
    assert len(quick.arcs) == len(slow.arcs) > 2
    for one, other in zip(quick.arcs, slow.arcs, strict=True):
        assert one.events == other.events
        assert all(one.turns[angle] == other.turns.get(angle, 0) for angle in one.turns)
        for constant, value in one.quantities["constants"].items():
            assert abs(value.value - other.quantities["constants"][constant].value) <= 4 * value.error + 1e-15
    for part in ("q", "p", "velocity"):
        for coordinate in quick.trajectory.q:
            a, b = (getattr(run.trajectory, part)[coordinate] for run in (quick, slow))
            if part == "q":
                a, b = (run.trajectory.unwrapped(coordinate) for run in (quick, slow))
            bound = sum(getattr(run.trajectory.error, part)[coordinate] for run in (quick, slow))
            assert np.all(np.abs(a - b) <= bound + 4e-15 * (part == "q"))


def test_the_motion_of_an_arc_begins_where_the_arc_does() -> None:
    run = ran(billiards.SECTOR, 6, 601)
    for arc in run.arcs[1:]:
        state = arc.motion.at(arc.begins.value)
        k = int(np.searchsorted(run.trajectory.t, arc.begins.value))
        later = arc.motion.at(run.trajectory.t[k])
        assert abs(later.q["theta"] - run.trajectory.q["theta"][k]) < 1e-14
        assert any(
            abs(state.q[e.coordinate] - float(e.value)) < 1e-14 for e in run.arcs[run.arcs.index(arc) - 1].events
        )


def test_a_rotation_turned_round_has_the_action_of_its_direction() -> None:
    table = {**MIXED["going round"], "want": ["actions", "kinds"], "times": [3]}
    run = Scene.load(table).run()
    forth, back = (run.quantity("actions", arc=k)["theta"].value for k in (0, 1))
    assert back == -forth < 0


def test_more_bounces_than_can_be_followed_are_told_at_once() -> None:
    with pytest.raises(NotConvergedError, match="shorten the scene"):
        ran(billiards.BALL, "1e40", 2)
