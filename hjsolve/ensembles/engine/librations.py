"""One coordinate of many librations: turning points, numbers of nodes, integrals, by kernels over blocks of orbits.

Where p² keeps its digits decides how a motion is seen: from the start, by second differences, where the amplitude is
small; else from zero or from the ends of the domain; and with p² to 32 digits where doubles do not know it well.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, two_sum
from hjsolve.arithmetic.machine.rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.constants import InitialConstants, momentum_errors
from hjsolve.ensembles.engine.kernels import types
from hjsolve.ensembles.engine.kernels.integrals import integrals
from hjsolve.ensembles.engine.kernels.small_motions import small_ends
from hjsolve.ensembles.engine.kernels.turning_points import Lanes, SearchSide, smallness, turning_points
from hjsolve.ensembles.engine.kernels.types import Modes, Motions, Results
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.midpoint_rule import Sums, empty
from hjsolve.ensembles.engine.node_maps import COUNTS, NodeMaps, fitting, node_maps, views
from hjsolve.ensembles.engine.nodes import EVEN, WARPS
from hjsolve.ensembles.engine.programs import (
    CoordinatePrograms,
    ExactPrograms,
    SmallPrograms,
    SystemPrograms,
    ViewPrograms,
    has_slopes,
    sides,
)
from hjsolve.ensembles.engine.proof_of_resolution import ResolutionProof, least_at_a_glance
from hjsolve.ensembles.engine.radicand_views import Knowns
from hjsolve.ensembles.engine.regions import offset
from hjsolve.ensembles.engine.starts import Starts

_SEARCHING = 72
"""Lanes of searches."""

_NEAR = 3.0
_STRETCHED = 16.0
"""(1 + ρ_d)(1 + ρ_c) from which on nodes are stretched; below, crowded ones do as well."""

_NEWTON = 4
_STANDING = 2.0**-60
"""Last step of Newton's method, over the distance of the zero of p² next to it, with which a turning point is known.

What is left of it does as many times that to an integral as there are nodes.
"""

_SMALL = 5e-13
"""Relative errors up to which an integral stays as it is, where others are made better."""


def begin(model: Model, programs: SystemPrograms, starts: Starts) -> InitialConstants:
    """Work out the constants to 32 digits; see ``constants.initial_constants``.

    Args:
        model: the lowered solution.
        programs: of the system.
        starts: of n orbits.
    """
    starts = starts.precise()
    m, given = len(model.constants), np.concatenate([starts.q, starts.p, starts.low, starts.spread])
    C, L, E, P = np.split(run_rows(programs.start, programs.parameters, given), [m, 2 * m, 3 * m])
    numbers = tuple(pair.high for pair in model.numbers)
    places = starts.q[[c.index for c in model.separated]]
    knowns = Knowns(tuple(C), tuple(E), numbers)
    return InitialConstants(places, P, starts, knowns, tuple(map(Pair, C, L)), momentum_errors(model, starts))


@dataclass(frozen=True)
class CoordinateOfOrbits:
    """One coordinate of n orbits.

    Attributes:
        coordinate: which.
        programs: its own.
        parameters: of the programs.
        maps: of nodes; every index of a map is a place in these.
        q, P: starts, shape (n,).
        constants, low, uncertainty: of the motion, in two doubles, shape (constants, n).
    """

    coordinate: Separated
    programs: CoordinatePrograms
    parameters: tuple[float, ...]
    maps: NodeMaps
    q: Reals
    P: Reals
    constants: Reals
    low: Reals
    uncertainty: Reals

    @staticmethod
    def of(model: Model, programs: SystemPrograms, start: InitialConstants, k: int) -> CoordinateOfOrbits:
        """Return the k-th separated one.

        Args:
            model: the lowered solution.
            programs: of the system.
            start: of n orbits.
            k: row.
        """
        assert start.pairs is not None
        low = np.stack([pair.low for pair in start.pairs])
        rows = (np.stack(start.knowns.constants), low, np.stack(start.knowns.uncertainty))
        q, P = (np.ascontiguousarray(x[k]) for x in (start.q, start.P))
        known = programs.coordinates[k], programs.parameters
        return CoordinateOfOrbits(model.separated[k], *known, node_maps(), q, P, *rows)

    def take(self, index: Integers) -> CoordinateOfOrbits:
        """Return some of the orbits.

        Args:
            index: which.
        """
        if len(index) == len(self.q):
            return self
        constants, low, uncertainty = (np.take(x, index, axis=1) for x in (self.constants, self.low, self.uncertainty))
        q, P = self.q[index], self.P[index]
        return replace(self, q=q, P=P, constants=constants, low=low, uncertainty=uncertainty)

    def smallness(self) -> Reals:
        """Return the error of p² at the start over about how large p² becomes; 0 where small motions have no view."""
        found = np.zeros(len(self.q))
        if has_slopes(self.coordinate.plain):
            view = self.programs.views[0]
            bend, errors = (code.program(_SEARCHING, self.parameters) for code in (view.bend, view.errors))
            smallness(bend, errors, self._walk(0), self.uncertainty, found)
        return found

    def _walk(self, upper: int) -> SearchSide:
        formula = sides(self.coordinate)[upper]
        side = (2.0 * upper - 1.0) * formula.sign
        origin = (self.coordinate.lower, self.coordinate.upper)[upper]
        floor = side * np.inf if origin is None else 0.0
        reach = 2 * np.pi if self.coordinate.periodic else np.inf
        return SearchSide(np.ascontiguousarray(offset(formula, self.q)), self.P, self.constants, floor, side, reach)

    def wide(self, modes: Modes) -> Sums:
        """Integrate motions seen from zero, or from the ends of the domain; good only where this was enough.

        Args:
            modes: what is wanted.
        """
        motions, ends = self._between()
        below, above = self.programs.views
        sums = self._resolved(motions, motions, modes, (below, above))
        again = np.flatnonzero(~sums.good & (motions.width > 0) & ~ends.even)
        if len(again):  # a zero and a pole beyond an end may hide each other: both ends as if they were like the worse
            first, share = ends.take(again).maps(motions.width[again], alike=True)
            part = _taken(motions, again)._replace(first=first, share=share)
            sums.put(again, self._resolved(part, part, modes, (below, above)))
        return sums

    def exactly(self, modes: Modes) -> Sums:
        """Integrate the same with p² to 32 digits, next to turning points to 32 digits: for close zeros of p².

        Args:
            modes: what is wanted; ``chords`` and ``shifts`` are not looked at.
        """
        placed, ends = self._between()
        programs, C = self.programs.exact, np.concatenate([self.constants, self.low])
        bases, distances, bends = [], [], ends.bends.copy()
        for k, (formula, x) in enumerate(zip(sides(self.coordinate), (placed.lower, placed.upper), strict=True)):
            base, slope, step = self._refined(k, x, C)
            s, e = two_sum(self.q, -formula.origin.high)
            here = Pair(formula.sign * s, formula.sign * (e - formula.origin.low))
            with np.errstate(invalid="ignore"):
                scale = np.fmin(placed.width, np.abs(slope / bends[k, 1]))
                known = (np.abs(step) <= _STANDING * scale) & (slope * bends[k, 0] > 0)
                distances.append(np.where(known, np.abs(DoubleDouble().sub(here, base).high), np.nan))
            bases += [base.high, base.low]
            bends[k, 0] = slope
        left, right = distances
        first, _ = ends._replace(bends=bends).maps(left + right)
        share = np.zeros_like(first)  # turning points to 32 digits leave nothing to be lost far from them
        lost = np.maximum(self.uncertainty - np.abs(self.low), 0.0) * 2.0**44  # by doubles, of the constants
        motions = placed._replace(
            left=left, right=right, width=left + right, lower=0.0 * left, upper=0.0 * right,
            homes=np.zeros((2, len(left))), first=first, share=share,
            known=np.ascontiguousarray(np.stack([*C, *bases], axis=1)),
            uncertainty=np.ascontiguousarray((self.uncertainty + lost).T),
        )  # fmt: skip
        placed = placed._replace(width=motions.width, first=first, share=share)
        return self._resolved(motions, placed, modes._replace(chords=False, shifts=False), programs)

    def _refined(self, side: int, x: Reals, C: Reals) -> tuple[Pair, Reals, Reals]:
        """Turning points to 32 digits by Newton's method with F′ in doubles, F′ there, and the last step."""
        slopes, squares = self.programs.views[side].slopes, self.programs.exact[side].squares
        with np.errstate(all="ignore"):
            _, slope = run_rows(slopes, self.parameters, np.stack([x, *self.constants]))
            base = Pair(x, 0.0 * x)
            for _ in range(_NEWTON):
                (f,) = run_rows(squares, self.parameters, np.stack([*base, *C]))
                step = f / slope
                base = DoubleDouble().sub(base, Pair(step, 0.0 * step))
                _, slope = run_rows(slopes, self.parameters, np.stack([base.high, *self.constants]))
        return base, slope, step

    def _between(self) -> tuple[Motions, _Ends]:
        """The motions between their turning points, in doubles."""
        n = len(self.q)
        places, bends, distances = np.empty((2, n)), np.empty((2, 2, n)), []
        lanes = Lanes(np.zeros((5, _SEARCHING), dtype=np.int64), np.empty((4, _SEARCHING)), np.empty((3, n)))
        for upper, view in enumerate(self.programs.views):
            walk = self._walk(upper)
            bend, slopes = (code.program(_SEARCHING, self.parameters) for code in (view.bend, view.slopes))
            turning_points(bend, slopes, walk, places[upper], bends[upper], lanes)
            distances.append(walk.side * (places[upper] - walk.start))
        below, above = sides(self.coordinate)
        width = distances[0] + distances[1]
        even = self.coordinate.even & (np.abs(distances[0] - distances[1] - 2 * self.q) <= 1e-13 * width)
        ends = _Ends(self.maps, bends, np.array([float(below.sign), -float(above.sign)]), even)
        first, share = ends.maps(width)
        homes = np.stack([_home(below, places[0], above, places[1]), _home(above, places[1], below, places[0])])
        motions = Motions(
            momentum=self.P, left=distances[0], right=distances[1], width=width, lower=places[0], upper=places[1],
            homes=homes, signs=ends.signs, known=np.ascontiguousarray(self.constants.T),
            uncertainty=np.ascontiguousarray(self.uncertainty.T), first=first, least=np.zeros(n, dtype=np.int64),
            share=share,
        )  # fmt: skip
        return motions, ends

    def _resolved(self, motions: Motions, placed: Motions, modes: Modes, programs: _Halves) -> Sums:
        """Integrate with as many nodes as are proved to resolve every motion, which lies where ``placed`` says."""
        below, above = sides(self.coordinate)
        proof, n = ResolutionProof(self.maps, placed, below.clearance, above.clearance), len(motions.width)
        span = np.stack([np.zeros(n, dtype=np.int64), np.full(n, len(COUNTS))])
        least = proof.least(np.arange(n), motions.first, span)
        if modes.oscillations:  # coefficients as they are, not nearly squared: never enough, of stretched maps by far
            most = len(COUNTS) - 1
            least = np.where(least < 0, least, np.minimum(least + np.where(motions.first < len(WARPS), 1, 2), most))
        motions.least[:] = least
        sums, chosen = self._integrated(motions, modes, programs)
        crowded = np.flatnonzero(sums.good & (chosen[1] != motions.first))
        if len(crowded):
            size, map_ = chosen[:, crowded]
            sums.good[crowded] = proof.least(crowded, map_, np.stack([size, size + 1])) >= 0
        return sums

    def _integrated(self, motions: Motions, modes: Modes, programs: _Halves) -> tuple[Sums, Integers]:
        tables, m = self.maps.tables, len(self.constants)
        sums = empty(m, len(motions.width))
        chosen = np.zeros((2, len(motions.width)), dtype=np.int64)
        results = Results(
            sums.action, sums.action_error, sums.means, sums.mean_errors, sums.oscillations, sums.oscillation_errors,
            sums.phase, sums.phase_error, sums.speeds, sums.good, chosen,
        )  # fmt: skip
        below, above = (types.side(p.fill, p.errors, p.relative, tables, self.parameters) for p in programs)
        work = types.scratch(tables, m if modes.kernels else 0)
        integrals(below, above, motions, tables, modes, results, work, np.zeros(m))
        return sums, chosen

    def small(self, modes: Modes) -> Sums:
        """Integrate motions about a maximum of p² that is deep beside them.

        Args:
            modes: what is wanted.
        """
        n, made, plain = len(self.q), self.programs.small, self.coordinate.plain
        (first,) = run_rows(made.slope, self.parameters, np.stack([self.q, *self.constants, *self.low]))
        known = np.stack([*self.constants, self.q, self.P**2, first, 0 * self.q, 0 * self.q])
        floors = np.stack([np.full(n, -np.inf), np.full(n, np.inf)])
        for k, formula in enumerate((self.coordinate.lower, self.coordinate.upper)):
            if formula is not None:
                floors[k] = -formula.sign * offset(formula, self.q)
        places, work = np.empty((2, n)), (np.empty((7, _SEARCHING)), np.zeros(_SEARCHING, dtype=np.int64))
        value, bounds = (code.program(_SEARCHING, self.parameters) for code in (made.value, made.bounds))
        small_ends(value, bounds, known, self.uncertainty, floors, places, *work)
        low, high = places
        width = high - low
        with np.errstate(invalid="ignore"):
            middle, known_here = self.q + 0.5 * (low + high), tuple(self.constants)
            least = least_at_a_glance(self.maps, plain.clearance, known_here, middle, width)
        motions = Motions(
            momentum=self.P, left=-low, right=high, width=width, lower=low, upper=high, homes=places,
            signs=np.array([1.0, -1.0]), known=np.ascontiguousarray(known.T),
            uncertainty=np.ascontiguousarray(self.uncertainty.T), first=np.zeros(n, dtype=np.int64), least=least,
            share=np.zeros(n, dtype=np.int64),
        )  # fmt: skip
        some = np.flatnonzero((least < 0) & (width > 0))
        if len(some):
            placed = motions._replace(lower=self.q + low, upper=self.q + high)
            span = np.stack([np.zeros(len(some), dtype=np.int64), np.full(len(some), len(COUNTS))])
            proof = ResolutionProof(self.maps, placed, plain.clearance, plain.clearance)
            least[some] = proof.least(some, motions.first[some], span)
        return self._integrated(motions, modes, (made, made))[0]


_Halves = tuple[ViewPrograms | SmallPrograms | ExactPrograms, ViewPrograms | SmallPrograms | ExactPrograms]


class _Ends(NamedTuple):
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

    def take(self, index: Integers) -> _Ends:
        return self._replace(bends=self.bends[..., index], even=self.even[index])

    def maps(self, width: Reals, *, alike: bool = False) -> tuple[Integers, Integers]:
        """The maps of the motions, and how much is seen from below; ``alike``: both ends as if like the worse one."""
        found = []
        with np.errstate(all="ignore"):
            for (first, bend), sign in zip(self.bends, self.signs, strict=True):
                # W·|S′/S| at an end is W over the distance of the zero or pole next to it: 1 + ρ_d and 1 + ρ_c
                ρ = np.abs(width * bend / (sign * first) + 1)
                found.append(1 + np.where(np.isfinite(ρ) & (ρ > _NEAR), ρ, 0.0))
            lower, upper = (np.maximum(*found),) * 2 if alike else found
            stretched = np.where(self.even, np.maximum(lower, upper) ** 2, lower * upper) >= _STRETCHED
            index = np.where(self.even, EVEN, 0)
            some = np.flatnonzero(stretched)
            if len(some):
                index[some] = self.known.index(fitting(lower[some], upper[some], self.even[some]))
            share = np.where(~self.even, views(self.bends[0, 0], self.bends[1, 0], (lower, upper)), 0)
        return index, share


def _taken(motions: Motions, index: Integers) -> Motions:
    arrays = {name: getattr(motions, name)[index] for name in motions._fields if name not in {"signs", "homes"}}
    return Motions(**arrays, signs=motions.signs, homes=np.ascontiguousarray(motions.homes[:, index]))


def _home(view: LoweredFormula, own: Reals, other: LoweredFormula, far: Reals) -> Reals:
    """That turning point, as an offset in a view, from which places keep their digits: the one nearer to x = 0.

    Args:
        view, own: of the turning point from which p² is seen there.
        other, far: of the other one.
    """
    moved = DoubleDouble().sub(other.origin, view.origin).high
    found = view.sign * (moved + other.sign * far)
    return np.where((np.abs(found) < np.abs(own)) & (np.abs(moved) <= np.abs(found)), found, own)


def librations(orbits: CoordinateOfOrbits, small: Mask, modes: Modes, *, exact: bool) -> Sums:
    """Integrate one coordinate of many orbits.

    Args:
        orbits: what is known of them.
        small: True where the motion is seen from the start.
        modes: what is wanted; ``chords`` and ``shifts`` are not looked at.
        exact: whether those whose errors are not small get p² to 32 digits.

    Returns:
        The sums, good only where this was enough.
    """
    sums = empty(len(orbits.constants), len(orbits.q))
    narrow = np.flatnonzero(small)
    if len(narrow):
        sums.put(narrow, orbits.take(narrow).small(modes._replace(chords=modes.kernels, shifts=False)))
    wide = np.flatnonzero(~sums.good)
    if len(wide):
        some = orbits.take(wide)
        chords = all(view.relative is not None for view in some.programs.views)
        sums.put(wide, some.wide(modes._replace(chords=chords, shifts=True)))
    rough = np.flatnonzero(sums.good & _rough(sums, modes)) if exact else wide[:0]
    if len(rough):
        better = orbits.take(rough).exactly(modes)
        fine = np.flatnonzero(better.good)
        sums.put(rough[fine], better.take(fine))
    return sums


def _rough(sums: Sums, modes: Modes) -> Mask:
    """Tell which errors are not small."""
    found: Mask = sums.action_error > _SMALL * np.abs(sums.action)
    return found | ((sums.mean_errors > _SMALL * np.abs(sums.means)).any(axis=0) if modes.kernels else False)
