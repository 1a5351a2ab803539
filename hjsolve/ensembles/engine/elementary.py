"""What the loops and programs of this room take of ``arithmetic.machine``, until they run on the machine themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from hjsolve.arithmetic.machine import elementary
from hjsolve.arithmetic.machine.elementary import sincos as sincos
from hjsolve.arithmetic.machine.intrinsics import as_bits as as_bits

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True, "_nrt": False}
"""Without numba's memory: nothing is allocated in compiled code."""
INLINED: dict[str, Any] = OPTIONS | {"forceinline": True}
"""For functions that bundles of arrays are passed to."""


@njit(**INLINED)
def sqrt_(x: float) -> float:
    """Return the square root.

    Args:
        x: a double; nan where it is negative.
    """
    return np.sqrt(x)


@njit(**INLINED)
def abs_(x: float) -> float:
    """Return |x|.

    Args:
        x: a double.
    """
    return abs(x)


_SHARED = (
    "exp_", "sincos", "sinhcosh", "tan_", "tanh_", "sech_", "log_", "asin_", "acos_", "atan_", "asinh_", "acosh_",
    "atanh_", "sincos_bends", "sinhcosh_bends", "exp_bend", "log_bend", "common_sign",
)  # fmt: skip
NAMES: dict[str, Any] = {"sqrt_": sqrt_, "abs_": abs_} | {name: getattr(elementary, name) for name in _SHARED}
"""What generated programs call."""
