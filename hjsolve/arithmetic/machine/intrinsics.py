"""What kernels need of the processor that Python has no word for, with stand-ins for plain Python.

Registers of the machine are read and filled by ``load`` and ``store0`` … ``store3``. They promise LLVM that what an
operation fills is not what it reads, nor what its other results fill: so loops become vector instructions without
comparing addresses first. ``lanes`` are what a loop runs over whose body needs no single number: in plain Python all
lanes are one step, over numpy's arrays.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from fractions import Fraction
from math import isfinite
from typing import Any

import numpy as np

from hjsolve.arithmetic.machine.compiling import available

if available():
    from llvmlite import ir
    from numba import extending, types

    intrinsic: Any = extending.intrinsic
    _FLOAT, _LONG, _INT = ir.DoubleType(), ir.IntType(64), ir.IntType(32)
    _FLOATS, _INTS, _LONGS = _FLOAT.as_pointer(), _INT.as_pointer(), _LONG.as_pointer()
    _MACHINE = ir.FunctionType(ir.VoidType(), [_LONGS, _INTS, _LONG, _FLOATS, _LONG, _LONG])
    _OPERATION = ir.FunctionType(ir.VoidType(), [_INTS, _FLOATS, _LONG, _LONG])
    _READ, _SCOPES = 4, 5

    def _scopes(builder: Any, chosen: list[int]) -> Any:
        """Metadata: a list of scopes, 0 … 3 of the registers filled, 4 of those read."""
        module = builder.module
        domain = module.add_metadata(["hjsolve"])
        return module.add_metadata([module.add_metadata([f"hjsolve {k}", domain]) for k in chosen])

    def _marked(builder: Any, instruction: Any, scope: int) -> Any:
        instruction.set_metadata("alias.scope", _scopes(builder, [scope]))
        instruction.set_metadata("noalias", _scopes(builder, [k for k in range(_SCOPES) if k != scope]))
        return instruction

    def _storing(scope: int) -> Any:
        @intrinsic
        def store(_context: Any, registers: Any, _row: Any, _lane: Any, _value: Any) -> Any:
            def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                registers, row, lane, value = arguments
                _marked(builder, builder.store(value, builder.gep(registers, [builder.add(row, lane)])), scope)
                return context.get_dummy_value()

            return types.void(registers, types.int64, types.int64, types.float64), generate

        return store

    store0, store1, store2, store3 = map(_storing, range(4))
    lanes: Any = range

    @intrinsic
    def load(_context: Any, registers: Any, _row: Any, _lane: Any) -> Any:
        """Return a number of a register that an operation reads."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            registers, row, lane = arguments
            return _marked(builder, builder.load(builder.gep(registers, [builder.add(row, lane)])), _READ)

        return types.float64(registers, types.int64, types.int64), generate

    @intrinsic
    def as_float(_context: Any, _integer: Any) -> Any:
        """Return the double with these bits."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], _FLOAT)

        return types.float64(types.int64), generate

    @intrinsic
    def as_bits(_context: Any, _number: Any) -> Any:
        """Return the bits of a double as an integer."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], _LONG)

        return types.int64(types.float64), generate

    @intrinsic
    def whole(_context: Any, _number: Any) -> Any:
        """Return a double that is whole as an integer; any integer where it is none."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.fptosi(arguments[0], _LONG)

        return types.int64(types.float64), generate

    @intrinsic
    def fma(_context: Any, _a: Any, _b: Any, _c: Any) -> Any:
        """Return a·b + c, rounded once."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.fma(*arguments)

        return types.float64(types.float64, types.float64, types.float64), generate

    @intrinsic
    def call_machine(
        _context: Any, _entry: Any, _others: Any, _code: Any, _lines: Any, _registers: Any, _width: Any, _n: Any
    ) -> Any:
        """Call the machine by addresses: its own, and where those of the operations, the code and the registers lie."""

        def generate(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            entry, others, code, lines, registers, width, n = given
            places = ((others, _LONGS), (code, _INTS), (registers, _FLOATS))
            others, code, registers = (builder.inttoptr(place, kind) for place, kind in places)
            machine = builder.inttoptr(entry, _MACHINE.as_pointer())
            builder.call(machine, [others, code, lines, registers, width, n])
            return context.get_dummy_value()

        return types.void(*[types.int64] * 7), generate

    @intrinsic
    def call_operation(
        _context: Any, others: Any, _operation: Any, code: Any, _line: Any, registers: Any, _width: Any, _n: Any
    ) -> Any:
        """Call an operation that is compiled apart."""

        def generate(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            others, operation, code, line, registers, width, n = given
            address = builder.load(builder.gep(others, [operation]))
            entry = builder.inttoptr(address, _OPERATION.as_pointer())
            builder.call(entry, [builder.gep(code, [line]), registers, width, n])
            return context.get_dummy_value()

        long = types.int64
        return types.void(others, long, code, long, registers, long, long), generate

else:

    def lanes(n: int) -> tuple[slice, ...]:
        """Return the first n lanes as one."""
        return (slice(n),)

    def load(registers: Any, row: int, lane: int | slice) -> Any:
        """Return a number of a register, or those of all lanes."""
        return registers[row:][lane]

    def store0(registers: Any, row: int, lane: int | slice, value: Any) -> None:
        """Fill a number of a register, or those of all lanes."""
        registers[row:][lane] = value

    store1 = store2 = store3 = store0

    def as_float(bits: int) -> float:
        """Return the double with these bits."""
        return np.float64(struct.unpack("<d", struct.pack("<q", int(bits)))[0])

    def as_bits(x: float) -> int:
        """Return the bits of a double as an integer."""
        bits: int = struct.unpack("<q", struct.pack("<d", float(x)))[0]
        return bits

    def whole(x: float) -> int:
        """Return a double that is whole as an integer; 0 where it is not finite."""
        return int(x) if isfinite(x) else 0

    def fma(a: float, b: float, c: float) -> float:
        """Return a·b + c, rounded once."""
        if not (isfinite(a) and isfinite(b) and isfinite(c)):
            return a * b + c
        try:
            total = Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c))
            return np.float64(total) if total else a * b + c
        except OverflowError:
            return a * b + c

    def call_operation(
        others: dict[int, Callable[..., None]], operation: int, code: Any, line: int, registers: Any, width: int, n: int
    ) -> None:
        """Call an operation that is compiled apart."""
        others[operation](code[line:], registers, width, n)
