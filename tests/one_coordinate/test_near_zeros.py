"""Motions that just pass over maxima, or past a softened centre of force: roughness inside the motion, not at its ends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.one_coordinate.anomaly import barrier_anomaly, rotation_anomaly, two_barrier_anomaly
from hjsolve.one_coordinate.stretched_anomaly import stretched

DIGITS = 40


def over(potential: str, domain: str, x: str, v: str, digits: int = 15) -> Any:
    solution = hjsolve.solve(hjsolve.System({"x": domain}, "dot(x)**2/2", potential))
    return solution.motion(q={"x": x}, velocity={"x": v}, digits=digits)


def wheel_period(n: int, above: str) -> mpf:
    """One turn over cos nx with E = 1 + above: n equal maxima."""
    height = 2 + mpf(above)
    return 4 * mp.ellipk(2 / height) / mp.sqrt(2 * height)


@pytest.mark.parametrize(("barrier_tops", "above", "most"), [
    (2, "1e-2", 250), (2, "1e-6", 500), (2, "1e-12", 520), pytest.param(3, "1e-4", 700, marks=pytest.mark.nightly),
    pytest.param(3, "1e-8", 1050, marks=pytest.mark.nightly),
])  # fmt: skip
def test_a_wheel_over_equal_crests(barrier_tops: int, above: str, most: int) -> None:
    motion = over(f"cos({barrier_tops}*x)", "angle", f"pi/{2 * barrier_tops}", f"sqrt(2*(1 + {above}))")

    with mp.workdps(DIGITS):
        true = wheel_period(barrier_tops, above)
        assert abs(mpf(motion.periods["x"].value) / true - 1) <= 1e-15
        assert motion.nodes <= most
        # a whole number of n-th turns takes that share of the period
        for k in range(1, 2 * barrier_tops):
            state = motion.at(mp.nstr(true * k / barrier_tops, 30))
            place = mpf(state.q["x"]) - mp.pi / (2 * barrier_tops) - 2 * mp.pi * k / barrier_tops
            missed = abs(place - 2 * mp.pi * mp.nint(place / (2 * mp.pi)))
            assert missed <= mpf(state.error.q["x"]) <= 1e-12


def softened_period(width: str) -> mpf:
    """x″ = −∂/∂x(−1/√(x² + ε²)) from rest at 1: x = ε sinh w near the centre, x = 1 − y² near the turning point."""
    ε = mpf(width)
    depth = 1 / mp.sqrt(1 + ε**2)

    def speed(x: mpf, left: mpf) -> mpf:
        """√(2(V(1) − V(x))) without cancellation, left = 1 − x."""
        a, b = mp.sqrt(x * x + ε * ε), 1 / depth
        return mp.sqrt(2 * left * (1 + x) / (a * b * (a + b)))

    middle = mp.asinh(mpf("0.5") / ε)
    inner = mp.quad(lambda w: ε * mp.cosh(w) / speed(ε * mp.sinh(w), 1 - ε * mp.sinh(w)), mp.linspace(0, middle, 9))
    outer = mp.quad(lambda y: 2 * y / speed(1 - y * y, y * y), [0, mp.sqrt(mpf("0.5"))])
    return 4 * (inner + outer)


@pytest.mark.parametrize(("width", "most"), [("1e-1", 250), ("1e-3", 300), ("1e-6", 560)])  # proving fewer costs more
def test_a_softened_centre_of_force(width: str, most: int) -> None:
    motion = over(f"-1/sqrt(x**2 + {width}**2)", "line", "1", "0")

    with mp.workdps(DIGITS):
        assert abs(mpf(motion.periods["x"].value) / softened_period(width) - 1) <= 1e-15
    assert motion.nodes <= most


def bump_half_period(side: int, E: mpf) -> mpf:
    """Time from x = 0 to the turning point on one side of x⁴/4 − x²/2 + x³/9."""

    def square(x: mpf) -> mpf:
        return 2 * E + x * x - 2 * x**3 / 9 - x**4 / 2

    end, δ, half = mp.findroot(square, side * mpf("1.4")), mp.sqrt(2 * E), mpf("0.7")
    inner = mp.quad(
        lambda w: δ * mp.cosh(w) / mp.sqrt(square(side * δ * mp.sinh(w))), mp.linspace(0, mp.asinh(half / δ), 9)
    )
    a = [end**j / 2 for j in range(4)]  # square(x)/(end − x), the root divided out by hand
    rest = [mpf(1) / 2, a[1] + mpf(2) / 9, a[2] + 2 * end / 9 - 1, a[3] + 2 * end**2 / 9 - end]
    outer = mp.quad(lambda y: 2 / mp.sqrt(side * mp.polyval(rest, end - side * y * y)), [0, mp.sqrt(abs(end) - half)])
    return inner + outer


def test_a_narrow_bump_beside_the_middle() -> None:
    """Two wells of different depth, the barrier passed by one part in 10⁹."""
    motion = over("x**4/4 - x**2/2 + x**3/9", "line", "0", "sqrt(2e-9)")

    with mp.workdps(DIGITS):
        true = 2 * (bump_half_period(1, mpf("1e-9")) + bump_half_period(-1, mpf("1e-9")))
        assert abs(mpf(motion.periods["x"].value) / true - 1) <= 1e-15
    assert motion.nodes <= 300


def maps() -> list[tuple[str, Callable[[Multi], Any]]]:
    def number(arithmetic: Multi, text: str) -> Any:
        return arithmetic.context.mpf(text)

    def a_barrier_top(arithmetic: Multi) -> Any:
        return barrier_anomaly(*(number(arithmetic, x) for x in ("-1", "1.5", "0.3", "1e-7")), arithmetic)

    def two_barrier_tops(arithmetic: Multi) -> Any:
        numbers = (number(arithmetic, x) for x in ("0.3", "1e-6", "-2", "1e-3"))
        return two_barrier_anomaly(*numbers, -1, arithmetic)

    def three_barrier_tops(arithmetic: Multi) -> Any:
        wheel = rotation_anomaly(number(arithmetic, "0.3"), 1, number(arithmetic, "1e-3"), arithmetic)
        return stretched(wheel, [(0.4, 1e-4), (-1.7, 1e-2)])

    def barrier_tops_in_a_libration(arithmetic: Multi) -> Any:
        return stretched(a_barrier_top(arithmetic), [(0.8, 1e-3)])

    return [(f.__name__, f) for f in (a_barrier_top, two_barrier_tops, three_barrier_tops, barrier_tops_in_a_libration)]


@pytest.mark.parametrize("make", [m for _, m in maps()], ids=[n for n, _ in maps()])
def test_an_anomaly_agrees_with_itself(make: Callable[[Multi], Any]) -> None:
    """Its speed is the slope of its place, its phase inverts it, and doubles agree with many digits."""
    arithmetic = Multi(220)
    map_, context = make(arithmetic), arithmetic.context
    small = context.mpf(10) ** -22
    for text in ("0.1", "0.8", "1.57", "2.9", "-0.4", "-1.7", "-3.1"):
        χ = context.mpf(text)
        place = map_.place(χ, arithmetic)
        slope = (map_.place(χ + small, arithmetic).q - map_.place(χ - small, arithmetic).q) / (2 * small)
        assert abs(slope / (place.speed * place.rate) - 1) < 1e-20
        assert abs(place.stretch**2 * place.product / place.speed**2 - 1) < 1e-55
        back = map_.phase(place.q, 1 if place.speed * map_.direction > 0 else -1, arithmetic)
        assert abs(back - χ) * abs(place.rate) < 1e-50
        rounded = map_.in_doubles().place(np.array([float(text)]), Float64())
        there = map_.place(context.mpf(float(text)), arithmetic)
        assert abs(rounded.q[0] - there.q) < 4e-15
