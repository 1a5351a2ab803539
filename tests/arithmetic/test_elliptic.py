"""Jacobi's functions against mpmath's."""

import numpy as np
import pytest
from mpmath import mp

from hjsolve.arithmetic.elliptic import jacobi, quarter_period
from hjsolve.arithmetic.floats import Float64, Multi

COMPLEMENTS = ("0.9", "0.1", "1e-6", "3.8e-11", "1e-15")


@pytest.mark.parametrize("complement", COMPLEMENTS)
@pytest.mark.parametrize("bits", [53, 120, 194])
def test_they_are_those_of_mpmath_and_change_sign_at_two_k_even_when_it_is_rounded_up(
    complement: str, bits: int
) -> None:
    arithmetic = Multi(max(bits, 64))
    k2 = arithmetic.convert(mp.mpf(complement))
    quarter = quarter_period(k2, arithmetic)
    step = arithmetic.context.mpf(2) ** (4 - bits) * quarter
    arguments = [x * quarter / 7 for x in range(-14, 15)] + [side * (2 * quarter + step) for side in (-1, 1)]
    with mp.workprec(4 * bits + 200):
        K = mp.ellipk(1 - mp.mpf(k2))
        for u in arguments:
            if bits == 53:
                found = jacobi(np.array([float(u)]), float(k2), float(quarter), Float64())
                values, at, noise = [float(x[0]) for x in found], mp.mpf(float(u)), mp.mpf(2) ** -46
            else:
                values, at, noise = jacobi(u, k2, quarter, arithmetic), mp.mpf(u), mp.mpf(2) ** (12 - bits)
            expected = [mp.ellipfun(name, at, m=1 - mp.mpf(k2)) for name in ("sn", "cn", "dn")]
            for value, exact in zip(values, expected, strict=True):
                assert abs(value - mp.re(exact)) <= noise * K, (u, value, exact)


@pytest.mark.parametrize("complement", COMPLEMENTS)
def test_they_have_all_digits_where_the_argument_is_too_small_for_its_square(complement: str) -> None:
    k2, tiny = float(complement), np.array([5e-324, 1e-300, -1e-200, 1e-160, -3e-154, 1e-140, 1e-9])
    found = jacobi(tiny, k2, quarter_period(k2, Float64()), Float64())
    for name, values in zip(("sn", "cn", "dn"), found, strict=True):
        with mp.workprec(3000):
            exact = [float(mp.re(mp.ellipfun(name, mp.mpf(u), m=1 - mp.mpf(k2)))) for u in tiny.tolist()]
        np.testing.assert_allclose(values, exact, rtol=1e-15, atol=0)
