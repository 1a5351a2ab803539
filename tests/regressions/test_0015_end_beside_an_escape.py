"""When an angle reaches its axis while the radius runs away: the time of a straight line, which is known.

Two faults of the campaign of random motions: where a coordinate's equation holds another one that has a time of its
own, the time came in doubles whatever was asked; and its error was claimed from a slope beyond the end, where there is none.
"""

import pytest
from mpmath import mp, mpf

import hjsolve

PLACE, SPEED = {"r": "0.556", "theta": "2.43"}, {"r": "0.124", "theta": "0.216"}


def straight():
    """x = r sin θ is zero there: t = −x/ẋ."""
    r, θ, ṙ, θ̇ = (mpf(text) for text in (*PLACE.values(), *SPEED.values()))
    return -r * mp.sin(θ) / (ṙ * mp.sin(θ) + r * θ̇ * mp.cos(θ))


@pytest.mark.parametrize("digits", [15, 25, 40])
def test_an_axis_is_reached_in_the_time_of_a_straight_line(digits):
    solution = hjsolve.solve(hjsolve.catalog.load("free-particle-spherical"))
    motion = solution.motion(q={**PLACE, "phi": "-1.57"}, velocity={**SPEED, "phi": 0}, digits=digits)
    found = motion.boundary_times["theta"]
    with mp.workdps(60):
        truth = straight()
        # G₂ of r is near its limit where θ ends: its last digit is worth a thousand of the time
        assert abs(mpf(found.value) - truth) <= mpf(found.error) <= truth * mpf(10) ** (4 - digits)


def test_so_it_does_beside_an_oscillator():
    """Three coordinates: the time is sought along the motion."""
    system = hjsolve.System(
        {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle", "z": "line"},
        "(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2 + dot(z)**2)/2", "z**2/2",
    )  # fmt: skip
    motion = hjsolve.solve(system).motion(q={**PLACE, "phi": 0, "z": "0.3"}, velocity={**SPEED, "phi": 0, "z": "0.2"})
    assert motion.kinds["z"] == "libration"
    found = motion.boundary_times["theta"]
    with mp.workdps(40):
        truth = straight()
        assert abs(mpf(found.value) - truth) <= found.error <= 1e-11 * truth
