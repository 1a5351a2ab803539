"""When an angle reaches its axis while the radius runs away: the time of a straight line, which is known.

Two faults of the campaign of random motions: where a coordinate's equation holds another one that has a time of its
own, the time came in doubles whatever was asked; and its error was claimed from a slope beyond the end, where there is none.
Motions of users go on through the axis since; what lies beneath them ends there.
"""

import pytest
from mpmath import mp, mpf

import hjsolve
from tests.support.ending_at_poles import ending_at_poles

PLACE, SPEED = {"r": "0.556", "theta": "2.43"}, {"r": "0.124", "theta": "0.216"}


def straight():
    """x = r sin θ is zero there: t = −x/ẋ."""
    r, θ, ṙ, θ̇ = (mpf(text) for text in (*PLACE.values(), *SPEED.values()))
    return -r * mp.sin(θ) / (ṙ * mp.sin(θ) + r * θ̇ * mp.cos(θ))


@pytest.mark.parametrize("digits", [15, 25, 40])
def test_an_axis_is_reached_in_the_time_of_a_straight_line(digits):
    solution = hjsolve.solve(hjsolve.catalog.load("free-particle-spherical"))
    start = {"q": {**PLACE, "phi": "-1.57"}, "velocity": {**SPEED, "phi": 0}}
    found = ending_at_poles(solution, **start, digits=digits).boundary_times["theta"]
    with mp.workdps(60):
        truth = straight()
        # G₂ of r is near its limit where θ ends: its last digit is worth a thousand of the time
        assert abs(mpf(found.value) - truth) <= mpf(found.error) <= truth * mpf(10) ** (4 - digits)


@pytest.mark.nightly
def test_so_it_does_beside_an_oscillator():
    """Three coordinates: the time is sought along the motion."""
    system = hjsolve.System(
        {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle", "z": "line"},
        "(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2 + dot(z)**2)/2", "z**2/2",
    )  # fmt: skip
    start = {"q": {**PLACE, "phi": 0, "z": "0.3"}, "velocity": {**SPEED, "phi": 0, "z": "0.2"}}
    motion = ending_at_poles(hjsolve.solve(system), **start)
    assert motion.kinds["z"] == "libration"
    found = motion.boundary_times["theta"]
    with mp.workdps(40):
        truth = straight()
        assert abs(mpf(found.value) - truth) <= found.error <= 1e-11 * truth


def test_the_motion_goes_on_through_the_axis_on_its_straight_line():
    """x, z = r sin θ, r cos θ in the plane of the motion; x changes its sign where φ jumps by π."""
    solution = hjsolve.solve(hjsolve.catalog.load("free-particle-spherical"))
    motion = solution.motion(q={**PLACE, "phi": "-1.57"}, velocity={**SPEED, "phi": 0})
    with mp.workdps(40):
        r, θ, ṙ, θ̇ = (mpf(text) for text in (*PLACE.values(), *SPEED.values()))
        for t in (straight() - mpf("0.1"), straight() + mpf("0.1"), mpf(1000)):
            state = motion.at(t)
            x = r * mp.sin(θ) + t * (ṙ * mp.sin(θ) + r * θ̇ * mp.cos(θ))
            z = r * mp.cos(θ) + t * (ṙ * mp.cos(θ) - r * θ̇ * mp.sin(θ))
            assert state.status == "ok"
            assert abs(mpf(state.q["r"]) - mp.hypot(x, z)) <= state.error.q["r"] <= 1e-12 * mp.hypot(x, z)
            assert abs(mpf(state.q["theta"]) - mp.atan2(abs(x), z)) <= state.error.q["theta"] <= 1e-12
            assert abs(mp.cos(mpf(state.q["phi"]) - mpf("-1.57")) - mp.sign(x)) < 1e-14
