"""Which closed path is drawn round the turning points of each of many librations.

A circle of the elliptic kind, q = m + ρ e^{iχ} + (h²/4ρ) e^{−iχ}, round m ± h, where nothing else is within some times
h; else the line χ + iη in the strip that is proved to resolve the orbit (``contour_integrals``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.contour_integrals import circle, steps, strip
from hjsolve.ensembles.engine.coordinate_of_orbits import offset
from hjsolve.ensembles.engine.kernels.path_integrals import Paths, PathTable
from hjsolve.ensembles.engine.kernels.types import Motions
from hjsolve.ensembles.engine.libration_ends import LibrationEnds
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Separated
from hjsolve.ensembles.engine.node_maps import COUNTS, node_maps
from hjsolve.ensembles.engine.programs import SystemPrograms, sides
from hjsolve.ensembles.engine.proof_of_resolution import ResolutionProof
from hjsolve.ensembles.engine.strips_of_analyticity import half_width

ATTEMPTS = 4
"""Paths tried one after the other."""
_CIRCLES = (1.0, 0.4)
"""Parts of the way to what is next, of circles; later attempts draw lines in strips."""
_STEPS_A_NODE = (2.25, 3.5)
"""Steps for each node that is proved to resolve an orbit, at the first attempt and later."""
_UNPROVED = COUNTS.index(64)
"""The size to begin with where none is proved."""
_MORE, _BLIND = 1.1, 2.0
"""By how much more nodes are taken than steps that were not enough show to be needed, and than those that show
nothing."""
_FAR = 8.0
"""How much farther away the other end of a domain is, from where on it is not looked from there."""
_NOISE = 2.0**-44
"""Relative error of F′ at a turning point, times the width over its distance from the origin."""
_FROM_END, _SMALL, _ROOMY = 0.9, 30.0, 4.0
"""How near in η a circle comes to what is next; ln of the room over the size of a small motion; and the room, over half
the width, from which on circles are drawn."""


class OnePath(NamedTuple):
    """Orbits that share the steps of their paths.

    Attributes:
        orbits: which.
        tables, paths: the steps, and where they are.
        view: the half that alone sees circles.
        proved: of which orbits the path lies in a strip that is proved to resolve them.
    """

    orbits: Integers
    tables: tuple[PathTable, ...]
    paths: Paths
    view: int
    proved: Mask


@dataclass(frozen=True)
class PlacedLibrations:
    """One coordinate of n librations; made by ``placed``.

    Attributes:
        formulas: of the lower and of the upper half.
        offsets: of the turning points in their views, shape (2, n).
        width: b − a.
        radius: of the disk about the middle in which nothing else is, as far as the turning points show.
        maps, least: the map, and the size that is proved to resolve the orbit, −1 for none.
        sizes: those of the last attempt, of strips; written by ``paths``.
    """

    formulas: tuple[LoweredFormula, LoweredFormula]
    offsets: Reals
    width: Reals
    radius: Reals
    maps: Integers
    least: Integers
    sizes: Integers

    def paths(self, left: Integers, attempt: int, known: Reals, open_: Reals) -> Iterator[OnePath]:
        """Yield the paths of some of the orbits.

        Args:
            attempt: how often they were tried before.
            known: constants and bounds on their errors, shape (n, 2 constants).
            open_: what the steps of the last attempt left open, relatively; 1 or more where that showed nothing.
        """
        part = _CIRCLES[min(attempt, len(_CIRCLES) - 1)]
        η, away = self._circles(left, part)
        # next to a small motion the integrands on a line in its strip are far larger than their means
        # a circle needs room on all sides; a line in the strip needs what was proved for the nodes
        roomy = self.radius[left] >= _ROOMY * self.width[left] / 2
        round_ = roomy & (attempt < len(_CIRCLES))
        again = left[~round_ & (attempt > np.where(roomy, len(_CIRCLES), 0))]
        self._enlarge(again, open_[again])
        size = self.sizes[left]
        circles, strips = steps(η), (_STEPS_A_NODE[min(attempt, 1)] * np.array(COUNTS)[size]).astype(np.int64)
        # seen from the nearer end of the domain, whose offset has the more digits
        view = (np.abs(self.offsets[1, left]) < np.abs(self.offsets[0, left])) & (self.formulas[1].sign < 0)
        far = np.abs(self.offsets[::-1, left]) > _FAR * (np.abs(self.offsets[:, left]) + self.width[left])
        side = np.where(far[0], 0, np.where(far[1], 1, 2))
        code = np.where(round_, -1 - 2 * circles - view, 3 * (self.maps[left] * len(COUNTS) + size) + side)
        # orbits with the same steps share a table and one call of the kernel
        order = np.argsort(code, kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(code[order])) + 1):
            if not len(group):
                continue
            own, first = left[group], group[0]
            if round_[first]:
                tables, end = circle(int(circles[first])), int(view[first])
                yield OnePath(own, tables, self._round(own, away[group], end, known[own]), end, own < 0)
            else:
                key, end = node_maps().key(int(self.maps[left[first]])), int(side[first])
                tables = strip(key, int(size[first]), int(strips[first]), end)
                yield OnePath(own, tables, self._between(own, end, known[own]), end % 2, self.least[own] >= 0)

    def _enlarge(self, some: Integers, open_: Reals) -> None:
        """Take as many nodes as the steps of the last attempt show to be needed.

        N steps at a/2 left c ~ exp(−N (b − a/2)), b being where the next singularity is, and (8c)² was claimed.
        """
        counts = np.array(COUNTS)[self.sizes[some]]
        a = np.array([half_width(n, 1) for n in counts])
        with np.errstate(all="ignore"):
            b = a / 2 - np.log(np.sqrt(open_) / 8) / (_STEPS_A_NODE[0] * counts)
            needed = np.where(open_ < 1, _MORE * counts * np.minimum(a / b, _BLIND), _BLIND * counts)
        needed = np.where(np.isfinite(needed) & (self.least[some] >= 0), needed, _BLIND * counts)
        self.sizes[some] = np.minimum(np.searchsorted(COUNTS, np.maximum(needed, counts)), len(COUNTS) - 1)

    def _circles(self, left: Integers, part: float) -> tuple[Reals, Reals]:
        """How far in η a circle is from the motion and from what is next, rounded down; and ln 2ρ/h, or −ρ."""
        h, radius = self.width[left] / 2, self.radius[left]
        with np.errstate(all="ignore"):
            # elliptic coordinates: a disk of radius R about the middle holds the ellipse cosh η = R/h with foci ±h
            farthest = np.arccosh(np.maximum(radius / h, 1 + 1e-12))
            away = part * np.maximum(farthest / 2, farthest - _FROM_END)
            away = np.where(np.isfinite(away), away, part * _SMALL)
            near = np.where(np.isfinite(farthest), np.minimum(away, farthest - away), _FROM_END)
            # rounded down to thirds of an octave: orbits with the same number of steps share a table
            η = np.clip(2.0 ** (np.floor(3 * np.log2(near)) / 3), 2.0**-6, 1.0)
            ρ = np.where(h > radius * np.exp(-_SMALL), h * np.exp(away) / 2, radius * part * np.exp(-_FROM_END))
        return η, ρ

    def _round(self, own: Integers, ρ: Reals, side: int, known: Reals) -> Paths:
        h, sign = self.width[own] / 2, float(self.formulas[side].sign)
        inward = sign if side == 0 else -sign
        middle = self.offsets[side, own] + inward * h
        # q = m + ρ e^(iχ) + (h²/4ρ) e^(−iχ): an ellipse with the turning points for its foci
        return Paths(np.stack([middle] * 2), np.ones(2), ρ, h * h / (4 * ρ), known)

    def _between(self, own: Integers, end: int, known: Reals) -> Paths:
        signs = np.array([float(self.formulas[0].sign), -float(self.formulas[1].sign)])
        W, seen = np.ascontiguousarray(self.width[own]), [end, end] if end < 2 else [0, 1]
        return Paths(np.ascontiguousarray(self.offsets[:, own][seen]), signs[seen], W, 0 * W, known)


def placed(
    coordinate: Separated, programs: SystemPrograms, k: int, places: Reals, constants: Reals
) -> PlacedLibrations:
    """Place librations between their turning points.

    Args:
        coordinate: the k-th separated one.
        places: turning points, shape (2, n).
        constants: of the motion, shape (constants, n).
    """
    formulas, codes = sides(coordinate), programs.coordinates[k].views
    offsets = np.stack([offset(f, x) for f, x in zip(formulas, places, strict=True)])
    n, width = places.shape[1], places[1] - places[0]
    signs, none = np.array([float(formulas[0].sign), -float(formulas[1].sign)]), np.zeros(n, dtype=np.int64)
    with np.errstate(all="ignore"):
        seen = (
            run_rows(view.bend, programs.parameters, np.stack([x, *constants]))
            for view, x in zip(codes, offsets, strict=True)
        )
        bends = np.stack([np.stack([slope, 0.5 * bend]) for _, slope, bend in seen])
        maps, fraction = LibrationEnds(node_maps(), bends, signs, np.zeros(n, dtype=bool)).maps(width)
    motions = Motions(
        momentum=0 * width, left=width, right=width, width=width, lower=offsets[0], upper=offsets[1], homes=offsets,
        signs=signs, known=np.zeros((n, 1)), uncertainty=np.zeros((n, 1)), first=maps, least=none, fraction=fraction,
        barrier_top=np.ones(n),
    )  # fmt: skip
    proof = ResolutionProof(node_maps(), motions, formulas[0].clearance, formulas[1].clearance)
    least = proof.least(np.arange(n), maps, np.stack([none, np.full(n, len(COUNTS))]))
    sizes = np.where(least < 0, _UNPROVED, least)
    return PlacedLibrations(formulas, offsets, width, _room(coordinate, motions, bends), maps, least, sizes)


def _room(coordinate: Separated, motions: Motions, bends: Reals) -> Reals:
    """Return the radius of the disk about the middle in which, as far as it shows, nothing but the motion is.

    Ends of the domain, what is next to the turning points by F′ and F″ there, and what is not proved to be analytic.
    """
    W, signs, h = motions.width, motions.signs, motions.width / 2
    middle, gaps = motions.lower + signs[0] * h, []
    for (first, bend), sign, x in zip(bends, signs, (motions.lower, motions.upper), strict=True):
        with np.errstate(all="ignore"):
            # W S′/S at an end is W over the distance of the zero or pole next to it
            ratio = np.abs(W * bend / (sign * first) + 1)
            beyond = W / np.maximum(ratio - _NOISE * np.abs(x) / W, 0.0)
        gaps.append(h + np.where(np.isfinite(beyond), beyond, np.inf))
    for formula, x in ((coordinate.lower, motions.lower), (coordinate.upper, motions.upper)):
        if formula is not None:
            # the end of the domain, x = 0 of this view, as seen from the middle
            gaps.append(np.abs(x) + h)
    clear = (coordinate.lower or coordinate.plain).clearance.radius(middle)
    gaps.append(np.where(clear > h, clear, np.inf))
    radius = np.minimum.reduce(gaps)
    # nothing is seen at all, as of an oscillator: any circle serves that is not much larger than its scale
    unbounded = np.maximum(4 * h, np.maximum(1.0, np.abs(middle) / 2))
    return np.where(np.isfinite(radius), radius, unbounded)
