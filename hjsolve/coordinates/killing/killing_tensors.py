"""Killing tensors K with d(K·dV) = 0, exactly.

The quadratic first integral ½K^{ij}p_i p_j + U of H = ½p² + V exists if and only if K is a Killing tensor and the
one-form K·dV is closed (Benenti; Smirnov, math-ph/0604038):

    ∂_j(K_i^l ∂_l V) − ∂_i(K_j^l ∂_l V) = 0,   i < j,

which is linear in the constants of K: six in the plane, twenty in space. A concircular tensor
L = A + w⊗x + x⊗w + m x⊗x gives the Killing tensor K = (tr L) g − L; those are all of them in the plane, and a
ten-dimensional subspace in space (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache, reduce
from itertools import combinations, combinations_with_replacement, count
from operator import mul
from random import Random

import sympy as sp
from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement
from sympy.polys.rings import PolyElement

from hjsolve.algebra.shared_parts import derivatives
from hjsolve.coordinates.killing.constant_field import EquationTable, FieldElement, Ground, Rows
from hjsolve.coordinates.killing.fraction_free_elimination import echelon_over_ring
from hjsolve.coordinates.killing.numerical_rank import rank_in_numbers, reconstructed_kernel
from hjsolve.coordinates.killing.radical_algebra import (
    Element,
    Key,
    PointAlgebra,
    ZeroDivisorError,
    collected_generators,
    prepared,
)
from hjsolve.errors import InternalError

_POINTS_WITHOUT_NEWS = 4
_MOST_POINTS = 200


def concircular_basis(n: int) -> tuple[sp.ImmutableMatrix, ...]:
    """Return the symmetric (n+1)×(n+1) matrices E_ab; M = [[A, w], [wᵀ, m]] stands for L = A + w⊙x + m x⊗x.

    Args:
        n: dimension.
    """
    basis = []
    for a, b in combinations_with_replacement(range(n + 1), 2):
        matrix = sp.zeros(n + 1, n + 1)
        matrix[a, b] = matrix[b, a] = 1
        basis.append(sp.ImmutableMatrix(matrix))
    return tuple(basis)


def concircular_tensor(matrix: sp.MatrixBase, x: Sequence[sp.Expr]) -> sp.ImmutableMatrix:
    """Return L = A + w⊗x + x⊗w + m x⊗x for M = [[A, w], [wᵀ, m]]; shape (n, n).

    Args:
        matrix: M, shape (n + 1, n + 1).
        x: Cartesian coordinates, or a place; length n.
    """
    n = len(x)
    frame = sp.eye(n).row_join(sp.Matrix(x))
    return sp.ImmutableMatrix((frame * matrix * frame.T).applyfunc(sp.expand))


def killing_tensor(matrix: sp.MatrixBase, x: Sequence[sp.Expr]) -> sp.ImmutableMatrix:
    """Return K = (tr L) g − L of a concircular tensor.

    Args:
        matrix: M of L, shape (n + 1, n + 1).
        x: Cartesian coordinates, or a place; length n.
    """
    L = concircular_tensor(matrix, x)
    return sp.ImmutableMatrix((L.trace() * sp.eye(len(x)) - L).applyfunc(sp.expand))


def killing_basis(x: Sequence[sp.Symbol]) -> tuple[sp.ImmutableMatrix, ...]:
    """Return all Killing 2-tensors of the Euclidean plane (6) or space (20).

    They are the symmetrised products of the n translations and n(n−1)/2 rotations. In space the 21 products obey one
    syzygy, p·(x×p) = 0; the product p₃ ⊙ (x×p)₃ is left out.

    Args:
        x: Cartesian coordinates, two or three.
    """
    n = len(x)
    vectors = [sp.Matrix([int(i == j) for j in range(n)]) for i in range(n)]
    for i, j in combinations(range(n), 2):
        vectors.append(sp.Matrix([-x[j] if k == i else x[i] if k == j else 0 for k in range(n)]))
    products = list(combinations_with_replacement(range(len(vectors)), 2))
    if n == 3:
        products.remove((2, 3))
    return tuple(sp.ImmutableMatrix((vectors[a] * vectors[b].T + vectors[b] * vectors[a].T) / 2) for a, b in products)


@dataclass(frozen=True)
class Kernel:
    """The solutions of d(K·dV) = 0 in the span of a basis.

    Attributes:
        vectors: one row of constants for each independent solution, reduced row echelon form, over Q(parameters).
        complete: an independent numerical rank agrees with the dimension, so nothing was missed.
        pivots: irreducible polynomials in the parameters; where none of them vanishes the dimension is this one.
    """

    vectors: tuple[tuple[sp.Expr, ...], ...]
    complete: bool
    pivots: tuple[sp.Expr, ...]

    @property
    def dimension(self) -> int:
        """Number of independent solutions."""
        return len(self.vectors)


@cache
def _coefficients(tensors: tuple[sp.ImmutableMatrix, ...], x: tuple[sp.Symbol, ...]) -> EquationTable:
    """Write d(K·dV)_ij = Σ_a c_a V_a + Σ_ab c_ab V_ab; returns [(i, j)][tensor] = {slot: polynomial terms}."""
    n = len(x)
    slots: list[tuple[int, ...]] = [(a,) for a in range(n)] + list(combinations_with_replacement(range(n), 2))
    table = []
    for i, j in combinations(range(n), 2):
        row = []
        for K in tensors:
            entry: dict[tuple[int, ...], sp.Expr] = dict.fromkeys(slots, sp.S.Zero)
            for a in range(n):
                entry[(a,)] += sp.diff(K[i, a], x[j]) - sp.diff(K[j, a], x[i])
                entry[min(a, j), max(a, j)] += K[i, a]
                entry[min(a, i), max(a, i)] -= K[j, a]
            row.append([(slots.index(slot), sp.Poly(value, *x).terms()) for slot, value in entry.items() if value])
        table.append(row)
    return table


def _in_domain(table: EquationTable, domain: Domain) -> EquationTable:
    """Convert the rational coefficients of a table to the numbers of the field of constants, once for all points."""
    return [
        [
            [(slot, [(exponents, domain.convert(c)) for exponents, c in terms]) for slot, terms in tensor]
            for tensor in equation
        ]
        for equation in table
    ]


class Samples:
    """The derivatives of V at one random regular point after another, worked out when they are first asked for.

    Attributes:
        values: the derivatives, prepared.
        made_of: what they are made of.
    """

    def __init__(self, V: sp.Expr, x: tuple[sp.Symbol, ...]):
        self.values = prepared(derivatives(V, x), x)
        self.made_of = collected_generators(self.values, x)
        self._random, self._left = Random(20161), _MOST_POINTS  # noqa: S311
        self._known: list[tuple[list[FieldElement], list[Element]]] = []

    def at(self, k: int) -> tuple[list[FieldElement], list[Element]]:
        """Return the k-th point, in numbers of the field of constants, and the derivatives there.

        Args:
            k: from 0 on.

        Raises:
            InternalError: there are no regular points.
        """
        while len(self._known) <= k:
            if not self._left:
                raise InternalError("find_coordinates: no regular points of the potential were found")
            self._left -= 1
            algebra = PointAlgebra(self.made_of, self._random)
            try:
                elements = [algebra.evaluate(value) for value in self.values]
            except (ZeroDivisorError, ZeroDivisionError):
                continue
            numbers = self.made_of.ground.numbers
            self._known.append(([numbers.convert(value) for value in algebra.plain.values()], elements))
        return self._known[k]


@lru_cache(maxsize=8)
def _samples(V: sp.Expr, x: tuple[sp.Symbol, ...]) -> Samples:
    """The samples of a potential, the same for every family of tensors."""
    return Samples(V, x)


def _rows_at(
    ground: Ground, x: Sequence[FieldElement], elements: Sequence[Element], table: EquationTable, width: int
) -> Rows:
    """Return the linear equations that one point gives."""
    field, numbers = ground.field, ground.numbers
    zero = ground.plain.zero
    monomials: dict[tuple[int, ...], FieldElement] = {}
    rows: Rows = []
    for equation in table:
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


def _reduce(row: list[FieldElement], echelon: dict[int, list[FieldElement]]) -> int | None:
    """Reduce a row against an echelon form; add it and return its pivot, or None where it was dependent."""
    for column, pivot_row in echelon.items():
        if row[column]:
            factor = row[column]
            row = [a - factor * b for a, b in zip(row, pivot_row, strict=True)]
    pivot = next((c for c, entry in enumerate(row) if entry), None)
    if pivot is None:
        return None
    row = [entry / row[pivot] for entry in row]
    for column, other in echelon.items():
        if other[pivot]:
            factor = other[pivot]
            echelon[column] = [a - factor * b for a, b in zip(other, row, strict=True)]
    echelon[pivot] = row
    return pivot


def _nullspace(echelon: Mapping[int, list[FieldElement]], width: int, field: Domain) -> Rows:
    """Return a basis of the kernel of an echelon form, itself in reduced echelon form."""
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


def _points(samples: Samples, table: EquationTable, width: int) -> Iterator[Rows]:
    """Yield the equations of one random regular point after another."""
    ground = samples.made_of.ground
    converted = _in_domain(table, ground.numbers)
    for k in count():
        yield _rows_at(ground, *samples.at(k), converted, width)


def _span(point_rows: Iterable[list[list[FracElement]]], ground: Ground, width: int) -> list[list[PolyElement]] | None:
    """Return sparse equations over Q[parameters] that span those of all points, or None if not polynomial.

    The equations of different points are rational combinations of a few ones with polynomial coefficients (those of
    the monomials of the coordinates). They are found again by elimination over Q in the space of columns times
    parameter monomials, which makes them sparse and their pivots independent of the points.
    """
    index: dict[tuple[int, ...], int] = {}
    echelon: dict[int, dict[int, FieldElement]] = {}
    base, ring = ground.field.domain, ground.field.field.ring
    quiet = 0
    for rows in point_rows:
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


def kernel(V: sp.Expr, x: Sequence[sp.Symbol], tensors: Sequence[sp.ImmutableMatrix], *, check: bool = True) -> Kernel:
    """Solve d(K·dV) = 0 exactly for the constants k of K = Σ k_b K_b, over the field Q(parameters).

    Args:
        V: potential, an analytic expression in the Cartesian coordinates x and any parameters.
        x: Cartesian coordinates.
        tensors: the Killing tensors K_b, matrices of polynomials in x.
        check: count the dimension a second time, by numbers.

    Returns:
        A ``Kernel``; the parameters are taken as independent (generic) quantities.
    """
    return _kernel(V, tuple(x), tuple(tensors), check)


@lru_cache(maxsize=16)
def _kernel(V: sp.Expr, x: tuple[sp.Symbol, ...], tensors: tuple[sp.ImmutableMatrix, ...], check: bool) -> Kernel:
    width, samples, table = len(tensors), _samples(V, x), _coefficients(tensors, x)
    ground, stream = samples.made_of.ground, _points(samples, table, width)
    sparse = _span(stream, ground, width) if ground.parameters else None
    pivots: tuple[sp.Expr, ...] = ()
    if sparse is not None:
        echelon, pivots = echelon_over_ring(sparse, ground.field)
    else:
        echelon = _dense_echelon(stream)
    basis = _nullspace(echelon, width, ground.field)
    vectors = tuple(tuple(ground.restore(entry) for entry in vector) for vector in basis)
    complete = not check
    if check:
        upper = width - rank_in_numbers(V, x, table, width)
        if upper > len(vectors) and not ground.parameters:
            vectors = reconstructed_kernel(V, x, table, width) or vectors
        complete = upper == len(vectors)
    restored = tuple(p.xreplace({d: c for c, d in ground.opaque.items()}) for p in pivots)
    return Kernel(vectors, complete, restored)


def dimension_by_numbers(V: sp.Expr, x: Sequence[sp.Symbol], tensors: Sequence[sp.ImmutableMatrix]) -> int:
    """Upper bound of the dimension of the kernel, from 60-digit numbers.

    Args:
        V: potential V(x).
        x: Cartesian coordinates, two or three.
        tensors: K of which linear combinations are sought, shape (n, n) each.
    """
    return len(tensors) - rank_in_numbers(V, tuple(x), _coefficients(tuple(tensors), tuple(x)), len(tensors))


def _dense_echelon(stream: Iterable[Rows]) -> dict[int, list[FieldElement]]:
    echelon: dict[int, list[FieldElement]] = {}
    quiet = 0
    for rows in stream:
        news = [row for row in rows if _reduce(row, echelon) is not None]
        quiet = 0 if news else quiet + 1
        if quiet == _POINTS_WITHOUT_NEWS:
            break
    return echelon
