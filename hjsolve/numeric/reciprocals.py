"""Reciprocals of functions that overflow, written with functions that do not.

1/cosh x is sech x, 1/sinh x is sech x/tanh x, 1/exp x is exp(−x), and the reciprocal of a product or a power is that of
its factors. Far out, where cosh x is beyond the doubles, nothing is lost.
"""

from __future__ import annotations

from functools import lru_cache

from hjsolve.numeric.tape import Operation, Tape


@lru_cache(maxsize=256)
def without_overflow(tape: Tape) -> Tape:
    """Return the same formulas with reciprocals that do not overflow; ``sech`` is an operation of its own."""
    rewriter = _Rewriter(tape)
    return Tape(tape.inputs, tuple(rewriter.operations), tuple(rewriter.slots[i] for i in tape.outputs))


class _Rewriter:
    def __init__(self, tape: Tape):
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
        return self.lines[operation]

    def _rewritten(self, operation: Operation) -> int:
        operands = [self.slots[i] for i in operation.operands]
        if operation.code == "div" and self._overflows(operands[1]):
            return self._emit("mul", operands[0], self._inverse(operands[1]))
        if operation.code == "power" and operation.payload[0] < 0 and self._overflows(operands[0]):
            return self._emit("power", self._inverse(operands[0]), payload=(-operation.payload[0],))
        return self._emit(operation.code, *operands, payload=operation.payload)

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
