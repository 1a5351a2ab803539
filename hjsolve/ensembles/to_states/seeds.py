"""Where Newton's method on J(α) begins: tori of random states, the one with the nearest actions for each orbit.

States at rest lie at a corner of their torus, so random ones show librations of all sizes; along coordinates that may
go round half of them move. Their actions and constants are those of the engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.engine import Engine
from hjsolve.ensembles.engine.status import Status
from hjsolve.motion.tori.radicand_curve import RadicandCurve

_SEEDS = 1500
"""How many states are tried."""
_CENTRAL = 0.7
"""The share of them from the middle third of the scales of a coordinate."""
_SMALL = 0.02
"""Actions below this part of the sum of all are distinguished by their differences, larger ones by their ratios."""
_EQUILIBRIUM = -700.0
"""Logarithm that stands for that of no action at all."""
_TOGETHER = 1 << 22
"""Pairs of orbits and seeds that are compared together."""


class Seeds(NamedTuple):
    """Tori; arrays (…, seeds).

    Attributes:
        constants: of all names.
        actions: of the separated coordinates, then of the ignorable angles; signed.
        places: between the turning points of each separated coordinate.
        rotating: which go round.
        low, high: turning points, NaN of a rotation.
    """

    constants: Reals
    actions: Reals
    places: Reals
    rotating: Mask
    low: Reals
    high: Reals

    def take(self, index: Integers | Mask) -> Seeds:
        """Return some of them.

        Args:
            index: which.
        """
        return Seeds._make(x[:, index] for x in self)


def seeds_of(engine: Engine, curves: Sequence[RadicandCurve], wanted: tuple[Reals, Reals]) -> Seeds:
    """Make the seeds of an ensemble.

    Args:
        engine: that gives actions, constants and turning points.
        curves: p² of the separated coordinates, for the scales of their domains.
        wanted: actions of the separated coordinates and of the ignorable angles; shapes (separated, n), (angles, n).
    """
    model, random = engine.model, np.random.default_rng(0)
    q, p = np.zeros((len(model.names), _SEEDS)), np.zeros((len(model.names), _SEEDS))
    drawn = random.integers(wanted[0].shape[1], size=_SEEDS)
    for k, (coordinate, curve) in enumerate(zip(model.separated, curves, strict=True)):
        grid = curve.samples()
        third = len(grid) // 3
        central = random.random(_SEEDS) < _CENTRAL
        index = np.where(
            central, random.integers(third, len(grid) - third, _SEEDS), random.integers(len(grid), size=_SEEDS)
        )
        q[coordinate.index] = grid[index]
        if curve.turn:
            moving = random.random(_SEEDS) < 0.5
            p[coordinate.index] = np.where(moving, wanted[0][k, drawn], 0.0)
    for k, name in enumerate(model.angles):
        p[model.names.index(name)] = wanted[1][k, drawn]
    found = engine.run(dict(zip(model.names, q, strict=True)), dict(zip(model.names, p, strict=True)))
    fine = np.flatnonzero(found.status == Status.OK)
    names = [c.name for c in model.separated]
    low, high = (np.stack([found.turning_points[f"{n}.{side}"] for n in names])[:, fine] for side in ("lower", "upper"))
    actions = np.stack([found.actions[n] for n in (*names, *model.angles)])[:, fine]
    constants = np.stack([found.constants[name] for name in model.constants])[:, fine]
    rotating = np.isnan(low)
    places = np.stack([q[c.index] for c in model.separated])[:, fine]
    inner = np.where(rotating, places, 0.5 * (low + high))
    return Seeds(constants, actions, inner, rotating, low, high)


def nearest(seeds: Reals, wanted: Reals) -> Integers:
    """Return which seed has the nearest actions, shape (n,).

    Args:
        seeds: actions, shape (names, seeds).
        wanted: actions, shape (names, n).
    """
    found = np.empty(wanted.shape[1], dtype=np.int64)
    theirs, own = _shapes(seeds), _shapes(wanted)
    half = 0.5 * (theirs**2).sum(axis=0)
    span = max(1, _TOGETHER // max(seeds.shape[1], 1))
    for begin in range(0, wanted.shape[1], span):  # ½|a − b|² less ½|a|², which is the same for all seeds
        found[begin : begin + span] = np.argmin(half - own[:, begin : begin + span].T @ theirs, axis=1)
    return found


def _shapes(actions: Reals) -> Reals:
    """Logarithms of actions: differences of them are ratios of large actions, and differences of small ones."""
    sizes = np.abs(actions)
    with np.errstate(divide="ignore"):
        logarithms = np.log(sizes + _SMALL * sizes.sum(axis=0))
    found: Reals = np.where(np.isfinite(logarithms), logarithms, _EQUILIBRIUM)
    return found
