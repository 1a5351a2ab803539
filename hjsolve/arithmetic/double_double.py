"""Thirty-two digits over whole arrays: numbers as unevaluated sums of two doubles.

Dekker, Numer. Math. 18 (1971) 224; Knuth, TAOCP 2, §4.2.2; Hida, Li & Bailey, ARITH-15 (2001) 155. Each operation is
good to a few units of 2⁻¹⁰⁴ of the size of its operands; elementary functions to about 2⁻¹⁰⁰. Arguments of sin and cos
are reduced by π/2 in two doubles, so they should stay below about 10⁶.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import factorial

import numpy as np

from hjsolve.arithmetic.error_free import Pair, exact, quick_two_sum, two_product, two_sum
from hjsolve.arithmetic.function_rules import ByOthers
from hjsolve.arithmetic.number_types import Elementwise

_LN2 = (0.6931471805599453, 2.3190468138462996e-17)
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
_EXP_HALVINGS = 9  # of the argument of exp, |r| ≤ log(2)/2: (7e-4)¹⁰/10! is 1e-38


@cache
def _coefficients(start: int, step: int, count: int, alternate: bool) -> tuple[Pair, ...]:
    """Return 1/start!, ±1/(start + step)!, … in turn."""
    signs = [(-1) ** k if alternate else 1 for k in range(count)]
    return tuple(exact(Fraction(sign, factorial(start + step * k))) for k, sign in enumerate(signs))


@dataclass(frozen=True, slots=True)
class DoubleDouble(ByOthers):
    """Arithmetic on ``Pair`` values, elementwise over arrays."""

    def rational(self, numerator: int, denominator: int) -> Pair:
        """Return the two doubles next to a fraction."""
        return exact(Fraction(numerator, denominator))

    def pi(self) -> Pair:
        return Pair(2 * _HALF_PI[0], 2 * _HALF_PI[1])

    def add(self, x: Pair, y: Pair) -> Pair:
        """Return x + y, by Knuth's sums without loss of both parts."""
        s, e = two_sum(x.high, y.high)
        t, f = two_sum(x.low, y.low)
        s, e = quick_two_sum(s, e + t)
        return quick_two_sum(s, e + f)

    def mul(self, x: Pair, y: Pair) -> Pair:
        """Return x·y; the product of the low parts is below the rounding."""
        p, e = two_product(x.high, y.high)
        return quick_two_sum(p, e + (x.high * y.low + x.low * y.high))

    def div(self, x: Pair, y: Pair) -> Pair:
        """Return x/y, by long division with three quotients in doubles."""
        first = x.high / y.high
        rest = self.sub(x, self.mul(Pair(first, 0.0), y))
        second = rest.high / y.high
        rest = self.sub(rest, self.mul(Pair(second, 0.0), y))
        s, e = quick_two_sum(first, second)
        return quick_two_sum(s, e + rest.high / y.high)

    def unary(self, name: str, x: Pair) -> Pair:
        """Return a function of x, good to about 2⁻¹⁰⁰."""
        result: Pair = getattr(self, f"_{name}")(x)
        return result

    def _scaled(self, x: Pair, factor: Elementwise) -> Pair:
        """Return times a power of two."""
        return Pair(x.high * factor, x.low * factor)

    def _neg(self, x: Pair) -> Pair:
        return Pair(-x.high, -x.low)

    def _abs(self, x: Pair) -> Pair:
        sign = np.where(np.asarray(x.high) < 0, -1.0, 1.0)
        return self._scaled(x, sign)

    def _sqrt(self, x: Pair) -> Pair:
        root = np.sqrt(x.high)
        rest = self.sub(x, two_product(root, root))
        low = np.where(root > 0, (rest.high + rest.low) / np.where(root > 0, 2 * root, 1.0), 0.0)
        return quick_two_sum(root, low)

    def _series(self, x: Pair, coefficients: tuple[Pair, ...]) -> Pair:
        total = coefficients[-1]
        for c in coefficients[-2::-1]:
            total = self.add(self.mul(total, x), c)
        return total

    def _reduced(self, x: Pair) -> tuple[Pair, Elementwise]:
        """Return exp(x − k ln 2) − 1 and k."""
        k = np.rint(x.high / _LN2[0])
        r = self._scaled(self.sub(x, self.mul(Pair(k, 0.0), Pair(*_LN2))), 2.0**-_EXP_HALVINGS)
        m = self.mul(r, self._series(r, _coefficients(1, 1, 9, False)))
        for _ in range(_EXP_HALVINGS):
            m = self.add(self._scaled(m, 2.0), self.mul(m, m))
        return m, k

    def _expm1(self, x: Pair) -> Pair:
        """Return exp(x) − 1, with its relative accuracy for small x."""
        m, k = self._reduced(x)
        size = np.exp2(k)
        scaled = self.add(self._scaled(m, size), Pair(size - 1.0, 0.0))
        whole = k == 0
        return Pair(np.where(whole, m.high, scaled.high), np.where(whole, m.low, scaled.low))

    def _exp(self, x: Pair) -> Pair:
        m, k = self._reduced(x)
        return self._scaled(self.add(m, Pair(1.0, 0.0)), np.exp2(k))

    def _sinh(self, x: Pair) -> Pair:
        m = self._expm1(self._abs(x))
        half = self._scaled(self.add(m, self.div(m, self.add(m, Pair(1.0, 0.0)))), 0.5)
        return self._scaled(half, np.where(np.asarray(x.high) < 0, -1.0, 1.0))

    def _cosh(self, x: Pair) -> Pair:
        e = self._exp(self._abs(x))
        return self._scaled(self.add(e, self.div(Pair(1.0, 0.0), e)), 0.5)

    def _tanh(self, x: Pair) -> Pair:
        return self.div(self._sinh(x), self._cosh(x))

    def _sech(self, x: Pair) -> Pair:
        e = self._exp(self._scaled(self._abs(x), -1.0))
        return self._scaled(self.div(e, self.add(Pair(1.0, 0.0), self.mul(e, e))), 2.0)

    def _turned(self, x: Pair) -> tuple[Pair, Pair, Elementwise]:
        """Sin and cos of the argument less a multiple of π/2, and that multiple modulo 4."""
        k = np.rint(x.high / _HALF_PI[0])
        r = self.sub(x, self.mul(Pair(k, 0.0), Pair(*_HALF_PI)))
        square = self.mul(r, r)
        sine = self.mul(r, self._series(square, _coefficients(1, 2, 15, True)))
        cosine = self._series(square, _coefficients(0, 2, 15, True))
        return sine, cosine, np.mod(k, 4)

    def _sin(self, x: Pair) -> Pair:
        sine, cosine, k = self._turned(x)
        sign = np.where(k >= 2, -1.0, 1.0)
        odd = np.mod(k, 2) == 1
        return Pair(sign * np.where(odd, cosine.high, sine.high), sign * np.where(odd, cosine.low, sine.low))

    def _cos(self, x: Pair) -> Pair:
        sine, cosine, k = self._turned(x)
        sign = np.where((k == 1) | (k == 2), -1.0, 1.0)
        odd = np.mod(k, 2) == 1
        return Pair(sign * np.where(odd, sine.high, cosine.high), sign * np.where(odd, sine.low, cosine.low))

    def _tan(self, x: Pair) -> Pair:
        return self.div(self._sin(x), self._cos(x))

    def _improved(self, guess: Elementwise, above: Pair, below: Pair) -> Pair:
        """One step of Newton's method from a double: the guess and a small quotient."""
        return self.add(Pair(guess, 0.0), self.div(above, below))

    def _log(self, x: Pair) -> Pair:
        guess = np.log(x.high)
        back = self._exp(Pair(-guess, 0.0 * guess))
        return self._improved(guess, self.sub(self.mul(x, back), Pair(1.0, 0.0)), Pair(1.0, 0.0))

    def _asin(self, x: Pair) -> Pair:
        guess = Pair(np.arcsin(x.high), 0.0)
        return self._improved(guess.high, self.sub(x, self._sin(guess)), self._cos(guess))

    def _acos(self, x: Pair) -> Pair:
        return self.sub(Pair(*_HALF_PI), self._asin(x))

    def _atan(self, x: Pair) -> Pair:
        guess = Pair(np.arctan(x.high), 0.0)
        s, c = self._sin(guess), self._cos(guess)
        return self._improved(guess.high, self.sub(self.mul(x, c), s), self.add(c, self.mul(x, s)))

    def _asinh(self, x: Pair) -> Pair:
        guess = Pair(np.arcsinh(x.high), 0.0)
        return self._improved(guess.high, self.sub(x, self._sinh(guess)), self._cosh(guess))

    def _acosh(self, x: Pair) -> Pair:
        guess = Pair(np.arccosh(x.high), 0.0)
        return self._improved(guess.high, self.sub(x, self._cosh(guess)), self._sinh(guess))

    def _atanh(self, x: Pair) -> Pair:
        guess = Pair(np.arctanh(x.high), 0.0)
        s, c = self._sinh(guess), self._cosh(guess)
        return self._improved(guess.high, self.sub(self.mul(x, c), s), self.sub(c, self.mul(x, s)))
