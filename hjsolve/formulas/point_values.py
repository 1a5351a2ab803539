"""The value of an expression at a point, at 80 digits; for checks of input, not for results."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp
from mpmath import libmp
from sympy.core.function import AppliedUndef

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
    if expression.is_Symbol:
        return values[expression]
    if expression.is_Rational:
        return CONTEXT.mpf(int(expression.p)) / int(expression.q)
    if expression.is_NumberSymbol:
        return +CONTEXT.pi if expression is sp.pi else CONTEXT.e + 0
    arguments = [evaluate(argument, values) for argument in expression.args]
    if expression.is_Add:
        return CONTEXT.fsum(arguments)
    if expression.is_Mul:
        return CONTEXT.fprod(arguments)
    return _real(expression, arguments)


def _real(expression: sp.Expr, arguments: list[mpmath.mpf]) -> mpmath.mpf:
    try:
        value = _power(*arguments) if expression.is_Pow else _function(expression, arguments[0])
    except (ZeroDivisionError, ValueError) as error:
        raise NoValueError(str(expression)) from error
    if isinstance(value, CONTEXT.mpc) or not CONTEXT.isfinite(value):
        raise NoValueError(str(expression))
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
