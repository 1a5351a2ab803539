"""Base points: simple values at which all coordinates but some are held.

A separable system satisfies its axis-line formula identically in the base point, so the values may be formal: sine
and cosine become a rational point of the circle, an exponential or a logarithm a rational number, an undetermined
function zero; a coordinate is put where its square roots are rational. Any substitution that respects the relations of
the field will do, and the result is verified afterwards in any case. Irrational constants such as √5 and log 3 would
be generators of the field for good, and make every later step costlier.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from itertools import islice
from math import gcd, isqrt

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reader import OutsideFieldError, Reader
from hjsolve.separation.zero_test.interval_evaluation import UNKNOWNS

ATTEMPTS = 40
CIRCLE = ((1, 0), ("3/5", "4/5"), (0, 1), ("4/5", "3/5"), ("5/13", "12/13"), ("12/13", "5/13"), ("8/17", "15/17"))
HYPERBOLA = (("3/4", "5/4"), ("4/3", "5/3"), (0, 1), ("5/12", "13/12"), ("12/5", "13/5"), ("8/15", "17/15"))
LINE = (0, 1, 2, -1, 3, "1/2", -2, 5, "1/3", "5/2")
RATIONALS = tuple(Fraction(p, q) for q in range(1, 9) for p in range(40) if gcd(p, q) == 1)


@dataclass
class BasePoint:
    """Formal values of all coordinates.

    Attributes:
        reader: reader of the field.
        symbols: the coordinates.
        choices: which entry of the tables above each coordinate takes.
    """

    reader: Reader
    symbols: Sequence[sp.Symbol]
    choices: Sequence[int]
    inside: bool = False
    _values: dict[tuple[int, frozenset[int]], Element] = field(default_factory=dict)

    def keep(self, x: Element, kept: set[int] | frozenset[int]) -> Element:
        """Return the element with every coordinate but those at the positions ``kept`` put to its base value.

        Args:
            kept: positions of the coordinates that stay.

        Raises:
            ZeroDivisionError: x has a pole there, or no real value.
        """
        frozen = frozenset(kept)
        fixed = {q for i, q in enumerate(self.symbols) if i not in frozen}
        result = self._poly(x.numerator, fixed, frozen) * x.coefficient
        for base, e in x.bases:
            if result.is_zero and e > 0:
                break
            result = result * self._poly(base, fixed, frozen) ** e
        return self.reader.field.cancelled(result)

    def _poly(self, a: Poly, fixed: set[sp.Symbol], kept: frozenset[int]) -> Element:
        f = self.reader.field
        values = {k: self._value(k, kept) for k in poly.generators(a) if fixed & f.generators[k].atom.free_symbols}
        if not values:
            return f.from_poly(a)
        terms = []
        for m, c in a.items():
            factors = [f.coerce(c)]
            for k, e in poly.exponents(m):
                factors.append((values[k] if k in values else f.generator(k)) ** e)
            terms.append(f.product(factors))
        return f.total(terms)

    def _value(self, k: int, kept: frozenset[int]) -> Element:
        if (k, kept) not in self._values:
            mapping: dict[sp.Expr, sp.Expr] = {}
            for i, q in enumerate(self.symbols):
                if i not in kept:
                    mapping.update(self._table(q, self.choices[i]))
            atom = self.reader.field.generators[k].atom
            try:
                self._values[k, kept] = self.reader.element(atom.xreplace(mapping))
            except OutsideFieldError as fault:
                raise ZeroDivisionError(f"{atom} has no real value at the base point") from fault
        return self._values[k, kept]

    def _table(self, q: sp.Symbol, choice: int) -> dict[sp.Expr, sp.Expr]:
        """Return the values of q and of the generators that are functions of q alone."""
        table: dict[sp.Expr, sp.Expr] = {q: self._coordinate(q, choice)}
        for g in list(self.reader.field.generators):
            if q not in g.atom.free_symbols or not g.atom.free_symbols <= {q}:
                continue
            if g.partner is not None:
                points = CIRCLE if g.kind == "sin" else HYPERBOLA
                s, c = points[choice % len(points)]
                table[g.atom] = sp.Rational(s)
                table[self.reader.field.generators[g.partner].atom] = sp.Rational(c)
            elif isinstance(g.atom, sp.exp | sp.log):
                table[g.atom] = sp.Integer(1 + choice)
            elif isinstance(g.atom, UNKNOWNS):
                table[g.atom] = sp.Integer(choice // 2)
        return table

    def _coordinate(self, q: sp.Symbol, choice: int) -> sp.Expr:
        lower, upper = self.reader.bounds.get(q, (None, None))
        if not self.inside and not _is_number(lower) and not _is_number(upper):
            return self._with_rational_roots(q, sp.Rational(LINE[choice % len(LINE)]), choice)
        fraction = sp.Rational(choice + 1)
        if lower is None and upper is None:
            return self._with_rational_roots(q, sp.Rational(LINE[choice % len(LINE)]), choice)
        if upper is None:
            return lower + fraction
        if lower is None:
            return upper - fraction
        whole = sp.Rational(1, choice + 2)
        middle = lower + (upper - lower) * whole
        if _is_number(lower) and _is_number(upper):
            low, high = Fraction(float(lower)), Fraction(float(upper))
            near = (low + (high - low) / (choice + 2)).limit_denominator(4 + 2 * choice)
            return sp.Rational(near.numerator, near.denominator)
        return middle

    def _with_rational_roots(self, q: sp.Symbol, value: sp.Rational, choice: int) -> sp.Rational:
        """Return the value, or one where the square roots of polynomials in q alone are rational, if there is one."""
        roots = [g.atom for g in self.reader.field.generators if g.kind == "root" and g.atom.free_symbols == {q}]
        radicands = [x.base for x in roots if x.is_Pow and x.exp == sp.S.Half and x.base.is_polynomial(q)]
        polynomials = [sp.Poly(r, q) for r in radicands]
        if not polynomials or any(not a.is_Rational for f in polynomials for a in f.coeffs()):
            return value
        rows = [[Fraction(int(a.p), int(a.q)) for a in f.all_coeffs()] for f in polynomials]
        if _are_squares(rows, Fraction(int(value.p), int(value.q))):
            return value
        good = next(islice((v for v in RATIONALS if _are_squares(rows, v)), choice, None), None)
        return value if good is None else sp.Rational(good.numerator, good.denominator)


def _are_squares(rows: Sequence[Sequence[Fraction]], v: Fraction) -> bool:
    """Return whether polynomials, by their coefficients from the highest on, are squares of rational numbers at v."""
    values = (reduce(lambda sum_, a: sum_ * v + a, row, Fraction(0)) for row in rows)
    return all(
        x >= 0 and isqrt(x.numerator) ** 2 == x.numerator and isqrt(x.denominator) ** 2 == x.denominator for x in values
    )


def _is_number(end: sp.Expr | None) -> bool:
    return end is not None and bool(end.is_number)


def find_base_points(reader: Reader, symbols: Sequence[sp.Symbol]) -> Iterator[BasePoint]:
    """Yield base points to try, the simplest first, then points inside the domain, then random ones.

    Args:
        reader: of the field; it knows the domain.
        symbols: essential coordinates.
    """
    n = len(symbols)
    first = [[0] * n, list(range(n)), [1] * n, list(range(1, n + 1)), [i + 3 for i in range(n)]]
    generator = random.Random(n)  # noqa: S311
    for attempt in range(ATTEMPTS):
        choices = first[attempt] if attempt < len(first) else [generator.randrange(10) for _ in range(n)]
        yield BasePoint(reader, symbols, choices, inside=attempt >= len(first))
