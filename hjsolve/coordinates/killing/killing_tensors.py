"""Killing tensors K with d(K·dV) = 0, exactly.

The quadratic first integral ½K^{ij}p_i p_j + U of H = ½p² + V exists if and only if K is a Killing tensor and the
one-form K·dV is closed (Benenti; Smirnov, math-ph/0604038):

    ∂_j(K_i^l ∂_l V) − ∂_i(K_j^l ∂_l V) = 0,   i < j,

which is linear in the constants of K: six in the plane, twenty in space. A concircular tensor
L = A + w⊗x + x⊗w + m x⊗x gives the Killing tensor K = (tr L) g − L; those are all of them in the plane, and a
ten-dimensional subspace in space (Rajaratnam, McLenaghan, Valero, SIGMA 12 (2016) 117).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import combinations, combinations_with_replacement

import sympy as sp

from hjsolve.coordinates.killing.constant_field import EquationTable, Rows
from hjsolve.coordinates.killing.elimination import dense_echelon, equations_at_points, nullspace, polynomial_span
from hjsolve.coordinates.killing.fraction_free_elimination import echelon_over_ring
from hjsolve.coordinates.killing.letters import kernel_in_letters, letters_are_polynomial
from hjsolve.coordinates.killing.numerical_rank import rank_in_numbers, reconstructed_kernel
from hjsolve.coordinates.killing.samples import Samples, samples_of


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
    width, samples, table = len(tensors), samples_of(V, x), _coefficients(tensors, x)
    ground = samples.made_of.ground
    basis, pivots = _basis(samples, table, width)
    vectors = tuple(tuple(ground.restore(entry) for entry in vector) for vector in basis)
    complete = not check
    if check:
        upper = width - rank_in_numbers(V, x, table, width)
        if upper > len(vectors) and not ground.parameters:
            vectors = reconstructed_kernel(V, x, table, width) or vectors
        complete = upper == len(vectors)
    restored = tuple(p.xreplace({d: c for c, d in ground.opaque.items()}) for p in pivots)
    return Kernel(vectors, complete, restored)


def _basis(samples: Samples, table: EquationTable, width: int) -> tuple[Rows, tuple[sp.Expr, ...]]:
    """Return a basis of the kernel in reduced echelon form, and the pivots of the elimination where they are asked for.

    Letters that occur as polynomials are eliminated over their ring, which tells at which values the rank drops; others
    are given values modulo a prime first.
    """
    ground = samples.made_of.ground
    stream = equations_at_points(samples, table, width)
    if ground.parameters:
        sparse = polynomial_span(stream, ground, width) if letters_are_polynomial(samples) else None
        if sparse is not None:
            echelon, pivots = echelon_over_ring(sparse, ground.field)
            return nullspace(echelon, width, ground.field), pivots
        found = kernel_in_letters(samples, table, width) if ground.numbers.is_QQ else None
        if found is not None:
            return found, ()
    return nullspace(dense_echelon(stream)[0], width, ground.field), ()


def dimension_by_numbers(V: sp.Expr, x: Sequence[sp.Symbol], tensors: Sequence[sp.ImmutableMatrix]) -> int:
    """Upper bound of the dimension of the kernel, from 60-digit numbers.

    Args:
        V: potential V(x).
        x: Cartesian coordinates, two or three.
        tensors: K of which linear combinations are sought, shape (n, n) each.
    """
    return len(tensors) - rank_in_numbers(V, tuple(x), _coefficients(tuple(tensors), tuple(x)), len(tensors))
