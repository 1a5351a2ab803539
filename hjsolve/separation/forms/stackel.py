"""Stäckel matrix and column by the base-point construction, made readable, and verified by substitution.

Greenwood (p. 208) says that Stäckel's theorem "presents no direct method". This is one: hold all coordinates but the
i-th at a base point q⁰ (written q̂ᵢ); a separable shell then has

    ½ Pᵢ² = [E − V(q̂ᵢ) − Σ_{j≠i} gʲʲ(q̂ᵢ) aⱼ] / gⁱⁱ(q̂ᵢ),        Σⱼ gʲʲ(q⁰) aⱼ + V(q⁰) = E,

linear in (E, a): a Stäckel matrix Φ and column ψ can be read off. Substitution decides: cᵀΦ = (1, 0, …, 0) and cᵀψ =
V hold if and only if the shell separates (Eisenhart 1934; docs/theory).

What may be changed without changing anything (Greenwood after (5-140)): columns 2 … n of Φ mixed by a constant
nonsingular matrix, multiples of them added to column 1 and to ψ. ``columns`` uses this freedom.

Here ``matrix`` holds Φ and ψ as elements, ``metric`` is c = (gᵃᵃ), one element a coordinate, and ``potential`` is V or
V_eff.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter, Products
from hjsolve.algebra.readable import length_of, shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.forms.base_points import BasePoint, find_base_points
from hjsolve.separation.forms.sparse_columns import sparsest
from hjsolve.separation.verdicts import Stackel

Row = list[Element]


@dataclass(frozen=True)
class Matrix:
    """Φ and ψ as elements of the field."""

    rows: list[Row]
    column: Row


def construct(
    reader: Reader, symbols: Sequence[sp.Symbol], metric: Sequence[Element], potential: Element
) -> Matrix | None:
    """Φ and ψ of a shell in readable form; None when no base point gives a regular matrix or the certificate fails.

    A failed certificate shows that the shell does not separate; which condition fails is for ``levi_civita`` to say.

    Args:
        symbols: essential coordinates.
        metric: gᵃᵃ, one element a coordinate.
    """
    if len(metric) == 1:
        matrix = Matrix([[metric[0] ** -1]], [reader.field.cancelled(potential / metric[0])])
        return matrix if certified(reader, metric, potential, matrix) else None
    for point in find_base_points(reader, symbols):
        try:
            raw = at_base_point(reader, point, metric, potential)
        except ZeroDivisionError:
            continue
        if not plausible(reader, metric, potential, raw):
            return None
        tidy = sparsest(reader, symbols, raw.rows, raw.column)
        matrix = Matrix(*tidy)
        return matrix if certified(reader, metric, potential, matrix) else None
    return None


def certified(reader: Reader, metric: Sequence[Element], potential: Element, matrix: Matrix) -> bool:
    """Exact proof of cᵀΦ = (1, 0, …, 0) and cᵀψ = V."""
    return all(
        levi_civita.sum_of_products(reader, identity).is_zero
        for identity in _identities(reader, metric, potential, matrix)
    )


def plausible(reader: Reader, metric: Sequence[Element], potential: Element, matrix: Matrix) -> bool:
    """Return the identities of ``certified`` at random points modulo primes.

    What fails here is not worth making readable.
    """
    sieve = Filter(reader.field)
    return all(sieve.vanishes(identity) is not False for identity in _identities(reader, metric, potential, matrix))


def _identities(reader: Reader, metric: Sequence[Element], potential: Element, matrix: Matrix) -> Iterator[Products]:
    """Yield the sums of products that vanish for a Stäckel matrix and column."""
    one, n = reader.field.one, range(len(metric))
    for j in n:
        yield [*([[metric[i]], [matrix.rows[i][j]]] for i in n), *([[[-one]]] if j == 0 else [])]
    yield [*([[metric[i]], [matrix.column[i]]] for i in n), [[-potential]]]


def at_base_point(
    reader: Reader,
    point: BasePoint,
    metric: Sequence[Element],
    potential: Element,
    blocks: Sequence[frozenset[int]] | None = None,
) -> Matrix:
    """Φ and ψ in the constants (E, gʲʲ(q⁰)aⱼ), j < n; a_n is eliminated by the shell at the base point.

    With aⱼ measured in units of 1/gʲʲ(q⁰) the factors of g that belong to one coordinate drop out of the constants.

    With ``blocks``, row i is a function of all coordinates of block i, and ``metric`` has one entry per block.

    Args:
        point: q⁰.
        metric: gᵃᵃ, one element a coordinate, or one a block.
        blocks: positions of the coordinates, block by block; by default every coordinate is one.

    Raises:
        ZeroDivisionError: the metric is singular at the base point or on a line through it.
    """
    field, n = reader.field, len(metric)
    last = n - 1
    g0 = [point.keep(g, set()) for g in metric]
    V0 = point.keep(potential, set())
    rows, column = [], []
    for i in range(n):
        free = {i} if blocks is None else blocks[i]
        g = [point.keep(x, free) for x in metric]
        V = point.keep(potential, free)
        if any(x.is_zero for x in (*g, *g0)):
            raise ZeroDivisionError("the metric vanishes on a line through the base point")
        own = g[i] ** -1
        through_last = field.coerce(0) if i == last else g[last] / (g0[last] * g[i])
        row = [own - through_last]
        for j in range(last):
            direct = field.coerce(0) if j == i else -(g[j] / g0[j] * own)
            row.append(field.cancelled(direct + through_last))
        rows.append([field.cancelled(row[0]), *row[1:]])
        column.append(field.cancelled(V * own - through_last * V0))
    return Matrix(rows, column)


def finished(
    reader: Reader, names: Sequence[str], metric: Sequence[sp.Expr], potential: sp.Expr, matrix: Matrix
) -> Stackel:
    """Return the verdict's form: readable expressions.

    With one coordinate ψ = V/c is written term by term as the user wrote V.

    Args:
        names: of the essential coordinates.
        metric: gᵃᵃ, one expression a coordinate.
    """
    entries = [[shortest_form(reader, x) for x in row] for row in matrix.rows]
    if len(names) == 1:
        column = (_as_written(reader, potential, matrix.rows[0][0], entries[0][0]),)
    else:
        column = tuple(shortest_form(reader, x) for x in matrix.column)
    return Stackel(tuple(names), sp.ImmutableMatrix(entries), column, tuple(metric))


def _as_written(reader: Reader, potential: sp.Expr, factor: Element, weight: sp.Expr) -> sp.Expr:
    """V times a factor, term by term; U·((x − c)² + …) too where that is shorter than what it is multiplied out.

    A term stays as it is where no other form is as short: (x/(x + a))²⁻ᶜ is in the field x²/(x + a)²·(x/(x + a))⁻ᶜ.
    """
    terms = sp.Add.make_args(potential)
    sums = [a for a in potential.args if a.is_Add] if potential.is_Mul else []
    written_forms = [terms, [potential / sums[0] * term for term in sums[0].args]] if len(sums) == 1 else [terms]
    written = [sp.Add(*(_term(reader, v, factor, weight) for v in form)) for form in written_forms]
    return min(written, key=length_of)


def _term(reader: Reader, v: sp.Expr, factor: Element, weight: sp.Expr) -> sp.Expr:
    return min(shortest_form(reader, reader.element(v) * factor), v * weight, key=length_of)
