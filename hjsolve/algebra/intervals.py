"""Enclosures of expressions at rational points: interval arithmetic with outward rounding over the sympy tree.

mpmath's ``libmp.mpi_*``; the true value lies between ``lower`` and ``upper``, so that what they exclude is excluded. No
float enters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import reduce

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.algebra.tree_walk import TreeWalk
from hjsolve.precision import mp

Interval = tuple[sp.Expr, sp.Expr]


class NoEnclosureError(ArithmeticError):
    """The expression has no finite real enclosure at this point."""


def enclose(
    expression: sp.Expr, point: Mapping[sp.Expr, sp.Rational], precision: int = 64
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Enclose the value of an expression at a rational point.

    Args:
        expression: real expression in the symbols and undetermined functions that ``point`` gives values to.
        point: rational values.
        precision: working precision in bits.

    Returns:
        Lower and upper bound of the true value.

    Raises:
        NoEnclosureError: a pole, a root or logarithm of what is not positive, or an unknown function.
    """
    return finite(lambda: Walk(point, precision)(expression))


def finite(compute: Callable[[], Interval]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Return the ends of an interval.

    Args:
        compute: gives the interval, or raises.

    Raises:
        NoEnclosureError: it could not be computed, or is not finite.
    """
    try:
        low, high = compute()
    except (libmp.ComplexResult, ValueError, ZeroDivisionError, OverflowError) as fault:
        raise NoEnclosureError(str(fault)) from fault
    if not all(end[1] or end == libmp.fzero for end in (low, high)):
        raise NoEnclosureError("the enclosure is not finite")
    return mp.make_mpf(low), mp.make_mpf(high)


class Walk(TreeWalk[Interval]):
    """The walk in intervals, at a point."""

    def __init__(self, point: Mapping[sp.Expr, sp.Rational], precision: int):
        super().__init__()
        self.point, self.precision = point, precision

    def leaf(self, x: sp.Expr) -> Interval | None:  # noqa: D102
        prec = self.precision
        x = self.point.get(x, x)
        if x.is_Rational:
            return rational(int(x.p), int(x.q), prec)
        if x is sp.pi:
            return _pi(prec)
        return libmp.mpi_exp(rational(1, 1, prec), prec) if x is sp.E else None

    def total(self, parts: Iterable[Interval]) -> Interval:  # noqa: D102
        return reduce(lambda a, b: libmp.mpi_add(a, b, self.precision), parts)

    def product(self, parts: Iterable[Interval]) -> Interval:  # noqa: D102
        return reduce(lambda a, b: libmp.mpi_mul(a, b, self.precision), parts)

    def function(self, x: sp.Expr) -> Interval:  # noqa: D102
        if function := _FUNCTIONS.get(x.func):
            return function(self(x.args[0]), self.precision)
        raise NoEnclosureError(f"no interval extension of {x.func}")

    def power(self, x: sp.Expr) -> Interval:  # noqa: D102
        prec, b, exponent = self.precision, self(x.base), x.exp
        if exponent.is_Integer:
            n = int(exponent)
            return enclose_inverse(libmp.mpi_pow_int(b, -n, prec), prec) if n < 0 else libmp.mpi_pow_int(b, n, prec)
        if exponent.is_Rational and exponent.q == 2:
            root = libmp.mpi_sqrt(b, prec)
            n = int(exponent.p)
            return (
                enclose_inverse(libmp.mpi_pow_int(root, -n, prec), prec) if n < 0 else libmp.mpi_pow_int(root, n, prec)
            )
        return libmp.mpi_exp(libmp.mpi_mul(self(exponent), _log(b, prec), prec), prec)


def rational(p: int, q: int, prec: int) -> Interval:
    """Return the rational p/q.

    Args:
        p, q: numerator and denominator.
    """
    return libmp.from_rational(p, q, prec, "f"), libmp.from_rational(p, q, prec, "c")


def _pi(prec: int) -> Interval:
    return libmp.mpf_pi(prec, "f"), libmp.mpf_pi(prec, "c")


def _integer(n: int) -> Interval:
    return libmp.from_int(n), libmp.from_int(n)


def enclose_inverse(x: Interval, prec: int) -> Interval:
    """1/x; ``NoEnclosureError`` where x may be zero.

    Args:
        x: a real interval.

    Raises:
        NoEnclosureError: x may be zero.
    """
    if not (libmp.mpf_sign(x[0]) > 0 or libmp.mpf_sign(x[1]) < 0):
        raise NoEnclosureError("division by an interval that contains zero")
    return libmp.mpi_div(_integer(1), x, prec)


def _log(x: Interval, prec: int) -> Interval:
    if libmp.mpf_sign(x[0]) <= 0:
        raise NoEnclosureError("logarithm of an interval that is not positive")
    return libmp.mpi_log(x, prec)


def _ratio(
    top: Callable[[Interval, int], Interval], bottom: Callable[[Interval, int], Interval]
) -> Callable[[Interval, int], Interval]:
    return lambda x, prec: libmp.mpi_mul(top(x, prec), enclose_inverse(bottom(x, prec), prec), prec)


def _reciprocal(function: Callable[[Interval, int], Interval]) -> Callable[[Interval, int], Interval]:
    return lambda x, prec: enclose_inverse(function(x, prec), prec)


def _half_sum(sign: int) -> Callable[[Interval, int], Interval]:
    def function(x: Interval, prec: int) -> Interval:
        up, down = libmp.mpi_exp(x, prec), libmp.mpi_exp(libmp.mpi_neg(x, prec), prec)
        total = libmp.mpi_add(up, down, prec) if sign > 0 else libmp.mpi_sub(up, down, prec)
        return libmp.mpi_div(total, _integer(2), prec)

    return function


def _asin(x: Interval, prec: int) -> Interval:
    rest = libmp.mpi_sub(_integer(1), libmp.mpi_mul(x, x, prec), prec)
    return libmp.mpi_atan(libmp.mpi_mul(x, enclose_inverse(libmp.mpi_sqrt(rest, prec), prec), prec), prec)


def _acos(x: Interval, prec: int) -> Interval:
    return libmp.mpi_sub(libmp.mpi_div(_pi(prec), _integer(2), prec), _asin(x, prec), prec)


def _area(constant: int) -> Callable[[Interval, int], Interval]:
    def function(x: Interval, prec: int) -> Interval:
        square = libmp.mpi_add(libmp.mpi_mul(x, x, prec), _integer(constant), prec)
        return _log(libmp.mpi_add(x, libmp.mpi_sqrt(square, prec), prec), prec)

    return function


def _atanh(x: Interval, prec: int) -> Interval:
    up, down = libmp.mpi_add(_integer(1), x, prec), libmp.mpi_sub(_integer(1), x, prec)
    return libmp.mpi_div(libmp.mpi_sub(_log(up, prec), _log(down, prec), prec), _integer(2), prec)


def _sign(x: Interval, _prec: int) -> Interval:
    if libmp.mpf_sign(x[0]) > 0:
        return _integer(1)
    if libmp.mpf_sign(x[1]) < 0:
        return _integer(-1)
    raise NoEnclosureError("sign of an interval that contains zero")


_SIN, _COS = libmp.mpi_sin, libmp.mpi_cos
_SINH, _COSH = _half_sum(-1), _half_sum(1)
_FUNCTIONS: dict[object, Callable[[Interval, int], Interval]] = {
    sp.sin: _SIN, sp.cos: _COS, sp.tan: _ratio(_SIN, _COS), sp.cot: _ratio(_COS, _SIN),
    sp.sec: _reciprocal(_COS), sp.csc: _reciprocal(_SIN),
    sp.sinh: _SINH, sp.cosh: _COSH, sp.tanh: _ratio(_SINH, _COSH), sp.coth: _ratio(_COSH, _SINH),
    sp.sech: _reciprocal(_COSH), sp.csch: _reciprocal(_SINH),
    sp.exp: libmp.mpi_exp, sp.log: _log, sp.Abs: libmp.mpi_abs, sp.sign: _sign,
    sp.atan: libmp.mpi_atan, sp.asin: _asin, sp.acos: _acos,
    sp.asinh: _area(1), sp.acosh: _area(-1), sp.atanh: _atanh,
}  # fmt: skip
