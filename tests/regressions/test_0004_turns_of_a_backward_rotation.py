"""A pendulum that went round backwards was one whole turn off at its own start."""

import pytest

import hjsolve


@pytest.mark.parametrize("speed", ["9", "-9"])
@pytest.mark.parametrize("place", ["1", "-2", "3.1", "7"])
@pytest.mark.parametrize("digits", [15, 20])
def test_turns_are_counted_from_the_place_given(speed, place, digits):
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    motion = solution.motion(q={"theta": place}, velocity={"theta": speed}, digits=digits)
    assert motion.kinds["theta"] == "rotation"
    assert float(motion.at(0).unwrapped("theta")) == pytest.approx(float(place), rel=1e-14, abs=0)
    times = [k * motion.periods["theta"].value for k in (-2, 1, 5)]
    for k, t in zip((-2, 1, 5), times, strict=True):
        there = float(place) + (1 if float(speed) > 0 else -1) * 2 * 3.141592653589793 * k
        assert float(motion.at(t).unwrapped("theta")) == pytest.approx(there, rel=1e-13, abs=0)
