"""Numbers in two doubles for the machine: ``arithmetic.double_double`` without branches, with fused products.

The same algorithms, and the same accuracy: each operation good to a few units of 2⁻¹⁰⁴, functions to about 2⁻¹⁰⁰. Terms
of a series that are below 2⁻⁵⁰ of its sum are summed in doubles. Nothing here may be contracted or reordered.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from hjsolve.arithmetic.error_free import exact
from hjsolve.arithmetic.machine.compiling import exactly
from hjsolve.arithmetic.machine.elementary import acosh_, asin_, asinh_, atan_, atanh_, log_, power_of_two
from hjsolve.arithmetic.machine.intrinsics import fma, whole

_LN2 = (0.6931471805599453, 2.3190468138462996e-17)
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
_EXP_HALVINGS = 5  # of the argument of exp, whose series has seven terms
_NEAR = 2.0**-34
_SMALLER = 2.0**-_EXP_HALVINGS

_EXP = tuple((float(c.high), float(c.low)) for c in (exact(Fraction(1, math.factorial(k))) for k in range(7)))
_EXP_REST = tuple(1.0 / math.factorial(k) for k in range(7, 14))
_TURN = tuple(
    (float(c.high), float(c.low)) for c in (exact(Fraction((-1) ** (k // 2), math.factorial(k))) for k in range(16))
)
_TURN_REST = tuple((-1.0) ** (k // 2) / math.factorial(k) for k in range(16, 30))
Two = tuple[float, float]
Four = tuple[float, float, float, float]


@exactly
def _two_sum(a: float, b: float) -> Two:
    s = a + b
    part = s - a
    return s, (a - (s - part)) + (b - part)


@exactly
def _quick(a: float, b: float) -> Two:
    s = a + b
    return s, b - (s - a)


@exactly
def pair_add(x: float, x_low: float, y: float, y_low: float) -> Two:
    """Return x + y."""
    s, e = _two_sum(x, y)
    t, f = _two_sum(x_low, y_low)
    s, e = _quick(s, e + t)
    return _quick(s, e + f)


@exactly
def pair_sub(x: float, x_low: float, y: float, y_low: float) -> Two:
    """Return x − y."""
    return pair_add(x, x_low, -y, -y_low)


@exactly
def pair_mul(x: float, x_low: float, y: float, y_low: float) -> Two:
    """Return x·y."""
    p = x * y
    return _quick(p, fma(x, y, -p) + (x * y_low + x_low * y))


@exactly
def pair_div(x: float, x_low: float, y: float, y_low: float) -> Two:
    """Return x/y, by long division with three quotients in doubles."""
    first = x / y
    p, e = pair_mul(first, 0.0, y, y_low)
    r, r_low = pair_add(x, x_low, -p, -e)
    second = r / y
    p, e = pair_mul(second, 0.0, y, y_low)
    r, r_low = pair_add(r, r_low, -p, -e)
    s, e = _quick(first, second)
    return _quick(s, e + r / y)


@exactly
def pair_abs(x: float, x_low: float) -> Two:
    """Return |x|."""
    return abs(x), (-x_low if x < 0.0 else x_low)


@exactly
def pair_sqrt(x: float, x_low: float) -> Two:
    """Return the square root; nan where x is negative."""
    root = np.sqrt(x)
    p = root * root
    r, r_low = pair_add(x, x_low, -p, -fma(root, root, -p))
    low = (r + r_low) / (2.0 * root) if root > 0.0 else 0.0
    return _quick(root, low)


@exactly
def _shrunk(x: float, x_low: float) -> tuple[float, float, float]:
    """exp(x − k ln 2) − 1, and 2ᵏ."""
    k = np.floor(min(max(x, -708.0), 709.0) / _LN2[0] + 0.5)
    p, e = pair_mul(k, 0.0, _LN2[0], _LN2[1])
    r, r_low = pair_add(x, x_low, -p, -e)
    r, r_low = _SMALLER * r, _SMALLER * r_low
    rest = _EXP_REST[6]
    for n in range(5, -1, -1):
        rest = rest * r + _EXP_REST[n]
    m, low = _two_sum(_EXP[6][0], rest * r)
    low += _EXP[6][1]
    for n in range(5, 0, -1):
        m, low = pair_mul(m, low, r, r_low)
        m, low = pair_add(m, low, _EXP[n][0], _EXP[n][1])
    m, low = pair_mul(m, low, r, r_low)
    for _ in range(_EXP_HALVINGS):
        p, e = pair_mul(m, low, m, low)
        m, low = pair_add(2.0 * m, 2.0 * low, p, e)
    return m, low, power_of_two(k)


@exactly
def pair_exp(x: float, x_low: float) -> Two:
    """Return the exponential; 0 below −708, where doubles end, and infinity above 709."""
    y = min(max(x, -708.0), 709.0)
    m, low, size = _shrunk(y, x_low if y == x else 0.0)
    m, low = pair_add(m, low, 1.0, 0.0)
    high, low = size * m, size * low
    high, low = (0.0, 0.0) if x < -708.0 else (high, low)
    high, low = (np.inf, 0.0) if x > 709.0 else (high, low)
    return (high, low) if x == x else (x, x)


@exactly
def pair_sinhcosh(x: float, x_low: float) -> Four:
    """Return sinh x and cosh x, |x| ≤ 708; sinh with its relative accuracy for small x."""
    y, y_low = pair_abs(x, x_low)
    m, low, size = _shrunk(y, y_low)
    e, e_low = pair_add(m, low, 1.0, 0.0)
    e, e_low = size * e, size * e_low
    less, less_low = pair_add(e, e_low, -1.0, 0.0)
    less, less_low = (m, low) if size == 1.0 else (less, less_low)
    back, back_low = pair_div(1.0, 0.0, e, e_low)
    p, p_low = pair_mul(less, less_low, back, back_low)
    s, s_low = pair_add(less, less_low, p, p_low)
    c, c_low = pair_add(e, e_low, back, back_low)
    half = -0.5 if x < 0.0 else 0.5
    return half * s, half * s_low, 0.5 * c, 0.5 * c_low


@exactly
def _series(first: int, r: float, r_low: float, s: float, s_low: float) -> Two:
    """Return the series of sine (1) or cosine (0) of r, s = r²."""
    rest = _TURN_REST[12 + first]
    for n in range(10 + first, -1, -2):
        rest = rest * s + _TURN_REST[n]
    total, low = _two_sum(_TURN[14 + first][0], rest * s)
    low += _TURN[14 + first][1]
    for n in range(12 + first, -1, -2):
        total, low = pair_mul(total, low, s, s_low)
        total, low = pair_add(total, low, _TURN[n][0], _TURN[n][1])
    return pair_mul(total, low, r, r_low)


@exactly
def pair_sincos(x: float, x_low: float) -> Four:
    """Return sin x and cos x; |x| should stay below about 10⁶.

    Args:
        x, x_low: an angle in radians.
    """
    k = np.floor(x / _HALF_PI[0] + 0.5)
    p, e = pair_mul(k, 0.0, _HALF_PI[0], _HALF_PI[1])
    r, r_low = pair_add(x, x_low, -p, -e)
    s, s_low = pair_mul(r, r_low, r, r_low)
    sine, sine_low = _series(1, r, r_low, s, s_low)
    cosine, cosine_low = _series(0, 1.0, 0.0, s, s_low)
    turns = whole(k) & 3
    odd = (turns & 1) == 1
    first, first_low = (cosine, cosine_low) if odd else (sine, sine_low)
    second, second_low = (sine, sine_low) if odd else (cosine, cosine_low)
    up = -1.0 if turns >= 2 else 1.0
    along = -1.0 if (turns == 1) | (turns == 2) else 1.0
    return up * first, up * first_low, along * second, along * second_low


@exactly
def _near(s: float, s_low: float, c: float, c_low: float, d: float, d_low: float, bend: float, sign: float) -> Two:
    """S + sign·c d + bend·s d²/2 + sign·bend·c d³/6; NaN where d is too large for this series."""
    d = sign * (d if abs(d) <= _NEAR else np.nan)
    p, low = pair_mul(c, c_low, d, sign * d_low)
    half = 0.5 * bend * d * d
    p, low = pair_add(p, low, half * (s + c * d * (1.0 / 3.0)), 0.0)
    return pair_add(s, s_low, p, low)


@exactly
def pair_sincos_near(s: float, s_low: float, c: float, c_low: float, d: float, d_low: float) -> Four:
    """Return sin(x + d) and cos(x + d), |d| ≤ 2⁻³⁴.

    Args:
        s, s_low, c, c_low: sin x and cos x.
        d, d_low: the difference.
    """
    sine, sine_low = _near(s, s_low, c, c_low, d, d_low, -1.0, 1.0)
    cosine, cosine_low = _near(c, c_low, s, s_low, d, d_low, -1.0, -1.0)
    return sine, sine_low, cosine, cosine_low


@exactly
def pair_sinhcosh_near(s: float, s_low: float, c: float, c_low: float, d: float, d_low: float) -> Four:
    """Return sinh(x + d) and cosh(x + d), |d| ≤ 2⁻³⁴.

    Args:
        s, s_low, c, c_low: sinh x and cosh x.
        d, d_low: the difference.
    """
    sine, sine_low = _near(s, s_low, c, c_low, d, d_low, 1.0, 1.0)
    cosine, cosine_low = _near(c, c_low, s, s_low, d, d_low, 1.0, 1.0)
    return sine, sine_low, cosine, cosine_low


@exactly
def pair_tan(x: float, x_low: float) -> Two:
    """Return sin x/cos x.

    Args:
        x, x_low: an angle in radians.
    """
    s, s_low, c, c_low = pair_sincos(x, x_low)
    return pair_div(s, s_low, c, c_low)


@exactly
def pair_tanh(x: float, x_low: float) -> Two:
    """Return sinh x/cosh x."""
    s, s_low, c, c_low = pair_sinhcosh(x, x_low)
    return pair_div(s, s_low, c, c_low)


@exactly
def pair_sech(x: float, x_low: float) -> Two:
    """Return 1/cosh x."""
    _, _, c, c_low = pair_sinhcosh(x, x_low)
    return pair_div(1.0, 0.0, c, c_low)


@exactly
def _improved(guess: float, above: float, above_low: float, below: float, below_low: float) -> Two:
    """One step of Newton's method from a double: the guess and a small quotient."""
    step, low = pair_div(above, above_low, below, below_low)
    return pair_add(guess, 0.0, step, low)


@exactly
def pair_log(x: float, x_low: float) -> Two:
    """Return the logarithm.

    Args:
        x, x_low: a positive number.
    """
    guess = log_(x)
    back, back_low = pair_exp(-guess, 0.0)
    p, low = pair_mul(x, x_low, back, back_low)
    p, low = pair_add(p, low, -1.0, 0.0)
    return pair_add(guess, 0.0, p, low)


@exactly
def pair_asin(x: float, x_low: float) -> Two:
    """Return arcsin.

    Args:
        x, x_low: a number between −1 and 1.
    """
    guess = asin_(x)
    s, s_low, c, c_low = pair_sincos(guess, 0.0)
    p, low = pair_add(x, x_low, -s, -s_low)
    return _improved(guess, p, low, c, c_low)


@exactly
def pair_acos(x: float, x_low: float) -> Two:
    """Return arccos.

    Args:
        x, x_low: a number between −1 and 1.
    """
    p, low = pair_asin(x, x_low)
    return pair_add(_HALF_PI[0], _HALF_PI[1], -p, -low)


@exactly
def pair_atan(x: float, x_low: float) -> Two:
    """Return arctan."""
    guess = atan_(x)
    s, s_low, c, c_low = pair_sincos(guess, 0.0)
    p, low = pair_mul(x, x_low, c, c_low)
    p, low = pair_add(p, low, -s, -s_low)
    r, r_low = pair_mul(x, x_low, s, s_low)
    r, r_low = pair_add(c, c_low, r, r_low)
    return _improved(guess, p, low, r, r_low)


@exactly
def pair_asinh(x: float, x_low: float) -> Two:
    """Return arsinh."""
    guess = asinh_(x)
    s, s_low, c, c_low = pair_sinhcosh(guess, 0.0)
    p, low = pair_add(x, x_low, -s, -s_low)
    return _improved(guess, p, low, c, c_low)


@exactly
def pair_acosh(x: float, x_low: float) -> Two:
    """Return arcosh.

    Args:
        x, x_low: a number from 1 on.
    """
    guess = acosh_(x)
    s, s_low, c, c_low = pair_sinhcosh(guess, 0.0)
    p, low = pair_add(x, x_low, -c, -c_low)
    return _improved(guess, p, low, s, s_low)


@exactly
def pair_atanh(x: float, x_low: float) -> Two:
    """Return artanh.

    Args:
        x, x_low: a number between −1 and 1.
    """
    guess = atanh_(x)
    s, s_low, c, c_low = pair_sinhcosh(guess, 0.0)
    p, low = pair_mul(x, x_low, c, c_low)
    p, low = pair_add(p, low, -s, -s_low)
    r, r_low = pair_mul(x, x_low, s, s_low)
    r, r_low = pair_add(c, c_low, -r, -r_low)
    return _improved(guess, p, low, r, r_low)
