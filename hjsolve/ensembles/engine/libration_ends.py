"""Which maps of nodes serve motions, by what p² does at their ends.

p² = (q − a)(b − q) S, and S′/S at an end tells how far the zero or pole next to it is; see ``node_maps``, and
``kernels.fitting_maps`` for the choice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.fitting_maps import maps_of_ends
from hjsolve.ensembles.engine.node_maps import NodeMaps
from hjsolve.ensembles.engine.nodes import MOST_LEVEL


class LibrationEnds(NamedTuple):
    """Turning points of n motions.

    Attributes:
        known: the maps of this process.
        bends: F′ and ½F″ of the lower and of the upper one, shape (2, 2, n).
        signs: how offsets grow away from them, shape (2,).
        even: True where the motion is even about its middle.
    """

    known: NodeMaps
    bends: Reals
    signs: Reals
    even: Mask

    def take(self, index: Integers) -> LibrationEnds:
        """Return those of some motions."""
        return self._replace(bends=self.bends[..., index], even=self.even[index])

    def maps(self, width: Reals, *, alike: bool = False) -> tuple[Integers, Integers]:
        """Return the maps of the motions, and how much is seen from below.

        Args:
            width: of the motions.
            alike: whether both ends are as if like the worse one.
        """
        n = len(width)
        kinds, fraction = np.empty((n, 3), dtype=np.int64), np.empty(n, dtype=np.int64)
        bends, even, W = np.ascontiguousarray(self.bends), np.ascontiguousarray(self.even), np.ascontiguousarray(width)
        with np.errstate(all="ignore"):
            maps_of_ends(bends, self.signs, even, W, MOST_LEVEL, alike, kinds, fraction)
        return self.known.index(kinds), fraction
