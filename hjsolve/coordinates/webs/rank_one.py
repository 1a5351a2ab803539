"""Tensors with two equal eigenvalues in a linear family of symmetric matrices.

A symmetric 3×3 matrix has two equal eigenvalues when it is λ ± v⊗v. In the span of some forms and of the metric there
is such a matrix exactly when every functional φ that vanishes on the span vanishes on v⊗v: a few quadratic equations
for the three components of v, however large the family.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.coordinates.webs.concircular_families import small_values
from hjsolve.coordinates.webs.orthonormal_frames import unit
from hjsolve.coordinates.webs.piecewise_conditions import SolutionPiece, real_pieces
from hjsolve.coordinates.webs.web import Vector

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
V = sp.symbols("v0:3", real=True)


def annihilators(forms: Sequence[sp.MatrixBase]) -> list[sp.Matrix]:
    """Return symmetric φ with tr(φ F) = 0 for every form F and for the metric; shape (3, 3) each.

    Args:
        forms: symmetric F, shape (3, 3) each.
    """
    rows = [[F[i, j] * (1 if i == j else 2) for i, j in PAIRS] for F in (*forms, sp.eye(3))]
    result = []
    for vector in sp.Matrix(rows).nullspace(simplify=True):
        φ = sp.zeros(3, 3)
        for (i, j), c in zip(PAIRS, vector, strict=True):
            φ[i, j] = φ[j, i] = c
        result.append(φ)
    return result


def trace_product(φ: sp.MatrixBase, F: sp.MatrixBase) -> sp.Expr:
    """Return tr(φ F).

    Args:
        φ: a square matrix.
        F: one of the same size.
    """
    return sp.expand((φ * F).trace())


def directions(forms: Sequence[sp.MatrixBase]) -> list[SolutionPiece]:
    """Return the pieces of {v : v⊗v in the span of the forms and the metric}; v = 0 is left out.

    Args:
        forms: symmetric F, shape (3, 3) each.
    """
    v = sp.Matrix(V)
    pieces = real_pieces([trace_product(φ, v * v.T) for φ in annihilators(forms)], V)
    return [piece for piece in pieces if piece.free]


def members(piece: SolutionPiece, most: int) -> list[Vector]:
    """Return the simplest unit vectors of a piece, at most so many, no two parallel.

    Args:
        piece: a set of directions v.
        most: how many vectors at most.
    """
    found: list[Vector] = []
    for values in small_values(len(piece.free)):
        v = direction(piece, values)
        if v is not None and v not in found:
            found.append(v)
        if len(found) == (1 if len(piece.free) == 1 else most):
            break
    return found


def direction(piece: SolutionPiece, values: Sequence[sp.Expr]) -> Vector | None:
    """Return the unit vector of a piece at given values of its free unknowns; None where there is none.

    Args:
        piece: a set of directions v.
        values: of its free unknowns, in their order.
    """
    place = dict(zip(piece.free, values, strict=True))
    v = [piece.values[u].subs(place) for u in V]
    if any(c.has(sp.zoo, sp.nan, sp.oo) for c in v) or not any(v):
        return None
    return unit(v)
