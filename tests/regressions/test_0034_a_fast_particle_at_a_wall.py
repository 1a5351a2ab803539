"""A wall and a jump of velocity took a relativistic momentum for m·q̇; the momentum after them was wrong."""

from __future__ import annotations

from typing import Any

import pytest
from mpmath import mp

from hjsolve.errors import InvalidInputError
from hjsolve.motion.initial_data import read_initial_data
from hjsolve.scenes import Scene
from hjsolve.scenes.events import changed, read_event
from hjsolve.solution.quadratures import solve
from tests.support.billiards import wall


def scene(event: dict[str, Any]) -> Any:
    """The harmonic relativistic oscillator of the catalog, an event at once."""
    return Scene.load({
        "system": "relativistic-oscillator", "want": ["constants", "trajectory"], "times": [1, 3], "events": [event],
    })  # fmt: skip


def test_a_wall_keeps_the_energy_and_turns_the_momentum() -> None:
    system = scene({"kind": "impulse", "at": {"t": "1"}, "momentum": {"x": "0"}}).system
    name = system.coordinates[0].name
    solution = solve(system)
    values = read_initial_data(solution, q={name: "1/3"}, velocity=None, p={name: "3"}, parameters={}).values
    event = read_event(wall(name, "1/3"), system, "events[1]")
    assert changed(event, system, values) == {name: -3}
    push = read_event({"kind": "impulse", "at": {"t": "1"}, "velocity": {name: "0.01"}}, system, "events[1]")
    new = changed(push, system, values)[name]
    with mp.workdps(30):
        numbers = {p.name: mp.mpf(str(values[p.symbol].evalf(30))) for p in system.parameters}
        m, c = numbers["m0"], numbers["c"]
        v = 3 * c / mp.sqrt(m**2 * c**2 + 9) + mp.mpf("0.01")
        assert abs(mp.mpf(str(new.evalf(30))) - m * v / mp.sqrt(1 - v**2 / c**2)) < mp.mpf(10) ** -25


def test_nothing_is_pushed_beyond_the_speed_of_light() -> None:
    system = scene({"kind": "impulse", "at": {"t": "1"}, "momentum": {"x": "0"}}).system
    name = system.coordinates[0].name
    values = read_initial_data(solve(system), q={name: "0"}, velocity=None, p={name: "1"}, parameters={}).values
    push = read_event({"kind": "impulse", "at": {"t": "1"}, "velocity": {name: "1e9"}}, system, "events[1]")
    with pytest.raises(InvalidInputError, match="as fast as light"):
        changed(push, system, values)
