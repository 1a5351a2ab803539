"""Where the functions of q in p² are proved to be analytic, whatever the constants of the orbits.

All orbits share the formulas: p² is a polynomial in the constants of an orbit, whose coefficients are functions of q
alone (``model``). By disk arithmetic (``numeric.disks``) it is proved that they are analytic in a disk of the
complex plane, and there at most ``GROWTH`` times what they are on the real axis. A feature narrower than the disk
cannot be: it would have a pole in it, or grow in it like exp((radius/width)²).

For a place on the real axis the largest such disk is found once, kept in a table for cells of q that are as narrow,
relatively, as doubles with five binary digits; an orbit then needs one look at the table. What the table does not
show is proved for that orbit itself.
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

_DROPPED = 47
"""Bits of a double that do not tell its cell: what is left are the sign, the exponent and five more."""
_CELLS = 1 << (64 - _DROPPED)
_FINE = 16
"""Radii are tried in steps of 2^(1/16)."""
_LONGEST = 40
"""Radii up to 2^40 times the place, or 2^40, are tried."""
_REAL = np.linspace(-0.4, 0.4, 9)
"""Where functions are looked at on the real axis, in units of the radius."""


class Clearance:
    """Functions of x, q = origin + sign·x, and where they are known to be analytic.

    The radius of a cell depends on the functions and the cell alone, so that no result depends on what other orbits
    there are; several threads may fill the table at the same time.
    """

    def __init__(self, parts: Tape, numbers: tuple[Pair, ...], *, alone: bool):
        """Take the functions as they are; nothing is computed.

        Args:
            parts: inputs x, constants, parameters.
            numbers: values of the parameters.
            alone: True where the functions do not depend on the constants. Otherwise there is no table.
        """
        self._parts = parts
        self._numbers = numbers
        self._alone = alone
        self._radii: Any = None

    def radius(self, x: Any) -> Any:
        """Return the radius of a disk about every place of an array in which all is known; 0 for none."""
        if not self._alone:
            return np.zeros(np.shape(x))
        if self._radii is None:
            self._radii = np.full(_CELLS, np.nan)
        keys = np.ascontiguousarray(x, dtype=np.float64).view(np.uint64) >> np.uint64(_DROPPED)
        found = self._radii[keys]
        new = np.isnan(found)
        if new.any():
            fresh = np.unique(keys[new])
            self._radii[fresh] = self._computed(fresh)
            found = self._radii[keys]
        return found

    def _computed(self, keys: Any) -> Any:
        """The radii of some cells, by bisection over powers of 2^(1/16)."""
        ends = [(keys + np.uint64(k) << np.uint64(_DROPPED)).view(np.float64) for k in (0, 1)]
        with np.errstate(all="ignore"):
            middle, half = 0.5 * ends[0] + 0.5 * ends[1], 0.5 * np.abs(ends[1] - ends[0])
            steps = np.log2(np.maximum(1.0, np.abs(middle))) + _LONGEST - np.log2(half)
            usable = np.isfinite(steps) & (half > 0)
            good, bad = np.zeros(len(keys)), np.where(usable, np.ceil(_FINE * steps), 1.0)
            while np.any(bad - good > 1):
                trial = np.floor((good + bad) / 2)
                radius = half * 2 ** (trial / _FINE)
                clear = self.holds((), middle[:, None], radius[:, None], middle[:, None] + radius[:, None] * _REAL)
                good, bad = np.where(clear, trial, good), np.where(clear, bad, trial)
            return np.where(usable & (good > 0), half * 2 ** (good / _FINE) - half, 0.0)

    def holds(self, constants: tuple[Any, ...], centres: Any, radii: Any, real: Any) -> Any:
        """Tell for which orbits all functions are analytic in some disks, and do not grow much in them.

        Args:
            constants: of the orbits, shape (n,); only looked at where the functions depend on them.
            centres, radii: the disks in terms of x, shape (n, disks).
            real: places on the real axis at which the size of functions is taken, shape (n, places).
        """
        with np.errstate(all="ignore"):
            sizes = self._parts.run(Float64(), [real, *self._known(constants)])
            place = Disk(centres.astype(complex), np.abs(radii) + 4 * 2.0**-53 * np.abs(centres))
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
