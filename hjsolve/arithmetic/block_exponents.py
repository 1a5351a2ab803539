"""A formula whose inputs come in other units: every value is written as v̂·2^e, with e known beforehand.

As in the block floating point of fixed-point arithmetic, products and powers only add exponents; what is smaller in a
sum is multiplied by the power of two between the two. So where r is 1e-90, 1/r² and its derivatives are numbers of
order one. Powers of two do not round.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import frexp
from typing import NamedTuple

from hjsolve.arithmetic.tape import Operation, Tape

NOTHING = -(1 << 24)
"""Exponent of zero: smaller than that of any number, and still so after roots and products."""

_LEAST_EXPONENT, _MOST_EXPONENT = -4096, 1023
"""Exponents of factors: what is smaller is nothing next to the other term of a sum; what is larger has no double."""


class ScaledSlot(NamedTuple):
    """A slot of the new tape that holds a value over 2^exponent."""

    slot: int
    exponent: int


def exponent_of(x: float) -> int:
    """Return e with |x| in [2^(e−1), 2^e); ``NOTHING`` for zero.

    Args:
        x: a finite number.
    """
    return frexp(x)[1] if x else NOTHING


class InUnits:
    """The arithmetic that writes the new tape."""

    def __init__(self, inputs: int):
        self.operations: list[Operation] = []
        self._inputs = inputs

    def _line(self, code: str, *operands: int, payload: tuple[int, ...] = ()) -> int:
        self.operations.append(Operation(code, operands, payload))
        return self._inputs + len(self.operations) - 1

    def at(self, x: ScaledSlot, exponent: int) -> int:
        """Return the slot of x over 2^exponent.

        Args:
            x: a value.
            exponent: of the unit asked for.
        """
        shift = x.exponent - exponent
        if shift == 0:
            return x.slot
        shift = min(max(shift, _LEAST_EXPONENT), _MOST_EXPONENT)
        factor = self._line("rational", payload=(1 << shift, 1) if shift > 0 else (1, 1 << -shift))
        return self._line("mul", x.slot, factor)

    def rational(self, numerator: int, denominator: int) -> ScaledSlot:
        if numerator == 0:
            return ScaledSlot(self._line("rational", payload=(0, 1)), NOTHING)
        e = abs(numerator).bit_length() - denominator.bit_length()
        payload = (numerator, denominator << e) if e > 0 else (numerator << -e, denominator)
        return ScaledSlot(self._line("rational", payload=payload), e)

    def pi(self) -> ScaledSlot:
        return ScaledSlot(self._line("pi"), 0)

    def add(self, x: ScaledSlot, y: ScaledSlot) -> ScaledSlot:
        e = max(x.exponent, y.exponent)
        return ScaledSlot(self._line("add", self.at(x, e), self.at(y, e)), e)

    def sub(self, x: ScaledSlot, y: ScaledSlot) -> ScaledSlot:
        e = max(x.exponent, y.exponent)
        return ScaledSlot(self._line("sub", self.at(x, e), self.at(y, e)), e)

    def mul(self, x: ScaledSlot, y: ScaledSlot) -> ScaledSlot:
        return ScaledSlot(self._line("mul", x.slot, y.slot), x.exponent + y.exponent)

    def div(self, x: ScaledSlot, y: ScaledSlot) -> ScaledSlot:
        return ScaledSlot(self._line("div", x.slot, y.slot), x.exponent - y.exponent)

    def power(self, x: ScaledSlot, n: int) -> ScaledSlot:
        return ScaledSlot(self._line("power", x.slot, payload=(n,)), n * x.exponent)

    def unary(self, name: str, x: ScaledSlot) -> ScaledSlot:
        if name in {"neg", "abs"}:
            return ScaledSlot(self._line(name, x.slot), x.exponent)
        half = x.exponent // 2 if name == "sqrt" else 0
        return ScaledSlot(self._line(name, self.at(x, 2 * half)), half)


def tape_in_units(tape: Tape, inputs: Sequence[int], outputs: Sequence[int] | None = None) -> tuple[Tape, list[int]]:
    """Return the formulas of a tape as functions of its inputs over powers of two, and the exponents of its results.

    Args:
        tape: the formulas.
        inputs: an exponent for each input.
        outputs: an exponent for each result; None for those that come of themselves, which no result exceeds by much.
    """
    units = InUnits(len(tape.inputs))
    found = tape.run(units, [ScaledSlot(k, e) for k, e in enumerate(inputs)])
    wanted = [x.exponent for x in found] if outputs is None else list(outputs)
    slots = tuple(units.at(x, e) for x, e in zip(found, wanted, strict=True))
    return Tape(tape.inputs, tuple(units.operations), slots), wanted
