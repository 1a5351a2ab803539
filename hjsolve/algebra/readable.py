"""The form of an expression that a person would write: chosen by counting, never by ``simplify``."""

from __future__ import annotations

from fractions import Fraction

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reader import Reader

MAX_TERMS = 60


def shortest_form(reader: Reader, x: Element) -> sp.Expr:
    """Return the shortest of a few forms of an element.

    As it stands, factored, expanded over its denominator, sin² ↔ 1 − cos².
    """
    if x.is_zero:
        return sp.S.Zero
    if len(x.numerator) > MAX_TERMS or sum(len(base) for base, _ in x.bases) > 2 * MAX_TERMS:
        return reader.write(reader.field.cancelled(x))
    forms = [form for y in variants(reader, x) for form in _forms(reader, y)]
    return min(forms, key=length_of)


def variants(reader: Reader, x: Element) -> list[Element]:
    """Return the element with cos² eliminated in favour of sin², and the other way round, as far as that shortens it.

    Args:
        reader: reads into the field.
        x: an element.
    """
    x = reader.field.cancelled(x)
    found = [x]
    for k, g in enumerate(reader.field.generators):
        if g.partner is not None and g.root is not None and {k, g.partner} & x.generators:
            found.extend(_swapped(reader, y, k, g.partner) for y in list(found) if len(y.numerator) <= MAX_TERMS)
    return found[:8]


def _swapped(reader: Reader, x: Element, s: int, c: int) -> Element:
    """Rewrite numerator and bases with c² = 1 − s² (c² = 1 + s² for hyperbolic functions)."""
    field = reader.field
    sign = -1 if field.generators[s].kind == "sin" else 1
    square: Poly = {0: 1, 2 << (poly.BITS * s): sign}
    result = Element(field, x.coefficient, {0: 1}, {})
    for a, e in [(x.numerator, 1), *x.bases]:
        if any(poly.exponent(m, c) > 1 for m in a):
            a = poly.with_square(a, c, square, field.budget)
        result = _times_raw(reader, result, a, e)
    return _cancel_raw(reader, result)


def _times_raw(reader: Reader, x: Element, a: Poly, e: int) -> Element:
    """x·a^e without reducing a modulo the relations, all of it in the factors."""
    field = reader.field
    n = poly.content(a)
    a = {m: k // n for m, k in a.items()}
    common = poly.monomial_content(a)
    factors = dict(x.factors)
    for k, power in poly.exponents(common):
        b = field._base(poly.variable(k))
        factors[b] = factors.get(b, 0) + e * power
    for b, power in field.split({m - common: k for m, k in a.items()}):
        factors[b] = factors.get(b, 0) + e * power
    return Element(field, x.coefficient * Fraction(n) ** e, {0: 1}, {b: p for b, p in factors.items() if p})


def _cancel_raw(reader: Reader, x: Element) -> Element:
    """Gather positive factors with several terms into the numerator when there is only one of them."""
    positive = [b for b, e in x.factors.items() if e > 0 and len(reader.field.bases[b]) > 1]
    if len(positive) == 1 and x.factors[positive[0]] == 1:
        factors = {b: e for b, e in x.factors.items() if b != positive[0]}
        return Element(reader.field, x.coefficient, reader.field.bases[positive[0]], factors)
    return x


def _forms(reader: Reader, x: Element) -> list[sp.Expr]:
    field = reader.field
    forms = [reader.write(x)]
    if 1 < len(x.numerator) <= MAX_TERMS:
        forms.append(reader.write(field.factored(x)))
        c = sp.Rational(x.coefficient.numerator, x.coefficient.denominator)
        shared = sp.Mul(c, *[reader.write_poly(base) ** e for base, e in x.bases])
        terms = [reader.write_poly({m: n}) * shared for m, n in x.numerator.items()]
        forms.append(sp.Add(*terms))
    return [*forms, *_with_falling_exponentials(reader, field.factored(x))]


def _with_falling_exponentials(reader: Reader, x: Element) -> list[sp.Expr]:
    """(e^u − 1)²e^(−2u) as (1 − e^(−u))²: an exponential divided out of the factors that hold it."""
    field, forms = reader.field, []
    for k in x.generators:
        held = x.factors.get(field._base(poly.variable(k)), 0)
        if held >= 0 or not isinstance(field.generators[k].atom, sp.exp):
            continue
        atom = field.generators[k].atom
        parts = [sp.Rational(x.coefficient.numerator, x.coefficient.denominator)]
        for base, e in x.bases:
            degree = max(poly.exponent(m, k) for m in base)
            unit = 1 << (poly.BITS * k)
            terms = (
                reader.write_poly({m - unit * poly.exponent(m, k): n})
                * sp.exp((poly.exponent(m, k) - degree) * atom.args[0])
                for m, n in base.items()
            )
            parts += [sp.Add(*terms) ** e, atom ** (degree * e)]
        forms.append(sp.Mul(*parts))
    return forms


def length_of(x: sp.Expr) -> int:
    """Operations in an expression; sympy's count_ops takes seconds where this takes milliseconds."""
    if not x.args:
        return _digits(x) - 1 if x.is_Rational else 0
    if x.is_Pow:
        return length_of(x.base) + (1 + length_of(x.exp) if x.exp != -1 else 1)
    return max(len(x.args) - 1, 1) + sum(map(length_of, x.args))


def _digits(x: sp.Rational) -> int:
    """Letters of a rational number as it is written, the sign included; ``str`` of sympy is much slower."""
    p, q = int(x.p), int(x.q)
    return len(str(p)) + (len(str(q)) + 1 if q != 1 else 0)


def printed_length(x: Element) -> int:
    """Return a cheap measure of how long an element will print."""
    if x.is_zero:
        return 0
    size = 2 * len(x.numerator) + len(str(x.coefficient)) - 1 + sum(m.bit_count() > 0 for m in x.numerator)
    for base, e in x.bases:
        size += (1 if len(base) == 1 else 2 * len(base)) + (abs(e) > 1)
    return size
