"""Elimination in d(K·dV) = 0: the equations of one random point after another, over any field of constants."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import count
from operator import mul

from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.constant_field import EquationTable, FieldElement, Ground, Rows
from hjsolve.coordinates.killing.radical_algebra import Element, Key
from hjsolve.coordinates.killing.samples import Samples

_POINTS_WITHOUT_NEWS = 4


def equations_at_points(samples: Samples, table: EquationTable, width: int) -> Iterator[Rows]:
    """Yield the equations of one random regular point after another.

    Args:
        samples: of the derivatives of V.
        width: how many tensors there are.
    """
    ground = samples.made_of.ground
    converted = _in_domain(table, ground.numbers)
    for k in count():
        yield _rows_at(ground, *samples.at(k), converted, width)


def _in_domain(table: EquationTable, domain: Domain) -> EquationTable:
    """Convert the rational coefficients of a table to elements of the field of constants, once for all points."""
    return [
        [
            [(slot, [(exponents, domain.convert(c)) for exponents, c in terms]) for slot, terms in tensor]
            for tensor in equation
        ]
        for equation in table
    ]


def _rows_at(
    ground: Ground, x: Sequence[FieldElement], elements: Sequence[Element], table: EquationTable, width: int
) -> Rows:
    """Return the linear equations that one point gives."""
    field, numbers = ground.field, ground.numbers
    zero = ground.plain.zero
    monomials: dict[tuple[int, ...], FieldElement] = {}
    rows: Rows = []
    for equation in table:
        check_time()
        parts: dict[Key, list[FieldElement]] = {}
        for column, tensor in enumerate(equation):
            for slot, terms in tensor:
                if not elements[slot]:
                    continue
                number = numbers.zero
                for exponents, coefficient in terms:
                    if exponents not in monomials:
                        monomials[exponents] = reduce(mul, (q**e for q, e in zip(x, exponents, strict=True)))
                    number += coefficient * monomials[exponents]
                for key, value in elements[slot].items():
                    row = parts.setdefault(key, [zero] * width)
                    row[column] += value * number
        rows.extend([field.convert(entry) for entry in row] for row in parts.values())
    return rows


def without_column(row: list[FieldElement], pivot_row: list[FieldElement], column: int) -> list[FieldElement]:
    """Return a row less so much of one with 1 in a column that its own entry there is 0."""
    factor = row[column]
    if not factor:
        return row
    check_time()
    return [a - factor * b for a, b in zip(row, pivot_row, strict=True)]


def _reduce(row: list[FieldElement], echelon: dict[int, list[FieldElement]]) -> int | None:
    """Reduce a row against an echelon form; add it and return its pivot, or None where it was dependent."""
    for column, pivot_row in echelon.items():
        row = without_column(row, pivot_row, column)
    pivot = next((c for c, entry in enumerate(row) if entry), None)
    if pivot is None:
        return None
    row = [entry / row[pivot] for entry in row]
    for column, other in echelon.items():
        echelon[column] = without_column(other, row, pivot)
    echelon[pivot] = row
    return pivot


def nullspace(echelon: Mapping[int, list[FieldElement]], width: int, field: Domain) -> Rows:
    """Return a basis of the kernel of an echelon form, itself in reduced echelon form.

    Args:
        echelon: pivot column → row.
        width: number of columns.
        field: of the entries.
    """
    vectors = []
    for free in (c for c in range(width) if c not in echelon):
        vector = [field.zero] * width
        vector[free] = field.one
        for column, row in echelon.items():
            vector[column] = -row[free]
        vectors.append(vector)
    reduced: dict[int, list[FieldElement]] = {}
    for vector in vectors:
        _reduce(vector, reduced)
    return [reduced[column] for column in sorted(reduced)]


def dense_echelon(stream: Iterable[Rows], points: int | None = None) -> tuple[dict[int, list[FieldElement]], int]:
    """Return the reduced echelon form of the equations of all points, and how many points it needed.

    Args:
        stream: the equations of one point after another.
        points: how many to look at; None: until some in a row bring nothing new.
    """
    echelon: dict[int, list[FieldElement]] = {}
    quiet = needed = 0
    for number, rows in enumerate(stream, 1):
        news = [row for row in rows if _reduce(row, echelon) is not None]
        quiet, needed = (0, number) if news else (quiet + 1, needed)
        if quiet == _POINTS_WITHOUT_NEWS or number == points:
            break
    return echelon, max(needed, 1)


def polynomial_span(
    stream: Iterable[list[list[FracElement]]], ground: Ground, width: int
) -> list[list[PolyElement]] | None:
    """Return sparse equations over Q[parameters] that span those of all points, or None if not polynomial.

    The equations of different points are rational combinations of a few ones with polynomial coefficients (those of
    the monomials of the coordinates). They are found again by elimination over Q in the space of columns times
    parameter monomials, which makes them sparse and their pivots independent of the points.

    Args:
        stream: the equations of one point after another.
        ground: field of the constants.
        width: how many tensors there are.
    """
    index: dict[tuple[int, ...], int] = {}
    echelon: dict[int, dict[int, FieldElement]] = {}
    base, ring = ground.field.domain, ground.field.field.ring
    quiet = 0
    for rows in stream:
        check_time()
        news = False
        for row in rows:
            flat: dict[int, FieldElement] = {}
            for column, entry in enumerate(row):
                if not entry.denom.is_ground:
                    return None
                for monomial, coefficient in (entry.numer / entry.denom.LC).terms() if entry else ():
                    flat[index.setdefault((column, monomial), len(index))] = coefficient
            news |= _reduce_sparse(flat, echelon)
        quiet = 0 if news else quiet + 1
        if quiet == 2:
            break
        if len(echelon) > 400:
            return None
    names = {number: key for key, number in index.items()}
    result = []
    for sparse in echelon.values():
        row = [ring.zero] * width
        for number, coefficient in sparse.items():
            column, monomial = names[number]
            row[column] += ring.term_new(monomial, base.convert(coefficient))
        result.append(row)
    return result


def _reduce_sparse(row: dict[int, FieldElement], echelon: dict[int, dict[int, FieldElement]]) -> bool:
    def subtract(a: dict[int, FieldElement], factor: FieldElement, b: dict[int, FieldElement]) -> None:
        for key, value in b.items():
            new = a.get(key, 0) - factor * value
            if new:
                a[key] = new
            else:
                a.pop(key, None)

    check_time()
    for column, pivot_row in echelon.items():
        if column in row:
            subtract(row, row[column], pivot_row)
    if not row:
        return False
    pivot = min(row)
    lead = row[pivot]
    row = {key: value / lead for key, value in row.items()}
    for other in echelon.values():
        if pivot in other:
            subtract(other, other[pivot], row)
    echelon[pivot] = row
    return True
