"""A formula as a flat list of operations, run in any arithmetic.

A ``Tape`` is what is left of a sympy expression when only numbers matter: it is made once by
``hjsolve.lowering`` and then run by one loop in whatever arithmetic is asked — numpy floats, many
digits, intervals, jets. An arithmetic is an object with a method for each operation code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, Protocol

from hjsolve.arithmetic.number_types import N
from hjsolve.errors import InvalidInputError

_POLE = (
    "a formula divides by zero at a place that the motion comes to: give the coordinate a domain that ends there, "
    'such as "0 < x"'
)
UNARY = ("neg", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan",
         "sinh", "cosh", "tanh", "sech", "asinh", "acosh", "atanh", "abs")  # fmt: skip
"""Operation codes with one argument."""


class Arithmetic(Protocol[N]):
    """Where a tape is run: constants, the four operations, powers and the elementary functions.

    Every arithmetic has these methods, on numbers x, y of its own kind: ``rational`` and ``pi`` make constants. What
    their arguments are is said here once.
    """

    def rational(self, numerator: int, denominator: int) -> N:
        """Return a fraction as a number of this arithmetic.

        Args:
            numerator, denominator: whole numbers, the second not zero.
        """
        ...

    def pi(self) -> N:
        """Return π."""
        ...

    def add(self, x: N, y: N, /) -> N:
        """Return x + y."""
        ...

    def sub(self, x: N, y: N, /) -> N:
        """Return x − y."""
        ...

    def mul(self, x: N, y: N, /) -> N:
        """Return x·y."""
        ...

    def div(self, x: N, y: N, /) -> N:
        """Return x/y."""
        ...

    def power(self, x: N, n: int) -> N:
        """Return xⁿ.

        Args:
            n: the exponent, a whole number of either sign.
        """
        ...

    def unary(self, name: str, x: N) -> N:
        """Return a function of one variable.

        Args:
            name: of the function, one of ``UNARY``.
        """
        ...


@dataclass(frozen=True, slots=True)
class Operation:
    """One line of a tape: ``code`` applied to the slots ``operands``; ``payload`` is a constant or exponent."""

    code: str
    operands: tuple[int, ...] = ()
    payload: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Tape:
    """Formulas compiled to slots: inputs first, then one slot an operation.

    Attributes:
        inputs: names of the inputs, in order.
        operations: the lines, each filling the next slot.
        outputs: the slots that hold the results.
    """

    inputs: tuple[str, ...]
    operations: tuple[Operation, ...]
    outputs: tuple[int, ...]

    def run(self, arithmetic: Arithmetic[N], values: Sequence[N]) -> list[N]:
        """Evaluate all outputs.

        Args:
            values: one value an input, of the arithmetic's own kind.

        Returns:
            One value an output, in order.

        Raises:
            InvalidInputError: a division by zero, in an arithmetic without infinity.
        """
        slots = list(values)
        try:
            for operation in self.operations:
                slots.append(applied(arithmetic, operation, slots))
        except ZeroDivisionError as fault:
            raise InvalidInputError(_POLE) from fault
        return [slots[i] for i in self.outputs]

    def bind(self, arithmetic: Arithmetic[N], known: Sequence[N]) -> BoundTape[N]:
        """Work out once what depends on the last inputs alone.

        Args:
            known: values of the last inputs.

        Returns:
            A rule for the other inputs.
        """
        free = len(self.inputs) - len(known)
        slots: list[Any] = [None] * free + list(known)  # None: filled by a run
        varying, rest = set(range(free)), []
        for operation in self.operations:
            place = len(slots)
            if varying.isdisjoint(operation.operands):
                slots.append(applied(arithmetic, operation, slots))
            else:
                varying.add(place)
                slots.append(None)
                rest.append((place, *_step(arithmetic, operation)))
        return BoundTape(arithmetic, free, tuple(slots), tuple(rest), self.outputs)

    def only(self, *chosen: int) -> Tape:
        """Return the tape of some of the outputs, with the operations they need.

        Args:
            *chosen: positions of the outputs.
        """
        outputs = tuple(self.outputs[j] for j in chosen)
        first, needed = len(self.inputs), set(outputs)
        for k in reversed(range(len(self.operations))):
            if first + k in needed:
                needed.update(self.operations[k].operands)
        kept = [k for k in range(len(self.operations)) if first + k in needed]
        moved = {first + k: first + n for n, k in enumerate(kept)} | {k: k for k in range(first)}
        lines = [self.operations[k] for k in kept]
        operations = tuple(Operation(o.code, tuple(moved[i] for i in o.operands), o.payload) for o in lines)
        return Tape(self.inputs, operations, tuple(moved[i] for i in outputs))


Step = tuple[int, Callable[..., N], int, int]
"""The slot to fill, what fills it, and the slots of its operands (the second is −1 where there is one)."""


@dataclass(frozen=True, slots=True, eq=False)
class BoundTape(Generic[N]):
    """A tape some of whose inputs are known; made by ``Tape.bind``.

    Attributes:
        arithmetic: where it was bound.
        free: number of inputs left.
        slots: what is known; None where a run fills it.
        rest: the steps left to do.
        outputs: as in the tape.
    """

    arithmetic: Arithmetic[N]
    free: int
    slots: tuple[N, ...]
    rest: tuple[Step[N], ...]
    outputs: tuple[int, ...]

    def run(self, *values: N) -> list[N]:
        """Evaluate all outputs at values of the free inputs; errors as in ``Tape.run``.

        Args:
            *values: one for each free input, numbers or arrays of the arithmetic bound.

        Raises:
            InvalidInputError: a division by zero.
        """
        slots = [*values, *self.slots[self.free :]]
        try:
            for place, rule, i, j in self.rest:
                slots[place] = rule(slots[i]) if j < 0 else rule(slots[i], slots[j])
        except ZeroDivisionError as fault:
            raise InvalidInputError(_POLE) from fault
        return [slots[i] for i in self.outputs]


def _raised(power: Callable[[N, int], N], n: int, x: N) -> N:
    return power(x, n)


def _step(arithmetic: Arithmetic[N], operation: Operation) -> tuple[Callable[..., N], int, int]:
    """Return an operation with operands as a rule and their slots."""
    code, operands = operation.code, operation.operands
    if code in {"add", "mul", "sub", "div"}:
        return getattr(arithmetic, code), operands[0], operands[1]
    if code == "power":
        power, n = arithmetic.power, operation.payload[0]
        return partial(_raised, power, n), operands[0], -1
    quick = getattr(arithmetic, "quick", {}).get(code)
    return quick or partial(arithmetic.unary, code), operands[0], -1


def applied(arithmetic: Arithmetic[N], operation: Operation, slots: Sequence[N]) -> N:
    """Return what an operation makes of the slots before it.

    Args:
        arithmetic: of the slots.
        operation: one line of a tape.
        slots: filled so far.
    """
    code, operands = operation.code, operation.operands
    match code:
        case "add":
            return arithmetic.add(slots[operands[0]], slots[operands[1]])
        case "mul":
            return arithmetic.mul(slots[operands[0]], slots[operands[1]])
        case "sub":
            return arithmetic.sub(slots[operands[0]], slots[operands[1]])
        case "div":
            return arithmetic.div(slots[operands[0]], slots[operands[1]])
        case "power":
            return arithmetic.power(slots[operands[0]], operation.payload[0])
        case "rational":
            return arithmetic.rational(*operation.payload)
        case "pi":
            return arithmetic.pi()
        case _:
            return arithmetic.unary(code, slots[operands[0]])
