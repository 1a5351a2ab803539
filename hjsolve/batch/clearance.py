"""Where the functions of q in p² are proved to be analytic, whatever the constants of the orbits.

All orbits share the formulas: p² is a polynomial in the constants of an orbit, whose coefficients are functions of q
alone (``model``). By disk arithmetic (``numeric.disks``) it is proved that they are analytic in a disk of the
complex plane, and there at most ``GROWTH`` times what they are on the real axis. A feature narrower than the disk
cannot be: it would have a pole in it, or grow in it like exp((radius/width)²).

For a place in the complex plane the largest such disk is found once, and kept in a table for cells whose size is in
proportion to the distance from the origin (an end of the domain, where there is one). An orbit then needs a few looks
at the table. What the table does not show is proved for that orbit itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hjsolve.numeric.arithmetic import Float64
from hjsolve.numeric.disks import Disk
from hjsolve.numeric.error_free import Pair
from hjsolve.numeric.logarithms import Logarithms
from hjsolve.numeric.tape import Tape

GROWTH = 100.0
"""How much larger than on the real axis functions may be in a disk."""

_DROPPED = 50
"""Bits of a double that do not tell its cell: what is left are the exponent and two more."""
_QUARTER = 4
"""Cells in a quarter of a turn."""
_CELLS = 2 * _QUARTER << (63 - _DROPPED)
_DEEPEST = 5
"""How often a cell may be halved in both directions."""
_PARTS_OF = 3.0
"""Cells are halved until they are this many times smaller than the radius."""
_FINE = 16
"""Radii are tried in steps of 2^(1/16)."""
_LONGEST = 40
"""Radii up to 2^40 times the place, or 2^40, are tried."""
_REAL = np.array([0.8, 1.0, 1.25])
"""Where functions are looked at on the real axis, as far from the origin as the disk's centre."""
_NONE = -1.0


class Clearance:
    """Functions of x, q = origin + sign·x, and where they are known to be analytic.

    The radius of a cell depends on the functions and the cell alone, so that no result depends on what other orbits
    there are; several threads may fill the table at the same time.
    """

    def __init__(self, parts: Tape, numbers: tuple[Pair, ...], *, alone: bool, side: int = 0):
        """Take the functions as they are; nothing is computed.

        Args:
            parts: inputs x, constants, parameters.
            numbers: values of the parameters.
            alone: True where the functions do not depend on the constants. Otherwise there is no table.
            side: where x = 0 is an end of the domain, the sign of x within; else 0.
        """
        self._parts = parts
        self._numbers = numbers
        self._alone = alone
        self._both, self._side = side == 0, side or 1
        self._table: _Table | None = None

    def radius(self, x: Any) -> Any:
        """Return the radius of a disk about every place in which all is known.

        Args:
            x: places, real or complex; of z and its conjugate all is the same.

        Returns:
            Array of the same shape; negative where nothing is known.
        """
        if not self._alone:
            return np.full(np.shape(x), _NONE)
        if self._table is None:
            self._table = _Table()
        table, re, im = self._table, np.real(x), np.abs(np.imag(x))
        place = table.place(re, im, self._radius_at)
        found = table.radii[place]
        if not found.all():
            fresh, first = np.unique(place[found == 0], return_index=True)
            re, im = (np.broadcast_to(part, place.shape)[found == 0][first] for part in (re, im))
            centre, half = _cell_of(re, im, table.depth_of(re, im))
            radius = self._radius_at(centre, half)
            table.radii[fresh] = np.where(radius > half, radius - half, _NONE)
            found = table.radii[place]
        return found

    def _radius_at(self, centre: Any, smallest: Any) -> Any:
        """The largest radius about some places, by bisection over powers of 2^(1/16) from the smallest on; 0 for none."""
        with np.errstate(all="ignore"):
            steps = np.log2(np.maximum(1.0, np.abs(centre))) + _LONGEST - np.log2(smallest)
            usable = np.isfinite(steps) & (smallest > 0)
            side = np.where((centre.real < 0) & self._both, -1.0, 1.0) * self._side
            real = (side * np.abs(centre))[:, None] * _REAL
            good, bad = np.zeros(len(centre)), np.where(usable, np.ceil(_FINE * steps), 1.0)
            while np.any(bad - good > 1):
                trial = np.floor((good + bad) / 2)
                clear = self.holds((), centre[:, None], (smallest * 2 ** (trial / _FINE))[:, None], real)
                good, bad = np.where(clear, trial, good), np.where(clear, bad, trial)
            return np.where(usable & (good > 0), smallest * 2 ** (good / _FINE), 0.0)

    def holds(self, constants: tuple[Any, ...], centres: Any, radii: Any, real: Any) -> Any:
        """Tell for which orbits all functions are analytic in some disks, and do not grow much in them.

        Args:
            constants: of the orbits, shape (n,); only looked at where the functions depend on them.
            centres, radii: the disks in terms of x, real or complex, shape (n, disks).
            real: places on the real axis at which the size of functions is taken, shape (n, places).
        """
        with np.errstate(all="ignore"):
            sizes = self._parts.run(Float64(), [real, *self._known(constants)])
            place = Disk(centres.astype(complex), radii + 4 * 2.0**-53 * np.abs(centres))
            known = [Disk(np.asarray(c, complex), 2.0**-52 * np.abs(c)) for c in self._known(constants)]
            arithmetic = Logarithms()
            disks = self._parts.run(arithmetic, [arithmetic.variable(place), *map(arithmetic.constant, known)])
            good = np.isfinite(centres).all(axis=1)
            for value, size in zip(disks, sizes, strict=True):
                scale = np.broadcast_to(np.abs(size), real.shape)
                scale = np.where(np.isfinite(scale), scale, 0.0).max(axis=1)
                good &= np.broadcast_to(value.largest <= GROWTH * scale[:, None], centres.shape).all(axis=1)
        return good

    def _known(self, constants: tuple[Any, ...]) -> list[Any]:
        count = len(self._parts.inputs) - 1 - len(self._numbers)
        values = [0.0] * count if self._alone else [c[:, None] for c in constants]
        return [*values, *(pair.high for pair in self._numbers)]


class _Table:
    """Radii by cells, the large cells divided as they need it.

    Attributes:
        depth: how often each large cell is halved; −1 where that is not known yet. start: where its parts begin.
        radii: of the parts; 0 where not known yet.
    """

    def __init__(self) -> None:
        self.depth = np.full(_CELLS, -1, dtype=np.int8)
        self.start = np.zeros(_CELLS, dtype=np.int64)
        self.radii = np.zeros(0)

    def place(self, re: Any, im: Any, radius_at: Callable[[Any, Any], Any]) -> Any:
        """Return where the radii of some places stand."""
        large = _number(re, im, 0)
        depth = self.depth[large]
        if (depth < 0).any():
            self._divide(np.unique(large[depth < 0]), radius_at)
            depth = self.depth[large]
        return self.start[large] + _part(re, im, depth.astype(np.int64))

    def depth_of(self, re: Any, im: Any) -> Any:
        """Return how often the large cells of some places are halved."""
        return self.depth[_number(re, im, 0)].astype(np.int64)

    def _divide(self, cells: Any, radius_at: Callable[[Any, Any], Any]) -> None:
        centre, half = _middle(cells // (2 * _QUARTER), cells % (2 * _QUARTER), 0)
        radius = radius_at(centre, half * 2.0**-_DEEPEST)
        with np.errstate(all="ignore"):
            depth = np.clip(np.ceil(np.log2(_PARTS_OF * half / radius)), 0, _DEEPEST).astype(np.int64)
        sizes = 4**depth
        self.start[cells] = len(self.radii) + np.cumsum(sizes) - sizes
        self.radii = np.concatenate([self.radii, np.zeros(int(sizes.sum()))])
        self.depth[cells] = depth


def _shares(re: Any, im: Any) -> tuple[Any, Any]:
    """|re| + im, and im/(|re| + im), which stands for an angle."""
    with np.errstate(all="ignore"):
        size = np.abs(re) + im
        share = im / size
    return np.ascontiguousarray(np.broadcast_to(size, np.shape(share))), np.where(size > 0, share, 0.0)


def _numbers(re: Any, im: Any, depth: Any) -> tuple[Any, Any]:
    """The cell of places re ± i·im when all cells are halved ``depth`` times: along |re| + im, and along the angle."""
    size, share = _shares(re, im)
    turn = np.minimum((share * (_QUARTER << depth)).astype(np.int64), (_QUARTER << depth) - 1)
    return size.view(np.int64) >> (_DROPPED - depth), np.where(re < 0, (2 * _QUARTER << depth) - 1 - turn, turn)


def _number(re: Any, im: Any, depth: int) -> Any:
    along, turn = _numbers(re, im, depth)
    return along * (2 * _QUARTER << depth) + turn


def _part(re: Any, im: Any, depth: Any) -> Any:
    """The number of a part among those of its large cell."""
    along, turn = _numbers(re, im, depth)
    within = (1 << depth) - 1
    return ((along & within) << depth) + (turn & within)


def _cell_of(re: Any, im: Any, depth: Any) -> tuple[Any, Any]:
    return _middle(*_numbers(re, im, depth), depth)


def _middle(along: Any, turn: Any, depth: Any) -> tuple[Any, Any]:
    """A place within each cell, and the distance of its farthest corner."""
    left = turn >= (_QUARTER << depth)
    turn = np.where(left, (2 * _QUARTER << depth) - 1 - turn, turn)
    sizes = [((along + k) << (_DROPPED - depth)).view(np.float64) for k in (0, 1)]
    shares = [(turn + k) / (_QUARTER << depth) for k in (0, 1)]
    corners = np.stack([np.where(left, -1, 1) * s * (1 - t) + 1j * s * t for s in sizes for t in shares])
    centre = corners.mean(axis=0)
    return centre, np.abs(corners - centre).max(axis=0)
