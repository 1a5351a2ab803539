"""Equations of motion solved by Taylor series to many digits: the witness that trajectories are measured against.

It shares nothing with the quadratures: no separation, no turning points, no time law. The right-hand side, a ``Tape``,
is run once over power series to give a program that appends one coefficient after the other (Jorba & Zou, Experimental
Mathematics 14 (2005) 99). Numbers are integers in units of 2^−P, and the k-th coefficient is that of hᵏ, so that all of
them are of the size of the state.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import mul

from hjsolve.arithmetic.floats import Multi, by_squaring
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError, NotConvergedError, of_kind

Series = list[int]
_LONGEST_STRETCH, _MOST_TRIALS, _TAIL, _PATIENCE = 1.25, 200, 8, 0.4


@dataclass(frozen=True, eq=False)
class ConstantSeries:
    """A slot that does not change along the motion."""

    value: Mpf


Slot = Series | ConstantSeries


@dataclass(eq=False)
class Program:
    """Operations on power series in fixed point; the ``Arithmetic`` that a tape is compiled with.

    Attributes:
        bits: P; numbers are integers in units of 2^−P.
        lines: k ↦ nothing; each appends the k-th coefficient of its series.
        series: all series, to be emptied before a step.
    """

    bits: int
    lines: list[Callable[[int], None]] = field(default_factory=list)
    series: list[Series] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.plain = Multi(self.bits)

    def new(self) -> Series:
        """Make an empty series."""
        self.series.append([])
        return self.series[-1]

    def fixed(self, value: Mpf) -> int:
        """Round a number to a multiple of 2^−P."""
        return int(self.plain.context.nint(self.plain.context.ldexp(value, self.bits)))

    def real(self, value: int) -> Mpf:
        """Return the number that a fixed-point integer means, as an mpf.

        Args:
            value: a multiple of 2^−P.
        """
        return self.plain.context.ldexp(self.plain.context.mpf(value), -self.bits)

    def rational(self, numerator: int, denominator: int) -> Slot:
        """Return a fraction: a series of one term."""
        return ConstantSeries(self.plain.rational(numerator, denominator))

    def pi(self) -> Slot:
        """Give π."""
        return ConstantSeries(self.plain.pi())

    def add(self, x: Slot, y: Slot) -> Slot:
        """Return x + y."""
        return self._sum(x, y, 1)

    def sub(self, x: Slot, y: Slot) -> Slot:
        """Return x − y."""
        return self._sum(x, y, -1)

    def _sum(self, x: Slot, y: Slot, sign: int) -> Slot:
        if isinstance(x, ConstantSeries) and isinstance(y, ConstantSeries):
            return ConstantSeries(x.value + sign * y.value)
        a, b, out = self.coefficients(x), self.coefficients(y), self.new()
        self.lines.append(lambda k: out.append(a(k) + sign * b(k)))
        return out

    def coefficients(self, x: Slot) -> Callable[[int], int]:
        """Return the rule k ↦ the k-th coefficient of a slot.

        Args:
            x: constant or series.
        """
        if isinstance(x, ConstantSeries):
            value = self.fixed(x.value)
            return lambda k: 0 if k else value
        return x.__getitem__

    def mul(self, x: Slot, y: Slot) -> Slot:
        """Return x·y, by Cauchy's product where both change."""
        bits = self.bits
        if isinstance(x, ConstantSeries) and isinstance(y, ConstantSeries):
            return ConstantSeries(x.value * y.value)
        out = self.new()
        if isinstance(x, list) and isinstance(y, list):
            self.lines.append(lambda k: out.append(sum(map(mul, x, y[k::-1])) >> bits))
            return out
        factor, other = (x, y) if isinstance(x, ConstantSeries) else (y, x)
        number, other = self.fixed(of_kind(factor, ConstantSeries).value), of_kind(other, list)
        self.lines.append(lambda k: out.append(other[k] * number >> bits))
        return out

    def div(self, x: Slot, y: Slot) -> Slot:
        """Return w = x/y, by w₀ = x₀/y₀ and y₀ wₖ = xₖ − Σ yⱼ wₖ₋ⱼ."""
        if isinstance(y, ConstantSeries):
            return self.mul(x, ConstantSeries(1 / y.value))
        a, out, bits = self.coefficients(x), self.new(), self.bits

        def line(k: int) -> None:
            known = sum(map(mul, y[1:], out[k - 1 :: -1])) if k else 0
            out.append(((a(k) << bits) - known) // y[0])

        self.lines.append(line)
        return out

    def power(self, x: Slot, n: int) -> Slot:
        """Return a whole power, by products, so that a base that vanishes does no harm."""
        if isinstance(x, ConstantSeries):
            return ConstantSeries(x.value**n)
        base: Slot = x
        result = by_squaring(self.mul, base, abs(n))
        return result if n > 0 else self.div(self.rational(1, 1), result)

    def unary(self, name: str, x: Slot) -> Slot:
        """Apply an elementary function, from the differential equation it satisfies."""
        if isinstance(x, ConstantSeries):
            return ConstantSeries(self.plain.unary(name, x.value))
        if name in ("sin", "cos", "tan", "sinh", "cosh", "tanh"):
            return self._circular(name, x)
        if name == "sech":
            return self.div(self.rational(1, 1), self._circular("cosh", x))
        if name in ("neg", "abs"):
            out = self.new()
            self.lines.append(lambda k: out.append(-x[k] if name == "neg" or x[0] < 0 else x[k]))
            return out
        if name == "sqrt":
            return self._root(x)
        return self._exponential(x) if name == "exp" else self._integral(name, x)

    def _root(self, x: Series) -> Series:
        out, bits = self.new(), self.bits

        def line(k: int) -> None:
            if k == 0:
                if x[0] <= 0:
                    raise NotConvergedError("the Taylor series met a square root of zero")
                out.append(math.isqrt(x[0] << bits))
                return
            known = sum(map(mul, out[1:], out[k - 1 : 0 : -1]))
            out.append(((x[k] << bits) - known) // (2 * out[0]))

        self.lines.append(line)
        return out

    def _exponential(self, x: Series) -> Series:
        out, slopes, bits = self.new(), self.new(), self.bits

        def line(k: int) -> None:
            if k == 0:
                out.append(self.fixed(self.plain.unary("exp", self.real(x[0]))))
                return
            slopes.append(k * x[k])
            out.append((sum(map(mul, slopes, out[k - 1 :: -1])) // k) >> bits)

        self.lines.append(line)
        return out

    def _circular(self, name: str, x: Series) -> Slot:
        """s′ = c x′, c′ = ∓s x′."""
        h = "h" if name.endswith("h") else ""
        sine, cosine, slopes, bits, sign = self.new(), self.new(), self.new(), self.bits, 1 if h else -1

        def line(k: int) -> None:
            if k == 0:
                at = self.real(x[0])
                sine.append(self.fixed(self.plain.unary(f"sin{h}", at)))
                cosine.append(self.fixed(self.plain.unary(f"cos{h}", at)))
                return
            slopes.append(k * x[k])
            new = sum(map(mul, slopes, cosine[k - 1 :: -1])) // k >> bits
            cosine.append(sign * sum(map(mul, slopes, sine[k - 1 :: -1])) // k >> bits)
            sine.append(new)

        self.lines.append(line)
        plain = name.removesuffix("h")
        return sine if plain == "sin" else cosine if plain == "cos" else self.div(sine, cosine)

    def _integral(self, name: str, x: Series) -> Series:
        """w′ = ±x′/g for the inverse functions."""
        one, square = self.rational(1, 1), self.mul(x, x) if name != "log" else x
        below = {
            "log": lambda: x, "atan": lambda: self.add(one, square), "atanh": lambda: self.sub(one, square),
            "asin": lambda: self.unary("sqrt", self.sub(one, square)),
            "acos": lambda: self.unary("sqrt", self.sub(one, square)),
            "asinh": lambda: self.unary("sqrt", self.add(one, square)),
            "acosh": lambda: self.unary("sqrt", self.sub(square, one)),
        }.get(name)  # fmt: skip
        if below is None:
            raise InvalidInputError(f"{name}: has no Taylor series here")
        g = of_kind(below(), list)
        out, slopes, bits, sign = self.new(), self.new(), self.bits, -1 if name == "acos" else 1

        def line(k: int) -> None:
            if k == 0:
                out.append(self.fixed(self.plain.unary(name, self.real(x[0]))))
                return
            known = sum(map(mul, slopes, g[k - 1 : 0 : -1]))
            out.append(((sign * k * x[k] << bits) - known) // (k * g[0]))
            slopes.append(k * out[k])

        self.lines.append(line)
        return out


def follow(slopes: Tape, start: Mpf, state: Sequence[Mpf], constants: Sequence[Mpf], times: Sequence[Mpf], digits: int,
           *, deadline: float = math.inf) -> list[list[Mpf]]:  # fmt: skip
    """Solve y′ = f(y) and give y at given times.

    Args:
        slopes: f; its inputs are the state and then the constants.
        start: the initial time, mpf.
        state: y there, mpf, length n.
        constants: mpf.
        times: mpf, in increasing distance from the start, all on one side of it.
        digits: decimal digits of a step.
        deadline: the moment of ``time.perf_counter`` by which to be done; given up as soon as that cannot be.

    Returns:
        y at the times reached, mpf; fewer than asked where the deadline came first.

    Raises:
        NotConvergedError: the solution runs into a singularity.
        InvalidInputError: the right-hand side holds a function without a series.
    """
    order = math.ceil(digits * math.log(10) / 2) + 2
    sizes = [abs(float(y)) for y in state if y]
    small = max(0, -math.frexp(min(sizes))[1]) if sizes else 0
    program = Program(math.ceil(3.33 * digits) + order // 3 + 64 + small)
    inputs = [program.new() for _ in state]
    slots: list[Slot] = [*inputs, *(ConstantSeries(program.plain.convert(c)) for c in constants)]
    rates = slopes.run(program, slots)
    derivatives = [program.coefficients(rate) for rate in rates]
    values, now, found = [program.fixed(y) for y in state], program.plain.convert(start), list[list[Mpf]]()
    step = _first_step(program, times, now)
    begun, far = time.perf_counter(), max((abs(t - now) for t in times), default=0)
    for goal in times:
        while now != goal:
            spent, gone = time.perf_counter() - begun, abs(now - start)
            if spent > _PATIENCE and (not gone or begun + spent * float(far / gone) > deadline):
                return found
            values, now, step = _stepped(program, inputs, derivatives, order, digits, values, now, goal, step)
        found.append([program.real(value) for value in values])
    return found


def _first_step(program: Program, times: Sequence[Mpf], now: Mpf) -> Mpf:
    ahead = [t - now for t in times if t != now]
    return program.plain.context.convert(ahead[0] / 1024) if ahead else program.plain.context.mpf(1)


def _stepped(program: Program, inputs: list[Series], derivatives: list[Callable[[int], int]], order: int, digits: int,
             values: Series, now: Mpf, goal: Mpf, step: Mpf) -> tuple[Series, Mpf, Mpf]:  # fmt: skip
    """One step towards the goal, as long as the series of the state allows."""
    left = goal - now
    for _ in range(_MOST_TRIALS):
        try:
            _expand(program, inputs, derivatives, order, values, program.fixed(step))
        except ZeroDivisionError:
            raise NotConvergedError("the Taylor series met a division by zero") from None
        reach = _reach(inputs, order, digits)
        if reach <= _LONGEST_STRETCH or abs(left) <= abs(step):
            break
        step = step * min(reach, 1024.0)
    part = min(reach, _LONGEST_STRETCH)
    if part * abs(float(step)) < 1e-12 * max(1e-3, abs(float(now)), abs(float(left))):
        raise NotConvergedError(f"the Taylor series stops near t = {float(now):.12g}")
    last = abs(left) <= abs(step) * part
    ratio = program.fixed(left / step if last else program.plain.context.mpf(part))
    result = []
    for series in inputs:
        total = 0
        for coefficient in reversed(series):
            total = (total * ratio >> program.bits) + coefficient
        result.append(total)
    longer = step * part
    return result, (goal if last else now + program.real(ratio) * step), longer


def _expand(program: Program, inputs: list[Series], derivatives: list[Callable[[int], int]], order: int,
            values: Series, step: int) -> None:  # fmt: skip
    """All coefficients of one step."""
    for series in program.series:
        series.clear()
    for series, value in zip(inputs, values):
        series.append(value)
    for k in range(order):
        for line in program.lines:
            line(k)
        for series, derivative in zip(inputs, derivatives):
            series.append(derivative(k) * step // (k + 1) >> program.bits)


def _reach(inputs: list[Series], order: int, digits: int) -> float:
    """Return how many steps long the step may be so that the last terms are negligible; ∞ for a polynomial.

    Two terms are too few: by symmetry several in a row may vanish (a pendulum released at 90°: three of four).
    """
    scale = math.log2(max(1, *(abs(series[0]) for series in inputs)))
    goal = scale - digits * math.log2(10)
    bounds = []
    for k in range(order - _TAIL, order + 1):
        size = max(abs(series[k]) for series in inputs)
        if size > 1:
            bounds.append(2 ** ((goal - math.log2(size)) / k))
    return min(bounds, default=math.inf)
