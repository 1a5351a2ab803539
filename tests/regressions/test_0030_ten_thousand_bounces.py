"""A bounce cost 0.18 s, for the motion was made anew at each; and two walls at one place let a body through."""

from __future__ import annotations

from typing import Any

import pytest
from mpmath import mp

from hjsolve.scenes import Scene
from tests.support import billiards
from tests.support.billiards import wall


def test_ten_thousand_bounces_evaluate_what_ten_do() -> None:
    def work(stop: int) -> Any:
        run = Scene.load(
            {**billiards.BALL, "want": ["trajectory"], "times": {"start": 0, "stop": stop, "count": 3}}
        ).run()
        assert len(run.arcs) > 0.98 * stop
        return run.work

    few, many = work(10), work(10_300)
    assert many.squares < 2 * few.squares
    assert many.kernels < 2 * few.kernels


def test_two_walls_a_millionth_apart_are_met_thousands_of_times() -> None:
    table = {**billiards.BALL["system"], "potential": "0"}
    run = Scene.load({
        "system": table, "initial": {"q": {"z": "5e-7"}, "velocity": {"z": "1"}}, "want": ["trajectory"],
        "times": ["0.0031234567"], "events": [wall("z", "0"), wall("z", "1e-6")],
    }).run()  # fmt: skip
    assert len(run.arcs) == 3124
    with mp.workdps(40):
        z, _ = billiards.reduced(mp.mpf("5e-7") + mp.mpf("0.0031234567"), mp.mpf("1e-6"))
        assert abs(run.trajectory.q["z"][0] - z) <= run.trajectory.error.q["z"][0] < 1e-17


@pytest.mark.parametrize("system", ["falling", "with a wall that asks for new constants"])
def test_two_walls_at_one_place_turn_a_body_once(system: str) -> None:
    """z = 5/4 − 5 t² until t = 1/2, then the parabola again: z(3/4) = 15/16, where 5/4 − 45/16 < 0 lies beneath."""
    walls = [wall("z", "0"), wall("z", "0", name="the same again")]
    if system != "falling":
        walls.append(wall("z", "0", restitution="1/2"))
    run = Scene.load({
        "system": {**billiards.BALL["system"], "potential": "10*z"}, "want": ["trajectory"], "times": ["3/4", 2],
        "initial": {"q": {"z": "1.25"}, "velocity": {"z": "0"}}, "events": walls,
    }).run()  # fmt: skip
    assert len(run.arcs[0].events) == len(walls)
    assert abs(run.trajectory.q["z"][0] - 15 / 16) < 1e-15
    assert abs(run.trajectory.q["z"][1]) - 1.25 < 1e-15
    assert run.trajectory.q["z"][1] > 0


def test_a_corner_turns_both_ways_a_thousand_times() -> None:
    plane = {"coordinates": [{"name": c, "domain": "line"} for c in "xy"], "kinetic": "dot(x)**2/2 + dot(y)**2/2"}
    run = Scene.load({
        "system": plane, "initial": {"q": {"x": "1/3", "y": "1/3"}, "velocity": {"x": "1", "y": "1"}},
        "want": ["trajectory"], "times": ["1000.25"], "events": [wall(c, str(v)) for c in "xy" for v in (0, 1)],
    }).run()  # fmt: skip
    assert len(run.arcs) == 1001
    assert all(len(arc.events) == 2 for arc in run.arcs[:-1])
    assert run.trajectory.q["x"][0] == run.trajectory.q["y"][0]
    with mp.workdps(30):
        x, _ = billiards.reduced(mp.mpf(1) / 3 + mp.mpf("1000.25"), 1)
        assert abs(run.trajectory.q["x"][0] - x) <= run.trajectory.error.q["x"][0] < 1e-14
