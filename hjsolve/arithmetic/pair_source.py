"""An arithmetic that writes Python for numbers in two doubles: the twin of ``double_double`` for compiled programs.

Every operation becomes the line that calls a function on doubles (``ensembles/engine/compiled_pairs.py``); the text is
made of our own operation codes and of numbers, as that of ``python_source``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, exact
from hjsolve.arithmetic.floats import by_squaring
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.arithmetic.tape import UNARY

_PAIRED = {
    "sin": ("pair_sincos", 0),
    "cos": ("pair_sincos", 2),
    "sinh": ("pair_sinhcosh", 0),
    "cosh": ("pair_sinhcosh", 2),
}
_WORD = re.compile(r"[A-Za-z_]\w*")


class NamedPair(NamedTuple):
    """A number high + low, names of variables or literals."""

    high: str
    low: str


_ZERO, _ONE = NamedPair("(0.0)", "(0.0)"), NamedPair("(1.0)", "(0.0)")


def written(pair: Pair) -> NamedPair:
    """Return the literals of a pair of floats.

    Args:
        pair: two finite doubles.
    """
    return NamedPair(f"({float(pair.high)!r})", f"({float(pair.low)!r})")


@dataclass(frozen=True, slots=True)
class PairSource:
    """Arithmetic on ``NamedPair`` values.

    Attributes:
        source: the program so far.
    """

    source: PythonSource
    _near: dict[NamedPair, tuple[NamedPair, NamedPair]] = field(default_factory=dict)

    def _called(self, name: str, *values: NamedPair, results: int = 2) -> tuple[str, ...]:
        return self.source.called(name, *(part for value in values for part in value), results=results)

    def rational(self, numerator: int, denominator: int) -> NamedPair:
        """Return the literals of the two doubles next to a fraction.

        Args:
            numerator, denominator: whole numbers, the second not zero.
        """
        return written(exact(Fraction(numerator, denominator)))

    def pi(self) -> NamedPair:
        return written(DoubleDouble().pi())

    def add(self, x: NamedPair, y: NamedPair) -> NamedPair:
        """Write the line with x + y; none for a term 0.

        Args:
            x, y: names of variables, or literals.
        """
        if _ZERO in (x, y):
            return y if x == _ZERO else x
        return NamedPair(*self._called("pair_add", x, y))

    def displaced(self, x: NamedPair, step: NamedPair) -> NamedPair:
        """Write the line with x + step; sines and the like of the sum will be had from those of x.

        Args:
            x: names of variables, or literals.
            step: not more than 2⁻³⁴; where it is more they will be NaN.
        """
        base, way = self._near.get(x, (x, _ZERO))
        total = self.add(x, step)
        self._near[total] = base, self.add(way, step)
        return total

    def sub(self, x: NamedPair, y: NamedPair) -> NamedPair:
        """Write the lines with x − y.

        Args:
            x, y: names of variables, or literals.
        """
        return self.add(x, self._negative(y))

    def mul(self, x: NamedPair, y: NamedPair) -> NamedPair:
        """Write the line with x·y; none for a factor 1 or 0.

        Args:
            x, y: names of variables, or literals.
        """
        if _ONE in (x, y):
            return y if x == _ONE else x
        if _ZERO in (x, y):
            return _ZERO
        return NamedPair(*self._called("pair_mul", x, y))

    def div(self, x: NamedPair, y: NamedPair) -> NamedPair:
        """Write the line with x/y.

        Args:
            x, y: names of variables, or literals.
        """
        return NamedPair(*self._called("pair_div", x, y))

    def power(self, x: NamedPair, n: int) -> NamedPair:
        """Write xⁿ as products.

        Args:
            x: names of variables, or literals.
            n: the exponent, of either sign.
        """
        if n <= 0:
            return _ONE if n == 0 else self.div(_ONE, self.power(x, -n))
        result: NamedPair = by_squaring(self.mul, x, n)
        return result

    def _negative(self, x: NamedPair) -> NamedPair:
        return x if x == _ZERO else NamedPair(*(self.source.unary("neg", part) for part in x))

    def unary(self, name: str, x: NamedPair) -> NamedPair:
        """Write the line that takes a function of one variable.

        Args:
            name: of the function, one of ``tape.UNARY``.
            x: names of variables, or literals.

        Raises:
            ValueError: a function that is not known here.
        """
        if name not in UNARY:
            raise ValueError(name)
        if name == "neg":
            return self._negative(x)
        if name in _PAIRED:
            function, place = _PAIRED[name]
            base, way = self._near.get(x, (x, _ZERO))
            found = self._called(function, base, results=4)
            if way != _ZERO:
                found = self._called(f"{function}_near", NamedPair(*found[:2]), NamedPair(*found[2:]), way, results=4)
            return NamedPair(*found[place : place + 2])
        return NamedPair(*self._called(f"pair_{name}", x))


def needed(lines: Sequence[str], results: Sequence[str]) -> list[str]:
    """Return the lines of a program that its results depend on.

    Args:
        lines: as ``PythonSource`` writes them.
        results: names of variables, or literals.
    """
    wanted, kept = set(results), []
    for line in reversed(lines):
        left, right = line.split(" = ", 1)
        if not wanted.isdisjoint(left.split(", ")):
            kept.append(line)
            wanted.update(_WORD.findall(right))
    return kept[::-1]
