"""Which maps of nodes serve motions, by what p² does at their ends.

p² = (q − a)(b − q) S, and S′/S at an end tells how far the zero or pole next to it is; see ``node_maps``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.crowding import EVEN
from hjsolve.ensembles.engine.node_maps import NodeMaps, fitting, views

_NEAR = 3.0
"""W over the distance of what is next to a turning point, minus 1, from which it counts. Without such a thing p² is
nearly quadratic, W S′/S ≈ ∓1, and the measure is of the curvature of S alone."""
_STRETCHED = 16.0
"""(1 + ρ_d)(1 + ρ_c) from which on nodes are stretched; below, crowded ones do as well."""


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
        """Return the maps of the motions, and how much is seen from below; ``alike``.

        Both ends as if like the worse one.
        """
        found = []
        with np.errstate(all="ignore"):
            for (first, bend), sign in zip(self.bends, self.signs, strict=True):
                # W·|S′/S| at an end is W over the distance of the zero or pole next to it: 1 + ρ_d and 1 + ρ_c
                ρ = np.abs(width * bend / (sign * first) + 1)
                found.append(1 + np.where(np.isfinite(ρ) & (ρ > _NEAR), ρ, 0.0))
            lower, upper = (np.maximum(*found),) * 2 if alike else found
            # 1/k′² = (1 + ρ_d)(1 + ρ_c): below 16 the elliptic map gains less than crowding does
            stretched = np.where(self.even, np.maximum(lower, upper) ** 2, lower * upper) >= _STRETCHED
            index = np.where(self.even, EVEN, 0)
            some = np.flatnonzero(stretched)
            if len(some):
                index[some] = self.known.index(fitting(lower[some], upper[some], self.even[some]))
            # an even motion is seen from one end over half of it, and mirrored
            fraction = np.where(~self.even, views(self.bends[0, 0], self.bends[1, 0], (lower, upper)), 0)
        return index, fraction
