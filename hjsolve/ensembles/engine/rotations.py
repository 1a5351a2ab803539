"""Motions that go round and round: p² > 0 all along the turn of a periodic coordinate."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.engine.orbit_groups import Group
from hjsolve.ensembles.engine.orbit_regions import LocatedRegions, OrbitRegions
from hjsolve.ensembles.engine.radicand_views import DirectEvaluation, DoubleDoubleEvaluation, View
from hjsolve.ensembles.engine.rotation_anomalies import slow_places
from hjsolve.ensembles.engine.status import UNDECIDED, Status

_POINTS = 32
_GRID = np.pi * (1 + 2 * np.arange(_POINTS) / _POINTS)


def turn(group: Group) -> Reals:
    """Return p² at equally spaced places all along a turn, shape (n, places).

    Args:
        group: of n orbits.
    """
    return DirectEvaluation(group.coordinate.plain, group.knowns).value(_GRID + np.zeros((len(group.q), 1)))


def going_round(group: Group) -> LocatedRegions:
    """Return those of some orbits that go round, and where they move.

    Args:
        group: of orbits.
    """
    with np.errstate(all="ignore"):
        values = turn(group)
        going = np.flatnonzero((values > 0).all(axis=1))
        return rotation(group.take(going), values[going])


def rotation(group: Group, values: Reals) -> LocatedRegions:
    """Return where they move, seen from where they are slow.

    Args:
        group: of orbits that go round.
        values: of p² on the grid, from ``turn``.
    """
    q, P = group.q, group.P
    plain = DirectEvaluation(group.coordinate.plain, group.knowns)
    raw: View = plain
    slow = slow_places(plain, values, _GRID)
    base, left = slow.centre, q - slow.centre
    if group.depth > 1:
        raw, base = DoubleDoubleEvaluation(plain, group.pairs, group.numbers, Pair(base, 0.0 * base)), 0.0 * base
    zero = np.zeros_like(q)
    region = OrbitRegions(
        raw, raw, base, base, zero + 2 * np.pi, slow.ratio, slow.opposite, slow.level, slow.several, P, left, zero,
        turning=False,
    )  # fmt: skip
    good = np.isfinite(P) & (P != 0) & (slow.least > 0) & (not group.coordinate.shifted)
    status = np.where(good, Status.OK, UNDECIDED).astype(np.uint8)
    return LocatedRegions(group.index, region, status, np.zeros(len(q), dtype=bool))
