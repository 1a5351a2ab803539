"""The maps from an anomaly to a coordinate at complex phases, in doubles.

The maps are those of ``one_coordinate.anomaly`` and ``one_coordinate.stretched_anomaly``; here they serve to bound
integrands in a strip of the complex plane, so that a few digits are enough.
"""

from __future__ import annotations

from functools import singledispatch
from typing import NamedTuple, cast

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk
from hjsolve.arithmetic.elliptic import jacobi, quarter_period
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Complexes, Reals
from hjsolve.errors import required
from hjsolve.one_coordinate.anomaly import BarrierAnomaly, Libration, Rotation, TwoBarrierAnomaly
from hjsolve.one_coordinate.stretched_anomaly import Inner, Stretched

_FLOAT = Float64()
_EDGE = np.exp(2j * np.pi * (np.arange(8) + 0.5) / 8)
_MARGIN = 1.2
"""The radius of a map's image over the greatest distance seen at eight points of the edge."""


class ComplexPlace(NamedTuple):
    """Where a complex phase puts the coordinate, arrays of one shape.

    Attributes:
        q: position; of an angle that goes round up to whole turns.
        from_lower, to_upper: q − a and b − q; None for a rotation.
        stretch: |dq/dψ| / √|(q − a)(b − q)|, the factor of dq/p.
    """

    q: Complexes
    from_lower: Complexes | None
    to_upper: Complexes | None
    stretch: Reals

    @property
    def from_upper(self) -> Complexes | None:
        """The distance q − b."""
        return None if self.to_upper is None else -self.to_upper


def jacobi_complex(u: Complexes, complement: float, quarter: float) -> tuple[Complexes, Complexes, Complexes]:
    """Return sn, cn, dn of complex arguments, |Re u| ≤ 2K, by the addition theorem (DLMF 22.8.19-21).

    Args:
        u: complex array.
        complement: k′² = 1 − k².
        quarter: K, the quarter period.
    """
    if complement == 1.0:
        return np.sin(u), np.cos(u), np.ones_like(u)
    s, c, d = jacobi(np.real(u), complement, quarter, _FLOAT)
    parameter = 1.0 - complement
    other = quarter_period(parameter, _FLOAT)
    # 2iK′ is a period of sn²: no strip goes that far, and the clip keeps the arithmetic finite
    y = np.clip(np.imag(u), -1.999 * other, 1.999 * other)
    s1, c1, d1 = jacobi(y, parameter, other, _FLOAT)
    # a sum of squares: it vanishes at the poles alone
    below = c1 * c1 + parameter * (s * s1) ** 2
    sn = (s * d1 + 1j * c * d * s1 * c1) / below
    cn = (c * c1 - 1j * s * d * s1 * d1) / below
    dn = (d * c1 * d1 - 1j * parameter * s * c * s1) / below
    return cast("Complexes", sn), cast("Complexes", cn), cast("Complexes", dn)


@singledispatch
def complex_place(anomaly: object, phase: Complexes) -> ComplexPlace:
    """Return where a complex phase puts the coordinate.

    Args:
        anomaly: the map; its constants are rounded to doubles.
        phase: complex array, real parts in [−π, π].

    Raises:
        TypeError: a kind of map that has no rule here.
    """
    raise TypeError(f"no map from phases like {phase!r} to places: {anomaly!r}")


@complex_place.register
def _(anomaly: Libration, phase: Complexes) -> ComplexPlace:
    width, low, up = (float(x) for x in (anomaly.width, anomaly.near_lower, anomaly.near_upper))
    quarter, complement = float(anomaly.quarter), float(anomaly.complement)
    sn, cn, _ = jacobi_complex(phase * (quarter / np.pi), complement, quarter)
    below = 1 + low * cn * cn
    # both fractions from their own squares: their sum is 1, but neither is a difference
    x, y = sn * sn / below, (1 + low) * cn * cn / below
    stretch = 2 * quarter / np.pi * np.sqrt(np.abs((1 + up * y) * (1 + low * x)) * complement)
    return ComplexPlace(_nearer(anomaly, width * x, width * y), width * x, width * y, stretch)


@complex_place.register
def _(anomaly: BarrierAnomaly, phase: Complexes) -> ComplexPlace:
    width, left, right = (float(x) for x in (anomaly.width, anomaly.from_lower, anomaly.from_upper))
    quarter, complement = float(anomaly.quarter), float(anomaly.complement)
    sn, cn, dn = jacobi_complex(phase * (2 * quarter / np.pi), complement, quarter)
    # as on the real axis: sin²(φ/2) from sn²/(2(1 + cn)) on the half where cn is near 1
    forward = np.real(cn) > 0
    large = np.where(forward, 1 + cn, 1 - cn) / 2
    low: Complexes = np.where(forward, sn * sn / (4 * large), large)
    high: Complexes = np.where(forward, large, sn * sn / (4 * large))
    below = left * low + right * high
    x: Complexes = left * low / below
    y: Complexes = right * high / below
    stretch = 2 * quarter / np.pi * np.abs(dn / below) * np.sqrt(left * right)
    return ComplexPlace(_nearer(anomaly, width * x, width * y), width * x, width * y, stretch)


@complex_place.register
def _(anomaly: Rotation, phase: Complexes) -> ComplexPlace:
    quarter, complement = float(anomaly.quarter), float(anomaly.complement)
    sn, cn, dn = jacobi_complex(quarter * phase / np.pi, complement, quarter)
    # e^(i am) = cn + i sn, continued off the axis by the principal logarithm
    amplitude = -1j * np.log(cn + 1j * sn)
    q = float(anomaly.slow) + anomaly.direction * (2 * amplitude - np.pi)
    return ComplexPlace(q, None, None, 2 * quarter / np.pi * np.abs(dn))


@complex_place.register
def _(anomaly: TwoBarrierAnomaly, phase: Complexes) -> ComplexPlace:
    quarter, complement = float(anomaly.quarter), float(anomaly.complement)
    scale, tilt, root = float(anomaly.scale), float(anomaly.tilt), complement**0.5
    # the map is centred at χ = π: v = 2K(χ − π)/π with |v| ≤ 2K
    turned: Complexes = np.where(np.real(phase) < 0, phase + np.pi, phase - np.pi)
    sn, cn, dn = jacobi_complex(2 * quarter * turned / np.pi, complement, quarter)
    w = -1j * np.log(cn / dn + 1j * root * sn / dn)
    s, c = np.sin(w / 2), np.cos(w / 2)
    beside = scale * c + anomaly.direction * tilt * s
    angle = -0.5j * np.log((beside + 1j * s) / (beside - 1j * s))
    stretch = np.abs(scale / (s * s + beside * beside) * root / dn) * 2 * quarter / np.pi
    return ComplexPlace(float(anomaly.slow) + 2 * anomaly.direction * angle, None, None, stretch)


@complex_place.register
def _(anomaly: Stretched, phase: Complexes) -> ComplexPlace:
    slope = anomaly.slope
    k = np.arange(1, len(slope.cosines) + 1)
    cosines = slope.cosines.astype(complex)
    sines = 0 * cosines if slope.sines is None else slope.sines.astype(complex)
    # off the axis e^(ikψ) falls and e^(−ikψ) grows: two power series instead of sines and cosines
    up, down = (cosines - 1j * sines) / 2, (cosines + 1j * sines) / 2  # of e^{ikψ} and e^{−ikψ}
    wave: Complexes = np.exp(1j * phase)
    rising, rising_rate = _power_sums(np.stack([up / (1j * k), up]), wave)
    falling, falling_rate = _power_sums(np.stack([down / (1j * k), down]), 1 / wave)
    χ = phase + rising - falling + np.sum((-1.0) ** k * sines / k)  # χ = π at ψ = π
    place = complex_place(anomaly.inner, χ)
    return place._replace(stretch=place.stretch * np.abs(1 + rising_rate + falling_rate))


_AT_ONCE, _BLOCK = 256, 64
"""Places and powers in one product of matrices: few enough to stay in the cache, and for BLAS to use one thread."""


def _power_sums(coefficients: Complexes, z: Complexes) -> Complexes:
    """Return the sum cₖ zᵏ over k = 1, 2, … for each row of coefficients, shape (rows, *z.shape).

    A block of powers at a time is a product of matrices; the blocks are joined by Horner's rule in z^64.
    """
    rows, count = coefficients.shape
    blocks = max(-(-count // _BLOCK), 1)
    padded = np.zeros((rows, blocks * _BLOCK), dtype=complex)
    padded[:, :count] = coefficients
    table = np.ascontiguousarray(padded.reshape(rows, blocks, _BLOCK).transpose(1, 0, 2))
    total = np.empty((rows, z.size), dtype=complex)
    for first in range(0, z.size, _AT_ONCE):
        part = z.reshape(-1)[first : first + _AT_ONCE]
        # z … z⁶⁴ once for all rows of coefficients
        powers = np.cumprod(np.broadcast_to(part, (_BLOCK, part.size)), axis=0)
        sums = table @ powers
        joined = sums[-1]
        for one in sums[-2::-1]:
            joined = joined * powers[-1] + one
        total[:, first : first + _AT_ONCE] = joined
    return total.reshape(rows, *z.shape)


def _nearer(anomaly: Libration | BarrierAnomaly, from_lower: Complexes, to_upper: Complexes) -> Complexes:
    lower = np.abs(from_lower) < np.abs(to_upper)
    return np.where(lower, float(anomaly.lower) + from_lower, float(anomaly.upper) - to_upper)


class PlaceDisks(NamedTuple):
    """Disks that hold q, q − a and q − b; the last two None for a rotation."""

    q: Disk
    from_lower: Disk | None
    from_upper: Disk | None


def place_disks(anomaly: Inner | Stretched, χ: Complexes, radius: Reals) -> PlaceDisks:
    """Enclose the images of disks of the phase: the distance is greatest on the edge (maximum principle).

    Args:
        χ: centres, complex, shape (m,).
        radius: of the disks, shape (m,).
    """
    points = np.concatenate([χ[None], χ + radius * _EDGE[:, None]])
    found = complex_place(anomaly, points)

    def disk(values: Complexes) -> Disk:
        apart = np.max(np.abs(values[1:] - values[0]), axis=0)
        return Disk(values[0], _MARGIN * apart + 1e-15 * np.abs(values[0]))

    if found.from_lower is None:
        # the angle is known up to turns: the edge is brought next to the centre
        across = np.real(found.q - found.q[0]) + np.pi
        turned = found.q[0] + across % (2 * np.pi) - np.pi + 1j * np.imag(found.q - found.q[0])
        return PlaceDisks(disk(turned), None, None)
    return PlaceDisks(disk(found.q), disk(found.from_lower), disk(required(found.from_upper)))
