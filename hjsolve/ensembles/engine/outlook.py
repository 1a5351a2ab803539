"""Which orbits a first pass in doubles would only integrate in vain: seen from their regions, before any node.

The claims of such a pass are made of the error δF of p², which shifts a turning point by δF/F′; and its plain anomalies
take ever more nodes the nearer a pole or zero of p² comes to a turning point. So both are looked at there. Whom this
sends on gets 32-digit constants and stretched anomalies, and loses nothing but the first pass.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.ensembles.engine.orbit_regions import LocatedRegions, OrbitRegions
from hjsolve.ensembles.engine.radicand_views import DifferenceEvaluation
from hjsolve.ensembles.engine.regions import stretched

_SHIFT, _SHIFT_ACTIONS = 4e-14, 6e-13
"""Shifts of a turning point, in widths of the motion, above which nearly all claims (of actions) are too large."""

_LEVEL, _LEVEL_ACTIONS = 6, 7
"""Moduli 4^−level from which on plain anomalies hardly ever do."""


def beyond_doubles(found: LocatedRegions, *, kernels: bool) -> Mask:
    """Tell which librations of a first pass would come out with claims that are too large, or not at all.

    Args:
        found: the regions of n orbits, p² being evaluated as it is written.
        kernels: whether ∂J/∂c are wanted, which suffer most.

    Returns:
        Array of booleans, shape (n,).
    """
    region = found.region
    if not region.turning:
        return np.zeros(len(region.width), dtype=bool)
    with np.errstate(all="ignore"):
        near = stretched(region).level >= (_LEVEL if kernels else _LEVEL_ACTIONS)
        return near | (_shift(region) > (_SHIFT if kernels else _SHIFT_ACTIONS))


def _shift(region: OrbitRegions) -> Reals:
    """The larger shift of the turning points, over the width."""
    shifts = []
    for view, x in ((region.below, region.lower), (region.above, region.upper)):
        assert not isinstance(view, DifferenceEvaluation)
        shifts.append(view.errors(x, kernels=False)[0] / np.abs(view.jet(x)[1]) / region.width)
    return np.fmax(*shifts)
