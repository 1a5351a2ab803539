"""Relations between generators of one variable, found by numbers and proved: a new generator may be an old function.

√((1 − cos x)/2) is sin(x/2) on (0, 2π), atan((1 − x)/(1 + x)) is π/4 − atan x on x > 0, and a nested radical may lie
in the field of the roots before it. A root or an inverse function of one variable (or a constant) that is about to
join a field is compared, at a few places of the domain and at 40 digits, with rational combinations of monomials in
the generators there are. What fits is proved by ``one_variable``, ``several_variables`` or ``constants``, or not used.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import mpmath
import sympy as sp

from hjsolve.algebra.constants import constant_is_zero
from hjsolve.algebra.elementary import PRIMITIVES, at_one_place
from hjsolve.algebra.field import Element, Generator
from hjsolve.algebra.one_variable import vanishes
from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.reading import FieldReader
from hjsolve.algebra.several_variables import constant_zero
from hjsolve.algebra.shared_parts import common_parts
from hjsolve.algebra.signs import Bounds
from hjsolve.precision import NAMES, mp

DIGITS, MAX_DENOMINATOR, MAX_BASIS, MAX_NEIGHBOURS = 60, 720, 20, 5
MAX_OPERATIONS, MAX_NUMBER, MAX_VARIABLES = 60, 10**9, 3
MAX_COEFFICIENT, MAX_STEPS = 1000, 1000
SECONDS = 6.0
CHECKS = 4
Place = dict[sp.Symbol, sp.Rational]


@dataclass(frozen=True)
class _Term:
    """One function of the basis: as an element and as an expression."""

    element: Element
    expression: sp.Expr


def dependent(reader: FieldReader, g: Generator) -> Element | None:
    """Return the element of the field that equals a new generator on the domain, proved; None where none was found."""
    start = time.thread_time()
    found = _dependent(reader, g)
    reader.seconds_for_relations -= time.thread_time() - start
    return found


def _dependent(reader: FieldReader, g: Generator) -> Element | None:
    symbols = sorted(g.atom.free_symbols, key=str)
    inverse = isinstance(g.atom, PRIMITIVES) and not isinstance(g.atom, sp.log)
    if not (inverse or (g.kind == "root" and len(symbols) <= 1)):
        return None
    neighbours = _neighbours(reader, set(symbols), inverse=inverse)
    if not neighbours or not _worth_while(reader, g, neighbours):
        return None
    held = (reader.field.generators[k].atom.free_symbols for k in neighbours)
    symbols = sorted(g.atom.free_symbols.union(*held), key=str)
    if len(symbols) > MAX_VARIABLES or not all(s.is_real for s in symbols):
        return None
    start = time.thread_time()
    for factor, basis in _bases(reader, g, neighbours, inverse=inverse):
        reader.field.budget.check()
        if time.thread_time() - start > reader.seconds_for_relations:
            return None
        places = [dict(zip(symbols, place, strict=True)) for place in _places(reader, symbols, len(basis) + CHECKS)]
        found = _combination(g.atom * factor.expression, basis, symbols, places)
        if found is None:
            continue
        whole = sp.Add(*(c * t.expression for c, t in zip(found, basis, strict=True)))
        if _proved(reader, g.atom * factor.expression - whole, symbols, places):
            total = reader.field.total(
                t.element * Fraction(int(c.p), int(c.q)) for c, t in zip(found, basis, strict=True)
            )
            return total / factor.element
    return None


def _worth_while(reader: FieldReader, g: Generator, neighbours: Sequence[int]) -> bool:
    """Return whether a relation may be hoped for, and seconds are left for looking.

    Roots of different primes are independent; numbers of many digits come from places, not from users.
    """
    if reader.seconds_for_relations < 0 or sp.count_ops(g.atom) > MAX_OPERATIONS:
        return False
    if any(max(abs(int(r.p)), int(r.q)) > MAX_NUMBER for r in g.atom.atoms(sp.Rational)):
        return False
    nested = (reader.field.generators[k] for k in neighbours)
    plain = g.kind == "root" and g.atom.is_number
    return not plain or any(h.root is not None and any(h.root.radicand) for h in (g, *nested))


def _neighbours(reader: FieldReader, symbols: set[sp.Symbol], *, inverse: bool) -> list[int]:
    """Return the generators that a new one may depend on, newest first.

    Of the same variable, inverse ones of any of them.
    """
    found = []
    for k, g in enumerate(reader.field.generators):
        own = g.atom.free_symbols
        is_inverse = isinstance(g.atom, PRIMITIVES)
        if g.atom.has(sp.core.function.AppliedUndef) or is_inverse != (inverse and g.kind != "symbol"):
            continue
        if own == symbols or (is_inverse and own & symbols):
            found.append(k)
    return found[::-1]


def _bases(
    reader: FieldReader, g: Generator, neighbours: Sequence[int], *, inverse: bool
) -> Iterator[tuple[_Term, list[_Term]]]:
    """Factors and bases to try: g·factor as a combination of the basis."""
    field, one = reader.field, _Term(reader.field.one, sp.S.One)
    terms = [_Term(field.generator(k), field.generators[k].atom) for k in neighbours]
    if inverse:
        others = terms[: MAX_BASIS - 2]
        if others or g.atom.is_number:
            yield one, [_Term(reader.element(sp.pi), sp.pi), *others]
        return
    basis = [one]
    for k, t in zip(neighbours[:MAX_NEIGHBOURS], terms, strict=False):
        root = field.generators[k].root
        top = (root.order if root is not None else 3) - 1
        basis = [
            _Term(b.element * t.element**e, b.expression * t.expression**e)
            for b, e in product(basis, range(top + 1))
            if len(basis) * (top + 1) <= MAX_BASIS or e <= 1
        ][: 2 * MAX_BASIS]
        if len(basis) > MAX_BASIS:
            basis = sorted(basis, key=lambda b: b.expression.count_ops())[:MAX_BASIS]
    yield one, basis
    for k, t in zip(neighbours[:MAX_NEIGHBOURS], terms, strict=False):
        other = field.generators[k]
        if g.root is not None and g.root.order == 2 and other.kind == "root" and other.root and other.root.order == 2:
            yield t, basis


def _places(reader: FieldReader, symbols: Sequence[sp.Symbol], count: int) -> list[tuple[sp.Rational, ...]]:
    """Rational places of the domain; more than are asked for, since some may be refused."""
    columns = [_column(reader, s, 3 * count, k) for k, s in enumerate(symbols)]
    return list(zip(*columns, strict=True))


def _column(reader: FieldReader, symbol: sp.Symbol, count: int, k: int) -> list[sp.Rational]:
    low, high = _ends(reader, symbol)
    if any(e is not None and e.free_symbols for e in (low, high)):
        return []
    a, b = (None if e is None else sp.Rational(str(sp.N(e, 30))) for e in (low, high))
    fractions = [sp.Rational((377 * j + 101 * k * j * j) % 997 or 1, 997) for j in range(1, count + 1)]
    if a is not None and b is not None:
        return [a + (b - a) * fraction for fraction in fractions]
    if a is None and b is None:
        return [6 * fraction - 3 for fraction in fractions]
    return [a + 4 * fraction if a is not None else b - 4 * fraction for fraction in fractions]


def _ends(reader: FieldReader, symbol: sp.Symbol) -> Bounds:
    low, high = reader.bounds.get(symbol, (None, None))
    low = sp.S.Zero if low is None and symbol.is_nonnegative else low
    high = sp.S.Zero if high is None and symbol.is_nonpositive else high
    return low, high


def _combination(
    g: sp.Expr, basis: Sequence[_Term], symbols: Sequence[sp.Symbol], places: Sequence[Place]
) -> list[sp.Rational] | None:
    """Rational coefficients with which the basis gives g at all places, to 40 digits."""
    with mp.workdps(DIGITS):
        if not symbols:
            return _integer_relation(g, basis)
        named, left = common_parts([*(t.expression for t in basis), g])
        f = sp.lambdify(symbols, left, NAMES, cse=lambda _: (named, left))
        rows = []
        for place in places:
            try:
                row = f(*(mp.mpf(int(place[s].p)) / int(place[s].q) for s in symbols))
            except (ZeroDivisionError, ValueError, OverflowError, TypeError):
                continue
            if all(not isinstance(v, mp.mpc) and mp.isfinite(v) for v in row):
                rows.append(row)
            if len(rows) == len(basis) + CHECKS:
                break
        if len(rows) < len(basis) + CHECKS:
            return None
        return _solved(rows, len(basis))


def _solved(rows: Sequence[Sequence[mpmath.mpf]], n: int) -> list[sp.Rational] | None:
    matrix = mp.matrix([[mp.mpf(v) for v in row[:n]] for row in rows[:n]])
    right = mp.matrix([mp.mpf(row[n]) for row in rows[:n]])
    try:
        solution = mp.lu_solve(matrix, right)
    except (ZeroDivisionError, TypeError):
        return None
    found = []
    for v in solution:
        near = Fraction(int(mp.nint(v * 2**200)), 2**200).limit_denominator(MAX_DENOMINATOR)
        if abs(v - mp.mpf(near.numerator) / near.denominator) > mp.mpf(10) ** -15:
            return None
        found.append(near)
    for row in rows:
        value = mp.fsum(mp.mpf(c.numerator) / c.denominator * v for c, v in zip(found, row))
        if abs(value - row[n]) > mp.mpf(10) ** -40 * (1 + abs(row[n])):
            return None
    return [sp.Rational(c.numerator, c.denominator) for c in found]


def _integer_relation(g: sp.Expr, basis: Sequence[_Term]) -> list[sp.Rational] | None:
    numbers = (sp.N(x, DIGITS + 15) for x in (g, *(t.expression for t in basis)))
    values = [mp.convert(v._to_mpmath(250)) for v in numbers]
    if not all(isinstance(v, mp.mpf) and v for v in values):
        return None
    relation = mp.pslq(values, maxcoeff=MAX_COEFFICIENT, maxsteps=MAX_STEPS)
    if relation is None or not relation[0]:
        return None
    return [sp.Rational(-c, relation[0]) for c in relation[1:]]


def _proved(reader: FieldReader, difference: sp.Expr, symbols: Sequence[sp.Symbol], places: Sequence[Place]) -> bool:
    if not symbols:
        return constant_is_zero(at_one_place(difference)) is True
    if len(symbols) > 1:
        return constant_zero(reader, difference, symbols, places[0])
    budget = reader.field.budget
    try:
        return vanishes(difference, symbols[0], _ends(reader, symbols[0]), budget.part(SECONDS, budget.terms))
    except WorkLimitError:
        return False
