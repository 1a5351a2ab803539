"""A well at x = 10⁶ with its depth a parameter was multiplied out: its terms cancelled, and the motion was refused after 30 s."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)

WELL = "((x - {far})**2/2 + 101/500/(1 + ((x - {far} - 11/10)/0.00285)**2))"


def far_motion(far: str, depth: str, mass: str, speed: str) -> hjsolve.Motion:
    well = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "U*" + WELL.format(far=far), {"m": mass, "U": depth})
    start = str(int(far) * 100 + 23)
    return hjsolve.solve(well).motion(q={"x": f"{start}/100"}, velocity={"x": speed})


def period_by_quadrature(depth: str, mass: str, speed: str) -> mpmath.mpf:
    """4 ∫ dy/ẏ of the well moved to 0, in 40 digits."""
    mp = mpmath.mp.clone()
    mp.dps = 40
    m, U, v, centre, width = (mp.mpf(text) for text in (mass, depth, speed, "1.1", "0.00285"))

    def height(y: mpmath.mpf) -> mpmath.mpf:
        return y * y / 2 + mp.mpf("0.202") / (1 + ((y - centre) / width) ** 2)

    energy = m * v * v / 2 / U + height(mp.mpf("0.23"))
    low, high = (mp.findroot(lambda y: energy - height(y), guess) for guess in (-1.4, 1.4))
    middle, half = (low + high) / 2, (high - low) / 2
    marks = [centre + k * width for k in (-90, -30, -9, -3, -1, 0, 1, 3, 9, 25)]
    places = [-mp.pi / 2, *(mp.asin((y - middle) / half) for y in marks), mp.pi / 2]

    def slowness(χ: mpmath.mpf) -> mpmath.mpf:
        y = middle + half * mp.sin(χ)
        return half * mp.cos(χ) / mp.sqrt(2 * (energy - height(y)))

    mp.dps = 60
    low, high = (mp.findroot(lambda y: energy - height(y), end) for end in (low, high))
    middle, half = (low + high) / 2, (high - low) / 2
    return 2 * mp.quad(slowness, places) * mp.sqrt(m / U)


@pytest.mark.parametrize(
    ("far", "depth", "mass", "speed"),
    [
        ("1000000", "1/10", "10", "0.1378"),
        ("1000000", "1e26", "1e26", "1.378"),
        ("-3000000", "4e-20", "1e-20", "2.756"),
    ],
)
def test_a_well_far_from_zero(far: str, depth: str, mass: str, speed: str) -> None:
    claimed = far_motion(far, depth, mass, speed).periods["x"]
    true = period_by_quadrature("0.1" if depth == "1/10" else depth, mass, speed)
    assert abs(mpmath.mpf(claimed.value) - true) <= claimed.error
    assert claimed.error < 1e-12 * claimed.value


def test_a_common_factor_does_not_multiply_squares_out() -> None:
    well = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "U*((x - 1000000)**2/2 + cos(x))", {"m": 1, "U": 1})
    assert "(x - 1000000)**2" in str(hjsolve.solve(well).momentum_squared["x"])
