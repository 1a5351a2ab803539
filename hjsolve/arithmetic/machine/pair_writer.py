"""An arithmetic that writes instructions for numbers in two doubles."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from hjsolve.arithmetic.double_double import PLACES, DoubleDouble
from hjsolve.arithmetic.error_free import Pair, exact
from hjsolve.arithmetic.function_rules import ByOthers
from hjsolve.arithmetic.machine.allocation import Value
from hjsolve.arithmetic.machine.writer import InstructionWriter
from hjsolve.arithmetic.tape import UNARY


class PairOfValues(NamedTuple):
    """A number high + low."""

    high: Value
    low: Value


@dataclass(frozen=True, slots=True)
class PairWriter(ByOthers):
    """Arithmetic on ``PairOfValues``.

    Attributes:
        writer: of the program.
    """

    writer: InstructionWriter
    _near: dict[PairOfValues, tuple[PairOfValues, PairOfValues]] = field(default_factory=dict)
    _opposite: dict[PairOfValues, PairOfValues] = field(default_factory=dict)

    def of(self, value: Value) -> PairOfValues:
        """Return a number whose low part is zero.

        Args:
            value: the high part.
        """
        return PairOfValues(value, self.writer.number(0.0))

    def parameter(self) -> PairOfValues:
        """Return a new parameter, which takes two of the program's: the high part, then the low one."""
        return PairOfValues(self.writer.parameter(), self.writer.parameter())

    def written(self, pair: Pair) -> PairOfValues:
        """Return a constant.

        Args:
            pair: two finite doubles.
        """
        return PairOfValues(self.writer.number(float(pair.high)), self.writer.number(float(pair.low)))

    def _is(self, x: PairOfValues, number: float) -> bool:
        return x == self.of(self.writer.number(number))

    def _called(self, name: str, *values: PairOfValues, results: int = 2) -> tuple[Value, ...]:
        return self.writer.called(name, *(part for value in values for part in value), results=results)

    def rational(self, numerator: int, denominator: int) -> PairOfValues:
        """Return the two doubles next to a fraction."""
        return self.written(exact(Fraction(numerator, denominator)))

    def pi(self) -> PairOfValues:
        return self.written(DoubleDouble().pi())

    def add(self, x: PairOfValues, y: PairOfValues) -> PairOfValues:
        """Write x + y; nothing for a term 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return y if self._is(x, 0.0) else x
        if y in self._opposite:
            return PairOfValues(*self._called("pair_sub", x, self._opposite[y]))
        return PairOfValues(*self._called("pair_add", x, y))

    def displaced(self, x: PairOfValues, step: PairOfValues) -> PairOfValues:
        """Write x + step; sines and the like of the sum come from those of x.

        Args:
            x: a number in two values.
            step: not more than 2⁻³⁴; where it is more, sines and the like will be nan.
        """
        base, offset = self._near.get(x, (x, self.rational(0, 1)))
        total = self.add(x, step)
        self._near[total] = base, self.add(offset, step)
        return total

    def sub(self, x: PairOfValues, y: PairOfValues) -> PairOfValues:
        """Write x − y; nothing for y = 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return self._negative(y) if self._is(x, 0.0) else x
        if y in self._opposite:
            return self.add(x, self._opposite[y])
        return PairOfValues(*self._called("pair_sub", x, y))

    def mul(self, x: PairOfValues, y: PairOfValues) -> PairOfValues:
        """Write x·y; nothing for a factor 1 or 0."""
        if self._is(x, 0.0) or self._is(y, 0.0):
            return self.rational(0, 1)
        for factor, other in ((x, y), (y, x)):
            if self._is(factor, 1.0):
                return other
            if self._is(factor, -1.0):
                return self._negative(other)
        return PairOfValues(*self._called("pair_mul", x, y))

    def div(self, x: PairOfValues, y: PairOfValues) -> PairOfValues:
        """Write x/y."""
        return x if self._is(y, 1.0) else PairOfValues(*self._called("pair_div", x, y))

    def _negative(self, x: PairOfValues) -> PairOfValues:
        if x in self._opposite:
            return self._opposite[x]
        made = PairOfValues(*(self.writer.unary("neg", part) for part in x))
        self._opposite[made] = x
        return made

    def unary(self, name: str, x: PairOfValues) -> PairOfValues:
        """Write a function of one variable.

        Raises:
            ValueError: a function that is not known here.
        """
        if name not in UNARY:
            raise ValueError(name)
        if name == "neg":
            return self._negative(x)
        if name in PLACES:
            function, place = f"pair_{PLACES[name][0]}", PLACES[name][1]
            base, offset = self._near.get(x, (x, self.rational(0, 1)))
            found = self._called(function, base, results=4)
            if not self._is(offset, 0.0):
                parts = PairOfValues(*found[:2]), PairOfValues(*found[2:]), offset
                found = self._called(f"{function}_near", *parts, results=4)
            return PairOfValues(*found[place : place + 2])
        return PairOfValues(*self._called(f"pair_{name}", x))
