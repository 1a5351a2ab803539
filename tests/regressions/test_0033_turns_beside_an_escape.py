"""Above 15 digits an angle that a libration carries next to an escape was off by whole growths, with a claim of 1e-28.

The refined phases held their whole turns already, and these were added once more, in doubles.
"""

from __future__ import annotations

from typing import Any

import pytest
from mpmath import mp

from hjsolve.mechanics.system import System
from hjsolve.solution.quadratures import Solution, solve


@pytest.fixture(scope="module")
def solution() -> Solution:
    """An isotropic oscillator in cylinder coordinates that falls along its axis."""
    coordinates = {"r": "0 < r", "phi": "angle", "z": "line"}
    return solve(System(coordinates, "(dot(r)**2 + r**2*dot(phi)**2 + dot(z)**2)/2", "r**2/2 + 9*z"))


@pytest.mark.parametrize("digits", [15, 30])
@pytest.mark.parametrize("t", ["5", "10", "1000.5", "-77.25"])
def test_the_angle_is_that_of_the_ellipse(solution: Solution, digits: int, t: str) -> None:
    motion = solution.motion(
        q={"r": 1, "phi": "0.1", "z": 1}, velocity={"r": "0.2", "phi": "1.3", "z": "0.1"}, digits=digits
    )
    state = motion.at(t)
    with mp.workdps(60):
        time, begin = mp.mpf(t), mp.mpf("0.1")
        across, along = mp.mpf("1.3"), mp.mpf("0.2")  # of the velocity, on and along the radius at the start

        def place(radial: Any, turning: Any) -> Any:
            return (radial * mp.cos(time) + turning * mp.sin(time)) * mp.expj(begin)

        z = place(1, mp.mpc(along, across))
        assert abs(mp.mpf(state.q["phi"]) - mp.arg(z)) <= state.error.q["phi"] < (1e-11 if digits == 15 else 1e-24)
        assert abs(mp.mpf(state.q["r"]) - abs(z)) <= state.error.q["r"]
        whole = mp.floor(time / (2 * mp.pi))
        assert abs(state.turns["phi"] - whole) <= 1
