"""The loops over lanes that the machine consists of.

``execute`` runs instructions and does the four operations, their fusions and what is as cheap itself. Every other
operation is a function of numbers in ``elementary`` or ``pairs``, put into a loop here and compiled apart; those
of pairs need no single number (``slots``). Registers lie row after row of ``width`` lanes; no register is both read and
filled by one instruction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np

from hjsolve.arithmetic.machine import elementary, pairs
from hjsolve.arithmetic.machine.intrinsics import call_operation, load, slots, store0, store1, store2, store3
from hjsolve.arithmetic.machine.operations import APART, LENGTH, NAMES, OPERATIONS, Instructions
from hjsolve.arithmetic.number_types import Integers, Reals

Loop: TypeAlias = Callable[[Instructions, Reals, int, int], None]
"""Runs an instruction over the first n lanes of registers of a width: (instruction, registers, width, n)."""
Addresses: TypeAlias = Mapping[int, Loop] | Integers
"""Of the operations that are compiled apart, by code; the operations themselves where plain Python runs."""

ADD, SUB, MUL, DIV, FMA, FMS, FNMA, ABSMUL, FMAABS, NEG, ABS, SQRT = (OPERATIONS[name].code for name in NAMES[:APART])


def execute(  # noqa: C901  a table of operations
    others: Addresses, code: Instructions, lines: int, r: Reals, width: int, n: int
) -> None:
    """Run instructions over the first n lanes.

    Args:
        others: addresses of the operations that are compiled apart, by code.
        code: the instructions, ``LENGTH`` integers each: an operation, the registers filled, the registers read.
        lines: how many instructions.
        r: the registers.
        width: lanes of a register.
        n: lanes to run, a multiple of eight.
    """
    for line in range(0, lines * LENGTH, LENGTH):
        operation, d = code[line], np.int64(code[line + 1]) * width
        a, b, c = np.int64(code[line + 5]) * width, np.int64(code[line + 6]) * width, np.int64(code[line + 7]) * width
        if operation == ADD:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) + load(r, b, j))
        elif operation == SUB:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) - load(r, b, j))
        elif operation == MUL:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) * load(r, b, j))
        elif operation == DIV:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) / load(r, b, j))
        elif operation == FMA:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) * load(r, b, j) + load(r, c, j))
        elif operation == FMS:
            for j in slots(n):
                store0(r, d, j, load(r, a, j) * load(r, b, j) - load(r, c, j))
        elif operation == FNMA:
            for j in slots(n):
                store0(r, d, j, load(r, c, j) - load(r, a, j) * load(r, b, j))
        elif operation == ABSMUL:
            for j in slots(n):
                store0(r, d, j, abs(load(r, a, j)) * load(r, b, j))
        elif operation == FMAABS:
            for j in slots(n):
                store0(r, d, j, abs(load(r, a, j)) * load(r, b, j) + load(r, c, j))
        elif operation == NEG:
            for j in slots(n):
                store0(r, d, j, -load(r, a, j))
        elif operation == ABS:
            for j in slots(n):
                store0(r, d, j, abs(load(r, a, j)))
        elif operation == SQRT:
            for j in slots(n):
                store0(r, d, j, np.sqrt(load(r, a, j)))
        else:
            call_operation(others, operation, code, line, r, width, n)


# ---------------------------------------------------------------------- loops by numbers of operands and of results
def _one_to_one(function: Callable[..., float], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, a = np.int64(line[1]) * width, np.int64(line[5]) * width
        for j in lanes(n):
            store0(r, d, j, function(load(r, a, j)))

    return loop


def _one_to_two(function: Callable[..., tuple[float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e, a = np.int64(line[1]) * width, np.int64(line[2]) * width, np.int64(line[5]) * width
        for j in lanes(n):
            u, v = function(load(r, a, j))
            store0(r, d, j, u)
            store1(r, e, j, v)

    return loop


def _two_to_one(function: Callable[..., float], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, a, b = np.int64(line[1]) * width, np.int64(line[5]) * width, np.int64(line[6]) * width
        for j in lanes(n):
            store0(r, d, j, function(load(r, a, j), load(r, b, j)))

    return loop


def _two_to_two(function: Callable[..., tuple[float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e = np.int64(line[1]) * width, np.int64(line[2]) * width
        a, b = np.int64(line[5]) * width, np.int64(line[6]) * width
        for j in lanes(n):
            u, v = function(load(r, a, j), load(r, b, j))
            store0(r, d, j, u)
            store1(r, e, j, v)

    return loop


def _two_to_three(function: Callable[..., tuple[float, float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e, f = np.int64(line[1]) * width, np.int64(line[2]) * width, np.int64(line[3]) * width
        a, b = np.int64(line[5]) * width, np.int64(line[6]) * width
        for j in lanes(n):
            u, v, w = function(load(r, a, j), load(r, b, j))
            store0(r, d, j, u)
            store1(r, e, j, v)
            store2(r, f, j, w)

    return loop


def _two_to_four(function: Callable[..., tuple[float, float, float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e = np.int64(line[1]) * width, np.int64(line[2]) * width
        f, g = np.int64(line[3]) * width, np.int64(line[4]) * width
        a, b = np.int64(line[5]) * width, np.int64(line[6]) * width
        for j in lanes(n):
            u, v, w, z = function(load(r, a, j), load(r, b, j))
            store0(r, d, j, u)
            store1(r, e, j, v)
            store2(r, f, j, w)
            store3(r, g, j, z)

    return loop


def _four_to_two(function: Callable[..., tuple[float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e = np.int64(line[1]) * width, np.int64(line[2]) * width
        a, b = np.int64(line[5]) * width, np.int64(line[6]) * width
        c, k = np.int64(line[7]) * width, np.int64(line[8]) * width
        for j in lanes(n):
            u, v = function(load(r, a, j), load(r, b, j), load(r, c, j), load(r, k, j))
            store0(r, d, j, u)
            store1(r, e, j, v)

    return loop


def _six_to_four(function: Callable[..., tuple[float, float, float, float]], lanes: Any) -> Loop:
    def loop(line: Instructions, r: Reals, width: int, n: int) -> None:
        d, e = np.int64(line[1]) * width, np.int64(line[2]) * width
        f, g = np.int64(line[3]) * width, np.int64(line[4]) * width
        a, b = np.int64(line[5]) * width, np.int64(line[6]) * width
        c, k = np.int64(line[7]) * width, np.int64(line[8]) * width
        s, t = np.int64(line[9]) * width, np.int64(line[10]) * width
        for j in lanes(n):
            at, step = ((load(r, a, j), load(r, b, j), load(r, c, j), load(r, k, j)), (load(r, s, j), load(r, t, j)))
            u, v, w, z = function(at[0], at[1], at[2], at[3], step[0], step[1])
            store0(r, d, j, u)
            store1(r, e, j, v)
            store2(r, f, j, w)
            store3(r, g, j, z)

    return loop


_SHAPES: dict[tuple[int, int], Callable[..., Loop]] = {
    (1, 1): _one_to_one, (1, 2): _one_to_two, (2, 1): _two_to_one, (2, 2): _two_to_two, (2, 3): _two_to_three,
    (2, 4): _two_to_four, (4, 2): _four_to_two, (6, 4): _six_to_four,
}  # fmt: skip


def loop_of(name: str) -> Loop:
    """Return the loop of an operation that is compiled apart.

    Args:
        name: of the operation. Its function has the same name, with an underscore where Python or numpy has one, too.

    Returns:
        A function of an instruction, the registers, their width, and how many lanes to run.
    """
    of_pairs = name.startswith("pair_")
    found = pairs.FUNCTIONS if of_pairs else vars(elementary)
    function = found[name] if name in found else found[f"{name}_"]
    loop = _SHAPES[OPERATIONS[name][1:]](function, slots if of_pairs else range)
    loop.__name__ = loop.__qualname__ = f"lanes_of_{name}"  # numba names machine code by it: no two may share a name
    return loop
