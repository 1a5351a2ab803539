"""Reciprocals and products of functions that overflow, written with functions that do not.

1/cosh x is sech x, 1/sinh x is sech x/tanh x, 1/exp x is exp(−x), and the reciprocal of a product or a power is that of
its factors. Far out, where cosh x is beyond the doubles, nothing is lost. In a wave packet e^x sin y, where a tiny
number meets one that is beyond the doubles at complex y, the product is (e^{x + iy} − e^{x − iy})/2i; ``turned`` is i
times a number.
"""

from __future__ import annotations

from functools import lru_cache, reduce

from hjsolve.arithmetic.tape import Operation, Tape

_WAVES = frozenset({"sin", "cos", "sinh", "cosh"})


@lru_cache(maxsize=256)
def without_overflow(tape: Tape, *, packets: bool = False) -> Tape:
    """Return the same formulas with reciprocals that do not overflow; ``sech`` is an operation of its own.

    Args:
        tape: the formulas.
        packets: True to rewrite wave packets too, for an arithmetic of complex numbers that has ``turned``.
    """
    rewriter = _Rewriter(tape, packets)
    return Tape(tape.inputs, tuple(rewriter.operations), tuple(rewriter.slots[i] for i in tape.outputs))


class _Rewriter:
    def __init__(self, tape: Tape, packets: bool):
        self.packets = packets
        self.varying = {0}  # what depends on the first input
        self.count = len(tape.inputs)
        self.operations: list[Operation] = []
        self.lines: dict[Operation, int] = {}
        self.slots = list(range(self.count))
        for operation in tape.operations:
            self.slots.append(self._rewritten(operation))

    def _emit(self, code: str, *operands: int, payload: tuple[int, ...] = ()) -> int:
        operation = Operation(code, operands, payload)
        if operation not in self.lines:
            self.lines[operation] = self.count + len(self.operations)
            self.operations.append(operation)
            if not self.varying.isdisjoint(operands):
                self.varying.add(self.lines[operation])
        return self.lines[operation]

    def _rewritten(self, operation: Operation) -> int:
        operands = [self.slots[i] for i in operation.operands]
        if operation.code == "div" and self._overflows(operands[1]):
            return self._product([operands[0], self._inverse(operands[1])])
        if operation.code == "power" and operation.payload[0] < 0 and self._overflows(operands[0]):
            return self._emit("power", self._inverse(operands[0]), payload=(-operation.payload[0],))
        if operation.code == "mul":
            return self._product(operands)
        return self._emit(operation.code, *operands, payload=operation.payload)

    def _product(self, operands: list[int]) -> int:
        """Return the product, with one wave taken into the exponential where both are among the factors."""
        factors = [leaf for slot in operands for leaf in self._factors(slot)]
        decays = [slot for slot in factors if self._line(slot).code == "exp"]
        wave = next((slot for slot in factors if self._line(slot).code in _WAVES and slot in self.varying), None)
        if not self.packets or not decays or wave is None:
            return self._emit("mul", *operands)
        factors.remove(wave)
        rest = [slot for slot in factors if slot not in decays]
        exponent = self._reduced("add", [self._line(slot).operands[0] for slot in decays])
        return self._reduced("mul", [*rest, self._packet(exponent, self._line(wave))])

    def _factors(self, slot: int) -> list[int]:
        line = self._line(slot)
        if line.code == "mul":
            return [leaf for i in line.operands for leaf in self._factors(i)]
        if line.code == "neg":
            return [self._emit("rational", payload=(-1, 1)), *self._factors(line.operands[0])]
        return [slot]

    def _reduced(self, code: str, slots: list[int]) -> int:
        return reduce(lambda x, y: self._emit(code, x, y), slots)

    def _packet(self, exponent: int, wave: Operation) -> int:
        """e^x sin y, e^x cos y, e^x sinh y or e^x cosh y as half the sum or difference of two exponentials."""
        phase, circular = wave.operands[0], wave.code in {"sin", "cos"}
        phase = self._emit("turned", phase) if circular else phase
        up, down = (self._emit("exp", self._emit(code, exponent, phase)) for code in ("add", "sub"))
        both = self._emit("add" if wave.code in {"cos", "cosh"} else "sub", up, down)
        half = self._emit("mul", self._emit("rational", payload=(1, 2)), both)
        return self._emit("neg", self._emit("turned", half)) if wave.code == "sin" else half

    def _line(self, slot: int) -> Operation:
        return self.operations[slot - self.count] if slot >= self.count else Operation("input")

    def _overflows(self, slot: int) -> bool:
        line = self._line(slot)
        if line.code in {"mul", "neg"} or (line.code == "power" and line.payload[0] > 0):
            return any(self._overflows(i) for i in line.operands)
        return line.code in {"cosh", "sinh", "exp"}

    def _inverse(self, slot: int) -> int:
        line = self._line(slot)
        match line.code:
            case "cosh":
                return self._emit("sech", *line.operands)
            case "sinh":
                return self._emit("div", self._emit("sech", *line.operands), self._emit("tanh", *line.operands))
            case "exp":
                return self._emit("exp", self._emit("neg", *line.operands))
            case "neg":
                return self._emit("neg", self._inverse(line.operands[0]))
            case "mul":
                return self._emit("mul", *(self._inverse(i) for i in line.operands))
            case "power" if line.payload[0] > 0:
                return self._emit("power", self._inverse(line.operands[0]), payload=line.payload)
            case _:
                return self._emit("div", self._emit("rational", payload=(1, 1)), slot)
