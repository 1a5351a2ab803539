"""The two plain arithmetics: numpy floats and any number of digits."""

from __future__ import annotations

import copyreg
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np

from hjsolve.errors import InvalidInputError

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
FARTHEST = 1024
"""Binary digits before the point of the largest argument of an exponential; many more of a circular function."""
CIRCULAR = ("sin", "cos", "tan")
_COSTLY = dict.fromkeys(("exp", "sinh", "cosh", "tanh"), FARTHEST) | dict.fromkeys(CIRCULAR, 16 * FARTHEST)


class ByOperators:
    """The four operations as Python writes them."""

    __slots__ = ()

    add = staticmethod(operator.add)
    sub = staticmethod(operator.sub)
    mul = staticmethod(operator.mul)
    div = staticmethod(operator.truediv)


def by_squaring(product: Callable[[Any, Any], Any], x: Any, n: int) -> Any:
    """Return xⁿ, n ≥ 1, by the fewest products that squaring gives.

    Args:
        product: multiplies two of them.
        x: the base.
        n: the exponent.
    """
    result = x
    for bit in bin(n)[3:]:
        result = product(result, result)
        if bit == "1":
            result = product(result, x)
    return result


@dataclass(frozen=True, slots=True)
class Float64(ByOperators):
    """Double precision, elementwise over numpy arrays of any shape."""

    def rational(self, numerator: int, denominator: int) -> Any:
        return float(Fraction(numerator, denominator))

    def pi(self) -> Any:
        return np.pi

    def power(self, x: Any, n: int) -> Any:
        return np.float_power(x, n) if abs(n) > 3 else _small_power(x, n)

    def unary(self, name: str, x: Any) -> Any:
        return sech(x) if name == "sech" else getattr(np, _NUMPY_NAMES.get(name, name))(x)


def sech(x: Any) -> Any:
    """Return 1/cosh x of doubles, which does not overflow."""
    decay = np.exp(-np.abs(x))
    return 2 * decay / (1 + decay * decay)


def _small_power(x: Any, n: int) -> Any:
    y = x * x if abs(n) == 2 else x * x * x if abs(n) == 3 else x
    return y if n > 0 else 1.0 / y


def bits_for(digits: int, guard: int) -> int:
    """Return the bits of so many decimal digits (log₂ 10 < 3.33), and some to spare for what is lost on the way.

    Args:
        digits: decimal digits.
        guard: bits to spare.
    """
    return int(3.33 * digits) + guard


@cache
def multiprecision(bits: int) -> Any:
    """Return an mpmath context of its own with this precision, so that no global is touched.

    Args:
        bits: binary digits.
    """
    context = mpmath.ctx_mp.MPContext()
    context.prec = bits
    for kind in (context.mpf, context.mpc):  # classes of their own, which pickle does not find by their names
        copyreg.pickle(kind, _reduced)
    copyreg.pickle(context.matrix, _reduced_matrix)
    return context


def _reduced(x: Any) -> tuple[Any, ...]:
    """What a number of one of our contexts is pickled as: its precision and its parts."""
    parts = (x._mpf_,) if hasattr(x, "_mpf_") else x._mpc_
    return _restored, (x.context.prec, *(tuple(int(part) for part in number) for number in parts))


def _reduced_matrix(matrix: Any) -> tuple[Any, ...]:
    return _restored_matrix, (matrix.ctx.prec, matrix.tolist())


def _restored_matrix(bits: int, rows: list[list[Any]]) -> Any:
    return multiprecision(bits).matrix(rows)


def _restored(bits: int, *parts: tuple[int, ...]) -> Any:
    context = multiprecision(bits)
    numbers = tuple((sign, mpmath.libmp.MPZ(whole), exponent, count) for sign, whole, exponent, count in parts)
    return context.make_mpf(numbers[0]) if len(parts) == 1 else context.make_mpc(numbers)


def within_reach(name: str, x: Any, context: Any) -> Any:
    """An argument, that of an exponential at most 2**FARTHEST: beyond, as many digits as it has bits would be needed.

    Args:
        name: of the function.
        x: its argument, mpmath's number.
        context: of mpmath.

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
    context: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "context", multiprecision(self.bits))

    def __reduce__(self) -> tuple[Any, ...]:
        return Multi, (self.bits,)

    def convert(self, value: Any) -> Any:
        """Take an int, float, Fraction or mpf in; the value is rounded to the precision."""
        if isinstance(value, Fraction):
            return self.context.mpf(value.numerator) / value.denominator
        return +self.context.convert(value)

    def rational(self, numerator: int, denominator: int) -> Any:
        return self.context.mpf(numerator) / denominator

    def pi(self) -> Any:
        return +self.context.pi

    def power(self, x: Any, n: int) -> Any:
        return x**n

    def unary(self, name: str, x: Any) -> Any:
        """Return a function of one variable at a number.

        Args:
            name: of the function, such as ``sqrt``.
            x: mpmath's number of this context.

        Raises:
            InvalidInputError: the value is not real, or beyond the range of numbers.
        """
        if name == "neg":
            return -x
        value = abs(x) if name == "abs" else getattr(self.context, name)(within_reach(name, x, self.context))
        if isinstance(value, self.context.mpc):
            raise InvalidInputError(
                f"{name} of {self.context.nstr(x, 8)} is not real: the formula leaves its domain there"
            )
        return value
