"""Where disks of the parameter of a branch put the coordinate, and how fast it moves there.

The maps are those of ``chebyshev_panels``. Distances from the place y₀ of a panel come from identities and not from
differences: (y₀ + z)² − y₀² = z (2y₀ + z), sin²α − sin²β = sin(α − β) sin(α + β), e^−y₀ − e^−(y₀ + z) = e^−y₀ (1 −
e^−z).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single, tighter
from hjsolve.arithmetic.number_types import Reals
from hjsolve.one_coordinate.chebyshev_panels import EndMap

_D = Disks()
_ONE = single(1.0, 0.0)


class Scale(NamedTuple):
    """|dx/dy| = rate·rᵃ and what the momentum is divided by, pace·rᵇ, r being the root of the fraction of the way left.

    At a turning point both stand without the root of x that p² brings.
    """

    rate: float
    a: int
    weighted_rate: float
    b: int


def scale_along(end_map: EndMap) -> Scale:
    """Return how dx/dy varies along a branch; see ``EndMap.distances`` and ``EndMap.rest``.

    Args:
        end_map: the map q(y) of the branch.
    """
    length = float(end_map.length)
    root = length**0.5
    match end_map.end, end_map.turning:
        case "infinity" | "kink", turning:
            return Scale(2 * root, 0, 1 / (2 * root), 0) if turning else Scale(length, 0, 1 / length, 0)
        case "boundary", turning:
            return (
                Scale(root, 1, 1 / root, end_map.pole)
                if turning
                else Scale(2 * length, 1, 1 / (2 * length), end_map.pole)
            )
        case end, turning:
            b = end_map.pole if end == "fall" else -2
            return Scale(2 * root, 2, 1 / (2 * root), b) if turning else Scale(length, 2, 1 / length, b)


class PanelSamples(NamedTuple):
    """Where disks of y lie: x, r, and q − q(y₀) times the side; r is 1 on the way to infinity or to a kink."""

    x: Disk
    root: Disk
    moved: Disk


def samples(end_map: EndMap, y: float, rest: float, z: Disk) -> PanelSamples:
    """Map disks of z = y − y₀.

    Args:
        end_map: the branch.
        y: y₀.
        rest: what is left from y₀ to the greatest y, if there is one.
        z: the disks.
    """
    d, length = _D, float(end_map.length)
    here = d.shifted(z, y)
    if end_map.end in {"infinity", "kink"}:
        if end_map.turning:
            # (y + z)² − y² = z (z + 2y): no difference of squares
            return PanelSamples(d.times(d.power(here, 2), length), _ONE, d.times(d.mul(z, d.shifted(z, 2 * y)), length))
        return PanelSamples(d.times(here, length), _ONE, d.times(z, length))
    if end_map.end == "boundary":
        left = d.shifted(d.times(z, -1.0), rest)
        if end_map.turning:
            half, sine, root = d.times(z, 0.5), d.unary("sin", d.times(here, 0.5)), d.unary("sin", d.times(left, 0.5))
            # sin²α − sin²β = sin(α − β) sin(α + β)
            moved = d.mul(d.unary("sin", half), d.unary("sin", d.shifted(half, y)))
            x = tighter(d.power(sine, 2), d.sub(_ONE, d.power(root, 2)))
            return PanelSamples(d.times(x, length), root, d.times(moved, length))
        x = tighter(d.mul(here, d.shifted(left, 1.0)), d.sub(_ONE, d.power(left, 2)))
        return PanelSamples(d.times(x, length), left, d.times(d.mul(z, d.shifted(left, rest)), length))
    if end_map.turning:
        rise, root = d.unary("tanh", here), d.inverse(d.unary("cosh", here))
        # the difference is taken, with the rounding of tanh² y
        before = np.tanh(y) ** 2
        x = tighter(d.power(rise, 2), d.sub(_ONE, d.power(root, 2)))
        moved = d.sub(x, single(before, 2.0**-50 * before))
        return PanelSamples(d.times(x, length), root, d.times(moved, length))
    root = d.unary("exp", d.times(here, -0.5))
    # e^(−y) − e^(−y−z) = e^(−y) (1 − e^(−z))
    moved = d.mul(d.unary("exp", single(-y, 0)), d.sub(_ONE, d.unary("exp", d.times(z, -1.0))))
    return PanelSamples(d.times(d.sub(_ONE, d.power(root, 2)), length), root, d.times(moved, length))


class RootBounds(NamedTuple):
    """The least |r|, |r| at the centre, and the largest."""

    low: Reals
    middle: Reals
    high: Reals


def root_bounds(r: Disk, places: PanelSamples) -> RootBounds:
    """Return the sizes of r over disks.

    Args:
        r: one disk, or as many as there are places.
        places: the disks.
    """
    shape = np.shape(places.moved.radius)
    return RootBounds(*(np.broadcast_to(part, shape) for part in (r.least, np.abs(r.centre), r.largest)))


def largest_power(low: Reals, high: Reals, k: int) -> Reals:
    """Return the largest |r|ᵏ; infinite where r may be 0 and k is negative.

    Args:
        low, high: the least and the largest |r|.
        k: exponent.
    """
    return high**k if k >= 0 else 1 / low**-k
