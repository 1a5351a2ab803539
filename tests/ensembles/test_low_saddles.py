"""Motions over a low saddle between two wells: p² nearly vanishes half way, and many nodes are needed there."""

from __future__ import annotations

import mpmath
import numpy as np

import hjsolve

WANT = ("actions", "frequencies")


def test_a_two_hundredth_of_the_depth_above_it_no_single_motion_is_needed() -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4 - 2*x**2 + x/7")
    x = np.linspace(-0.5, 0.5, 100_001)
    saddle = (x**4 - 2 * x**2 + x / 7).max()
    q = np.full(12, -1.0)
    p = np.sqrt(2 * (saddle + np.geomspace(5e-3, 1.0, 12) + 1 + 1 / 7))
    batch = hjsolve.ensemble(system, {"x": q}, {"x": p}, want=WANT, fallback=False)
    assert batch.summary()["ok"] == len(q)
    solution = hjsolve.solve(system)
    for k in range(0, len(q), 3):
        motion = solution.motion(q={"x": -1}, p={"x": float(p[k])}, digits=30)
        for quantity in WANT:
            missed = mpmath.mpf(float(getattr(batch, quantity)["x"][k])) - getattr(motion, quantity)["x"].value
            claim = batch.error[quantity]["x"][k]
            assert abs(missed) <= claim <= 1e-10 * abs(getattr(batch, quantity)["x"][k])
