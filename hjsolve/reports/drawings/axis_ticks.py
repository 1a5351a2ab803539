"""Round places on an axis and what is written next to them."""

from __future__ import annotations

from math import ceil, floor, log10, pi


def ticks(low: float, high: float, wanted: float = 5.0, *, angle: bool = False) -> list[tuple[float, str]]:
    """Choose round places on an axis.

    Args:
        low: start of the range.
        high: its end, above ``low``.
        wanted: about how many.
        angle: True for multiples of π/2, π/4 … where the range is that of an angle.

    Returns:
        (place, label) in order.
    """
    if angle and high - low > pi / 3:
        return _angle_ticks(low, high, wanted)
    raw = (high - low) / wanted
    power = 10.0 ** floor(log10(raw))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= raw * 0.999)
    places = [i * step for i in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]
    decimals = max(0, -floor(log10(step) + 1e-9))
    largest = max(abs(low), abs(high))
    if decimals > 4 or largest >= 1e6:
        # many digits: show the offset-free value with as few digits as tell the ticks apart
        digits = max(1, ceil(log10(largest / step) - 1e-9) + 1)
        return [(x, _power_label(x, digits)) for x in places]
    return [(x, f"{x:.{decimals}f}".replace("-", "−") if abs(x) > step / 2 else "0") for x in places]


def _power_label(x: float, digits: int) -> str:
    mantissa, _, exponent = f"{x:.{digits - 1}e}".partition("e")
    superscript = str(int(exponent)).translate(str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"))
    return "0" if x == 0 else f"{mantissa}·10{superscript}".replace("-", "−")


def _angle_ticks(low: float, high: float, wanted: float) -> list[tuple[float, str]]:
    step = next(
        (s for s in (pi / 4, pi / 2, pi, 2 * pi, 4 * pi, 8 * pi, 16 * pi) if (high - low) / s <= wanted + 1.01), 32 * pi
    )
    places = range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)
    return [(i * step, _angle_label(i * round(step / (pi / 4)))) for i in places]


def _angle_label(quarters: int) -> str:
    sign, n = ("−" if quarters < 0 else ""), abs(quarters)
    if n == 0:
        return "0"
    for divisor in (4, 2):
        if n % divisor == 0:
            whole, under = n // divisor, 4 // divisor
            return f"{sign}{'' if whole == 1 else whole}π{'' if under == 1 else f'/{under}'}"
    return f"{sign}{'' if n == 1 else n}π/4"
