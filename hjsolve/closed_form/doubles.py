"""The regime of many constants at once, in doubles: how the real roots of P lie in the domain, by Sturm's sequences.

A sequence counts the real roots between two places from signs alone, for whole arrays. Where a sign is not certain in
doubles the element is left to ``regions.region_exists``, which has 50 digits. Roots that P has at an end of the domain
for all constants (cos θ = ±1) are divided out exactly.

Basu, Pollack, Roy, Algorithms in real algebraic geometry (2006), theorem 2.50 (Sturm).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.polynomial_roots import real_roots, size_of_roots
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.regions import RootInterval
from hjsolve.functions import modules

Doubles = NDArray[np.float64]
Booleans = NDArray[np.bool_]
_NEAR = 0.25
"""How far from ±1, the ends of a cosine, a root may be that is sought from there."""
_AT_END = 1e-12
"""In units of the coordinate, how far beyond an end of the domain a place may be by its rounding."""
_UNSURE = 1e-8
"""Below this part of what it is a sum of, a number has no certain sign."""


@dataclass(frozen=True)
class RegionTest:
    """Whether a region between roots exists, for arrays of constants.

    Attributes:
        numbers: arrays of the symbols ↦ the coefficients of what is left of P, and the ends of the domain.
        at_ends: whether P has a root at the lower end, and at the upper, for all constants.
        region: the region.
    """

    numbers: Callable[..., list[Doubles]]
    at_ends: tuple[bool, bool]
    region: RootInterval

    def __call__(self, places: Sequence[Doubles], shape: tuple[int, ...]) -> tuple[Booleans, Booleans]:
        """Return where the region exists, and where that is not certain in doubles.

        Args:
            places: arrays of the symbols.
            shape: of the arrays.
        """
        *coefficients, low, high = (np.broadcast_to(np.asarray(v, dtype=float), shape) for v in self.numbers(*places))
        coefficients, unit = _of_size_one(coefficients)
        low, high = low / unit, high / unit
        sequence, unsure = _sturm(coefficients)
        everywhere = [np.full(shape, -np.inf), low, high, np.full(shape, np.inf)]
        changes = []
        for there in everywhere:
            count, doubtful = _changes(sequence, there)
            changes.append(count)
            unsure = unsure | doubtful
        below, inside, above = (a - b for a, b in pairwise(changes))
        first = below + self.at_ends[0]
        total = first + inside + self.at_ends[1] + above
        start = self.region.lower[1] if self.region.lower[0] == "root" else first - 1
        stop = self.region.upper[1] if self.region.upper[0] == "root" else first + inside
        exists = (total == len(self.region.roots)) & (stop == start + 1)
        if self.region.lower[0] == "root":
            exists = exists & (start >= first) & (start < first + inside)
        if self.region.upper[0] == "root":
            exists = exists & (stop >= first) & (stop < first + inside)
        # the leading coefficient of the whole of P, and the roots above the region, give its sign there
        sign = np.sign(coefficients[0]) * np.where((total - 1 - start) % 2 == 0, 1, -1)
        return exists & (sign > 0), unsure


def region_test(curve: MomentumCurve, region: RootInterval, symbols: Sequence[sp.Symbol]) -> RegionTest | None:
    """Prepare the test; None where the coordinate may come to rest between roots, which it does not look for.

    Args:
        curve: whose P.
        region: the region.
        symbols: in the order of the arrays.
    """
    prepared = _without_ends(curve)
    if prepared is None:
        return None
    rest, at_ends = prepared
    formulas = [*rest.all_coeffs(), curve.substitution.lower, curve.substitution.upper]
    return RegionTest(sp.lambdify(list(symbols), formulas, modules=modules("numpy"), cse=True), at_ends, region)


def _without_ends(curve: MomentumCurve) -> tuple[sp.Poly, tuple[bool, bool]] | None:
    """P without the roots that it has at the ends of the domain for all constants, and whether it has those."""
    x, s = curve.x, curve.substitution
    if sp.numer(sp.together(curve.square)).has(x):
        return None
    rest, at_ends = curve.polynomial, []
    for end in (s.lower, s.upper):
        there = bool(end.is_finite and sp.cancel(sp.together(curve.polynomial.as_expr().subs(x, end))) == 0)
        if there:
            rest = sp.quo(rest, sp.Poly(x - end, x))
        at_ends.append(there)
    if rest.degree() == 0:
        rest = sp.Poly(x**2 + 1, x)  # like a constant it has no real root
    return rest, (at_ends[0], at_ends[1])


@dataclass(frozen=True)
class PlaceTest:
    """Whether a place is in a region that exists, for arrays.

    Attributes:
        numbers: arrays of the symbols ↦ coefficients of what is left of P, the ends of the values of x, x, how far the
            place is from the middle of the turn, and how far it is inside the ends of the domain.
        at_end: whether P has a root at the lower end for all constants.
        region: the region.
    """

    numbers: Callable[..., list[Doubles]]
    at_end: bool
    region: RootInterval

    def __call__(self, places: Sequence[Doubles], shape: tuple[int, ...]) -> tuple[Booleans, Booleans]:
        """Return where the place is in the region, and where that is not certain in doubles.

        Args:
            places: arrays of the symbols.
            shape: of the arrays.
        """
        given = (np.broadcast_to(np.asarray(v, dtype=float), shape) for v in self.numbers(*places))
        *coefficients, low, high, x, away, after, before = given
        coefficients, unit = _of_size_one(coefficients)
        sequence, unsure = _sturm(coefficients)
        far, doubtful = _changes(sequence, np.full(shape, -np.inf))
        here, beside = _changes(sequence, x / unit)
        below, _ = _changes(sequence, low / unit)
        start = self.region.lower[1] if self.region.lower[0] == "root" else far - below + self.at_end - 1
        unsure = unsure | doubtful | beside | ~np.isfinite(x) | (abs(abs(away) - np.pi) < _UNSURE)
        inside = (far - here + self.at_end == start + 1) & (low <= x) & (x <= high) & (abs(away) <= np.pi)
        inside &= (after >= -_AT_END) & (before >= -_AT_END)
        return inside, unsure


def place_test(
    curve: MomentumCurve, region: RootInterval, place: sp.Symbol, symbols: Sequence[sp.Symbol]
) -> PlaceTest | None:  # fmt: skip
    """Prepare the test; None where it is left to 50 digits.

    Args:
        curve: whose P.
        region: the region.
        place: the symbol of the place: a coordinate, or a lower limit.
        symbols: in the order of the arrays.
    """
    prepared = _without_ends(curve)
    if prepared is None:
        return None
    rest, at_ends = prepared
    s = curve.substitution
    x = s.place.subs(curve.coordinate.symbol, place)
    away = 2 * sp.pi * (place - s.inverse.subs(s.x, 0)) / s.turn if s.closed else sp.S.Zero  # in parts of a turn
    first, last = (-sp.oo, sp.oo) if s.closed else curve.ends
    formulas = [*rest.all_coeffs(), s.lower, s.upper, x, away, place - first, last - place]
    return PlaceTest(sp.lambdify(list(symbols), formulas, modules=modules("numpy"), cse=True), at_ends[0], region)


@dataclass(frozen=True)
class RootsOfPolynomial:
    """The real roots of a polynomial for arrays of constants.

    Next to a place c where P(c) is one term, roots are c + y, y a root of P(c + y), whose last coefficient that is: two
    roots on either side of a pole have all their digits, where those of P as it stands lose half of them.

    Attributes:
        coefficients: arrays of the symbols ↦ coefficients of the polynomial.
        shifted: places c, and the same of P(c + y).
    """

    coefficients: Callable[..., list[Doubles]]
    shifted: tuple[tuple[float, Callable[..., list[Doubles]]], ...] = ()

    def __call__(self, places: Sequence[Doubles], shape: tuple[int, ...]) -> tuple[Doubles, Booleans]:
        """Return the real roots, ascending, inf after the last; and where they are not certain.

        Args:
            places: arrays of the symbols.
            shape: of the arrays.
        """
        roots, unsure = _real_roots(self.coefficients, places, shape)
        nearest = np.full(roots.shape, _NEAR)
        for c, coefficients in self.shifted:
            away, doubtful = _real_roots(coefficients, places, shape)
            same = np.all(np.isfinite(away) == np.isfinite(roots), axis=0) & ~doubtful
            better = same & (abs(away) < nearest)
            roots, nearest = np.where(better, c + away, roots), np.where(better, abs(away), nearest)
        return roots, unsure


def _real_roots(
    coefficients: Callable[..., list[Doubles]], places: Sequence[Doubles], shape: tuple[int, ...]
) -> tuple[Doubles, Booleans]:  # fmt: skip
    return real_roots([np.broadcast_to(np.asarray(c, dtype=float), shape) for c in coefficients(*places)])


def roots_of(polynomial: sp.Poly, symbols: Sequence[sp.Symbol]) -> RootsOfPolynomial:
    """Prepare the roots of a polynomial.

    Args:
        polynomial: whose roots.
        symbols: in the order of the arrays.
    """
    known = modules("numpy")
    shifted = []
    for c in (-1, 1):
        if (last := sp.factor(polynomial.eval(c))) != 0 and not last.is_Add:
            moved = [sp.factor(k) for k in polynomial.compose(sp.Poly(polynomial.gen + c, polynomial.gen)).all_coeffs()]
            shifted.append((float(c), sp.lambdify(list(symbols), moved, modules=known, cse=True)))
    plain = sp.lambdify(list(symbols), polynomial.all_coeffs(), modules=known, cse=True)
    return RootsOfPolynomial(plain, tuple(shifted))


def _of_size_one(coefficients: list[Doubles]) -> tuple[list[Doubles], Doubles]:
    """Return the polynomial in x/λ, whose roots are about 1 in size; and λ."""
    degree, unit = len(coefficients) - 1, size_of_roots(coefficients)
    return [c * unit ** (degree - k) for k, c in enumerate(coefficients)], unit


def _sturm(coefficients: list[Doubles]) -> tuple[list[list[Doubles]], Booleans]:
    """P, P′ and the remainders with signs, each of size 1; and where one of them is too small to be sure of."""
    degree = len(coefficients) - 1
    size = np.max([abs(c) for c in coefficients], axis=0)
    first, unsure = _scaled([c / size for c in coefficients])
    second, doubtful = _scaled([(degree - k) * c for k, c in enumerate(first[:-1])])
    sequence, unsure = [first, second], unsure | doubtful
    while len(sequence[-1]) > 1:
        above, below = [*sequence[-2]], sequence[-1]
        for k in range(len(above) - len(below) + 1):
            factor = above[k] / below[0]
            for j, c in enumerate(below):
                above[k + j] = above[k + j] - factor * c
        remainder, doubtful = _scaled([-c for c in above[len(sequence[-2]) - len(below) + 1 :]])
        sequence.append(remainder)
        unsure = unsure | doubtful
    return sequence, unsure


def _scaled(coefficients: list[Doubles]) -> tuple[list[Doubles], Booleans]:
    """Return coefficients by the greatest of them; where the leading one is nearly nothing."""
    size = np.max([abs(c) for c in coefficients], axis=0)
    scaled = [c / size for c in coefficients]
    return scaled, ~(abs(scaled[0]) > _UNSURE) | ~(size > _UNSURE)


def _changes(sequence: list[list[Doubles]], there: Doubles) -> tuple[NDArray[np.int64], Booleans]:
    """Return how often the sign changes along a sequence at a place, and where a sign is not certain."""
    finite = np.isfinite(there)
    place = np.where(finite, there, 0.0)
    count, former = np.zeros(there.shape, dtype=np.int64), None
    unsure = np.zeros(there.shape, dtype=bool)
    for polynomial in sequence:
        value, size = np.zeros(there.shape), np.zeros(there.shape)
        for c in polynomial:
            value, size = value * place + c, size * abs(place) + abs(c)
        odd = (len(polynomial) - 1) % 2 == 1
        far = polynomial[0] * np.where(there < 0, -1.0 if odd else 1.0, 1.0)
        unsure = unsure | (finite & ~(abs(value) > _UNSURE * size))
        sign = np.sign(np.where(finite, value, far))
        if former is not None:
            count = count + (sign != former)
        former = sign
    return count, unsure
