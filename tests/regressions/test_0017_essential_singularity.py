"""V = −exp(1/r): no power of the distance makes the way to r = 0 regular. That is told after a bounded amount of work."""

import pytest

import hjsolve
from hjsolve.errors import NotConvergedError
from hjsolve.numeric.counting import counted


@pytest.mark.parametrize(("potential", "digits"), [("-exp(1/r)", 15), ("-exp(1/r**2)", 15), ("-exp(1/r)", 60)])
@pytest.mark.parametrize("speed", [-1])
def test_an_essential_singularity_at_the_end_of_a_domain_is_told_soon(potential, digits, speed):
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r"}, "dot(r)**2/2", potential))
    with counted() as work, pytest.raises(NotConvergedError, match="stays rough"):
        solution.motion(q={"r": 1}, velocity={"r": speed}, digits=digits)
    assert work.squares <= 40 * (digits + 40)
