"""An inverted quartic reaches infinity in a finite time; the panels never ended."""

from __future__ import annotations

import mpmath
import numpy as np

import hjsolve


def test_inverted_quartic_ends_and_says_so():
    system = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "-x**4/4", {"m": 1})
    motion = hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": 0})
    blow_up = float(mpmath.ellipk(0.5))  # ∫₁^∞ dx / √((x⁴ − 1)/2) = K(1/√2)
    state = motion.at(np.array([0.9 * blow_up, 1.1 * blow_up]))
    assert list(state.status) == ["ok", "reaches_boundary"]
    assert np.isnan(state.q["x"][1])
