"""Escapes that start next to the top of a barrier: p² has a near double zero on the way, but no narrow feature."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf, quad

import hjsolve

KINETIC = "(dot(r)**2 + r**2*dot(theta)**2)/2"


def elapsed(potential: sp.Expr, momentum: float, begin: float, slope: float, end: mpf) -> mpf:
    """The time from begin to end, ∫ dr/p, on stretches that double away from the start; 50 digits."""
    r = sp.Symbol("r")
    V = sp.lambdify(r, potential + sp.Rational(momentum) ** 2 / (2 * r**2), "mpmath")
    with mp.workdps(50):
        energy = mpf(slope) ** 2 / 2 + V(mpf(begin))
        edges = [mpf(begin)]
        step = mpf(10) ** -11
        while edges[-1] + step < end:
            edges.append(edges[-1] + step)
            step *= 2
        return +quad(lambda q: 1 / mp.sqrt(2 * (energy - V(q))), [*edges, end])


@pytest.mark.nightly
@pytest.mark.parametrize("slope", [1e-9, 1e-4])
def test_an_escape_from_next_to_a_barrier_keeps_its_time(slope: float) -> None:
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, KINETIC, "1/r**12 - 2/r**6")
    place, momentum, times = 2.002337088664273, 0.8572758582388131, [0.75, 23.125, 40.0]
    motion = hjsolve.solve(system).motion(q={"r": place, "theta": 0}, p={"r": slope, "theta": momentum})
    assert motion.kinds["r"] == "escape"
    few, many = motion.at(times), motion.at(np.resize(times, 2049))
    r = sp.Symbol("r")
    for k, t in enumerate(times):
        for state in (few, many):
            truth = elapsed(1 / r**12 - 2 / r**6, momentum, place, slope, mpf(float(state.q["r"][k])))
            missed = abs(truth - mpf(t)) * abs(mpf(float(state.velocity["r"][k])))
            assert missed <= state.error.q["r"][k] <= 2e-13
        assert abs(few.q["theta"][k] - many.q["theta"][k]) <= few.error.q["theta"][k] + many.error.q["theta"][k]
