"""Value and error of a function of numbers that have errors.

The function is enclosed over value ± error of each operand (``ranges``) and at the values themselves; the error is how
far the first enclosure reaches from the result. That is the first order and everything beyond it, at a working
precision far above that of the result.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Sequence
from decimal import ROUND_CEILING, Context, Decimal
from typing import Any, TypeAlias

from hjsolve.algebra import ranges
from hjsolve.algebra.ranges import Range
from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Context as MpContext
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.printed_digits import decimal

Term: TypeAlias = tuple[Any, Any]
"""(value, error)."""

_DOUBLE, _GUARD = 53, 75
_TWO_DIGITS = Context(prec=2, rounding=ROUND_CEILING)


def is_real(x: object) -> bool:
    """Whether something is a real number: int, float, Fraction, Decimal, mpf, a numpy scalar, a rational of sympy."""
    if isinstance(x, (numbers.Real, Decimal)) or hasattr(x, "_mpf_"):
        return not isinstance(x, bool)
    return bool(getattr(x, "shape", None) == () and getattr(getattr(x, "dtype", None), "kind", "") in {"i", "u", "f"})


def propagated(name: str, terms: Sequence[Term]) -> Term:
    """Return a function's value and the bound on its error.

    Args:
        name: of ``ranges.FUNCTIONS`` or ``ranges.OF_TWO``.
        terms: value and error of each operand.

    Returns:
        Doubles where all operands are and the result is within their range, else ``mpf`` of the highest precision among
        them. A value that is not finite, or an error that is not known, gives an error that is not known (infinite).

    Raises:
        InvalidInputError: the function is not real there, or has no bound.
    """
    if not all(_finite(part) for term in terms for part in term):
        return math.nan, math.inf
    bits = max(_bits(part) for term in terms for part in term)
    c = multiprecision(max(bits, _DOUBLE) + _GUARD)
    spread = _applied(c, name, [_ends(c, *term) for term in terms])
    at_values = _applied(c, name, [_exact(c, value) for value, _ in terms])
    middle = at_values[0] if at_values[0] == at_values[1] else (at_values[0] + at_values[1]) / 2
    if not bits and (value := _double(middle)) is not None:
        exact = c.convert(value)
        return value, _up(_reach(c, spread, exact))
    target = multiprecision(max(bits, _DOUBLE))
    value = target.mpf(middle)
    return value, target.fadd(_reach(c, spread, value), 0, rounding="c")


def _reach(c: MpContext, spread: Range, value: float | Mpf) -> Mpf:
    """Return how far an interval extends from a number in it or next to it, rounded up."""
    below, above = c.fsub(value, spread[0], rounding="c"), c.fsub(spread[1], value, rounding="c")
    return max(below, above, c.zero)


def interval(term: Term) -> tuple[float, float] | Range:
    """Lower and upper end, rounded outward to the precision of the value.

    Args:
        term: value and error.
    """
    low, high = exact_ends(term)
    bits = _bits(term[0])
    if bits:
        c = multiprecision(bits)
        return c.fadd(low, 0, rounding="f"), c.fadd(high, 0, rounding="c")
    return -_up(-low), _up(high)


def exact_ends(term: Term) -> tuple[float, float] | Range:
    """Lower and upper end as they are.

    Args:
        term: value and error; infinite ends where one of them is not finite.
    """
    if not all(_finite(part) for part in term):
        return -math.inf, math.inf
    return _ends(multiprecision(max(_bits(part) for part in term) + _DOUBLE + _GUARD), *term)


def meet(one: Term, other: Term) -> bool:
    """Return whether value ± error of two have a number in common."""
    (a, b), (c, d) = exact_ends(one), exact_ends(other)
    return bool(a <= d and c <= b)


def short_bound(error: float | Mpf) -> str:
    """Write an error with two digits, not below itself."""
    if not _finite(error) or not error:
        return repr(float(error))
    exact = decimal(error)
    text = f"{exact:.1e}"
    if Decimal(text) < exact and (_bits(error) or float(text) < error):
        text = f"{_TWO_DIGITS.plus(exact):.1e}"
    return text


# ------------------------------------------------------------------------------------------------ one operand
def _applied(c: MpContext, name: str, spreads: list[Range]) -> Range:
    return ranges.apply(c, name, spreads[0]) if len(spreads) == 1 else ranges.OF_TWO[name](c, *spreads)


def _finite(x: Any) -> bool:
    if isinstance(x, Decimal):
        return x.is_finite()
    if hasattr(x, "_mpf_"):
        return bool(x.context.isfinite(x))
    return not isinstance(x, float) or math.isfinite(x)


def _bits(x: Any) -> int:
    """Precision of a number of many digits; 0 of every other."""
    return max(int(x.context.prec), int(x._mpf_[3])) if hasattr(x, "_mpf_") else 0


def _exact(c: MpContext, x: Any) -> Range:
    """Return a number as an interval: one number twice where it is a binary fraction."""
    if hasattr(x, "_mpf_"):
        return (c.convert(x),) * 2
    if hasattr(x, "item"):
        x = x.item()
    if isinstance(x, int):
        return (c.convert(x),) * 2
    top, bottom = (int(x.numerator), int(x.denominator)) if isinstance(x, numbers.Rational) else x.as_integer_ratio()
    return c.fdiv(top, bottom, rounding="f"), c.fdiv(top, bottom, rounding="c")


def _ends(c: MpContext, value: float | Mpf, error: float | Mpf) -> Range:
    (low, high), uncertainty = _exact(c, value), _exact(c, error)[1]
    return c.fsub(low, uncertainty, rounding="f"), c.fadd(high, uncertainty, rounding="c")


def _double(x: float | Mpf) -> float | None:
    """Return the nearest double; None beyond their range."""
    try:
        value = float(x)
    except OverflowError:
        return None
    return value if math.isfinite(value) else None


def _up(x: float | Mpf) -> float:
    """Return the least double that is not below a number."""
    nearest = _double(x)
    if nearest is None:
        return math.inf if x > 0 else -1.7976931348623157e308
    return math.nextafter(nearest, math.inf) if x > nearest else nearest
