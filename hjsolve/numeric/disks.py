"""Disks of the complex plane as numbers: what a formula can be over a whole piece of the plane, in doubles.

A disk is a centre and a radius, arrays of any shape. Every operation gives a disk that holds all values of the
operation over the disks it is given, its own rounding included; where the operation meets a singularity or a branch
cut the radius is infinite, "nothing is known here", never an error. A formula whose radius stays finite over a disk is
analytic there: this is what proofs of resolution rest on (``numeric.resolution``). Functions of principal value are
taken as analytic off their cuts only. (Disk arithmetic: Gargantini & Henrici, Numer. Math. 18 (1972) 305.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hjsolve.numeric.arithmetic import Float64

_UNIT = 4 * 2.0**-52
"""Relative rounding of one operation on complex doubles, more than it is."""
_TINY = 1e-300
_HIGHEST = 700.0
"""Real part of an exponent above which exp is beyond the doubles."""


class Disk(NamedTuple):
    """All z with |z − centre| ≤ radius; beyond all doubles where the centre is infinite and the radius 0."""

    centre: Any
    radius: Any

    @property
    def largest(self) -> Any:
        """The greatest |z|."""
        return np.abs(self.centre) + self.radius

    @property
    def least(self) -> Any:
        """The least |z|, not below 0."""
        return np.maximum(np.abs(self.centre) - self.radius, 0.0)

    @property
    def known(self) -> Any:
        """True where the disk is bounded."""
        return np.isfinite(self.radius) & np.isfinite(self.centre)


def hull(x: Disk, y: Disk) -> Disk:
    """Return a disk that holds both."""
    with np.errstate(all="ignore"):
        apart = y.centre - x.centre
        return Disk(x.centre + apart / 2, np.abs(apart) * 0.5000001 + np.maximum(x.radius, y.radius))


def tighter(x: Disk, y: Disk) -> Disk:
    """Return the smaller of two disks that hold the same number, element by element."""
    first = x.radius <= y.radius
    if np.all(first):
        return x
    return Disk(np.where(first, x.centre, y.centre), np.where(first, x.radius, y.radius))


def _rounded(centre: Any, radius: Any) -> Disk:
    """The disk widened by the rounding of its centre; unknown where it is no number."""
    radius = radius * (1 + _UNIT) + (_UNIT * np.abs(centre) + _TINY)
    if np.all(np.isfinite(radius)):
        return Disk(centre, radius)
    lost = ~np.isfinite(radius)
    return Disk(np.where(lost, 0.0, centre), np.where(lost, np.inf, radius))


def _where(good: Any, x: Disk) -> Disk:
    """The disk where ``good``, unknown elsewhere."""
    if np.all(good):
        return x
    return Disk(np.where(good, x.centre, 0.0), np.where(good, x.radius, np.inf))


def _beyond(x: Disk) -> Any:
    return np.isinf(x.centre) & (x.radius == 0)


class Disks:
    """Arithmetic on disks; numbers below it are complex doubles."""

    __slots__ = ()

    def point(self, x: Any) -> Disk:
        """Enclose a real number that may have to be rounded."""
        nearest = float(x)
        return Disk(np.complex128(nearest), np.float64(0.0 if nearest == x else abs(nearest) * 2.0**-52))

    def rational(self, numerator: int, denominator: int) -> Disk:
        value = Float64().rational(numerator, denominator)
        exact = denominator & (denominator - 1) == 0 and abs(numerator) < 2**53
        return Disk(np.complex128(value), np.float64(0.0 if exact else abs(value) * 2.0**-52))

    def pi(self) -> Disk:
        return Disk(np.complex128(np.pi), np.float64(2.0**-52))

    def add(self, x: Disk, y: Disk) -> Disk:
        with np.errstate(all="ignore"):
            return self._kept(x, y, _rounded(x.centre + y.centre, x.radius + y.radius))

    def sub(self, x: Disk, y: Disk) -> Disk:
        with np.errstate(all="ignore"):
            return self._kept(x, y, _rounded(x.centre - y.centre, x.radius + y.radius))

    def _kept(self, x: Disk, y: Disk, total: Disk) -> Disk:
        """What is beyond all doubles stays there when a bounded number is added."""
        if np.all(np.isfinite(total.radius)):
            return total
        one = (_beyond(x) & y.known) | (_beyond(y) & x.known)
        return Disk(np.where(one, np.inf, total.centre), np.where(one, 0.0, total.radius))

    def mul(self, x: Disk, y: Disk) -> Disk:
        with np.errstate(all="ignore"):
            a, b = np.abs(x.centre), np.abs(y.centre)
            product = _rounded(x.centre * y.centre, a * y.radius + x.radius * (b + y.radius))
            if np.all(np.isfinite(product.radius)):
                return product
            far, other = _beyond(x), _beyond(y)
            clear = (far & (other | (y.least > 1e-250))) | (other & (x.least > 1e-250))
            return Disk(np.where(clear, np.inf, product.centre), np.where(clear, 0.0, product.radius))

    def div(self, x: Disk, y: Disk) -> Disk:
        return self.mul(x, self.inverse(y))

    def inverse(self, x: Disk) -> Disk:
        """Return 1/x: the exact image of a disk is a disk."""
        with np.errstate(all="ignore"):
            size = np.abs(x.centre)
            room = (size - x.radius) * (size + x.radius)
            result = _where(size > x.radius, _rounded(np.conj(x.centre) / room, x.radius / room))
            far = _beyond(x)
            return Disk(np.where(far, 0.0, result.centre), np.where(far, _TINY, result.radius)) if far.any() else result

    def power(self, x: Disk, n: int) -> Disk:
        if n < 0:
            return self.inverse(self.power(x, -n))
        if n == 0:
            return self.rational(1, 1)
        with np.errstate(all="ignore"):
            size = np.abs(x.centre)
            grown = size**n * np.expm1(n * np.log1p(x.radius / size))
            radius = np.where(size > 0, grown, x.radius**n)
            result = _rounded(x.centre**n, radius + n * _UNIT * np.abs(x.centre**n))
            if np.all(np.isfinite(result.radius)):
                return result
            far = _beyond(x) | (x.known & (x.least > 1e300 ** (1 / n)))
            return Disk(np.where(far, np.inf, result.centre), np.where(far, 0.0, result.radius))

    def unary(self, name: str, x: Disk) -> Disk:
        with np.errstate(all="ignore"):
            result: Disk = _FUNCTIONS[name](self, x)
            return result

    # ------------------------------------------------------------------ elementary functions

    def _neg(self, x: Disk) -> Disk:
        return Disk(-x.centre, x.radius)

    def _abs(self, x: Disk) -> Disk:
        """The analytic function ±z, off the imaginary axis."""
        real = np.real(x.centre)
        return _where(np.abs(real) > x.radius, Disk(np.where(real < 0, -x.centre, x.centre), x.radius))

    def _exp(self, x: Disk) -> Disk:
        value = np.exp(x.centre)
        spread = np.where(x.radius < 1, np.abs(value) * np.expm1(x.radius), np.exp(np.real(x.centre) + x.radius))
        result = _rounded(value, spread * (1 + _UNIT * (np.abs(x.centre) + x.radius)) + _UNIT * np.abs(value * x.centre))
        return _overflowed(result, np.real(x.centre) - x.radius > _HIGHEST)

    def _sincos(self, x: Disk, name: str) -> Disk:
        """By the addition theorem: |cos z − 1| ≤ cosh r − 1 and |sin z| ≤ sinh r for |z| ≤ r; sinh and cosh alike."""
        of, other = _PAIR[name]
        value, beside = of(x.centre), other(x.centre)
        spread = np.abs(value) * 2 * np.sinh(x.radius / 2) ** 2 + np.abs(beside) * np.sinh(x.radius)
        result = _rounded(value, spread + _UNIT * np.abs(x.centre) * (np.abs(value) + np.abs(beside)))
        part = np.real(x.centre) if name in {"sinh", "cosh"} else np.imag(x.centre)
        return _overflowed(result, np.abs(part) - x.radius > _HIGHEST)

    def _tan(self, x: Disk) -> Disk:
        """Tan z = −i tanh iz."""
        turned = self._tanh(Disk(1j * x.centre, x.radius))
        return Disk(-1j * turned.centre, turned.radius)

    def _tanh(self, x: Disk) -> Disk:
        """±(1 − 2u/(1 + u)), u = exp(∓2z), which does not overflow."""
        side = np.where(np.real(x.centre) < 0, 1.0, -1.0)
        u = self._exp(Disk(2 * side * x.centre, 2 * x.radius))
        one = Disk(np.complex128(1.0), np.float64(0.0))
        # 1 − 2u/(1+u) holds u twice; written as 2/(1 + u) − 1 it holds it once
        rest = self.sub(self.mul(Disk(np.complex128(2.0), np.float64(0.0)), self.inverse(self.add(one, u))), one)
        return Disk(-side * rest.centre, rest.radius)

    def _log(self, x: Disk) -> Disk:
        size = np.abs(x.centre)
        return _where(_off_cut(x), _rounded(np.log(x.centre), -np.log1p(-x.radius / size)))

    def _sqrt(self, x: Disk) -> Disk:
        share = x.radius / np.abs(x.centre)
        root = np.sqrt(x.centre)
        return _where(_off_cut(x), _rounded(root, np.abs(root) * share / (1 + np.sqrt(1 - share))))

    def _by_slope(self, x: Disk, name: str) -> Disk:
        """By the mean value theorem, f′ known over the disk off the cuts of f."""
        slope = self.derivative(name, x)
        clear = slope.known
        if name in _CUT:  # the slope does not see the cut
            clear = clear & _off_cut(_beside(self, x, _CUT[name]))
        return _where(clear, _rounded(_NUMPY[name](x.centre), x.radius * slope.largest))

    # ------------------------------------------------------------------ derivatives of elementary functions

    def derivative(self, name: str, x: Disk) -> Disk:
        """Return Φ′ over a disk."""
        with np.errstate(all="ignore"):
            return _SLOPES[name](self, x)

    def bend(self, name: str, x: Disk) -> Disk:
        """Return Φ″ over a disk."""
        with np.errstate(all="ignore"):
            return _BENDS[name](self, x)

    def shifted(self, x: Disk, by: float) -> Disk:
        """Return x + by."""
        with np.errstate(all="ignore"):
            return _rounded(x.centre + by, x.radius)

    def times(self, x: Disk, by: complex) -> Disk:
        """Return by·x."""
        with np.errstate(all="ignore"):
            return _rounded(by * x.centre, abs(by) * x.radius)


def _overflowed(x: Disk, far: Any) -> Disk:
    if not np.any(far):
        return x
    return Disk(np.where(far, np.inf, x.centre), np.where(far, 0.0, x.radius))


def _off_cut(x: Disk) -> Any:
    """True where a disk does not meet the negative real axis or 0."""
    real = np.real(x.centre)
    return np.where(real > 0, np.abs(x.centre), np.abs(np.imag(x.centre))) > x.radius


_PAIR: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "sin": (np.sin, np.cos), "cos": (np.cos, np.sin), "sinh": (np.sinh, np.cosh), "cosh": (np.cosh, np.sinh),
}  # fmt: skip
_NUMPY: dict[str, Callable[[Any], Any]] = {
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "asinh": np.arcsinh, "acosh": np.arccosh,
    "atanh": np.arctanh,
}  # fmt: skip
_CUT = {"atan": 1.0, "atanh": -1.0}
"""Functions whose cut is where 1 + sign·x² is negative."""


def _root(d: Disks, x: Disk, n: int) -> Disk:
    """x^(n/2)."""
    return d.power(d._sqrt(x), n)


def _beside(d: Disks, x: Disk, sign: float) -> Disk:
    """1 + sign·x²."""
    return d.shifted(d.times(d.power(x, 2), sign), 1.0)


def _hyperbola(d: Disks, x: Disk) -> Disk:
    """√(x − 1) √(x + 1)."""
    return d.mul(d._sqrt(d.shifted(x, -1.0)), d._sqrt(d.shifted(x, 1.0)))


def _sign(x: Disk) -> Disk:
    real = np.real(x.centre)
    return _where(np.abs(real) > x.radius, Disk(np.sign(real) + 0j, 0.0 * x.radius))


_FUNCTIONS: dict[str, Callable[[Disks, Disk], Disk]] = {
    "neg": Disks._neg, "abs": Disks._abs, "exp": Disks._exp, "log": Disks._log, "sqrt": Disks._sqrt,
    "tan": Disks._tan, "tanh": Disks._tanh,
    **{name: (lambda d, x, name=name: d._sincos(x, name)) for name in _PAIR},
    **{name: (lambda d, x, name=name: d._by_slope(x, name)) for name in _NUMPY},
}  # fmt: skip
_SLOPES: dict[str, Callable[[Disks, Disk], Disk]] = {
    "neg": lambda d, x: Disk(-1.0 + 0 * x.centre, 0.0 * x.radius),
    "abs": lambda d, x: _sign(x),
    "exp": Disks._exp,
    "log": Disks.inverse,
    "sqrt": lambda d, x: d.times(_root(d, x, -1), 0.5),
    "sin": lambda d, x: d._sincos(x, "cos"),
    "cos": lambda d, x: d._neg(d._sincos(x, "sin")),
    "sinh": lambda d, x: d._sincos(x, "cosh"),
    "cosh": lambda d, x: d._sincos(x, "sinh"),
    "tan": lambda d, x: _beside(d, d._tan(x), 1.0),
    "tanh": lambda d, x: _beside(d, d._tanh(x), -1.0),
    "asin": lambda d, x: _root(d, _beside(d, x, -1.0), -1),
    "acos": lambda d, x: d._neg(_root(d, _beside(d, x, -1.0), -1)),
    "atan": lambda d, x: d.inverse(_beside(d, x, 1.0)),
    "asinh": lambda d, x: _root(d, _beside(d, x, 1.0), -1),
    "acosh": lambda d, x: d.inverse(_hyperbola(d, x)),
    "atanh": lambda d, x: d.inverse(_beside(d, x, -1.0)),
}
_BENDS: dict[str, Callable[[Disks, Disk], Disk]] = {
    "neg": lambda d, x: Disk(0 * x.centre, 0.0 * x.radius),
    "abs": lambda d, x: d.times(_sign(x), 0.0),
    "exp": Disks._exp,
    "log": lambda d, x: d._neg(d.power(x, -2)),
    "sqrt": lambda d, x: d.times(_root(d, x, -3), -0.25),
    "sin": lambda d, x: d._neg(d._sincos(x, "sin")),
    "cos": lambda d, x: d._neg(d._sincos(x, "cos")),
    "sinh": lambda d, x: d._sincos(x, "sinh"),
    "cosh": lambda d, x: d._sincos(x, "cosh"),
    "tan": lambda d, x: d.times(d.mul(d._tan(x), _beside(d, d._tan(x), 1.0)), 2.0),
    "tanh": lambda d, x: d.times(d.mul(d._tanh(x), _beside(d, d._tanh(x), -1.0)), -2.0),
    "asin": lambda d, x: d.mul(x, _root(d, _beside(d, x, -1.0), -3)),
    "acos": lambda d, x: d._neg(d.mul(x, _root(d, _beside(d, x, -1.0), -3))),
    "atan": lambda d, x: d.times(d.mul(x, d.power(_beside(d, x, 1.0), -2)), -2.0),
    "asinh": lambda d, x: d._neg(d.mul(x, _root(d, _beside(d, x, 1.0), -3))),
    "acosh": lambda d, x: d._neg(d.mul(x, d.power(_hyperbola(d, x), -3))),
    "atanh": lambda d, x: d.times(d.mul(x, d.power(_beside(d, x, -1.0), -2)), 2.0),
}
