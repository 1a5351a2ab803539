"""What random potentials found (tests/numeric/test_any_potential.py)."""

import pytest

import hjsolve
from hjsolve.errors import NotConvergedError


def line(potential):
    return hjsolve.System(coordinates={"x": "line"}, kinetic="dot(x)**2/2", potential=potential)


def test_angles_with_a_large_ratio_are_functions_of_their_own():
    """115 and 71 times the common unit were multiplied out, and that was too much work: one coordinate, undecided."""
    verdict = hjsolve.separate(line("-3*sin(1.15*x - 2.84) + 0.63*sin(0.71*x + 0.27)"))
    assert isinstance(verdict, hjsolve.Separation)
    system = hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="(dot(x)**2 + dot(y)**2)/2", potential="sin(115*x + 71*y)"
    )
    assert isinstance(hjsolve.separate(system), hjsolve.Obstruction)


@pytest.mark.nightly
def test_a_search_that_interval_arithmetic_cannot_end_says_so():
    """cosh(3x) e^(−x²) over wide cells is [0, ∞]; the search divided cells without end."""
    solution = hjsolve.solve(line("0.9*cosh(3.18*x)*exp(-x**2) + 5.33*x - 1.65/(x**2 + 0.96)"))
    with pytest.raises(NotConvergedError, match="could not be decided"):
        solution.motion(q={"x": "-0.31"}, velocity={"x": "3.4"})
