"""Proved numbers of motions past steep steps and narrow dips took 45 s and more, or did not come.

Exponents were multiplied out ((x − 1.9)² became three terms of 10⁶ that cancel) and tanh was sinh/cosh, so that nothing
was known of them over a ball.
"""

import pytest
from mpmath import mp

import hjsolve
from tests.support.random_features import Draw, Feature, truth

pytest.importorskip("flint")

CASES = [
    ("x**2/2 + tanh(200*x)/2", 1, 0.5, Feature("step", "0", "0.5", "0.005", 20)),
    ("x**2/2 - exp(-10**6*(x - 1.9)**2)", 1, 2, Feature("Gaussian", "1.9", "-1", "0.001", 7)),
    ("1 - cos(x) - 0.0838/cosh((x - 0.71888)/4.3e-06)**2", 0.5, 0.9, Feature("sech2", "0.71888", "1", "4.3e-6", 20)),
]


@pytest.mark.parametrize(("potential", "place", "speed", "feature"), CASES, ids=[case[0] for case in CASES])
def test_a_proved_frequency_holds_the_truth(potential, place, speed, feature):
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", potential))
    motion = solution.motion(q={"x": str(place)}, velocity={"x": str(speed)}, certified=True)
    drawn = Draw(
        0, "own", {"x": "line"}, "dot(x)**2/2", potential, {"x": place}, {"x": speed}, (feature,), f"2*({potential})"
    )
    with mp.workdps(40):
        exact = truth(drawn).frequency
        found = motion.frequencies["x"]
        assert found.certified
        assert abs(found.value - exact) <= found.error + exact * mp.mpf(10) ** -17
        assert found.error < 1e-14
