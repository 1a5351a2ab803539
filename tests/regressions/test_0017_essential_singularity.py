"""V = −exp(1/r): no power of the distance makes the way to r = 0 regular. That is told after a bounded amount of work."""

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.arithmetic.work_counter import counted
from hjsolve.errors import NotConvergedError

pytestmark = pytest.mark.rotating_file(4)

HARD = ["-exp(1/r)", "-exp(1/r**2)", "-exp(3/sqrt(r))/r", "-sinh(1/r)", "exp(1/r) - exp(2/r)", "-exp(exp(1/r))"]


@pytest.mark.nightly_cases("-1--exp(exp(1/r))-15", "-1-exp(1/r) - exp(2/r)-15")
@pytest.mark.parametrize(("potential", "digits"), [*((p, 15) for p in HARD), ("-exp(1/r)", 60)])
@pytest.mark.parametrize("speed", [-1])
def test_an_essential_singularity_at_the_end_of_a_domain_is_told_soon(potential, digits, speed):
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r"}, "dot(r)**2/2", potential))
    with counted() as work, pytest.raises(NotConvergedError, match=r"essential singularity.*a domain that ends before"):
        solution.motion(q={"r": 1}, velocity={"r": speed}, digits=digits)
    assert work.squares <= 40 * (digits + 40)


@pytest.mark.nightly_cases("-exp(-1/r)")
@pytest.mark.parametrize("potential", ["-1/r**3", "-1/r**40", "-1/r - 10**(-12)/r**8", "log(r)", "-exp(-1/r)"])
def test_powers_logarithms_and_what_is_flat_at_the_end_are_no_essential_singularities(potential):
    """The fall takes ∫ dr/p, by mpmath's quadrature in 40 digits."""
    motion = hjsolve.solve(hjsolve.System({"r": "0 < r"}, "dot(r)**2/2", potential)).motion(
        q={"r": 1}, velocity={"r": -1}
    )
    arrival = motion.boundary_times["r"]
    with mpmath.workdps(40):
        f = sp.lambdify("r", 1 + 2 * (sp.sympify(potential).subs("r", 1) - sp.sympify(potential)), "mpmath")
        true = mpmath.quad(lambda r: 1 / mpmath.sqrt(f(r)), [0, 1e-3, 1e-2, 0.1, 0.3, 1])
        assert abs(arrival.value - true) <= arrival.error
