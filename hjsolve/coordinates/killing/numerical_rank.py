"""The rank of d(K·dV) = 0 counted by 60-digit numbers, independently of the exact elimination.

An exact solution cannot be wrong, but radicals that depend on each other (√(r+x) √(r−x) = |y|) could hide one. The
numerical rank bounds the dimension of the kernel from above; where the two meet, the kernel is complete.

V(x) is the potential, ``table`` holds the equations, as terms in the derivatives of V, for each tensor, ``width`` is
how many tensors there are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from random import Random

import mpmath
import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.algebra.shared_parts import common_parts, derivatives
from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.killing.constant_field import EquationTable
from hjsolve.precision import NAMES, mp


def _concrete(V: sp.Expr) -> sp.Expr:
    """Replace undetermined functions by some definite ones; the rank can only get smaller."""
    names = sorted({node.func.__name__ for node in V.atoms(AppliedUndef)})
    return V.replace(
        lambda node: isinstance(node, AppliedUndef),
        lambda node: (
            sum(
                sp.exp(a / sp.Integer(7 + 2 * names.index(node.func.__name__) + 4 * i)) for i, a in enumerate(node.args)
            )
            + sp.prod(node.args) ** 3
        ),
    )


def _numerical_rows(V: sp.Expr, x: Sequence[sp.Symbol], table: EquationTable, width: int) -> list[list[mpmath.mpf]]:
    """Return equations at random real points, 60 digits, with random positive values of the parameters."""
    V = _concrete(V)
    random = Random(7)  # noqa: S311
    parameters = sorted(V.free_symbols - set(x), key=str)
    values = {p: sp.Rational(random.randint(3, 90), 37) * (-1 if p.is_negative else 1) for p in parameters}
    named, left = common_parts([d.xreplace(values) for d in derivatives(V, tuple(x))])
    functions = sp.lambdify(list(x), left, NAMES, cse=lambda _: (named, left))
    rows: list[list[mpmath.mpf]] = []
    while len(rows) < width + 8:
        check_time()
        point = [mp.mpf(random.randint(-99, 99) * 2 + 1) / 83 for _ in x]
        try:
            slots = functions(*point)
        except (ZeroDivisionError, ValueError):
            continue
        rows.extend([_coefficient(tensor, slots, point) for tensor in equation] for equation in table)
    return rows


def _coefficient(
    tensor: Iterable[tuple[int, list[tuple[tuple[int, ...], sp.Rational]]]], slots: Sequence[mpmath.mpf],
    point: Sequence[mpmath.mpf],
) -> mpmath.mpf:  # fmt: skip
    """Return the coefficient of one tensor in an equation at a point."""
    total = mp.mpf(0)
    for slot, terms in tensor:
        for exponents, c in terms:
            monomial = mp.fprod(q**e for q, e in zip(point, exponents, strict=True))
            total += slots[slot] * monomial * int(c.p) / int(c.q)
    return total


def _numerical_echelon(rows: list[list[mpmath.mpf]], width: int) -> tuple[list[list[mpmath.mpf]], list[int]]:
    """Reduce with full pivoting; entries below 10⁻²⁵ of their row are zero."""
    rows = [[entry / scale for entry in row] for row in rows if (scale := max(abs(e) for e in row))]
    pivots: list[int] = []
    while len(pivots) < width:
        check_time()
        rest = rows[len(pivots) :]
        size, r, c = max(
            ((abs(row[c]), r, c) for r, row in enumerate(rest) for c in range(width) if c not in pivots),
            default=(0, 0, 0),
        )
        if size < mp.mpf(10) ** -25:
            break
        k = len(pivots)
        rows[k], rows[r + k] = rows[r + k], rows[k]
        rows[k] = [entry / rows[k][c] for entry in rows[k]]
        rows = [
            row if i == k else [a - row[c] * b for a, b in zip(row, rows[k], strict=True)] for i, row in enumerate(rows)
        ]
        pivots.append(c)
    return rows[: len(pivots)], pivots


def rank_in_numbers(V: sp.Expr, x: Sequence[sp.Symbol], table: EquationTable, width: int) -> int:
    """Return the rank of d(K·dV) = 0 found by 60-digit numbers; it bounds the dimension of the kernel from above."""
    with mp.workdps(60):
        return len(_numerical_echelon(_numerical_rows(V, x, table, width), width)[1])


def reconstructed_kernel(
    V: sp.Expr, x: Sequence[sp.Symbol], table: EquationTable, width: int
) -> tuple[tuple[sp.Expr, ...], ...] | None:
    """Recover the kernel from numbers where the radicals of V depend on each other; None unless it verifies."""
    with mp.workdps(60):
        rows, pivots = _numerical_echelon(_numerical_rows(V, x, table, width), width)
        free = [c for c in range(width) if c not in pivots]
        vectors = []
        for column in free:
            vector = [sp.S.Zero] * width
            vector[column] = sp.S.One
            for row, pivot in zip(rows, pivots, strict=True):
                vector[pivot] = -_rational(row[column])
            vectors.append(vector)
        residual = max(
            (
                abs(mp.fsum(a * mp.mpf(int(b.p)) / int(b.q) for a, b in zip(row, v, strict=True)))
                for row in _numerical_rows(V, x, table, width)
                for v in vectors
            ),
            default=1,
        )
    if residual > mp.mpf(10) ** -20:
        return None
    return tuple(tuple(row) for row in sp.Matrix(vectors).rref()[0].tolist())


def _rational(number: mpmath.mpf) -> sp.Rational:
    """Return the simplest rational number within 10⁻²⁵ of a real number."""
    return sp.nsimplify(sp.Float(str(mp.re(number)), 40), rational=True, tolerance=sp.Float("1e-25", 30))
