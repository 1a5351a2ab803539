"""Numbers with their errors, rounded to the digits they deserve."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal, Inexact
from typing import TYPE_CHECKING, Protocol

import sympy as sp

from hjsolve.arithmetic.printed_digits import (
    LARGE,
    WIDE,
    decimal,
    plain_text,
    raised,
    rounded_pair,
    scientific,
    shortest,
    special,
)
from hjsolve.reports.document import Number

if TYPE_CHECKING:
    from hjsolve.arithmetic.number_types import Mpf


class WithError(Protocol):
    """A number with a bound on its error: ``Estimate``, or what is like one."""

    @property
    def value(self) -> float | Mpf:
        """The number."""

    @property
    def error(self) -> float | Mpf:
        """At least how far the truth may be from it."""

    @property
    def certified(self) -> bool:
        """Whether that is proved."""


HOW_NUMBERS_ARE_PRINTED = (
    "Every number is a value ± a bound on its error. A number without ± is exact as printed; (double) stands for the "
    "binary number nearest to it."
)


def quantity(estimate: WithError) -> Number:
    """Write an estimate: the error rounded up to one digit (two if the first is a 1), the value to the same last place.

    A reader may take every printed digit of the value as meant, and the interval value ± error as holding the truth.

    Args:
        estimate: anything with ``value``, ``error`` and ``certified``.

    Returns:
        The rounded texts. A zero error leaves the value exact and the error text empty.

    Example:
        >>> from hjsolve.arithmetic.estimate import Estimate
        >>> quantity(Estimate(6.283185307179586, 3.1e-15))
        Number(value='6.283185307179586', error='4e-15', certified=False)
    """
    value, error = decimal(estimate.value), decimal(estimate.error)
    if not value.is_finite():
        return Number(special(value), "", bool(estimate.certified))
    if not error.is_finite():
        return Number(shortest(estimate.value, 2), "unknown", bool(estimate.certified))
    if error == 0:
        return Number(shortest(estimate.value), "", bool(estimate.certified))
    rounded, margin = rounded_pair(value, error)
    uncertainty = plain_text(margin) if -3 < margin.adjusted() < 3 else scientific(margin)
    return Number(plain_text(rounded), uncertainty, bool(estimate.certified))


def terminating(value: sp.Basic, digits: int = 15) -> Number | None:
    """Write a number that is known exactly and has a short decimal expansion.

    Args:
        value: the exact number.
        digits: significant digits that count as short.

    Returns:
        The exact decimal; None where the number is not a rational, or its expansion is long or does not end.

    Example:
        >>> terminating(sp.Rational(-7, 25))
        Number(value='-0.28', error='', certified=False)
    """
    if not isinstance(value, sp.Rational) or value.q.bit_length() > 4 * digits or len(str(value.q)) > digits:
        return None
    context = Context(prec=4 * digits)
    context.clear_flags()
    quotient = context.divide(Decimal(int(value.p)), Decimal(int(value.q))).normalize(context)
    if context.flags[Inexact] or len(quotient.as_tuple().digits) > digits:
        return None
    whole = quotient == quotient.to_integral_value() and quotient.adjusted() < LARGE
    return Number(str(int(quotient)) if whole else plain_text(quotient))


def bound(value: float) -> Number:
    """Write a bound in two digits, rounded up.

    Args:
        value: the bound, not negative.

    Example:
        >>> bound(8.8817841970012523e-16), bound(0.0)
        (Number(value='8.9e-16', error='', certified=False), Number(value='0', error='', certified=False))
    """
    if not value:
        return Number("0")
    rounded = Context(prec=2, rounding=ROUND_CEILING).plus(decimal(value)).normalize(WIDE)
    return Number(plain_text(rounded) if -3 < rounded.adjusted() < 3 else scientific(rounded))


def rounded_outward(value: float | Mpf, *, up: bool, digits: int = 10) -> str:
    """Write an end of an enclosure, rounded outward.

    Args:
        value: the end; float or ``mpf``.
        up: whether it is the upper end.
        digits: significant digits kept.

    Returns:
        Its digits; the number they mean is not inside the enclosure.
    """
    context = Context(prec=digits, rounding=ROUND_CEILING if up else ROUND_FLOOR)
    return raised(plain_text(context.plus(decimal(value)).normalize(WIDE)))
