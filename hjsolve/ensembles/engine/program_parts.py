"""What the programs of a view are made of: the integrands F r, r and kⱼ r with r = |dq/dχ|/√F at a node."""

from __future__ import annotations

from collections.abc import Sequence

from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.machine.pair_writer import PairOfValues
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.running_error import WithErrorBound

ARITHMETIC = frozenset({"add", "sub", "mul", "div", "power", "rational", "pi"})
"""Operations of tapes for which every arithmetic has rules."""

FINER = 2.0**-44
"""What 32 digits lose, over the running error in doubles: 2⁻¹⁰⁴ an operation (Hida, Li and Bailey 2001) over 2⁻⁵³ is
2⁻⁵¹; 2⁷ operations may add up, or terms of second order that a running error leaves out."""
PLACE = 2 * UNIT
"""Roundings of a place."""

MADE = 256
"""Programs that are remembered."""


class ParameterRows:
    """The parameters of a system as values of a program: in doubles, in pairs, and with bounds on their errors."""

    def __init__(self, writer: InstructionWriter, count: int):
        rows = writer.parameters(3 * count)
        self.plain = rows[:count]
        self.pairs = [PairOfValues(*both) for both in zip(rows[:count], rows[count : 2 * count], strict=True)]
        self.rounded = [WithErrorBound(*both) for both in zip(rows[:count], rows[2 * count :], strict=True)]


def filled(writer: InstructionWriter, root: Value, square: Value, weights: Sequence[Value]) -> MachineCode:
    """Return the code of F r, r, F and the kernels times r, r = root/√F.

    Args:
        root: |dq/dχ|.
        square: F.
        weights: the kernels.
    """
    r = writer.div(root, writer.unary("sqrt", square))
    return writer.code([writer.mul(square, r), r, square, *(writer.mul(w, r) for w in weights)])


def error_of(writer: InstructionWriter, value: WithErrorBound[Value]) -> Value:
    """Return the bound of a number as a value.

    Args:
        value: the number with its bound.
    """
    return writer.number(0.0) if value.error is None else value.error
