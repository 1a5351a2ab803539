"""Pieces of an interval on which an algebraic function is analytic, by exact isolation of real roots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

import mpmath
import sympy as sp

from hjsolve.algebra.constants import algebraic_is_zero
from hjsolve.algebra.intervals import enclose
from hjsolve.algebra.poly import Budget

MAX_DEGREE = 80
REFINEMENTS = (20, 60, 200, 600)
Ends = tuple[sp.Expr | None, sp.Expr | None]


class TooLargeError(ArithmeticError):
    """More work than is worth while, or ends and roots that could not be separated."""


@dataclass(frozen=True)
class AnalyticPiece:
    """An open interval with rational ends inside of a piece; None is infinite."""

    low: sp.Rational | None
    high: sp.Rational | None

    def places(self, count: int) -> Iterator[sp.Rational]:
        """So many rational numbers inside, simple ones."""
        low, high = self.low, self.high
        if low is None and high is None:
            yield from (sp.Integer(k - count // 2) + sp.Rational(1, 3) for k in range(count))
        elif high is None:
            yield from (sp.floor(low) + k for k in range(1, count + 1))
        elif low is None:
            yield from (sp.ceiling(high) - k for k in range(1, count + 1))
        else:
            n = sp.ceiling((count + 1) / (high - low))
            first = sp.floor(low * n) + 1
            yield from (sp.Rational(first + k, n) for k in range(count))


def analytic_pieces(
    functions: Sequence[sp.Expr], t: sp.Symbol, ends: Sequence[Ends], budget: Budget
) -> Iterator[AnalyticPiece]:
    """Yield the pieces of intervals between the critical points of some functions.

    Zeros of what is divided by or rooted.

    Args:
        functions: algebraic in t.
        ends: of the open intervals.
        budget: of the exact computation.

    Raises:
        TooLargeError: the critical points could not be computed.
    """
    polynomial = _critical(functions, t, budget)
    for low, high in ends:
        yield from _pieces(polynomial, t, low, high)


def _pieces(polynomial: sp.Poly, t: sp.Symbol, low: sp.Expr | None, high: sp.Expr | None) -> Iterator[AnalyticPiece]:
    at_end = [e is not None and algebraic_is_zero(polynomial.as_expr().xreplace({t: e})) for e in (low, high)]
    for digits in REFINEMENTS:
        found = _apart(polynomial, low, high, at_end, digits)
        if found is not None:
            yield from found
            return
    raise TooLargeError("roots and ends lie too close together")


def _apart(
    polynomial: sp.Poly, low: sp.Expr | None, high: sp.Expr | None, at_end: Sequence[bool], digits: int
) -> list[AnalyticPiece] | None:
    """Return the pieces where roots and ends are told apart at this accuracy, else None."""
    eps = sp.Rational(1, 10**digits)
    roots = [] if polynomial.degree() == 0 else [pair for pair, _ in polynomial.intervals(eps=eps)]
    begin, end = (None if e is None else _enclosed(e, digits) for e in (low, high))
    inside = []
    for a, b in roots:
        sides = [_side(a, b, begin, at_end[0]), _side(a, b, end, at_end[1])]
        if None in sides:
            return None
        if (begin is None or sides[0] == 1) and (end is None or sides[1] == -1):
            inside.append((a, b))
    outer = None if begin is None else begin[1], None if end is None else end[0]
    marks = [outer[0], *(x for pair in inside for x in pair), outer[1]]
    gaps = [(marks[k], marks[k + 1]) for k in range(0, len(marks), 2)]
    if any(a is not None and b is not None and a >= b for a, b in gaps):
        return None
    return [AnalyticPiece(a, b) for a, b in gaps]


def _side(a: sp.Rational, b: sp.Rational, end: tuple[sp.Rational, sp.Rational] | None, may_meet: bool) -> int | None:
    """+1 where the root lies above the end, −1 below, 0 where it is the end, None where that is not told."""
    if end is None or a > end[1]:
        return 1
    if b < end[0]:
        return -1
    return 0 if may_meet else None


def _enclosed(x: sp.Expr, digits: int) -> tuple[sp.Rational, sp.Rational]:
    if x.is_Rational:
        return x, x
    lower, upper = enclose(x, {}, 4 * digits + 64)
    return _rational(lower), _rational(upper)


def _rational(x: mpmath.mpf) -> sp.Rational:
    sign, mantissa, exponent, _ = x._mpf_
    value = sp.Integer(int(mantissa)) * sp.Integer(2) ** exponent
    return -value if sign else value


# -------------------------------------------------------------------------------- critical points


def _critical(functions: Sequence[sp.Expr], t: sp.Symbol, budget: Budget) -> sp.Poly:
    """Return a squarefree polynomial among whose real roots are all zeros and poles of radicands and denominators."""
    letters: dict[tuple[sp.Expr, int], sp.Symbol] = {}
    relations: list[tuple[sp.Symbol, sp.Expr]] = []
    watched: list[sp.Expr] = []

    def visit(x: sp.Expr) -> sp.Expr:
        if x == t or x.is_Rational:
            return x
        if x.is_Add or x.is_Mul:
            return x.func(*map(visit, x.args))
        if not (x.is_Pow and x.exp.is_Rational):
            raise TooLargeError(f"{sp.sstr(x)[:40]} is not a root")
        base, q = visit(x.base), int(x.exp.q)
        if base.has(t) and (q > 1 or x.exp < 0):
            watched.append(base)
        if q == 1:
            return base**x.exp
        if (base, q) not in letters:
            letters[base, q] = sp.Dummy(f"g{len(letters)}")
            top, bottom = sp.fraction(sp.together(base))
            relations.append((letters[base, q], bottom * letters[base, q] ** q - top))
        return letters[base, q] ** x.exp.p

    for f in functions:
        visit(f)
    found = [_norm(part, t, relations, budget) for base in watched for part in sp.fraction(sp.together(base))]
    product = reduce(lambda a, b: a * b, found, sp.Poly(1, t))
    return product.sqf_part() if product.degree() > 0 else product


def _norm(x: sp.Expr, t: sp.Symbol, relations: Sequence[tuple[sp.Symbol, sp.Expr]], budget: Budget) -> sp.Poly:
    """Return a polynomial in t that vanishes where x does; the roots are eliminated, the last ones first."""
    for letter, relation in reversed(relations):
        if not x.has(letter):
            continue
        budget.check()
        x = sp.resultant(sp.expand(x), sp.expand(relation), letter)
    polynomial = sp.Poly(sp.expand(x), t)
    if polynomial.is_zero or polynomial.degree() > MAX_DEGREE or polynomial.domain not in (sp.ZZ, sp.QQ):
        raise TooLargeError("no norm, or one of too high a degree")
    return polynomial.sqf_part()
