"""Real and imaginary parts of R_C(x, a + ib) and R_J(x, y, z, a + ib): real functions of real arguments.

A rational integrand with a pole at a complex place has the conjugate pole as well; what both give together is real.
Derivatives are those of R_C and R_J (DLMF 19.18) by Cauchy and Riemann.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import mpmath
import sympy as sp
from sympy.core.function import ArgumentIndexError
from sympy.core.sorting import ordered

from hjsolve.functions.carlson import CarlsonRD
from hjsolve.functions.many_digits import remembered
from hjsolve.functions.printing import Printable
from hjsolve.precision import for_any_context, mp

if TYPE_CHECKING:
    from sympy.printing.str import StrPrinter

Parts = tuple[sp.Expr, sp.Expr]
"""Real and imaginary part."""
_HERE, _COMPLEX_DOUBLES = "hjsolve.functions.complex_pole", "hjsolve.arithmetic.carlson_complex"


@for_any_context
def carlson_rcre(x: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """Return Re R_C(x, a + ib), DLMF 19.2.17.

    Args:
        x: not negative.
        a, b: real and imaginary part of the last argument.

    Raises:
        ValueError: an argument outside of these.
    """
    return mp.re(_rc(x, a, b))


@for_any_context
def carlson_rcim(x: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """Return Im R_C(x, a + ib), DLMF 19.2.17.

    Args:
        x: not negative.
        a, b: real and imaginary part of the last argument.

    Raises:
        ValueError: an argument outside of these.
    """
    return mp.im(_rc(x, a, b))


@remembered
def _rc(x: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpc:
    if mp.im(x) != 0 or mp.im(a) != 0 or mp.im(b) != 0 or x < 0:
        raise ValueError("R_C(x, a + ib) needs x ≥ 0 and real a, b")
    return mp.elliprc(x, mp.mpc(a, b))


@for_any_context
def carlson_rjre(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """Return Re R_J(x, y, z, a + ib), DLMF 19.16.2.

    Args:
        x, y, z: none of them negative.
        a, b: real and imaginary part of the last argument.

    Raises:
        ValueError: an argument outside of these.
    """
    return mp.re(_rj(x, y, z, a, b))


@for_any_context
def carlson_rjim(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """Return Im R_J(x, y, z, a + ib), DLMF 19.16.2.

    Args:
        x, y, z: none of them negative.
        a, b: real and imaginary part of the last argument.

    Raises:
        ValueError: an argument outside of these.
    """
    return mp.im(_rj(x, y, z, a, b))


@remembered
def _rj(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpc:
    if any(mp.im(v) != 0 for v in (x, y, z, a, b)) or min(x, y, z) < 0:
        raise ValueError("R_J(x, y, z, a + ib) needs x, y, z ≥ 0 and real a, b")
    with mp.extraprec(20):
        return _duplicated(mp.mpf(x), mp.mpf(y), mp.mpf(z), mp.mpc(a, b))


def _duplicated(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, p: mpmath.mpc) -> mpmath.mpc:
    """Carlson, Numer. Algorithms 10 (1995) 13, (2.17)–(2.26); mpmath's own integrates numerically for Re p < 0."""
    A = (x + y + z + 2 * p) / 5
    bound = max(abs(A - v) for v in (x, y, z, p)) / mp.root(mp.eps / 4, 6)
    product, total, weight = (p - x) * (p - y) * (p - z), mp.mpc(0), mp.mpf(1)
    while bound > abs(A):
        roots, last = [mp.sqrt(v) for v in (x, y, z)], mp.sqrt(p)
        λ = roots[0] * roots[1] + roots[0] * roots[2] + roots[1] * roots[2]
        d = (last + roots[0]) * (last + roots[1]) * (last + roots[2])
        w = mp.sqrt(product / (d * d))
        total += weight / d * (mp.atan(w) / w if w else 1)
        weight, product, bound = weight / 4, product / 64, bound / 4
        x, y, z, p, A = (x + λ) / 4, (y + λ) / 4, (z + λ) / 4, (p + λ) / 4, (A + λ) / 4
    X, Y, Z = (A - x) / A, (A - y) / A, (A - z) / A
    P = -(X + Y + Z) / 2
    E2 = X * Y + X * Z + Y * Z - 3 * P * P
    E3 = X * Y * Z + 2 * E2 * P + 4 * P**3
    E4, E5 = (2 * X * Y * Z + E2 * P + 3 * P**3) * P, X * Y * Z * P * P
    series = 1 - 3 * E2 / 14 + E3 / 6 + 9 * E2 * E2 / 88 - 3 * E4 / 22 - 9 * E2 * E3 / 52 + 3 * E5 / 26
    return weight * series / (A * mp.sqrt(A)) + 6 * total


class ComplexPole(Printable):
    """What the four functions share: the last two arguments are a and b of the complex argument a + ib.

    Attributes:
        part: 0 of the real part, 1 of the imaginary one.
    """

    part: ClassVar[int]
    doubles, many_digits = _COMPLEX_DOUBLES, _HERE

    def _parts(self) -> Parts:
        """Return this function and its twin, the real part first."""
        both = _BOTH[type(self)]
        return both[0](*self.args), both[1](*self.args)

    def _by_argument(self, value: Parts, over: Parts) -> sp.Expr:
        return divided(value, over)[self.part]

    def _latex(self, printer: StrPrinter, exp: str | None = None) -> str:
        *first, a, b = self.args
        place = printer._print(a + sp.I * b)
        inner = ", ".join([*(printer._print(argument) for argument in first), place])
        head, power = (r"\operatorname{Re}", r"\operatorname{Im}")[self.part], "" if exp is None else f"^{{{exp}}}"
        return rf"{head}{power} {self.letter[:3].replace('_', '_{') + '}'}\left({inner}\right)"


class _RC(ComplexPole):
    nargs = 3

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_C/∂x = (R_C − 1/√x)/(2(y − x)), ∂R_C/∂y = (√x/y − R_C)/(2(y − x)), y = a + ib."""
        x, a, b = self.args
        re, im = self._parts()
        twice = (2 * (a - x), 2 * b)
        if argindex == 1:
            return self._by_argument((re - 1 / sp.sqrt(x), im), twice)
        if argindex not in {2, 3}:
            raise ArgumentIndexError(self, argindex)
        first = divided((sp.sqrt(x), sp.S.Zero), (a, b))
        slope = divided((first[0] - re, first[1] - im), twice)
        return _turned(slope, argindex == 3)[self.part]


class CarlsonRCRe(_RC):
    """Re R_C(x, a + ib), x ≥ 0, b ≠ 0 or a > 0."""

    letter, part, value = "R_Cre", 0, staticmethod(carlson_rcre)


class CarlsonRCIm(_RC):
    """Im R_C(x, a + ib), x ≥ 0, b ≠ 0 or a > 0."""

    letter, part, value = "R_Cim", 1, staticmethod(carlson_rcim)


class _RJ(ComplexPole):
    nargs = 5

    @classmethod
    def eval(cls, x: sp.Expr, y: sp.Expr, z: sp.Expr, a: sp.Expr, b: sp.Expr) -> sp.Expr | None:
        """Order x, y, z.

        Args:
            x, y, z: the symmetric arguments.
            a, b: real and imaginary part of the last one.
        """
        arranged = tuple(ordered((x, y, z)))
        return cls(*arranged, a, b) if arranged != (x, y, z) else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_J/∂x = (R_J − R_D(y, z, x))/(2(p − x)); ∂/∂p by homogeneity, DLMF 19.18.11; p = a + ib."""
        if not 1 <= argindex <= 5:
            raise ArgumentIndexError(self, argindex)
        if argindex <= 3:
            return self._by_symmetric(argindex - 1)[self.part]
        *first, a, b = self.args
        re, im = self._parts()
        three_halves = sp.Rational(3, 2)
        slopes = [self._by_symmetric(k) for k in range(3)]
        total = [
            three_halves * own + sp.Add(*(x * slope[k] for x, slope in zip(first, slopes, strict=True)))
            for k, own in enumerate((re, im))
        ]
        slope = divided((-total[0], -total[1]), (a, b))
        return _turned(slope, argindex == 5)[self.part]

    def _by_symmetric(self, k: int) -> Parts:
        *first, a, b = self.args
        mine, others = first[k], [x for j, x in enumerate(first) if j != k]
        re, im = self._parts()
        return divided((re - CarlsonRD(*others, mine), im), (2 * (a - mine), 2 * b))


class CarlsonRJRe(_RJ):
    """Re R_J(x, y, z, a + ib), x, y, z ≥ 0, b ≠ 0 or a > 0."""

    letter, part, value = "R_Jre", 0, staticmethod(carlson_rjre)


class CarlsonRJIm(_RJ):
    """Im R_J(x, y, z, a + ib), x, y, z ≥ 0, b ≠ 0 or a > 0."""

    letter, part, value = "R_Jim", 1, staticmethod(carlson_rjim)


_BOTH: dict[type[ComplexPole], tuple[type[ComplexPole], type[ComplexPole]]] = {
    own: both for both in ((CarlsonRCRe, CarlsonRCIm), (CarlsonRJRe, CarlsonRJIm)) for own in both
}


def _turned(value: Parts, turn: bool) -> Parts:
    """By i, where asked: ∂/∂b = i ∂/∂p."""
    return (-value[1], value[0]) if turn else value


def times(one: Parts, other: Parts) -> Parts:
    """Return a product of complex numbers.

    Args:
        one, other: real and imaginary parts.
    """
    (a, b), (c, d) = one, other
    return a * c - b * d, a * d + b * c


def divided(one: Parts, other: Parts) -> Parts:
    """Return a quotient of complex numbers.

    Args:
        one, other: real and imaginary parts.
    """
    (a, b), (c, d) = one, other
    square = c**2 + d**2
    return (a * c + b * d) / square, (b * c - a * d) / square
