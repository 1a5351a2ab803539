"""Complex numbers on the machine: an arithmetic whose values are two values of a program, and its running errors.

Numbers known to be real have no imaginary part, so that what is real costs what it costs in a real program. Functions
are their principal branches; those that a tape rarely has are written by logarithms and roots, so that their errors are
those of the operations they are made of.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from hjsolve.arithmetic.function_rules import ByOthers, quotient
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.writer import InstructionWriter, Value
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Arithmetic

_PRODUCT, _QUOTIENT = 3, 7
"""Units of rounding: |fl(x·y) − x·y| ≤ √5 u |x y| (Brent, Percival and Zimmermann 2007); of a quotient |y|² has two,
its inverse and ȳ/|y|² one more each."""
_OF_LOGARITHM = 4
"""Units of rounding of |z|² next to 1, which the real part of a logarithm keeps as they are."""
_OF_FUNCTION = 2 * ROUNDINGS + 1
"""Units of rounding of the parts of a function that are products of two."""


class ComplexValue(NamedTuple):
    """Real and imaginary part; None for a real number."""

    re: Value
    im: Value | None = None


@dataclass(frozen=True)
class ComplexWriter(ByOthers):
    """Arithmetic on ``ComplexValue``.

    Attributes:
        writer: of the program.
    """

    writer: InstructionWriter

    def rational(self, numerator: int, denominator: int) -> ComplexValue:
        return ComplexValue(self.writer.rational(numerator, denominator))

    def pi(self) -> ComplexValue:
        return ComplexValue(self.writer.pi())

    def add(self, x: ComplexValue, y: ComplexValue) -> ComplexValue:
        a = self.writer
        im = y.im if x.im is None else x.im if y.im is None else a.add(x.im, y.im)
        return ComplexValue(a.add(x.re, y.re), im)

    def mul(self, x: ComplexValue, y: ComplexValue) -> ComplexValue:
        """Write x·y: one product where both are real, two where one is."""
        a = self.writer
        if y.im is None:
            return ComplexValue(a.mul(x.re, y.re), None if x.im is None else a.mul(x.im, y.re))
        if x.im is None:
            return self.mul(y, x)
        re = a.sub(a.mul(x.re, y.re), a.mul(x.im, y.im))
        return ComplexValue(re, a.add(a.mul(x.re, y.im), a.mul(x.im, y.re)))

    def div(self, x: ComplexValue, y: ComplexValue) -> ComplexValue:
        """Write x/y = x ȳ/|y|²."""
        a = self.writer
        if y.im is None:
            return ComplexValue(a.div(x.re, y.re), None if x.im is None else a.div(x.im, y.re))
        part = a.div(a.number(1.0), self.square(y))
        return self.mul(x, ComplexValue(a.mul(y.re, part), a.unary("neg", a.mul(y.im, part))))

    def power(self, x: ComplexValue, n: int) -> ComplexValue:
        """Write xⁿ as products."""
        if x.im is None:
            return ComplexValue(self.writer.power(x.re, n))
        return ByOthers.power(self, x, n)

    def square(self, x: ComplexValue) -> Value:
        """Write |x|²."""
        a, own = self.writer, self.writer.mul(x.re, x.re)
        return own if x.im is None else a.add(own, a.mul(x.im, x.im))

    def _negative(self, x: ComplexValue) -> ComplexValue:
        a = self.writer
        return ComplexValue(a.unary("neg", x.re), None if x.im is None else a.unary("neg", x.im))

    def turned(self, x: ComplexValue, sign: int) -> ComplexValue:
        """Write ±i x."""
        a = self.writer
        im = a.number(0.0) if x.im is None else x.im
        return ComplexValue(a.unary("neg", im), x.re) if sign > 0 else ComplexValue(im, a.unary("neg", x.re))

    def unary(self, name: str, x: ComplexValue) -> ComplexValue:
        """Write a function of one variable; "abs" is the modulus, as bounds need it."""
        a = self.writer
        if name == "neg":
            return self._negative(x)
        if x.im is None and name not in {"sqrt", "log", "log1p"}:
            return ComplexValue(a.unary(name, x.re))
        im = a.number(0.0) if x.im is None else x.im
        match name:
            case "abs":
                return ComplexValue(a.unary("sqrt", self.square(x)))
            case "sqrt":
                return self._root(x.re, im)
            case "exp":
                size = a.unary("exp", x.re)
                return ComplexValue(a.mul(size, a.unary("cos", im)), a.mul(size, a.unary("sin", im)))
            case "log":
                return self._logarithm(x.re, im)
            case "log1p":
                return self._logarithm_next_to_one(x.re, im)
            case "sin" | "cos" | "sinh" | "cosh":
                return self._wave(name, x.re, im)
            case _:
                return composed(self, name, x)

    def _root(self, x: Value, y: Value) -> ComplexValue:
        """√z = t + i y/2t, t = √((|z| + |x|)/2), or the two the other way round where x < 0."""
        a = self.writer
        size = a.unary("sqrt", a.add(a.mul(x, x), a.mul(y, y)))
        t = a.unary("sqrt", a.mul(a.number(0.5), a.add(size, a.unary("abs", x))))
        s = a.div(a.mul(a.number(0.5), a.unary("abs", y)), t)
        forward = a.called("signed", x, a.number(0.5))[0]  # ½ or −½
        right, left = a.add(a.number(0.5), forward), a.sub(a.number(0.5), forward)
        re = a.add(a.mul(right, t), a.mul(left, s))
        im = a.add(a.mul(right, s), a.mul(left, t))
        return ComplexValue(re, a.called("signed", y, im)[0])

    def _logarithm(self, x: Value, y: Value) -> ComplexValue:
        """½ log |z|² + i arg z, arg z = 2 atan(y/(|z| + x))."""
        a = self.writer
        square = a.add(a.mul(x, x), a.mul(y, y))
        half = a.unary("atan", a.div(y, a.add(a.unary("sqrt", square), x)))
        return ComplexValue(a.mul(a.number(0.5), a.unary("log", square)), a.mul(a.number(2.0), half))

    def _logarithm_next_to_one(self, x: Value, y: Value) -> ComplexValue:
        """½ log(1 + s) + i arg(1 + z) with s = x (2 + x) + y² and log(1 + s) = arsinh(s (1 + 1/(1 + s))/2)."""
        a, one = self.writer, self.writer.number(1.0)
        s = a.add(a.mul(x, a.add(a.number(2.0), x)), a.mul(y, y))
        squared, w = a.add(one, s), a.add(one, x)
        rise = a.unary("asinh", a.mul(a.mul(a.number(0.5), s), a.add(one, a.div(one, squared))))
        half = a.unary("atan", a.div(y, a.add(a.unary("sqrt", squared), w)))
        return ComplexValue(a.mul(a.number(0.5), rise), a.mul(a.number(2.0), half))

    def _wave(self, name: str, x: Value, y: Value) -> ComplexValue:
        a = self.writer
        s, c, sh, ch = "sin", "cos", "sinh", "cosh"
        around, along = (x, y) if name in {s, c} else (y, x)
        sine, cosine = a.unary(s, around), a.unary(c, around)
        grown, even = a.unary(sh, along), a.unary(ch, along)
        match name:
            case "sin":
                return ComplexValue(a.mul(sine, even), a.mul(cosine, grown))
            case "cos":
                return ComplexValue(a.mul(cosine, even), a.unary("neg", a.mul(sine, grown)))
            case "sinh":
                return ComplexValue(a.mul(cosine, grown), a.mul(sine, even))
            case _:
                return ComplexValue(a.mul(cosine, even), a.mul(sine, grown))


@dataclass(frozen=True)
class AnalyticWriter(ComplexWriter):
    """As ``ComplexWriter``, but "abs" is the analytic function ±z that a formula means by it."""

    def unary(self, name: str, x: ComplexValue) -> ComplexValue:
        """Write a function of one variable."""
        if name != "abs" or x.im is None:
            return ComplexWriter.unary(self, name, x)
        sign = self.writer.called("signed", x.re, self.writer.number(1.0))[0]
        return self.mul(x, ComplexValue(sign))


class TurningArithmetic(Arithmetic[N], Protocol[N]):
    """An arithmetic over complex numbers that turns them by a right angle."""

    def turned(self, x: N, sign: int) -> N:
        """Return ±i x."""
        ...


def composed(arithmetic: TurningArithmetic[N], name: str, z: N) -> N:
    """Write a function by exponentials, logarithms and roots.

    Args:
        arithmetic: over complex numbers.
        z: a number of it.

    Raises:
        ValueError: a function without such a formula.
    """
    a, one, half = arithmetic, arithmetic.rational(1, 1), arithmetic.rational(1, 2)

    def log(x: N) -> N:
        return a.unary("log", x)

    def root(x: N) -> N:
        return a.unary("sqrt", x)

    match name:
        case "tan" | "tanh" | "sech":
            return quotient(a, name, z)
        case "asinh":  # z + √(1 + z²) is 1 + z + z²/(1 + √(1 + z²))
            square = a.mul(z, z)
            return a.unary("log1p", a.add(z, a.div(square, a.add(one, root(a.add(one, square))))))
        case "acosh":
            return log(a.add(z, a.mul(root(a.add(z, one)), root(a.sub(z, one)))))
        case "atanh":
            return a.mul(half, log(a.div(a.add(one, z), a.sub(one, z))))
        case "atan":
            return a.turned(composed(a, "atanh", a.turned(z, 1)), -1)
        case "asin":
            return a.turned(composed(a, "asinh", a.turned(z, 1)), -1)
        case "acos":
            return a.sub(a.mul(half, a.pi()), composed(a, "asin", z))
    raise ValueError(f"no complex formula for {name}")


@dataclass(frozen=True, slots=True)
class ComplexRunningError(RunningError[ComplexValue]):
    """Running errors of complex values: the same rules with roundings of complex operations, bounds being real."""

    plain: ComplexWriter
    own: int = _OF_FUNCTION

    def _units_of_product(self, x: ComplexValue, y: ComplexValue) -> int:
        return 1 if x.im is None or y.im is None else _PRODUCT

    def _units_of_quotient(self, y: ComplexValue) -> int:
        return 1 if y.im is None else _QUOTIENT

    def _units_of_power(self, x: ComplexValue, n: int) -> int:
        return abs(n) * self._units_of_product(x, x) + (0 if n > 0 else _QUOTIENT)

    def unary(self, name: str, x: WithErrorBound[ComplexValue]) -> WithErrorBound[ComplexValue]:
        """Return Φ(x); its bound is |Φ′(x)| δx and its roundings."""
        if name == "sqrt":
            value = self.plain.unary(name, x.value)
            passed = None if x.error is None else self.plain.div(x.error, self.plain.unary("abs", value))
            return WithErrorBound(value, self._sum(passed, self._scaled(value, _QUOTIENT)))
        if name == "neg":
            return WithErrorBound(self.plain.unary(name, x.value), x.error)
        if name == "abs":
            return WithErrorBound(AnalyticWriter(self.plain.writer).unary(name, x.value), x.error)
        if name == "log1p":
            return self._logarithm_next_to_one(x)
        if name not in {"exp", "log", "sin", "cos", "sinh", "cosh"}:
            return composed(self, name, x)
        a = self.plain
        value = a.unary(name, x.value)
        slopes = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}
        own = self._scaled(value, self.own)  # real and imaginary part are products of two functions each
        if name == "log":
            slope = a.div(a.rational(1, 1), x.value)
            own = a.add(own, a.rational(_OF_LOGARITHM, 2**self.bits))  # bits are 53
        else:
            slope = value if name == "exp" else a.unary(slopes[name], x.value)
        return WithErrorBound(value, self._sum(self._part(slope, x.error), own))

    def turned(self, x: WithErrorBound[ComplexValue], sign: int) -> WithErrorBound[ComplexValue]:
        """Return ±i x, which has the error of x."""
        return WithErrorBound(self.plain.turned(x.value, sign), x.error)

    def _logarithm_next_to_one(self, x: WithErrorBound[ComplexValue]) -> WithErrorBound[ComplexValue]:
        """log(1 + z): s is rounded to parts of |z| (1 + |z|), which 1/|1 + z|² passes on."""
        a, one = self.plain, self.plain.rational(1, 1)
        value, size = a.unary("log1p", x.value), a.unary("abs", x.value)
        below = a.add(one, x.value)
        rounded = a.div(a.mul(size, a.add(one, size)), ComplexValue(a.square(below)))
        own = a.add(self._scaled(value, self.own), self._scaled(rounded, self.own))
        return WithErrorBound(value, self._sum(self._part(a.div(one, below), x.error), own))
