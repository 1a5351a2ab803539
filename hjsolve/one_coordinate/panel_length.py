"""How long the next panel of an open motion may be: as long as its integrands are proved to be analytic around it.

A series through n Chebyshev points of a panel misses a function that is analytic and at most M in the ellipse of
parameter ρ about the panel by no more than 4 M ρ^(1−n)/(ρ − 1) (Trefethen, Approximation Theory and Approximation
Practice (2013), theorem 8.2). The ellipse is covered by disks (``Sectors``) and the integrands are
enclosed over them (``one_coordinate.panel_integrands``): where p² and the kernels are bounded and p² has no zero, all
integrands are analytic, and the disks bound them. Nothing can hide between the nodes, however narrow it is.

The ellipse of parameter ρ about a panel [0, s] (foci at its ends) is s times that about [0, 1]: the ellipses of all
panels that begin at one place are nested, and z lies on the edge of that with

    s = λ(z) = 2 (R |z| − Re z)/(R² − 1),   R = (ρ + 1/ρ)/2.

So the upper half plane about the place is cut into rings and sectors, finer towards it; where the integrands are
analytic over the sectors that an ellipse meets, they are so in the ellipse, by reflection in its lower half as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.number_types import Elementwise, Mask, Mpf, Reals

RHO = 5.0
"""Parameter of the ellipses: a series of degree n is right to about ρ^(−n)."""
_R = (RHO + 1 / RHO) / 2
"""The longer semiaxis of the ellipse, in half lengths of the panel."""
RATIO = 2.0**0.5
"""Of the radii of a ring."""
_ANGLES = 6
"""Sectors of a half ring: of 30°, so that one is about as long (0.52 of its radius) as it is broad (0.41,
``RATIO``)."""
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
        # the centre on the bisector that is as far from the inner as from the outer corners
        away = np.where(core, 0.0, (inner + 1) / (2 * np.cos(np.where(core, 0.0, half))))
        corner = np.sqrt(np.abs(away**2 + 1 - 2 * away * np.cos(half)))
        # the outer arc bulges beyond its corners
        radius = np.where(core, 1.0, np.maximum(corner, 1 - away))
        return Disk(self.outer * away * np.exp(1j * (self.first + half)), self.outer * radius * (1 + 1e-12))

    def lengths(self) -> Reals:
        """Return the length of the panel whose ellipse begins to meet each sector: λ is least at a corner."""
        # λ(z) with |z| and −Re z least: the inner corner next to the real axis
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
        # the geometric mean of the radii: quarters are alike at all scales
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


_OCTAVES, _DEEPEST = 12, 12
"""How many times smaller than the longest panel the core is, in powers of two, and how often that is done."""
_ROUNDS = 3
"""How often the sectors that limit a panel are quartered."""
_WORTH = 2.5
"""Sectors are quartered up to so many times the panel that the nearest one allows."""
_SHORT = 1 / 64
"""Of the way so far, or of the longest panel; where one is shorter, the surroundings are looked at with all care."""
_FRACTIONS = 0.84 ** np.arange(13)
"""Parts of the longest panel that is proved, from which the one with the fewest nodes for its length is taken."""
_MOST_NODES = 2.0
"""Nodes, over those for integrands that are no larger in the ellipse than on the panel."""
_NOTHING = 1e-290
"""A bound below this is that of an integrand which is 0: the rounding of disks."""
_LOSS = float(np.log(4 * RHO / (RHO - 1)))
"""Interpolation in n nodes errs by at most 4 M ρ^(1−n)/(ρ − 1), M being the bound on the ellipse (Trefethen 2013,
Theorem 8.2); its logarithm, but for M and ρ^(−n)."""


class Sizes(NamedTuple):
    """Bounds of the integrands over some sectors, infinite where nothing is known, and their size inside, roughly.

    Both of shape (integrands, sectors).
    """

    most: Reals
    inside: Reals


Surroundings = Callable[[Disk, bool], Sizes]
"""Disks of y − y₀ ↦ what the integrands are there; False quickly, True with all care."""


@dataclass(frozen=True)
class Reach:
    """A panel: its length, bounds of all integrands in the ellipse about it, and the nodes that are thought to do."""

    length: float
    most: Reals
    nodes: int

    def nodes_for(self, sizes: list[Mpf], digits: int) -> int:
        """Return the nodes that miss no integrand by more than 10^−(digits + 1) of its size, proved.

        Args:
            sizes: bounds on the integrands.
        """
        pairs = zip(self.most, sizes, strict=True)
        excess = max((float(np.log(most)) - float(size.context.log(size)) for most, size in pairs if size), default=0.0)
        return nodes_for(excess, digits)


def nodes_for(excess: float, digits: int) -> int:
    """Return the nodes for an error of 10^−(digits + 1), relative, where the bound is e^excess times the size.

    Args:
        excess: logarithm of the bound over the size.
    """
    return int(np.ceil((max(excess, 0.0) + _LOSS + (digits + 1) * np.log(10)) / np.log(RHO))) + 1


def longest(surroundings: Surroundings, most: float, digits: int, so_far: float = 0.0) -> Reach | None:
    """Return the panel that is worth most; None where none can be proved.

    Args:
        surroundings: of the place where the panel begins.
        most: greatest length.
        so_far: length of the way before it. Towards a near zero of p² panels shrink one after the other, each only a
            little shorter than the longest that was thought of: they are short by this measure.
    """
    for _ in range(_DEEPEST):
        found = _within(surroundings, most, digits, _SHORT * max(most, so_far))
        if found is not None:
            return found
        most *= 2.0**-_OCTAVES
    return None


def _within(surroundings: Surroundings, most: float, digits: int, short: float) -> Reach | None:
    """Return the same, not shorter than most/2^``_OCTAVES``."""
    sectors = around(_OCTAVES).scaled(most)
    sizes = surroundings(sectors.disks(), False)
    careful = False
    for turn in range(_ROUNDS + 1):
        # a sector with no bound: what lies there is not known to be analytic
        bad = ~np.all(np.isfinite(sizes.most), axis=0)
        lengths = sectors.lengths()
        # the panel whose ellipse just does not meet a bad sector
        length = float(np.min(lengths[bad], initial=most))
        if turn == _ROUNDS or length >= most:
            break
        least = most * 2.0**-_OCTAVES
        if length < short and not careful:
            careful = True
            sizes = _again(surroundings, sectors, sizes, bad & (lengths < _WORTH * short))
            continue
        if length == 0:
            break
        # only those that bound the panel, and those it would meet next
        limiting = bad & (lengths < _WORTH * max(length, least))
        parts = sectors.chosen(limiting).quartered()
        finer = surroundings(parts.disks(), careful)
        sectors = joined(sectors.chosen(~limiting), parts)
        sizes = Sizes(*(np.concatenate([a[:, ~limiting], b], axis=1) for a, b in zip(sizes, finer, strict=True)))
    return _best(sectors, sizes, length, digits) if length > 0 else None


def _again(surroundings: Surroundings, sectors: Sectors, sizes: Sizes, which: Mask) -> Sizes:
    """Return the same with all care taken over some sectors."""
    again = surroundings(sectors.chosen(which).disks(), True)
    most, inside = sizes.most.copy(), sizes.inside.copy()
    most[:, which], inside[:, which] = again.most, again.inside
    return Sizes(most, inside)


def _best(sectors: Sectors, sizes: Sizes, length: float, digits: int) -> Reach:
    """Of the panels up to a length, the one with the fewest nodes for its length."""
    order = np.argsort(sectors.lengths())
    met = sectors.lengths()[order]
    most = np.maximum.accumulate(sizes.most[:, order], axis=1)
    # sizes on the real axis, of the panel itself: sectors that touch it from above
    inside = np.maximum.accumulate(np.where(sectors.first[order] == 0, sizes.inside[:, order], 0.0), axis=1)
    steps = length * _FRACTIONS
    outer = np.searchsorted(met, steps) - 1
    inner = np.searchsorted(met, real_lengths(steps)) - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.nan_to_num(np.log(most[:, outer] / inside[:, inner]), nan=0.0, posinf=700.0, neginf=0.0)
    excess[most[:, outer] < _NOTHING] = 0.0
    nodes = np.array([nodes_for(x, digits) for x in np.max(excess, axis=0)])
    # a panel on which integrands grow much needs more nodes than two shorter ones
    costly = nodes > _MOST_NODES * nodes_for(0.0, digits)
    best = int(np.argmin(np.where(costly, 1e3, 1.0) * nodes / steps))
    return Reach(float(steps[best]), most[:, outer[best]], int(nodes[best]))
