"""Numbers like 1e300 ended in an AttributeError, an unknown id in a line of 3 kB, an oblique wall in two lines."""

from __future__ import annotations

from typing import Any

import pytest

from hjsolve import catalog
from hjsolve.errors import CatalogError
from hjsolve.scenes import Scene
from tests.support.billiards import BALL, KEPLER, wall

BASE: dict[str, Any] = {**BALL, "want": ["trajectory"], "times": [1, 2]}
PUSH = {"kind": "impulse", "at": {"t": "1"}}
FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "a push": ({**BASE, "events": [{**PUSH, "velocity": {"z": "1e300"}}]}, "events[1].z: with events"),
    "a small push": ({**BASE, "events": [{**PUSH, "momentum": {"z": "5e-324"}}]}, "events[1].z: with events"),
    "a place": ({**BASE, "initial": {"q": {"z": "-1e160"}, "velocity": {"z": "0"}}}, "initial.q.z: with events"),
    "a velocity": (
        {**BASE, "initial": {"q": {"z": "1"}, "velocity": {"z": "1e400"}}},
        "initial.velocity.z: with events",
    ),
    "a wall": ({**BASE, "events": [wall("z", "1e-300")]}, "events[1].at.value: with events"),
    "a restitution": ({**BASE, "events": [wall("z", "0", restitution="1e-300")]}, "events[1].restitution: with events"),
    "a time": ({**BASE, "times": ["1e300"]}, "times: with events"),
    "an angle": ({**KEPLER, "times": [1], "events": [wall("theta", "1e90")]}, "at.value: an angle beyond"),
    "an oblique wall": ({**BASE, "events": [{"kind": "wall", "surface": "x = z"}]}, "events[1].surface: only walls"),
    "an unknown id": ({**BASE, "system": "zzzz"}, "`hjsolve catalog`"),
    "part of an id": ({**BASE, "system": "monopole"}, "charge-in-monopole-field"),
}


@pytest.mark.parametrize("kind", FAULTS)
def test_one_clear_line(kind: str) -> None:
    table, expected = FAULTS[kind]
    with pytest.raises(CatalogError) as fault:
        Scene.load(table)
    text = str(fault.value)
    assert expected in text
    assert len(text.splitlines()) == 1
    assert len(text) < 250


def test_a_near_miss_of_an_id_is_still_named() -> None:
    with pytest.raises(CatalogError, match=r'did you mean "kepler-planar"\?'):
        catalog.load("kepler-plannar")


@pytest.mark.parametrize("size", ["1e60", "1e-60"])
def test_what_is_large_but_not_beyond_all_measure_is_run(size: str) -> None:
    run = Scene.load({**BASE, "events": [{**PUSH, "velocity": {"z": size}}]}).run()
    assert abs(run.trajectory.velocity["z"][1] / (float(size) + 0.3 - 2 * 9.81) - 1) < 1e-14
