"""Products whose rows do not depend on their company."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.arithmetic.reproducible_products import rowwise, stacked

RANDOM = np.random.default_rng(5)
TABLE = RANDOM.standard_normal((64, 63))
ROWS = RANDOM.standard_normal((3, 200, 64))


@pytest.mark.parametrize("count", [1, 2, 3, 7, 64])
def test_a_row_is_the_same_in_any_company(count: int) -> None:
    whole = rowwise(ROWS, TABLE)
    for first in (0, 1, 50, 200 - count):
        part = slice(first, first + count)
        assert np.array_equal(rowwise(ROWS[:, part], TABLE), whole[:, part])
        assert np.array_equal(rowwise(ROWS[0, part], TABLE), whole[0, part])


def test_products_are_right() -> None:
    assert rowwise(ROWS, TABLE) == pytest.approx(ROWS @ TABLE, rel=1e-12, abs=1e-12)
    left, right = RANDOM.standard_normal((5, 3, 4)), RANDOM.standard_normal((5, 4, 2))
    assert stacked(left, right) == pytest.approx(left @ right, rel=1e-13, abs=1e-13)
