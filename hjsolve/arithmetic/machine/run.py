"""The machine: runs the instructions of a program, one after the other, over many lanes of doubles.

A lane is an orbit, or a node of one; a register is a row of lanes. An operation takes 0.2 to 0.3 ns a lane and 3 to
8 ns besides, so that 64 lanes and more are worth while, up to a few hundred, whose registers stay in the cache.

Kernels call the machine through its address: it is compiled once, and no kernel with a copy of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from threading import RLock
from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.compiling import PLAIN, available
from hjsolve.arithmetic.machine.loops import execute, loop_of
from hjsolve.arithmetic.machine.operations import APART, NAMES, Instructions
from hjsolve.arithmetic.number_types import Integers, Reals

_ADDRESSES: Integers = np.zeros(len(NAMES), dtype=np.int64)
"""Of the operations that are compiled apart, by code, as far as programs needed them; 0 of the others."""
_ONE_AT_A_TIME = RLock()


class MachineProgram(NamedTuple):
    """A code with registers to run in; made by ``MachineCode.program``, one for each thread, never for another process.

    Attributes:
        entry: address of the machine; 0 where it runs as plain Python.
        others: addresses of the operations that are compiled apart.
        code: instructions, int32, shape (instructions, ``LENGTH``): an operation, registers filled, registers read.
        registers: shape (rows, width): the inputs first, then parameters, constants, and what is worked out.
        outputs: the rows that hold the results.
    """

    entry: int
    others: Integers
    code: Instructions
    registers: Reals
    outputs: Integers


def prepared(apart: frozenset[int]) -> tuple[int, Integers]:
    """Compile what a program needs, or read the machine code from disk, where that has not been done in this process.

    Args:
        apart: codes of operations that are compiled apart.

    Returns:
        The address of the machine, and those of all operations, by code; zeros where plain Python runs.
    """
    if not available():
        return 0, _ADDRESSES
    with _ONE_AT_A_TIME:
        for code in apart:
            _ADDRESSES[code] = _ADDRESSES[code] or _compiled(code).address
        return _compiled(None).address, _ADDRESSES


@cache
def _compiled(code: int | None) -> Any:
    """Return an operation, or the machine (None), as a function with the interface of C.

    Some tenths of a second, once.
    """
    from numba.core import types
    from numba.core.ccallback import CFunc

    from hjsolve.arithmetic.machine.kept_code import keep

    loop = execute if code is None else loop_of(NAMES[code])
    codes, numbers, count = types.CPointer(types.int32), types.CPointer(types.float64), types.int64
    first = (types.CPointer(types.int64), codes, count) if code is None else (codes,)
    exactly = code is not None and NAMES[code].startswith("pair_")
    options = PLAIN if exactly else PLAIN | {"fastmath": {"contract"}}
    made = CFunc(loop, ((*first, numbers, count, count), types.void), {}, dict(options))
    keep(made, loop)
    made.compile()
    return made


if available():
    import ctypes

    from numba.extending import overload

    from hjsolve.arithmetic.machine.intrinsics import call_machine

    _WORD = ctypes.c_int64
    _MACHINE = ctypes.CFUNCTYPE(None, *[_WORD] * 6)  # addresses are words, too

    def run(program: MachineProgram, n: int) -> None:
        """Run a program over its first n lanes.

        Args:
            program: inputs lie in its first registers.
            n: lanes, a multiple of eight.
        """
        code, registers = program.code, program.registers
        _MACHINE(program.entry)(
            program.others.ctypes.data, code.ctypes.data, code.shape[0],
            registers.ctypes.data, registers.shape[1], n,
        )  # fmt: skip

    _OPTIONS: Any = PLAIN | {"forceinline": True, "no_cfunc_wrapper": True}

    @overload(run, jit_options=_OPTIONS)
    def _run_from_kernels(program: MachineProgram, n: int) -> Callable[[MachineProgram, int], None]:  # noqa: ARG001
        def called(program: MachineProgram, n: int) -> None:
            code, registers = program.code, program.registers
            call_machine(
                program.entry, program.others.ctypes.data, code.ctypes.data, code.shape[0],
                registers.ctypes.data, registers.shape[1], n,
            )  # fmt: skip

        return called

else:
    _LOOPS = {code: loop_of(name) for code, name in enumerate(NAMES) if code >= APART}

    def run(program: MachineProgram, n: int) -> None:
        """Run a program over its first n lanes.

        Args:
            program: inputs lie in its first registers.
            n: lanes, a multiple of eight.
        """
        code, registers = program.code, program.registers
        with np.errstate(all="ignore"):
            execute(_LOOPS, code.reshape(-1), len(code), registers.reshape(-1), registers.shape[1], n)
