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
