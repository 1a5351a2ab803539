"""The regular factor of p² at complex places: R(q) = −F[a, b, q], the second divided difference on the turning points.

With F(a) = F(b) = 0 it is p² = (q − a)(b − q) R(q). The difference is carried through the formula by the rules of
``arithmetic.divided_differences``. One of an elementary function Φ is a quotient where its points are far apart, and a
mean value of Φ′ or ½Φ″ over their hull where they are close (Hermite–Genocchi), whichever is known better.
However small b − a is, nothing cancels, and constants added to F do not matter. What depends on a and b alone is worked
out once; the rest runs over disks, or over points in complex doubles where a few digits are enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single, tighter
from hjsolve.arithmetic.floats import by_squaring
from hjsolve.arithmetic.number_types import Complexes, Integers, N
from hjsolve.arithmetic.tape import Operation, Tape
from hjsolve.errors import required
from hjsolve.one_coordinate.difference_rules import (
    AtPoints,
    DifferenceRules,
    DividedValues,
    EndValues,
    OverDisks,
    ProgramLine,
)

_DISKS = Disks()
_ONE = _DISKS.rational(1, 1)


@dataclass(frozen=True)
class Deflated:
    """The second difference of a formula on two fixed places, ready to be run.

    Attributes:
        ends: what is known of each slot of the program at a and b.
        lines: what is left to do at q.
        output: the slot of the formula.
    """

    ends: tuple[EndValues, ...]
    lines: tuple[ProgramLine, ...]
    output: int

    def over(self, q: Disk, from_lower: Disk | None, from_upper: Disk | None) -> tuple[Disk, Integers | int]:
        """Enclose R over disks that hold q, q − a and q − b.

        Args:
            q: disks, shape (m,).
            from_lower, from_upper: q − a and q − b, known better than by subtraction.

        Returns:
            The disks, and which of ``methods`` gave each of them: the one that is known best.
        """
        from_lower, from_upper = required(from_lower), required(from_upper)
        # one pass gives F(q) and its differences: four formulas for R, of which each is narrow somewhere else
        result = self._run(OverDisks(), q)
        best, method = result.second, np.zeros(np.shape(result.second.radius), dtype=int)
        for number, (above, below) in enumerate(
            ((result.from_upper, from_lower), (result.from_lower, from_upper), (result.here, None)), 1
        ):
            other = _DISKS.div(above, below if below is not None else _DISKS.mul(from_lower, from_upper))
            # disks of one number all hold it: the narrowest is right whichever formula it comes from
            better = (other.radius < best.radius) | (~np.isfinite(best.radius) & np.isfinite(other.radius))
            best = Disk(*(np.where(better, x, y) for x, y in zip(other, best, strict=True)))
            method = np.where(better, number, method)
        return -best, method

    def at(
        self, q: Complexes, from_lower: Complexes | None, from_upper: Complexes | None, method: Integers | int = 0
    ) -> Complexes:
        """Return R at complex places, in doubles, in one of the ``methods``.

        Args:
            q: complex, shape (m,).
            from_lower, from_upper: q − a and q − b, known better than by subtraction.
            method: position among the ``methods``; one for all places, or one for each.
        """
        found: Complexes = np.choose(method, np.broadcast_arrays(*self.methods(q, from_lower, from_upper)))
        return found

    def methods(
        self, q: Complexes, from_lower: Complexes | None, from_upper: Complexes | None
    ) -> tuple[Complexes, ...]:
        """Return R at complex places as −F[a, b, q], −F[b, q]/(q − a), −F[a, q]/(q − b), −F(q)/((q − a)(q − b)).

        They are the same, and each of them may have lost all digits where another one has not.

        Args:
            q: complex, shape (m,).
            from_lower, from_upper: q − a and q − b, known better than by subtraction.
        """
        from_lower, from_upper = required(from_lower), required(from_upper)
        found = self._run(AtPoints(), q)
        quotients = found.from_upper / from_lower, found.from_lower / from_upper, found.here / (from_lower * from_upper)
        return -found.second, -quotients[0], -quotients[1], -quotients[2]

    def _run(self, on: DifferenceRules[N], q: N) -> DividedValues[N]:
        one, zero = on.fixed(_ONE), on.fixed(single(0, 0))
        slots: list[DividedValues[N] | None] = [None] * len(self.ends)
        # of q itself: q[a, b, q] = 0 and q[b, q] = q[a, q] = 1
        slots[0] = DividedValues(q, zero, one, one)
        for line in self.lines:
            slots[line.target] = on.step(line, self.ends, slots)
        found = slots[self.output]
        return DividedValues(zero, zero, zero, zero) if found is None else found


def deflated(tape: Tape, inputs: Sequence[Disk], lower: Disk, upper: Disk, width: Disk) -> Deflated:
    """Make a formula ready for its second differences on two places.

    Args:
        tape: the formula, one output; q is its first input.
        inputs: the other inputs.
        lower, upper, width: a, b and b − a.
    """
    with np.errstate(all="ignore"):
        builder = _Builder(lower, upper, width, inputs)
        for operation in tape.operations:
            builder.add(operation)
        return Deflated(tuple(builder.ends), tuple(builder.lines), builder.slots[tape.outputs[0]])


class _Builder:
    """Writes the lines of a program and works out what is known at the ends."""

    def __init__(self, lower: Disk, upper: Disk, width: Disk, inputs: Sequence[Disk]):
        self.ends: list[EndValues] = [EndValues(lower, upper, _ONE), *(EndValues(x, x) for x in inputs)]
        self.lines: list[ProgramLine] = []
        self.width = width
        self.slots = list(range(len(self.ends)))

    def add(self, operation: Operation) -> None:
        self.slots.append(self._slot(operation, [self.slots[i] for i in operation.operands]))

    def _slot(self, operation: Operation, x: list[int]) -> int:
        match operation.code:
            case "rational":
                return self._constant(_DISKS.rational(*operation.payload))
            case "pi":
                return self._constant(_DISKS.pi())
            case "add" | "mul":
                return self._line(operation.code, *x)
            case "sub":
                return self._line("add", x[0], self._negative(x[1]))
            case "div":
                return self._line("mul", x[0], self._line("inverse", x[1]))
            case "power":
                return self._power(x[0], operation.payload[0])
            case "neg":
                return self._negative(x[0])
            case _:
                return self._line(operation.code, x[0])

    def _constant(self, value: Disk) -> int:
        self.ends.append(EndValues(value, value))
        return len(self.ends) - 1

    def _negative(self, x: int) -> int:
        return self._line("mul", self._constant(_DISKS.rational(-1, 1)), x)

    def _power(self, x: int, n: int) -> int:
        if n < 0:
            return self._line("inverse", self._power(x, -n))
        return by_squaring(partial(self._line, "mul"), x, n) if n else self._constant(_ONE)

    def _line(self, code: str, x: int, y: int = -1) -> int:
        f, g = self.ends[x], self.ends[y]
        at = self._at(code, f.lower, g.lower), self._at(code, f.upper, g.upper)
        # what does not contain q has no differences: one disk, and no line of the program
        if f.chord is None and (y < 0 or g.chord is None):
            return self._constant(at[0])
        line = ProgramLine(code, len(self.ends), x, y)
        self.ends.append(EndValues(*at, self._chord(code, f, g, at)))
        self.lines.append(line)
        return line.target

    def _at(self, code: str, x: Disk, y: Disk) -> Disk:
        match code:
            case "add":
                return _DISKS.add(x, y)
            case "mul":
                return _DISKS.mul(x, y)
            case "inverse":
                return _DISKS.inverse(x)
            case _:
                return _DISKS.unary(code, x)

    def _chord(self, code: str, f: EndValues, g: EndValues, at: tuple[Disk, Disk]) -> Disk:
        """Return the first difference on a and b, by rule or as a quotient."""
        zero, d = single(0, 0), _DISKS
        first, second = f.chord or zero, g.chord or zero
        match code:
            case "add":
                found = d.add(first, second)
            case "mul":
                # Leibniz: (fg)[a, b] = f(a) g[a, b] + f[a, b] g(b)
                found = d.add(d.mul(f.lower, second), d.mul(first, g.upper))
            case "inverse":
                # (1/f)[a, b] = −f[a, b]/(f(a) f(b)), with both inverses known already
                found = d.mul(d.mul(*at), -first)
            case _:
                found = d.mul(d.chord(code, f.lower, f.upper, *at), first)
        # by rule no digits cancel where b − a is small; where it is large the quotient is narrower
        return tighter(found, d.div(d.sub(at[1], at[0]), self.width))
