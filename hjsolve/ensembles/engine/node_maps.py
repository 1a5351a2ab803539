"""Maps from χ to the coordinate for the compiled pass: tables that grow as orbits need them.

The anomalies are those of ``nodes``. There ρ_d and ρ_c, which say how near a pole or zero lies beyond an end, are the
orbit's own; here 1 + ρ_d and 1 + ρ_c are powers of two. Where exactly they lie does not enter an integral, only its
rate of convergence, and a map serves all orbits.
"""

from __future__ import annotations

from functools import cache
from threading import Lock
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Elementwise, Integers, Reals
from hjsolve.ensembles.engine import nodes
from hjsolve.ensembles.engine.kernels.crowding import BARRIER_TOP, CLUSTERINGS, EVEN
from hjsolve.ensembles.engine.kernels.fitting_maps import FROM_ABOVE, FROM_BELOW, FROM_MIDDLE
from hjsolve.ensembles.engine.kernels.types import VECTOR, Strips, Tables
from hjsolve.ensembles.engine.nodes import MOST_LEVEL
from hjsolve.ensembles.engine.strips_of_analyticity import across, barrier_top_disks, covered_strip, disks, squares

COUNTS = (16, 24, 32, 40, 48, 56, 64, 72, 80, 96, 112, 128, 160, 192, 256, 320, 384, 512, 768, 1024)
"""Numbers of nodes: whole vectors of eight."""

SAMPLES, STRETCHED_SAMPLES, BARRIER_TOP_SAMPLES = 4, 12, 13
"""Places at which rounding errors are looked at, next to the middle; one at a crest itself, where p² is least."""

_WIDEST = COUNTS[-1]
_FIRST = np.concatenate([[0], np.cumsum(COUNTS)])
"""The length of a row of the tables, and where the nodes of each size begin."""
_MARGIN = 0.04
"""Distance of the first sample from the turning point, in spacings: p² is 0 at the end itself, and what rounding does
to it infinitely large. Tested: half and twice of it change no claim of 20 000 orbits by 2 %."""
_ONE_AT_A_TIME = Lock()
_PART = 0.125
"""The part of the width that is seen from such an end where nothing beyond it gives a scale."""


class NodeMap(NamedTuple):
    """A map.

    Attributes:
        node_map: place in the table of crowdings; ``BARRIER_TOP`` for one about a crest, which has its level twice.
        lower, upper: logarithms to base 2 of 1 + ρ_d and 1 + ρ_c; their sum is even.
    """

    node_map: int
    lower: int = 0
    upper: int = 0

    @property
    def level(self) -> int:
        """Of k′² = 4^−level."""
        return (self.lower + self.upper) // 2

    @property
    def symmetry(self) -> int:
        """2 for an even motion, else 1."""
        return 2 if EVEN <= self.node_map < BARRIER_TOP else 1

    def dividing(self, fraction: int) -> float:
        """(q − a)/(b − q) up to which a motion is seen from its lower end; see ``kernels.fitting_maps``.

        The ratio, not (q − a)/W: next to the upper end that is 1 in doubles from 1 + ρ_c = 2⁵⁴ on.
        """
        if self.level == 0:
            return (1.0, (1.0 - _PART) / _PART, _PART / (1.0 - _PART))[fraction]
        return (1.0, 2.0**self.upper, 2.0**-self.lower)[fraction]

    def stretched(self, sn2: Elementwise, cn2: Elementwise) -> tuple[Elementwise, Elementwise]:
        """Return (q − a)/W and (b − q)/W where sn² and cn² are these."""
        d = 2.0**self.lower - 1
        below = 1 + d * cn2
        return sn2 / below, (1 + d) * cn2 / below


class NodeMaps:
    """All maps that were ever needed, and their tables; several threads may ask for more at the same time."""

    def __init__(self) -> None:
        """Begin with the maps that stretch nothing, in the order of ``CLUSTERINGS``."""
        self._lock = Lock()
        self._places: dict[NodeMap, int] = {}
        self._by_kind = np.full((len(CLUSTERINGS) + 1, 2 * MOST_LEVEL + 1, 2 * MOST_LEVEL + 1), -1, dtype=np.int64)
        self.tables, none = _shared_tables(), np.empty(0)
        self.strips = Strips(none, none, none, none, np.full((3, 0, len(COUNTS)), -1))
        self._add([NodeMap(node_map) for node_map in range(len(CLUSTERINGS))])

    def index(self, maps: Integers) -> Integers:
        """Return the places of some maps in the tables, which grow where it must be.

        Args:
            maps: as ``kernels.fitting_maps`` writes them, shape (n, 3).
        """
        kinds = tuple(maps.T)
        places = self._by_kind[kinds]
        # asked without the lock first: nearly every map is in the tables already
        if (places < 0).any():
            with self._lock:
                wanted = [NodeMap(*map(int, kind)) for kind in np.unique(maps[places < 0], axis=0)]
                self._add([key for key in wanted if key not in self._places])
            places = self._by_kind[kinds]
        return places

    def key(self, place: int) -> NodeMap:
        """Return the map at a place in the tables.

        Args:
            place: as ``index`` returns it.
        """
        return next(key for key, own in self._places.items() if own == place)

    def _add(self, keys: list[NodeMap]) -> None:
        if not keys:
            return
        rows = [_rows(key) for key in keys]
        grown = {name: _joined(getattr(self.tables, name), np.stack([row[name] for row in rows])) for name in rows[0]}
        self.tables = self.tables._replace(**grown)
        begin = len(self._places)
        shape = (len(keys), len(COUNTS))
        plain = [
            [across(n, CLUSTERINGS[k.node_map], k.symmetry) if k.level == 0 else np.inf for n in COUNTS] for k in keys
        ]
        counts = np.concatenate([self.strips.counts, np.full((3, *shape), -1)], axis=1)
        self.strips = self.strips._replace(enough=_joined(self.strips.enough, np.array(plain)), counts=counts)
        for k, key in enumerate(keys):  # last, for whoever looks without the lock
            self._places[key] = self._by_kind[key] = begin + k

    def cover(self, map_: int, size: int) -> None:
        """Work out the disks over the strip of a map and a size, where that was not done yet.

        Args:
            map_: place in the tables.
            size: place in ``COUNTS``.
        """
        with self._lock:
            strips = self.strips
            if strips.counts[0, map_, size] >= 0:
                return
            key = self.key(map_)
            *parts, low = _disks(key, COUNTS[size])
            flat = dict(zip(("along", "away", "spread"), parts, strict=True))
            # a new object each time: compiled loops that read the old one go on undisturbed
            counts = strips.counts.copy()
            counts[:, map_, size] = len(parts[0]), low, len(strips.along)
            grown = {name: np.concatenate([getattr(strips, name), row]) for name, row in flat.items()}
            self.strips = strips._replace(**grown, counts=counts)


def _joined(old: Elementwise, new: Elementwise) -> Elementwise:
    return new if old.size == 0 else np.concatenate([old, new])


def node_maps() -> NodeMaps:
    """Return the maps of this process, the same object to every thread: an index means a row of its own tables only.

    ``cache`` alone lets two threads that come first each make an object of its own.
    """
    with _ONE_AT_A_TIME:
        return _of_this_process()


@cache
def _of_this_process() -> NodeMaps:
    return NodeMaps()


def _shared_tables() -> Tables:
    """Return what depends on the sizes alone."""
    size = len(COUNTS)
    last, middle = np.zeros((size, 5, _WIDEST)), np.zeros((size, 3, _WIDEST))
    cosines = []
    squares, slopes = (np.zeros((2, size, _WIDEST)) for _ in range(2))
    for k, count in enumerate(COUNTS):
        rows = nodes.series(count)
        last[k, :, :count], middle[k, :, :count] = rows[-5:], rows[count // 2 - 3 : count // 2]
        cosines.append(rows.ravel())
        for symmetry in (1, 2):
            squares[symmetry - 1, k, :count], slopes[symmetry - 1, k, : count - 1] = nodes.shifts(count, symmetry)
    none, counted = np.empty(0), np.empty(0, dtype=np.int64)
    return Tables(
        maps=none, counts=np.array(COUNTS), first=_FIRST, low=none, high=none, root=none, split=counted, places=none,
        samples=counted, spans=counted, last=last, middle=middle, cosines=np.concatenate(cosines),
        rows=np.cumsum([0, *map(len, cosines)]), squares=squares, slopes=slopes,
    )  # fmt: skip


def _rows(key: NodeMap) -> dict[str, Elementwise]:
    """Return the rows of one map in the tables."""
    samples = BARRIER_TOP_SAMPLES if key.node_map == BARRIER_TOP else SAMPLES if key.level == 0 else STRETCHED_SAMPLES
    parts = [nodes.equal_anomalies(count, key.symmetry * count) for count in COUNTS]
    fraction = np.pi / key.symmetry / (samples - 1 + 2 * _MARGIN)
    equal = np.array([(k + _MARGIN) * fraction for k in range(samples)])
    split, farthest = _divided(key)
    among = np.concatenate([equal, farthest])
    χ = Pair(
        np.concatenate([*(part.high for part in parts), among]),
        np.concatenate([*(part.low for part in parts), 0.0 * among]),
    )
    known, x, y, root = _barrier_top(key, χ) if key.node_map == BARRIER_TOP else _stretched(key, χ)
    places = np.zeros((4, BARRIER_TOP_SAMPLES + len(farthest)))
    seen = np.stack([x, y, root, np.sin(χ.high) ** 2])[:, -len(among) :]
    places[:, :samples], places[:, BARRIER_TOP_SAMPLES:] = seen[:, :samples], seen[:, samples:]
    return {
        "maps": np.array(known),
        "low": x[: -len(among)],
        "high": y[: -len(among)],
        "root": root[: -len(among)],
        "split": split,
        "places": places,
        "samples": np.array(samples),
        "spans": np.array(
            [_spans(key, equal, fraction, *farthest[2 * fraction : 2 * fraction + 2]) for fraction in range(3)]
        ),
    }


_Placed = tuple[list[float], Reals, Reals, Reals]


def _stretched(key: NodeMap, χ: Pair) -> _Placed:
    """Return the row of ``Tables.maps``, and (q − a)/W, (b − q)/W and |dq/dχ|/W at some anomalies."""
    complement, quarter, sn2, cn2, derivative = nodes.libration_places(χ, key.level, key.node_map)
    x, y = key.stretched(sn2, cn2)
    d, c = 2.0**key.lower - 1, 2.0**key.upper - 1
    if key.level:
        # dq/√((q − a)(b − q)) of Byrd & Friedman 254-256, see ``one_coordinate.anomaly``
        derivative = (2 * quarter / np.pi * derivative) * np.sqrt(complement * (1 + c * y) * (1 + d * x))
    known = [*CLUSTERINGS[key.node_map], quarter, complement, d, c, float(key.symmetry), 0.0]
    return known, x, y, derivative * np.sqrt(x * y)


def _barrier_top(key: NodeMap, χ: Pair) -> _Placed:
    """Return the same of nodes about a crest half way."""
    complement, quarter, x, y, root = nodes.barrier_top_places(χ, key.level)
    return [0.0, 0.0, quarter, complement, 0.0, 0.0, 1.0, 1.0], x, y, root


def _divided(key: NodeMap) -> tuple[Integers, Reals]:
    """How many nodes of every size are seen from below, in every part; and the farthest that is, seen from either end.

    Whole vectors are, where that moves no more than a few nodes.
    """
    split, farthest = np.empty((len(COUNTS), 3), dtype=np.int64), np.empty(6)
    for fraction in range(3):
        if key.symmetry == 2:
            split[:, fraction], farthest[2 * fraction : 2 * fraction + 2] = COUNTS, 0.5 * np.pi
            continue
        middle = _at_half(key, key.dividing(fraction))
        for k, count in enumerate(COUNTS):
            part = middle / np.pi * count
            whole = {FROM_MIDDLE: np.rint, FROM_BELOW: np.ceil, FROM_ABOVE: np.floor}[fraction](part / VECTOR)
            rounded = VECTOR * int(whole)
            fits = VECTOR <= rounded <= count - VECTOR and not (key.node_map and not key.level)
            split[k, fraction] = rounded if fits else min(max(round(part), 1), count - 1)
        last = (split[:, fraction] - 0.5) * np.pi / COUNTS
        farthest[2 * fraction] = max(last.max(), middle)
        farthest[2 * fraction + 1] = min((last + np.pi / np.array(COUNTS)).min(), middle)
    return split, farthest


def _spans(key: NodeMap, equal: Reals, fraction: int, below: float, above: float) -> tuple[int, int, int]:
    """How many samples are seen from below, and between which ones both views are used: at χ from above to below."""
    if key.symmetry == 2:
        return len(equal), len(equal) - 1, len(equal) - 1
    inside = int((equal <= _at_half(key, key.dividing(fraction))).sum())
    first = int((equal <= above).sum()) - 1
    last = len(equal) - int((equal >= below).sum())
    return inside, min(max(first, 0), inside - 1), max(min(last, len(equal) - 1), inside)


def _at_half(key: NodeMap, ratio: float) -> float:
    """χ where (q − a)/(b − q) has some value, nearly: doubles are enough."""
    if key.node_map == BARRIER_TOP:
        return 0.5 * np.pi
    # interpolated in log(x/y), which is nearly linear in χ where nodes are stretched
    χ = np.linspace(0.0, np.pi, 514)[1:-1]
    table = nodes.libration_nodes(COUNTS[0], key.level, key.node_map)
    x, y = key.stretched(*(square.real for square in squares(χ.astype(complex), table)))
    return float(np.interp(np.log(ratio), np.log(x / y), χ))


def _disks(key: NodeMap, count: int) -> tuple[Reals, Reals, Reals, int]:
    """Disks over the strip of a map: parts of the middles, radii, and how many belong to the lower half.

    An infinite radius says that the strip holds a pole of the map.
    """
    if key.node_map == BARRIER_TOP:
        low, high, radii = barrier_top_disks(nodes.barrier_top_nodes(count, key.level))
    else:
        table = nodes.libration_nodes(count, key.level, key.node_map)
        low, high, radii = disks(covered_strip(table), 2.0**key.lower - 1)
    below = (low.real <= 0.5) | (key.symmetry == 2)
    # disks that the lower view sees come first, as the compiled loop takes them
    order = np.argsort(~below, kind="stable")
    seen = np.where(below, low, high)[order]
    return seen.real, np.abs(seen.imag), radii[order], int(below.sum())
