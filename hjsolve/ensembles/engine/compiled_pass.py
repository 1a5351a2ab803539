"""The passes over librations as compiled loops, orbit by orbit (extra ``fast``).

The same mathematics as ``regions``, ``turning_points`` and ``midpoint_rule`` in doubles, with maps from ``node_maps``;
an orbit that is no libration, or not easy (a slow series, a large claimed error), is left to those. Small motions are
seen from the start, by second differences. The constants are known to 32 digits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.compiled_types import Clearances, Modes, Motions, Results, scratch
from hjsolve.ensembles.engine.constants import InitialConstants, momentum_errors
from hjsolve.ensembles.engine.lowered_solution import Model, Separated
from hjsolve.ensembles.engine.midpoint_rule import Sums, empty
from hjsolve.ensembles.engine.node_maps import COUNTS, fitting, node_maps, views
from hjsolve.ensembles.engine.nodes import EVEN, WARPS
from hjsolve.ensembles.engine.programs import Compiled, CoordinatePrograms, Loops, sides
from hjsolve.ensembles.engine.radicand_views import Knowns
from hjsolve.ensembles.engine.regions import has_slopes, offset
from hjsolve.ensembles.engine.resolution import room
from hjsolve.ensembles.engine.starts import Starts

_NOT_COVERED, _UNTOLD = -3, -2
_FIRST = 64
"""Orbits for which a table of clearances is filled before the others are looked at again."""

_NEAR = 3.0
_STRETCHED = 16.0
"""(1 + ρ_d)(1 + ρ_c) from which on nodes are stretched; below, crowded ones do as well."""

_NARROW = 0.03
_ALONG = np.linspace(-0.5, 0.5, 5)
_HELD = COUNTS.index(40)
"""Size of the tables for which a small motion gets a disk of its own."""


def begin_compiled(model: Model, made: Compiled, starts: Starts) -> InitialConstants:
    """Work out the constants to 32 digits; see ``constants.initial_constants``.

    Args:
        model: the lowered solution.
        made: its programs.
        starts: of n orbits.
    """
    starts = starts.precise()
    q, count, m = starts.q, starts.q.shape[1], len(model.constants)
    C, L, E = (np.empty((m, count)) for _ in range(3))
    P = np.empty((len(model.separated), count))
    made.start(q, starts.p, starts.low, starts.spread, C, L, E, P)
    numbers = tuple(pair.high for pair in model.numbers)
    places = q[[c.index for c in model.separated]]
    knowns = Knowns(tuple(C), tuple(E), numbers)
    return InitialConstants(places, P, starts, knowns, tuple(map(Pair, C, L)), momentum_errors(model, starts))


@dataclass(frozen=True)
class CompiledCoordinate:
    """One coordinate of n orbits.

    Attributes:
        coordinate: which.
        programs: its own.
        loops: ours.
        q, P: starts, shape (n,).
        constants, low, uncertainty: of the motion, in two doubles, shape (constants, n).
    """

    coordinate: Separated
    programs: CoordinatePrograms
    loops: Loops
    q: Reals
    P: Reals
    constants: Reals
    low: Reals
    uncertainty: Reals

    @staticmethod
    def of(model: Model, made: Compiled, start: InitialConstants, k: int) -> CompiledCoordinate:
        """Return the k-th separated one.

        Args:
            model: the lowered solution.
            made: its programs.
            start: of n orbits.
            k: row.
        """
        assert start.pairs is not None
        low = np.stack([pair.low for pair in start.pairs])
        rows = (np.stack(start.knowns.constants), low, np.stack(start.knowns.uncertainty))
        q, P = (np.ascontiguousarray(x[k]) for x in (start.q, start.P))
        return CompiledCoordinate(model.separated[k], made.coordinates[k], made.loops, q, P, *rows)

    def take(self, index: Integers) -> CompiledCoordinate:
        """Return some of the orbits.

        Args:
            index: which.
        """
        if len(index) == len(self.q):
            return self
        constants, low, uncertainty = (np.take(x, index, axis=1) for x in (self.constants, self.low, self.uncertainty))
        return replace(
            self, q=self.q[index], P=self.P[index], constants=constants, low=low, uncertainty=uncertainty
        )  # fmt: skip

    def smallness(self, *, kernels: bool) -> Reals:
        """Return the error of p² at the start over about how large p² becomes; 0 where small motions have no view.

        Args:
            kernels: whether ∂J/∂c are wanted.
        """
        found = np.zeros(len(self.q))
        if has_slopes(self.coordinate.plain):
            view, walk = self.programs.below, self._walk(0, np.ascontiguousarray(self.constants.T))
            uncertainty = np.ascontiguousarray(self.uncertainty.T)
            out = np.empty((2 + (len(self.constants) if kernels else 0), 1))
            self.loops.crests(view.bend, view.uncertainties, walk, uncertainty, found, np.empty((2, 1)), out)
        return found

    def _walk(self, upper: int, known: Reals) -> Any:
        from hjsolve.ensembles.engine.compiled_turning_points import SearchSide

        formula = sides(self.coordinate)[upper]
        side = (2.0 * upper - 1.0) * formula.sign
        origin = (self.coordinate.lower, self.coordinate.upper)[upper]
        floor = side * np.inf if origin is None else 0.0
        reach = 2 * np.pi if self.coordinate.periodic else np.inf
        return SearchSide(offset(formula, self.q), self.P, known, self.constants, floor, side, reach)

    def wide(self, modes: Modes) -> Sums:
        """Integrate motions seen from zero, or from the ends of the domain; good only where this pass was enough.

        Args:
            modes: what is wanted.
        """
        known, n = np.ascontiguousarray(self.constants.T), len(self.q)
        places, bends, work, distances = np.empty((2, n)), np.empty((2, 2, n)), np.empty((5, n)), []
        for upper, view in enumerate((self.programs.below, self.programs.above)):
            walk = self._walk(upper, known)
            self.loops.ends(view.bend, view.slopes, walk, places[upper], bends[upper], work)
            distances.append(walk.side * (places[upper] - walk.start))
        below, above = sides(self.coordinate)
        width = distances[0] + distances[1]
        even = self.coordinate.even & (np.abs(distances[0] - distances[1] - 2 * self.q) <= 1e-13 * width)
        signs = np.array([float(below.sign), -float(above.sign)])
        nearby, slopes = _nearby(width, bends, signs), (bends[0, 0], bends[1, 0])
        first, share = _maps(nearby, slopes, even)
        motions = Motions(
            momentum=self.P, left=distances[0], right=distances[1], width=width, lower=places[0], upper=places[1],
            signs=signs, known=known, uncertainty=np.ascontiguousarray(self.uncertainty.T), first=first,
            least=np.zeros(n, dtype=np.int64), share=share,
        )  # fmt: skip
        sums = self._resolved(motions, modes)
        again = np.flatnonzero(~sums.good & (width > 0) & ~even)
        if len(again):  # a zero and a pole beyond an end may hide each other: both ends as if they were like the worse
            largest = np.maximum(*nearby)[again]
            first, share = _maps((largest, largest), (slopes[0][again], slopes[1][again]), even[again])
            sums.put(again, self._resolved(_taken(motions, again)._replace(first=first, share=share), modes))
        return sums

    def _resolved(self, motions: Motions, modes: Modes) -> Sums:
        """Integrate with as many nodes as are proved to resolve every motion."""
        below, above = sides(self.coordinate)
        proof, n = _Proof(self.loops, motions, below.clearance, above.clearance), len(motions.width)
        span = np.stack([np.zeros(n, dtype=np.int64), np.full(n, len(COUNTS))])
        least = proof.least(np.arange(n), motions.first, span)
        if modes.oscillations:  # coefficients as they are, not nearly squared: never enough, of stretched maps by far
            most = len(COUNTS) - 1
            least = np.where(least < 0, least, np.minimum(least + np.where(motions.first < len(WARPS), 1, 2), most))
        motions.least[:] = least
        sums, chosen = self._integrated(motions, modes, (self.programs.below, self.programs.above))
        crowded = np.flatnonzero(sums.good & (chosen[1] != motions.first))
        if len(crowded):
            size, map_ = chosen[:, crowded]
            sums.good[crowded] = proof.least(crowded, map_, np.stack([size, size + 1])) >= 0
        return sums

    def _integrated(self, motions: Motions, modes: Modes, programs: tuple[Any, Any]) -> tuple[Sums, Integers]:
        (below, above), tables = programs, node_maps().tables
        rows = len(self.constants) if modes.kernels else 0
        modes = modes._replace(alike=below.uncertainties is above.uncertainties)
        sums = empty(len(self.constants), len(motions.width))
        chosen = np.zeros((2, len(motions.width)), dtype=np.int64)
        results = Results(
            sums.action, sums.action_error, sums.means, sums.mean_errors, sums.oscillations, sums.oscillation_errors,
            sums.phase, sums.phase_error, sums.speeds, sums.good, chosen,
        )  # fmt: skip
        self.loops.integrals(
            below.fill, above.fill, below.uncertainties, above.uncertainties, below.relative, above.relative, motions,
            tables, modes, results, scratch(tables, rows), np.zeros(len(self.constants)),
        )  # fmt: skip
        return sums, chosen

    def small(self, modes: Modes) -> Sums:
        """Integrate motions about a maximum of p² that is deep beside them.

        Args:
            modes: what is wanted.
        """
        n, made, plain = len(self.q), self.programs.small(), self.coordinate.plain
        first = np.empty(n)
        made.slope(self.q, np.concatenate([self.constants, self.low]), first)
        rows = [*self.constants, self.q, self.P**2, first, 0 * self.q, 0 * self.q]
        known = np.ascontiguousarray(np.stack(rows, axis=1))
        uncertainty = np.ascontiguousarray(self.uncertainty.T)
        floors = np.stack([np.full(n, -np.inf), np.full(n, np.inf)])
        for k, formula in enumerate((self.coordinate.lower, self.coordinate.upper)):
            if formula is not None:
                floors[k] = -formula.sign * offset(formula, self.q)
        places, work = np.empty((2, n)), (np.empty(3), np.empty((2, 3)))
        self.loops.small_ends(made.value, made.bounds, known, uncertainty, floors, places, *work)
        low, high = places
        width = high - low
        with np.errstate(invalid="ignore"):
            least = _least_at_a_glance(plain.clearance, tuple(self.constants), self.q + 0.5 * (low + high), width)
        motions = Motions(
            momentum=self.P, left=-low, right=high, width=width, lower=low, upper=high, signs=np.array([1.0, -1.0]),
            known=known, uncertainty=uncertainty, first=np.zeros(n, dtype=np.int64), least=least,
            share=np.zeros(n, dtype=np.int64),
        )  # fmt: skip
        some = np.flatnonzero((least < 0) & (width > 0))
        if len(some):
            placed = motions._replace(lower=self.q + low, upper=self.q + high)
            span = np.stack([np.zeros(len(some), dtype=np.int64), np.full(len(some), len(COUNTS))])
            proof = _Proof(self.loops, placed, plain.clearance, plain.clearance)
            least[some] = proof.least(some, motions.first[some], span)
        return self._integrated(motions, modes, (made, made))[0]


def _least_at_a_glance(clearance: Clearance, constants: tuple[Reals, ...], middle: Reals, width: Reals) -> Integers:
    """The first size that one disk about the middle of a motion proves to be enough, −1 for none."""
    known = np.nan_to_num(room(clearance, middle, width), nan=-1.0)
    enough = node_maps().strips.enough[0]
    least = np.searchsorted(-enough, -known)
    some = np.flatnonzero((least > _HELD) & (width < _NARROW * np.abs(middle)))
    if len(some):  # cells are too large for it
        x, W = middle[some, None], width[some, None]
        chosen = tuple(c[some] for c in constants)
        held = clearance.holds(chosen, x, 0.5 * enough[_HELD] * W, x + W * _ALONG)
        least[some[held]] = _HELD
    least[least == len(COUNTS)] = -1
    return least


def _nearby(width: Reals, bends: Reals, signs: Reals) -> tuple[Reals, Reals]:
    """1 + ρ_d and 1 + ρ_c: W·|S′/S| at an end is W over the distance of the zero or pole next to it."""
    found = []
    with np.errstate(all="ignore"):
        for (first, bend), sign in zip(bends, signs, strict=True):
            ρ = np.abs(width * bend / (sign * first) + 1)
            found.append(1 + np.where(np.isfinite(ρ) & (ρ > _NEAR), ρ, 0.0))
    lower, upper = found
    return lower, upper


def _maps(nearby: tuple[Reals, Reals], slopes: tuple[Reals, Reals], even: Mask) -> tuple[Integers, Integers]:
    """The maps of some motions, and how much is seen from below."""
    lower, upper = nearby
    stretched = np.where(even, np.maximum(lower, upper) ** 2, lower * upper) >= _STRETCHED
    index = np.where(even, EVEN, 0)
    some = np.flatnonzero(stretched)
    if len(some):
        index[some] = node_maps().index(fitting(lower[some], upper[some], even[some]))
    with np.errstate(all="ignore"):
        share = np.where(~even, views(*slopes, nearby), 0)
    return index, share


def _taken(motions: Motions, index: Integers) -> Motions:
    arrays = {name: getattr(motions, name)[index] for name in motions._fields if name != "signs"}
    return Motions(**arrays, signs=motions.signs)


def librations(orbits: CompiledCoordinate, small: Mask, modes: Modes) -> Sums:
    """Integrate one coordinate of many orbits.

    Args:
        orbits: what is known of them.
        small: True where the motion is seen from the start.
        modes: what is wanted; ``chords``, ``shifts`` and ``alike`` are not looked at.

    Returns:
        The sums, good only where this pass was enough.
    """
    sums = empty(len(orbits.constants), len(orbits.q))
    narrow = np.flatnonzero(small)
    if len(narrow):
        sums.put(narrow, orbits.take(narrow).small(modes._replace(chords=modes.kernels, shifts=False)))
    wide = np.flatnonzero(~sums.good)
    if len(wide):
        some = orbits.take(wide)
        chords = some.programs.below.chords and some.programs.above.chords
        sums.put(wide, some.wide(modes._replace(chords=chords, shifts=True)))
    return sums


@dataclass(frozen=True)
class _Proof:
    """How many nodes resolve motions between turning points, by glances at the tables of clearances.

    Attributes:
        loops: ours.
        motions: of n orbits.
        below, above: clearances in the views of the lower and of the upper half.
    """

    loops: Loops
    motions: Motions
    below: Clearance
    above: Clearance

    def least(self, left: Integers, maps: Integers, span: Integers) -> Integers:
        """The first size that is proved to resolve some orbits, −1 for none; the tables grow until they tell for all.

        Args:
            left: which orbits.
            maps: how their nodes are placed.
            span: the sizes to look at, first and end, shape (2, len(left)).
        """
        least = np.full(len(left), -1, dtype=np.int64)
        if self.below.table() is None or self.above.table() is None:
            return least
        lower, W = self.motions.lower[left], self.motions.width[left]
        known = room(self.below, lower + 0.5 * self.motions.signs[0] * W, W)
        todo, block = np.flatnonzero(W > 0), _FIRST
        while len(todo):
            found, part = np.empty(len(todo), dtype=np.int64), np.ascontiguousarray(span[:, todo])
            some = self._taken(left[todo], maps[todo])
            low, high = (Clearances(*side.table()) for side in (self.below, self.above))  # type: ignore[misc]
            self.loops.glances(some, known[todo], part, node_maps().strips, low, high, found)
            least[todo], span[0, todo] = found, part[0]
            bare = found == _NOT_COVERED
            for map_, size in set(zip(some.first[bare].tolist(), part[0, bare].tolist(), strict=True)):
                node_maps().cover(map_, size)
            untold = todo[found == _UNTOLD][:block]
            self._fill(left[untold], maps[untold], span[0, untold])
            todo = todo[(found == _UNTOLD) | (found == _NOT_COVERED)]
            block *= 4
        return least

    def _taken(self, index: Integers, maps: Integers) -> Motions:
        all_ = self.motions
        others = {"signs", "first", "known", "uncertainty"}
        arrays = {name: getattr(all_, name)[index] for name in all_._fields if name not in others}
        return Motions(**arrays, signs=all_.signs, first=maps, known=all_.known[:0], uncertainty=all_.uncertainty[:0])

    def _fill(self, some: Integers, maps: Integers, sizes: Integers) -> None:
        """Complete the tables for some orbits."""
        strips, motions = node_maps().strips, self.motions
        codes = maps * len(COUNTS) + sizes
        for code in np.unique(codes):
            part = some[codes == code]
            count, below, start = strips.counts[:, code // len(COUNTS), code % len(COUNTS)]
            window, W = slice(start, start + count), motions.width[part, None]
            z = strips.along[window] + 1j * strips.away[window]
            self.below.radius(motions.lower[part, None] + W * _seen(z[:below], motions.signs[0]))
            if below < count:
                self.above.radius(motions.upper[part, None] + W * _seen(z[below:], motions.signs[1]))


def _seen(z: Any, sign: float) -> Any:
    return sign * z.real + 1j * z.imag
