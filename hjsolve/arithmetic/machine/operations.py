"""The operations of the machine: name, code, number of operands and of results.

A pair of doubles takes two registers, so that ``pair_add`` has four operands.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Instructions = NDArray[np.int32]
"""Instructions, one after the other or in rows of ``LENGTH``."""


class MachineOperation(NamedTuple):
    """An operation: its code, and how many registers it reads and fills."""

    code: int
    operands: int
    results: int


_TABLE = (
    ("add", 2, 1), ("sub", 2, 1), ("mul", 2, 1), ("div", 2, 1),
    ("fma", 3, 1),     # a·b + c
    ("fms", 3, 1),     # a·b − c
    ("fnma", 3, 1),    # c − a·b
    ("absmul", 2, 1),  # |a|·b
    ("fmaabs", 3, 1),  # |a|·b + c
    ("neg", 1, 1), ("abs", 1, 1), ("sqrt", 1, 1),
    # what comes now is compiled apart, operation by operation, when a program first needs it
    ("min", 2, 1), ("max", 2, 1),   # nan where one of them is
    ("signed", 2, 1),       # b where a > 0, else −b
    ("common_sign", 2, 1),  # the sign of a, nan where that of b is another
    ("exp", 1, 1), ("log", 1, 1), ("sincos", 1, 2), ("sinhcosh", 1, 2), ("tan", 1, 1), ("tanh", 1, 1), ("sech", 1, 1),
    ("asin", 1, 1), ("acos", 1, 1), ("atan", 1, 1), ("asinh", 1, 1), ("acosh", 1, 1), ("atanh", 1, 1),
    ("sincos_bends", 2, 4), ("sinhcosh_bends", 2, 4), ("exp_bend", 2, 2), ("log_bend", 2, 3),
    ("pair_add", 4, 2), ("pair_sub", 4, 2), ("pair_mul", 4, 2), ("pair_div", 4, 2), ("pair_abs", 2, 2),
    ("pair_sqrt", 2, 2), ("pair_exp", 2, 2), ("pair_log", 2, 2), ("pair_sincos", 2, 4), ("pair_sinhcosh", 2, 4),
    ("pair_sincos_near", 6, 4), ("pair_sinhcosh_near", 6, 4), ("pair_tan", 2, 2), ("pair_tanh", 2, 2),
    ("pair_sech", 2, 2), ("pair_asin", 2, 2), ("pair_acos", 2, 2), ("pair_atan", 2, 2), ("pair_asinh", 2, 2),
    ("pair_acosh", 2, 2), ("pair_atanh", 2, 2),
)  # fmt: skip

OPERATIONS: dict[str, MachineOperation] = {
    name: MachineOperation(code, *counts) for code, (name, *counts) in enumerate(_TABLE)
}
"""All of them by name."""

NAMES = tuple(OPERATIONS)
"""Their names, in the order of the codes."""

APART = OPERATIONS["min"].code
"""The first code of those that are compiled apart; the machine does the operations before it itself."""

RESULTS, OPERANDS = 4, 6
"""Most registers that one operation fills, and reads."""

LENGTH = 1 + RESULTS + OPERANDS
"""Integers of an instruction: the code, the registers filled, the registers read."""
