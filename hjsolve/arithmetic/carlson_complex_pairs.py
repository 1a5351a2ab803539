"""Carlson's R_C and R_J with a complex last argument a + ib, b ≠ 0, in two doubles, elementwise over arrays.

The same duplication as in ``carlson_complex``, for what doubles lose. What is outside the domain is nan.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.carlson import series_beyond_one
from hjsolve.arithmetic.carlson_pairs import (
    LAST_SPREAD,
    LAST_SPREAD_OF_RC,
    MOST_DUPLICATIONS,
    OF_RC,
    TwoDoubles,
    as_two_doubles,
    either,
)
from hjsolve.arithmetic.number_types import Complexes, Mask, Reals


@dataclass(frozen=True, eq=False)
class ComplexTwoDoubles:
    """A complex number, both parts in two doubles.

    Attributes:
        re, im: its parts.
    """

    re: TwoDoubles
    im: TwoDoubles

    def __add__(self, other: ComplexTwoDoubles | TwoDoubles | float) -> ComplexTwoDoubles:
        o = _complex(other)
        return ComplexTwoDoubles(self.re + o.re, self.im + o.im)

    def __sub__(self, other: ComplexTwoDoubles | TwoDoubles | float) -> ComplexTwoDoubles:
        o = _complex(other)
        return ComplexTwoDoubles(self.re - o.re, self.im - o.im)

    def __mul__(self, other: ComplexTwoDoubles | TwoDoubles | float) -> ComplexTwoDoubles:
        if not isinstance(other, ComplexTwoDoubles):
            return ComplexTwoDoubles(self.re * other, self.im * other)
        return ComplexTwoDoubles(
            self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re
        )  # fmt: skip

    def __truediv__(self, other: ComplexTwoDoubles | float) -> ComplexTwoDoubles:
        if not isinstance(other, ComplexTwoDoubles):
            return ComplexTwoDoubles(self.re / other, self.im / other)
        above = self * ComplexTwoDoubles(other.re, -other.im)
        size = other.re * other.re + other.im * other.im
        return ComplexTwoDoubles(above.re / size, above.im / size)

    def scaled(self, power: Reals) -> ComplexTwoDoubles:
        """Return it times a power of two."""
        return ComplexTwoDoubles(self.re.scaled(power), self.im.scaled(power))

    def root(self) -> ComplexTwoDoubles:
        """Return the principal root, its greater part first."""
        size = (self.re * self.re + self.im * self.im).root()
        greater = ((size + self.re.size()).scaled(0.5)).root()
        lesser = self.im.size() / (greater + greater)
        right, side = np.asarray(self.re.high) >= 0, np.where(np.asarray(self.im.high) < 0, -1.0, 1.0)
        return ComplexTwoDoubles(either(right, greater, lesser), either(right, lesser, greater).scaled(side))

    def rounded(self) -> Complexes:
        """Return the complex number next to it."""
        return np.asarray(self.re.high) + 1j * np.asarray(self.im.high)


def _complex(x: ComplexTwoDoubles | TwoDoubles | float) -> ComplexTwoDoubles:
    return x if isinstance(x, ComplexTwoDoubles) else ComplexTwoDoubles(as_two_doubles(x), TwoDoubles(0.0, 0.0))


def _where(condition: Mask, x: ComplexTwoDoubles) -> ComplexTwoDoubles:
    zero = TwoDoubles(0.0, 0.0)
    return ComplexTwoDoubles(either(condition, x.re, zero), either(condition, x.im, zero))


def _with_one(rest: Complexes) -> ComplexTwoDoubles:
    """Return 1 + a small number."""
    return ComplexTwoDoubles(1.0 + as_two_doubles(rest.real), as_two_doubles(rest.imag))


def rc(x: TwoDoubles, a: TwoDoubles, b: TwoDoubles) -> ComplexTwoDoubles:
    """R_C(x, a + ib), x ≥ 0."""
    return _rc(_complex(x), ComplexTwoDoubles(a, b), np.asarray(x.high) >= 0)


def _rc(x: ComplexTwoDoubles, y: ComplexTwoDoubles, good: Mask) -> ComplexTwoDoubles:
    A = (x + y + y) / 3.0
    bound = abs((y - A).rounded()) / LAST_SPREAD_OF_RC
    for _ in range(MOST_DUPLICATIONS):
        open_ = bound > abs(A.rounded())
        if not open_.any():
            break
        λ = _where(open_, x.root() * y.root() * 2.0 + y)
        quarter = np.where(open_, 0.25, 1.0)
        x, y, A, bound = (x + λ).scaled(quarter), (y + λ).scaled(quarter), (A + λ).scaled(quarter), bound * quarter
    s = ((y - A) / A).rounded()
    rest = np.zeros_like(s)
    for c in reversed(OF_RC):
        rest = rest * s + c
    value = _with_one(rest * s * s) / A.root()
    nan = TwoDoubles(np.nan, np.nan)
    return ComplexTwoDoubles(either(good, value.re, nan), either(good, value.im, nan))


def rj(x: TwoDoubles, y: TwoDoubles, z: TwoDoubles, a: TwoDoubles, b: TwoDoubles) -> ComplexTwoDoubles:
    """R_J(x, y, z, a + ib), x, y, z ≥ 0, at most one of them zero."""
    p = ComplexTwoDoubles(a, b)
    good = (np.asarray(x.high) >= 0) & (np.asarray(y.high) >= 0) & (np.asarray(z.high) >= 0)
    product = (p - x) * (p - y) * (p - z)
    A = (p + p + (x + y + z)) / 5.0
    bound = np.max([abs((A - v).rounded()) for v in (x, y, z, p)], axis=0) / LAST_SPREAD
    weight, total = np.ones_like(bound), _complex(TwoDoubles(np.zeros_like(bound)))
    for _ in range(MOST_DUPLICATIONS):
        open_ = bound > abs(A.rounded())
        if not open_.any():
            break
        (sx, sy, sz), sp = (v.root() for v in (x, y, z)), p.root()
        λ = either(open_, sx * (sy + sz) + sy * sz, TwoDoubles(0.0, 0.0))
        d = (sp + sx) * (sp + sy) * (sp + sz)
        e = product.scaled(weight**3) / (d * d)
        # arctan √e/√e = R_C(1, 1 + e)
        part = _rc(_complex(1.0), e + 1.0, open_).scaled(weight)
        total = total + _where(open_, part / d)
        quarter = np.where(open_, 0.25, 1.0)
        x, y, z = ((v + λ).scaled(quarter) for v in (x, y, z))
        p, A, bound, weight = (p + λ).scaled(quarter), (A + λ).scaled(quarter), bound * quarter, weight * quarter
    X, Y, Z = (((A - v) / A).rounded() for v in (x, y, z))
    last = _with_one(series_beyond_one(X, Y, Z, -(X + Y + Z) / 2)) / (A * A.root())
    value, nan = last.scaled(weight) + total * 6.0, TwoDoubles(np.nan, np.nan)
    return ComplexTwoDoubles(either(good, value.re, nan), either(good, value.im, nan))


def part_at_a_complex_pole(name: str, *arguments: TwoDoubles) -> TwoDoubles:
    """Return a part of R_C or R_J.

    Args:
        name: CarlsonRCRe, CarlsonRCIm, CarlsonRJRe or CarlsonRJIm.
        arguments: of it.
    """
    value = (rc if name.startswith("CarlsonRC") else rj)(*arguments)
    return value.re if name.endswith("Re") else value.im
