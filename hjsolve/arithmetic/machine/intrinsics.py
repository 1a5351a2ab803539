"""What kernels need of the processor that Python has no word for, with stand-ins for plain Python.

Registers of the machine are read and filled by ``load`` and ``store0`` … ``store3``. They promise LLVM that what an
operation fills is not what it reads, nor what its other results fill: so loops become vector instructions without
comparing addresses first. ``slots`` are what a loop runs over whose body needs no single number: in plain Python all
lanes are one step, over numpy's arrays.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from hjsolve.arithmetic.machine.compiling import available
from hjsolve.arithmetic.machine.operations import Instructions
from hjsolve.arithmetic.number_types import Elementwise, Reals

if TYPE_CHECKING:
    from llvmlite.ir import Value
    from numba.core.base import BaseContext
    from numba.core.typing.context import BaseContext as TypingContext
    from numba.core.typing.templates import Signature

    Values: TypeAlias = Sequence[Value]
    """The arguments of a call, as LLVM has them."""
    Typed: TypeAlias = tuple[Signature, Callable[..., Value]]
    """What numba wants of an intrinsic: the types of a call, and what writes it."""

if available():
    from llvmlite import ir
    from numba import extending, types

    intrinsic: Any = extending.intrinsic
    """Kernels call what it makes with numbers, not with their types: neither is known to a type checker."""
    _FLOAT, _LONG, _INT = ir.DoubleType(), ir.IntType(64), ir.IntType(32)
    _FLOATS, _INTS, _LONGS = _FLOAT.as_pointer(), _INT.as_pointer(), _LONG.as_pointer()
    _MACHINE = ir.FunctionType(ir.VoidType(), [_LONGS, _INTS, _LONG, _FLOATS, _LONG, _LONG])
    _OPERATION = ir.FunctionType(ir.VoidType(), [_INTS, _FLOATS, _LONG, _LONG])
    _READ, _SCOPES = 4, 5

    def _scopes(builder: ir.IRBuilder, chosen: list[int]) -> ir.MDValue:
        """Metadata: a list of scopes, 0 … 3 of the registers filled, 4 of those read."""
        module = builder.module
        domain = module.add_metadata(["hjsolve"])
        return module.add_metadata([module.add_metadata([f"hjsolve {k}", domain]) for k in chosen])

    def _marked(builder: ir.IRBuilder, instruction: ir.Instruction, scope: int) -> ir.Instruction:
        instruction.set_metadata("alias.scope", _scopes(builder, [scope]))
        instruction.set_metadata("noalias", _scopes(builder, [k for k in range(_SCOPES) if k != scope]))
        return instruction

    def _made_by(instruction: Callable[..., ir.Value], result: types.Type, *arguments: types.Type) -> Typed:
        """Return the types of an intrinsic that is one instruction, and what writes it."""

        def generate(_context: BaseContext, builder: ir.IRBuilder, _signature: Signature, given: Values) -> ir.Value:
            return instruction(builder, *given)

        return result(*arguments), generate

    def _storing(scope: int) -> Callable[[Reals, int | np.int64, int | slice, Elementwise], None]:
        @intrinsic
        def store(
            _context: TypingContext, registers: types.Array, _row: types.Type, _slot: types.Type, _value: types.Type
        ) -> Typed:
            def generate(context: BaseContext, builder: ir.IRBuilder, _signature: Signature, given: Values) -> ir.Value:
                registers, row, slot, value = given
                _marked(builder, builder.store(value, builder.gep(registers, [builder.add(row, slot)])), scope)
                return context.get_dummy_value()

            return types.void(registers, types.int64, types.int64, types.float64), generate

        return store

    store0, store1, store2, store3 = map(_storing, range(4))
    slots: Any = range

    @intrinsic
    def load(_context: TypingContext, registers: types.Array, _row: types.Type, _slot: types.Type) -> Typed:
        """Return a number of a register that an operation reads."""

        def read(builder: ir.IRBuilder, registers: ir.Value, row: ir.Value, slot: ir.Value) -> ir.Value:
            return _marked(builder, builder.load(builder.gep(registers, [builder.add(row, slot)])), _READ)

        return _made_by(read, types.float64, registers, types.int64, types.int64)

    @intrinsic
    def as_float(_context: TypingContext, _integer: types.Type) -> Typed:
        """Return the double with these bits."""
        return _made_by(lambda builder, bits: builder.bitcast(bits, _FLOAT), types.float64, types.int64)

    @intrinsic
    def as_bits(_context: TypingContext, _number: types.Type) -> Typed:
        """Return the bits of a double as an integer."""
        return _made_by(lambda builder, x: builder.bitcast(x, _LONG), types.int64, types.float64)

    @intrinsic
    def whole(_context: TypingContext, _number: types.Type) -> Typed:
        """Return a double that is whole as an integer; any integer where it is none."""
        return _made_by(lambda builder, x: builder.fptosi(x, _LONG), types.int64, types.float64)

    @intrinsic
    def fma(_context: TypingContext, _a: types.Type, _b: types.Type, _c: types.Type) -> Typed:
        """Return a·b + c, rounded once."""
        return _made_by(lambda builder, *given: builder.fma(*given), types.float64, *[types.float64] * 3)

    @intrinsic
    def call_machine(
        _context: TypingContext, _entry: types.Type, _others: types.Type, _code: types.Type, _lines: types.Type,
        _registers: types.Type, _width: types.Type, _n: types.Type,
    ) -> Typed:  # fmt: skip
        """Call the machine by addresses: its own, and where those of the operations, the code and the registers lie."""

        def generate(context: BaseContext, builder: ir.IRBuilder, _signature: Signature, given: Values) -> ir.Value:
            entry, others, code, lines, registers, width, n = given
            places = ((others, _LONGS), (code, _INTS), (registers, _FLOATS))
            others, code, registers = (builder.inttoptr(place, kind) for place, kind in places)
            machine = builder.inttoptr(entry, _MACHINE.as_pointer())
            builder.call(machine, [others, code, lines, registers, width, n])
            return context.get_dummy_value()

        return types.void(*[types.int64] * 7), generate

    @intrinsic
    def call_operation(
        _context: TypingContext, others: types.Type, _operation: types.Type, code: types.Type, _line: types.Type,
        registers: types.Type, _width: types.Type, _n: types.Type,
    ) -> Typed:  # fmt: skip
        """Call an operation that is compiled apart."""

        def generate(context: BaseContext, builder: ir.IRBuilder, _signature: Signature, given: Values) -> ir.Value:
            others, operation, code, line, registers, width, n = given
            address = builder.load(builder.gep(others, [operation]))
            entry = builder.inttoptr(address, _OPERATION.as_pointer())
            builder.call(entry, [builder.gep(code, [line]), registers, width, n])
            return context.get_dummy_value()

        long = types.int64
        return types.void(others, long, code, long, registers, long, long), generate

else:

    def slots(n: int) -> tuple[slice, ...]:
        """Return the first n lanes as one."""
        return (slice(n),)

    def load(registers: Reals, row: int | np.int64, slot: int | slice) -> Elementwise:
        """Return a number of a register, or those of all lanes."""
        return registers[row:][slot]

    def store0(registers: Reals, row: int | np.int64, slot: int | slice, value: Elementwise) -> None:
        """Fill a number of a register, or those of all lanes."""
        registers[row:][slot] = value

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
        others: Mapping[int, Callable[..., None]], operation: int, code: Instructions, line: int, registers: Reals,
        width: int, n: int,
    ) -> None:  # fmt: skip
        """Call an operation that is compiled apart."""
        others[operation](code[line:], registers, width, n)
