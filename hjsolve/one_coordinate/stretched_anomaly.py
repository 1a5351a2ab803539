"""A second change of variable where the elliptic anomaly alone would need too many nodes.

The anomalies of ``one_coordinate.anomaly`` take care of the four branch points of p dq nearest to the motion. Where
more come close (a wheel that just passes several barriers, features of a potential) the new phase ψ grows like

    dψ/dχ ~ (3⁴ + Σₖ (sin²((χ − χₖ)/2) + δₖ²/4)^−2)^¼

with a rough place χₖ ± iδₖ for each (and its mirror image for an even anomaly): nearly the inverse of the distance to
the nearest one, so that all of them are equally far from the real axis in ψ. The number of nodes is in proportion to
the integral of that, 2 log(8/δₖ) for a lonely place; a crowd of places costs little more than one of them.
The map used is a trigonometric polynomial close to the inverse, χ = ψ + Σ (cₖ/k) sin kψ …
with coefficients that are doubles, taken as exact numbers: any such map with dχ/dψ > 0 leaves the integrals what they
are, so it need not be known better than that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import cast

import numpy as np

from hjsolve.arithmetic.floats import EPS, ComplexPoints, Float64, Multi
from hjsolve.arithmetic.fourier import at_midpoints
from hjsolve.arithmetic.number_types import Complexes, Mpf, Numeric, Reals
from hjsolve.arithmetic.root_finding import bracketed_root, bracketed_roots
from hjsolve.one_coordinate.anomaly import BarrierAnomaly, Libration, Rotation, TwoBarrierAnomaly
from hjsolve.one_coordinate.fourier_series import FourierSeries, midpoints
from hjsolve.one_coordinate.phase_map import Place

_SAMPLES, _MOST_SAMPLES = 4096, 32768  # doubled in between
_LEGENDRE_TERMS = 12
"""Newton's method within a piece begins near and stops by itself; twelve terms give a rate to 1e-9, as ψ grows by 1."""
_BASE = 3.0
"""What keeps zeros that are as far from the real axis as they may be, 1 or so, as far in ψ as the rough places."""
_LAST = 1e-4
"""Coefficients of dχ/dψ below that part of its least value are left out: they would not make the map a better one."""
_NARROWEST = 1e-12  # width of a step of the phase that doubles resolve
_AT_ONCE, _BLOCK = 256, 64
"""Places and powers in one product of matrices: few enough to stay in the cache, and for BLAS to use one thread."""

Inner = Libration | BarrierAnomaly | Rotation | TwoBarrierAnomaly


@dataclass(frozen=True, eq=False)
class Stretched:
    """An anomaly whose phase ψ moves slowly through the rough places of another one's χ.

    In its methods ψ is a phase, a number of the arithmetic, or an array of doubles.

    Attributes:
        inner: the anomaly in χ.
        slope: dχ/dψ, a trigonometric polynomial in doubles with mean 1.
    """

    inner: Inner
    slope: FourierSeries

    @property
    def even(self) -> bool:
        return self.inner.even

    @property
    def direction(self) -> int:
        return self.inner.direction

    @property
    def lower(self) -> Mpf:
        return self.inner.lower  # type: ignore[union-attr]

    @property
    def upper(self) -> Mpf:
        return self.inner.upper  # type: ignore[union-attr]

    @cached_property
    def _waves(self) -> list[tuple[Fraction, Fraction]]:
        """Coefficients of χ − ψ as exact numbers, the last one first; k times as much are those of dχ/dψ."""
        k = np.arange(1, len(self.slope.cosines) + 1)
        parts = (self.slope.cosines / k, 0 * k if self.slope.sines is None else self.slope.sines / k)
        return [(Fraction(float(c)), Fraction(float(s))) for c, s in zip(*parts, strict=True)][::-1]

    @cached_property
    def _shift(self) -> float:
        """What makes χ = π at ψ = π."""
        return float(self.slope.oscillation(np.array([np.pi]))[0])

    @lru_cache(maxsize=8)  # noqa: B019
    def _fixed(self, bits: int) -> list[tuple[int, int]]:
        return [(int(c * 2**bits), int(s * 2**bits)) for c, s in self._waves]

    def place(self, ψ: Numeric, arithmetic: Float64 | Multi) -> Place:
        """Return the place at ψ, |ψ| ≤ 2π.

        Args:
            arithmetic: in which q is worked out.
        """
        χ, rate = self.unstretched(ψ, arithmetic)
        return self.inner.place(χ, arithmetic)._replace(rate=rate)

    def places(self, nodes: int, arithmetic: Multi) -> Iterator[Place]:
        """Yield the places at the midpoints of equal parts of half a turn (of a turn where it is not even)."""
        bits, context = arithmetic.bits + 32, arithmetic.context
        waves = self._fixed(bits)[::-1]
        # Σ (−1)ᵏ sₖ: what the series is at ψ = π, taken off so that χ = π is ψ = π
        shift = sum(s if k % 2 == 0 else -s for k, (_, s) in enumerate(waves, 1))
        turn = 2 * nodes if self.even else nodes
        # all nodes by one fast transform in integers: Horner's rule would cost as many products as nodes times terms
        _, moved = at_midpoints([(c, -s) for c, s in waves], turn, bits)
        rates, _ = at_midpoints([(k * c, -k * s) for k, (c, s) in enumerate(waves, 1)], turn, bits)
        for ψ, v, du in zip(midpoints(nodes, even=self.even, bits=arithmetic.bits), moved, rates, strict=False):
            place = self.inner.place(ψ + context.mpf(v + shift) * context.mpf(2) ** -bits, arithmetic)
            yield place._replace(rate=1 + context.mpf(du) * context.mpf(2) ** -bits)

    def unstretched(self, ψ: Numeric, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric]:
        """Return χ(ψ) and dχ/dψ.

        Args:
            arithmetic: in which χ is worked out.
        """
        if isinstance(arithmetic, ComplexPoints):
            return cast("tuple[Numeric, Numeric]", self._off_axis(cast("Complexes", ψ)))
        return arithmetic.choose(lambda _: self._by_series(ψ), lambda many: self._in_fixed_point(cast("Mpf", ψ), many))

    def _by_series(self, ψ: Numeric) -> tuple[Numeric, Numeric]:
        """Return the same in doubles."""
        return ψ + (self.slope.oscillation(ψ) - self._shift), self.slope.value(ψ)

    def _off_axis(self, ψ: Complexes) -> tuple[Complexes, Complexes]:
        """Return the same at complex ψ: e^{ikψ} falls and e^{−ikψ} grows, two power series in place of sines."""
        k = np.arange(1, len(self.slope.cosines) + 1)
        cosines = self.slope.cosines.astype(complex)
        sines = 0 * cosines if self.slope.sines is None else self.slope.sines.astype(complex)
        up, down = (cosines - 1j * sines) / 2, (cosines + 1j * sines) / 2  # of e^{ikψ} and e^{−ikψ}
        wave: Complexes = np.exp(1j * ψ)
        rising, rising_rate = _power_sums(np.stack([up / (1j * k), up]), wave)
        falling, falling_rate = _power_sums(np.stack([down / (1j * k), down]), 1 / wave)
        return ψ + rising - falling + np.sum((-1.0) ** k * sines / k), 1 + rising_rate + falling_rate

    def _in_fixed_point(self, ψ: Mpf, arithmetic: Multi) -> tuple[Mpf, Mpf]:
        """χ = ψ + Im Σ (cₖ − i sₖ) e^{ikψ} + Σ (−1)ᵏ sₖ and its derivative by Horner's rule in integers."""
        bits, context = arithmetic.bits + 32, arithmetic.context
        # the coefficients are doubles, taken as exact: the map is the same at every precision
        one = context.mpf(2) ** bits
        x, y = (int(context.nint(part * one)) for part in context.cos_sin(ψ))
        waves = self._fixed(bits)
        u = v = du = dv = shift = 0
        for k, (c, s) in zip(range(len(waves), 0, -1), waves, strict=True):
            u, v, du, dv = u + c, v - s, du + k * c, dv - k * s
            u, v = (u * x - v * y) >> bits, (u * y + v * x) >> bits
            du, dv = (du * x - dv * y) >> bits, (du * y + dv * x) >> bits
            shift += s if k % 2 == 0 else -s
        return ψ + context.mpf(v + shift) / one, 1 + context.mpf(du) / one

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:
        """Return ψ in (−π, π] of a position: Newton's method kept inside a bracket."""
        χ = self.inner.phase(q, forward, arithmetic)

        def off(ψ: Mpf) -> tuple[Mpf, Mpf]:
            value, rate = self._in_fixed_point(ψ, arithmetic)
            return value - χ, rate

        return bracketed_root(off, -arithmetic.pi(), arithmetic.pi(), arithmetic.bits, start=χ, rising=True, size=1)

    def slope_at(self, ψ: Reals) -> Reals:
        """Return dχ/dψ."""
        return self.unstretched(ψ, Float64())[1]  # type: ignore[return-value]

    def rounding(self, ψ: Reals) -> Reals:
        """Return the rounding of χ(ψ) as an uncertainty of ψ."""
        return 8 * EPS * np.pi / np.abs(self.slope.value(ψ))

    def in_doubles(self) -> Stretched:
        """Return the same with its constants rounded to doubles, for vectorised use."""
        return replace(self, inner=self.inner.in_doubles())

    def lowered(self, arithmetic: Multi) -> Stretched:
        """Return the same with its constants rounded to fewer digits."""
        return replace(self, inner=self.inner.lowered(arithmetic))


def stretched(inner: Inner, places: list[tuple[float, float]]) -> Stretched | None:
    """Make the phase that resolves rough places χₖ of width δₖ.

    Args:
        inner: the anomaly in χ.
        places: (χₖ, δₖ); without mirror images.

    Returns:
        The map; None where doubles cannot hold one.
    """
    # an even map needs an even density: the mirror images on the other half turn
    if inner.even:
        places = places + [(-χ, δ) for χ, δ in places if 0 < χ < np.pi]
    narrowest = _NARROWEST
    # a width below what doubles resolve makes dχ/dψ negative by rounding: wider places are a worse map, and still a map
    while narrowest < 0.1:
        slope = _inverse_slope([(χ, max(δ, narrowest)) for χ, δ in places], even=inner.even)
        if slope is not None:
            return Stretched(inner, slope)
        narrowest *= 8
    return None


def _inverse_slope(places: list[tuple[float, float]], *, even: bool) -> FourierSeries | None:
    """dχ/dψ as a trigonometric polynomial in ψ; None where rounding would make it negative."""
    growth = _Growth.through(places)
    samples = _SAMPLES
    while samples <= _MOST_SAMPLES:
        fraction = np.arange(samples) / samples
        # dχ/dψ at equal steps of ψ from −π, and its Fourier coefficients
        # the inverse function ψ ↦ dχ/dψ, from which the polynomial takes its coefficients
        values = growth.rate(fraction)
        waves = np.fft.rfft(np.roll(values, samples // 2)) / samples
        size = np.abs(waves[1:])
        # the coefficients that matter for the least value; there must be samples enough for them
        top = int(np.max(np.nonzero(size > _LAST * np.min(values))[0], initial=0)) + 1
        if top <= samples // 4:
            cosines, sines = 2 * waves.real[1 : top + 1], -2 * waves.imag[1 : top + 1]
            slope = FourierSeries(1, cosines, None if even else sines, samples, 0.0)
            # cut off, the polynomial is still near dχ/dψ > 0 everywhere, so it is positive itself
            good = np.abs(slope.value(2 * np.pi * fraction - np.pi) - values) < values / 4
            return slope if np.all(good) else None
        samples *= 2
    return None


@dataclass(frozen=True)
class _Growth:
    """ψ(χ) in pieces that are shorter than the distance to the rough places.

    Attributes:
        edges: of the pieces, from −π to π.
        levels: ∫ dψ from −π to each of them.
        rates: dψ/dχ on each piece, coefficients of Legendre polynomials, shape (pieces, orders).
    """

    edges: Reals
    levels: Reals
    rates: Reals

    @classmethod
    def through(cls, places: list[tuple[float, float]]) -> _Growth:
        edges = _edges(places)
        nodes, weights = np.polynomial.legendre.leggauss(_LEGENDRE_TERMS)
        half = np.diff(edges) / 2
        values = _density((edges[:-1] + half)[:, None] + half[:, None] * nodes, places)
        k = np.arange(_LEGENDRE_TERMS)
        # coefficients k + ½ times ∫ f Pₖ, by the rule that has the nodes of f
        rates = (values * weights) @ np.polynomial.legendre.legvander(nodes, _LEGENDRE_TERMS - 1) * (k + 0.5)
        return cls(edges, np.concatenate([[0.0], np.cumsum(2 * half * rates[:, 0])]), rates)

    def rate(self, fraction: Reals) -> Reals:
        """dχ/dψ where a fraction of ψ's whole turn is reached, by Newton steps within a piece."""
        # the piece that holds the goal, and what is left of it there in units of half the piece
        goal = fraction * self.levels[-1]
        piece = np.clip(np.searchsorted(self.levels, goal, side="right") - 1, 0, len(self.rates) - 1)
        half = (self.edges[piece + 1] - self.edges[piece]) / 2
        goal = (goal - self.levels[piece]) / half
        rates = self.rates[piece].T
        # Newton's method for ∫ rate = goal on [−1, t], from the place where a constant rate would come to
        areas = np.polynomial.legendre.legint(rates, lbnd=-1)
        legval = np.polynomial.legendre.legval

        def off(t: Reals) -> tuple[Reals, Reals]:
            return legval(t, areas, tensor=False) - goal, legval(t, rates, tensor=False)

        ends = np.ones_like(goal)
        _, _, slope = bracketed_roots(off, np.clip(goal / rates[0] - 1, -1, 1), -ends, ends, close=1e-9)
        return self.levels[-1] / (2 * np.pi) / slope


def _edges(places: list[tuple[float, float]]) -> Reals:
    """Return phases between which ψ grows by about 1: closer to each other than to the rough places."""
    # geometric steps from δ/4 outwards: the density varies by a power law there
    near = [χ + side * δ * 2.0 ** np.arange(-2, 4 - np.log2(δ), 0.5) for χ, δ in places for side in (-1, 1)]
    points = np.concatenate([np.linspace(-np.pi, np.pi, 65), [χ for χ, _ in places], *near])
    table = np.unique(np.concatenate([np.remainder(points + np.pi, 2 * np.pi) - np.pi, [np.pi]]))
    density = _density(table, places)
    levels = np.concatenate([[0.0], np.cumsum(np.diff(table) * (density[1:] + density[:-1]) / 2)])
    # the trapezoidal rule places the edges only; the integral over a piece is Gauss and Legendre's
    inner = np.interp(np.arange(1, np.ceil(levels[-1])), levels, table)
    return np.concatenate([[-np.pi], inner, [np.pi]])


def _density(χ: Reals, places: list[tuple[float, float]]) -> Reals:
    """dψ/dχ, up to a constant."""
    total = np.full_like(χ, _BASE**4)
    for place, width in places:
        # sin²((χ − χₖ)/2) + δₖ²/4 is about |χ − (χₖ ± iδₖ)|²/4, with period 2π
        total += (np.sin((χ - place) / 2) ** 2 + width**2 / 4) ** -2
    return total**0.25


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
