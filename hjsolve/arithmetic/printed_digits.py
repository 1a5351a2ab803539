"""How a number with an error is written.

As many digits are printed as the error leaves, and the interval that is printed still contains the true number.
"""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, ROUND_UP, Context, Decimal
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hjsolve.arithmetic.number_types import Mpf


WIDE = Context(prec=400)
_SMALL, LARGE = -5, 7  # powers of ten between which a number is written without an exponent


def decimal(value: float | Mpf) -> Decimal:
    """Give a number its exact decimal value.

    Args:
        value: int, float, numpy scalar or ``mpf``.

    Returns:
        The exact value; an ``mpf`` to 400 digits.
    """
    if hasattr(value, "man_exp"):
        mantissa, exponent = value.man_exp  # of the absolute value
        whole = Decimal(abs(int(mantissa)) if value >= 0 else -abs(int(mantissa)))
        scaled = WIDE.multiply(whole, WIDE.power(Decimal(2), Decimal(int(exponent))))
        return scaled if mantissa or value == 0 else Decimal(str(value).replace("+", ""))
    return Decimal(int(value)) if isinstance(value, int) else Decimal(float(value))


def rounded_pair(value: Decimal, error: Decimal) -> tuple[Decimal, Decimal]:
    """Round an error up to one digit (two if the first is a 1) and its value to the same last place.

    Args:
        value: finite.
        error: finite and above 0.

    Returns:
        Value and error; what the rounding of the value itself costs is counted in the error.
    """
    last = _last_place(error)
    rounded = value.quantize(Decimal(1).scaleb(last), rounding=ROUND_HALF_EVEN, context=WIDE)
    total = WIDE.add(error, WIDE.abs(WIDE.subtract(value, rounded)))
    return rounded, total.quantize(Decimal(1).scaleb(_last_place(total)), rounding=ROUND_UP, context=WIDE)


def _last_place(error: Decimal) -> int:
    """One digit of the error, two where it begins with 1."""
    return error.adjusted() - (1 if error.as_tuple().digits[0] == 1 else 0)


def shortest(value: float | Mpf, digits: int = 15) -> str:
    """Write a number that has no error: exactly if it is short, else to some digits.

    Args:
        value: int, float or ``mpf``.
        digits: significant digits kept.

    Returns:
        Its digits.
    """
    exact = decimal(value)
    if not exact.is_finite():
        return special(exact)
    rounded = Context(prec=digits, rounding=ROUND_HALF_EVEN).plus(exact).normalize(WIDE)
    whole = rounded == rounded.to_integral_value() and rounded.adjusted() < LARGE
    return str(int(rounded)) if whole else plain_text(rounded)


def special(value: Decimal) -> str:
    """Write what is not a finite number.

    Args:
        value: infinite, or no number.
    """
    return "undefined" if value.is_nan() else "∞" if value > 0 else "−∞"


def plain_text(value: Decimal) -> str:
    """Write a decimal, with an exponent only where it is very large or small.

    Args:
        value: finite.
    """
    if value == 0:
        return "0"
    exponent = int(value.as_tuple().exponent)
    plain = _SMALL <= value.adjusted() < LARGE and exponent <= 0
    return f"{value:f}" if plain else scientific(value)


def scientific(value: Decimal) -> str:
    """Write a decimal with one digit before the point and an exponent.

    Args:
        value: finite.
    """
    sign, digits, _ = value.as_tuple()
    letters = "".join(map(str, digits))
    mantissa = letters[0] + ("." + letters[1:] if len(letters) > 1 else "")
    return f"{'-' if sign else ''}{mantissa}e{value.adjusted()}"


def with_last_digits(value: float | Mpf, error: float | Mpf) -> tuple[str, int]:
    """Write a number with its error in brackets, in units of the last digit: 7.4162987(3).

    Returns:
        The digits, and the power of ten they are to be multiplied by; 0 where none is needed.
    """
    exact, uncertainty = decimal(value), decimal(error)
    if not exact.is_finite() or not uncertainty.is_finite():
        return (special(exact) if not exact.is_finite() else f"{shortest(value, 2)}(unknown)"), 0
    if uncertainty == 0:
        text = plain_text(Decimal(repr(float(value)))) if isinstance(value, float) else shortest(value, WIDE.prec)
        mantissa, _, power = text.partition("e")
        return mantissa, int(power or 0)
    rounded, margin = rounded_pair(exact, uncertainty)
    last, size = int(rounded.as_tuple().exponent), max(rounded.adjusted() if rounded else -400, margin.adjusted())
    power_of_ten = 0 if _SMALL <= size < LARGE and last <= 0 else size
    units = int(margin.scaleb(-last, context=WIDE))
    return f"{rounded.scaleb(-power_of_ten, context=WIDE):f}({units})", power_of_ten


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
