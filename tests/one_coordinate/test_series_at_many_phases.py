"""Σ cₖ cos kχ and Σ cₖ sin kχ at many phases in fixed-point integers, against direct sums in 600 bits."""

from __future__ import annotations

import random

import numpy as np
import pytest

from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.precision import multiprecision

BITS = 140


@pytest.mark.parametrize("n", [1, 5, 60, 400])
def test_sums_keep_their_digits_next_to_0_and_pi(n: int) -> None:
    """The recurrence magnifies the rounding of cos χ there by the square of the number of terms."""
    context, exact, draw = multiprecision(BITS), multiprecision(600), random.Random(n)
    rows = [[context.mpf(draw.uniform(-1, 1)) * context.mpf(0.97) ** k / 3 for k in range(n)] for _ in range(2)]
    series = FourierSeries(context.mpf(0.25), *(np.array(row, dtype=object) for row in rows), n, 0.0)
    χ = np.array([context.mpf(x) for x in (0, 1e-12, 1e-3, 1, -2, 3.1415, 3.141592653589793)], dtype=object)
    for x, found in zip(map(exact.convert, χ), series.value(χ), strict=True):
        truth = exact.mpf(0.25) + exact.fsum(
            exact.convert(a) * exact.cos(k * x) + exact.convert(b) * exact.sin(k * x)
            for k, (a, b) in enumerate(zip(*rows, strict=True), start=1)
        )
        assert abs(exact.convert(found) - truth) < 8 * exact.mpf(2) ** -BITS
