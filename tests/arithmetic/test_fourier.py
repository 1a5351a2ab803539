"""The fast transform in integers against its definition, summed term by term in more digits."""

from __future__ import annotations

import random

import pytest
from mpmath import mp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.fourier import smooth, waves

BITS = 300


@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("nodes", [2, 12, 13, 30, 45, 64, 77, 125])
def test_coefficients_are_those_of_the_definition_to_the_last_bits(nodes, even):
    context, rng = multiprecision(BITS), random.Random(nodes)
    values = [context.mpf(rng.getrandbits(BITS) - (1 << (BITS - 1))) * 10**40 for _ in range(nodes)]
    cosines, sines = waves(values, even=even, bits=BITS)
    assert len(cosines) == (nodes - 1 if even else (nodes + 1) // 2 - 1)
    assert len(sines) == (0 if even else len(cosines))
    with mp.workprec(BITS + 80):
        step = mp.pi / nodes * (1 if even else 2)
        largest = max(map(abs, values))
        for parts, wave in ((cosines, mp.cos), (sines, mp.sin)):
            for k, found in enumerate(parts, 1):
                truth = 2 * mp.fsum(v * wave(k * step * (2 * m + 1) / 2) for m, v in enumerate(values)) / nodes
                assert abs(found - truth) <= largest * mp.mpf(2) ** (1 - BITS)


def test_numbers_of_nodes_have_no_prime_factor_above_thirteen():
    assert [smooth(n) for n in (1, 7, 17, 19, 31, 97, 440, 1537)] == [1, 7, 18, 20, 32, 98, 440, 1540]
