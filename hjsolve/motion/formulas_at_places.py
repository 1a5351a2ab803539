"""Formulas at many places, in doubles or many digits, and bounds on their errors.

Arrays have shape (m,): doubles, or objects that hold ``mpf`` (and plain nan where a motion has ended). The last inputs
of a tape are exact numbers, such as parameters, which are rounded to the digits of the arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, Multi, context_of
from hjsolve.arithmetic.number_types import Numbers, Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.lowering import lower
from hjsolve.motion.exact_numbers import to_bits

_BITS_OF_NOTHING = 128
"""Binary digits of an array in which every motion has ended, so that no number says how many there are."""


@lru_cache(maxsize=64)
def tape_of(formulas: tuple[sp.Expr, ...], arguments: tuple[sp.Symbol, ...]) -> Tape:
    """Return formulas as a tape, kept.

    Args:
        formulas: the outputs.
        arguments: symbols of the inputs, in order.
    """
    return lower(formulas, arguments)


def bits_in(array: Numbers) -> int:
    """Return in how many binary digits an array holds its elements; 53 of doubles."""
    if array.dtype != object:
        return 53
    return max((c.prec for x in array.flat if (c := context_of(x)) is not None), default=_BITS_OF_NOTHING)


def values_at(tape: Tape, arrays: Sequence[Numbers], fixed: Sequence[sp.Expr]) -> list[Numbers]:
    """Return formulas at m places; in many digits nan where an input is nan.

    Args:
        tape: the formulas.
        arrays: the first inputs, all doubles or all of many digits.
        fixed: the others, exact.
    """
    if arrays[0].dtype != object:
        # 64 bits, rounded once: what float() makes of a sympy number may be an evaluation at 15 digits
        numbers = [float(to_bits(x)(64)) for x in fixed]
        with np.errstate(all="ignore"):
            return [np.broadcast_to(x, arrays[0].shape) for x in tape.run(Float64(), [*arrays, *numbers])]
    field = Multi(bits_in(arrays[0]))
    exact, ended = [to_bits(x)(field.bits) for x in fixed], [field.context.nan] * len(tape.outputs)
    # ``Multi`` computes with single numbers: row by row, and not where the motion has ended
    rows = []
    for row in zip(*arrays, strict=True):
        inputs = [field.convert(x) for x in row]
        rows.append(ended if any(x != x for x in inputs) else tape.run(field, [*inputs, *exact]))
    return [np.array(column, dtype=object) for column in zip(*rows, strict=True)]


def bounded_at(
    tape: Tape, arrays: Sequence[Numbers], errors: Sequence[Reals | None], fixed: Sequence[sp.Expr], bits: int = 53
) -> list[tuple[Reals, Reals]]:
    """Return formulas at m places in doubles, and bounds on what errors of the inputs and all roundings do to them.

    Args:
        tape: the formulas.
        arrays: the first inputs.
        errors: bounds on their errors, to be taken to first order; None where they count as exact.
        fixed: the other inputs, exact.
        bits: binary digits in which the formulas were evaluated.
    """
    inputs = [WithErrorBound(np.asarray(x, dtype=float), e) for x, e in zip(arrays, errors, strict=True)]
    numbers = (np.asarray(float(to_bits(x)(64))) for x in fixed)
    # a parameter is rounded to the precision in which the formulas ran, here it is a double
    inputs += [WithErrorBound(x, 2.0**-bits * np.abs(x)) for x in numbers]
    shape = arrays[0].shape
    with np.errstate(all="ignore"):
        found = tape.run(RunningError(Float64(), bits=bits), inputs)
        rows = ((x.value, 0.0 if x.error is None else SECOND_ORDER * x.error) for x in found)
        return [(np.broadcast_to(value, shape), np.broadcast_to(error, shape)) for value, error in rows]
