"""The kinetic energy as a quadratic form: mass matrix, linear terms, rest, and the inverse in readable squares.

T = ½ Σ m_ij(q) q̇_i q̇_j + Σ a_i(q) q̇_i + T₀(q)                                      Greenwood (2-5)–(2-10)

In what follows ``kinetic`` is T(q, q̇), and ``velocities`` are the symbols q̇, shape (n,).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from hjsolve.algebra.factoring import factored
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.tokens import printable

_MAX_TERMS = 300
_MAX_TIDY = 60
_MAX_EXPONENT = 12


def check_quadratic(kinetic: sp.Expr, velocities: Sequence[sp.Symbol]) -> sp.Expr:
    """Return T once it is a polynomial of degree two at most in the velocities.

    Raises:
        InvalidSystemError: it is not, or a velocity does not occur.
    """
    symbols = frozenset(velocities)
    if 2 < degree(kinetic, symbols) <= 4 and _terms(kinetic) <= 10 * _MAX_TERMS:
        kinetic = sp.expand(kinetic)
    if degree(kinetic, symbols) > 2:
        term = max(sp.Add.make_args(kinetic), key=lambda term: degree(term, symbols))
        raise InvalidSystemError(
            f"kinetic: {printable(str(term))[:60]} is not quadratic in the velocities; "
            "T must be a polynomial of second degree in dot(q), with coefficients that depend on the coordinates"
        )
    missing = [velocity.name for velocity in velocities if velocity not in kinetic.free_symbols]
    if missing:
        raise InvalidSystemError(
            f"kinetic: {', '.join(missing)} does not occur in T; a coordinate without inertia must be eliminated first"
        )
    return kinetic


def degree(expression: sp.Expr, symbols: frozenset[sp.Symbol]) -> float:
    """Upper bound of the degree in the symbols, read off the structure; infinite where not a polynomial.

    Args:
        symbols: those the degree counts.
    """
    if not expression.free_symbols & symbols:
        return 0
    if expression.is_Symbol:
        return 1
    if expression.is_Add:
        return max(degree(term, symbols) for term in expression.args)
    if expression.is_Mul:
        return sum(degree(factor, symbols) for factor in expression.args)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return int(expression.exp) * degree(expression.base, symbols)
    return math.inf


Parts = dict[tuple[int, ...], sp.Expr]


def mass_entries(kinetic: sp.Expr, velocities: Sequence[sp.Symbol]) -> sp.ImmutableMatrix:
    """m_ij = ∂²T/∂q̇_i∂q̇_j, shape (n, n), in readable entries."""
    return mass_as_written(kinetic, velocities).applyfunc(tidy)


def mass_as_written(kinetic: sp.Expr, velocities: Sequence[sp.Symbol]) -> sp.ImmutableMatrix:
    """m_ij = ∂²T/∂q̇_i∂q̇_j, shape (n, n), as it falls out of T."""
    found = velocity_coefficients(kinetic, velocities)

    def entry(i: int, j: int) -> sp.Expr:
        return found.get((min(i, j), max(i, j)), sp.S.Zero) * (2 if i == j else 1)

    return sp.ImmutableMatrix(len(velocities), len(velocities), entry)


def velocity_coefficients(kinetic: sp.Expr, velocities: Sequence[sp.Symbol]) -> Parts:
    """Return the coefficients of T as a polynomial in the velocities, by their positions: (), (i,), (i, j) with i ≤ j.

    Read off the structure; what holds no velocity is neither differentiated nor expanded.
    """
    return _parts(kinetic, {velocity: i for i, velocity in enumerate(velocities)})


def _parts(x: sp.Expr, places: Mapping[sp.Symbol, int]) -> Parts:
    if x in places:
        return {(places[x],): sp.S.One}
    if x.free_symbols.isdisjoint(places):
        return {(): x}
    if x.is_Add:
        return _sum([_parts(a, places) for a in x.args])
    if x.is_Mul:
        found: Parts = {(): sp.Mul(*(a for a in x.args if a.free_symbols.isdisjoint(places)))}
        for a in x.args:
            if not a.free_symbols.isdisjoint(places):
                found = _product(found, _parts(a, places))
        return found
    base = _parts(x.base, places)
    found = base
    for _ in range(int(x.exp) - 1):
        found = _product(found, base)
    return found


def _sum(several: Sequence[Parts]) -> Parts:
    gathered: dict[tuple[int, ...], list[sp.Expr]] = {}
    for found in several:
        for key, coefficient in found.items():
            gathered.setdefault(key, []).append(coefficient)
    return {key: sp.Add(*terms) for key, terms in gathered.items()}


def _product(a: Parts, b: Parts) -> Parts:
    return _sum([{tuple(sorted(i + j)): x * y} for i, x in a.items() for j, y in b.items()])


def blocks(matrix: sp.ImmutableMatrix) -> list[list[int]]:
    """Return the index sets that a symmetric matrix couples, each in increasing order.

    Args:
        matrix: symmetric, shape (n, n).
    """
    found: list[list[int]] = []
    for i in range(matrix.rows):
        joined = [block for block in found if any(matrix[i, j] != 0 for j in block)]
        found = [block for block in found if block not in joined]
        found.append(sorted({i, *(j for block in joined for j in block)}))
    return sorted(found)


@dataclass(frozen=True)
class SumOfSquares:
    """½ xᵀM⁻¹x of one block as a sum of squares: ½ Σ_k (rows[k]·x)²/pivots[k], from M = L D Lᵀ and rows = L⁻¹."""

    indices: tuple[int, ...]
    rows: tuple[tuple[sp.Expr, ...], ...]
    pivots: tuple[sp.Expr, ...]


def squares(matrix: sp.ImmutableMatrix, block: Sequence[int]) -> SumOfSquares | None:
    """Complete the squares of a block, the simplest pivot first; None where every pivot left is zero.

    Args:
        matrix: symmetric, shape (n, n).
        block: indices of the rows and columns to take, one of ``blocks``.
    """
    left = list(block)
    n = len(left)
    remaining = {(i, j): matrix[i, j] for i in block for j in block}
    unit = {i: [sp.S.One if i == j else sp.S.Zero for j in block] for i in block}
    rows, pivots = [], []
    while left:
        usable = [i for i in left if remaining[i, i] != 0]
        if not usable:
            return None
        k = min(usable, key=lambda i: (sp.count_ops(remaining[i, i]), left.index(i)))
        left.remove(k)
        pivot = remaining[k, k]
        rows.append(tuple(unit[k]))
        pivots.append(pivot)
        for i in left:
            ratio = tidy(remaining[i, k] / pivot)
            unit[i] = [tidy(unit[i][j] - ratio * unit[k][j]) for j in range(n)]
            for j in left:
                if i <= j:
                    remaining[i, j] = remaining[j, i] = tidy(remaining[i, j] - ratio * remaining[k, j])
    return SumOfSquares(tuple(block), tuple(rows), tuple(pivots))


def inverse_of_mass_matrix(matrix: sp.ImmutableMatrix) -> sp.ImmutableMatrix:
    """M⁻¹, block by block, in readable entries.

    Args:
        matrix: M, symmetric and regular, shape (n, n).
    """
    result = sp.zeros(matrix.rows, matrix.rows)
    for block in blocks(matrix):
        completed = squares(matrix, block)
        part = _adjugate_inverse(matrix, block) if completed is None else _from_squares(completed)
        for i, a in enumerate(block):
            for j, b in enumerate(block):
                result[a, b] = part[i, j]
    return sp.ImmutableMatrix(result)


def _from_squares(completed: SumOfSquares) -> sp.Matrix:
    n = len(completed.indices)
    terms = list(zip(completed.rows, completed.pivots))
    return sp.Matrix(n, n, lambda i, j: sp.Add(*(row[i] * row[j] * short_reciprocal(pivot) for row, pivot in terms)))


def _adjugate_inverse(matrix: sp.ImmutableMatrix, block: Sequence[int]) -> sp.Matrix:
    part = matrix.extract(list(block), list(block))
    return (part.adjugate() / part.det(method="berkowitz")).applyfunc(tidy)


def half_inverse_form(matrix: sp.ImmutableMatrix, vector: Sequence[sp.Expr]) -> sp.Expr:
    """½ xᵀM⁻¹x as a sum of squares wherever a block has pivots.

    Args:
        matrix: M, symmetric and regular, shape (n, n).
        vector: x, shape (n,).
    """
    terms = []
    for block in blocks(matrix):
        completed = squares(matrix, block)
        if completed is None:
            part = _adjugate_inverse(matrix, block)
            x = sp.Matrix([vector[i] for i in block])
            terms.append((x.T * part * x)[0, 0] / 2)
            continue
        for row, pivot in zip(completed.rows, completed.pivots):
            terms.append(sp.Add(*(c * vector[i] for c, i in zip(row, block))) ** 2 * short_reciprocal(pivot) / 2)
    return sp.Add(*terms)


def short_reciprocal(expression: sp.Expr) -> sp.Expr:
    """1/expression, without a fraction in the denominator where that is shorter."""
    return _shortest([1 / expression, 1 / sp.together(expression)])


@lru_cache(maxsize=1024)
def tidy(expression: sp.Expr) -> sp.Expr:
    """Return the shortest of a few equal forms: as it is, factored, and with sin² + cos² = 1 used either way.

    Args:
        expression: any formula in coordinates and parameters.
    """
    if not expression.has(sp.Add) or _terms(expression) > _MAX_TIDY or any(map(_is_hard, expression.atoms(sp.Pow))):
        return expression
    if expression.is_Mul and not any(map(_may_shorten, expression.atoms(sp.Add))):
        return expression
    together = sp.together(expression)
    numerator, denominator = together.as_numer_denom()
    candidates = [expression, _shortest(_forms(numerator)) / _shortest(_forms(denominator))]
    return _shortest(candidates)


def _may_shorten(total: sp.Add) -> bool:
    """Whether sin² + cos² = 1 or an angle difference could shorten a sum: squares or products of sines and cosines."""
    return any(
        sum(f.as_base_exp()[1] for f in sp.Mul.make_args(term) if isinstance(f.as_base_exp()[0], (sp.sin, sp.cos))) >= 2
        for term in total.args
    )


def _is_hard(power: sp.Pow) -> bool:
    """Return whether a power makes factoring slow: a high one, or one that is neither whole nor half."""
    return not (power.exp.is_Rational and abs(power.exp) <= _MAX_EXPONENT and power.exp.q <= 2)


def _terms(expression: sp.Expr) -> int:
    """Upper bound of the number of terms of an expression when expanded."""
    if expression.is_Add:
        return sum(map(_terms, expression.args))
    if expression.is_Mul:
        return math.prod(map(_terms, expression.args))
    if expression.is_Pow and expression.exp.is_Integer:
        terms, exponent = _terms(expression.base), abs(int(expression.exp))
        return math.comb(terms + exponent - 1, exponent) if terms <= _MAX_TERMS else terms
    return 1


def _forms(polynomial: sp.Expr) -> list[sp.Expr]:
    if not polynomial.is_Add and not polynomial.has(sp.Add):
        return [polynomial]
    return [polynomial, *(factored(sp.expand(form)) for form in _pythagoras(sp.expand(polynomial)))]


def _pythagoras(expanded: sp.Expr) -> list[sp.Expr]:
    """Return the expanded expression with angle differences joined, even powers of cos, or of sin, eliminated."""
    if not expanded.has(sp.sin, sp.cos):
        return [expanded]
    expanded = sp.expand(_joined(expanded))
    return [expanded, *(expanded.replace(sp.Pow, lambda b, e, f=f: _other(b, e, f)) for f in (sp.cos, sp.sin))]


def _other(base: sp.Expr, exponent: sp.Expr, eliminated: type[sp.Function]) -> sp.Expr:
    if not (isinstance(base, eliminated) and exponent.is_Integer and exponent >= 2):
        return sp.Pow(base, exponent)
    partner = sp.sin if eliminated is sp.cos else sp.cos
    half, odd = divmod(int(exponent), 2)
    return (1 - partner(base.args[0]) ** 2) ** half * base**odd


def _joined(expanded: sp.Expr) -> sp.Expr:
    """Return the sum with k cos a cos b ± k sin a sin b written as k cos(a ∓ b)."""
    terms = dict(expanded.as_coefficients_dict())
    for term, weight in list(terms.items()):
        angles = [factor.args[0] for factor in sp.Mul.make_args(term) if isinstance(factor, sp.cos)]
        for a, b in itertools.combinations(angles, 2):
            partner = term / (sp.cos(a) * sp.cos(b)) * sp.sin(a) * sp.sin(b)
            other = terms.get(partner, 0)
            if term in terms and abs(other) == abs(weight):
                del terms[term], terms[partner]
                joined = term / (sp.cos(a) * sp.cos(b)) * sp.cos(a - b if other == weight else a + b)
                terms[joined] = terms.get(joined, 0) + weight
    return sp.Add(*(weight * term for term, weight in terms.items()))


def _shortest(candidates: Sequence[sp.Expr]) -> sp.Expr:
    return min(candidates, key=sp.count_ops)
