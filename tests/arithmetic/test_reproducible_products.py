"""Products whose rows do not depend on their company."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.arithmetic.reproducible_products import stacked

RANDOM = np.random.default_rng(5)
LEFT, RIGHT = RANDOM.standard_normal((200, 3, 4)), RANDOM.standard_normal((200, 4, 2))


@pytest.mark.parametrize("count", [1, 2, 3, 7, 64])
def test_an_orbit_is_the_same_in_any_company(count: int) -> None:
    whole = stacked(LEFT, RIGHT)
    for first in (0, 1, 50, 200 - count):
        part = slice(first, first + count)
        assert np.array_equal(stacked(LEFT[part], RIGHT[part]), whole[part])


def test_products_are_right() -> None:
    assert stacked(LEFT, RIGHT) == pytest.approx(LEFT @ RIGHT, rel=1e-13, abs=1e-13)
