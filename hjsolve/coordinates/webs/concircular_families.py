"""Linear families of concircular tensors, cut into strata.

A concircular tensor L = A + w⊙x + m x⊗x is the symmetric matrix M = [[A, w], [wᵀ, m]]; adding a multiple of the
metric, J = diag(1, …, 1, 0), does not change the web. A linear family therefore splits into the central tensors
(m = 1), the axial ones (m = 0, w ≠ 0) and the constant ones (m = 0, w = 0).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Generic, TypeVar

import sympy as sp

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.killing_tensors import concircular_basis
from hjsolve.coordinates.webs.orthonormal_frames import TooHardError

Member = TypeVar("Member")


@dataclass(frozen=True)
class Family:
    """A linear family of concircular tensors modulo the metric.

    Attributes:
        n: dimension of the space.
        central: an element with m = 1, or None.
        axial: elements with m = 0 whose w are independent.
        constant: elements with m = 0, w = 0, modulo J.
    """

    n: int
    central: sp.ImmutableMatrix | None
    axial: tuple[sp.ImmutableMatrix, ...]
    constant: tuple[sp.ImmutableMatrix, ...]

    @property
    def dimension(self) -> int:
        """Dimension of the family, the metric included."""
        return 1 + (self.central is not None) + len(self.axial) + len(self.constant)


def family(vectors: Sequence[Sequence[sp.Expr]], n: int) -> Family:
    """Sort a kernel by strata: reduced echelon form with the columns in the order m, w, A modulo J.

    Args:
        vectors: a basis of the kernel, in coordinates of ``concircular_basis``.
        n: dimension.
    """
    basis = concircular_basis(n)
    matrices = [sum((c * E for c, E in zip(v, basis, strict=True)), sp.zeros(n + 1, n + 1)) for v in vectors]
    rows = sp.Matrix([_flatten(M, n) for M in matrices])
    reduced = rows.rref(simplify=True)[0] if rows.rows else rows
    central, axial, constant = None, [], []
    for index in range(reduced.rows):
        row = reduced.row(index)
        pivot = next((c for c, entry in enumerate(row) if entry != 0), None)
        if pivot is None:
            continue
        M = _unflatten(list(row), n)
        if pivot == 0:
            central = M
        elif pivot <= n:
            axial.append(M)
        else:
            constant.append(M)
    return Family(n, central, tuple(axial), tuple(constant))


def _flatten(M: sp.MatrixBase, n: int) -> list[sp.Expr]:
    """Return m, w, A_ii − A_nn (which does not see multiples of the metric) and the off-diagonal of A."""
    off = [M[i, j] for i in range(n) for j in range(i + 1, n)]
    return [M[n, n], *(M[i, n] for i in range(n)), *(M[i, i] - M[n - 1, n - 1] for i in range(n - 1)), *off]


def _unflatten(row: list[sp.Expr], n: int) -> sp.ImmutableMatrix:
    M = sp.zeros(n + 1, n + 1)
    entries = iter(row)
    M[n, n] = next(entries)
    for i in range(n):
        M[i, n] = M[n, i] = next(entries)
    for i in range(n - 1):
        M[i, i] = next(entries)
    for i in range(n):
        for j in range(i + 1, n):
            M[i, j] = M[j, i] = next(entries)
    return sp.ImmutableMatrix(M)


def combination(
    base: sp.MatrixBase | None, terms: Sequence[sp.MatrixBase], numbers: Sequence[sp.Expr], n: int
) -> sp.Matrix:
    """Return base + Σ number·term.

    Args:
        base: shape (n + 1, n + 1); None for zero.
        terms: of the same shape.
        numbers: as many as there are terms.
        n: dimension.
    """
    total = sp.zeros(n + 1, n + 1) if base is None else sp.Matrix(base)
    for number, term in zip(numbers, terms, strict=True):
        total += number * term
    return total


def tensor_parts(M: sp.MatrixBase) -> tuple[sp.Matrix, sp.Matrix, sp.Expr]:
    """Return A, w, m.

    Args:
        M: [[A, w], [wᵀ, m]], shape (n + 1, n + 1).
    """
    n = M.rows - 1
    return sp.Matrix(M[:n, :n]), sp.Matrix(M[:n, n]), M[n, n]


def small_values(count: int, most: int = 700) -> Iterator[tuple[sp.Expr, ...]]:
    """Yield tuples of small numbers, the simplest first.

    Args:
        count: length of the tuples.
        most: how many tuples at most.
    """
    digits = (0, 1, -1, 2, -2, 3) if count <= 3 else (0, 1, -1, 2)
    tuples = sorted(product(digits, repeat=count), key=lambda t: (sum(map(abs, t)), tuple(-v for v in t)))
    yield from (tuple(map(sp.Integer, t)) for t in islice(tuples, most))


_COMPARED = 10
"""Members of a kind that are compared where none of them is simple."""


@dataclass(frozen=True)
class FamilyMember(Generic[Member]):
    """A member of a family and the parameter values it was found at."""

    member: Member
    values: tuple[sp.Expr, ...]


def representatives(
    choices: Callable[[tuple[sp.Expr, ...]], Member | None],
    count: int,
    kind: Callable[[Member], str],
    cost: Callable[[Member], int],
) -> dict[str, FamilyMember[Member]]:
    """Sample a family at small parameter values and keep the simplest member of each kind.

    Args:
        choices: member at given values, or None where it does not exist.
        count: number of parameters.
        kind: kind of a member.
        cost: simplicity; the smaller the better, below 10 good enough (rational constants only). Else ten are compared.

    Raises:
        TooHardError: no member was found, and some were too hard to compute.
    """
    best: dict[str, FamilyMember[Member]] = {}
    seen: dict[str, int] = {}
    hard = False
    for values in islice(small_values(count), 90):
        check_time()
        try:
            member = choices(values)
        except TooHardError:
            hard = True
            continue
        if member is None:
            continue
        name = kind(member)
        seen[name] = seen.get(name, 0) + 1
        if name not in best or cost(member) < cost(best[name].member):
            best[name] = FamilyMember(member, values)
        if best and all(seen[name] >= _COMPARED or cost(best[name].member) < 10 for name in best):
            break
    if hard and not best:
        raise TooHardError
    return best


def simplest_members(
    choices: Callable[[tuple[sp.Expr, ...]], Member | None],
    count: int,
    kind: Callable[[Member], str],
    cost: Callable[[Member], int],
    in_numbers: Callable[[tuple[sp.Expr, ...]], Member | None] | None,
) -> dict[str, FamilyMember[Member]]:
    """Return the simplest member of a family of one kind, of one with letters that which is simplest at their values.

    Args:
        choices, count, kind, cost: as for ``representatives``.
        in_numbers: the member at values of the letters; None where there are no letters.

    Raises:
        TooHardError: no member was found, and some were too hard to compute.
    """
    if in_numbers is not None:
        for name, found in representatives(in_numbers, count, kind, cost).items():
            member = choices(found.values)
            if member is not None and kind(member) == name:
                return {name: FamilyMember(member, found.values)}
    return representatives(choices, count, kind, cost)
