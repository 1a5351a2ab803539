"""Truncated power series: the Taylor coefficients of a formula along a path, from its tape, one after the other.

Coefficients of products and quotients are those of Cauchy's rule; those of elementary functions follow from their
differential equations, such as y = e^x: k y_k = Σ_{1 ≤ j ≤ k} j x_j y_{k−j} (Griewank and Walther, ch. 13). A tape run
over series gives lines, each of which appends the k-th coefficient of its series: what is differentiated may be what is
being found, as in y′ = f(y) (Jorba & Zou, Experimental Mathematics 14 (2005) 99).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import mul
from typing import Generic, Protocol, TypeVar

from hjsolve.arithmetic.floats import Multi, by_squaring
from hjsolve.arithmetic.function_rules import QUOTIENTS, quotient
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError, of_kind

C = TypeVar("C", int, Mpf)
"""The kind of coefficients."""


class SeriesNumbers(Protocol[C]):
    """What coefficients are: how sums of products of them become one of them."""

    @property
    def plain(self) -> Multi: ...
    def of(self, value: Mpf) -> C:
        """Return a number as a coefficient."""
        ...

    def product(self, total: C) -> C:
        """Return a sum of products as a coefficient."""
        ...

    def mean(self, total: C, k: int) -> C:
        """Return a sum of products over a whole number."""
        ...

    def quotient(self, above: C, total: C, below: C) -> C:
        """Return a coefficient less a sum of products, over a coefficient."""
        ...

    def root(self, value: C) -> C:
        """Return the square root of a positive coefficient."""
        ...

    def real(self, value: C) -> Mpf:
        """Return the number that a coefficient means."""
        ...


@dataclass(frozen=True)
class FixedPoint:
    """Integers in units of 2^−bits: products of long series cost a fifth of those of ``mpf``.

    Attributes:
        bits: binary digits after the point.
    """

    bits: int
    plain: Multi = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "plain", Multi(self.bits))

    def of(self, value: Mpf) -> int:
        return int(self.plain.context.nint(self.plain.context.ldexp(value, self.bits)))

    def product(self, total: int) -> int:
        return total >> self.bits

    def mean(self, total: int, k: int) -> int:
        return total // k >> self.bits

    def quotient(self, above: int, total: int, below: int) -> int:
        return ((above << self.bits) - total) // below

    def root(self, value: int) -> int:
        return math.isqrt(value << self.bits)

    def real(self, value: int) -> Mpf:
        return self.plain.context.ldexp(self.plain.context.mpf(value), -self.bits)


@dataclass(frozen=True)
class FloatingPoint:
    """Numbers of many digits, however large or small they are.

    Attributes:
        plain: their arithmetic.
    """

    plain: Multi

    def of(self, value: Mpf) -> Mpf:
        return value

    def product(self, total: Mpf) -> Mpf:
        return total

    def mean(self, total: Mpf, k: int) -> Mpf:
        return total / k

    def quotient(self, above: Mpf, total: Mpf, below: Mpf) -> Mpf:
        return (above - total) / below

    def root(self, value: Mpf) -> Mpf:
        return self.plain.unary("sqrt", value)

    def real(self, value: Mpf) -> Mpf:
        return value


@dataclass(frozen=True, eq=False)
class ConstantSeries:
    """A slot that does not change along the path."""

    value: Mpf


Slot = list[C] | ConstantSeries
"""Coefficients of s⁰, s¹, … as far as they are known; or a constant."""


@dataclass(eq=False)
class SeriesProgram(Generic[C]):
    """Operations on power series; the ``Arithmetic`` that a tape is compiled with.

    Attributes:
        numbers: what coefficients are.
        lines: k ↦ nothing; each appends the k-th coefficient of its series.
        series: all series, to be emptied before another expansion.
    """

    numbers: SeriesNumbers[C]
    lines: list[Callable[[int], None]] = field(default_factory=list)
    series: list[list[C]] = field(default_factory=list)

    def new(self) -> list[C]:
        """Make an empty series."""
        self.series.append([])
        return self.series[-1]

    def restart(self) -> None:
        """Forget all coefficients: the next are those at another place."""
        for series in self.series:
            series.clear()

    def extend(self, k: int) -> None:
        """Append the k-th coefficient of all that depends on the inputs, of which it is known."""
        for line in self.lines:
            line(k)

    def rational(self, numerator: int, denominator: int) -> Slot[C]:
        """Return a fraction: a series of one term."""
        return ConstantSeries(self.numbers.plain.rational(numerator, denominator))

    def pi(self) -> Slot[C]:
        """Give π."""
        return ConstantSeries(self.numbers.plain.pi())

    def add(self, x: Slot[C], y: Slot[C]) -> Slot[C]:
        """Return x + y."""
        return self._sum(x, y, 1)

    def sub(self, x: Slot[C], y: Slot[C]) -> Slot[C]:
        """Return x − y."""
        return self._sum(x, y, -1)

    def _sum(self, x: Slot[C], y: Slot[C], sign: int) -> Slot[C]:
        if isinstance(x, ConstantSeries) and isinstance(y, ConstantSeries):
            return ConstantSeries(x.value + sign * y.value)
        a, b, out = self.coefficients(x), self.coefficients(y), self.new()
        self.lines.append(lambda k: out.append(a(k) + sign * b(k)))
        return out

    def coefficients(self, x: Slot[C]) -> Callable[[int], C]:
        """Return the rule k ↦ the k-th coefficient of a slot.

        Args:
            x: constant or series.
        """
        if isinstance(x, ConstantSeries):
            value, zero = self.numbers.of(x.value), self.numbers.of(0 * x.value)
            return lambda k: zero if k else value
        return x.__getitem__

    def mul(self, x: Slot[C], y: Slot[C]) -> Slot[C]:
        """Return x·y, by Cauchy's product where both change."""
        product = self.numbers.product
        if isinstance(x, ConstantSeries) and isinstance(y, ConstantSeries):
            return ConstantSeries(x.value * y.value)
        out = self.new()
        if isinstance(x, list) and isinstance(y, list):
            self.lines.append(lambda k: out.append(product(sum(map(mul, x, y[k::-1])))))
            return out
        factor, other = (x, y) if isinstance(x, ConstantSeries) else (y, x)
        number, changing = self.numbers.of(of_kind(factor, ConstantSeries).value), of_kind(other, list)
        self.lines.append(lambda k: out.append(product(changing[k] * number)))
        return out

    def div(self, x: Slot[C], y: Slot[C]) -> Slot[C]:
        """Return w = x/y, by w₀ = x₀/y₀ and y₀ wₖ = xₖ − Σ wⱼ yₖ₋ⱼ."""
        if isinstance(y, ConstantSeries):
            return self.mul(x, ConstantSeries(1 / y.value))
        a, out, over = self.coefficients(x), self.new(), self.numbers.quotient
        self.lines.append(lambda k: out.append(over(a(k), sum(map(mul, out, y[k:0:-1])), y[0])))
        return out

    def power(self, x: Slot[C], n: int) -> Slot[C]:
        """Return a whole power, by products, so that a base that vanishes does no harm."""
        if isinstance(x, ConstantSeries):
            return ConstantSeries(x.value**n)
        base: Slot[C] = x
        result = by_squaring(self.mul, base, abs(n))
        return result if n > 0 else self.div(self.rational(1, 1), result)

    def unary(self, name: str, x: Slot[C]) -> Slot[C]:
        """Apply an elementary function, from the differential equation it satisfies."""
        if isinstance(x, ConstantSeries):
            return ConstantSeries(self.numbers.plain.unary(name, x.value))
        if name in QUOTIENTS:
            return quotient(self, name, x)
        if name in {"neg", "abs"}:
            out = self.new()
            self.lines.append(lambda k: out.append(-x[k] if name == "neg" or x[0] < 0 else x[k]))
            return out
        if name in {"sin", "cos", "sinh", "cosh"}:
            return self._circular(name, x)
        return self._root(x) if name == "sqrt" else self._exponential(x) if name == "exp" else self._integral(name, x)

    def _at(self, name: str, x: C) -> C:
        """Return a function of a leading coefficient."""
        return self.numbers.of(self.numbers.plain.unary(name, self.numbers.real(x)))

    def _root(self, x: list[C]) -> list[C]:
        """2 y₀ yₖ = xₖ − Σ yⱼ yₖ₋ⱼ, 0 < j < k."""
        out, numbers = self.new(), self.numbers

        def line(k: int) -> None:
            if k == 0 and x[0] <= 0:
                raise NotConvergedError("the Taylor series met a square root of zero")
            known = sum(map(mul, out[1:], out[k - 1 : 0 : -1]))
            out.append(numbers.quotient(x[k], known, 2 * out[0]) if k else numbers.root(x[0]))

        self.lines.append(line)
        return out

    def _exponential(self, x: list[C]) -> list[C]:
        """y′ = y x′."""
        out, slopes, mean = self.new(), self.new(), self.numbers.mean

        def line(k: int) -> None:
            if k:
                slopes.append(k * x[k])
            out.append(mean(sum(map(mul, slopes, out[k - 1 :: -1])), k) if k else self._at("exp", x[0]))

        self.lines.append(line)
        return out

    def _circular(self, name: str, x: list[C]) -> list[C]:
        """s′ = c x′, c′ = ∓s x′."""
        h = "h" if name.endswith("h") else ""
        sine, cosine, slopes, mean, sign = self.new(), self.new(), self.new(), self.numbers.mean, 1 if h else -1

        def line(k: int) -> None:
            if k == 0:
                sine.append(self._at(f"sin{h}", x[0]))
                cosine.append(self._at(f"cos{h}", x[0]))
                return
            slopes.append(k * x[k])
            new = mean(sum(map(mul, slopes, cosine[k - 1 :: -1])), k)
            cosine.append(mean(sign * sum(map(mul, slopes, sine[k - 1 :: -1])), k))
            sine.append(new)

        self.lines.append(line)
        return sine if name.startswith("sin") else cosine

    def _integral(self, name: str, x: list[C]) -> list[C]:
        """Solve g y′ = ±x′, the equation of the inverse functions."""
        one = self.rational(1, 1)
        square = self.mul(x, x) if name != "log" else x
        below = {
            "log": lambda: x, "atan": lambda: self.add(one, square), "atanh": lambda: self.sub(one, square),
            "asin": lambda: self.unary("sqrt", self.sub(one, square)),
            "acos": lambda: self.unary("sqrt", self.sub(one, square)),
            "asinh": lambda: self.unary("sqrt", self.add(one, square)),
            "acosh": lambda: self.unary("sqrt", self.sub(square, one)),
        }[name]  # fmt: skip
        g = of_kind(below(), list)
        out, slopes, sign = self.new(), self.new(), -1 if name == "acos" else 1

        def line(k: int) -> None:
            known = sum(map(mul, slopes, g[k - 1 : 0 : -1]))
            out.append(self.numbers.quotient(sign * k * x[k], known, k * g[0]) if k else self._at(name, x[0]))
            if k:
                slopes.append(k * out[k])

        self.lines.append(line)
        return out
