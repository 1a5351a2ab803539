"""An arithmetic that writes instructions: run a tape in it, and a program for the machine comes out.

Composite arithmetics (``jet``, ``running_error``, ``divided_differences``) write the programs of their components.
What is equal is written once, constants are worked out at once, signs are moved into sums; ``allocation.py`` makes a
``MachineCode`` of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from hjsolve.arithmetic.function_rules import ByOthers
from hjsolve.arithmetic.machine.allocation import Instruction, allocated
from hjsolve.arithmetic.machine.allocation import Value as Value
from hjsolve.arithmetic.machine.code import MachineCode as MachineCode
from hjsolve.arithmetic.machine.operations import OPERATIONS
from hjsolve.arithmetic.tape import UNARY

_PAIRED = {"sin": ("sincos", 0), "cos": ("sincos", 1), "sinh": ("sinhcosh", 0), "cosh": ("sinhcosh", 1)}


@dataclass(eq=False)
class InstructionWriter(ByOthers):
    """Arithmetic on values of the machine, which are integers.

    Attributes:
        instructions: what has been written.
    """

    instructions: list[Instruction] = field(default_factory=list)
    _count: int = 0
    _inputs: list[Value] = field(default_factory=list)
    _parameters: list[Value] = field(default_factory=list)
    _constants: dict[str, Value] = field(default_factory=dict)
    _numbers: dict[Value, float] = field(default_factory=dict)
    _known: dict[tuple[str, tuple[Value, ...]], tuple[Value, ...]] = field(default_factory=dict)
    _opposite: dict[Value, Value] = field(default_factory=dict)
    _sizes: set[Value] = field(default_factory=set)

    def _new(self) -> Value:
        self._count += 1
        return self._count - 1

    def input(self) -> Value:
        """Return a new input: a number of each lane. Inputs lie in the first rows, in the order of these calls."""
        self._inputs.append(self._new())
        return self._inputs[-1]

    def inputs(self, count: int) -> list[Value]:
        """Return several new inputs."""
        return [self.input() for _ in range(count)]

    def parameter(self) -> Value:
        """Return a new parameter: a number that is the same in all lanes, given when a program is made."""
        self._parameters.append(self._new())
        return self._parameters[-1]

    def parameters(self, count: int) -> list[Value]:
        """Return several new parameters."""
        return [self.parameter() for _ in range(count)]

    def number(self, x: float) -> Value:
        """Return a constant."""
        key = float(x).hex()
        if key not in self._constants:
            self._constants[key] = self._new()
            self._numbers[self._constants[key]] = float(x)
        return self._constants[key]

    def called(self, name: str, *operands: Value, results: int = 1) -> tuple[Value, ...]:
        """Write an operation as it is.

        Args:
            name: of the operation, one of ``OPERATIONS``.
            operands: values that it takes.
            results: how many it makes.

        Raises:
            ValueError: an operation that is not known, or has another number of operands or results.
        """
        operation = OPERATIONS.get(name)
        if operation is None or (operation.operands, operation.results) != (len(operands), results):
            raise ValueError(f"the machine has no operation {name} of {len(operands)} operands and {results} results")
        key = name, operands
        if key not in self._known:
            self._known[key] = tuple(self._new() for _ in range(results))
            self.instructions.append(Instruction(name, self._known[key], operands))
        return self._known[key]

    def _is(self, x: Value, number: float) -> bool:
        return self._numbers.get(x) == number

    def _both(self, x: Value, y: Value) -> tuple[float, float] | None:
        """Return the numbers that both values are."""
        return (self._numbers[x], self._numbers[y]) if x in self._numbers and y in self._numbers else None

    def rational(self, numerator: int, denominator: int) -> Value:
        """Return a fraction, rounded to a double."""
        return self.number(float(Fraction(numerator, denominator)))

    def pi(self) -> Value:
        return self.number(math.pi)

    def add(self, x: Value, y: Value) -> Value:
        """Write x + y; nothing for a term 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return y if self._is(x, 0.0) else x
        if both := self._both(x, y):
            return self.number(both[0] + both[1])
        if y in self._opposite:
            return self.sub(x, self._opposite[y])
        if x in self._opposite:
            return self.sub(y, self._opposite[x])
        return self.called("add", *sorted((x, y)))[0]

    def sub(self, x: Value, y: Value) -> Value:
        """Write x − y; nothing for y = 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return self._negative(y) if self._is(x, 0.0) else x
        if both := self._both(x, y):
            return self.number(both[0] - both[1])
        if y in self._opposite:
            return self.add(x, self._opposite[y])
        if x in self._opposite:
            return self._negative(self.add(self._opposite[x], y))
        return self.called("sub", x, y)[0]

    def mul(self, x: Value, y: Value) -> Value:
        """Write x·y; nothing for a factor 1 or 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return self.number(0.0)
        if both := self._both(x, y):
            return self.number(both[0] * both[1])
        for factor, other in ((x, y), (y, x)):
            if self._is(factor, 1.0):
                return other
            if self._is(factor, -1.0):
                return self._negative(other)
            if factor in self._opposite:
                return self._negative(self.mul(self._opposite[factor], other))
        return self.called("mul", *sorted((x, y)))[0]

    def div(self, x: Value, y: Value) -> Value:
        """Write x/y."""
        both = self._both(x, y)
        if both and both[1] != 0.0:
            return self.number(both[0] / both[1])
        if y in self._numbers and _has_exact_reciprocal(self._numbers[y]):
            return self.mul(x, self.number(1.0 / self._numbers[y]))
        if x in self._opposite:
            return self._negative(self.div(self._opposite[x], y))
        if y in self._opposite:
            return self._negative(self.div(x, self._opposite[y]))
        return self.called("div", x, y)[0]

    def _negative(self, x: Value) -> Value:
        if x in self._numbers:
            return self.number(-self._numbers[x])
        if x in self._opposite:
            return self._opposite[x]
        (made,) = self.called("neg", x)
        self._opposite[made] = x
        return made

    def _size(self, x: Value) -> Value:
        x = self._opposite.get(x, x)
        if x in self._numbers:
            return self.number(abs(self._numbers[x]))
        if x in self._sizes:
            return x
        (made,) = self.called("abs", x)
        self._sizes.add(made)
        return made

    def unary(self, name: str, x: Value) -> Value:
        """Write a function of one variable.

        Raises:
            ValueError: a function that is not known here.
        """
        if name not in UNARY:
            raise ValueError(name)
        if name == "neg":
            return self._negative(x)
        if name == "abs":
            return self._size(x)
        if name == "sqrt" and self._numbers.get(x, -1.0) >= 0.0:
            return self.number(math.sqrt(self._numbers[x]))
        if name in _PAIRED:
            operation, place = _PAIRED[name]
            return self.called(operation, x, results=2)[place]
        return self.called(name, x)[0]

    def code(self, results: Sequence[Value]) -> MachineCode:
        """Return the code that works out some values, and nothing else.

        Args:
            results: the values, in the order of the outputs.
        """
        return allocated(self.instructions, self._inputs, self._parameters, self._numbers, results)


def _has_exact_reciprocal(x: float) -> bool:
    """Powers of two, unless they are extreme."""
    return x != 0.0 and abs(math.frexp(x)[0]) == 0.5 and 2.0**-1000 < abs(x) < 2.0**1000
