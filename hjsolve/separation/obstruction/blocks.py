"""Which coordinates separate from each other although the whole does not: the finest partition into blocks.

A shell separates into blocks A, B, … when W = W_A(q_A) + W_B(q_B) + …; then ½ Σ gⁱⁱ pᵢ² + V = Σ_A φ^A(q) H_A with H_A
of block A alone, and φ is the first row of an inverse Stäckel matrix whose rows are functions of one *block* each
(Chanu and Rastelli 2019). Two coordinates of different blocks satisfy Levi-Civita's conditions, so that the connected
components of the pairs that fail are the finest candidate; Stäckel's construction by blocks proves it by substitution.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import sympy as sp

from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter
from hjsolve.algebra.reader import Reader
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.forms.base_points import find_base_points
from hjsolve.separation.forms.stackel import at_base_point, certified, plausible

Block = tuple[int, ...]
MAX_BASE_POINTS = 6


def finest(
    reader: Reader,
    symbols: Sequence[sp.Symbol],
    metric: Sequence[Element],
    potential: Element,
    failing: Iterable[tuple[int, int]],
) -> tuple[Block, ...]:
    """Return the finest partition into blocks that is proved to separate; one block when there is none.

    Args:
        symbols: essential coordinates.
        metric: gᵃᵃ.
        potential: V_eff.
        failing: pairs of positions that do not satisfy Levi-Civita's conditions.
    """
    atoms = components(len(symbols), failing)
    candidates = sorted(_coarser(atoms), key=lambda partition: -len(partition))
    for partition in candidates:
        if len(partition) > 1 and separates(reader, symbols, metric, potential, partition):
            return partition
    return (tuple(range(len(symbols))),)


def components(n: int, pairs: Iterable[tuple[int, int]]) -> tuple[Block, ...]:
    """Return connected components of a graph on 0 … n − 1.

    Args:
        n: number of vertices.
        pairs: the edges.
    """
    found: list[Block] = [(i,) for i in range(n)]
    for i, j in pairs:
        joined = [block for block in found if i in block or j in block]
        found = [block for block in found if block not in joined]
        found.append(tuple(sorted(k for block in joined for k in block)))
    return tuple(sorted(found))


def _coarser(atoms: Sequence[Block]) -> Iterator[tuple[Block, ...]]:
    """Every partition whose blocks are unions of the blocks given."""
    if not atoms:
        yield ()
        return
    first, rest = atoms[0], atoms[1:]
    for partition in _coarser(rest):
        yield tuple(sorted((first, *partition)))
        for k, block in enumerate(partition):
            yield tuple(sorted((*partition[:k], tuple(sorted(first + block)), *partition[k + 1 :])))


def separates(
    reader: Reader,
    symbols: Sequence[sp.Symbol],
    metric: Sequence[Element],
    potential: Element,
    partition: Sequence[Block],
) -> bool:
    """Return a proof that a shell separates into these blocks; False is not a proof of the opposite.

    Args:
        symbols: essential coordinates.
        metric: gᵃᵃ, one element a coordinate.
        potential: V or V_eff.
        partition: positions of the coordinates, block by block.
    """
    if not all(_is_one_energy(reader, symbols, metric, block) for block in partition):
        return False
    φ = [metric[block[0]] for block in partition]
    for count, point in enumerate(find_base_points(reader, symbols)):
        if count == MAX_BASE_POINTS:
            break
        try:
            matrix = at_base_point(reader, point, φ, potential, [frozenset(block) for block in partition])
        except ZeroDivisionError:
            continue
        return plausible(reader, φ, potential, matrix) and certified(reader, φ, potential, matrix)
    return False


def _is_one_energy(reader: Reader, symbols: Sequence[sp.Symbol], metric: Sequence[Element], block: Block) -> bool:
    """Return whether the ratios of the gⁱⁱ of a block are functions of the block's coordinates alone."""
    sieve, minus = Filter(reader.field), [reader.field.coerce(-1)]
    outside = [q for k, q in enumerate(symbols) if k not in block]
    for k in block[1:]:
        for q in outside:
            mine, first = reader.log_diff_terms(metric[k], q), reader.log_diff_terms(metric[block[0]], q)
            if not levi_civita.sum_vanishes(reader, [[mine], [minus, first]], sieve):
                return False
    return True
