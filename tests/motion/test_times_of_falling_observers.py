"""Schwarzschild's geometry in the time of falling observers (Painlevé 1921, Gullstrand 1922): against the usual time."""

from __future__ import annotations

import numpy as np

import hjsolve

TIMES = np.array([3.0, 50.0, 400.0])


def test_geodesics_in_the_time_of_falling_observers():
    """T = t + 2 √(2r) + 2 ln((√r − √2)/(√r + √2)) for M = 1, a gauge whose integral has no cases of the sign of M."""
    metric = "(-(1 - 2*M/r)*T'^2 + 2*sqrt(2*M/r)*T'*r' + r'^2 + r^2*phi'^2)/2"
    falling = hjsolve.System(
        {"T": "line", "r": "0 < r", "phi": "angle"}, metric, "0", {"M": 1}, signature="indefinite"
    )
    assert isinstance(hjsolve.separate(falling), hjsolve.Separation)
    state = hjsolve.solve(falling).motion(
        q={"T": 0, "r": 10, "phi": 0}, velocity={"T": "1.2", "r": 0, "phi": "0.04"}
    ).at(TIMES)
    usual = hjsolve.solve("schwarzschild").motion(
        q={"t": 0, "r": 10, "theta": "pi/2", "phi": 0}, velocity={"t": "1.2", "r": 0, "theta": 0, "phi": "0.04"}
    ).at(TIMES)

    def ahead(r):
        return 2 * np.sqrt(2 * r) + 2 * np.log((np.sqrt(r) - np.sqrt(2)) / (np.sqrt(r) + np.sqrt(2)))

    for name in ("r", "phi"):
        assert np.all(np.abs(state.q[name] - usual.q[name]) <= state.error.q[name] + usual.error.q[name])
    true = usual.q["t"] + ahead(usual.q["r"]) - ahead(10.0)
    rounding = 1e-14 * np.abs(true)
    assert np.all(np.abs(state.q["T"] - true) <= state.error.q["T"] + usual.error.q["t"] + rounding)
    assert np.all(state.error.q["T"] < 1e-10)
