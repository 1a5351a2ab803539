"""Disks with their logarithms: what a formula can be over a disk of the complex plane, products and powers kept exact.

The square of a disk is enclosed by a disk that may hold 0 where the disk does not, and then nothing is known of its
inverse or its root. A logarithm does not lose that: beside the disk D of values of f there is a disk L with f = exp ℓ,
ℓ analytic and in L. Products add the L, powers and roots multiply them, and where |g| < |f|,

    log(f + g) = log f + log(1 + exp(log g − log f)),   log cosh z = z + log(1 + exp(−2z)) − log 2  for Re z > 0.

L is the principal logarithm: where it might not be, nothing is known, so that the functions on disks that overlap are
the same analytic function. About a real centre it may leave the principal range, because the disk itself connects
all of it with the centre (``whole``).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hjsolve.numeric.disks import Disk, Disks, tighter

_D = Disks()
_MOST = 0.999
"""How large |g/f| may be where f + g is seen from f."""
_PRINCIPAL = 3.1415


class Logged(NamedTuple):
    """Values and their logarithm; ``power`` is unknown where its radius is infinite."""

    value: Disk
    power: Disk

    @property
    def largest(self) -> Any:
        """A bound on |f|, infinite where there is none."""
        with np.errstate(all="ignore"):
            plain = np.where(self.value.known, self.value.largest, np.inf)
            other = np.where(self.power.known, np.exp(np.real(self.power.centre) + self.power.radius), np.inf)
            return np.fmin(plain, other)


class Logarithms:
    """Arithmetic on such disks.

    Attributes:
        whole: where the disk of the variable has a real centre; shape of the disks.
    """

    def __init__(self, whole: Any):
        self._whole = whole

    def variable(self, x: Disk) -> Logged:
        """Take a disk as it is."""
        return self._from_value(x)

    def rational(self, numerator: int, denominator: int) -> Logged:
        return self._from_value(_D.rational(numerator, denominator))

    def pi(self) -> Logged:
        return self._from_value(_D.pi())

    def add(self, x: Logged, y: Logged) -> Logged:
        plain = self._from_value(_D.add(x.value, y.value))
        return self._beside(self._beside(plain, x, y, 1.0), y, x, 1.0)

    def sub(self, x: Logged, y: Logged) -> Logged:
        plain = self._beside(self._from_value(_D.sub(x.value, y.value)), x, y, -1.0)
        turned = Disk(y.power.centre + 1j * np.pi, y.power.radius)
        return self._beside(plain, y._replace(power=turned), x, 1.0)

    def _beside(self, plain: Logged, x: Logged, y: Logged, sign: float) -> Logged:
        """Use log x + log(1 ± exp(log y − log x))."""
        ratio = _D.times(_exp(_D.sub(y.power, x.power)), sign)
        small = ratio.largest < _MOST
        if not np.any(small):
            return plain
        return self._with(plain, _D.add(x.power, _D.unary("log", _D.shifted(_where(small, ratio), 1.0))))

    def mul(self, x: Logged, y: Logged) -> Logged:
        return self._with(self._from_value(_D.mul(x.value, y.value)), _D.add(x.power, y.power))

    def div(self, x: Logged, y: Logged) -> Logged:
        return self.mul(x, self.power(y, -1))

    def power(self, x: Logged, n: int) -> Logged:
        return self._with(self._from_value(_D.power(x.value, n)), _D.times(x.power, n))

    def unary(self, name: str, x: Logged) -> Logged:
        plain = self._from_value(_D.unary(name, x.value))
        if name == "exp":
            return self._with(plain, x.value)
        if name == "sqrt":
            return self._with(plain._replace(value=_nothing(x.value)), _D.times(x.power, 0.5))
        if name == "log":
            return self._from_value(x.power)
        if name in {"cosh", "sinh"}:
            return self._with(plain, self._hyperbolic(name, x.value))
        return plain

    def _hyperbolic(self, name: str, x: Disk) -> Disk:
        side = np.where(np.real(x.centre) < 0, -1.0, 1.0)
        outward = Disk(side * x.centre, x.radius)
        rest = _exp(_D.times(outward, -2.0))
        rest = rest if name == "cosh" else Disk(-rest.centre, rest.radius)
        known = _where(rest.largest < _MOST, rest)
        found = _D.shifted(_D.add(outward, _D.unary("log", _D.shifted(known, 1.0))), -float(np.log(2)))
        turned = (name == "sinh") & (side < 0)
        return Disk(found.centre + np.where(turned, 1j * np.pi, 0.0), found.radius)

    def _from_value(self, value: Disk) -> Logged:
        """The logarithm where the disk is off 0 and the negative axis; about it where the centre is real."""
        with np.errstate(all="ignore"):
            plain = _D.unary("log", value)
            if np.any(~plain.known & self._whole):
                size = np.abs(value.centre)
                off = self._whole & value.known & (size > value.radius)
                about = Disk(np.log(value.centre), -np.log1p(-value.radius / size) * (1 + 1e-15) + 1e-15)
                plain = tighter(plain, _where(off, about))
        return Logged(value, plain)

    def _with(self, plain: Logged, power: Disk) -> Logged:
        """Use another enclosure of the logarithm, where it is better and sure to be of the same function."""
        with np.errstate(all="ignore"):
            turns = np.ceil(np.imag(power.centre) / (2 * np.pi) - 0.500001)  # a real function: multiples of π
            power = Disk(power.centre - 2j * np.pi * np.where(self._whole, turns, 0.0), power.radius)
            principal = np.abs(np.imag(power.centre)) + power.radius < _PRINCIPAL
            power = _where(principal | self._whole, power)
            return Logged(tighter(plain.value, _exp(power)), tighter(plain.power, power))


def _exp(x: Disk) -> Disk:
    return _D.unary("exp", x)


def _nothing(x: Disk) -> Disk:
    return Disk(np.zeros_like(x.centre), np.full_like(x.radius, np.inf))


def _where(good: Any, x: Disk) -> Disk:
    good = np.broadcast_to(good, np.broadcast_shapes(np.shape(good), np.shape(x.centre), np.shape(x.radius)))
    return Disk(np.where(good, x.centre, 0.0), np.where(good, x.radius, np.inf))
