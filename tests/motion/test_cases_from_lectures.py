"""Inputs of lectures and questions, with values of closed forms."""

from __future__ import annotations

from mpmath import mp

import hjsolve


def test_a_top_that_rises_to_the_vertical() -> None:
    """1/cos θ = 1 + sech t, the exercise's own answer; θ(3) = 0.428363646215506."""
    system = hjsolve.System(
        {"theta": "0 < theta < pi", "phi": "angle", "psi": "angle"},
        "(dot(theta)**2 + dot(phi)**2*sin(theta)**2)/2 + (dot(psi) + dot(phi)*cos(theta))**2/2", "cos(theta)",
    )  # fmt: skip
    speed = {"theta": 0, "phi": "2/sqrt(3)", "psi": "2/sqrt(3)"}
    motion = hjsolve.solve(system).motion(q={"theta": "pi/3", "phi": 0, "psi": 0}, velocity=speed)
    assert motion.kinds["theta"] == "asymptotic"
    times = [0.5, 3.0, 12.0]
    state = motion.at(times)
    with mp.workdps(40):
        for t, angle, error in zip(times, state.q["theta"], state.error.q["theta"], strict=True):
            assert abs(mp.mpf(angle) - mp.acos(1 / (1 + mp.sech(mp.mpf(t))))) <= error <= 1e-12
