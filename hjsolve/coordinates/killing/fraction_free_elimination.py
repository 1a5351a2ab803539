"""Elimination over a polynomial ring of parameters, remembering which polynomials were assumed not to vanish."""

from __future__ import annotations

from functools import reduce

import sympy as sp
from sympy.polys.domains.domain import Domain
from sympy.polys.rings import PolyElement, PolyRing

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.constant_field import FieldElement
from hjsolve.coordinates.killing.elimination import without_column


def echelon_over_ring(
    rows: list[list[PolyElement]], field: Domain
) -> tuple[dict[int, list[FieldElement]], tuple[sp.Expr, ...]]:
    """Bring rows of polynomials to reduced echelon form over their fraction field.

    Pivots are taken where they are simplest. The rank is the one found wherever none of the pivot factors vanishes;
    these factors are returned, so that the exceptional values of the parameters can be tried one by one.

    Args:
        rows: entries in the ring of ``field``; shape (equations, unknowns).
        field: a sympy fraction field.

    Returns:
        {pivot column: row over the field}, and the irreducible factors of all pivots and contents.
    """
    ring = field.field.ring
    factors: dict[PolyElement, None] = {}
    remaining = [_primitive(row, ring, factors) for row in rows if any(row)]
    done: list[tuple[int, list[PolyElement]]] = []
    while remaining:
        best = min(
            ((_size(entry), r, c) for r, row in enumerate(remaining) for c, entry in enumerate(row) if entry),
            default=None,
        )
        if best is None:
            break
        _, r, column = best
        pivot_row = remaining.pop(r)
        pivot = pivot_row[column]
        _note(pivot, factors)
        remaining = [_cleared(row, pivot_row, column, pivot, ring, factors) for row in remaining]
        remaining = [row for row in remaining if any(row)]
        done.append((column, pivot_row))
    return _back_substituted(done, field), tuple(factor.as_expr() for factor in factors)


def _size(entry: PolyElement) -> tuple[int, int, int]:
    degree = max(sum(monomial) for monomial in entry.itermonoms())
    return degree, len(entry), sum(abs(int(getattr(c, "numerator", 1))) for c in entry.itercoeffs()).bit_length()


def _note(polynomial: PolyElement, factors: dict[PolyElement, None]) -> None:
    if not polynomial.is_ground:
        for factor, _ in polynomial.factor_list()[1]:
            factors[factor.monic()] = None


def _primitive(row: list[PolyElement], ring: PolyRing, factors: dict[PolyElement, None]) -> list[PolyElement]:
    common = reduce(lambda a, b: a.gcd(b), (entry for entry in row if entry), ring.zero)
    if not common or common.is_ground:
        return row
    _note(common, factors)
    return [entry.exquo(common) if entry else entry for entry in row]


def _cleared(
    row: list[PolyElement], pivot_row: list[PolyElement], column: int, pivot: PolyElement, ring: PolyRing,
    factors: dict[PolyElement, None],
) -> list[PolyElement]:  # fmt: skip
    if not row[column]:
        return row
    check_time()
    common = pivot.gcd(row[column])
    a, b = pivot.exquo(common), row[column].exquo(common)
    return _primitive([a * mine - b * its for mine, its in zip(row, pivot_row, strict=True)], ring, factors)


def _back_substituted(done: list[tuple[int, list[PolyElement]]], field: Domain) -> dict[int, list[FieldElement]]:
    reduced: dict[int, list[FieldElement]] = {}
    for column, polynomials in reversed(done):
        lead = field(polynomials[column])
        row = [field(entry) / lead if entry else field.zero for entry in polynomials]
        for other, other_row in reduced.items():
            row = without_column(row, other_row, other)
        reduced[column] = row
    return reduced
