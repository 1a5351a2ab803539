"""Pieces of the complex plane about the left end of a panel, and how long a panel that meets no bad one may be.

The ellipse of parameter ρ about a panel [0, s] (foci at its ends) is s times that about [0, 1]: the ellipses of all
panels that begin at one place are nested, and z lies on the edge of that with

    s = λ(z) = 2 (R |z| − Re z)/(R² − 1),   R = (ρ + 1/ρ)/2.

So the upper half plane about the place is cut into rings and sectors, finer towards it; where the integrands are
analytic over the sectors that an ellipse meets, they are so in the ellipse, by reflection in its lower half as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.number_types import Elementwise, Mask, Reals

RHO = 5.0
"""Parameter of the ellipses: a series of degree n is right to about ρ^(−n)."""
_R = (RHO + 1 / RHO) / 2
RATIO = 2.0**0.5
"""Of the radii of a ring."""
_ANGLES = 6
_PARTS = ("inner", "outer", "first", "last")


@dataclass(frozen=True)
class Sectors:
    """Sectors inner ≤ |z| ≤ outer, first ≤ arg z ≤ last, arrays of one shape; the core has inner radius 0."""

    inner: Reals
    outer: Reals
    first: Reals
    last: Reals

    def disks(self) -> Disk:
        """Return the disk about each: through its corners, or through the outer ones where it is a half disk."""
        half = (self.last - self.first) / 2
        core, inner = self.inner == 0, self.inner / self.outer
        away = np.where(core, 0.0, (inner + 1) / (2 * np.cos(np.where(core, 0.0, half))))
        corner = np.sqrt(np.abs(away**2 + 1 - 2 * away * np.cos(half)))
        radius = np.where(core, 1.0, np.maximum(corner, 1 - away))
        return Disk(self.outer * away * np.exp(1j * (self.first + half)), self.outer * radius * (1 + 1e-12))

    def lengths(self) -> Reals:
        """Return the length of the panel whose ellipse begins to meet each sector: λ is least at a corner."""
        return 2 * self.inner * (_R - np.cos(self.first)) / (_R * _R - 1)

    def chosen(self, which: Mask) -> Sectors:
        """Return some of the sectors.

        Args:
            which: True for those to be kept.
        """
        return Sectors(self.inner[which], self.outer[which], self.first[which], self.last[which])

    def scaled(self, by: float) -> Sectors:
        """Return sectors whose radii are multiplied."""
        return Sectors(by * self.inner, by * self.outer, self.first, self.last)

    def quartered(self) -> Sectors:
        """Return four parts of each; those of one sector stand together."""
        radius, angle = np.sqrt(self.inner) * np.sqrt(self.outer), (self.first + self.last) / 2
        inner = np.stack([self.inner, self.inner, radius, radius], axis=1).ravel()
        outer = np.stack([radius, radius, self.outer, self.outer], axis=1).ravel()
        first = np.stack([self.first, angle, self.first, angle], axis=1).ravel()
        last = np.stack([angle, self.last, angle, self.last], axis=1).ravel()
        return Sectors(inner, outer, first, last)


@lru_cache(maxsize=8)
def around(octaves: int) -> Sectors:
    """Return sectors that cover the upper half of the ellipse about [0, 1], and a core 2^octaves times smaller.

    Args:
        octaves: log₂ of how much smaller the core is.
    """
    rings = round(octaves * np.log(2) / np.log(RATIO))
    radii = (_R + 1) / 2 * RATIO ** np.arange(-rings, 1.0)
    angles = np.linspace(0, np.pi, _ANGLES + 1)
    inner, first = np.meshgrid(radii[:-1], angles[:-1], indexing="ij")
    outer, last = np.meshgrid(radii[1:], angles[1:], indexing="ij")
    parts = [np.concatenate([[head], part.ravel()]) for head, part in
             zip((0.0, radii[0], 0.0, np.pi), (inner, outer, first, last), strict=True)]  # fmt: skip
    kept = Sectors(*parts)
    return kept.chosen(kept.lengths() < 1)


def real_lengths(steps: Elementwise) -> Elementwise:
    """Return the length of the panel whose ellipse begins to meet the real place at each step.

    Args:
        steps: distances from the beginning of the panel.
    """
    return 2 * steps / (_R + 1)


def joined(x: Sectors, y: Sectors) -> Sectors:
    """Return the sectors of both.

    Args:
        x, y: sectors, those of x first.
    """
    return Sectors(*(np.concatenate([getattr(x, part), getattr(y, part)]) for part in _PARTS))
