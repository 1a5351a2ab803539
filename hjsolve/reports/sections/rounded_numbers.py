"""Numbers with their errors, rounded to the digits they deserve."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, ROUND_UP, Context, Decimal, Inexact
from typing import Any

import sympy as sp

from hjsolve.reports.document import Number

_WIDE = Context(prec=400)
_SMALL, _LARGE = -5, 7  # powers of ten between which a number is written without an exponent


def decimal(value: Any) -> Decimal:
    """Give a number its exact decimal value.

    Args:
        value: int, float, numpy scalar or ``mpf``.

    Returns:
        The exact value; an ``mpf`` to 400 digits.
    """
    if hasattr(value, "man_exp"):
        mantissa, exponent = value.man_exp
        whole = Decimal(int(mantissa))
        scaled = _WIDE.multiply(whole, _WIDE.power(Decimal(2), Decimal(int(exponent))))
        return scaled if mantissa or value == 0 else Decimal(str(value).replace("+", ""))
    return Decimal(int(value)) if isinstance(value, int) else Decimal(float(value))


def quantity(estimate: Any) -> Number:
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
        return Number(_special(value), "", bool(estimate.certified))
    if not error.is_finite():
        return Number(shortest(estimate.value, 2), "unknown", bool(estimate.certified))
    if error == 0:
        return Number(shortest(estimate.value), "", bool(estimate.certified))
    last = _last_place(error)
    rounded = value.quantize(Decimal(1).scaleb(last), rounding=ROUND_HALF_EVEN, context=_WIDE)
    # the rounding of the value itself is part of the error that is printed
    total = _WIDE.add(error, _WIDE.abs(_WIDE.subtract(value, rounded)))
    margin = total.quantize(Decimal(1).scaleb(_last_place(total)), rounding=ROUND_UP, context=_WIDE)
    return Number(
        _text(rounded), _text(margin) if -3 < margin.adjusted() < 3 else _scientific(margin), bool(estimate.certified)
    )


def terminating(value: sp.Basic, digits: int = 15) -> Number | None:
    """Write a number that is known exactly and has a short decimal expansion.

    Args:
        value: the exact number.
        digits: significant digits that count as short.

    Returns:
        The exact decimal; None where the number is no rational, or its expansion is long or does not end.

    Example:
        >>> terminating(sp.Rational(-7, 25))
        Number(value='-0.28', error='', certified=False)
    """
    if not isinstance(value, sp.Rational) or len(str(value.q)) > digits:
        return None
    context = Context(prec=4 * digits)
    context.clear_flags()
    quotient = context.divide(Decimal(int(value.p)), Decimal(int(value.q))).normalize(context)
    if context.flags[Inexact] or len(quotient.as_tuple().digits) > digits:
        return None
    whole = quotient == quotient.to_integral_value() and quotient.adjusted() < _LARGE
    return Number(str(int(quotient)) if whole else _text(quotient))


def _last_place(error: Decimal) -> int:
    """One digit of the error, two where it begins with 1."""
    return error.adjusted() - (1 if error.as_tuple().digits[0] == 1 else 0)


def shortest(value: Any, digits: int = 15) -> str:
    """Write a number that has no error: exactly if it is short, else to some digits.

    Args:
        value: int, float or ``mpf``.
        digits: significant digits kept.

    Returns:
        Its digits.
    """
    exact = decimal(value)
    if not exact.is_finite():
        return _special(exact)
    rounded = Context(prec=digits, rounding=ROUND_HALF_EVEN).plus(exact).normalize(_WIDE)
    whole = rounded == rounded.to_integral_value() and rounded.adjusted() < _LARGE
    return str(int(rounded)) if whole else _text(rounded)


def written_duration(value: float) -> str:
    """Write a duration with two digits and the unit that suits it.

    Args:
        value: seconds.

    Returns:
        Such as ``37 ms`` or ``1.4 s``.
    """
    if value < 0.9995e-3:
        return f"{value * 1e6:.0f} µs"
    return f"{value * 1e3:.0f} ms" if value < 0.9995 else f"{value:.2g} s" if value < 9.95 else f"{value:.0f} s"


def rounded_outward(value: Any, *, up: bool, digits: int = 10) -> str:
    """Write an end of an enclosure, rounded outward.

    Args:
        value: the end; float or ``mpf``.
        up: whether it is the upper end.
        digits: significant digits kept.

    Returns:
        Its digits; the number they mean is not inside the enclosure.
    """
    context = Context(prec=digits, rounding=ROUND_CEILING if up else ROUND_FLOOR)
    return raised(_text(context.plus(decimal(value)).normalize(_WIDE)))


def raised(text: str) -> str:
    """Write a number's exponent with raised figures.

    Args:
        text: digits with ``e`` before the exponent.

    Returns:
        Unicode text.
    """
    mantissa, _, exponent = text.replace("-", "−").partition("e")
    figures = exponent.translate(str.maketrans("0123456789−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"))
    return f"{mantissa}×10{figures}" if exponent else mantissa


def _special(value: Decimal) -> str:
    return "undefined" if value.is_nan() else "∞" if value > 0 else "−∞"


def _text(value: Decimal) -> str:
    if value == 0:
        return "0"
    exponent = int(value.as_tuple().exponent)
    plain = _SMALL <= value.adjusted() < _LARGE and exponent <= 0
    return f"{value:f}" if plain else _scientific(value)


def _scientific(value: Decimal) -> str:
    sign, digits, _ = value.as_tuple()
    letters = "".join(map(str, digits))
    mantissa = letters[0] + ("." + letters[1:] if len(letters) > 1 else "")
    return f"{'-' if sign else ''}{mantissa}e{value.adjusted()}"
