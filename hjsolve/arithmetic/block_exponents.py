"""A formula in other units: every value is b + v̂·2^e, with the number b and the exponent e known beforehand.

As in block floating point, products and powers only add exponents; what is smaller in a sum is multiplied by the power
of two between the two. So where r is 1e-90, 1/r² and its derivatives are numbers of order one. Powers of two do not
round.

A value that hardly differs from a number b is kept as the difference, which has all its digits: √(1 + r²) is
1 + r²/(√(1 + r²) + 1), and E − V(r) of an orbit at the bottom of a well keeps what is left of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import frexp, ldexp
from typing import NamedTuple

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import Operation, Tape

_LIKE_X = frozenset({"tan", "asin", "atan", "sinh", "tanh", "asinh", "atanh", "sin"})
"""Odd functions whose slope at zero is 1."""

NOTHING = -(1 << 24)
"""Exponent of zero: smaller than that of any number, and still so after roots and products."""

_LEAST_EXPONENT, _MOST_EXPONENT = -4096, 1023
"""Exponents of factors: what is smaller is nothing next to the other term of a sum; what is larger has no double."""

_BASES = Multi(3072)
"""Bits of the numbers b: what is left of two that cancel is nothing next to the smallest double, or they differ."""

_CANCELLED_BITS = 2048
_SMALL_BITS = 8
"""A difference is kept apart from b where it is this many bits smaller."""

_WRITTEN_BITS = 320
"""Of b as a constant of the new tape."""


class Scaled(NamedTuple):
    """A slot of the new tape that holds a number over 2^exponent."""

    slot: int
    exponent: int


class Value(NamedTuple):
    """A value base + part, or a constant, whose part is the whole of it."""

    base: Mpf
    part: Scaled
    constant: bool = False


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

    # --------------------------------------------------------------------------------------------- numbers of the tape
    def _line(self, code: str, *operands: int, payload: tuple[int, ...] = ()) -> int:
        self.operations.append(Operation(code, operands, payload))
        return self._inputs + len(self.operations) - 1

    def at(self, x: Scaled, exponent: int) -> int:
        """Return the slot of x over 2^exponent.

        Args:
            exponent: of the unit asked for.
        """
        shift = x.exponent - exponent
        if shift == 0:
            return x.slot
        shift = min(max(shift, _LEAST_EXPONENT), _MOST_EXPONENT)
        factor = self._line("rational", payload=(1 << shift, 1) if shift > 0 else (1, 1 << -shift))
        return self._line("mul", x.slot, factor)

    def _fraction(self, numerator: int, denominator: int) -> Scaled:
        if numerator == 0:
            return Scaled(self._line("rational", payload=(0, 1)), NOTHING)
        e = abs(numerator).bit_length() - denominator.bit_length()
        payload = (numerator, denominator << e) if e > 0 else (numerator << -e, denominator)
        return Scaled(self._line("rational", payload=payload), e)

    def _written(self, base: Mpf) -> Scaled:
        mantissa, e = _BASES.context.frexp(base)
        found = self._fraction(int(_BASES.context.ldexp(mantissa, _WRITTEN_BITS)), 1 << _WRITTEN_BITS)
        return Scaled(found.slot, found.exponent + e)

    def _sum(self, code: str, x: Scaled, y: Scaled) -> Scaled:
        e = max(x.exponent, y.exponent)
        return Scaled(self._line(code, self.at(x, e), self.at(y, e)), e)

    def _product(self, x: Scaled, y: Scaled) -> Scaled:
        return Scaled(self._line("mul", x.slot, y.slot), x.exponent + y.exponent)

    def _quotient(self, x: Scaled, y: Scaled) -> Scaled:
        return Scaled(self._line("div", x.slot, y.slot), x.exponent - y.exponent)

    def _function(self, name: str, x: Scaled, exponent: int = 0) -> Scaled:
        """Write a function of a number; ``exponent`` is that of the result, about."""
        if name in {"neg", "abs"}:
            return Scaled(self._line(name, x.slot), x.exponent)
        half = x.exponent // 2 if name == "sqrt" else 0
        found = Scaled(self._line(name, self.at(x, 2 * half)), half)
        return Scaled(self.at(found, exponent), exponent) if exponent else found

    # --------------------------------------------------------------------------------------------- values
    def known(self, slot: int, value: Fraction) -> Value:
        """Return an input that is the same for all orbits.

        Args:
            slot: of the input, over the power of two of ``exponent_of``.
        """
        return Value(_BASES.convert(value), Scaled(slot, exponent_of(float(value))), constant=True)

    def whole(self, x: Value) -> Scaled:
        """Return a value as one number."""
        return x.part if x.constant or x.base == 0 else self._sum("add", self._written(x.base), x.part)

    def _near(self, base: Mpf, part: Scaled) -> Value:
        """Return base + part; one number where the part is not small."""
        found = Value(base, part)
        if base == 0 or part.exponent <= _BASES.context.mag(base) - _SMALL_BITS:
            return found
        return Value(_BASES.convert(0), self.whole(found))

    def _bases(self, code: str, x: Mpf, y: Mpf) -> Mpf:
        found = x + y if code == "add" else x - y
        return _BASES.convert(0) if abs(found) < _BASES.context.ldexp(abs(x) + abs(y), -_CANCELLED_BITS) else found

    def _added(self, code: str, x: Value, y: Value) -> Value:
        base = self._bases(code, x.base, y.base)
        if x.constant and y.constant:
            return Value(base, self._sum(code, x.part, y.part) if base else self._fraction(0, 1), constant=True)
        if x.constant:
            return self._near(base, y.part if code == "add" else self._function("neg", y.part))
        return self._near(base, x.part if y.constant else self._sum(code, x.part, y.part))

    def rational(self, numerator: int, denominator: int) -> Value:
        return Value(_BASES.rational(numerator, denominator), self._fraction(numerator, denominator), constant=True)

    def pi(self) -> Value:
        return Value(_BASES.pi(), Scaled(self._line("pi"), 0), constant=True)

    def add(self, x: Value, y: Value) -> Value:
        return self._added("add", x, y)

    def sub(self, x: Value, y: Value) -> Value:
        return self._added("sub", x, y)

    def mul(self, x: Value, y: Value) -> Value:
        if x.constant or y.constant:
            return Value(x.base * y.base, self._product(x.part, y.part), x.constant and y.constant)
        part = self._product(x.part, y.part)
        for number, other in ((x, y), (y, x)):
            if number.base:
                part = self._sum("add", part, self._product(self._written(number.base), other.part))
        return self._near(x.base * y.base, part)

    def div(self, x: Value, y: Value) -> Value:
        if y.constant:
            base = x.base / y.base if x.base else x.base
            return Value(base, self._quotient(x.part, y.part), x.constant)
        if y.base == 0:
            return Value(y.base, self._quotient(self.whole(x), y.part))
        below = self._product(self._written(y.base), self.whole(y))  # 1/(b + r) = 1/b − r/(b (b + r))
        return self.mul(x, self._near(1 / y.base, self._quotient(self._function("neg", y.part), below)))

    def power(self, x: Value, n: int) -> Value:
        if x.constant or x.base == 0:
            part = Scaled(self._line("power", x.part.slot, payload=(n,)), n * x.part.exponent)
            return Value(x.base**n if x.base else x.base, part, x.constant)
        if n < 0:
            return self.div(self.rational(1, 1), self.power(x, -n))
        found = x
        for _ in range(n - 1):
            found = self.mul(found, x)
        return found

    def unary(self, name: str, x: Value) -> Value:
        if x.constant:
            return Value(_BASES.unary(name, x.base), self._function(name, x.part), constant=True)
        if name == "neg" or (name == "abs" and x.base):
            turned = name == "neg" or x.base < 0
            return Value(-x.base, self._function("neg", x.part)) if turned else x
        small = x.base != 0 or 2 * x.part.exponent <= -_SMALL_BITS
        if name in _LIKE_X and x.base == 0 and small:
            return Value(x.base, self._of_small(name, x.part))
        rule = _DIFFERENCES.get(name) if small and (x.base or name not in {"sqrt", "log"}) else None
        if rule is None:
            return Value(_BASES.convert(0), self._function(name, self.whole(x)))
        return self._near(_BASES.unary(name, x.base), rule(self, x))

    # --------------------------------------------------------------------------------------------- f(b + r) − f(b)
    def _times(self, factor: Mpf, x: Scaled) -> Scaled:
        return self._product(self._written(factor), x)

    def _half(self, x: Scaled) -> Scaled:
        return Scaled(x.slot, x.exponent - 1)

    def _of_small(self, name: str, x: Scaled) -> Scaled:
        """Write an odd function whose slope at zero is 1, of a small number."""
        return self._function(name, x, x.exponent)

    def of_root(self, x: Value) -> Scaled:
        """√(b + r) − √b = r/(√(b + r) + √b)."""
        root = self._function("sqrt", self.whole(x))
        return self._quotient(x.part, self._sum("add", root, self._written(_BASES.unary("sqrt", x.base))))

    def of_exponential(self, x: Value) -> Scaled:
        """e^(b + r) − e^b = 2 e^b e^(r/2) sinh(r/2)."""
        half = self._half(x.part)
        product = self._product(self._of_small("sinh", half), self._function("exp", half))
        return self._times(2 * _BASES.unary("exp", x.base), product)

    def of_logarithm(self, x: Value) -> Scaled:
        """log(b + r) − log b = 2 arsinh(r/(2 √(b (b + r))))."""
        root = self._function("sqrt", self._times(x.base, self.whole(x)))
        return self._times(_BASES.convert(2), self._of_small("asinh", self._quotient(self._half(x.part), root)))

    def of_wave(self, name: str, x: Value) -> Scaled:
        """Return sin(b + r) − sin b = 2 sin(r/2) cos(b + r/2); other waves alike.

        Args:
            name: of the function, sin, cos, sinh or cosh.
        """
        tail, half = "h" if name.endswith("h") else "", self._half(x.part)
        middle = self._sum("add", self._written(x.base), half) if x.base else half
        other = {"sin": "cos", "cos": "sin"}[name.removesuffix("h")] + tail
        factor = self._function(other, middle) if x.base or other.startswith("cos") else self._of_small(other, middle)
        return self._times(
            _BASES.convert(-2 if name == "cos" else 2), self._product(self._of_small("sin" + tail, half), factor)
        )


def _wave(name: str) -> Callable[[InUnits, Value], Scaled]:
    return lambda units, x: units.of_wave(name, x)


_DIFFERENCES: dict[str, Callable[[InUnits, Value], Scaled]] = {
    "sqrt": InUnits.of_root,
    "exp": InUnits.of_exponential,
    "log": InUnits.of_logarithm,
    **{name: _wave(name) for name in ("sin", "cos", "sinh", "cosh")},
}


class Results(NamedTuple):
    """What a formula gives in other units: result k is bases[k] + output k · 2^exponents[k]."""

    tape: Tape
    bases: list[Mpf]
    exponents: list[int]


class Unit(NamedTuple):
    """What is known of an input: it is base + x̂·2^exponent, or the number ``value`` for all."""

    exponent: int = 0
    base: Mpf | int = 0
    value: Fraction | None = None


def unit_of(number: Pair) -> Unit:
    """Return what is known of a parameter.

    Args:
        number: in two doubles.
    """
    return Unit(value=sum(map(Fraction, number), Fraction(0)))


def over_power_of_two(number: Pair, exponent: int | None = None) -> Pair:
    """Return a number over a power of two.

    Args:
        number: in two doubles.
        exponent: of two; None for that of a parameter.
    """
    e = exponent_of(number.high) if exponent is None else exponent
    return Pair(*(ldexp(part, -e) if part else 0.0 for part in map(float, number)))


def tape_in_units(tape: Tape, inputs: Sequence[Unit], wanted: Sequence[int] | None = None) -> Results:
    """Return the formulas of a tape as functions of its inputs in other units.

    Args:
        tape: the formulas.
        inputs: the units.
        wanted: an exponent for each result, which then has no base; None for bases and exponents that come of
            themselves, which no result exceeds by much.
    """
    units = InUnits(len(tape.inputs))
    start = [
        Value(_BASES.convert(u.base), Scaled(k, u.exponent)) if u.value is None else units.known(k, u.value)
        for k, u in enumerate(inputs)
    ]
    found = tape.run(units, start)
    if wanted is None:
        bases = [_BASES.convert(0) if x.constant else x.base for x in found]
        exponents = [x.part.exponent for x in found]
        slots = [x.part.slot for x in found]
    else:
        bases, exponents = [_BASES.convert(0) for _ in found], list(wanted)
        slots = [units.at(units.whole(x), e) for x, e in zip(found, wanted, strict=True)]
    lines = Tape(tape.inputs, tuple(units.operations), tuple(slots))
    return Results(lines.only(*range(len(slots))), bases, exponents)
