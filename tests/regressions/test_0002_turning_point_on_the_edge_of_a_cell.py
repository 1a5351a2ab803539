"""A pendulum let go at θ = 1/2 with g = 1.62, asked to 30 digits, never came back.

The other turning point, −1/2, lay exactly on the edge of a search cell. There p² is zero and its computed sign is rounding, so
that the bisection ran to the wrong end and the precision was raised for ever.
"""

import mpmath

import hjsolve


def test_a_turning_point_on_the_edge_of_a_cell_is_found() -> None:
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    motion = solution.motion(q={"theta": "0.5"}, velocity={"theta": 0}, parameters={"g": "1.62"}, digits=30)
    with mpmath.workdps(50):
        expected = 4 * mpmath.sqrt(1 / mpmath.mpf("1.62")) * mpmath.ellipk(mpmath.sin(mpmath.mpf(1) / 4) ** 2)
        assert abs(motion.periods["theta"].value - expected) <= motion.periods["theta"].error
        assert motion.periods["theta"].error < expected * mpmath.mpf(10) ** -29
