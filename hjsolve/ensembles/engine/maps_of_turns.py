"""Maps from χ to the angle of rotations: tables that grow as orbits need them; the anomalies are those of ``nodes``.

θ = 2 am(Kχ/π | k²) − π, dθ/dχ = (2K/π) dn, k′² = 4⁻ⁿ; with two slow places at twice the speed (``turned_circle``).
"""

from __future__ import annotations

from functools import cache
from threading import Lock

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.turn_integrals import Turns
from hjsolve.ensembles.engine.nodes import MOST_LEVEL, rotation_nodes

COUNTS = (12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384, 512)
"""Numbers of nodes over half a turn."""

_WIDEST = 2 * COUNTS[-1]
"""Nodes of a whole turn: the length of a row of the tables."""
_ONE_AT_A_TIME = Lock()


class TurnMaps:
    """All maps that were ever needed, and their tables; several threads may ask for more at the same time."""

    def __init__(self) -> None:
        """Begin with what depends on the sizes alone."""
        self._lock = Lock()
        self._places = np.full((2, MOST_LEVEL + 1), -1, dtype=np.int64)
        none = np.empty((0, len(COUNTS), _WIDEST))
        self.tables = Turns(np.empty((0, 6)), 2 * np.array(COUNTS), none, none, *_shared())

    def index(self, level: Integers, several: Integers) -> Integers:
        """Return the places of some maps in the tables, which grow where it must be.

        Args:
            level: l in k′ = 2^−l, shape (n,).
            several: 1 where there are two slow places, else 0.
        """
        found = self._places[several, level]
        if (found < 0).any():
            # asked again inside: another thread may have added the map while this one waited
            with self._lock:
                for k, other in sorted({*zip(several[found < 0].tolist(), level[found < 0].tolist(), strict=True)}):
                    if self._places[k, other] < 0:
                        self._add(k, other)
            found = self._places[several, level]
        return found

    def _add(self, several: int, level: int) -> None:
        angle, speed = np.zeros((1, len(COUNTS), _WIDEST)), np.zeros((1, len(COUNTS), _WIDEST))
        for k, count in enumerate(COUNTS):
            nodes = rotation_nodes(2 * count, level, 1 + several)
            angle[0, k, : 2 * count] = nodes.low
            # dθ/dχ = (2K/π) dn: the weight of a node
            speed[0, k, : 2 * count] = 2 * nodes.quarter / np.pi * nodes.high
        row = np.array([[0.0, 0.0, nodes.quarter, nodes.complement, np.sqrt(nodes.complement), 1.0 + several]])
        old = self.tables
        joined = (np.concatenate(both) for both in ((old.maps, row), (old.angle, angle), (old.speed, speed)))
        maps, angles, speeds = joined
        # one assignment of a new object: readers see the old tables or the new ones, never half of them
        self.tables = old._replace(maps=maps, angle=angles, speed=speeds)
        self._places[several, level] = len(maps) - 1


def turn_maps() -> TurnMaps:
    """Return the maps of this process, the same object to every thread."""
    with _ONE_AT_A_TIME:
        return _of_this_process()


@cache
def _of_this_process() -> TurnMaps:
    return TurnMaps()


def _shared() -> tuple[Reals, Reals, Reals]:
    """Return what depends on the sizes alone: ``circle``, with ones in a third row, ``last`` and ``middle``."""
    circle = np.ones((len(COUNTS), 3, 2 * _WIDEST))
    last, middle = np.zeros((len(COUNTS), 6, _WIDEST)), np.zeros((len(COUNTS), 6, _WIDEST))
    for k, count in enumerate(COUNTS):
        n = 2 * count
        angle = np.arange(2 * n) * (np.pi / n)
        circle[k, 0, : 2 * n], circle[k, 1, : 2 * n] = np.sin(angle), np.cos(angle)
        for rows, terms in ((last, range(count - 3, count)), (middle, range(count // 2 - 1, count // 2 + 2))):
            # reduced as whole numbers before they become angles
            exact = (np.array(terms)[:, None] * (2 * np.arange(n) + 1)) % (2 * n) * (np.pi / n)
            rows[k, :3, :n], rows[k, 3:, :n] = np.cos(exact), np.sin(exact)
    return circle, last, middle
