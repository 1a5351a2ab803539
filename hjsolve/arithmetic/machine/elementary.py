"""Elementary functions without branches, so that LLVM turns a loop over nodes into vector instructions.

Good to about two units in the last place: exp by Cody and Waite's reduction and a polynomial of degree 12, sin and
cos by π/2 in three parts (|x| ≤ 10⁵, NaN beyond), sinh from its series below 1.

Arguments are doubles.
"""

from __future__ import annotations

import math

import numpy as np

from hjsolve.arithmetic.machine.compiling import of_numbers
from hjsolve.arithmetic.machine.intrinsics import as_float, whole

ROUNDINGS = 4
"""A bound on the error of every function here, in units of 2⁻⁵³ of its value (``RunningError.own``)."""
_NOTHING = np.float64(0.0)
"""Numpy's, because plain Python divides no float by zero."""
_EXP = tuple(1.0 / math.factorial(k) for k in range(13))
_SIN = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(9))
_COS = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(9))
_SINH = tuple(1.0 / math.factorial(2 * k + 1) for k in range(10))


@of_numbers
def power_of_two(k: float) -> float:
    """Return 2ᵏ.

    Args:
        k: a whole number from −1021 to 1024.
    """
    return as_float((whole(k) + 1022) << 52) * 2.0


@of_numbers
def exp_(x: float) -> float:
    """Return the exponential; 0 below −708 and infinity above 709."""
    y = min(max(x, -708.0), 709.0)
    k = np.floor(y * 1.4426950408889634 + 0.5)
    r = (y - k * 0.693147180369123816490) - k * 1.90821492927058770002e-10
    total = _EXP[12]
    for n in range(11, -1, -1):
        total = total * r + _EXP[n]
    value = total * power_of_two(k)
    value = _NOTHING if x < -708.0 else value
    value = np.inf if x > 709.0 else value
    return value if x == x else x


@of_numbers
def sincos(x: float) -> tuple[float, float]:
    """Return sin x and cos x.

    Args:
        x: angle in radians, |x| < 10⁵; beyond that both are nan.
    """
    k = np.floor(x * 0.6366197723675814 + 0.5)
    r = ((x - k * 1.5707963267341256) - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21
    s = r * r
    sine, cosine = _SIN[8], _COS[8]
    for n in range(7, 0, -1):
        sine = sine * s + _SIN[n]
        cosine = cosine * s + _COS[n]
    sine = r + r * (s * sine)
    cosine = 1.0 + s * cosine
    turns = whole(k) & 3
    odd = (turns & 1) == 1
    first = cosine if odd else sine
    second = sine if odd else cosine
    first = -first if turns >= 2 else first
    second = -second if (turns == 1) | (turns == 2) else second
    inside = abs(x) < 1e5
    return (first if inside else np.nan), (second if inside else np.nan)


@of_numbers
def sinhcosh(x: float) -> tuple[float, float]:
    """Return sinh x and cosh x.

    Args:
        x: any double; beyond ±709 the values are infinite.
    """
    e = 0.5 * exp_(x)
    other = 0.25 / e
    s = x * x
    total = _SINH[9]
    for n in range(8, 0, -1):
        total = total * s + _SINH[n]
    small = x + x * (s * total)
    return (small if s < 1.0 else e - other), e + other


@of_numbers
def tan_(x: float) -> float:
    """Return sin x/cos x.

    Args:
        x: angle in radians, |x| < 10⁵.
    """
    s, c = sincos(x)
    return s / c


@of_numbers
def tanh_(x: float) -> float:
    """Return sinh x/cosh x."""
    s, c = sinhcosh(max(min(x, 40.0), -40.0))
    return s / c


@of_numbers
def sech_(x: float) -> float:
    """Return 1/cosh x."""
    decay = exp_(-min(abs(x), 700.0))
    return 2.0 * decay / (1.0 + decay * decay)


@of_numbers
def log_(x: float) -> float:
    """Return the logarithm.

    Args:
        x: a double; nan where it is not positive.
    """
    return math.log(x) if x > 0.0 else np.nan


@of_numbers
def asin_(x: float) -> float:
    """Return arcsin.

    Args:
        x: a double; nan beyond −1 … 1.
    """
    return math.asin(x) if abs(x) <= 1 else np.nan


@of_numbers
def acos_(x: float) -> float:
    """Return arccos.

    Args:
        x: a double; nan beyond −1 … 1.
    """
    return math.acos(x) if abs(x) <= 1 else np.nan


@of_numbers
def atan_(x: float) -> float:
    """Return arctan."""
    return math.atan(x)


@of_numbers
def asinh_(x: float) -> float:
    """Return arsinh."""
    return math.asinh(x)


@of_numbers
def acosh_(x: float) -> float:
    """Return arcosh.

    Args:
        x: a double; nan below 1.
    """
    return math.acosh(x) if x >= 1 else np.nan


@of_numbers
def atanh_(x: float) -> float:
    """Return artanh.

    Args:
        x: a double; nan where it is not between −1 and 1.
    """
    return math.atanh(x) if abs(x) < 1 else np.nan


_SERIES = 0.7
_EVEN = tuple(1.0 / math.factorial(2 * k + 2) for k in range(9))
_ODD = tuple(1.0 / math.factorial(2 * k + 3) for k in range(9))
_WHOLE = tuple(1.0 / math.factorial(k + 2) for k in range(16))
_ARTANH = tuple(2.0 / (2 * k + 3) for k in range(12))


@of_numbers
def _tails(square: float) -> tuple[float, float]:
    """1/2! + s/4! + … and 1/3! + s/5! + …; NaN where the terms do not suffice."""
    even, odd = _EVEN[8], _ODD[8]
    for n in range(7, -1, -1):
        even = even * square + _EVEN[n]
        odd = odd * square + _ODD[n]
    inside = abs(square) <= _SERIES * _SERIES
    return (even if inside else np.nan), (odd if inside else np.nan)


@of_numbers
def sincos_bends(x: float, d: float) -> tuple[float, float, float, float]:
    """Return sin x and cos x, and Φ[x, x, x + d] of both for |d| ≤ 0.7, NaN beyond; see ``divided_differences``."""
    s, c = sincos(x)
    even, odd = _tails(-d * d)
    return s, c, -s * even - c * (d * odd), s * (d * odd) - c * even


@of_numbers
def sinhcosh_bends(x: float, d: float) -> tuple[float, float, float, float]:
    """Return the same of sinh and cosh."""
    s, c = sinhcosh(x)
    even, odd = _tails(d * d)
    return s, c, s * even + c * (d * odd), c * even + s * (d * odd)


@of_numbers
def exp_bend(x: float, d: float) -> tuple[float, float]:
    """Return the exponential and its Φ[x, x, x + d] for |d| ≤ 0.7."""
    e, total = exp_(x), _WHOLE[15]
    for n in range(14, -1, -1):
        total = total * d + _WHOLE[n]
    return e, (e * total if abs(d) <= _SERIES else np.nan)


@of_numbers
def log_bend(x: float, d: float) -> tuple[float, float, float]:
    """Return the logarithm, 1/x and Φ[x, x, x + d], for |d| ≤ 0.35 x.

    Args:
        x, d: doubles, x > 0.
    """
    r = d / x
    y = r / (2.0 + r)
    square, total = y * y, _ARTANH[11]
    for n in range(10, -1, -1):
        total = total * square + _ARTANH[n]
    bend = (y * total / (2.0 + r) ** 2 - 1.0 / (2.0 + r)) / (x * x)
    return log_(x), 1.0 / x, (bend if abs(r) <= 0.5 * _SERIES else np.nan)


@of_numbers
def common_sign(x: float, y: float) -> float:
    """Return the sign of x, NaN where that of y is another."""
    return math.copysign(1.0, x) if x * y > 0.0 else np.nan


@of_numbers
def min_(x: float, y: float) -> float:
    """Return the lesser of two numbers, nan where one of them is."""
    return x if (x <= y) | (x != x) else y


@of_numbers
def max_(x: float, y: float) -> float:
    """Return the greater of two numbers, nan where one of them is."""
    return x if (x >= y) | (x != x) else y


@of_numbers
def signed(x: float, y: float) -> float:
    """Return y where x is positive, −y elsewhere."""
    return y if x > 0.0 else -y
