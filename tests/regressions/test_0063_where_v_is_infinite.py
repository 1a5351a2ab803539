"""A start where V is infinite, in coordinates that were found, was a ValueError of zip: the map to them rounds it away."""

from __future__ import annotations

import pytest

import hjsolve


@pytest.mark.parametrize(
    ("potential", "x", "y"),
    [
        ("x**2 + y**2 + 1/(x - y)**2", "1/2", "1/2"),
        ("x**2 + y**2 + 1/(x - y)**2", "-0.967", "-0.967"),
        ("x**2 + y**2 + 1/(x - y)**2 - 1/(x - y)**4", "1/2", "1/2"),
        ("log(x**2 + y**2)", 0, 0),
    ],
)
def test_a_start_where_v_is_infinite_is_refused(potential: str, x: object, y: object) -> None:
    plane = hjsolve.System({"x": "line", "y": "line"}, "dot(x)**2/2 + dot(y)**2/2", potential)
    solution = hjsolve.solve(plane, coordinates="find")
    with pytest.raises(hjsolve.InvalidInputError, match="infinite there"):
        solution.motion(q={"x": x, "y": y}, velocity={"x": 1, "y": 0})
