"""Roots in a field.

Taken apart where signs are proved, denested where that is possible, else a generator with its relation.
"""

from __future__ import annotations

import math
from fractions import Fraction

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element, Field, Generator, RootRelation
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reading import FieldReader
from hjsolve.algebra.signs import sign_of

MAX_FACTORED = 10**15
"""Larger numbers are not factored, and no root of a sum with larger ones is denested: its C² has their squares."""


def root(reader: FieldReader, x: Element, p: int, q: int) -> Element:
    """x^(p/q), the real root.

    Factors whose sign on the domain is proved get a root of their own, so that √(ab) = √a·√b and √(P²) = ±P are used
    where they are true and nowhere else; the other factors stay together under one root.

    Args:
        reader: of the field; it knows the domain.
        p, q: numerator and denominator of the exponent.
    """
    if x.is_zero:
        return x
    field = reader.field
    x = field.factored(x)
    outside, rest_factors, negative = field.one, {}, x.coefficient < 0
    for b, e in x.factors.items():
        sign = sign_of(field, field.bases[b], reader.bounds)
        if sign == 0 and not (q % 2 == 1 and e % q == 0):
            rest_factors[b] = e
            continue
        negative ^= sign < 0 and e % 2 == 1
        whole, part = divmod(e * p, q)
        base = Element(field, Fraction(1 if sign >= 0 else -1), {0: 1}, {b: 1})
        outside = outside * base**whole
        if part:
            outside = outside * _base_root(reader, base, q) ** part
    outside = outside * _number_root(reader, abs(x.coefficient), p, q)
    if not rest_factors and not negative:
        return outside
    rest = Element(field, Fraction(-1 if negative else 1), {0: 1}, rest_factors)
    return outside * _rest_root(reader, rest, q) ** p


def _base_root(reader: FieldReader, base: Element, q: int) -> Element:
    """base^(1/q) for ± a base polynomial that is not negative on the domain."""
    ((b, _),) = base.factors.items()
    radicand = poly.scale(reader.field.bases[b], int(base.coefficient))
    if q == 2 and (simpler := _denested(reader, radicand)) is not None:
        return simpler
    return _adjoin(reader, radicand, reader.field.one, q, nonnegative=True)


def _rest_root(reader: FieldReader, rest: Element, q: int) -> Element:
    """rest^(1/q) where rest = N/D.

    The generator is D·rest^(1/q), a root of N·D^(q−1), whatever the sign of D.
    """
    field = reader.field
    up = Element(field, rest.coefficient, {0: 1}, {b: e for b, e in rest.factors.items() if e > 0})
    down = Element(field, Fraction(1), {0: 1}, {b: -e for b, e in rest.factors.items() if e < 0})
    radicand = up * down ** (q - 1)
    expanded: Poly = {0: int(radicand.coefficient)}
    for base, e in [*radicand.bases, (radicand.numerator, 1)]:
        for _ in range(e):
            expanded = field.reduce(poly.mul(expanded, base, field.budget))
    if q == 2 and not down.factors and (simpler := _denested(reader, expanded)) is not None:
        return simpler
    return _adjoin(reader, expanded, down, q, nonnegative=not down.factors) / down


def _denested(reader: FieldReader, radicand: Poly) -> Element | None:
    """Denest √(A + B√d) = √((A+C)/2) ± √((A−C)/2).

    C² = A² − B²d must have a root C in the functions that A, B and d are made of, and the roots of (A ± C)/2 must be
    nested less deeply; A ≥ 0 and the sign of B must be
    proved. Where B > 0, either sign of C gives the same sum, so that the sign of C need not be known.
    Borodin, Fagin, Hopcroft and Tompa, J. Symb. Comp. 1 (1985) 169.

    Raises:
        WorkLimitError: the budget is used up.
    """
    field = reader.field
    field.budget.check()
    if max(map(abs, radicand.values())) > MAX_FACTORED:
        return None
    for k in reversed(poly.generators(radicand)):
        g = field.generators[k]
        if g.kind != "root" or g.root is None or g.root.order != 2:
            continue
        unit = 1 << (poly.BITS * k)
        B = {m - unit: c for m, c in radicand.items() if poly.exponent(m, k)}
        A = {m: c for m, c in radicand.items() if not poly.exponent(m, k)}
        side = sign_of(field, B, reader.bounds)
        if not A or side == 0 or sign_of(field, A, reader.bounds) <= 0:
            continue
        own = {*poly.generators(radicand), *poly.generators(g.root.radicand)} - {k}
        a = field.from_poly(A)
        square = a**2 - field.from_poly(B) ** 2 * field.from_poly(g.root.radicand)
        C = (_whole_root(field, square) if side > 0 else None) or root(reader, square, 1, 2)
        if not all(j in own or field.generators[j].atom.is_number for j in C.generators):
            continue
        half = Fraction(1, 2)
        parts = [(a + C) * half, (a - C) * half]
        number = g.atom.is_number
        inside = max((_depth(field, j, number) for part in parts for j in part.generators), default=0)
        if inside >= _depth(field, k, number):
            continue
        return root(reader, parts[0], 1, 2) + root(reader, parts[1], 1, 2) * side
    return None


def _depth(field: Field, k: int, number: bool) -> int:
    """Return how many roots of numbers, or of functions, lie in each other in a generator.

    Denesting goes on only where this falls, or it would go round in circles: √(3 + √2) → √(3 + √7) → √(3 + √2).
    """
    g = field.generators[k]
    if g.kind != "root" or g.root is None:
        return 0
    inside = max((_depth(field, j, number) for j in poly.generators(g.root.radicand)), default=0)
    return inside + (g.atom.is_number is number)


def _whole_root(field: Field, square: Element) -> Element | None:
    """C with C² = square, of either sign; None where the square is none of a rational function of the generators."""
    if square.is_zero:
        return None
    x = field.factored(square)
    top, bottom = (math.isqrt(abs(n)) for n in (x.coefficient.numerator, x.coefficient.denominator))
    if Fraction(top, bottom) ** 2 != x.coefficient or any(e % 2 for e in x.factors.values()):
        return None
    return Element(field, Fraction(top, bottom), {0: 1}, {b: e // 2 for b, e in x.factors.items()})


def _adjoin(reader: FieldReader, radicand: Poly, factor: Element, q: int, *, nonnegative: bool) -> Element:
    value = reader.write(reader.field.from_poly(radicand) / factor**q)
    atom = reader.write(factor) * sp.Pow(value, sp.Rational(1, q))
    if atom.is_Rational:
        return reader.element(atom)
    low = Fraction(0) if nonnegative and q % 2 == 0 else None
    return reader.adjoined(Generator(atom, "root", RootRelation(q, radicand), low=low))


def _number_root(reader: FieldReader, value: Fraction, p: int, q: int) -> Element:
    """value^(p/q) for a positive rational number, over the roots of primes."""
    result = reader.field.one
    for n, sign in ((value.numerator, 1), (value.denominator, -1)):
        factors = sp.factorint(n) if n < MAX_FACTORED else {n: 1}
        for prime, e in factors.items():
            whole, part = divmod(sign * e * p, q)
            result = result * Fraction(prime) ** whole
            if part:
                atom = sp.Pow(sp.Integer(prime), sp.Rational(1, q))
                generator = Generator(atom, "root", RootRelation(q, {0: int(prime)}), low=Fraction(0))
                result = result * reader.adjoined(generator) ** part
    return result
