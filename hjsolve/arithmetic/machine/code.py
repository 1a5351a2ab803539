"""What a writer has written: instructions with rows given out, and programs made of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import local

import numpy as np

from hjsolve.arithmetic.machine.operations import APART, LENGTH, Instructions
from hjsolve.arithmetic.machine.run import MachineProgram, prepared, run
from hjsolve.arithmetic.number_types import Integers, Reals

SLOTS = 8
"""Widths are rounded up to a multiple of this."""

_KEPT = 128
"""Programs of a thread that stay, each of some 0.1 MB: to make one takes as long as several orbits."""


@dataclass(frozen=True)
class MachineCode:
    """Instructions for the machine; equal where they do the same in the same registers.

    Attributes:
        written: the instructions as the bytes of int32, ``LENGTH`` for each.
        once: those that depend on parameters and constants alone, run when a program is made.
        inputs, parameters: how many there are; their rows come first, in this order.
        constants: values of the rows after them.
        outputs: rows of the results; they may be those of an input or a constant.
        rows: how many rows there are.
    """

    written: bytes
    once: bytes
    inputs: int
    parameters: int
    constants: tuple[float, ...]
    outputs: tuple[int, ...]
    rows: int

    def __len__(self) -> int:
        """Return the number of instructions that are run over all lanes."""
        return len(self.instructions)

    @cached_property
    def instructions(self) -> Instructions:
        """The instructions, int32, shape (instructions, ``LENGTH``)."""
        return _instructions(self.written)

    @cached_property
    def _first(self) -> Instructions:
        return _instructions(self.once)

    @cached_property
    def _results(self) -> Integers:
        return np.array(self.outputs, dtype=np.int64)

    @cached_property
    def _apart(self) -> frozenset[int]:
        return frozenset(int(op) for part in (self.instructions, self._first) for op in part[:, 0] if op >= APART)

    def program(self, width: int, parameters: Sequence[float] = (), place: int = 0) -> MachineProgram:
        """Return the code with registers of this thread, the same ones at the next call.

        Args:
            width: lanes, rounded up to a multiple of eight.
            parameters: their values, as many as there are.
            place: another number gives other registers, for programs that are at work together.
        """
        # by identity, which keeps the code: its hash is that of all it holds
        made, key = _THREAD.made, (id(self), width, tuple(parameters), place)
        known = made.pop(key) if key in made else (self, self._program(width, parameters))
        made[key] = known  # the last one is the one that was asked for last
        if len(made) > _KEPT:
            del made[next(iter(made))]
        return known[1]

    def _program(self, width: int, parameters: Sequence[float]) -> MachineProgram:
        registers = aligned((self.rows, -(-width // SLOTS) * SLOTS))
        known = [*parameters, *self.constants]
        registers[self.inputs : self.inputs + self.parameters + len(self.constants)] = np.reshape(known, (-1, 1))
        entry, others = prepared(self._apart)
        if len(self._first):
            run(MachineProgram(entry, others, self._first, registers, self._results), registers.shape[1])
        return MachineProgram(entry, others, self.instructions, registers, self._results)


class _Programs(local):
    """The programs of a thread, in the order in which they were asked for."""

    def __init__(self) -> None:
        self.made: dict[tuple[int, int, tuple[float, ...], int], tuple[MachineCode, MachineProgram]] = {}


_THREAD = _Programs()


def aligned(shape: tuple[int, ...]) -> Reals:
    """Return an array of zeros that begins where a line of the cache does: else every second vector lies in two lines.

    Args:
        shape: of the array; where the last axis has whole vectors, all rows begin so.
    """
    size = math.prod(shape)
    room = np.zeros(size + SLOTS)
    first = -room.ctypes.data // room.itemsize % SLOTS
    return room[first : first + size].reshape(shape)


def _instructions(written: bytes) -> Instructions:
    return np.frombuffer(written, dtype=np.int32).reshape(-1, LENGTH).copy()
