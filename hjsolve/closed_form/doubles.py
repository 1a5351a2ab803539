"""The regime of many constants at once: how the real roots of P lie in the domain, and where a place is among them.

All numbers of a test come from one tape in two doubles with running errors, and roots with disks that prove them real
and in order (``arithmetic.polynomial_roots``), so that an answer is a proof. Where a disk straddles another, an end of
the domain or the place, the element is left to ``regions``, which has 50 digits. Roots that P has at an end of the
domain for all constants (cos θ = ±1) are divided out exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.arithmetic.polynomial_roots import RealRoots, real_roots
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.regions import RootInterval
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import lower

Table = Mapping[sp.Symbol, Reals]
"""Symbol → its values, arrays of one shape."""
_PAIRS = RunningError(DoubleDouble(), own=8, bits=102)
"""Two doubles with bounds: an operation is right to four units of 2⁻¹⁰⁴, an elementary function to 2⁻¹⁰⁰."""
_TOLERANCE = 1e-12
"""Of itself, how far beyond a turning point a place may be by its rounding, as in ``regions``."""
_EDGE = 1e-3
"""About the edge of that tolerance, in units of it, 50 digits decide."""
_ROUNDED = 4 * 2.0**-52
"""How far a root may be off, by its size, to be one with all its digits."""
_SPARE = 2e-22
"""Of themselves, how near roots, or a root and an end, are left to ``regions``: twice what it calls the same."""


class FormulasForArrays:
    """Formulas of constants and places for arrays, in two doubles with bounds on their errors.

    Args:
        formulas: in order.
    """

    def __init__(self, formulas: Sequence[sp.Expr]):
        self.symbols = sorted(set[sp.Symbol]().union(*(f.free_symbols for f in formulas)), key=str)
        self.tape: Tape = lower(formulas, self.symbols)

    def __call__(self, table: Table, shape: tuple[int, ...]) -> list[tuple[Pair, Reals]]:
        """Return each formula and how far it may be off.

        Args:
            table: values of the symbols.
            shape: of the arrays.
        """
        zero = np.zeros(shape)
        given = [WithErrorBound(Pair(np.asarray(table[s], dtype=float) + zero, zero)) for s in self.symbols]
        with np.errstate(all="ignore"):
            results = self.tape.run(_PAIRS, given)
            return [
                (Pair(r.value.high + zero, r.value.low + zero), zero if r.error is None else self._bound(r.error, zero))
                for r in results
            ]

    @staticmethod
    def _bound(error: Pair, zero: Reals) -> Reals:
        found = SECOND_ORDER * abs(error.high) + zero
        # nan is not a bound: such an element is left to 50 digits
        return np.where(np.isnan(found), np.inf, found)


def _half_angle(y: sp.Expr, x: sp.Expr) -> sp.Expr:
    """Return atan2(y, x) by the tangent of its half, 2 arctan y/(r + x): where r + x cancels, its bound is wide."""
    return 2 * sp.atan(y / (sp.sqrt(x**2 + y**2) + x))


def formulas_of(expressions: Sequence[sp.Expr]) -> FormulasForArrays | None:
    """Prepare formulas; None where one has no numbers in two doubles.

    Args:
        expressions: the formulas.
    """
    try:
        return FormulasForArrays([e.replace(sp.atan2, _half_angle) for e in expressions])
    except InvalidInputError:
        return None


@dataclass(frozen=True, eq=False)
class RootsOfPolynomial:
    """The real roots of a polynomial for arrays of constants.

    Attributes:
        coefficients: of the highest power first.
    """

    coefficients: FormulasForArrays

    def __call__(self, table: Table, shape: tuple[int, ...]) -> tuple[RealRoots, Reals]:
        """Return the real roots, and the coefficient of the highest power, whose sign is certain where roots are.

        Args:
            table: values of the symbols.
            shape: of the arrays.
        """
        found = self.coefficients(table, shape)
        roots = real_roots([value for value, _ in found], [off for _, off in found])
        with np.errstate(all="ignore"):
            real = np.where(np.isfinite(roots.roots), roots.roots, np.nan)
            close = (np.diff(real, axis=0) <= _SPARE * np.fmax(abs(real[1:]), abs(real[:-1]))).any(axis=0)
        leading = np.asarray(found[0][0].high)
        return RealRoots(roots.roots, roots.errors, roots.unsure | close), leading

    def once(self, table: Table, shape: tuple[int, ...], solved: Solved) -> tuple[RealRoots, Reals]:
        """Return the same, from ``solved`` where it is there.

        Args:
            table: values of the symbols.
            shape: of the arrays.
            solved: roots that were found for these arrays.
        """
        if self not in solved:
            solved[self] = self(table, shape)
        return solved[self]

    def rounded(self, table: Table, shape: tuple[int, ...], solved: Solved) -> tuple[Reals, Mask]:
        """Return the real roots, ascending, inf after the last; and where they do not have all their digits.

        Args:
            table: values of the symbols.
            shape: of the arrays.
            solved: roots that were found for these arrays.
        """
        found, _ = self.once(table, shape, solved)
        return found.roots, found.unsure | (found.errors > _ROUNDED * abs(found.roots)).any(axis=0)


Solved = dict[RootsOfPolynomial, tuple[RealRoots, Reals]]
"""Roots that were found for some arrays: regimes and forms ask for the same ones."""


def roots_of(polynomial: sp.Poly) -> RootsOfPolynomial | None:
    """Prepare the roots of a polynomial; None where its coefficients have no numbers in two doubles.

    Args:
        polynomial: whose roots.
    """
    coefficients = formulas_of(polynomial.all_coeffs())
    return None if coefficients is None else RootsOfPolynomial(coefficients)


class CurveForArrays:
    """P of a coordinate, without the roots that it has at ends of the domain for all constants.

    Args:
        curve: whose P.
    """

    def __init__(self, curve: MomentumCurve):
        self.curve = curve

    @cached_property
    def without_ends(self) -> tuple[sp.Poly, tuple[bool, bool]]:
        """What is left of P, and whether it has a root at the lower end, and at the upper, for all constants."""
        x, s, rest = self.curve.x, self.curve.substitution, self.curve.polynomial
        at_ends = []
        for end in (s.lower, s.upper):
            there = bool(end.is_finite and sp.cancel(sp.together(rest.as_expr().subs(x, end))) == 0)
            if there:
                rest = sp.quo(rest, sp.Poly(x - end, x))
            at_ends.append(there)
        # P is a number by its ends alone: (1 − x²) c
        # the methods for roots need a degree
        if rest.degree() == 0:
            rest = sp.Poly(rest.LC() * (x**2 + 1), x)  # like a constant it has no real root, and its sign
        return rest, (at_ends[0], at_ends[1])

    @cached_property
    def roots(self) -> RootsOfPolynomial | None:
        """Of what is left; None where the coordinate may come to rest between them, which is not looked for."""
        # at a zero of S within the domain the momentum vanishes though P does not: 50 digits look for such places
        _, factors = sp.factor_list(sp.numer(sp.together(self.curve.square)), self.curve.x)
        return None if any(self._vanishes(f) for f, _ in factors) else roots_of(self.without_ends[0])

    def _vanishes(self, factor: sp.Expr) -> bool:
        """Return whether a factor of S may be zero within the domain: 1 + tan² of half an angle never is."""
        s, own = self.curve.substitution, sp.Poly(factor, self.curve.x)
        ends = () if s.closed else (s.lower, s.upper)
        return bool(own.free_symbols_in_domain) or any(root not in ends for root in sp.real_roots(own))

    @cached_property
    def ends(self) -> FormulasForArrays | None:
        """The finite ends of the domain; None where one has no number in two doubles."""
        s = self.curve.substitution
        return formulas_of([end for end in (s.lower, s.upper) if end.is_finite])

    def roots_like(self, polynomial: sp.Poly) -> RootsOfPolynomial | None:
        """Return the roots of what is left of P, if it is a multiple of a polynomial; else None.

        Args:
            polynomial: any.
        """
        own, _ = self.without_ends
        if self.roots is None or own.degree() != polynomial.degree():
            return None
        there = polynomial.as_expr().subs(polynomial.gen, own.gen)
        return self.roots if sp.expand(there * own.LC() - own.as_expr() * polynomial.LC()) == 0 else None

    def at(self, table: Table, shape: tuple[int, ...], solved: Solved) -> RootsInDomain | None:
        """Return how the roots lie in the domain; None where it is left to 50 digits.

        Args:
            table: values of the symbols.
            shape: of the arrays.
            solved: roots that were found for these arrays.
        """
        if self.roots is None or self.ends is None:
            return None
        s, finite = self.curve.substitution, iter(self.ends(table, shape))
        ends = list[tuple[Reals, Reals]]()
        for end, far in ((s.lower, -np.inf), (s.upper, np.inf)):
            if end.is_finite:
                value, off = next(finite)
                ends.append((np.asarray(value.high), off + abs(value.low)))
            else:
                ends.append((np.full(shape, far), np.zeros(shape)))
        # forms of one coordinate ask for the same roots: they are found once a block
        roots, leading = self.roots.once(table, shape, solved)
        return RootsInDomain(roots, leading, (ends[0], ends[1]), self.without_ends[1])

    def place(self, symbol: sp.Symbol) -> FormulasForArrays | None:
        """Return a place, its x, dx/dq, the turn or 0, and how far the place is inside the ends of domain or turn.

        Args:
            symbol: of the place: the coordinate, or a lower limit.
        """
        s, (first, last) = self.curve.substitution, self.curve.ends
        x = s.place.subs(self.curve.coordinate.symbol, symbol)
        first_four = [symbol, x, sp.diff(x, symbol), s.turn if s.closed else sp.S.Zero]
        if s.closed:
            return formulas_of([*first_four, s.turn / 2 - sp.Abs(symbol - s.inverse.subs(s.x, 0))])
        inside = [a for a, end in ((symbol - first, first), (last - symbol, last)) if end.is_finite]
        return formulas_of([*first_four, *inside])


@dataclass(frozen=True)
class RootsInDomain:
    """How the roots of P lie in the domain, for arrays of constants.

    Attributes:
        roots: of P without those at the ends for all constants.
        leading: the coefficient of its highest power.
        ends: of the values of x, lower and upper, each with how far it may be off.
        at_ends: whether P has a root at the lower end, and at the upper, for all constants.
    """

    roots: RealRoots
    leading: Reals
    ends: tuple[tuple[Reals, Reals], tuple[Reals, Reals]]
    at_ends: tuple[bool, bool]

    def has(self, region: RootInterval) -> tuple[Mask, Mask]:
        """Return where a region exists, and where that is not certain.

        Args:
            region: between roots and ends, by their numbers.
        """
        below, first_doubt = self._count_below(*self.ends[0])
        not_above, last_doubt = self._count_below(*self.ends[1])
        count, inside = np.isfinite(self.roots.roots).sum(axis=0), not_above - below
        first, total = below + self.at_ends[0], count + self.at_ends[0] + self.at_ends[1]
        # roots are numbered as in ``regions``: those at the ends for all constants count
        start = region.lower[1] if region.lower[0] == "root" else first - 1
        stop = region.upper[1] if region.upper[0] == "root" else first + inside
        # neighbours among the roots: another one between them is where the motion turns
        exists = (total == len(region.roots)) & (stop == start + 1)
        if region.lower[0] == "root":
            exists = exists & (start >= first) & (start < first + inside)
        if region.upper[0] == "root":
            exists = exists & (stop >= first) & (stop < first + inside)
        # the leading coefficient of the whole of P, and the roots above the region, give its sign there
        sign = np.sign(self.leading) * np.where((total - 1 - start) % 2 == 0, 1, -1)
        # an end that is not a real number leaves no domain; two doubles know the signs below roots
        domain = ~(np.isnan(self.ends[0][0]) | np.isnan(self.ends[1][0]))
        return exists & domain & (sign > 0), domain & (self.roots.unsure | first_doubt | last_doubt)

    def _count_below(self, there: Reals, off: Reals) -> tuple[NDArray[np.int64], Mask]:
        """Return how many roots are below a place, and where a root may be on either side of it."""
        known = np.isfinite(self.roots.roots)
        apart = np.where(known, self.roots.roots, 0.0) - there
        spacing = _SPARE * abs(np.where(known, self.roots.roots, 0.0))
        # a root known to e, an end known to δ: on which side it is, is known where they are further apart
        doubt = known & (abs(apart) <= self.roots.errors + off + spacing)
        return (known & (apart < 0)).sum(axis=0), np.asarray(doubt.any(axis=0))

    def holds(self, region: RootInterval, place: list[tuple[Pair, Reals]]) -> tuple[Mask, Mask]:
        """Return where a place is in a region that exists, turning points among it, and where that is not certain.

        Args:
            region: between roots and ends, by their numbers.
            place: what ``CurveForArrays.place`` says of it.
        """
        (q, _), (x, x_off), (slope, _), (turn, _), *within = place
        tolerance = _TOLERANCE * np.fmax(abs(np.asarray(q.high)), turn.high)
        (begin, begin_off), (stop, stop_off) = self._side(region.lower, 0), self._side(region.upper, 1)
        with np.errstate(all="ignore"):
            moved, width = tolerance * abs(np.asarray(slope.high)), abs(stop - begin)
        # the tolerance of q, in x, and the rounding of x, as in ``regions``
        wide = np.where(np.isfinite(moved), moved, 0.0) + _TOLERANCE * abs(x.high)
        wide = wide + np.where(np.isfinite(width), _TOLERANCE * width, 0.0)
        distances = [(np.asarray(w.high), off, tolerance) for w, off in within]
        distances += [(x.high - begin, x_off + begin_off, wide), (stop - x.high, x_off + stop_off, wide)]
        inside, unsure = np.ones(self.leading.shape, dtype=bool), self.roots.unsure | ~np.isfinite(x.high)
        for distance, off, near in distances:
            inside = inside & (distance >= -near)
            # the tolerance itself is no number to be exact about: next to its edge 50 digits decide
            exact = (distance == 0) & (off == 0)
            unsure = unsure | ~(np.isinf(distance) | exact | (abs(distance + near) > off + _EDGE * near))
        return inside, unsure

    def _side(self, end: tuple[str, int], side: int) -> tuple[Reals, Reals]:
        if end[0] != "root":
            return self.ends[side]
        k = end[1] - self.at_ends[0]
        if not 0 <= k < len(self.roots.roots):
            return np.full(self.leading.shape, np.nan), np.zeros(self.leading.shape)
        return self.roots.roots[k], self.roots.errors[k]
