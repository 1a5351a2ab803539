"""Choosing the separation constants so that the Stäckel matrix is sparse and reads as in a textbook.

The rows of Φ are functions of one coordinate each. Written over a common denominator, each row is a list of coefficient
functionals acting on constant column vectors. A column with a zero in row i is a vector in the kernel of row i. Since
"sparsest basis" is a problem over a linear matroid, taking the sparsest admissible vectors greedily is optimal for
the number of zeros.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import combinations, islice

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.readable import printed_length, variants
from hjsolve.algebra.reader import Reader
from hjsolve.errors import required

Row = list[Element]
Vector = list[Element]
MAX_CANDIDATES = 120
LINES, POINTS = 30, 8


def sparsest(reader: Reader, symbols: Sequence[sp.Symbol], rows: list[Row], column: Row) -> tuple[list[Row], Row]:
    """Change columns 2 … n, column 1 and ψ by the operations that are free, so that as much as possible vanishes.

    Args:
        reader: reader of the field.
        symbols: the coordinates; row i of ``rows`` depends on symbols[i] only.
        rows: Φ.
        column: ψ.

    Returns:
        The new Φ and ψ.
    """
    n = len(rows)
    if n == 1:
        return rows, column
    functionals = [_functionals(reader, q, [*row, ψ]) for q, row, ψ in zip(symbols, rows, column)]
    free = _distinct(reader, [f[1:n] for row in functionals for f in row])
    lines = _independent_lines(reader, rows, _candidate_lines(reader, free, n - 1))
    chosen = _ordered([_scaled(reader, _apply(reader, rows, [None, *v])) for v in lines])
    first = _best_point(reader, rows, [row[0] for row in rows], [[f[0], *f[1:n]] for row in functionals for f in row])
    last = _best_point(reader, rows, column, [[f[n], *f[1:n]] for row in functionals for f in row])
    return [[first[i], *(c[i] for c in chosen)] for i in range(n)], last


def _functionals(reader: Reader, q: sp.Symbol, row: Row) -> list[Vector]:
    """Coefficients of the independent functions of q that a row is made of: one vector of constants per function.

    Both normal forms of sin² + cos² = 1 are used, so that 1, 1/sin² and cot² can each be made to vanish.
    """
    field = reader.field
    names = {b for x in row for b in x.factors}
    shared = {b: min(0, *(x.factors.get(b, 0) for x in row)) for b in names}
    inverse = Element(field, Fraction(1), {0: 1}, {b: -e for b, e in shared.items() if e})
    scaled = [_expanded(reader, x * inverse) for x in row]
    found = _coefficients_of(reader, q, scaled)
    for k, g in enumerate(field.generators):
        if g.partner is not None and q in g.atom.free_symbols:
            sign = -1 if g.kind == "sin" else 1
            square: Poly = {0: 1, 2 << (poly.BITS * k): sign}
            swapped = [(poly.with_square(a, g.partner, square, reader.field.budget), c) for a, c in scaled]
            found += _coefficients_of(reader, q, swapped)
    return found


def _expanded(reader: Reader, x: Element) -> tuple[Poly, Fraction]:
    """Write x = polynomial · number.

    Factors with negative exponents must be free of coordinates and are moved to the rest.
    """
    field = reader.field
    a = x.numerator
    for base, e in x.bases:
        for _ in range(max(e, 0)):
            a = field.reduce(poly.mul(a, base, field.budget))
    return a, x.coefficient


def _coefficients_of(reader: Reader, q: sp.Symbol, scaled: Sequence[tuple[Poly, Fraction]]) -> list[Vector]:
    field = reader.field
    mask = sum(poly.FIELD << (poly.BITS * k) for k, g in enumerate(field.generators) if q in g.atom.free_symbols)
    table: dict[int, list[Poly]] = {}
    for position, (a, _) in enumerate(scaled):
        for m, n in a.items():
            table.setdefault(m & mask, [{} for _ in scaled])[position][m & ~mask] = n
    return [[field.from_poly(a, c) for a, (_, c) in zip(polys, scaled)] for polys in table.values()]


def _distinct(reader: Reader, vectors: Iterable[Vector]) -> list[Vector]:
    """Functionals that differ by more than a factor, zeros left out."""
    found: dict[tuple[object, ...], Vector] = {}
    for v in vectors:
        lead = next((x for x in v if not x.is_zero), None)
        if lead is not None:
            w = [reader.field.cancelled(reader.field.factored(x / lead)) for x in v]
            found.setdefault(tuple((x.coefficient, poly.key(x.numerator), frozenset(x.factors.items())) for x in w), w)
    return list(found.values())


def _candidate_lines(reader: Reader, functionals: list[Vector], d: int) -> list[Vector]:
    """Vectors of dimension d that d − 1 independent functionals annihilate, and the unit vectors."""
    field = reader.field
    units = [[field.coerce(int(i == k)) for i in range(d)] for k in range(d)]
    if d == 1:
        return units
    kernels = (_kernel(reader, rows) for rows in combinations(functionals, d - 1))
    found = list(islice((k for k in kernels if k is not None), MAX_CANDIDATES))
    return [*_promising(reader, functionals, found, LINES), *units]


def _promising(reader: Reader, functionals: Sequence[Vector], vectors: list[Vector], few: int) -> list[Vector]:
    """Return those that most functionals annihilate, in their order; all of them where they are few.

    Annihilation is read off modulo a prime: it only decides which candidates are worth multiplying out.
    """
    if len(vectors) <= few:
        return vectors
    sieve = Filter(reader.field, points=1)

    def annihilated(vector: Vector) -> int:
        return sum(
            sieve.vanishes([[[f], [x]] for f, x in zip(functional, vector)]) is True for functional in functionals
        )

    best = sorted(range(len(vectors)), key=lambda k: -annihilated(vectors[k]))[:few]
    return [vectors[k] for k in sorted(best)]


def _kernel(reader: Reader, rows: Sequence[Vector]) -> Vector | None:
    """Return the vector that d − 1 functionals of dimension d annihilate; None when they are dependent."""
    field, d = reader.field, len(rows[0])
    work = [list(row) for row in rows]
    pivots: list[int] = []
    for r in range(d - 1):
        pivot = next(((i, k) for i in range(r, d - 1) for k in range(d) if not work[i][k].is_zero), None)
        if pivot is None:
            return None
        i, k = pivot
        work[r], work[i] = work[i], work[r]
        lead = work[r][k]
        work[r] = [field.cancelled(x / lead) for x in work[r]]
        for other in range(d - 1):
            if other != r and not (c := work[other][k]).is_zero:
                work[other] = [field.cancelled(x - c * y) for x, y in zip(work[other], work[r])]
        pivots.append(k)
    free = next(k for k in range(d) if k not in pivots)
    vector = [field.zero] * d
    vector[free] = field.one
    for r, k in enumerate(pivots):
        vector[k] = -work[r][free]
    return vector


def _apply(reader: Reader, rows: list[Row], vector: Sequence[Element | None], start: Row | None = None) -> Row:
    """Start + Φ·vector; None stands for 0."""
    field = reader.field
    result = []
    for row, first in zip(rows, start or [field.zero] * len(rows)):
        terms = [first, *(x * v for x, v in zip(row, vector) if v is not None and not v.is_zero)]
        result.append(min(variants(reader, field.cancelled(field.total(terms))), key=printed_length))
    return result


def _independent_lines(reader: Reader, rows: list[Row], candidates: list[Vector]) -> list[Vector]:
    """Return the n − 1 best independent candidates: most zeros first, then shortest, then upper triangular."""
    scored = []
    for position, v in enumerate(candidates):
        image = _scaled(reader, _apply(reader, rows, [None, *v]))
        zeros = tuple(x.is_zero for x in image)
        scored.append((-sum(zeros), sum(map(printed_length, image)), zeros, position, v))
    chosen: list[Vector] = []
    for *_, v in sorted(scored, key=lambda item: item[:-1]):
        if len(chosen) < len(v) and _rank(reader, [*chosen, v]) == len(chosen) + 1:
            chosen.append(v)
    return chosen


def _rank(reader: Reader, vectors: Sequence[Vector]) -> int:
    field = reader.field
    work, rank = [list(v) for v in vectors], 0
    for k in range(len(work[0])):
        r = next((i for i in range(rank, len(work)) if not work[i][k].is_zero), None)
        if r is None:
            continue
        work[rank], work[r] = work[r], work[rank]
        for i in range(rank + 1, len(work)):
            if not work[i][k].is_zero:
                c = work[i][k] / work[rank][k]
                work[i] = [field.cancelled(x - c * y) for x, y in zip(work[i], work[rank])]
        rank += 1
    return rank


def _scaled(reader: Reader, image: Row) -> Row:
    """Return a column divided by the constant content of its last entry that is not zero.

    So that this entry has coefficient 1.
    """
    field = reader.field
    lead = next(x for x in reversed(image) if not x.is_zero)
    constant = _constant_part(reader, lead)
    return [field.cancelled(x / constant) for x in image]


def _constant_part(reader: Reader, x: Element) -> Element:
    """Return the factors of an element that hold no coordinate."""
    field = reader.field
    moving = set(reader.bounds)
    y = field.factored(x)

    def still(base: Poly) -> bool:
        return not any(field.generators[k].atom.free_symbols & moving for k in poly.generators(base))

    return Element(field, y.coefficient, {0: 1}, {b: e for b, e in y.factors.items() if still(field.bases[b])})


def _ordered(columns: list[Row]) -> list[Row]:
    """Columns by the place of their last entry that is not zero, upper triangular where possible; then by length."""

    def place(column: Row) -> tuple[int, int, int]:
        places = [i for i, x in enumerate(column) if not x.is_zero]
        return places[-1], places[0], sum(map(printed_length, column))

    return sorted(columns, key=place)


def _best_point(reader: Reader, rows: list[Row], start: Row, functionals: list[Vector]) -> Row:
    """Start + Σ_{j≥2} Φ·ⱼ k_j with the constants k that leave the shortest column."""
    field, d = reader.field, len(rows) - 1
    augmented = _distinct(reader, [f for f in functionals if any(not x.is_zero for x in f[1:])])
    candidates: list[Vector] = [[field.zero] * d]
    solutions = (_solution(reader, chosen) for chosen in combinations(augmented, d))
    found = [[field.one, *s] for s in islice((s for s in solutions if s is not None), MAX_CANDIDATES)]
    candidates += [k[1:] for k in _promising(reader, augmented, found, POINTS)]
    best: tuple[tuple[object, ...], Row] | None = None
    for position, k in enumerate(candidates):
        image = _apply(reader, rows, [None, *k], start)
        score = (
            -sum(x.is_zero for x in image),
            sum(map(printed_length, image)),
            tuple(x.is_zero for x in image),
            position,
        )
        if best is None or score < best[0]:
            best = score, image
    return required(best)[1]


def _solution(reader: Reader, equations: Sequence[Vector]) -> Vector | None:
    """Solve f₀ + Σ f_j k_j = 0 for k; None when the equations are dependent."""
    kernel = _kernel(reader, equations)
    if kernel is None or kernel[0].is_zero:
        return None
    return [reader.field.cancelled(x / kernel[0]) for x in kernel[1:]]
