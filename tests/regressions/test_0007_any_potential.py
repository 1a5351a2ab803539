"""What random potentials found (tests/motion/test_any_potential.py)."""

import pytest
from mpmath import mp

import hjsolve


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
def test_a_search_over_unbounded_enclosures_ends_with_the_motion():
    """cosh(3x) e^(−x²) over wide cells is [0, ∞]; the search divided cells without end, then gave up."""
    solution = hjsolve.solve(line("0.9*cosh(3.18*x)*exp(-x**2) + 5.33*x - 1.65/(x**2 + 0.96)"))
    motion = solution.motion(q={"x": "-0.31"}, velocity={"x": "3.4"})
    with mp.workdps(30):
        number = mp.mpf

        def potential(x):
            hill = number("0.9") * mp.cosh(number("3.18") * x) * mp.exp(-x * x)
            return hill + number("5.33") * x - number("1.65") / (x * x + number("0.96"))

        def square(x):
            return number("3.4") ** 2 + 2 * (potential(number("-0.31")) - potential(x))

        assert all(square(number(k) / 100) > 0 for k in range(-2000, 57))
        turning = mp.findroot(square, number("0.57"))
        low, high = motion.turning_points["x"]
        assert low is None
        assert abs(number(high.value) - turning) <= high.error <= 1e-15
        assert motion.kinds == {"x": "escape"}
        x = number(motion.at(1).q["x"])
        # x = b − y²: up to the turning point, and down
        time = sum(
            mp.quad(lambda y: 2 * y / mp.sqrt(square(turning - y * y)), mp.linspace(0, mp.sqrt(turning - end), 5))
            for end in (number("-0.31"), x)
        )
        assert abs(time - 1) * mp.sqrt(square(x)) <= motion.at(1).error.q["x"] <= 1e-12
