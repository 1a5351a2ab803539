"""Where the functions of q in p² are proved to be analytic, whatever the constants of the orbits.

All orbits share the formulas: p² is a polynomial in the constants of an orbit, whose coefficients are functions of q
alone (``lowered_solution``). By disk arithmetic (``arithmetic.complex_disks``) it is proved that they are analytic in a
disk of the complex plane, and there at most ``GROWTH`` times what they are on the real axis, with rounding, of which
log(1 + r²) consists next to r = 0. A feature narrower than the disk cannot be: it would have a pole in it, or grow in
it like exp((radius/width)²).

For a place in the complex plane the largest such disk is found once, and kept in a table for cells whose size is in
proportion to the distance from the origin (an end of the domain, where there is one). An orbit then needs a few looks
at the table. What the table does not show is proved for that orbit itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Lock
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.block_exponents import Unit, over_power_of_two, tape_in_units, unit_of
from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.disks_with_logarithms import DisksInLogarithms
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS, UNIT, Float64
from hjsolve.arithmetic.number_types import Complexes, Elementwise, Integers, Mask, Reals
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.kernels.clearance_tables import DEEPEST, DROPPED, QUARTER

GROWTH = 100.0
"""How much larger than on the real axis functions may be in a disk."""

_CELLS = 2 * QUARTER << (63 - DROPPED)
"""13 bits of the size (11 of the exponent, 2 of the mantissa) and 2 · ``QUARTER`` parts of the half turn: below the
real axis functions have the conjugate values."""
_PARTS_OF = 4.0
"""Cells are halved until they are this many times smaller than the radius."""
_COARSE = 20
"""Radii tried at once."""
_LONGEST = 40
"""Radii up to 2^40 times the place, or 2^40, are tried."""
_REAL = np.array([0.8, 1.0, 1.25])
"""Where functions are looked at on the real axis, as far from the origin as the disk's centre."""
_NONE, _UNKNOWN = -1.0, -(1 << 40)
"""The radius where nothing is known, and where the radii of a cell begin that was not met: the number of a part within
a cell, below 4^``DEEPEST``, leaves it negative."""
_Depths = NDArray[np.int8]
_Often = int | Integers
_ALL = 1
"""Where a cell is halved no more often, all of its parts are worked out at once."""
RadiusAt = Callable[[Complexes, Reals], Reals]


class Cells(NamedTuple):
    """What a table knows at one moment. Compiled loops read it while other threads work: only ``radii`` are written to.

    Attributes:
        depth: how often each large cell is halved.
        start: where its parts begin, negative where not known yet.
        radii: of the parts; 0 where not known yet.
    """

    depth: _Depths
    start: Integers
    radii: Reals


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
        self._table = _Table() if alone else None
        self._one_at_a_time = Lock()

    def in_units(self, place: int, constants: Sequence[Unit]) -> Clearance:
        """Return the same of x over a power of two; of functions that hardly change, of what they change by.

        Args:
            place: exponent of the unit of x.
            constants: units of the constants.
        """
        own = [unit_of(pair) for pair in self._numbers]
        parts = tape_in_units(self._parts, (Unit(place), *(() if self._alone else constants), *own)).tape
        numbers = tuple(map(over_power_of_two, self._numbers))
        if (parts, numbers) == (self._parts, self._numbers):  # powers of x grow in a disk alike at all scales
            return self
        return Clearance(parts, numbers, alone=self._alone, side=0 if self._both else self._side)

    def radius(self, x: Reals | Complexes) -> Reals:
        """Return the radius of a disk about every place in which all is known.

        Args:
            x: places, real or complex; of z and its conjugate all is the same.

        Returns:
            Array of the same shape; negative where nothing is known.
        """
        if self._table is None:
            return np.full(np.shape(x), _NONE)
        table, re, im = self._table, np.real(x), np.abs(np.imag(x))
        place = table.place(re, im)
        found = table.cells.radii[np.maximum(place, 0)]
        if (place < 0).any() or not found.all():
            with self._one_at_a_time:
                table.divide(re, im, place < 0, self._radius_at)
                place = table.place(re, im)
                table.fill(place, self._radius_at)
                found = table.cells.radii[place]
        return found

    def table(self) -> Cells | None:
        """Return what is known so far; None where there is no table."""
        return None if self._table is None else self._table.cells

    def _radius_at(self, centre: Complexes, smallest: Reals) -> Reals:
        """Return the largest radius about some places, at least the smallest, to a tenth or so; 0 for none.

        What holds in a disk is taken to hold in smaller ones; where it is not so, a smaller radius may be found.
        """
        with np.errstate(all="ignore"):
            # radii as powers of two between the smallest asked and 2⁴⁰ times the place
            octaves = np.log2(np.maximum(1.0, np.abs(centre))) + _LONGEST - np.log2(smallest)
            octaves = np.where(np.isfinite(octaves) & (smallest > 0), octaves, 0.0)
            side = np.where((centre.real < 0) & self._both, -1.0, 1.0) * self._side
            real = (side * np.abs(centre))[:, None] * _REAL
            found, step = np.zeros(len(centre)), octaves / (_COARSE - 1)
            # twenty radii of all places in one run, then twenty between the last good and the first bad one
            for grid, width in ((np.arange(_COARSE), step), (np.arange(_COARSE) / _COARSE, step)):
                radii = (smallest * 2**found)[:, None] * 2.0 ** (grid * width[:, None])
                good = self._bounded((), centre[:, None], radii, real)
                count = np.where(good.all(axis=1), len(grid), np.argmin(good, axis=1))
                usable = count > 0
                found = found + np.where(usable, width * grid[np.maximum(count - 1, 0)], 0.0)
                if grid[-1] >= 1:
                    lowest = usable
            return np.where(lowest, smallest * 2**found, 0.0)

    def holds(self, constants: tuple[Reals, ...], centres: Reals | Complexes, radii: Reals, real: Reals) -> Mask:
        """Tell for which orbits all functions are analytic in some disks, and do not grow much in them.

        Args:
            constants: of the orbits, shape (n,); only looked at where the functions depend on them.
            centres, radii: the disks in terms of x, real or complex, shape (n, disks).
            real: places on the real axis at which the size of functions is taken, shape (n, places).
        """
        return np.logical_and.reduce(self._bounded(constants, centres, radii, real), axis=1)

    def _bounded(self, constants: tuple[Reals, ...], centres: Reals | Complexes, radii: Reals, real: Reals) -> Mask:
        """Return the same for each of the disks."""
        with np.errstate(all="ignore"):
            # the size on the real axis includes its rounding: where a function is all rounding no claim depends on it
            noisy = [WithErrorBound(x) for x in (real, *self._known(constants))]
            sizes = self._parts.run(RunningError(Float64()), noisy)
            # the centre is rounded: the disk is widened by that
            place = Disk(centres.astype(complex), radii + 4 * UNIT * np.abs(centres))
            known = [Disk(np.asarray(c, complex), EPS * np.abs(c)) for c in self._known(constants)]
            arithmetic = DisksInLogarithms()
            disks = self._parts.run(arithmetic, [arithmetic.variable(place), *map(arithmetic.constant, known)])
            good = np.isfinite(centres) & np.isfinite(radii)
            for value, size in zip(disks, sizes, strict=True):
                noise = 0.0 if size.error is None else size.error  # what rounding hides no claim leaves out
                scale = np.broadcast_to(np.abs(size.value) + noise, real.shape)
                scale = np.where(np.isfinite(scale), scale, 0.0).max(axis=1)
                # a feature of width w would have a pole in a disk of radius r > w, or grow in it like exp((r/w)²)
                good = good & (value.largest <= GROWTH * scale[:, None])
        return good

    def _known(self, constants: tuple[Reals, ...]) -> list[Elementwise]:
        count = len(self._parts.inputs) - 1 - len(self._numbers)
        values = [0.0] * count if self._alone else [c[:, None] for c in constants]
        return [*values, *(pair.high for pair in self._numbers)]


class _Table:
    """Radii by cells, the large cells divided as they need it.

    Attributes:
        cells: what is known; another object whenever cells are divided, so that no ``start`` points beyond its radii.
        owner: the large cell of each part.
    """

    def __init__(self) -> None:
        depth, start = np.zeros(_CELLS, dtype=np.int8), np.full(_CELLS, _UNKNOWN, dtype=np.int64)
        self.cells = Cells(depth, start, np.zeros(1))  # the first stands for none
        self.owner = np.zeros(1, dtype=np.int64)

    def place(self, re: Reals, im: Reals) -> Integers:
        """Return where the radii of some places stand; negative where that is not known yet."""
        cells, (size, fraction) = self.cells, _fractions(re, im)
        # cells by the exponent and two bits of the size, and by the angle: as wide as they are far from the origin
        along, turn = _numbers(size, fraction, re < 0, 0)
        large = along * (2 * QUARTER) + turn
        start, depth = cells.start[large], cells.depth[large]
        if not depth.any():  # no cell is divided
            return start
        depth = np.maximum(depth, 0).astype(np.int64)
        along, turn = _numbers(size, fraction, re < 0, depth)
        within = (1 << depth) - 1
        return start + ((along & within) << depth) + (turn & within)

    def fill(self, places: Integers, radius_at: RadiusAt) -> None:
        """Work out radii that are not known; where a large cell has few parts, those of all of them."""
        depths, start, radii = self.cells
        places = np.unique(places[radii[places] == 0])
        if not len(places):
            return
        owner = np.unique(self.owner[places])
        # a cell with few parts is done as a whole: what costs is the run, not the place
        few = owner[depths[owner] <= _ALL]
        whole = [np.arange(start[k], start[k] + 4 ** int(depths[k])) for k in few]
        fresh = np.unique(np.concatenate([places, *whole]))
        large = self.owner[fresh]
        depth = depths[large].astype(np.int64)
        part, within = fresh - start[large], (1 << depth) - 1
        along = ((large // (2 * QUARTER)) << depth) + (part >> depth)
        turn = ((large % (2 * QUARTER)) << depth) + (part & within)
        centre, half = _middle(along, turn, depth)
        radius = radius_at(centre, half)
        # from the middle of the cell to its farthest corner: what holds about the middle holds in a smaller disk about
        # every place
        radii[fresh] = np.where(radius > half, radius - half, _NONE)

    def divide(self, re: Reals, im: Reals, unknown: Mask, radius_at: RadiusAt) -> None:
        """Decide how often large cells are halved."""
        along, turn = _numbers(*_fractions(re[unknown], im[unknown]), re[unknown] < 0, 0)
        cells = np.unique(along * (2 * QUARTER) + turn)
        cells = cells[self.cells.start[cells] < 0]
        if not len(cells):
            return
        depth = _depth(cells, radius_at)
        sizes = 4**depth
        depths, start, radii = self.cells.depth.copy(), self.cells.start.copy(), self.cells.radii
        depths[cells], start[cells] = depth, len(radii) + np.cumsum(sizes) - sizes
        self.owner = np.concatenate([self.owner, np.repeat(cells, sizes)])
        # one assignment of a new object: readers see the old table or the new one, never half of it
        self.cells = Cells(depths, start, np.concatenate([radii, np.zeros(int(sizes.sum()))]))


def _depth(cells: Integers, radius_at: RadiusAt) -> Integers:
    """Return how often some large cells are to be halved; a function of each cell alone.

    Where the middle of a cell says that it is to be divided, the least radius about the middles of 16 parts decides.
    """
    along, turn = cells // (2 * QUARTER), cells % (2 * QUARTER)
    centre, half = _middle(along, turn, 0)
    radius = radius_at(centre, half * 2.0**-DEEPEST)
    with np.errstate(all="ignore"):
        uneven = np.flatnonzero((radius < _PARTS_OF * half) & np.isfinite(centre))
        if len(uneven):
            k = np.arange(16)
            sixteenth_along = ((along[uneven, None] << 2) + (k >> 2)).ravel()
            sixteenth_turn = ((turn[uneven, None] << 2) + (k & 3)).ravel()
            middles, halves = _middle(sixteenth_along, sixteenth_turn, 2)
            found = radius_at(middles, halves * 2.0**-DEEPEST).reshape(-1, 16)
            radius[uneven] = np.where(found > 0, found, np.inf).min(axis=1)
        depth = np.clip(np.ceil(np.log2(_PARTS_OF * half / radius)), 0, DEEPEST)
    # the cell about 0 has no width where the processor is told to take subnormal numbers for 0
    depth = np.where(half > 0, depth, 0)
    return np.where(np.isfinite(centre), depth, 0).astype(np.int64)


def _fractions(re: Reals, im: Reals) -> tuple[Reals, Reals]:
    """|re| + im, and im/(|re| + im), which stands for an angle."""
    with np.errstate(all="ignore"):
        size = np.abs(re) + im
        fraction = im / size
    return np.ascontiguousarray(np.broadcast_to(size, np.shape(fraction))), np.where(size > 0, fraction, 0.0)


def _numbers(size: Reals, fraction: Reals, left: Mask, depth: _Often) -> tuple[Integers, Integers]:
    """Return the cell of a place when all cells are halved ``depth`` times: along its size, and along the angle."""
    turn = np.minimum((fraction * (QUARTER << depth)).astype(np.int64), (QUARTER << depth) - 1)
    # the bits of a double are its exponent and mantissa: shifted, they number the octaves and their quarters
    return size.view(np.int64) >> (DROPPED - depth), np.where(left, (2 * QUARTER << depth) - 1 - turn, turn)


def _middle(along: Integers, turn: Integers, depth: _Often) -> tuple[Complexes, Reals]:
    """Return a place within each cell, and the distance of its farthest corner."""
    left = turn >= (QUARTER << depth)
    turn = np.where(left, (2 * QUARTER << depth) - 1 - turn, turn)
    sizes = [((along + k) << (DROPPED - depth)).view(np.float64) for k in (0, 1)]
    fractions = [(turn + k) / (QUARTER << depth) for k in (0, 1)]
    corners = np.stack([np.where(left, -1, 1) * s * (1 - t) + 1j * s * t for s in sizes for t in fractions])
    centre = corners.mean(axis=0)
    return centre, np.abs(corners - centre).max(axis=0)
