"""P² of a coordinate as a polynomial in one variable, whose coefficients are polynomials in two constants.

P²(q; x, y) = N(t; x, y)/D(t) with D > 0 on the domain and t = φ(q) monotone (``closed_form.substitutions``): q
itself, cos q, tan q/2, exp κq, cosh κq, √(q² + c) … The domain of t becomes (0, 1) by t = a + s (b − a),
t = a + l s/(1 − s), or two pieces with s in (0, 1) and (1, 2), and N is written in Bernstein's polynomials of s: the
coefficients there are, for all points (x, y) at once, one matrix times the monomials xⁱyʲ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import mpmath
import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.tape import Tape
from hjsolve.closed_form.change_of_variable import Substitution
from hjsolve.closed_form.substitutions import known_substitutions
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.energy_momentum.isolation import IsolatedRoots, Reals, at_place, bernstein_value, isolated_roots
from hjsolve.lowering import lower
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.precision import mp

_DIGITS = 60
_MODERATE = 400
"""Binary digits before and after the point from which on coefficients are divided by a power of two."""
_LOW_ENOUGH, _HIGHEST = 6, 24
"""Degree in t up to which no other variable is tried, and above which doubles tell little in Bernstein's form."""


@dataclass(frozen=True, repr=False, eq=False)
class _Piece(ByValue, Shown):
    """A part of the domain of t, and N on it.

    Attributes:
        start, end: in order of q, ±inf allowed.
        length: of the part, or where it is infinite that of the map.
        table: Bernstein coefficients of every monomial, shape (monomials, n + 1).
    """

    start: float
    end: float
    length: float
    table: Reals = field(repr=False)

    def fraction(self, t: Reals) -> Reals:
        """Return the s in (0, 1) of t; outside of it where t is outside of the part."""
        with np.errstate(all="ignore"):
            if np.isinf(self.start):
                away = np.abs(t - self.end) / self.length
                return np.where((t - self.end) * np.sign(self.start) >= 0, 1 / (1 + away), 2.0)
            part = (t - self.start) * (1 if self.end > self.start else -1) / self.length
            return np.where(part >= 0, part / (1 + part), -1.0) if np.isinf(self.end) else part

    def places(self, s: Reals) -> Reals:
        """Return the t of s in (0, 1)."""
        with np.errstate(all="ignore"):
            if np.isinf(self.start):
                return self.end + np.sign(self.start) * self.length * (1 - s) / s
            side = 1 if self.end > self.start else -1
            return self.start + side * self.length * (s / (1 - s) if np.isinf(self.end) else s)


@dataclass(frozen=True, repr=False, eq=False)
class MomentumPolynomial(ByValue, Shown):
    """N(t; x, y) of one coordinate.

    In its methods x and y are values of the two constants, shape (m,).

    Attributes:
        substitution: t = φ(q).
        polynomial: N.
        monomials: (i, j) of every xⁱyʲ.
        pieces: one or two parts of the domain, in order of q.
        closed: q is an angle: both ends of the domain are one place.
        forward, backward: tapes of φ and of its inverse.
    """

    substitution: Substitution = field(repr=False)
    polynomial: sp.Expr
    monomials: tuple[tuple[int, int], ...]
    pieces: tuple[_Piece, ...] = field(repr=False)
    closed: bool
    forward: Tape = field(repr=False)
    backward: Tape = field(repr=False)

    def roots(self, x: Reals, y: Reals) -> tuple[IsolatedRoots, ...]:
        """Isolate the zeros of P² at many points; one result for each piece."""
        return tuple(isolated_roots(*self._coefficients(piece, x, y)) for piece in self.pieces)

    def value(self, x: Reals, y: Reals, s: Reals) -> tuple[Reals, Reals]:
        """Return N at places s of (0, 1) or (1, 2), and bounds on its errors.

        Args:
            s: the places, shape (m,).
        """
        value, error = np.empty(len(s)), np.empty(len(s))
        for k, piece in enumerate(self.pieces):
            here = (s >= k) & ((s < k + 1) | (k == len(self.pieces) - 1))
            value[here], error[here] = bernstein_value(*self._coefficients(piece, x[here], y[here]), s[here] - k)
        return value, error

    def values(self, x: Reals, y: Reals) -> Callable[[Reals], Reals]:
        """Return N at many points as a function of the places s; the coefficients there are worked out once."""
        tables = [self._coefficients(piece, x, y)[0] for piece in self.pieces]

        def at(s: Reals) -> Reals:
            value = np.empty(len(s))
            for k, table in enumerate(tables):
                here = (s >= k) & ((s < k + 1) | (k == len(tables) - 1))
                value[here] = at_place(table[here], s[here] - k)
            return value

        return at

    def fractions(self, q: Reals) -> Reals:
        """Return s of places q.

        Args:
            q: places in the domain; of an angle, in (−π, π].
        """
        with np.errstate(all="ignore"):
            t = np.broadcast_to(np.asarray(self.forward.run(Float64(), [np.asarray(q, float)])[0], float), np.shape(q))
        result = np.full(np.shape(q), np.nan)
        for k, piece in enumerate(self.pieces):
            s = piece.fraction(t)
            result = np.where((s >= 0) & (s <= 1), s + k, result)
        return result

    def places(self, s: Reals) -> Reals:
        """Return q of places s, to doubles.

        Args:
            s: in (0, 1), or up to 2 where there are two pieces.
        """
        t = np.where(s < 1, self.pieces[0].places(s), self.pieces[-1].places(s - len(self.pieces) + 1))
        with np.errstate(all="ignore"):
            return np.broadcast_to(np.asarray(self.backward.run(Float64(), [t])[0], float), np.shape(s)).copy()

    def _coefficients(self, piece: _Piece, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        powers = np.stack([x**i * y**j for i, j in self.monomials], axis=1)
        degree = max(i + j for i, j in self.monomials)
        size = np.abs(powers) @ np.abs(piece.table)
        return powers @ piece.table, (len(self.monomials) + degree + 4) * EPS * size + 1e-290


def polynomial_of(
    square: sp.Expr, coordinate: Coordinate, x: sp.Symbol, y: sp.Symbol, scale: float
) -> MomentumPolynomial | None:
    """Write P² as a polynomial; None where no known variable makes it one.

    Args:
        square: P²(q; x, y), every other symbol replaced by a number.
        coordinate: q, the ends of its domain numbers; of the kind line where P² is not periodic.
        x, y: the symbols of the two constants.
        scale: a length typical of q.
    """
    t = sp.Symbol("_t", real=True)
    closed = coordinate.domain.kind == "angle"
    found = []
    for candidate in known_substitutions(square, coordinate, t):
        if candidate.closed is closed and (N := _numerator(candidate, x, y)) is not None:
            found.append((sp.Poly(N, t).degree(), candidate, N))
            if found[-1][0] <= _LOW_ENOUGH:
                break
    if not found:
        return None
    degree, chosen, N = min(found, key=lambda item: item[0])
    if not degree <= _HIGHEST:
        return None
    ends = chosen.lower, chosen.upper
    ends = ends if chosen.increasing else ends[::-1]
    monomials, pieces = _tables(N, t, (x, y), ends, _length(chosen, coordinate, scale))
    tapes = lower([chosen.place], [coordinate.symbol]), lower([chosen.inverse], [t])
    return MomentumPolynomial(chosen, N, monomials, pieces, closed, *tapes)


def _length(chosen: Substitution, coordinate: Coordinate, scale: float) -> float:
    """Return a length typical of t."""
    low, q = coordinate.domain.lower, sp.Float(scale)
    if low is not None:
        q = q + low
    value = sp.N(chosen.place.subs(coordinate.symbol, q))
    start = chosen.lower if chosen.lower.is_finite else chosen.upper if chosen.upper.is_finite else sp.S.Zero
    size = abs(float(value - start)) if value.is_real else 1.0
    return size if 1e-12 < size < 1e12 else 1.0


# ------------------------------------------------------------------------------------------------ the numerator
def _numerator(s: Substitution, x: sp.Symbol, y: sp.Symbol) -> sp.Expr | None:
    """N with P² D = N, D > 0 on the domain and every factor left out that keeps its sign there."""
    top, bottom = sp.fraction(sp.cancel(sp.together(s.function)))
    if not top.is_polynomial(s.x, x, y) or not bottom.is_polynomial(s.x) or bottom.has(x, y):
        return None
    kept, sign = _of_one_sign(bottom, s)
    content = sp.S.Zero
    for coefficient in sp.Poly(top, x, y).coeffs():
        content = sp.gcd(content, coefficient)
    if content.has(s.x):
        rest, own = _of_one_sign(content, s)
        top, kept, sign = sp.cancel(top / content), kept * rest, sign * own
    return _of_moderate_size(sp.expand(sign * top * kept), (s.x, x, y))


def _of_moderate_size(N: sp.Expr, symbols: tuple[sp.Symbol, ...]) -> sp.Expr:
    """N over a power of two: exact constants of many digits leave coefficients beyond all doubles."""
    largest = max((mp.mag(mp.mpf(sp.N(c, _DIGITS))) for c in sp.Poly(N, *symbols).coeffs()), default=0)
    return N if abs(largest) < _MODERATE else sp.expand(N * sp.Integer(2) ** -int(largest))


def _of_one_sign(factors: sp.Expr, s: Substitution) -> tuple[sp.Expr, int]:
    """Return the product of the factors that change their sign on the domain, and the sign of all others together."""
    constant, powers = sp.factor_list(factors, s.x)
    kept, sign = sp.S.One, 1 if constant > 0 else -1
    inside = _a_place(s)
    for factor, power in powers:
        if power % 2 == 0:
            continue
        polynomial = sp.Poly(factor, s.x)
        if polynomial.domain.is_Exact and polynomial.domain.is_Numerical and not _roots_inside(polynomial, s):
            sign *= 1 if sp.N(factor.subs(s.x, inside)) > 0 else -1
        else:
            kept *= factor
    return kept, sign


def _roots_inside(polynomial: sp.Poly, s: Substitution) -> int:
    """Return roots on the open domain; 1, to be careful, where that is not found out."""
    try:
        ends = [None if not e.is_finite else e for e in (s.lower, s.upper)]
        number = int(polynomial.count_roots(*ends))
        return number - sum(1 for e in ends if e is not None and sp.simplify(polynomial.as_expr().subs(s.x, e)) == 0)
    except (NotImplementedError, sp.PolynomialError, ValueError, TypeError):
        return 1


def _a_place(s: Substitution) -> sp.Expr:
    low, high = s.lower, s.upper
    if low.is_finite and high.is_finite:
        return sp.N((low + high) / 2, 30)
    return sp.N(low + 1, 30) if low.is_finite else sp.N(high - 1, 30) if high.is_finite else sp.S.Zero


# ------------------------------------------------------------------------------------------------ Bernstein's form
def _tables(
    N: sp.Expr, t: sp.Symbol, constants: tuple[sp.Symbol, sp.Symbol], ends: tuple[sp.Expr, sp.Expr], length: float
) -> tuple[tuple[tuple[int, int], ...], tuple[_Piece, ...]]:
    terms = sp.Poly(N, t, *constants).terms()
    degree = max(k for (k, _, _), _ in terms)
    monomials = tuple(sorted({(i, j) for (_, i, j), _ in terms}))
    with mp.workdps(_DIGITS):
        rows = {ij: [mp.mpf(0)] * (degree + 1) for ij in monomials}
        for (k, i, j), c in terms:
            rows[i, j][k] = mp.mpf(sp.N(c, _DIGITS))
        table = [rows[ij] for ij in monomials]
        a, b = (mp.mpf(sp.N(e, _DIGITS)) if e.is_finite else mp.inf * (1 if e is sp.oo else -1) for e in ends)
        if mp.isfinite(a) or mp.isfinite(b):
            return monomials, (_piece(table, a, b, length),)
        middle = mp.mpf(length) / 137
        return monomials, (_piece(table, a, middle, length), _piece(table, middle, b, length))


def _piece(table: list[list[mpmath.mpf]], a: mpmath.mpf, b: mpmath.mpf, length: float) -> _Piece:
    if mp.isinf(a):
        turned = _piece(table, b, a, length)
        return _Piece(float(a), float(b), turned.length, np.ascontiguousarray(turned.table[:, ::-1]))
    far = bool(mp.isinf(b))
    size = mp.mpf(length) if far else abs(b - a)
    shifted = [_shifted(row, a, size * (1 if b > a else -1)) for row in table]
    n = len(table[0]) - 1
    if far:
        found = [[row[k] / mp.binomial(n, k) for k in range(n + 1)] for row in shifted]
    else:
        found = [
            [sum(row[k] * mp.binomial(i, k) / mp.binomial(n, k) for k in range(i + 1)) for i in range(n + 1)]
            for row in shifted
        ]
    return _Piece(float(a), float(b), float(size), np.array([[float(c) for c in row] for row in found]))


def _shifted(row: list[mpmath.mpf], a: mpmath.mpf, step: mpmath.mpf) -> list[mpmath.mpf]:
    """Return the coefficients of N(a + step·s), by Horner's scheme."""
    result = list(row)
    for first in range(len(result) - 1):
        for k in range(len(result) - 2, first - 1, -1):
            result[k] += a * result[k + 1]
    return [c * step**k for k, c in enumerate(result)]


def with_domain(
    coordinate: Coordinate, lower_end: sp.Expr | None, upper_end: sp.Expr | None,
    kind: Literal["line", "angle", "interval"],
) -> Coordinate:  # fmt: skip
    """Return a coordinate whose domain has ends that are numbers.

    Args:
        coordinate: any.
        lower_end, upper_end: the ends; None for none.
        kind: ``line``, ``angle`` or ``interval``.
    """
    return replace(coordinate, domain=replace(coordinate.domain, kind=kind, lower=lower_end, upper=upper_end))
