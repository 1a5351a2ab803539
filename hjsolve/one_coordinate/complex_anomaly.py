"""The maps from an anomaly to a coordinate at complex phases, in doubles.

The maps are those of ``one_coordinate.anomaly`` and ``one_coordinate.stretched_anomaly``; here they serve to bound
integrands in a strip of the complex plane, so that a few digits are enough.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.floats import ComplexPoints
from hjsolve.arithmetic.number_types import Complexes, Elementwise, Reals
from hjsolve.errors import required
from hjsolve.one_coordinate.stretched_anomaly import Inner, Stretched

_POINTS = ComplexPoints()
_EDGE = np.exp(2j * np.pi * (np.arange(8) + 0.5) / 8)
"""Places of the edge of a disk, none on the axes, where maps have their symmetries: two of them would say the same."""
_MARGIN = 1.2
"""The radius of a map's image over the greatest distance seen at eight points of the edge. They miss 2 % (1/cos(π/16))
of a map whose second term is as large as its first; maps that bend more are those of wider disks, which are divided."""


class ComplexPlace(NamedTuple):
    """Where a complex phase puts the coordinate, arrays of one shape.

    Attributes:
        q: position; of an angle that goes round up to whole turns.
        from_lower, to_upper: q − a and b − q; None for a rotation.
        stretch: |dq/dψ| / √|(q − a)(b − q)|, the factor of dq/p.
    """

    q: Complexes
    from_lower: Complexes | None
    to_upper: Complexes | None
    stretch: Reals

    @property
    def from_upper(self) -> Complexes | None:
        """The distance q − b."""
        return None if self.to_upper is None else -self.to_upper


def complex_place(anomaly: Inner | Stretched, phase: Complexes) -> ComplexPlace:
    """Return where a complex phase puts the coordinate.

    Args:
        anomaly: the map; its constants are rounded to doubles.
        phase: complex array, real parts in [−π, π].
    """
    there: Elementwise = phase
    found = anomaly.in_doubles().place(there, _POINTS)
    numbers = found.q, found.below, found.above, found.stretch * found.rate
    q, below, above, stretch = cast("tuple[Complexes, ...]", numbers)
    return ComplexPlace(q, below, above, np.abs(stretch))


class PlaceDisks(NamedTuple):
    """Disks that hold q, q − a and q − b; the last two None for a rotation."""

    q: Disk
    from_lower: Disk | None
    from_upper: Disk | None


def place_disks(anomaly: Inner | Stretched, χ: Complexes, radius: Reals) -> PlaceDisks:
    """Enclose the images of disks of the phase: the distance is greatest on the edge (maximum principle).

    Args:
        χ: centres, complex, shape (m,).
        radius: of the disks, shape (m,).
    """
    points = np.concatenate([χ[None], χ + radius * _EDGE[:, None]])
    found = complex_place(anomaly, points)

    def disk(values: Complexes) -> Disk:
        apart = np.max(np.abs(values[1:] - values[0]), axis=0)
        return Disk(values[0], _MARGIN * apart + 1e-15 * np.abs(values[0]))

    if found.from_lower is None:
        # the angle is known up to turns: the edge is brought next to the centre
        across = np.real(found.q - found.q[0]) + np.pi
        turned = found.q[0] + across % (2 * np.pi) - np.pi + 1j * np.imag(found.q - found.q[0])
        return PlaceDisks(disk(turned), None, None)
    return PlaceDisks(disk(found.q), disk(found.from_lower), disk(required(found.from_upper)))
