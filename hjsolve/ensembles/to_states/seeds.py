"""Where Newton's method on J(α) begins: tori of random states, the one with the nearest actions for each orbit.

States at rest lie at a corner of their torus, so random ones show librations of all sizes; along coordinates that may
go round half of them move. Their actions and constants are those of the engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.constants import initial_constants
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits
from hjsolve.ensembles.engine.kernels.neighbours import PlacesOfWells, extrapolated, nearest_points
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import SystemPrograms
from hjsolve.ensembles.engine.starts import Starts, given_momenta
from hjsolve.ensembles.to_states.newton_on_actions import Asked, newton_step
from hjsolve.ensembles.to_states.places_on_tori import refined
from hjsolve.ensembles.to_states.short_arcs import inverses
from hjsolve.ensembles.to_states.tori import ALONE, Actions, AngleTask, Tori, joined

_SEEDS = 1500
"""How many states are tried."""
_CENTRAL = 0.7
"""The fraction of them from the middle third of the scales of a coordinate."""
_SMALL = 0.02
"""Actions below this part of the sum of all are distinguished by their differences, larger ones by their ratios."""
_EQUILIBRIUM = -700.0
"""Logarithm that stands for that of no action at all."""
_MANY, _EVERY = 2048, 8
"""Orbits from which on some are solved first, and which of them: every eighth."""
_BESIDE = 0.5
"""Distance of the nearest known torus, in logarithms of actions, from which on it says nothing of others."""
_NEAR = 0.3
"""The relative change of an action up to which constants are extrapolated."""
_ALL = PlacesOfWells(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), apart=True)
"""Wells do not matter."""


class Scales(NamedTuple):
    """Where states of one coordinate are drawn: places in ascending order, and whether it may go round."""

    places: Reals
    turns: bool


class Seeds(NamedTuple):
    """Tori with their actions.

    Attributes:
        tori: constants, and places between the turning points.
        shells: J of the separated coordinates without their signs, and ∂J/∂c.
        actions: of the separated coordinates, then of the ignorable angles; signed, shape (…, seeds).
    """

    tori: Tori
    shells: Actions
    actions: Reals

    def take(self, index: Integers | Mask) -> Seeds:
        """Return some of them."""
        return Seeds(self.tori.take(index), self.shells.take(index), self.actions[:, index])

    def joined(self, other: Seeds) -> Seeds:
        """Return these and others."""
        return Seeds(
            joined(self.tori, other.tori), joined(self.shells, other.shells),
            np.concatenate([self.actions, other.actions], axis=1),
        )  # fmt: skip


def seeds_of(model: Model, programs: SystemPrograms, scales: Sequence[Scales], wanted: tuple[Reals, Reals]) -> Seeds:
    """Make the seeds of an ensemble.

    Args:
        wanted: actions of the separated coordinates and of the ignorable angles; shapes (separated, n), (angles, n).
    """
    start = initial_constants(model, programs, _drawn(model, scales, wanted))
    size, seeds = start.q.shape
    sums, places, turned = [], start.q.copy(), np.zeros((size, seeds), dtype=bool)
    ends = np.full((size, 4, seeds), np.nan)
    for k in range(size):
        one = CoordinateOfOrbits.of(model, programs, start, k)
        total, found, turned[k] = integrated(one, ALONE, exact=False, places=True)
        places[k] = np.where(turned[k], places[k], 0.5 * found.places.sum(axis=0))
        ends[k] = refined(AngleTask(model, programs), Tori(start.values, start.low, places, ends), k, found.places)
        sums.append(total)
    values, errors = (np.stack([getattr(s, name) for s in sums]) for name in ("action", "action_error"))
    slopes, slope_errors = (np.stack([getattr(s, name) for s in sums]) for name in ("means", "mean_errors"))
    none = np.zeros_like(turned)
    good = (
        np.all([s.good for s in sums], axis=0) & np.isfinite(slopes).all(axis=(0, 1)) & np.isfinite(places).all(axis=0)
    )
    momenta = start.starts.p[[model.names.index(name) for name in model.angles]]
    signed = np.concatenate([np.where(turned, np.sign(start.P), 1.0) * values, momenta])
    shells = Actions(values, errors, slopes, slope_errors, none, good, turned)
    tori = Tori(start.values, start.low, places, ends)
    return Seeds(tori, shells, signed).take(np.flatnonzero(good))


def _drawn(model: Model, scales: Sequence[Scales], wanted: tuple[Reals, Reals]) -> Starts:
    """Draw states."""
    random = np.random.default_rng(0)
    q, p = np.zeros((len(model.names), _SEEDS)), np.zeros((len(model.names), _SEEDS))
    drawn = random.integers(wanted[0].shape[1], size=_SEEDS)
    for k, (coordinate, (grid, turns)) in enumerate(zip(model.separated, scales, strict=True)):
        third = len(grid) // 3
        central = random.random(_SEEDS) < _CENTRAL
        index = np.where(
            central, random.integers(third, len(grid) - third, _SEEDS), random.integers(len(grid), size=_SEEDS)
        )
        q[coordinate.index] = grid[index]
        if turns:
            moving = random.random(_SEEDS) < 0.5
            p[coordinate.index] = np.where(moving, wanted[0][k, drawn], 0.0)
    for k, name in enumerate(model.angles):
        p[model.names.index(name)] = wanted[1][k, drawn]
    return given_momenta(q, p)


def nearest(seeds: Reals, wanted: Reals, wells: PlacesOfWells | None = None) -> Integers:
    """Return which seeds have the nearest actions, the nearest one first, −1 for none; shape (neighbours, n).

    Args:
        seeds: actions, shape (names, seeds).
        wanted: actions, shape (names, n).
        wells: which seeds count; None for all.
    """
    return nearest_in(seeds, wanted, wells, min(2 * len(wanted) + 1, seeds.shape[1]))[0]


def alone(seeds: Reals, wanted: Reals) -> Mask:
    """Return which orbits have no seed near them.

    Args:
        seeds: actions, shape (names, seeds).
        wanted: actions, shape (names, n).
    """
    return np.asarray(nearest_in(seeds, wanted, None, 1)[1][0] > _BESIDE**2)


def nearest_in(seeds: Reals, wanted: Reals, wells: PlacesOfWells | None, count: int) -> tuple[Integers, Reals]:
    """Return which seeds, in some wells, have the nearest actions, and the squares of how far off they are.

    Args:
        seeds: actions, shape (names, seeds).
        wanted: actions, shape (names, n).
        wells: which seeds count; None for all.
        count: how many are wanted.

    Returns:
        Positions, −1 for none, and squares, shape (count, n).
    """
    points, places = shapes(seeds), shapes(wanted)
    axes = np.argsort(-np.ptp(points, axis=1), kind="stable") if points.shape[1] else np.arange(len(points))
    order = np.argsort(points[axes[0]], kind="stable")
    found, squares = np.empty((count, places.shape[1]), dtype=np.int64), np.empty((count, places.shape[1]))
    own, others = (np.ascontiguousarray(x) for x in (points[axes][:, order], places[axes]))
    chosen = _ALL if wells is None else wells._replace(there=np.ascontiguousarray(wells.there[:, order]))
    nearest_points(own, others, chosen, found, squares)
    return np.where(found < 0, -1, order[found]), squares


def shapes(actions: Reals) -> Reals:
    """Return logarithms of actions: differences of them are ratios of large actions, and differences of small ones.

    Args:
        actions: shape (names, n).
    """
    sizes = np.abs(actions)
    with np.errstate(divide="ignore"):
        logarithms = np.log(sizes + _SMALL * sizes.sum(axis=0))
    found: Reals = np.where(np.isfinite(logarithms), logarithms, _EQUILIBRIUM)
    return found


def some_first(orbits: Integers) -> tuple[Integers, Integers]:
    """Divide many orbits into some that are solved first, and the others, which begin at these."""
    first = (np.arange(len(orbits)) % _EVERY == 0) | (len(orbits) < _MANY)
    return orbits[first], orbits[~first]


def begun(pool: Seeds, near: Integers, wanted: Asked) -> tuple[Tori, Reals]:
    """Return the nearest tori, and the step from each to the one with the actions wanted; no step from far away.

    To third order from several neighbours, or to first order from one.

    Args:
        pool: tori that are known.
        near: which of them are neighbours, the nearest one first, shape (neighbours, n).
        wanted: actions.
    """
    (goals, momenta, places, _), first = wanted, near[0]
    values, there, slopes = pool.tori.values[:, first], pool.shells.values[:, first], pool.shells.slopes[:, :, first]
    values[places] = momenta
    with np.errstate(all="ignore"):
        moved = np.einsum("kcn,cn->kn", slopes, values - pool.tori.values[:, first])
        step = newton_step(slopes[:, goals.unknown], goals.actions - there - moved)
        fine = (np.abs(goals.actions - there) <= _NEAR * there).all(axis=0) & np.isfinite(step).all(axis=0)
        better = (
            _extrapolated(pool, near, wanted) - values[goals.unknown] if len(near) > 1 else np.full_like(step, np.nan)
        )
        known = np.isfinite(better).all(axis=0)
    step = np.where(known, better, np.where(fine, step, 0.0))
    return Tori(values, np.zeros_like(values), pool.tori.q[:, first], pool.tori.ends[..., first]), step


def _extrapolated(pool: Seeds, near: Integers, wanted: Asked) -> Reals:
    """Return the unknown constants of tori by those of several neighbours."""
    goals, momenta, places, _ = wanted
    inverse = inverses(pool.shells.slopes[:, goals.unknown].transpose(2, 0, 1))  # ∂c/∂J
    others = -np.einsum("nck,kpn->cpn", inverse, pool.shells.slopes[:, places])
    slopes = np.concatenate([inverse.transpose(1, 2, 0), others], axis=1)
    points = np.concatenate([pool.shells.values, pool.tori.values[places]])
    here = np.concatenate([goals.actions, momenta])
    found, size = np.empty((len(goals.unknown), here.shape[1])), len(here) + 1
    extrapolated(
        points, np.ascontiguousarray(pool.tori.values[goals.unknown]), np.ascontiguousarray(slopes), here, near, found,
        np.empty((size, size)), np.empty((4, max(size, len(near)))),
    )  # fmt: skip
    return found
