"""Irreducible factors of small polynomials, without the steps of general algorithms that may take minutes.

A polynomial that is linear in some generator, f = A·g + B, is gcd(A, B) times an irreducible one: polynomials of
mechanics are nearly always linear in a mass, a length or a charge, and the gcd is quick. What is linear in none is
given to the general algorithm of sympy (Wang's) only where it is small, since that has no bound of its own.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.poly import Poly

MAX_TERMS = 60
MAX_GENERATORS = 8
MAX_DEGREES = {1: 60, 2: 30, 3: 18}
MAX_DEGREES_OF_MANY = 14
Element = Any
"""An element of a polynomial ring of sympy, over the integers or the rationals."""
Factors = list[tuple[Element, int]]


def factors_of(a: Poly) -> list[tuple[Poly, int]]:
    """Irreducible factors where that is cheap, else the polynomial itself."""
    names = poly.generators(a)
    if len(a) <= 1 or len(a) > MAX_TERMS or len(names) > MAX_GENERATORS:
        return [(a, 1)]
    ring = sp.polys.rings.ring([f"g{k}" for k in names], sp.ZZ)[0]
    element = ring.from_dict({tuple(poly.exponent(m, k) for k in names): c for m, c in a.items()})
    factors = []
    for factor, e in irreducible(element):
        packed = {sum(n << (poly.BITS * k) for n, k in zip(ms, names, strict=True)): int(c) for ms, c in factor.terms()}
        sign = 1 if packed[max(packed)] > 0 else -1
        factors.append((poly.scale(packed, sign), e))
    return factors


def factored(expression: sp.Expr, generators: int = MAX_GENERATORS) -> sp.Expr:
    """Return a polynomial in whatever it holds as a product of factors, irreducible where that is cheap.

    Args:
        expression: a polynomial in symbols, functions and roots, with rational coefficients; others come back as given.
        generators: how many symbols, functions and roots it may hold, or it comes back as given.
    """
    made = expression.as_poly()
    if made is None or made.domain not in (sp.ZZ, sp.QQ) or len(made.gens) > generators:
        return expression
    primitive = made.clear_denoms(convert=True)[1].primitive()[1]
    ring = sp.polys.rings.ring([f"g{k}" for k in range(len(made.gens))], sp.ZZ)[0]
    element = ring.from_dict({m: int(c) for m, c in primitive.terms()})
    unit, written = made.LC(), []
    for factor, e in irreducible(element):
        positive = factor if factor.LC > 0 else -factor
        unit /= int(positive.LC) ** e
        written.append(positive.as_expr(*made.gens) ** e)
    return sp.Mul(unit, *written) if len(written) != 1 or unit in (1, -1) else sp.Mul(unit, *written, evaluate=False)


def irreducible(f: Element) -> Factors:
    """Return the factors of a polynomial up to a constant, each prime to the others; irreducible where cheap."""
    if f.is_ground:
        return []
    for k in range(f.ring.ngens):
        parts = _coefficients(f, k)
        if len(parts) == 1 and 0 not in parts:
            ((degree, rest),) = parts.items()
            return [(f.ring.gens[k], degree), *irreducible(rest)]
    for k in range(f.ring.ngens):
        parts = _coefficients(f, k)
        if set(parts) == {0, 1}:
            common = reduce(lambda a, b: a.gcd(b), parts.values())
            return _gathered([(f.exquo(common).primitive()[1], 1), *irreducible(common)])
    if _small(f):
        return [(factor, e) for factor, e in f.factor_list()[1]]
    for k in range(f.ring.ngens):
        parts = _coefficients(f, k)
        common = reduce(lambda a, b: a.gcd(b), parts.values())
        if set(parts) != {0} and not common.is_ground:
            return _gathered([*irreducible(f.exquo(common)), *irreducible(common)])
    return [(f.primitive()[1], 1)]


def _small(f: Element) -> bool:
    degrees = [d for d in f.degrees() if d > 0]
    return sum(degrees) <= MAX_DEGREES.get(len(degrees), MAX_DEGREES_OF_MANY)


def _coefficients(f: Element, k: int) -> dict[int, Element]:
    """Return the coefficients of f as a polynomial in generator k, by its power; they hold the others only."""
    found: dict[int, dict[tuple[int, ...], Any]] = {}
    for monomial, c in f.terms():
        found.setdefault(monomial[k], {})[(*monomial[:k], 0, *monomial[k + 1 :])] = c
    return {power: f.ring.from_dict(terms) for power, terms in found.items()}


def _gathered(factors: Factors) -> Factors:
    """Equal factors together."""
    found: dict[Element, int] = {}
    for factor, e in factors:
        if factor.is_ground:
            continue
        same = factor if factor.LC > 0 else -factor
        found[same] = found.get(same, 0) + e
    return list(found.items())
