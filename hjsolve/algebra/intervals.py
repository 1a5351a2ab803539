"""Enclosures of expressions at rational points: interval arithmetic with outward rounding over the sympy tree.

The four operations, powers and roots are mpmath's ``libmp.mpi_*``, functions those of ``ranges``; the true value lies
between ``lower`` and ``upper``, so that what they exclude is excluded. No float enters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache, reduce

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.algebra import ranges
from hjsolve.algebra.elementary import INVERSES, Rule
from hjsolve.algebra.tree_walk import TreeWalk
from hjsolve.precision import mp, multiprecision

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
        self.point, self.precision, self._context = point, precision, multiprecision(precision)

    def leaf(self, x: sp.Expr) -> Interval | None:  # noqa: D102
        prec = self.precision
        x = self.point.get(x, x)
        if x.is_Rational:
            return rational(int(x.p), int(x.q), prec)
        if x is sp.pi:
            return _pi(prec)
        return self._applied("exp", _integer(1)) if x is sp.E else None

    def total(self, parts: Iterable[Interval]) -> Interval:  # noqa: D102
        return reduce(lambda a, b: libmp.mpi_add(a, b, self.precision), parts)

    def product(self, parts: Iterable[Interval]) -> Interval:  # noqa: D102
        return reduce(lambda a, b: libmp.mpi_mul(a, b, self.precision), parts)

    def function(self, x: sp.Expr) -> Interval:  # noqa: D102
        if name := _FUNCTIONS.get(x.func):
            return self._applied(name, self(x.args[0]))
        if x.func is sp.sign:
            return _sign(self(x.args[0]))
        return self(_by_others(x))

    def _applied(self, name: str, x: Interval) -> Interval:
        c = self._context
        low, high = ranges.apply(c, name, (c.make_mpf(x[0]), c.make_mpf(x[1])))
        return low._mpf_, high._mpf_

    def power(self, x: sp.Expr) -> Interval:  # noqa: D102
        prec, b, exponent = self.precision, self(x.base), x.exp
        if exponent.is_Rational and exponent.q <= 2:
            n, root = int(exponent.p), b if exponent.q == 1 else libmp.mpi_sqrt(b, prec)
            power = libmp.mpi_pow_int(root, abs(n), prec)
            return _inverse(power, prec) if n < 0 else power
        return self._applied("exp", libmp.mpi_mul(self(exponent), self._applied("log", b), prec))


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


def _inverse(x: Interval, prec: int) -> Interval:
    if not (libmp.mpf_sign(x[0]) > 0 or libmp.mpf_sign(x[1]) < 0):
        raise NoEnclosureError("division by an interval that contains zero")
    return libmp.mpi_div(_integer(1), x, prec)


def _sign(x: Interval) -> Interval:
    if libmp.mpf_sign(x[0]) > 0:
        return _integer(1)
    if libmp.mpf_sign(x[1]) < 0:
        return _integer(-1)
    raise NoEnclosureError("sign of an interval that contains zero")


_FUNCTIONS: dict[object, str] = {
    sp.sin: "sin", sp.cos: "cos", sp.tan: "tan", sp.exp: "exp", sp.log: "log", sp.atan: "atan", sp.Abs: "abs",
    sp.sinh: "sinh", sp.cosh: "cosh", sp.tanh: "tanh", sp.asinh: "asinh",
}  # fmt: skip
"""Those that ``ranges`` has, and that are real wherever they are finite, or say so as the logarithm does."""
_BY_OTHERS: dict[object, Rule] = {
    **INVERSES,
    sp.cot: lambda u: sp.cos(u) / sp.sin(u), sp.sec: lambda u: 1 / sp.cos(u), sp.csc: lambda u: 1 / sp.sin(u),
    sp.coth: lambda u: 1 / sp.tanh(u), sp.sech: lambda u: 1 / sp.cosh(u), sp.csch: lambda u: 1 / sp.sinh(u),
}  # fmt: skip
"""Every other function, written by those."""


@lru_cache(maxsize=4096)
def _by_others(x: sp.Expr) -> sp.Expr:
    """Return a function by those that are enclosed themselves; asked of the same function at every point.

    Raises:
        NoEnclosureError: a function that is not known.
    """
    if rule := _BY_OTHERS.get(x.func):
        return rule(x.args[0])
    raise NoEnclosureError(f"no interval extension of {x.func}")
