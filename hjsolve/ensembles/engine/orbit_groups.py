"""Some orbits of one coordinate: what is known of them before it is known where they move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Integers, Reals, Which
from hjsolve.ensembles.engine.constants import InitialConstants
from hjsolve.ensembles.engine.lowered_solution import Model, Separated
from hjsolve.ensembles.engine.radicand_views import DirectEvaluation, Knowns


@dataclass(frozen=True)
class Group:
    """Some orbits of one coordinate.

    Attributes:
        coordinate: which.
        index: which orbits.
        knowns, pairs, numbers: constants and parameters, in doubles and in two doubles.
        q, P, first, bend: the start, F′ and ½F″ there.
        depth: 0 in doubles; 1 with small amplitudes seen from the start and poles from their place; 2 with 32
            digits where doubles do not know p² well; 3 with 32 digits.
    """

    coordinate: Separated
    index: Integers
    knowns: Knowns
    pairs: tuple[Pair, ...]
    numbers: tuple[Pair, ...]
    q: Reals
    P: Reals
    first: Reals
    bend: Reals
    depth: int

    def take(self, index: Which) -> Group:
        """Return some of them.

        Args:
            index: which, positions or a mask.
        """
        arrays = {name: getattr(self, name)[index] for name in ("index", "q", "P", "first", "bend")}
        pairs = tuple(Pair(c.high[index], c.low[index]) for c in self.pairs)
        return replace(self, knowns=self.knowns.take(index), pairs=pairs, **arrays)


def group_of(
    model: Model, coordinate: Separated, start: InitialConstants, k: int, depth: int, index: Integers | None = None
) -> Group:
    """Return orbits of one coordinate.

    Args:
        model: of the system.
        coordinate: the k-th separated one.
        start: of n orbits.
        k: row of the coordinate.
        depth: see ``Group``.
        index: which of the orbits; None for all.
    """
    index = np.arange(start.q.shape[1]) if index is None else index
    every = len(index) == start.q.shape[1]
    q, P = start.q[k][index], start.P[k][index]
    knowns = start.knowns if every else start.knowns.take(index)
    pairs = tuple(Pair(c.high[index], c.low[index]) for c in start.pairs or ())
    with np.errstate(all="ignore"):
        _, first, second = DirectEvaluation(coordinate.plain, knowns).jet(q)
    return Group(coordinate, index, knowns, pairs, model.numbers, q, P, first, 0.5 * second, depth)
