"""Disks of the complex plane as numbers: what a formula can be over a whole piece of the plane, in doubles.

A disk is a centre and a radius, arrays of any shape. Every operation gives a disk that holds all values of the
operation over the disks it is given, its own rounding included; where the operation meets a singularity or a branch
cut, or overflows, the radius is not a finite number, "nothing is known here", never an error. A formula whose radius
stays finite over a disk is analytic there: this is what proofs of resolution rest on (``one_coordinate.resolution``).
Functions of principal value are taken as analytic off their cuts only. (Gargantini & Henrici, Numer. Math. 18 (1972)
305.)

Whoever runs a formula in this arithmetic silences numpy's warnings around it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic import function_rules
from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.function_rules import BY_VALUE, OF_ITSELF
from hjsolve.arithmetic.number_types import Complexes, Mask, Numeric, Reals

_UNIT = 4 * EPS
"""Relative rounding of one operation on complex doubles, more than it is."""
_NUMPY: dict[str, Callable[[Complexes], Complexes]] = {
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "asinh": np.arcsinh, "acosh": np.arccosh,
    "atanh": np.arctanh,
}  # fmt: skip
_PAIR: dict[str, tuple[Callable[[Complexes], Complexes], Callable[[Complexes], Complexes]]] = {
    "sin": (np.sin, np.cos), "cos": (np.cos, np.sin), "sinh": (np.sinh, np.cosh), "cosh": (np.cosh, np.sinh),
}  # fmt: skip
_CUT = {"atan": 1.0, "atanh": -1.0}
"""Functions whose cut is where 1 + sign·x² is negative."""
_ODD = frozenset({"asin", "atan", "asinh", "atanh"})
"""Functions that vanish at 0 and keep their digits next to it."""


class Disk(NamedTuple):
    """All z with |z − centre| ≤ radius; nothing is known where the radius is not finite."""

    centre: Complexes
    radius: Reals

    def __neg__(self) -> Disk:
        return Disk(-self.centre, self.radius)

    @property
    def largest(self) -> Reals:
        """The greatest |z|."""
        return np.abs(self.centre) + self.radius

    @property
    def least(self) -> Reals:
        """The least |z|, not below 0."""
        return np.maximum(np.abs(self.centre) - self.radius, 0.0)

    @property
    def known(self) -> Mask:
        """True where the disk is bounded."""
        return np.isfinite(self.radius) & np.isfinite(self.centre)


def single(centre: complex, radius: float) -> Disk:
    """Return the disk of one number: a scalar of numpy is an array without axes."""
    return Disk(np.complex128(centre), np.float64(radius))  # type: ignore[arg-type]


def hull(x: Disk, y: Disk) -> Disk:
    """Return a disk that holds both.

    Args:
        y: another one, of the same shape.
    """
    apart = y.centre - x.centre
    return Disk(x.centre + apart / 2, np.abs(apart) * 0.5000001 + np.maximum(x.radius, y.radius))


def tighter(x: Disk, y: Disk) -> Disk:
    """Return the smaller of two disks that hold the same number, element by element.

    Args:
        y: another one that holds the same number.
    """
    first = (x.radius <= y.radius) | ~np.isfinite(y.radius)
    return x if first.all() else Disk(np.where(first, x.centre, y.centre), np.where(first, x.radius, y.radius))


def _where(good: Mask, x: Disk) -> Disk:
    """Return the disk where ``good``, unknown elsewhere."""
    return x if np.all(good) else Disk(x.centre, np.where(good, x.radius, np.inf))


class Disks:
    """Arithmetic on disks; numbers below it are complex doubles."""

    __slots__ = ()

    def point(self, x: Numeric) -> Disk:
        """Enclose a real number that may have to be rounded.

        Args:
            x: a float, or a number of many digits.
        """
        nearest = float(x)
        return single(nearest, 0.0 if nearest == x else abs(nearest) * EPS)

    def rational(self, numerator: int, denominator: int) -> Disk:
        """Return a disk about a fraction; its radius is zero where a double holds it exactly."""
        value = Float64().rational(numerator, denominator)
        exact = denominator & (denominator - 1) == 0 and abs(numerator) < 2**53
        return single(value, 0.0 if exact else abs(value) * EPS)

    def pi(self) -> Disk:
        return single(np.pi, EPS)

    def add(self, x: Disk, y: Disk) -> Disk:
        """Return a disk that holds every x + y."""
        centre = x.centre + y.centre
        return Disk(centre, x.radius + y.radius + _UNIT * np.abs(centre))

    def sub(self, x: Disk, y: Disk) -> Disk:
        """Return a disk that holds every x − y."""
        centre = x.centre - y.centre
        return Disk(centre, x.radius + y.radius + _UNIT * np.abs(centre))

    def mul(self, x: Disk, y: Disk) -> Disk:
        """Return a disk that holds every x·y."""
        a, b = np.abs(x.centre), np.abs(y.centre)
        return Disk(x.centre * y.centre, a * (y.radius + _UNIT * b) + x.radius * (b + y.radius))

    def div(self, x: Disk, y: Disk) -> Disk:
        """Return a disk that holds every x/y; nothing is known where y holds zero."""
        return self.mul(x, self.inverse(y))

    def inverse(self, x: Disk) -> Disk:
        """Return 1/x: the exact image of a disk is a disk."""
        size = np.abs(x.centre)
        # 1/x has its centre at c̄/(|c|² − r²) and the radius r/(|c|² − r²)
        room = (size - x.radius) * (size + x.radius)
        fraction = x.radius / room
        return Disk(x.centre.conj() / room, np.where(room > 0, fraction + _UNIT * (fraction + 1 / size), np.inf))

    def power(self, x: Disk, n: int) -> Disk:
        """Return a disk that holds every xⁿ, narrower than a product of n different disks."""
        if n < 0:
            return self.inverse(self.power(x, -n))
        if n == 0:
            return self.rational(1, 1)
        size, value = np.abs(x.centre), x.centre**n
        grown = (size + x.radius) ** n - size**n
        return Disk(value, grown + n * _UNIT * (size + x.radius) ** n)

    def unary(self, name: str, x: Disk) -> Disk:
        """Return a disk that holds every value of a function; nothing is known where x meets a singularity or a cut."""
        result: Disk = _FUNCTIONS[name](self, x)
        return result

    def derivative(self, name: str, x: Disk) -> Disk:
        """Return Φ′ over a disk."""
        if name == "abs":
            return _sign(x)
        if name == "turned":
            return Disk(1j + 0 * x.centre, 0 * x.radius)
        return function_rules.slope(self, name, x, self.unary(name, x) if name in BY_VALUE else x)

    def bend(self, name: str, x: Disk) -> Disk:
        """Return Φ″ over a disk."""
        if name in {"abs", "turned"}:
            return Disk(0 * x.centre, 0 * x.radius)
        value = x if name == "log" or name in _NUMPY else self.unary(name, x)
        return function_rules.bend(self, name, x, value, x if name in OF_ITSELF else self.derivative(name, x))

    def chord(self, name: str, x: Disk, y: Disk, at_x: Disk, at_y: Disk) -> Disk:
        """Return Φ[x, y]: the quotient of differences, or the mean of Φ′ over the hull: the smaller disk.

        Args:
            name: of Φ.
            x, y: the two places.
            at_x, at_y: Φ of them.
        """
        quotient = self.div(self.sub(at_y, at_x), self.sub(y, x))
        return tighter(quotient, self.derivative(name, hull(x, y)))

    def shifted(self, x: Disk, by: float) -> Disk:
        """Return x + by."""
        centre = x.centre + by
        return Disk(centre, x.radius + _UNIT * np.abs(centre))

    def times(self, x: Disk, by: complex) -> Disk:
        """Return by·x."""
        return Disk(by * x.centre, abs(by) * x.radius + _UNIT * np.abs(by * x.centre))


def _abs(_: Disks, x: Disk) -> Disk:
    """Return the analytic function ±z, off the imaginary axis."""
    real = np.real(x.centre)
    return _where(np.abs(real) > x.radius, Disk(np.where(real < 0, -x.centre, x.centre), x.radius))


def _exp(_: Disks, x: Disk) -> Disk:
    # |e^{c + z} − e^c| ≤ e^{Re c}(e^r − 1) for |z| ≤ r, written without cancellation and without ∞·0
    value, most = np.exp(x.centre), np.exp(np.real(x.centre) + x.radius)
    return Disk(value, most * (-np.expm1(-x.radius) + _UNIT * (1 + np.abs(x.centre))))


def _sincos(x: Disk, name: str) -> Disk:
    """By the addition theorem: |cos z − 1| ≤ cosh r − 1 and |sin z| ≤ sinh r for |z| ≤ r; sinh and cosh alike."""
    of, other = _PAIR[name]
    value, beside = of(x.centre), np.abs(other(x.centre))
    size = np.abs(value)
    # |sin c| (cosh r − 1) + |cos c| sinh r, with cosh r − 1 = 2 sinh²(r/2)
    spread = size * 2 * np.sinh(x.radius / 2) ** 2 + beside * np.sinh(x.radius)
    near = np.minimum(np.abs(x.centre), 1.0)
    return Disk(value, spread + _UNIT * (1 + np.abs(x.centre)) * (size + near * beside))


def _tan(d: Disks, x: Disk) -> Disk:
    """Tan as −i tanh ix."""
    turned = _tanh(d, Disk(1j * x.centre, x.radius))
    return Disk(-1j * turned.centre, turned.radius)


def _decaying(d: Disks, x: Disk, n: float) -> tuple[Reals, Disk]:
    """Return the sign s of Re x and exp(−n s x), which is not above e^(n·radius)."""
    side = np.where(np.real(x.centre) < 0, -1.0, 1.0)
    return side, _exp(d, Disk(-n * side * x.centre, n * x.radius))


def _tanh(d: Disks, x: Disk) -> Disk:
    """Tanh as s (2/(1 + u) − 1), u = exp(−2 s x), which does not overflow."""
    side, u = _decaying(d, x, 2.0)
    rest = d.shifted(d.times(d.inverse(d.shifted(u, 1.0)), 2.0), -1.0)
    return Disk(side * rest.centre, rest.radius)


def _sech(d: Disks, x: Disk) -> Disk:
    """Sech as 2u/(1 + u²), u = exp(−s x)."""
    _, u = _decaying(d, x, 1.0)
    return d.times(d.mul(u, d.inverse(d.shifted(d.power(u, 2), 1.0))), 2.0)


def _off_cut(x: Disk) -> Mask:
    """Return True where a disk does not meet the negative real axis or 0."""
    real = np.real(x.centre)
    return np.where(real > 0, np.abs(x.centre), np.abs(np.imag(x.centre))) > x.radius


def _log(_: Disks, x: Disk) -> Disk:
    value = np.log(x.centre)
    fraction = np.minimum(x.radius / np.abs(x.centre), 1.0)
    return _where(_off_cut(x), Disk(value, -np.log1p(-fraction) + _UNIT * (1 + np.abs(value))))


def _sqrt(_: Disks, x: Disk) -> Disk:
    fraction = np.minimum(x.radius / np.abs(x.centre), 1.0)
    root = np.sqrt(x.centre)
    return _where(_off_cut(x), Disk(root, np.abs(root) * (fraction / (1 + np.sqrt(1 - fraction)) + _UNIT)))


def _by_slope(d: Disks, x: Disk, name: str) -> Disk:
    """By the mean value theorem, f′ known over the disk off the cuts of f."""
    slope, value = d.derivative(name, x), _NUMPY[name](x.centre)
    clear = slope.known & _off_cut(_beside(d, x, _CUT[name])) if name in _CUT else slope.known
    noise = np.minimum(np.abs(x.centre), 1.0) if name in _ODD else 1.0
    return _where(clear, Disk(value, x.radius * slope.largest + _UNIT * (noise + np.abs(value))))


def _beside(d: Disks, x: Disk, sign: float) -> Disk:
    """1 + sign·x²."""
    return d.shifted(d.times(d.power(x, 2), sign), 1.0)


def _sign(x: Disk) -> Disk:
    real = np.real(x.centre)
    return _where(np.abs(real) > x.radius, Disk(np.sign(real) + 0j, 0.0 * x.radius))


def _paired(name: str) -> Callable[[Disks, Disk], Disk]:
    return lambda _, x: _sincos(x, name)


def _inverse_function(name: str) -> Callable[[Disks, Disk], Disk]:
    return lambda d, x: _by_slope(d, x, name)


_FUNCTIONS: dict[str, Callable[[Disks, Disk], Disk]] = {
    "neg": lambda _, x: -x, "abs": _abs, "exp": _exp, "log": _log, "sqrt": _sqrt, "tan": _tan, "tanh": _tanh,
    "sech": _sech, "turned": lambda _, x: Disk(1j * x.centre, x.radius),
    **{name: _paired(name) for name in _PAIR}, **{name: _inverse_function(name) for name in _NUMPY},
}  # fmt: skip
