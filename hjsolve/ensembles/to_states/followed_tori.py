"""Rough J, ∂J/∂c and θ of tori whose turning points are next to known ones: what the searches for tori and phases use.

No coordinate rests. Where a motion is so narrow that p² in doubles has few digits, p² is from 32 digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset_in_pairs, place, squares
from hjsolve.ensembles.engine.kernels import types
from hjsolve.ensembles.engine.kernels.crowding import CLUSTERINGS
from hjsolve.ensembles.engine.kernels.followed_librations import (
    PhaseScratch,
    RunningSeries,
    angles_of_series,
    begun_series,
    phases_of_series,
    rough_integrals,
)
from hjsolve.ensembles.engine.kernels.types import Motions
from hjsolve.ensembles.engine.librating import APPROXIMATE_SIZES, home, sides_of
from hjsolve.ensembles.engine.libration_ends import LibrationEnds
from hjsolve.ensembles.engine.maps_of_turns import turn_maps
from hjsolve.ensembles.engine.node_maps import COUNTS, node_maps
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.engine.rotating import going_round, rough_series
from hjsolve.ensembles.to_states.places_on_tori import Frames, changed, ends_of, width_of
from hjsolve.ensembles.to_states.tori import AngleTask, Tori, coordinate_at, kernels, summits

_NOISY = 1e-9
"""Error of p² in doubles next to a turning point, over the width and the slope, from which on it is from 32 digits."""
_PAIRS = 6
"""Steps for the turning points of narrow motions."""
_EVEN = 1e-13
"""How far from zero the middle of an even motion may lie, over its width: by rounding."""
_NODES = max(COUNTS[size] for size in APPROXIMATE_SIZES)
_NODES_OF_TURNS = 128
"""Of a whole turn, at most: a rotation that needs more is left to the engine."""


class FollowedTori(NamedTuple):
    """Librations and rotations of n tori.

    Attributes:
        action: J, shape (separated, n).
        bases: turning points in two doubles, shape (separated, 4, n), as ``Frames`` have them.
        widths: between them, shape (separated, n).
        harmonic: where J is that of the harmonic libration, p² having a maximum below zero; the same shape.
        series: ∂J/∂c and the running integrals; without coefficients where they are not wanted.
        good: where all of it is known, shape (n,).
    """

    action: Reals
    bases: Reals
    widths: Reals
    harmonic: Mask
    series: RunningSeries
    good: Mask


def followed(
    task: AngleTask, tori: Tori, *, series: bool, still: bool = False, turning: Reals | None = None
) -> FollowedTori:
    """Return the integrals of tori whose ``ends`` are turning points next to their own.

    Args:
        series: whether running integrals are wanted.
        still: whether these are their own, to 32 digits.
        turning: ±1 for a coordinate that goes round, 0 for librations, shape (separated, n); None for librations
            alone. Its slow places are looked for.
    """
    (size, n), m = tori.q.shape, len(task.model.constants)
    turning = np.zeros((size, n)) if turning is None else turning
    nodes = (_NODES_OF_TURNS if turning.any() else _NODES) if series else 0
    maps, sizes = np.zeros((2, size, n), dtype=np.int64)
    series_ = RunningSeries(
        np.full((size, m, n), np.nan), np.empty((size, n, m, nodes)), maps, sizes, np.full((size, 3 + m, n), np.nan)
    )
    made = FollowedTori(
        np.full((size, n), np.nan), tori.ends.copy(), np.zeros((size, n)), np.zeros((size, n), dtype=bool), series_,
        np.ones(n, dtype=bool),
    )  # fmt: skip
    for k in range(size):
        if turning[k].any():
            _turn(made, task, tori, k, turning[k])
            continue
        W, one = width_of(task, k, tori.ends[k]), coordinate_at(*task, tori, k)
        exactly = _narrow(one, tori.ends[k], W)
        own = W > 0
        if not still:
            made.bases[k], W, own, made.harmonic[k] = _ends(
                task, tori, k, (W, exactly), (made.action[k], made.series.means[k])
            )
        made.widths[k] = W
        made.good[:] &= own | made.harmonic[k]
        for to_32_digits in (False, True):
            _fill(made, one, k, np.flatnonzero(made.good & own & (exactly == to_32_digits)), exactly=to_32_digits)
    return made


def _turn(made: FollowedTori, task: AngleTask, tori: Tori, k: int, directions: Reals) -> None:
    """Integrate one coordinate of all orbits, which goes round."""
    one, series, n = coordinate_at(*task, tori, k, directions), made.series, len(directions)
    going = going_round(one)
    coefficients = np.empty((len(going.orbits), *series.coefficients.shape[2:]))
    sums = rough_series(one.take(going.orbits), going.slow, coefficients)
    fine = np.flatnonzero(sums.good)
    some, slow, sums = going.orbits[fine], going.slow.take(fine), sums.take(fine)
    made.good[:] &= np.bincount(some, minlength=n) > 0
    made.action[k, some], series.means[k][:, some] = sums.action, sums.means
    series.coefficients[k][some] = coefficients[fine]
    series.size[k, some], series.map[k, some] = sums.chosen
    own = directions[some]
    series.turns[k, 0, some], series.turns[k, 1, some] = own * slow.centre, slow.ratio
    begun_series(series, some, own * slow.opposite, k, turn_maps().tables, np.empty((4, _NODES_OF_TURNS)))


def _fill(made: FollowedTori, one: CoordinateOfOrbits, k: int, some: Integers, *, exactly: bool) -> None:
    """Integrate one coordinate of some orbits between their turning points."""
    if not len(some):
        return
    (_, m, n), series = made.series.means.shape, made.series
    everything = len(some) == n
    own, bases, W = one.take(some), made.bases[k][:, some], made.widths[k, some]
    motions = _between(own, bases, W, exactly=exactly)
    J, slopes, fine = np.empty(len(some)), np.empty((m, len(some))), np.zeros(len(some), dtype=bool)
    coefficients = series.coefficients[k] if everything else np.empty((len(some), *series.coefficients.shape[2:]))
    _integrate(own, motions, (J, slopes, coefficients, fine), exactly=exactly)
    made.action[k, some], series.means[k][:, some], made.good[some] = J, slopes, fine
    series.map[k, some], series.size[k, some] = motions.first, motions.least
    if not everything:
        series.coefficients[k][some] = coefficients


def followed_at(task: AngleTask, tori: Tori, frames: Frames) -> FollowedTori:
    """Return the running integrals of tori whose turning points are known; none of those with a rest.

    Args:
        frames: with these turning points.
    """
    plain = frames.good & ~frames.resting.any(axis=0)
    ends = np.where(plain, frames.bases, np.nan)
    found = followed(task, tori._replace(ends=ends), series=True, still=True, turning=turning_of(frames))
    return found._replace(good=found.good & plain)


def turning_of(frames: Frames) -> Reals:
    """Return ±1 where coordinates go round, 0 where they librate.

    Args:
        frames: between what they move.
    """
    return np.where(frames.rotating, frames.directions, 0.0)


def _narrow(one: CoordinateOfOrbits, bases: Reals, W: Reals) -> Mask:
    """Tell which motions are so narrow that p² in doubles has few digits."""
    view, x = one.programs.views[0], bases[0]
    with np.errstate(all="ignore"):
        given = np.stack([x, EPS * np.abs(x), 0.0 * x, *one.constants, *one.uncertainty])
        noise = run_rows(view.errors, one.parameters, given)[0]
        slope = run_rows(view.slopes, one.parameters, np.stack([x, *one.constants]))[1]
        return np.asarray(noise > _NOISY * np.abs(slope) * W)


def _ends(
    task: AngleTask, tori: Tori, k: int, known: tuple[Reals, Mask], made: tuple[Reals, Reals]
) -> tuple[Reals, Reals, Mask, Mask]:
    """Return turning points, widths, and which are known: from neighbours, else from the parabola at the top.

    Where that lies below zero J and ∂J/∂c of the harmonic libration are written; the last mask tells where.
    """
    (widths, narrow), (action, slopes) = known, made
    bases, W, good = ends_of(task, tori, k, widths, pairs=1)
    harmonic = np.zeros(len(W), dtype=bool)
    some = np.flatnonzero(narrow | ~good)
    if not len(some):
        return bases, W, good, harmonic
    own = tori.take(some)
    q, F, bend = _top(task, own, k)
    with np.errstate(all="ignore"):
        root = np.sqrt(-0.5 * bend)
        near = _about(task, k, q, np.sqrt(F) / root)
        below = np.flatnonzero((F <= 0) & (bend < 0))
        harmonic[some[below]] = True
        action[some[below]] = F[below] / (2 * root[below])
        slopes[:, some[below]] = (
            kernels(coordinate_at(*task, own._replace(q=changed(own.q, k, q)), k))[:, below] / root[below]
        )
    moved, their_widths, fine = ends_of(
        task, own._replace(ends=changed(own.ends, k, near)), k, width_of(task, k, near), pairs=_PAIRS
    )
    W[some], good[some] = their_widths, fine
    bases[:, some] = np.where(fine, moved, tori.ends[k][:, some])
    return bases, W, good, harmonic


def _top(task: AngleTask, tori: Tori, k: int) -> tuple[Reals, Reals, Reals]:
    """Return the maxima of p² next to the middle between ``ends``, p² there from 32 digits, and ∂²p²/∂q²."""
    below, above = sides(task.model.separated[k])
    one = coordinate_at(*task, tori, k)
    q, bend = summits(one, 0.5 * (place(below, tori.ends[k, 0]) + place(above, tori.ends[k, 2])))
    return q, squares(one, q), bend


def _about(task: AngleTask, k: int, q: Reals, away: Reals) -> Reals:
    """Return places at a distance on either side of others, as ``ends``."""
    rows, D = [], DoubleDouble()
    for side, formula in enumerate(sides(task.model.separated[k])):
        end = D.add(offset_in_pairs(formula, q), Pair((2.0 * side - 1.0) * formula.sign * away, 0.0 * away))
        rows += [end.high, end.low]
    return np.stack(rows)


def _between(one: CoordinateOfOrbits, bases: Reals, W: Reals, *, exactly: bool) -> Motions:
    """Motions between their turning points."""
    (below, above), bends, n = sides(one.coordinate), np.empty((2, 2, len(W))), len(W)
    with np.errstate(all="ignore"):
        for side, view in enumerate(one.programs.views):
            _, first, second = run_rows(view.bend, one.parameters, np.stack([bases[2 * side], *one.constants]))
            bends[side] = first, 0.5 * second
        even = one.coordinate.even & (np.abs(place(below, bases[0]) + place(above, bases[2])) <= _EVEN * W)
    ends = LibrationEnds(node_maps(), bends, np.array([float(below.sign), -float(above.sign)]), even)
    first, fraction = ends.maps(W)
    lower, upper = (np.zeros(n), np.zeros(n)) if exactly else (np.ascontiguousarray(bases[k]) for k in (0, 2))
    homes = [lower, upper] if exactly else [home(below, lower, above, upper), home(above, upper, below, lower)]
    known = [*one.constants, *one.low, *bases] if exactly else [*one.constants]
    return Motions(
        momentum=W, left=W, right=W, width=np.ascontiguousarray(W), lower=lower, upper=upper, homes=np.stack(homes),
        signs=ends.signs, known=np.stack(known, axis=1), uncertainty=np.zeros((n, 0)), first=first,
        least=np.where(first < len(CLUSTERINGS), *APPROXIMATE_SIZES), fraction=0 * fraction if exactly else fraction,
        barrier_top=np.ones(n),
    )  # fmt: skip


def _integrate(
    one: CoordinateOfOrbits, motions: Motions, made: tuple[Reals, Reals, Reals, Mask], *, exactly: bool
) -> None:
    tables, halves = node_maps().tables, one.programs.exact if exactly else one.programs.views
    below, above = sides_of(halves, tables, one.parameters)
    (action, slopes, coefficients, good), work = made, types.scratch(tables, len(one.constants))
    rough_integrals(below, above, motions, tables, coefficients.shape[2] > 0, action, slopes, coefficients, good, work)


def series_of(found: FollowedTori, index: Integers) -> RunningSeries:
    """Return the running integrals of some of the orbits."""
    means, coefficients, map_, size, turns = found.series
    return RunningSeries(means[..., index], coefficients[:, index], map_[:, index], size[:, index], turns[..., index])


def _scratch(series: RunningSeries) -> PhaseScratch:
    size, constants, width = series.coefficients.shape[0], series.means.shape[1], series.coefficients.shape[3]
    return PhaseScratch(
        np.empty((4, width)), np.empty(constants), np.empty((size, size)), np.empty((size, size)), np.empty((7, size))
    )


def phases_along(series: RunningSeries, θ: Reals, φ: Reals) -> tuple[Reals, Mask]:
    """Move phases to where angles are as given; return κ of Newton's method, and which were found.

    Args:
        θ: angles, shape (separated, n).
        φ: phases to begin with; changed.
    """
    curve, good = np.full(φ.shape[1], np.inf), np.zeros(φ.shape[1], dtype=bool)
    tables = node_maps().tables, turn_maps().tables
    phases_of_series(np.ascontiguousarray(θ), φ, series, *tables, curve, good, _scratch(series))
    return curve, good


def angles_along(task: AngleTask, series: RunningSeries, φ: Reals) -> tuple[Reals, Reals]:
    """Return θ of the separated coordinates and of the ignorable ones, where these are at zero, at phases.

    Args:
        φ: phases, shape (separated, n).
    """
    anomalies, advance = np.empty(φ.shape), np.empty(φ.shape)
    running = np.empty((series.means.shape[1], φ.shape[1]))
    tables = node_maps().tables, turn_maps().tables
    angles_of_series(np.ascontiguousarray(φ), series, *tables, anomalies, advance, running, _scratch(series))
    places = [task.model.ignorable[name] for name in task.model.angles]
    ignorable = running[places] - np.einsum("kan,kn->an", series.means[:, places], advance)
    return anomalies + advance, ignorable
