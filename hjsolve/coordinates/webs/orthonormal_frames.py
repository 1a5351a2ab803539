"""Exact orthonormal frames: eigenvectors of symmetric matrices, square roots without a sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import sympy as sp

from hjsolve.algebra.time_limit import check_time
from hjsolve.coordinates.webs.web import Geometry, Vector


@dataclass(frozen=True)
class Sign:
    """Tells the sign of a constant, where assumptions do not by the values of the parameters.

    Attributes:
        values: parameter → default value; parameters that have none count as 2, 3, 5, … in alphabetical order.
    """

    values: Mapping[sp.Symbol, sp.Expr]

    def __call__(self, constant: sp.Expr) -> int:
        """Return −1, 0 or 1.

        Args:
            constant: without coordinates.
        """
        if constant.is_zero or constant.is_positive or constant.is_negative:
            return 0 if constant.is_zero else 1 if constant.is_positive else -1
        number = constant.xreplace(self._numbers(constant)).evalf(30)
        return 0 if abs(number) < sp.Float("1e-20") else 1 if number > 0 else -1

    def in_numbers(self, matrix: sp.MatrixBase) -> sp.MatrixBase:
        """Return a matrix with the values of its parameters."""
        return matrix.xreplace(self._numbers(matrix))

    def _numbers(self, holder: sp.Expr | sp.MatrixBase) -> dict[sp.Symbol, sp.Expr]:
        missing = sorted(holder.free_symbols - set(self.values), key=str)
        chosen = {s: sp.prime(i + 1) * (-1 if s.is_negative else 1) for i, s in enumerate(missing)}
        return {**self.values, **chosen}


class TooHardError(ArithmeticError):
    """An exact frame would need the roots of an irreducible cubic, or a search has too many branches."""


def tidy_constant(expression: sp.Expr) -> sp.Expr:
    """Bring a constant to a short form: rational denominators, no nested radicals where they can be undone.

    Args:
        expression: without coordinates.
    """
    if expression.is_Rational or expression.is_Symbol:
        return expression
    check_time()
    if not any(p.exp.is_Rational and not p.exp.is_Integer for p in expression.atoms(sp.Pow)):
        return sp.expand(expression) if expression.is_number else sp.factor(expression)
    if expression.is_Mul and expression.free_symbols:
        number, rest = expression.as_independent(*expression.free_symbols, as_Add=False)
        if number != 1 and rest.atoms(sp.Pow) != expression.atoms(sp.Pow):
            return tidy_constant(number) * tidy_constant(rest)
    if expression.is_number:
        return sp.sqrtdenest(sp.radsimp(sp.expand(expression)))
    return sp.radsimp(sp.factor(sp.sqrtdenest(expression)))


def real_root(square: sp.Expr) -> sp.Expr:
    """Return a square root of a non-negative quantity; its sign is of no importance, so |c| is written c."""
    value = tidy_constant(sp.sqrt(sp.factor(square)))
    return value.replace(sp.Abs, lambda u: u)


def norm_squared(v: Sequence[sp.Expr]) -> sp.Expr:
    """Return v·v.

    Args:
        v: Cartesian components.
    """
    return sp.factor(sp.Add(*(c**2 for c in v)))


def unit(v: Sequence[sp.Expr]) -> Vector:
    """Return v/|v|, with the first component that is not zero positive where its sign is known.

    A symbolic vector is divided by its first component before, so that ratios of components stay short, and quotients
    of polynomials are made polynomials: (a − c, b − d), whose length is the distance of (a, b) and (c, d).

    Args:
        v: not zero; shape (n,).
    """
    entries = [tidy_constant(c) for c in v]
    lead = next(c for c in entries if c != 0)
    if any(c.free_symbols for c in entries):
        check_time()
        entries = [sp.S.Zero if c == 0 else sp.S.One if c == lead else sp.radsimp(sp.cancel(c / lead)) for c in entries]
        if all(c.is_rational_function() for c in entries):
            common = reduce(sp.lcm, (sp.denom(sp.together(c)) for c in entries))
            check_time()
            entries = [sp.factor(sp.cancel(c * common)) for c in entries]
        length = real_root(sp.simplify(norm_squared(entries)))
        return tuple(c / length for c in entries)
    length = sp.sqrt(norm_squared(entries))
    sign = -1 if lead.is_negative else 1
    return tuple(tidy_constant(sign * c / length) for c in entries)


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b.

    Args:
        a, b: Cartesian components.
    """
    (a1, a2, a3), (b1, b2, b3) = a, b
    return tidy_constant(a2 * b3 - a3 * b2), tidy_constant(a3 * b1 - a1 * b3), tidy_constant(a1 * b2 - a2 * b1)


def scalar_product(a: Sequence[sp.Expr], b: Sequence[sp.Expr]) -> sp.Expr:
    """Return a·b.

    Args:
        a, b: Cartesian components, equally many.
    """
    return sp.expand(sp.Add(*(p * q for p, q in zip(a, b, strict=True))))


def stepped(origin: Vector, terms: Sequence[tuple[sp.Expr, Vector]]) -> Vector:
    """Return origin + Σ length·direction.

    Args:
        origin: where to begin, shape (n,).
        terms: (length, direction) of each step.
    """
    return tuple(tidy_constant(c + sp.Add(*(length * v[i] for length, v in terms))) for i, c in enumerate(origin))


def attempt(search: Callable[[], list[Geometry]]) -> list[Geometry]:
    """Return what a search finds; where it is too hard, one geometry of kind ``unresolved`` says so."""
    try:
        return search()
    except TooHardError:
        return [Geometry("unresolved", (), ())]


def perpendicular_frame(axis: Vector) -> tuple[Vector, Vector, Vector]:
    """Return (e₁, e₂, axis), right-handed and orthonormal; e₁ is as simple as possible.

    Args:
        axis: unit vector in space.
    """
    candidates = [tuple(sp.Integer(int(i == j)) for j in range(3)) for i in range(3)]
    first = next((c for c in candidates if scalar_product(c, axis) == 0), None) or unit(
        (axis[1], -axis[0], sp.S.Zero) if axis[0] != 0 else (sp.S.Zero, axis[2], -axis[1])
    )
    return first, cross(axis, first), axis


def eigenframe(A: sp.MatrixBase) -> list[tuple[sp.Expr, Vector]]:
    """Return (eigenvalue, unit eigenvector) of a real symmetric matrix, exact; equal eigenvalues side by side.

    Args:
        A: shape (2, 2) or (3, 3).

    Raises:
        TooHardError: the characteristic polynomial is an irreducible cubic.
    """
    n = A.rows
    A = sp.Matrix(A).applyfunc(sp.expand)
    if A.is_diagonal():
        pairs = [(A[i, i], tuple(sp.Integer(int(i == j)) for j in range(n))) for i in range(n)]
        return sorted(pairs, key=lambda pair: [p[0] for p in pairs].index(pair[0]))
    result: list[tuple[sp.Expr, Vector]] = []
    for value, multiplicity in _eigenvalues(A):
        space = _nullspace(A, value, multiplicity)
        basis: list[Vector] = []
        for v in space:
            rest = sp.Matrix(v)
            for e in basis:
                rest -= sp.Matrix(e) * scalar_product(v, e)
            basis.append(unit(tuple(rest)))
        result.extend((value, e) for e in basis)
    return result


def _eigenvalues(A: sp.Matrix) -> list[tuple[sp.Expr, int]]:
    s = sp.Symbol("s", real=True)
    numbers = sorted((a for a in A.atoms(sp.Pow) if a.is_number and not a.exp.is_Integer), key=str)
    options = {"extension": numbers} if numbers else {}
    polynomial = sp.factor_list(A.charpoly(s).as_expr(s), s, **options)[1]
    values: list[tuple[sp.Expr, int]] = []
    for factor, multiplicity in polynomial:
        degree = sp.degree(factor, s)
        if degree <= 2:
            values.extend(
                (tidy_constant(r), multiplicity) for r in sorted(sp.roots(factor, s), key=sp.default_sort_key)
            )
        else:
            raise TooHardError
    return values


def _nullspace(A: sp.Matrix, value: sp.Expr, multiplicity: int) -> list[Vector]:
    n = A.rows
    B = (A - value * sp.eye(n)).applyfunc(tidy_constant)
    if n - multiplicity == 1:
        row = next(B.row(i) for i in range(n) if any(sp.simplify(c) != 0 for c in B.row(i)))
        lead = next(i for i, c in enumerate(row) if sp.simplify(c) != 0)
        space = []
        for free in (i for i in range(n) if i != lead):
            entry = {free: sp.S.One, lead: tidy_constant(-row[free] / row[lead])}
            space.append(tuple(entry.get(i, sp.S.Zero) for i in range(n)))
        return space
    for i in range(n):
        for j in range(i + 1, n):
            v = tuple(tidy_constant(c) for c in B.row(i).cross(B.row(j)))
            if any(sp.simplify(c) != 0 for c in v):
                return [v]
    raise TooHardError


def sort_frame(frame: list[tuple[sp.Expr, Vector]], sign: Sign) -> list[tuple[sp.Expr, Vector]]:
    """Sort (eigenvalue, vector) pairs from small to large eigenvalues; equal ones keep their order.

    Args:
        frame: as ``eigenframe`` gives it.
        sign: tells the sign of a constant.
    """
    ordered: list[tuple[sp.Expr, Vector]] = []
    for value, axis in frame:
        place = sum(1 for other, _ in ordered if sign(sp.expand(other - value)) <= 0)
        ordered.insert(place, (value, axis))
    return ordered


def righted(e1: Vector, e2: Vector) -> tuple[Vector, Vector, Vector]:
    """Return the right-handed frame (e₁, e₂, e₁ × e₂).

    Args:
        e1, e2: orthonormal, in space.
    """
    return e1, e2, cross(e1, e2)
