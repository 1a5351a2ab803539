"""A velocity 1e-20 to 1e-200 of the others: p² at the start is what terms of size one leave, and is known exactly."""

import random

import mpmath
import pytest

import hjsolve
from tests.support import entries

GEODESICS = hjsolve.solve(hjsolve.catalog.load("oblate-geodesics"))
WGS84 = {"a": "6378137", "b": "6356752.314245"}
SYSTEMS = [
    "kepler-planar", "kepler-spherical", "spherical-pendulum", "pendulum", "central-power", "springs-planar",
    "smorodinsky-winternitz", "disk-on-slope", "helix-turning", "lagrange-top",
    "block-on-wedge", "morse",
]  # fmt: skip


def test_a_geodesic_along_the_equator_may_leave_it_slowly():
    """It was said to be forbidden: "p² = 0 < 0 there". Its small oscillation has the frequency λ̇ a/b."""
    motion = GEODESICS.motion(q={"beta": 0, "lambda_": 0}, velocity={"beta": "1e-48", "lambda_": 1}, parameters=WGS84)
    with mpmath.workdps(40):
        ratio = mpmath.mpf("6378137") / mpmath.mpf("6356752.314245")
        assert abs(motion.frequencies["beta"].value - ratio) <= motion.frequencies["beta"].error
        high = motion.turning_points["beta"][1]
        assert abs(high.value - mpmath.mpf("1e-48") / ratio) <= high.error


def test_a_geodesic_that_hardly_leaves_its_vertex_is_the_one_that_turns_there():
    """It took more than 20 s."""
    numbers = {
        speed: GEODESICS.motion(
            q={"beta": "-1.0457506914", "lambda_": 0}, velocity={"beta": speed, "lambda_": "-3e-7"}, parameters=WGS84
        ).frequencies["beta"]
        for speed in ("1e-48", "0")
    }
    assert abs(numbers["1e-48"].value - numbers["0"].value) <= numbers["0"].error


@pytest.mark.rotating(3)
@pytest.mark.parametrize("entry", [name for name in SYSTEMS if name in hjsolve.catalog.ids("separable")])
def test_a_motion_depends_continuously_on_a_velocity_that_vanishes(entry):
    draw = random.Random(entry)
    solution = entries.solution(entry)
    initial = hjsolve.catalog.describe(entry).initial
    name, what = draw.choice(solution.coordinates), "velocity" if initial.velocity else "p"
    rates = {**(initial.velocity or initial.p)}
    if all(mpmath.mpf(str(value)) == 0 for other, value in rates.items() if other != name):
        rates = dict.fromkeys(rates, "1/3")
    slow = f"{draw.choice(['', '-'])}1e-{draw.randint(20, 200)}"
    motions = [solution.motion(q=initial.q, **{what: {**rates, name: value}}) for value in (slow, 0)]
    assert motions[0].kinds == motions[1].kinds
    for key, one in motions[0].frequencies.items():
        other = motions[1].frequencies[key]
        assert abs(one.value - other.value) <= one.error + other.error
    one, other = (motion.at("0.7") for motion in motions)
    for key, value in one.q.items():
        assert abs(value - other.q[key]) <= one.error.q[key] + other.error.q[key] + 1e-19


def test_a_velocity_that_the_kinetic_energy_hides_is_forbidden_where_it_is():
    """Constants that allow no motion are still refused."""
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    with pytest.raises(hjsolve.ForbiddenMotionError):
        kepler.motion(q={"r": 1, "theta": 0}, constants={"E": "-1/2 - 1e-60", "p_theta": 1}, signs={"r": 1})
    assert (
        kepler.motion(q={"r": 1, "theta": 0}, constants={"E": "-1/2 + 1e-60", "p_theta": 1}, signs={"r": 1}).kinds["r"]
        == "libration"
    )


def test_the_sine_of_one_number_is_enclosed_in_many_digits():
    from hjsolve.arithmetic.floats import Multi
    from hjsolve.arithmetic.interval import Intervals

    field = Intervals(Multi(256))
    sine = field.unary("sin", field.point(Multi(256).convert(0.5)))
    with mpmath.workprec(300):
        assert sine.low <= mpmath.sin(0.5) <= sine.high
        assert sine.high - sine.low < mpmath.mpf(2) ** -240
