"""The value of an expression at a point, at 80 digits; for checks of input, not for results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial

import mpmath
import sympy as sp
from mpmath import libmp
from sympy.core.function import AppliedUndef

from hjsolve.algebra.tree_walk import TreeWalk
from hjsolve.precision import multiprecision

CONTEXT = multiprecision(libmp.dps_to_prec(80))
_MAX_ARGUMENT = 1_000_000
_GROWING = (sp.exp, sp.sinh, sp.cosh, sp.tanh)


class NoValueError(ArithmeticError):
    """The expression is not a finite real number at the point."""


class BeyondRangeError(NoValueError):
    """The value is too large to be computed; nothing is known of it."""


def evaluate(expression: sp.Expr, values: Mapping[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    """Return the value of an expression of ``formulas.read.parse``.

    Args:
        expression: of the formula language.
        values: one for each of its symbols.

    Raises:
        NoValueError: it has a pole there or is not real.
        BeyondRangeError: a power or an exponential in it is too large.
    """
    return _Digits(values)(expression)


class _Digits(TreeWalk[mpmath.mpf]):
    """The walk to 80 digits."""

    def __init__(self, values: Mapping[sp.Symbol, mpmath.mpf]):
        super().__init__()
        self.values = values

    def leaf(self, x: sp.Expr) -> mpmath.mpf | None:
        if x.is_Symbol:
            return self.values[x]
        if x.is_Rational:
            return CONTEXT.mpf(int(x.p)) / int(x.q)
        if x.is_NumberSymbol:
            return +CONTEXT.pi if x is sp.pi else CONTEXT.e + 0
        return None

    def total(self, parts: Iterable[mpmath.mpf]) -> mpmath.mpf:
        return CONTEXT.fsum(parts)

    def product(self, parts: Iterable[mpmath.mpf]) -> mpmath.mpf:
        return CONTEXT.fprod(parts)

    def power(self, x: sp.Expr) -> mpmath.mpf:
        return _real(x, partial(_power, self(x.base), self(x.exp)))

    def function(self, x: sp.Expr) -> mpmath.mpf:
        argument, *_ = map(self, x.args)
        return _real(x, partial(_function, x, argument))


def _real(x: sp.Expr, compute: Callable[[], mpmath.mpf]) -> mpmath.mpf:
    """Return the value of an expression; what is not finite and real has none."""
    try:
        value = compute()
    except (ZeroDivisionError, ValueError) as error:
        raise NoValueError(str(x)) from error
    if isinstance(value, CONTEXT.mpc) or not CONTEXT.isfinite(value):
        raise NoValueError(str(x))
    return value


def _power(base: mpmath.mpf, exponent: mpmath.mpf) -> mpmath.mpf:
    if base and abs(exponent * CONTEXT.log(abs(base))) > _MAX_ARGUMENT:
        raise BeyondRangeError
    return CONTEXT.power(base, int(exponent) if CONTEXT.isint(exponent) else exponent)


def _function(expression: sp.Expr, argument: mpmath.mpf) -> mpmath.mpf:
    if abs(argument) > (_MAX_ARGUMENT if isinstance(expression, _GROWING) else CONTEXT.mpf(10) ** 60):
        raise BeyondRangeError
    if isinstance(expression, AppliedUndef):
        raise NoValueError(str(expression))
    return getattr(CONTEXT, type(expression).__name__)(argument)
