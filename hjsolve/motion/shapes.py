"""Values worked out in a row, told in the shape of the times that were asked for."""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import AtTimes, Integers, Numbers

Shape = tuple[int, ...] | None
"""Of the times; empty or None for one time."""


@overload
def shaped(values: Numbers, shape: Shape) -> AtTimes: ...
@overload
def shaped(values: Integers, shape: Shape) -> int | Integers: ...
@overload
def shaped(values: NDArray[np.str_], shape: Shape) -> str | NDArray[np.str_]: ...
def shaped(values: Numbers | Integers | NDArray[np.str_], shape: Shape) -> object:
    """Return values in the shape of the times; a plain number or word for one time.

    Args:
        values: shape (m,).
        shape: of the times; empty or None for one time.
    """
    if shape:
        return values.reshape(shape)
    return values[0].item() if hasattr(values[0], "item") else values[0]
