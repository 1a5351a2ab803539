"""Sines and cosines of a coordinate and of constants are put together again, and stay the same function."""

import random

import pytest
import sympy as sp
from mpmath import mp

from hjsolve.algebra.addition_theorems import rejoined

x, c, w = sp.symbols("x c w")
NARROW = [
    1 / (w**2 + 4 * sp.sin((x - c) / 2) ** 2),
    sp.exp(-(sp.sin(x / 2 - c) ** 2) / w**2),
    sp.sin(3 * x - c) / (2 + sp.cos(x + c)),
    1 / sp.cosh(sp.sin(x - c) / w) ** 2 + sp.cos(x),
    sp.Rational(1, 4) * sp.cos(x) + 3 / (1 + (2 * sp.cos((x - c) / 2) / w) ** 2),
]


@pytest.mark.parametrize("e", NARROW, ids=str)
def test_what_was_multiplied_out_is_short_again_and_the_same(e):
    rng = random.Random(str(e))
    numbers = {c: sp.Rational(rng.randint(1, 3000), 1000), w: sp.Rational(1, 1000)}
    spread = e.subs(numbers).replace(lambda part: isinstance(part, sp.sin | sp.cos), sp.expand_trig)
    spread = spread.replace(lambda part: part.is_Add, lambda part: sp.expand(part, deep=False, power_exp=False))
    joined = rejoined(spread, x)
    assert not any(angle.is_number for angle in joined.atoms(sp.sin, sp.cos) if not angle.has(x))
    with mp.workdps(60):
        for _ in range(5):
            place = mp.mpf(rng.uniform(-3, 3))
            one, other = (sp.lambdify(x, part, "mpmath")(place) for part in (joined, spread))
            assert abs(one - other) <= mp.mpf(10) ** -40 * abs(other)


def test_no_digits_are_lost_next_to_the_narrow_place():
    centre = sp.Rational(255984019413, 100000000000)
    denominator = rejoined(sp.expand(sp.expand_trig(sp.Rational(1, 10**14) + sp.sin(x / 2 - centre / 2) ** 2)), x)
    value = sp.lambdify(x, denominator, "math")(float(centre))
    assert value == pytest.approx(1e-14, rel=1e-12)


def test_a_formula_without_angles_of_constants_stays_as_it_stands():
    e = 2 * x + sp.sin(x) ** 2 * sp.cos(x) - 1 / (1 + sp.cos(x))
    assert rejoined(e, x) is e
