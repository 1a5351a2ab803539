"""Second differences over doubles and arrays with numpy: what the programs of small motions are compared with."""

from __future__ import annotations

from math import factorial

import numpy as np

from hjsolve.arithmetic.divided_differences import SecondDifferences
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Elementwise

_SERIES = 0.7
_TERMS = 11


def in_doubles(offset: Elementwise) -> SecondDifferences[Elementwise]:
    """Return the arithmetic over doubles and arrays of them.

    Args:
        offset: δ.
    """
    return SecondDifferences(Float64(), offset, _elementary, _common_sign)


def _common_sign(x: Elementwise, y: Elementwise) -> Elementwise:
    return np.where(x * y > 0, np.sign(x), np.nan)


def _elementary(name: str, x: Elementwise, d: Elementwise) -> tuple[Elementwise, Elementwise, Elementwise]:
    """Φ(x), Φ′(x) and Φ[x, x, x + d]."""
    match name:
        case "exp":
            e = np.exp(x)
            return e, e, e * _choose(d, _tail(d, 2, 1, 1), lambda y: (np.expm1(y) - y) / y**2)
        case "sin" | "cos":
            s, c = np.sin(x), np.cos(x)
            even = _choose(d, _tail(d, 2, 2, -1), lambda y: (1 - np.cos(y)) / y**2)
            odd = d * _choose(d, _tail(d, 3, 2, -1), lambda y: (y - np.sin(y)) / y**3)
            return (s, c, -s * even - c * odd) if name == "sin" else (c, -s, -c * even + s * odd)
        case "sinh" | "cosh":
            s, c = np.sinh(x), np.cosh(x)
            even = _choose(d, _tail(d, 2, 2, 1), lambda y: (np.cosh(y) - 1) / y**2)
            odd = d * _choose(d, _tail(d, 3, 2, 1), lambda y: (np.sinh(y) - y) / y**3)
            return (s, c, s * even + c * odd) if name == "sinh" else (c, s, c * even + s * odd)
        case "log":
            r = d / x
            return np.log(x), 1 / x, _log_tail(r) / x**2
        case _:
            raise NotImplementedError(name)


def _tail(d: Elementwise, start: int, step: int, sign: int) -> Elementwise:
    """1/start! + sign·dˢ/(start + s)! + …, s the step: the rest of a power series divided by its first power."""
    y = d**step
    total = 0.0 * d
    for k in range(_TERMS + 5 * (step == 1), -1, -1):
        total = sign**k / factorial(start + step * k) + total * y
    return total


def _choose(d: Elementwise, series: Elementwise, formula: Elementwise) -> Elementwise:
    """Return the series where |d| is small, the formula elsewhere."""
    far = np.abs(d) >= _SERIES
    if not np.any(far):
        return series
    return np.where(far, formula(np.where(far, d, 1.0)), series)


def _log_tail(r: Elementwise) -> Elementwise:
    """(ln(1 + r) − r)/r², by the series of artanh: ln(1 + r) = 2 artanh(y), y = r/(2 + r)."""
    y = r / (2 + r)
    square = y * y
    total = 0.0 * r
    for k in range(14, -1, -1):
        total = 2.0 / (2 * k + 3) + total * square
    series = y * total / (2 + r) ** 2 - 1 / (2 + r)
    far = np.abs(r) >= _SERIES / 2
    safe = np.where(far, r, 1.0)
    return np.where(far, (np.log1p(safe) - safe) / safe**2, series)
