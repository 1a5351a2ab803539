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

from typing import Any

import numpy as np

from hjsolve.numeric.arithmetic import Float64
from hjsolve.numeric.disks import Disk, Disks
from hjsolve.numeric.error_free import Pair
from hjsolve.numeric.tape import Tape

GROWTH = 100.0
"""How much larger than on the real axis functions may be in a disk."""

_DROPPED = 48
"""Bits of a double that do not tell its cell: what is left are the exponent and four more."""
_TURNS = 32
"""Cells in half a turn."""
_CELLS = _TURNS << (63 - _DROPPED)
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
        self._radii: Any = None

    def radius(self, x: Any) -> Any:
        """Return the radius of a disk about every place in which all is known.

        Args:
            x: places, real or complex; of z and its conjugate all is the same.

        Returns:
            Array of the same shape; negative where nothing is known.
        """
        if not self._alone:
            return np.full(np.shape(x), _NONE)
        if self._radii is None:
            self._radii = np.zeros(_CELLS)  # unknown; what is never looked at takes no memory
        keys = _cell(np.real(x), np.abs(np.imag(x)))
        found = self._radii[keys]
        if not found.all():
            fresh = np.unique(keys[found == 0])
            self._radii[fresh] = self._computed(fresh)
            found = self._radii[keys]
        return found

    def _computed(self, keys: Any) -> Any:
        """The radii of some cells, by bisection over powers of 2^(1/16)."""
        with np.errstate(all="ignore"):
            centre, half = _middle(keys)
            steps = np.log2(np.maximum(1.0, np.abs(centre))) + _LONGEST - np.log2(half)
            usable = np.isfinite(steps) & (half > 0)
            side = np.where((centre.real < 0) & self._both, -1.0, 1.0) * self._side
            real = (side * np.abs(centre))[:, None] * _REAL
            good, bad = np.zeros(len(keys)), np.where(usable, np.ceil(_FINE * steps), 1.0)
            while np.any(bad - good > 1):
                trial = np.floor((good + bad) / 2)
                clear = self.holds((), centre[:, None], (half * 2 ** (trial / _FINE))[:, None], real)
                good, bad = np.where(clear, trial, good), np.where(clear, bad, trial)
            return np.where(usable & (good > 0), half * 2 ** (good / _FINE) - half, _NONE)

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
            disks = self._parts.run(Disks(), [place, *known])
            good = np.isfinite(centres).all(axis=1)
            for value, size in zip(disks, sizes, strict=True):
                scale = np.broadcast_to(np.abs(size), real.shape)
                scale = np.where(np.isfinite(scale), scale, 0.0).max(axis=1)
                grown = np.where(value.known, value.largest, np.inf)
                good &= np.broadcast_to(grown <= GROWTH * scale[:, None], centres.shape).all(axis=1)
        return good

    def _known(self, constants: tuple[Any, ...]) -> list[Any]:
        count = len(self._parts.inputs) - 1 - len(self._numbers)
        values = [0.0] * count if self._alone else [c[:, None] for c in constants]
        return [*values, *(pair.high for pair in self._numbers)]


def _cell(re: Any, im: Any) -> Any:
    """The cell of places re ± i·im: by |re| + im as a double, and by im/(|re| + im) in the place of an angle."""
    with np.errstate(all="ignore"):
        size = np.abs(re) + im
        turn = np.minimum((_TURNS // 2 * (im / size)).astype(np.int64), _TURNS // 2 - 1)
    turn = np.where(size > 0, np.where(re < 0, _TURNS - 1 - turn, turn), 0)
    return (np.ascontiguousarray(size).view(np.int64) >> _DROPPED) * _TURNS + turn


def _middle(keys: Any) -> tuple[Any, Any]:
    """A place within each cell, and the distance of its farthest corner."""
    turn = keys % _TURNS
    left = turn >= _TURNS // 2
    turn = np.where(left, _TURNS - 1 - turn, turn)
    sizes = [((keys // _TURNS + k) << _DROPPED).view(np.float64) for k in (0, 1)]
    shares = [(turn + k) / (_TURNS // 2) for k in (0, 1)]
    corners = np.stack([np.where(left, -1, 1) * s * (1 - t) + 1j * s * t for s in sizes for t in shares])
    centre = corners.mean(axis=0)
    return centre, np.abs(corners - centre).max(axis=0)
