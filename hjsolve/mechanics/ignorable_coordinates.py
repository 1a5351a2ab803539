"""Eliminating the ignorable coordinates: what is left of ½ pᵀM⁻¹p as squares, linear terms and a potential.

With m the mass matrix and r = (c − a) for ignorable, (−a) for essential coordinates, ½ (p + r)ᵀ m⁻¹ (p + r) is reduced
pivot by pivot. A pivot k adds r_k²/(2m_kk) and replaces m by m − m_·k m_k·/m_kk, r by r − m_·k r_k/m_kk: symmetric
Gaussian elimination. Where T is indefinite the pivots may all vanish: two ignorable coordinates with m_kl ≠ 0 are then
eliminated together, as ½(2m_kl) of the sum and difference of their velocities would be. What is left may be a null
block N, m_NN = 0 (light-like coordinates, T = q̇ ẏ). With G the inverse of what is left,

    H = ½ (p + r)ᵀ G_ee (p + r) + (p + r)ᵀ G_eN r_N + ½ r_Nᵀ G_NN r_N + …,

and G_ee has as many null directions as N has members: where it is diagonal, the momenta of that many essential
coordinates enter H linearly, with the coefficients (G_eN r_N).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.readable import printed_length
from hjsolve.algebra.reader import Reader

Rows = list[list[Element]]


@dataclass(frozen=True)
class Eliminated:
    """H = Σ_a ½ gᵃ(p_a + A_a)² + Σ_n gⁿ p_n + centrifugal, unless two coordinates stay coupled.

    Attributes:
        coupled: positions of the first two essential coordinates that stay coupled, with the coefficient; or None.
        metric: gᵃ, or the coefficient gⁿ of a momentum that enters linearly; one per essential coordinate.
        null: positions of the essential coordinates whose momentum enters linearly.
        shift: A_a; zero for null coordinates.
        centrifugal: the terms without essential momenta.
    """

    coupled: tuple[int, int, Element] | None
    metric: list[Element]
    null: tuple[int, ...]
    shift: list[Element]
    centrifugal: list[Element]


def eliminate(
    reader: Reader, mass: Rows, r: list[Element], essential: Sequence[int], passive: Sequence[int],
    positions: Sequence[sp.Symbol],
) -> Eliminated:  # fmt: skip
    """Eliminate the ignorable coordinates.

    Args:
        reader: reader of the field.
        mass: the mass matrix; changed in place.
        r: −a, with the constant momentum added for ignorable coordinates; changed in place.
        essential: numbers of the coordinates that stay.
        passive: numbers of the ignorable ones.
        positions: symbols of the essential coordinates; pivots without them come first.
    """
    left, centrifugal = list(passive), list[Element]()
    while (pivots := _pivots(mass, left, positions)) is not None:
        left = [i for i in left if i not in pivots]
        centrifugal.append(_sweep(reader, mass, r, pivots, [*left, *essential]))
    if left:
        return _with_null_block(reader, mass, r, essential, left, centrifugal)
    m = [[mass[i][j] for j in essential] for i in essential]
    coupled = first_coupled(m)
    metric = [] if coupled else [m[a][a] ** -1 for a in range(len(m))]
    return Eliminated(coupled, metric, (), [r[i] for i in essential], centrifugal)


def first_coupled(m: Rows) -> tuple[int, int, Element] | None:
    """Positions of the first entry off the diagonal that is not zero, and the entry.

    Args:
        m: rows of a symmetric matrix, shape (n, n).
    """
    return next(((j, i, m[i][j]) for i in range(len(m)) for j in range(i) if not m[i][j].is_zero), None)


def _pivots(mass: Rows, left: Sequence[int], positions: Sequence[sp.Symbol]) -> tuple[int, int] | None:
    """Return the simplest pivot as (k, k), else a pair (k, l) with m_kk = m_ll = 0 and m_kl ≠ 0, else None."""
    usable = [i for i in left if not mass[i][i].is_zero]
    if usable:
        k = min(usable, key=lambda i: (any(mass[i][i].depends_on(q) for q in positions), printed_length(mass[i][i])))
        return k, k
    return next(((k, n) for n in left for k in left if k < n and not mass[k][n].is_zero), None)


def _sweep(reader: Reader, mass: Rows, r: list[Element], pivots: tuple[int, int], others: Sequence[int]) -> Element:
    """Replace m and r by what is left of them after the pivots; return the term they leave in H."""
    field, (k, n) = reader.field, pivots
    pivot = mass[k][n]
    term = r[k] ** 2 / pivot * Fraction(1, 2) if k == n else r[k] * r[n] / pivot  # a power keeps its factors
    both = [(k, n)] if k == n else [(k, n), (n, k)]
    fraction = {
        i: [(field.cancelled(mass[i][a] / pivot), b) for a, b in both if not mass[i][a].is_zero] for i in others
    }
    rows = {b: list(mass[b]) for b in pivots}
    for i in others:
        for weight, b in fraction[i]:
            r[i] = field.cancelled(r[i] - weight * r[b])
            for j in others:
                if not rows[b][j].is_zero:
                    mass[i][j] = field.cancelled(mass[i][j] - weight * rows[b][j])
    return term


def _with_null_block(
    reader: Reader, mass: Rows, r: list[Element], essential: Sequence[int], null: Sequence[int],
    centrifugal: list[Element],
) -> Eliminated:  # fmt: skip
    """Return the shell where m_NN = 0 is left of the ignorable coordinates; see the module's text."""
    field = reader.field
    order = [*essential, *null]
    G = _inverse(reader, [[mass[i][j] for j in order] for i in order])
    e, n = range(len(essential)), range(len(essential), len(order))
    rest = {k: r[i] for k, i in enumerate(order)}
    if (coupled := first_coupled([[G[a][b] for b in e] for a in e])) is not None:
        return Eliminated(coupled, [], (), [rest[a] for a in e], centrifugal)
    linear = [field.cancelled(field.total(G[a][k] * rest[k] for k in n)) for a in e]
    metric, shift, found = [], [], []
    centrifugal = [*centrifugal, field.total(G[j][k] * rest[j] * rest[k] for j in n for k in n) * Fraction(1, 2)]
    for a in e:
        if G[a][a].is_zero:
            found.append(a)
            metric.append(linear[a])
            shift.append(field.zero)
            centrifugal.append(linear[a] * rest[a])
        else:
            metric.append(G[a][a])
            shift.append(field.cancelled(rest[a] + linear[a] / G[a][a]))
            centrifugal.append(linear[a] ** 2 / G[a][a] * Fraction(-1, 2))
    return Eliminated(None, metric, tuple(found), shift, [x for x in centrifugal if not x.is_zero])


def _inverse(reader: Reader, m: Rows) -> Rows:
    """Return the inverse of a regular matrix by Gauss and Jordan, the simplest pivot of each column first."""
    field, size = reader.field, len(m)
    work = [[*row, *(field.one if i == j else field.zero for j in range(size))] for i, row in enumerate(m)]
    for k in range(size):
        p = min(
            (i for i in range(k, size) if not work[i][k].is_zero),
            key=lambda i: printed_length(work[i][k]),
            default=None,
        )
        if p is None:
            raise ZeroDivisionError("the mass matrix is singular")
        work[k], work[p] = work[p], work[k]
        pivot = work[k][k]
        work[k] = [x if x.is_zero else field.cancelled(x / pivot) for x in work[k]]
        for i in range(size):
            if i != k and not (weight := work[i][k]).is_zero:
                work[i] = [field.cancelled(x - weight * y) for x, y in zip(work[i], work[k], strict=True)]
    return [row[size:] for row in work]
