"""A program over many orbits: rows of inputs in, rows of results out, in blocks whose registers stay in the cache."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hjsolve.arithmetic.machine.code import SLOTS, MachineCode
from hjsolve.arithmetic.machine.compiling import kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Reals

WIDTH = 128
"""Orbits of a block."""


@kernel
def rows(program: MachineProgram, given: Reals, made: Reals) -> None:
    """Run a program over n orbits.

    Args:
        program: with as many inputs as ``given`` has rows.
        given: the inputs, shape (inputs, n).
        made: filled with the results, shape (results, n).
    """
    registers, n = program.registers, given.shape[1]
    width = registers.shape[1]
    for first in range(0, n, width):
        count = min(width, n - first)
        slots = (count + SLOTS - 1) // SLOTS * SLOTS
        for k in range(given.shape[0]):
            for j in range(count):
                registers[k, j] = given[k, first + j]
            for j in range(count, slots):  # the last orbit again: lanes that nobody reads
                registers[k, j] = given[k, first + count - 1]
        run(program, slots)
        for k in range(made.shape[0]):
            row = program.outputs[k]
            for j in range(count):
                made[k, first + j] = registers[row, j]


def run_rows(code: MachineCode, parameters: Sequence[float], given: Reals) -> Reals:
    """Run a code over n orbits.

    Args:
        parameters: values of its parameters.
        given: its inputs, shape (inputs, n).

    Returns:
        The results, shape (results, n).
    """
    made, width = np.empty((len(code.outputs), given.shape[1])), SLOTS
    while width < min(given.shape[1], WIDTH):  # few widths: each has registers of its own
        width *= 2
    rows(code.program(width, parameters), np.ascontiguousarray(given, dtype=float), made)
    return made
