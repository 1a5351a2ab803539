"""The real roots of many polynomials at once, proved: how many there are, their order, and how far each may be off.

Coefficients come in two doubles with bounds on their errors. Starts are roots in doubles, corrections those of
Weierstrass, with the polynomial evaluated in two doubles,

    Wᵢ = P(zᵢ) / (a ∏ⱼ (zᵢ − zⱼ)),        zᵢ ← zᵢ − Wᵢ,

whose denominators are differences of doubles: they keep their digits where roots nearly meet, and P′ does not. Smith's
theorem makes a proof of the last of them: the disks |z − zᵢ| ≤ n |Wᵢ| hold all roots, and m disks that are apart from
the others hold m of them. So a disk about a real number that meets no other holds one root, which is real, since the
conjugate of a root of a real polynomial is a root, too. Where disks meet, or one that is not centred on the real axis
reaches it, nothing is proved, the answer says so, and the caller takes more digits.

Weierstrass, Sitzungsber. Akad. Berlin (1891) 1085; Smith, J. ACM 17 (1970) 137, theorem 3; Bini and Fiorentino, Numer.
Algorithms 23 (2000) 127.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, two_product, two_sum
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Complexes, Mask, Reals

_ROUNDS = 16
"""Corrections at most: from starts with half of their digits three are enough, roots that nearly meet take ten."""
_SETTLED = 0.75 * EPS
"""A correction of a real root by its size, below which it is the rounding of the root, half a unit at most."""
_FORMULAS = 1e-3
"""The distance of two roots by their size, above which Cardano's formula has more than half of their digits."""
_SPREAD = 1e-4
"""The least root by the greatest, below which it has fewer: two small ones are nearly double next to the greatest."""
_ALONE = 1e-3
"""An imaginary part below this part of the distance to the next root is none: a conjugate would be nearer than that."""
_PAIRED = 0.125
"""Half the distance of two roots by their middle, below which they are corrected together: m ± h loses no digits."""
_OF_HORNER = 2.0**-98
"""The error of one step of Horner's rule in two doubles, by what it adds: 2⁻¹⁰⁴ times a few, and ten to spare."""
_OF_STEPS = 16 * EPS
"""Relative error of a correction, over the degree: roundings of a value, of a product of complex numbers, and more."""
_OF_BOUNDS = 1 + 1e-10
"""By which bounds are multiplied that were worked out in doubles themselves, with fewer than a thousand roundings."""
_LOST = 1e-300
"""More than what is lost where a coefficient is scaled below the least double."""
_PAIRS = DoubleDouble()


@dataclass(frozen=True)
class RealRoots:
    """The real roots of m polynomials of degree n.

    Attributes:
        roots: ascending, inf after the last, of shape (n, m).
        errors: how far each may be off, of the same shape.
        unsure: where neither number nor order are proved, of shape (m,).
    """

    roots: Reals
    errors: Reals
    unsure: Mask


def real_roots(coefficients: Sequence[Pair], errors: Sequence[Reals]) -> RealRoots:
    """Return the real roots of polynomials, and where they are not proved.

    Args:
        coefficients: of the highest power first, in two doubles, of one shape.
        errors: how far each may be off.
    """
    with np.errstate(all="ignore"):
        return _proved(coefficients, errors)


def _proved(coefficients: Sequence[Pair], errors: Sequence[Reals]) -> RealRoots:
    shape = np.shape(coefficients[0].high)
    high, low, off = (np.stack([np.ravel(part) for part in parts]) for parts in (
        [c.high for c in coefficients], [c.low for c in coefficients], errors))  # fmt: skip
    degree = len(high) - 1
    # in x = λy the roots y are about 1 in size; powers of two scale without an error
    power = np.rint(np.log2(size_of_roots(list(high)))).astype(np.int64)
    moved = np.arange(degree, -1, -1)[:, None] * power
    moved = moved - np.max(np.where(high == 0, -(2**30), np.frexp(high)[1] + moved), axis=0)
    high, low, off = np.ldexp(high, moved), np.ldexp(low, moved), np.ldexp(off, moved)
    known = np.isfinite(high).all(axis=0) & np.isfinite(off).all(axis=0) & (abs(high[0]) > off[0])
    known &= np.isfinite(high / high[0]).all(axis=0)  # the sum of the roots, too, is a double
    unit = np.where(np.arange(degree + 1) == 0, 1.0, 0.0)[:, None]
    unit[-1] = -1.0  # any polynomial with simple roots, where there is none
    P = _Polynomials(np.where(known, high, unit), np.where(known, low, 0.0), np.where(known, off, 0.0))
    z, step, radius, error = _corrected(P, _on_axis_where_alone(_starts(P)))
    distance = abs(_differences(z, np.inf))
    real = z.imag == 0
    apart = (distance > (radius[:, None] + radius[None]) * _OF_BOUNDS).all(axis=1)
    # complex ones, too, must be apart: else a root might be in the other's disk, and corrections count on its own
    proved = (apart & (real | (abs(z.imag) > radius))).all(axis=0) & np.isfinite(radius).all(axis=0) & known
    # within its disk, so that the order stays
    values = np.where(real, z.real - step.real, np.inf)
    order = np.argsort(values, axis=0)
    roots = np.ldexp(np.take_along_axis(values, order, axis=0), power)
    error = np.ldexp(np.take_along_axis(np.where(real, error, 0.0), order, axis=0), power)
    return RealRoots(roots.reshape(degree, *shape), error.reshape(degree, *shape), ~proved.reshape(shape))


@dataclass(frozen=True)
class _Polynomials:
    """Coefficients in two doubles and bounds on their errors, each of shape (degree + 1, m)."""

    high: Reals
    low: Reals
    off: Reals

    def __call__(self, z: Complexes) -> tuple[Complexes, Reals]:
        """Return P at numbers of shape (n, m), and how far it may be off."""
        size, place = np.broadcast_to(abs(self.high[0]), z.shape), abs(z)
        off = np.broadcast_to(self.off[0], z.shape)
        for c, own in zip(self.high[1:], self.off[1:], strict=True):
            size, off = size * place + abs(c), off * place + own
        value = np.empty(z.shape, dtype=complex)
        real = z.imag == 0
        root, column = np.nonzero(real)
        value[real] = self._on_axis(z.real[root, column], column)
        root, column = np.nonzero(~real)
        value[~real] = self._in_plane(z[root, column], column)
        return value, (off + (len(self.high) * _OF_HORNER) * size + _LOST) * _OF_BOUNDS

    def _on_axis(self, x: Reals, column: NDArray[np.int64]) -> Reals:
        total = Pair(self.high[0, column], self.low[0, column])
        for high, low in zip(self.high[1:], self.low[1:], strict=True):
            total = _PAIRS.add(_times(total, x), Pair(high[column], low[column]))
        return np.asarray(total.high + total.low)

    def _in_plane(self, z: Complexes, column: NDArray[np.int64]) -> Complexes:
        x, y, zero = z.real, z.imag, np.zeros(len(z))
        real, imaginary = Pair(self.high[0, column], self.low[0, column]), Pair(zero, zero)
        for high, low in zip(self.high[1:], self.low[1:], strict=True):
            turned = _PAIRS.sub(_times(real, x), _times(imaginary, y))
            imaginary = _PAIRS.add(_times(real, y), _times(imaginary, x))
            real = _PAIRS.add(turned, Pair(high[column], low[column]))
        return np.asarray(real.high + 1j * imaginary.high)

    def of(self, columns: Mask) -> _Polynomials:
        """Return some of them."""
        return _Polynomials(self.high[:, columns], self.low[:, columns], self.off[:, columns])


def _times(a: Pair, x: Reals) -> Pair:
    """Return a number in two doubles times a double."""
    p, e = two_product(a.high, x)
    return two_sum(p, e + a.low * x)


def _differences(z: Complexes, same: float) -> Complexes:
    """Return zᵢ − zⱼ, of shape (n, n, m), with a number in place of zᵢ − zᵢ."""
    found = z[:, None] - z[None]
    found[range(len(z)), range(len(z))] = same
    return found


def _starts(P: _Polynomials) -> Complexes:
    """Roots in doubles, of which corrections need half of the digits: by formulas where these have them, else LAPACK's.

    Eigenvalues of companion matrices are balanced there, so that roots of all sizes keep most of their digits; of a
    cubic they take eight times as long as Cardano's formula.
    """
    degree, monic = len(P.high) - 1, P.high[1:] / P.high[0]
    z = _quadratic(*monic) if degree == 2 else _cubic(*monic) if degree == 3 else np.full(monic.shape, 0j)
    hard = ~(abs(_differences(z, np.inf)).min(axis=1) > _FORMULAS * abs(z)).all(axis=0) if degree > 2 else degree < 2
    if degree > 2:
        hard |= abs(z).min(axis=0) < _SPREAD * abs(z).max(axis=0)
    if np.any(hard):
        some = np.flatnonzero(np.broadcast_to(hard, monic.shape[1:]))
        z[:, some] = _eigenvalues(monic[:, some])
    zero = (P.high[-1] == 0) & (P.off[-1] == 0)  # P(0) = 0: corrections of relative size would never settle there
    z[np.argmin(abs(z), axis=0)[zero], np.flatnonzero(zero)] = 0.0
    for one in range(1, len(z)):  # starts that coincide would divide by zero
        for other in range(one):
            z[one] = np.where(z[one] == z[other], z[one] * (1 + 1e-9 * one) + 1e-12 * one, z[one])
    return z


def _eigenvalues(monic: Reals) -> Complexes:
    """Return the roots by companion matrices: of 1/x where one root is much greater than the others, which it hides."""
    degree = len(monic)
    inverse = np.concatenate([monic[-2::-1], np.ones_like(monic[:1])]) / np.where(monic[-1] == 0, 1.0, monic[-1])
    powers = 1 / np.arange(1, degree + 1)[:, None]
    far, near = ((abs(c) ** powers).max(axis=0) for c in (monic, inverse))  # of the greatest, and of 1/the least
    turned = (far > near) & (monic[-1] != 0) & np.isfinite(inverse).all(axis=0)
    companion = np.zeros((monic.shape[1], degree, degree))
    companion[:, range(1, degree), range(degree - 1)] = 1.0
    companion[:, 0] = -np.where(turned, inverse, monic).T
    z = np.linalg.eigvals(companion).T.astype(complex)
    column, least = np.flatnonzero(turned), np.argmin(abs(z), axis=0)[turned]
    z[least, column] = 1.0
    z[:, column] = 1 / z[:, column]
    z[least, column] = 0.0  # the greatest, by the sum of all: its inverse has lost its digits
    z[least, column] = -monic[0, column] - z[:, column].sum(axis=0)
    return z


def _quadratic(b: Reals, c: Reals) -> Complexes:
    half = -b.astype(complex) / 2
    far = half + np.where(half.real < 0, -1, 1) * np.sqrt(half**2 - c)
    return np.stack([far, c / np.where(far == 0, 1.0, far)])


def _cubic(a: Reals, b: Reals, c: Reals) -> Complexes:
    """Return the roots of x³ + ax² + bx + c: x = y − a/3, y = u − p/3u for the three u³ = −q/2 ± √(q²/4 + p³/27)."""
    p, q = b - a**2 / 3, a * (2 * a**2 / 27 - b / 3) + c
    root = np.sqrt((q**2 / 4 + p**3 / 27).astype(complex))
    cube = -q / 2 + np.where(q < 0, root, -root)  # of both signs that in which nothing cancels
    u = np.where(cube == 0, 0.0, cube ** (1 / 3)) * np.exp(2j * np.pi / 3 * np.arange(3))[:, None]
    return np.asarray(u - np.where(u == 0, 0.0, p / (3 * np.where(u == 0, 1.0, u))) - a / 3)


def _on_axis_where_alone(z: Complexes) -> Complexes:
    """Return the roots, real where no conjugate can be as near as its imaginary part says."""
    nearest = abs(_differences(z, np.inf)).min(axis=1)
    return np.where(abs(z.imag) <= _ALONE * nearest, z.real.astype(complex), z)


def _corrected(P: _Polynomials, z: Complexes) -> tuple[Complexes, Complexes, Reals, Reals]:
    """Correct starts until one correction more is right to the last digit.

    Where no disks meet, P(zᵢ) = a ∏ (zᵢ − ζⱼ) gives ζᵢ = zᵢ − Wᵢ ∏ⱼ (zᵢ − zⱼ)/(zᵢ − ζⱼ) for the roots ζⱼ, j ≠ i in the
    product, which is within s/(1 − s) of 1, with s = Σⱼ rⱼ/|zᵢ − zⱼ|: so zᵢ − Wᵢ needs no second look at P.

    Returns:
        The places z, the corrections W there, the radii of Smith's disks about z, and how far z − W may be off.
    """
    waiting, step, n = np.ones(z.shape[1], dtype=bool), np.zeros_like(z), len(z)
    radius, error = np.full(z.shape, np.inf), np.full(z.shape, np.inf)
    for turn in range(_ROUNDS + 1):
        own, there = P.of(waiting), z[:, waiting]
        value, off = own(there)
        distance = _differences(there, 1.0)
        product, leading = np.prod(distance, axis=1), abs(own.high[0]) * (1 - EPS) - own.off[0]
        W, size = value / (own.high[0] * product), leading * abs(product)
        above = (abs(value) + off) / size * _OF_BOUNDS
        near = n * above / abs(distance)
        near[range(n), range(n)] = 0.0
        s = near.sum(axis=1)
        moved = np.where(s < 1, s / (1 - s), np.inf) * _OF_BOUNDS
        step[:, waiting], radius[:, waiting] = W, n * above
        error[:, waiting] = (
            above * (moved + n * _OF_STEPS + own.off[0] / leading) + off / size + EPS / 2 * abs(there - W)
        ) * _OF_BOUNDS
        last = (abs(W) <= _SETTLED * abs(there)) | (abs(W) * moved <= EPS / 8 * abs(there))
        left = ~last.all(axis=0) & (turn < _ROUNDS)
        if not left.any():
            break
        waiting[waiting] = left
        there, W = there[:, left], W[:, left]
        corrected = there - np.where(np.isfinite(W), W, 0.0)
        if turn:
            corrected = _nearest_pair(there, corrected, W)
        z[:, waiting] = _on_axis_where_alone(corrected)
    return z, step, radius, error


def _nearest_pair(z: Complexes, moved: Complexes, step: Complexes) -> Complexes:
    """Correct the two roots that are nearest to each other together, where both are real or conjugates.

    With d = (zᵢ − zⱼ)/2 and h from their middle, P/(a ∏ of the others) is h² + (Wᵢ + Wⱼ)h − d² + d(Wᵢ − Wⱼ) but for the
    change of the others. Its roots are real or conjugates as those of P are; single corrections of two real numbers
    would stay real for ever.
    """
    if len(z) < 2:
        return moved
    m = np.arange(z.shape[1])
    i, j = np.unravel_index(np.argmin(abs(_differences(z, np.inf)).reshape(-1, len(m)), axis=0), (len(z), len(z)))
    d, middle = (z[i, m] - z[j, m]) / 2, (z[i, m] + z[j, m]) / 2
    half = (step[i, m] + step[j, m]) / 2
    inside = half**2 + d**2 - d * (step[i, m] - step[j, m])
    mirrored = (z[i, m].imag == -z[j, m].imag) & (abs(z[i, m].real - z[j, m].real) <= abs(d) * (z[i, m].imag == 0) * 2)
    fits = mirrored & np.isfinite(inside) & (abs(half) < abs(middle)) & (abs(d) < _PAIRED * abs(middle))
    root = np.sqrt(inside.real.astype(complex))
    between = middle.real - half.real
    moved[i, m] = np.where(fits, between + root, moved[i, m])
    moved[j, m] = np.where(fits, between - root, moved[j, m])
    return moved


def size_of_roots(coefficients: Sequence[Reals]) -> Reals:
    """Return the geometric mean of the sizes of the roots that are not 0.

    Args:
        coefficients: of the highest power first, arrays of one shape.
    """
    degree = len(coefficients) - 1
    found = np.ones_like(coefficients[0])
    for k in range(1, degree + 1):  # the last coefficient that is not zero
        ratio = abs(coefficients[k] / np.where(coefficients[0] == 0, 1.0, coefficients[0]))
        found = np.where((ratio > 0) & np.isfinite(ratio), ratio ** (1 / k), found)
    return found
