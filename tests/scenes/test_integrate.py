"""Effects that Hamilton-Jacobi cannot take: refused with the obstruction, or integrated when the scene says so."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.errors import NotConvergedError, NotSeparableError
from hjsolve.scenes import Scene
from hjsolve.separation import Obstruction

PENDULUM = {
    "system": "pendulum", "initial": {"q": {"theta": "0.4"}, "velocity": {"theta": "-1"}}, "want": ["trajectory"],
    "times": {"start": 0, "stop": 10, "count": 101},
}  # fmt: skip


def test_drag_is_refused_with_the_power_it_takes() -> None:
    with pytest.raises(NotSeparableError, match=r"dH/dt = -c\*dot\(theta\)\*\*2.*method = \"integrate\"") as refusal:
        Scene.load({**PENDULUM, "effects": ["drag"]}).run()
    assert refusal.value.verdict.part == "dissipation"


def test_an_effect_that_breaks_separability_is_refused_with_the_obstruction() -> None:
    with pytest.raises(NotSeparableError, match='or write method = "integrate"') as refusal:
        Scene.load({"system": "kepler-planar", "effects": ["uniform-field"]}).run()
    verdict = refusal.value.verdict
    assert isinstance(verdict, Obstruction)
    assert set(verdict.pair) == {"r", "theta"}


def test_the_integrator_agrees_with_the_quadratures_within_its_error() -> None:
    exact = Scene.load(PENDULUM).run().trajectory
    run = Scene.load({**PENDULUM, "method": "integrate", "want": ["trajectory", "constants"]}).run()
    difference = np.abs(run.trajectory.q["theta"] - exact.q["theta"])
    assert np.all(difference <= run.trajectory.error.q["theta"])
    assert difference.max() < 1e-10
    assert np.abs(run.drift["E"]).max() < 1e-10
    assert run.solution is None


def test_events_of_an_integrated_scene_agree_with_the_exact_ones() -> None:
    events = [
        {"kind": "impulse", "at": {"t": "5"}, "momentum": {"theta": "0.1"}},
        {"kind": "wall", "at": {"coordinate": "theta", "value": "0.5"}},
        {"kind": "impulse", "at": {"coordinate": "theta", "value": "-0.1", "passage": 3}, "velocity": {"theta": "0.3"}},
    ]
    exact = Scene.load({**PENDULUM, "events": events}).run()
    run = Scene.load({**PENDULUM, "events": events, "method": "integrate"}).run()
    assert list(run.trajectory.arc) == list(exact.trajectory.arc)
    difference = np.abs(run.trajectory.q["theta"] - exact.trajectory.q["theta"])
    assert len(exact.arcs) > 4
    assert difference.max() < 1e-9
    assert np.all(difference <= run.trajectory.error.q["theta"])


def test_a_damped_oscillator_is_the_closed_form() -> None:
    run = Scene.load({
        "system": "harmonic-oscillator", "effects": ["drag"], "method": "integrate",
        "parameters": {"c": "0.2", "k": "4"}, "initial": {"q": {"x": "1"}, "velocity": {"x": "0"}}, "want": ["trajectory", "constants"],
        "times": {"start": 0, "stop": 20, "count": 41}, "accuracy": {"digits": 11},
    }).run()  # fmt: skip
    t, w = run.trajectory.t, np.sqrt(4 - 0.1**2)
    x = np.exp(-0.1 * t) * (np.cos(w * t) + 0.1 / w * np.sin(w * t))
    difference = np.abs(run.trajectory.q["x"] - x)
    assert difference.max() < 1e-11
    assert np.all(difference <= run.trajectory.error.q["x"])
    # dE/dt = -c*v**2 (Greenwood (3-5)): the energy only falls, and to exp(-0.2 t) of itself on the whole
    assert np.all(np.diff(run.drift["E"]) < 0)
    assert abs(run.drift["E"][-1] + 2 * (1 - np.exp(-0.2 * 20))) < 0.02


def test_the_drift_is_that_of_the_former_constants() -> None:
    run = Scene.load("scenes/planet-in-a-wind.toml").run()
    assert set(run.drift) == {"E", "p_theta"}
    assert np.abs(run.drift["E"]).max() < 1e-8
    assert np.abs(run.drift["p_theta"]).max() > 0.5
    assert run.drift["p_theta"][0] == 0


def test_effects_that_keep_the_system_separable_keep_their_constants_among_the_former_ones() -> None:
    """With the magnetic field alone p_theta = m r² θ̇ + w r²/2 is constant; drag lets that very quantity drift."""
    run = Scene.load({
        "system": "kepler-planar", "effects": ["magnetic-field", "drag"], "parameters": {"c": "0"},
        "method": "integrate", "want": ["constants"], "times": [5],
    }).run()  # fmt: skip
    assert abs(run.drift["p_theta"][0]) < 1e-9
    assert run.trajectory is None


def test_a_collision_stops_the_integrator_with_a_word() -> None:
    with pytest.raises(NotConvergedError, match=r"integrator stopped at t = 1\.11"):
        Scene.load({
            "system": "kepler-planar", "method": "integrate", "want": ["trajectory"], "times": [2],
            "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0", "theta": "0"}},
        }).run()  # fmt: skip
