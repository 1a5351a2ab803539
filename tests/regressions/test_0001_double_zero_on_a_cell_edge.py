"""A double zero of p² exactly on an edge of the search (here at distance 1) was stepped over: a separatrix became a libration."""

from __future__ import annotations

import numpy as np

import hjsolve


def test_double_well_at_the_height_of_its_barrier_is_asymptotic():
    well = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "x**4/4 - x**2/2", {"m": 1})
    motion = hjsolve.solve(well).motion(q={"x": 1}, velocity={"x": "sqrt(1/2)"})
    assert motion.kinds == {"x": "asymptotic"}
    assert "x" not in motion.periods
    t = np.array([0.5, 3.0, 20.0])
    start = np.arccosh(np.sqrt(2.0))  # x(t) = √2 / cosh(t − t₁), t₁ = arcosh √2
    np.testing.assert_allclose(motion.at(t).q["x"], np.sqrt(2) / np.cosh(t - start), rtol=2e-14, atol=0)
