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
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import SystemPrograms
from hjsolve.ensembles.engine.starts import Starts, given_momenta
from hjsolve.ensembles.to_states.tori import ALONE, Actions, Tori

_SEEDS = 1500
"""How many states are tried."""
_CENTRAL = 0.7
"""The fraction of them from the middle third of the scales of a coordinate."""
_SMALL = 0.02
"""Actions below this part of the sum of all are distinguished by their differences, larger ones by their ratios."""
_EQUILIBRIUM = -700.0
"""Logarithm that stands for that of no action at all."""
_TOGETHER = 1 << 22
"""Pairs of orbits and seeds that are compared together."""


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


def seeds_of(model: Model, programs: SystemPrograms, scales: Sequence[Scales], wanted: tuple[Reals, Reals]) -> Seeds:
    """Make the seeds of an ensemble.

    Args:
        wanted: actions of the separated coordinates and of the ignorable angles; shapes (separated, n), (angles, n).
    """
    start = initial_constants(model, programs, _drawn(model, scales, wanted))
    seeds = len(start.q), start.q.shape[1]
    sums, places, turned = [], start.q.copy(), np.zeros(seeds, dtype=bool)
    for k in range(len(model.separated)):
        one = CoordinateOfOrbits.of(model, programs, start, k)
        total, found, turned[k] = integrated(one, ALONE, exact=False, places=True)
        places[k] = np.where(turned[k], places[k], 0.5 * found.places.sum(axis=0))
        sums.append(total)
    values, errors = (np.stack([getattr(s, name) for s in sums]) for name in ("action", "action_error"))
    slopes, slope_errors = (np.stack([getattr(s, name) for s in sums]) for name in ("means", "mean_errors"))
    none = np.zeros(seeds, dtype=bool)
    good = (
        np.all([s.good for s in sums], axis=0) & np.isfinite(slopes).all(axis=(0, 1)) & np.isfinite(places).all(axis=0)
    )
    momenta = start.starts.p[[model.names.index(name) for name in model.angles]]
    signed = np.concatenate([np.where(turned, np.sign(start.P), 1.0) * values, momenta])
    shells = Actions(values, errors, slopes, slope_errors, none, good, turned)
    return Seeds(Tori(start.values, start.low, places), shells, signed).take(np.flatnonzero(good))


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


def nearest(seeds: Reals, wanted: Reals) -> Integers:
    """Return which seed has the nearest actions, shape (n,).

    Args:
        seeds: actions, shape (names, seeds).
        wanted: actions, shape (names, n).
    """
    found = np.empty(wanted.shape[1], dtype=np.int64)
    theirs, own = shapes(seeds), shapes(wanted)
    half = 0.5 * (theirs**2).sum(axis=0)
    span = max(1, _TOGETHER // max(seeds.shape[1], 1))
    for begin in range(0, wanted.shape[1], span):  # ½|a − b|² less ½|a|², which is the same for all seeds
        found[begin : begin + span] = np.argmin(half - own[:, begin : begin + span].T @ theirs, axis=1)
    return found


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
