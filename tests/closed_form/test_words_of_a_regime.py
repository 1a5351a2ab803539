"""A regime says between which roots of its radicand a coordinate moves, in words that a reader of the page knows."""

import pytest

import hjsolve


@pytest.mark.parametrize(
    ("potential", "start", "words"),
    [
        ("x**4/4 - x**2/2", {"q": {"x": "1.2"}, "velocity": {"x": 0}}, ""),
        ("x**3/3 - x", {"q": {"x": "1.1"}, "velocity": {"x": 0}}, "between the second and the third of the 3 real roots"),
        ("x**3/3 - x", {"q": {"x": "-3"}, "velocity": {"x": 0}}, "below the first root of the radicand"),
    ],
)
def test_the_place_among_the_roots_is_said(potential, start, words):
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", potential))
    said = hjsolve.closed_forms(solution.motion(**start))[0].regime.words
    assert words in said
    assert "of P" not in said
