"""Three coupled librations, one 1e5 times smaller than its neighbours: its phase ripples by 350 radians next to theirs.

What the errors of their phases do to it was counted as if that ripple had the slope 1: the claim for φ was 0.87 of its error
(motion 173 of the campaign with seed 21).
"""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from tests.support import entries

START = {"r": 1.6219417232110496, "theta": 2.663424334449126, "phi": -0.004154770313343992}
SPEED = {"r": -0.10745538849679942, "theta": 0.22424718337412372, "phi": 6.221979849528468e-06}


@pytest.mark.nightly
def test_claims_hold_beside_ripples_of_many_turns() -> None:
    solution = entries.solution("spherical-staeckel")
    times = np.array([5.707681187103338, *np.linspace(0.3, 9.7, 40)])
    ours = solution.motion(q=START, velocity=SPEED).at(times)
    with mp.workdps(40):
        theirs = solution.motion(q=START, velocity=SPEED, digits=25).at(times)
        for name in START:
            for k in range(len(times)):
                assert abs(mpf(ours.q[name][k]) - theirs.q[name][k]) <= ours.error.q[name][k]
                assert abs(mpf(ours.p[name][k]) - theirs.p[name][k]) <= ours.error.p[name][k]
