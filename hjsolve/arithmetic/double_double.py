"""Numbers in two doubles, |low| at most half a unit of high: one text, over arrays and for the lanes of the machine.

Dekker, Numer. Math. 18 (1971) 224; Knuth, TAOCP 2, §4.2.2; Hida, Li & Bailey, ARITH-15 (2001) 155. Each operation is
good to a few units of 2⁻¹⁰⁴ of the size of its operands, functions to about 2⁻¹⁰⁰. Terms of a series that are below
2⁻⁵⁰ of its sum are summed in doubles. Numpy runs the functions as they stand, ``machine.pairs`` compiles them, with
words of its own for those below: so nothing here branches, and nothing may be reordered. Arguments of sin and cos are
reduced by π/2 in two doubles, so they should stay below about 10⁶.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from hjsolve.arithmetic.error_free import Pair, exact, quick_two_sum, two_product, two_sum
from hjsolve.arithmetic.function_rules import ByOthers
from hjsolve.arithmetic.number_types import Elementwise

# words that the machine has its own for
chosen = np.where
power_of_two = np.exp2
log_, asin_, atan_ = np.log, np.arcsin, np.arctan
asinh_, acosh_, atanh_ = np.arcsinh, np.arccosh, np.arctanh

_LN2 = (0.6931471805599453, 2.3190468138462996e-17)
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
_EXP_HALVINGS = 5  # of the argument of exp, whose series has seven terms
_NEAR = 2.0**-34
_FLAT = 40.0  # from here on 1 − tanh x < 2⁻¹¹⁴
_SMALLER = 2.0**-_EXP_HALVINGS

_EXP = tuple((float(c.high), float(c.low)) for c in (exact(Fraction(1, math.factorial(k))) for k in range(7)))
_EXP_REST = tuple(1.0 / math.factorial(k) for k in range(7, 14))
_TURN = tuple(
    (float(c.high), float(c.low)) for c in (exact(Fraction((-1) ** (k // 2), math.factorial(k))) for k in range(16))
)
_TURN_REST = tuple((-1.0) ** (k // 2) / math.factorial(k) for k in range(16, 30))
Two = tuple[Elementwise, Elementwise]
Four = tuple[Elementwise, Elementwise, Elementwise, Elementwise]
PLACES = {"sin": ("sincos", 0), "cos": ("sincos", 2), "sinh": ("sinhcosh", 0), "cosh": ("sinhcosh", 2)}
"""Functions that come with another: what is called, and which of its results they are."""


def pair_add(x: Elementwise, x_low: Elementwise, y: Elementwise, y_low: Elementwise) -> Two:
    """Return x + y."""
    s, e = two_sum(x, y)
    t, f = two_sum(x_low, y_low)
    s, e = quick_two_sum(s, e + t)
    return quick_two_sum(s, e + f)


def pair_sub(x: Elementwise, x_low: Elementwise, y: Elementwise, y_low: Elementwise) -> Two:
    """Return x − y."""
    return pair_add(x, x_low, -y, -y_low)


def pair_mul(x: Elementwise, x_low: Elementwise, y: Elementwise, y_low: Elementwise) -> Two:
    """Return x·y."""
    p, e = two_product(x, y)
    return quick_two_sum(p, e + (x * y_low + x_low * y))


def pair_div(x: Elementwise, x_low: Elementwise, y: Elementwise, y_low: Elementwise) -> Two:
    """Return x/y, by long division with three quotients in doubles."""
    first = x / y
    p, e = pair_mul(first, 0.0, y, y_low)
    r, r_low = pair_add(x, x_low, -p, -e)
    second = r / y
    p, e = pair_mul(second, 0.0, y, y_low)
    r, r_low = pair_add(r, r_low, -p, -e)
    s, e = quick_two_sum(first, second)
    return quick_two_sum(s, e + r / y)


def pair_abs(x: Elementwise, x_low: Elementwise) -> Two:
    """Return |x|."""
    return abs(x), chosen(x < 0.0, -x_low, x_low)


def pair_sqrt(x: Elementwise, x_low: Elementwise) -> Two:
    """Return the square root; nan where x is negative."""
    root = np.sqrt(x)
    p, e = two_product(root, root)
    r, r_low = pair_add(x, x_low, -p, -e)
    return quick_two_sum(root, (r + r_low) / chosen(root > 0.0, 2.0 * root, 1.0))


def _within(x: Elementwise, least: float, most: float) -> Elementwise:
    """Return the number of an interval that is next to x."""
    return chosen(x < least, least, chosen(x > most, most, x))


def _shrunk(x: Elementwise, x_low: Elementwise) -> tuple[float, float, float]:
    """exp(x − k ln 2) − 1, and 2ᵏ."""
    k = np.floor(_within(x, -708.0, 709.0) / _LN2[0] + 0.5)
    p, e = pair_mul(k, 0.0, _LN2[0], _LN2[1])
    r, r_low = pair_add(x, x_low, -p, -e)
    r, r_low = _SMALLER * r, _SMALLER * r_low
    rest = _EXP_REST[6]
    for n in range(5, -1, -1):
        rest = rest * r + _EXP_REST[n]
    m, low = two_sum(_EXP[6][0], rest * r)
    low += _EXP[6][1]
    for n in range(5, 0, -1):
        m, low = pair_mul(m, low, r, r_low)
        m, low = pair_add(m, low, _EXP[n][0], _EXP[n][1])
    m, low = pair_mul(m, low, r, r_low)
    for _ in range(_EXP_HALVINGS):
        p, e = pair_mul(m, low, m, low)
        m, low = pair_add(2.0 * m, 2.0 * low, p, e)
    return m, low, power_of_two(k)


def pair_exp(x: Elementwise, x_low: Elementwise) -> Two:
    """Return the exponential; 0 below −708, where doubles end, and infinity above 709."""
    y = _within(x, -708.0, 709.0)
    inside = x == y
    m, low, size = _shrunk(y, chosen(inside, x_low, 0.0))
    m, low = pair_add(m, low, 1.0, 0.0)
    beyond = chosen(x < -708.0, 0.0, chosen(x > 709.0, np.inf, x))
    return chosen(inside, size * m, beyond), chosen(inside, size * low, 0.0)


def pair_sinhcosh(x: Elementwise, x_low: Elementwise) -> Four:
    """Return sinh x and cosh x, |x| ≤ 708; sinh with its relative accuracy for small x."""
    y, y_low = pair_abs(x, x_low)
    m, low, size = _shrunk(y, y_low)
    e, e_low = pair_add(m, low, 1.0, 0.0)
    e, e_low = size * e, size * e_low
    less, less_low = pair_add(e, e_low, -1.0, 0.0)
    less, less_low = chosen(size == 1.0, m, less), chosen(size == 1.0, low, less_low)
    back, back_low = pair_div(1.0, 0.0, e, e_low)
    p, p_low = pair_mul(less, less_low, back, back_low)
    s, s_low = pair_add(less, less_low, p, p_low)
    c, c_low = pair_add(e, e_low, back, back_low)
    half = chosen(x < 0.0, -0.5, 0.5)
    return half * s, half * s_low, 0.5 * c, 0.5 * c_low


def _series(first: int, r: Elementwise, r_low: Elementwise, s: Elementwise, s_low: Elementwise) -> Two:
    """Return the series of sine (1) or cosine (0) of r, s = r²."""
    rest = _TURN_REST[12 + first]
    for n in range(10 + first, -1, -2):
        rest = rest * s + _TURN_REST[n]
    total, low = two_sum(_TURN[14 + first][0], rest * s)
    low += _TURN[14 + first][1]
    for n in range(12 + first, -1, -2):
        total, low = pair_mul(total, low, s, s_low)
        total, low = pair_add(total, low, _TURN[n][0], _TURN[n][1])
    return pair_mul(total, low, r, r_low)


def pair_sincos(x: Elementwise, x_low: Elementwise) -> Four:
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
    turns = k - 4.0 * np.floor(0.25 * k)
    odd = (turns == 1.0) | (turns == 3.0)
    first, first_low = chosen(odd, cosine, sine), chosen(odd, cosine_low, sine_low)
    second, second_low = chosen(odd, sine, cosine), chosen(odd, sine_low, cosine_low)
    up = chosen(turns >= 2.0, -1.0, 1.0)
    along = chosen((turns == 1.0) | (turns == 2.0), -1.0, 1.0)
    return up * first, up * first_low, along * second, along * second_low


def _near(
    s: Elementwise,
    s_low: Elementwise,
    c: Elementwise,
    c_low: Elementwise,
    d: Elementwise,
    d_low: Elementwise,
    bend: Elementwise,
    sign: Elementwise,
) -> Two:
    """S + sign·c d + bend·s d²/2 + sign·bend·c d³/6; NaN where d is too large for this series."""
    d = sign * chosen(abs(d) <= _NEAR, d, np.nan)
    p, low = pair_mul(c, c_low, d, sign * d_low)
    half = 0.5 * bend * d * d
    p, low = pair_add(p, low, half * (s + c * d * (1.0 / 3.0)), 0.0)
    return pair_add(s, s_low, p, low)


def pair_sincos_near(
    s: Elementwise, s_low: Elementwise, c: Elementwise, c_low: Elementwise, d: Elementwise, d_low: Elementwise
) -> Four:
    """Return sin(x + d) and cos(x + d), |d| ≤ 2⁻³⁴.

    Args:
        s, s_low, c, c_low: sin x and cos x.
        d, d_low: the difference.
    """
    sine, sine_low = _near(s, s_low, c, c_low, d, d_low, -1.0, 1.0)
    cosine, cosine_low = _near(c, c_low, s, s_low, d, d_low, -1.0, -1.0)
    return sine, sine_low, cosine, cosine_low


def pair_sinhcosh_near(
    s: Elementwise, s_low: Elementwise, c: Elementwise, c_low: Elementwise, d: Elementwise, d_low: Elementwise
) -> Four:
    """Return sinh(x + d) and cosh(x + d), |d| ≤ 2⁻³⁴.

    Args:
        s, s_low, c, c_low: sinh x and cosh x.
        d, d_low: the difference.
    """
    sine, sine_low = _near(s, s_low, c, c_low, d, d_low, 1.0, 1.0)
    cosine, cosine_low = _near(c, c_low, s, s_low, d, d_low, 1.0, 1.0)
    return sine, sine_low, cosine, cosine_low


def pair_tan(x: Elementwise, x_low: Elementwise) -> Two:
    """Return sin x/cos x.

    Args:
        x, x_low: an angle in radians.
    """
    s, s_low, c, c_low = pair_sincos(x, x_low)
    return pair_div(s, s_low, c, c_low)


def pair_tanh(x: Elementwise, x_low: Elementwise) -> Two:
    """Return sinh x/cosh x."""
    y = _within(x, -_FLAT, _FLAT)
    s, s_low, c, c_low = pair_sinhcosh(y, chosen(x == y, x_low, 0.0))
    return pair_div(s, s_low, c, c_low)


def pair_sech(x: Elementwise, x_low: Elementwise) -> Two:
    """Return 1/cosh x."""
    y, y_low = pair_abs(x, x_low)
    e, e_low = pair_exp(-y, -y_low)
    p, low = pair_mul(e, e_low, e, e_low)
    p, low = pair_add(1.0, 0.0, p, low)
    return pair_div(2.0 * e, 2.0 * e_low, p, low)


def _improved(
    guess: Elementwise, above: Elementwise, above_low: Elementwise, below: Elementwise, below_low: Elementwise
) -> Two:
    """One step of Newton's method from a double: the guess and a small quotient."""
    step, low = pair_div(above, above_low, below, below_low)
    return pair_add(guess, 0.0, step, low)


def pair_log(x: Elementwise, x_low: Elementwise) -> Two:
    """Return the logarithm.

    Args:
        x, x_low: a positive number.
    """
    guess = log_(x)
    back, back_low = pair_exp(-guess, 0.0)
    p, low = pair_mul(x, x_low, back, back_low)
    p, low = pair_add(p, low, -1.0, 0.0)
    return pair_add(guess, 0.0, p, low)


def pair_asin(x: Elementwise, x_low: Elementwise) -> Two:
    """Return arcsin.

    Args:
        x, x_low: a number between −1 and 1.
    """
    guess = asin_(x)
    s, s_low, c, c_low = pair_sincos(guess, 0.0)
    p, low = pair_add(x, x_low, -s, -s_low)
    return _improved(guess, p, low, c, c_low)


def pair_acos(x: Elementwise, x_low: Elementwise) -> Two:
    """Return arccos.

    Args:
        x, x_low: a number between −1 and 1.
    """
    p, low = pair_asin(x, x_low)
    return pair_add(_HALF_PI[0], _HALF_PI[1], -p, -low)


def pair_atan(x: Elementwise, x_low: Elementwise) -> Two:
    """Return arctan."""
    guess = atan_(x)
    s, s_low, c, c_low = pair_sincos(guess, 0.0)
    p, low = pair_mul(x, x_low, c, c_low)
    p, low = pair_add(p, low, -s, -s_low)
    r, r_low = pair_mul(x, x_low, s, s_low)
    r, r_low = pair_add(c, c_low, r, r_low)
    return _improved(guess, p, low, r, r_low)


def pair_asinh(x: Elementwise, x_low: Elementwise) -> Two:
    """Return arsinh."""
    guess = asinh_(x)
    s, s_low, c, c_low = pair_sinhcosh(guess, 0.0)
    p, low = pair_add(x, x_low, -s, -s_low)
    return _improved(guess, p, low, c, c_low)


def pair_acosh(x: Elementwise, x_low: Elementwise) -> Two:
    """Return arcosh.

    Args:
        x, x_low: a number from 1 on.
    """
    guess = acosh_(x)
    s, s_low, c, c_low = pair_sinhcosh(guess, 0.0)
    p, low = pair_add(x, x_low, -c, -c_low)
    return _improved(guess, p, low, s, s_low)


def pair_atanh(x: Elementwise, x_low: Elementwise) -> Two:
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


@dataclass(frozen=True, slots=True)
class DoubleDouble(ByOthers):
    """Arithmetic on ``Pair`` values, elementwise over arrays."""

    def rational(self, numerator: int, denominator: int) -> Pair:
        """Return the two doubles next to a fraction."""
        return exact(Fraction(numerator, denominator))

    def pi(self) -> Pair:
        return Pair(*(2 * part for part in _HALF_PI))

    def add(self, x: Pair, y: Pair) -> Pair:
        """Return x + y, by Knuth's sums without loss of both parts."""
        return Pair(*pair_add(*x, *y))

    def mul(self, x: Pair, y: Pair) -> Pair:
        """Return x·y; the product of the low parts is below the rounding."""
        return Pair(*pair_mul(*x, *y))

    def div(self, x: Pair, y: Pair) -> Pair:
        """Return x/y, by long division with three quotients in doubles."""
        return Pair(*pair_div(*x, *y))

    def unary(self, name: str, x: Pair) -> Pair:
        """Return a function of x, good to about 2⁻¹⁰⁰."""
        if name == "neg":
            return Pair(-x.high, -x.low)
        function, place = PLACES.get(name, (name, 0))
        return Pair(*globals()[f"pair_{function}"](*x)[place : place + 2])
