"""The two plain arithmetics: numpy floats and any number of digits."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar, TypeVar, cast

import numpy as np

from hjsolve import precision
from hjsolve.algebra.ranges import CIRCULAR, FARTHEST
from hjsolve.arithmetic.number_types import Context, Elementwise, Mpf, N, Numeric, Truth, X
from hjsolve.errors import InvalidInputError

A = TypeVar("A")
"""Whatever there is to choose from."""
_NUMPY_NAMES = {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "asinh": "arcsinh",
    "acosh": "arccosh",
    "atanh": "arctanh",
    "neg": "negative",
    "abs": "absolute",
}


EPS = 2.0**-52
"""From 1 to the next double; rounding of a result is half of it, relatively."""
GREATEST = float(np.finfo(float).max)
"""The greatest double."""
UNIT = 2.0**-53
"""The unit roundoff: half of ``EPS``, the relative error of one rounding to the nearest double at most."""
_COSTLY = dict.fromkeys(("exp", "sinh", "cosh", "tanh"), FARTHEST) | dict.fromkeys(CIRCULAR, 16 * FARTHEST)


class ByOperators:
    """The four operations as Python writes them."""

    __slots__ = ()

    add = staticmethod(operator.add)
    sub = staticmethod(operator.sub)
    mul = staticmethod(operator.mul)
    div = staticmethod(operator.truediv)


def multiprecision(bits: int) -> Context:
    """Return an mpmath context of its own with this precision, so that no global is touched."""
    context: Context = precision.multiprecision(bits)
    return context


def context_of(x: Elementwise) -> Context | None:
    """Return where a number of many digits is computed with; None of doubles and arrays of them.

    Args:
        x: one number of any plain arithmetic, or an array of doubles.
    """
    return getattr(x, "context", None)


def by_squaring(product: Callable[[N, N], N], x: N, n: int) -> N:
    """Return xⁿ, n ≥ 1, by the fewest products that squaring gives.

    Args:
        product: multiplies two of them.
    """
    result = x
    for bit in bin(n)[3:]:
        result = product(result, result)
        if bit == "1":
            result = product(result, x)
    return result


@dataclass(frozen=True, slots=True)
class Float64(ByOperators):
    """Double precision, elementwise over numpy arrays of any shape.

    Beside what every arithmetic has, the plain ones choose between two numbers (``where``), round to whole numbers
    (``rint``), and have the angle of a point (``atan2``) and the size of one number with the sign of another.
    ``minimum_keeps_nan``: whether the lesser of nan and a number is nan in an array of theirs.
    """

    bits: ClassVar[int] = 53
    minimum_keeps_nan: ClassVar[bool] = True
    few_units: ClassVar[float] = 4 * EPS
    """More than any operation rounds by, relatively."""

    def rational(self, numerator: int, denominator: int) -> Elementwise:
        """Return the double next to a fraction."""
        return float(Fraction(numerator, denominator))

    def pi(self) -> Elementwise:
        return np.pi

    def power(self, x: Elementwise, n: int) -> Elementwise:
        """Return xⁿ, elementwise; small powers are products."""
        return np.float_power(x, n) if abs(n) > 3 else _small_power(x, n)

    def unary(self, name: str, x: Elementwise) -> Elementwise:
        """Return a function of x, elementwise; nan outside its domain."""
        return sech(x) if name == "sech" else getattr(np, _NUMPY_NAMES.get(name, name))(x)

    def where(self, condition: Truth, x: Elementwise, y: Elementwise) -> Elementwise:
        """Return x where a condition holds, y elsewhere.

        Args:
            condition: one truth value or an array of them.
            x, y: doubles or arrays of doubles that broadcast with it.
        """
        chosen: Elementwise = np.where(condition, x, y)
        return chosen[()]  # one number stays a number

    def rint(self, x: Elementwise) -> Elementwise:
        """Return the nearest whole number, elementwise."""
        return np.rint(x)

    def atan2(self, y: Elementwise, x: Elementwise) -> Elementwise:
        """Return the angle of the point (x, y) in radians, −π … π."""
        return np.arctan2(y, x)

    def copysign(self, size: Elementwise, sign: Elementwise) -> Elementwise:
        """Return a size with the sign of another number, that of a zero included."""
        return np.copysign(size, sign)

    def choose(self, doubles: Callable[[Float64], A], many: Callable[[Multi], A]) -> A:  # noqa: ARG002
        """Return what a rule for doubles gives, where the algorithm for many digits is another one.

        Args:
            doubles: rule for arrays of doubles.
            many: rule for numbers of many digits.
        """
        return doubles(self)

    def held(self, x: float | Mpf) -> tuple[Elementwise, bool]:
        """Return a number as arrays hold it, and whether nothing was rounded.

        Args:
            x: a float, or a number of many digits.
        """
        nearest = float(x)
        return np.float64(nearest), nearest == x

    def widened(self, low: Elementwise, high: Elementwise) -> tuple[Elementwise, Elementwise]:
        """Return ends moved outward by more than the rounding of an operation; what overflowed is finite."""
        low, high = np.minimum(low, GREATEST), np.maximum(high, -GREATEST)
        return low - (self.few_units * abs(low) + 1e-300), high + (self.few_units * abs(high) + 1e-300)

    def over_array(self, name: str, x: Elementwise) -> Elementwise:
        """Return a function elementwise, nan where it is not real.

        Args:
            name: of the function, such as ``sqrt``.
        """
        return self.unary(name, x)


def sech(x: Elementwise) -> Elementwise:
    """Return 1/cosh x of doubles, which does not overflow."""
    decay = np.exp(-np.abs(x))
    return 2 * decay / (1 + decay * decay)


class ComplexPoints(Float64):
    """Complex doubles, where a few digits are enough; functions are the analytic ones that formulas on the line mean.

    Comparisons are those of numpy, which orders complex numbers by their real parts.
    """

    __slots__ = ()

    def unary(self, name: str, x: Elementwise) -> Elementwise:
        """Return a function of one variable."""
        if name == "turned":
            return 1j * x
        if name == "abs":  # the analytic function ±z
            return np.where(np.real(x) < 0, -x, x)
        if name == "sech":
            decay = np.exp(np.where(np.real(x) < 0, x, -x))
            return 2 * decay / (1 + decay * decay)
        return Float64().unary(name, np.asarray(x, dtype=complex))

    def power(self, x: Elementwise, n: int) -> Elementwise:
        """Return xⁿ."""
        return x**n

    def rint(self, x: Elementwise) -> Elementwise:
        """Return the whole number nearest to the real part."""
        return np.rint(np.real(x))

    def atan2(self, y: Elementwise, x: Elementwise) -> Elementwise:
        """Return the angle φ of x + iy = r e^{iφ} for complex x and y, r² = x² + y²."""
        return -1j * np.log((x + 1j * y) / np.sqrt(x * x + y * y))

    def copysign(self, size: Elementwise, sign: Elementwise) -> Elementwise:
        """Return a size with the sign of the real part of another number."""
        return np.where(np.real(sign) < 0, -size, size)


def _small_power(x: Elementwise, n: int) -> Elementwise:
    y = x * x if abs(n) == 2 else x * x * x if abs(n) == 3 else x
    return y if n > 0 else 1.0 / y


def bits_for(digits: int, guard: int) -> int:
    """Return the bits of so many decimal digits (log₂ 10 < 3.33), and some to spare for what is lost on the way."""
    return int(3.33 * digits) + guard


def within_reach(name: str, x: Numeric, context: Context) -> Numeric:
    """Return an argument, that of an exponential at most 2**FARTHEST.

    Beyond, as many digits as it has bits would be needed.

    Args:
        x: its argument, mpmath's number.

    Raises:
        InvalidInputError: a circular function of so large an argument.
    """
    if name not in _COSTLY or context.mag(x) <= _COSTLY[name]:
        return x
    farthest = _COSTLY[name]
    if name in CIRCULAR:
        raise InvalidInputError(
            f"{name} of a number beyond 2**{farthest}: give the coordinate a domain that ends before"
        )
    edge = context.ldexp(1, farthest)
    return edge if x > 0 else -edge


@dataclass(frozen=True, slots=True)
class Multi(ByOperators):
    """Scalars of a chosen precision.

    Attributes:
        bits: binary digits of the working precision.
    """

    bits: int
    minimum_keeps_nan: ClassVar[bool] = False
    context: Context = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "context", multiprecision(self.bits))

    def __reduce__(self) -> tuple[type[Multi], tuple[int]]:
        return Multi, (self.bits,)

    @property
    def few_units(self) -> Mpf:
        """More than any operation rounds by, relatively."""
        return cast("Mpf", self.context.mpf(2) ** (3 - self.bits))

    def convert(self, value: object) -> Mpf:
        """Take an int, float, Fraction or mpf in; the value is rounded to the precision.

        Args:
            value: an int, float, Fraction or ``mpf``.
        """
        if isinstance(value, Fraction):
            return self.context.mpf(value.numerator) / value.denominator
        return +self.context.convert(value)

    def rational(self, numerator: int, denominator: int) -> Mpf:
        """Return a fraction, rounded to the precision."""
        return self.context.mpf(numerator) / denominator

    def pi(self) -> Mpf:
        return +self.context.pi

    def power(self, x: Numeric, n: int) -> Mpf:
        """Return xⁿ."""
        return cast("Mpf", x**n)

    def unary(self, name: str, x: Numeric) -> Mpf:
        """Return a function of one variable at a number.

        Raises:
            InvalidInputError: the value is not real, or beyond the range of numbers.
        """
        if name == "neg":
            return cast("Mpf", -x)
        value = abs(x) if name == "abs" else getattr(self.context, name)(within_reach(name, x, self.context))
        if isinstance(value, self.context.mpc):
            raise InvalidInputError(
                f"{name} of {self.context.nstr(x, 8)} is not real: the formula leaves its domain there"
            )
        return cast("Mpf", value)

    def where(self, condition: Truth, x: X, y: X) -> X:
        """Return x where a condition holds, y elsewhere."""
        return x if condition else y

    def rint(self, x: Numeric) -> Mpf:
        """Return the nearest whole number."""
        return self.context.nint(x)

    def atan2(self, y: Numeric, x: Numeric) -> Mpf:
        """Return the angle of the point (x, y) in radians, −π … π."""
        return self.context.atan2(y, x)

    def copysign(self, size: X, sign: Numeric) -> X:
        """Return a size with the sign of another number; a zero counts as positive."""
        return -size if sign < 0 else size

    def choose(self, doubles: Callable[[Float64], A], many: Callable[[Multi], A]) -> A:  # noqa: ARG002
        """Return what a rule for many digits gives, where the algorithm for doubles is another one."""
        return many(self)

    def held(self, x: float | Mpf) -> tuple[Elementwise, bool]:
        """Return a number as arrays hold it, and whether nothing was rounded."""
        return np.array(x, dtype=object), True

    def widened(self, low: Elementwise, high: Elementwise) -> tuple[Elementwise, Elementwise]:
        """Return ends moved outward by more than the rounding of an operation."""
        return low - abs(low) * self.few_units, high + abs(high) * self.few_units

    def over_array(self, name: str, x: Elementwise) -> Elementwise:
        """Return a function elementwise, nan where it is not real or too large to be known."""
        return np.frompyfunc(lambda v: self._real_or_nan(name, v), 1, 1)(x)

    def _real_or_nan(self, name: str, v: Mpf) -> Mpf:
        context = self.context
        if name in {"sin", "cos"} and (context.isinf(v) or context.mag(v) > 16 * FARTHEST):
            return context.nan
        # an infinite end has its limit, e^(−∞) = 0: that of the farthest number in reach would lie inside the range
        value = getattr(context, name)(v if context.isinf(v) else within_reach(name, v, context))
        return cast("Mpf", value) if isinstance(value, context.mpf) else context.nan
