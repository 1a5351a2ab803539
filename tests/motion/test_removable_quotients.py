"""V that is 0/0 at an end of the domain but has a limit there: the motion comes to the end in its true time."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mpmath import mp, mpf

from hjsolve import System, solve

CASES: dict[str, Callable[[mpf], mpf]] = {
    "-(1-exp(-r))/r": lambda r: mp.expm1(-r) / r,
    "-1/r+exp(-r)/r": lambda r: mp.expm1(-r) / r,
    "-log(1+r)/r": lambda r: -mp.log1p(r) / r,
    "-tanh(r)/r": lambda r: -mp.tanh(r) / r,
    "-atan(r)/r": lambda r: -mp.atan(r) / r,
    "-2*(1-exp(-r)-r*exp(-r))/r**2": lambda r: -2 * mp.gammainc(2, 0, r) / r**2,
}


@pytest.mark.parametrize("potential", CASES)
def test_a_radial_fall_comes_to_the_centre_in_its_true_time(potential: str) -> None:
    system = System({"r": "0 < r", "phi": "angle"}, "(dot(r)**2+r**2*dot(phi)**2)/2", potential)
    motion = solve(system).motion(q={"r": 1, "phi": 0}, velocity={"r": "-1/10", "phi": 0})
    V, time = CASES[potential], motion.boundary_times["r"]
    with mp.workdps(30):
        truth = mp.quad(lambda r: 1 / mp.sqrt(mpf(1) / 100 + 2 * (V(mpf(1)) - V(r))), [0, 0.25, 0.5, 0.75, 1])
        assert abs(time.value - truth) <= time.error <= 1e-14
