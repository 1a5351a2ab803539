"""Disks with their logarithms: what a formula can be over a disk of the complex plane, products and powers kept exact.

The square of a disk is enclosed by a disk that may hold 0 where the disk does not, and then nothing is known of its
inverse or its root. A logarithm does not lose that: next to the disk of values of f there is a disk of ℓ, f = exp ℓ
with ℓ analytic. Products add the ℓ, powers and roots multiply them, and where |g| < |f|,

    log(f + g) = log f + log(1 + exp(log g − log f)),   log cosh z = z + log(1 + exp(−2z)) − log 2  for Re z > 0.

Roots and logarithms are those that one comes to from the real axis, straight up to the centre of the disk: the
argument of f is followed along this way. So no cut is met that only the principal value has (√cosh²z is analytic where
cosh z is not 0), and disks that overlap have the same function wherever all that lies below them is known, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, tighter
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Complexes, Mask, Reals

_D, _F = Disks(), Float64()
_LARGEST_RATIO = 0.999
"""How large |g/f| may be where f + g is seen from f."""
_PLACES_ON_THE_WAY = 13
"""Places on the way from the real axis to the centre."""
_TURN = 2.0
"""More than this from one place to the next, and the argument is lost."""


class Followed(NamedTuple):
    """Values on the way, shape (…, places), and their logarithm."""

    value: Complexes
    power: Complexes


class Logged(NamedTuple):
    """Values, their logarithm (of infinite radius where it is not known), and both on the way to the centre."""

    value: Disk
    power: Disk
    path: Followed

    @property
    def largest(self) -> Reals:
        """A bound on |f|, infinite where there is none."""
        with np.errstate(all="ignore"):
            plain = np.where(self.value.known, self.value.largest, np.inf)
            other = np.where(self.power.known, np.exp(np.real(self.power.centre) + self.power.radius), np.inf)
            return np.fmin(plain, other)


class DisksInLogarithms:
    """Arithmetic on such disks."""

    __slots__ = ()

    def variable(self, x: Disk) -> Logged:
        """Take a disk as it is; a way leads to it from the real axis."""
        rise = np.linspace(0.0, 1.0, _PLACES_ON_THE_WAY) if np.any(np.imag(x.centre)) else np.ones(1)
        centre = np.asarray(x.centre)[..., None]
        return _logged(x, centre.real + 1j * centre.imag * rise)

    def constant(self, x: Disk) -> Logged:
        """Take a number in doubt."""
        return _logged(x, np.asarray(x.centre)[..., None])

    def rational(self, numerator: int, denominator: int) -> Logged:
        """Return a fraction, with its logarithm."""
        return self.constant(_D.rational(numerator, denominator))

    def pi(self) -> Logged:
        return self.constant(_D.pi())

    def add(self, x: Logged, y: Logged) -> Logged:
        """Return x + y; logarithm: log x + log(1 + exp(log y − log x)) where |y| < |x|, or the other way round."""
        plain = _logged(_D.add(x.value, y.value), x.path.value + y.path.value)
        return _beside(_beside(plain, x, y, 1.0), y, x, 1.0)

    def sub(self, x: Logged, y: Logged) -> Logged:
        """Return x − y, with −y as y turned by π."""
        plain = _logged(_D.sub(x.value, y.value), x.path.value - y.path.value)
        turned = Disk(y.power.centre + 1j * np.pi, y.power.radius)
        return _beside(_beside(plain, x, y, -1.0), y._replace(power=turned), x, 1.0)

    def mul(self, x: Logged, y: Logged) -> Logged:
        """Return x·y; the logarithms are added."""
        plain = _logged(_D.mul(x.value, y.value), x.path.value * y.path.value)
        return _with(plain, _D.add(x.power, y.power))

    def div(self, x: Logged, y: Logged) -> Logged:
        """Return x/y; the logarithms are subtracted."""
        return self.mul(x, self.power(y, -1))

    def power(self, x: Logged, n: int) -> Logged:
        """Return xⁿ; the logarithm is multiplied by n."""
        return _with(_logged(_D.power(x.value, n), x.path.value**n), _D.times(x.power, n))

    def unary(self, name: str, x: Logged) -> Logged:
        """Return a function of x; roots and logarithms are continued along the way to the centre."""
        with np.errstate(all="ignore"):
            if name == "sqrt":
                nothing = Disk(np.zeros_like(x.power.centre), np.full_like(x.power.radius, np.inf))
                return _with(_logged(nothing, np.exp(0.5 * x.path.power)), _D.times(x.power, 0.5))
            if name == "log":
                return _logged(x.power, x.path.power)
            plain = _logged(_D.unary(name, x.value), _F.unary(name, x.path.value))
            if name == "exp":
                return _with(plain, x.value)
            if name in {"cosh", "sinh"}:
                return _with(plain, _hyperbolic(name, x.value))
            return plain


def _logged(value: Disk, path: Complexes) -> Logged:
    """With the logarithm of a disk that does not hold 0."""
    with np.errstate(all="ignore"):
        power = _followed(path)
        size = np.abs(value.centre)
        radius = -np.log1p(-value.radius / size) * (1 + 1e-15) + 1e-15
        found = _where(value.known & (size > value.radius), Disk(np.log(value.centre + 0j), radius))
    return Logged(value, _turned(found, power[..., -1]), Followed(path, power))


def _followed(path: Complexes) -> Complexes:
    """Return the logarithm along the way, from the principal one on the real axis; NaN where it turns too fast."""
    power = np.log(path + 0j)
    start = np.where(np.imag(power[..., :1]) < -3, 2j * np.pi, 0)  # −π is π
    if path.shape[-1] == 1:
        return power + start
    turn = np.diff(np.imag(power), axis=-1)
    turns = np.rint(turn / (2 * np.pi))
    steady = np.all(np.abs(turn - 2 * np.pi * turns) < _TURN, axis=-1, keepdims=True)
    power = power + np.where(steady, start, np.nan)
    power[..., 1:] -= 2j * np.pi * np.cumsum(turns, axis=-1)
    return power


def _with(plain: Logged, power: Disk) -> Logged:
    """Use another enclosure of the logarithm where it is better."""
    power = _turned(power, plain.path.power[..., -1])
    return plain._replace(value=tighter(plain.value, _D.unary("exp", power)), power=tighter(plain.power, power))


def _turned(power: Disk, centre: Complexes) -> Disk:
    """Return the logarithm that one comes to on the way; nothing is known where that was lost."""
    with np.errstate(all="ignore"):
        turns = np.rint((np.imag(centre) - np.imag(power.centre)) / (2 * np.pi))
        return _where(np.isfinite(turns), Disk(power.centre + 2j * np.pi * turns, power.radius))


def _beside(plain: Logged, x: Logged, y: Logged, sign: float) -> Logged:
    """Use log x + log(1 ± exp(log y − log x))."""
    ratio = _D.times(_D.unary("exp", _D.sub(y.power, x.power)), sign)
    small = ratio.largest < _LARGEST_RATIO
    if not np.any(small):
        return plain
    return _with(plain, _D.add(x.power, _D.unary("log", _D.shifted(_where(small, ratio), 1.0))))


def _hyperbolic(name: str, x: Disk) -> Disk:
    side = np.where(np.real(x.centre) < 0, -1.0, 1.0)
    outward = Disk(side * x.centre, x.radius)
    rest = _D.times(_D.unary("exp", _D.times(outward, -2.0)), 1.0 if name == "cosh" else -1.0)
    known = _where(rest.largest < _LARGEST_RATIO, rest)
    return _D.shifted(_D.add(outward, _D.unary("log", _D.shifted(known, 1.0))), -float(np.log(2)))


def _where(good: Mask, x: Disk) -> Disk:
    if np.all(good):
        return x
    return Disk(np.where(good, x.centre, 0.0), np.where(good, x.radius, np.inf))
