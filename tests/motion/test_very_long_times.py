"""Whole turns beyond 2**53, where doubles no longer hold every integer: exact, by every path to a state."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf, nint

import hjsolve

TIMES = (8.856613100308274e16, -8.089436646608065e17)
RATES = (1.7555963960837078, -2.551214779813705)


def rotor(angle: float, rate: float, digits: int) -> hjsolve.Motion:
    system = hjsolve.System({"theta": "angle"}, "dot(theta)**2/2", "0")
    return hjsolve.solve(system).motion(q={"theta": angle}, velocity={"theta": rate}, digits=digits)


@pytest.mark.parametrize("digits", [15, 30])
def test_turns_of_a_free_rotor_are_exact_up_to_1e17_turns(digits: int) -> None:
    for t, rate in zip(TIMES, RATES):
        motion = rotor(1.6231388389848034, rate, digits)
        with mp.workdps(60):
            truth = int(nint((mpf(1.6231388389848034) + mpf(rate) * mpf(t)) / (2 * mp.pi)))
        assert abs(truth) > 2**53
        assert int(motion.at(t).turns["theta"]) == truth
        if digits == 15:
            assert set(motion.at(np.full(2048, t)).turns["theta"].tolist()) == {truth}


@pytest.mark.parametrize("digits", [15, 30])
def test_turns_of_a_kepler_orbit_are_exact_at_1e18(digits: int) -> None:
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "-1/r")
    motion = hjsolve.solve(system).motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}, digits=digits)
    with mp.workdps(60):  # Kepler's equation from the pericentre, e = 0.44, a = 1/0.56
        mean = mpf(10) ** 18 * mpf("0.56") ** 1.5
        truth = int(nint(mean / (2 * mp.pi)))
        rest = mean - 2 * mp.pi * truth
        anomaly = mp.findroot(lambda E: E - mpf("0.44") * mp.sin(E) - rest, rest)
        angle = 2 * mp.atan(mp.sqrt(mpf("1.44") / mpf("0.56")) * mp.tan(anomaly / 2))
        state = motion.at("1e18")
        assert int(state.turns["theta"]) == truth > 2**53
        assert abs(mpf(state.q["theta"]) - angle) <= mpf(state.error.q["theta"]) <= 1e-12


def test_more_turns_than_are_counted_are_refused() -> None:
    motion = rotor(0.5, 1.5, 15)
    for t in (1e20, -1e200):
        for times in (t, np.full(2048, t)):
            with pytest.raises(hjsolve.InvalidInputError, match=r"more than 2\*\*60 turns"):
                motion.at(times)
