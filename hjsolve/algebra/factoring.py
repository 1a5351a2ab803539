"""Irreducible factors of small polynomials; the one step that calls sympy, and only where it is cheap."""

from __future__ import annotations

from collections.abc import Sequence
from math import gcd

import sympy as sp

from . import poly
from .poly import Poly


def factors_of(a: Poly) -> list[tuple[Poly, int]]:
    """Irreducible factors where that is cheap, else the polynomial itself."""
    names = poly.generators(a)
    if len(a) <= 1 or len(a) > 40 or len(names) > 8 or _obviously_irreducible(a, names):
        return [(a, 1)]
    ring = sp.polys.rings.ring([f"g{k}" for k in names], sp.ZZ)[0]
    element = ring.from_dict({tuple(poly.exponent(m, k) for k in names): c for m, c in a.items()})
    if sum(element.degrees()) > 24:
        return [(a, 1)]
    factors = []
    for factor, e in element.factor_list()[1]:
        packed = {sum(n << (poly.BITS * k) for n, k in zip(ms, names, strict=True)): int(c) for ms, c in factor.terms()}
        sign = 1 if packed[max(packed)] > 0 else -1
        factors.append((poly.scale(packed, sign), e))
    return factors


def _obviously_irreducible(a: Poly, names: Sequence[int]) -> bool:
    """Linear in some generator, a = A·g + B, with A a monomial prime to B; a is primitive."""
    for k in names:
        top = [m for m in a if poly.exponent(m, k)]
        if len(top) != 1 or poly.exponent(top[0], k) != 1:
            continue
        rest = [m for m in a if m != top[0]]
        if gcd(a[top[0]], *(a[m] for m in rest)) == 1 and not poly.monomial_content(
            [top[0] - (1 << (poly.BITS * k)), *rest]
        ):
            return True
    return False
