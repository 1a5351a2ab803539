"""A coordinate that oscillates next to one that escapes lost its whole turns in the other's equation."""

from __future__ import annotations

import numpy as np

import hjsolve


def test_oscillator_beside_free_fall_keeps_both_right_over_many_periods():
    system = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", "x**2/2 + y", {"m": 1})
    motion = hjsolve.solve(system).motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": 1})
    t = np.array([0.5, 4.0, 10.0, 40.0, -25.0])
    state = motion.at(t)
    assert np.all(np.abs(state.q["x"] - np.cos(t)) <= state.error.q["x"])
    assert np.all(np.abs(state.q["y"] - (t - t**2 / 2)) <= state.error.q["y"])
    assert np.all(state.error.q["y"] <= 1e-12 * (1 + t**2))
