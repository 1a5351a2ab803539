"""Tops and spherical pendulums in hard states, against elliptic functions at 90 digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from tests.support.hard_turning import AMPLE, Turning, turning

CASES = turning()


def compare(case: Turning, digits: int = 15) -> tuple[float, float, Any, Any]:
    """Largest error of an angle, of a period, frequency or action (relative), claims ÷ truth, and the motion."""
    motion = case.motion(digits)
    state = motion.at(np.array(case.times, dtype=object))
    with mp.workdps(max(AMPLE, 2 * digits + 40)):
        truth, worst, ratios = case.truth(), mpf(0), []
        for m, text in enumerate(case.times):
            for name, value in case.place(truth, mpf(text)).items():
                given, claim = state.q[name][m], mpf(state.error.q[name][m])
                missed = mpf(given) - value
                if name in state.turns:
                    whole = int(mp.nint(missed / (2 * mp.pi)))
                    assert -whole == state.turns[name][m], f"{name}({text}): turns"
                    missed -= 2 * mp.pi * whole
                assert abs(missed) <= claim, f"{name}({text}) claims {claim}, misses by {missed}"
                worst = max(worst, abs(missed))
                ratios.append(float(claim / max(abs(missed), max(1, abs(mpf(given))) * mpf(10) ** -digits / 9)))
        azimuth, spin = truth.mean()
        numbers = [
            (motion.periods["theta"], truth.period),
            (motion.frequencies["phi" if case.axial == "0" else "psi"], azimuth),
            (motion.actions["theta"], truth.action()),
            *([] if case.axial == "0" else [(motion.frequencies["phi"], spin)]),
        ]
        off = mpf(0)
        for found, value in numbers:
            assert abs(mpf(found.value) - value) <= found.error
            off = max(off, abs(mpf(found.value) / value - 1))
    return float(worst), float(off), np.array(ratios), motion


@pytest.mark.rotating(4)
@pytest.mark.nightly_cases(
    "nearly sleeping top, critical, tilted by 1e-6", "nearly sleeping top, unstable, tilted by 1/1000",
    "nearly sleeping top, unstable, tilted by 1e-6", "spherical pendulum, dphi/dt = 1e-12 at theta = 1",
    "spherical pendulum, dphi/dt = 1e-3 at theta = 1", "spherical pendulum, dphi/dt = 1e-6 at theta = 1",
    "spherical pendulum, nearly upright and nearly through both poles", "top with waves",
)  # fmt: skip
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_angles_periods_rates_and_actions_are_right_and_the_claims_hold(case: Turning) -> None:
    worst, off, ratios, motion = compare(case)

    assert motion.kinds["theta"] == "libration"
    assert worst <= 2e-13
    assert off <= 1e-15
    assert motion.nodes <= 300  # as many as are proved to be enough
    assert np.median(ratios) <= 150


@pytest.mark.nightly
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_thirty_digits(case: Turning) -> None:
    worst, off, _, _ = compare(case, 30)

    assert worst <= 1e-27
    assert off <= 1e-30
