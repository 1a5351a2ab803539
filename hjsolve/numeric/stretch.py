"""A second change of variable where the elliptic anomaly alone would need too many nodes.

The anomalies of ``numeric.anomaly`` take care of the four branch points of p dq nearest to the motion. Where more
come close (a wheel that just passes several crests) the new phase ψ grows like

    dψ/dχ ~ 1 + Σₖ cₖ / √(sin²((χ − χₖ)/2) + δₖ²/4)

with a rough place χₖ ± iδₖ for each (and its mirror image for an even anomaly), which spreads a square-root singularity
evenly. Its integral is 2 sin u R_F(δ² cos² u, δ², δ² + sin² u), u = (χ − χₖ)/2 and δ = δₖ/2 (Carlson's form; DLMF
19.25.5): nothing cancels. The map used is a trigonometric polynomial close to the inverse, χ = ψ + Σ (cₖ/k) sin kψ …
with coefficients that are doubles, taken as exact numbers: any such map with dχ/dψ > 0 leaves the integrals what they
are, so it need not be known better than that.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from hjsolve.numeric.anomaly import Crested, Libration, Paired, Place, Rotation, as_float
from hjsolve.numeric.arithmetic import Float64, Multi
from hjsolve.numeric.series import Series

_SAMPLES = 4096
_STEPS = 60
_LAST = 1e-4
"""Coefficients of dχ/dψ below that part of its least value are left out: they would not make the map a better one."""
_NARROWEST = 1e-12

Inner = Libration | Crested | Rotation | Paired


@dataclass(frozen=True, eq=False)
class Stretched:
    """An anomaly whose phase ψ moves slowly through the rough places of another one's χ.

    Attributes:
        inner: the anomaly in χ.
        slope: dχ/dψ, a trigonometric polynomial in doubles with mean 1.
    """

    inner: Inner
    slope: Series

    @property
    def even(self) -> bool:
        return self.inner.even

    @property
    def direction(self) -> int:
        return self.inner.direction

    @property
    def lower(self) -> Any:
        return self.inner.lower  # type: ignore[union-attr]

    @property
    def upper(self) -> Any:
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
        return float(self.slope.ripple(np.array([np.pi]))[0])

    @lru_cache(maxsize=8)  # noqa: B019
    def _fixed(self, bits: int) -> list[tuple[int, int]]:
        return [(int(c * 2**bits), int(s * 2**bits)) for c, s in self._waves]

    def place(self, ψ: Any, arithmetic: Float64 | Multi) -> Place:
        """Return the place at ψ, |ψ| ≤ 2π."""
        χ, rate = self.unstretched(ψ, arithmetic)
        place = self.inner.place(χ, arithmetic)
        return Place(place.q, place.speed, place.product, place.stretch, rate)

    def unstretched(self, ψ: Any, arithmetic: Float64 | Multi) -> tuple[Any, Any]:
        """Return χ(ψ) and dχ/dψ."""
        if isinstance(arithmetic, Float64):
            return ψ + (self.slope.ripple(ψ) - self._shift), self.slope.value(ψ)
        return self._in_fixed_point(ψ, arithmetic)

    def _in_fixed_point(self, ψ: Any, arithmetic: Multi) -> tuple[Any, Any]:
        """χ = ψ + Im Σ (cₖ − i sₖ) e^{ikψ} + Σ (−1)ᵏ sₖ and its derivative by Horner's rule in integers."""
        bits, context = arithmetic.bits + 32, arithmetic.context
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

    def phase(self, q: Any, forward: int, arithmetic: Multi) -> Any:
        """Return ψ in (−π, π] of a position: Newton's method kept inside a bracket."""
        χ = self.inner.phase(q, forward, arithmetic)
        low, high, ψ = -arithmetic.pi(), arithmetic.pi(), χ
        close = arithmetic.context.mpf(2) ** (12 - arithmetic.bits)
        for _ in range(4 * arithmetic.bits):
            value, rate = self.unstretched(ψ, arithmetic)
            low, high = (low, ψ) if value > χ else (ψ, high)
            new = ψ - (value - χ) / rate
            new = new if low < new < high else (low + high) / 2
            if abs(new - ψ) <= close:
                return new
            ψ = new
        return ψ


def rounded(anomaly: Inner | Stretched) -> Inner | Stretched:
    """Round the constants of a map to doubles, for vectorised use."""
    return replace(anomaly, inner=as_float(anomaly.inner)) if isinstance(anomaly, Stretched) else as_float(anomaly)


def lowered(anomaly: Inner | Stretched, arithmetic: Multi) -> Inner | Stretched:
    """Round the constants of a map to fewer digits."""
    if isinstance(anomaly, Stretched):
        return replace(anomaly, inner=_lowered(anomaly.inner, arithmetic))
    return _lowered(anomaly, arithmetic)


def _lowered(anomaly: Inner, arithmetic: Multi) -> Inner:
    values = {f.name: getattr(anomaly, f.name) for f in fields(anomaly)}
    numbers = {n: arithmetic.convert(v) for n, v in values.items() if not isinstance(v, int | float | None)}
    return replace(anomaly, **numbers)


def stretched(inner: Inner, places: list[tuple[float, float]]) -> Stretched | None:
    """Make the phase that resolves rough places χₖ of width δₖ.

    Args:
        inner: the anomaly in χ.
        places: (χₖ, δₖ); without mirror images.

    Returns:
        The map; None where doubles cannot hold one.
    """
    if inner.even:
        places = places + [(-χ, δ) for χ, δ in places if 0 < χ < np.pi]
    narrowest = _NARROWEST
    while narrowest < 0.1:
        slope = _inverse_slope([(χ, max(δ, narrowest)) for χ, δ in places], even=inner.even)
        if slope is not None:
            return Stretched(inner, slope)
        narrowest *= 8
    return None


def _inverse_slope(places: list[tuple[float, float]], *, even: bool) -> Series | None:
    """dχ/dψ as a trigonometric polynomial in ψ; None where rounding would make it negative."""
    ψ = 2 * np.pi * np.arange(_SAMPLES) / _SAMPLES - np.pi
    χ = _inverted(ψ, places)
    values = 1 / _stretching(χ, places)[1]
    waves = np.fft.rfft(np.roll(values, _SAMPLES // 2)) / _SAMPLES
    size = np.abs(waves[1:])
    top = int(np.max(np.nonzero(size > _LAST * np.min(values))[0], initial=0)) + 1
    if top > _SAMPLES // 4:
        return None
    cosines, sines = 2 * waves.real[1 : top + 1], -2 * waves.imag[1 : top + 1]
    slope = Series(1, cosines, None if even else sines, _SAMPLES, 0.0)
    return slope if np.all(np.abs(slope.value(ψ) - values) < values / 4) else None


def _inverted(ψ: Any, places: list[tuple[float, float]]) -> Any:
    """Solve ψ(χ) = ψ by Newton steps from a table that is fine at the rough places."""
    near = [χ + side * δ * 2.0 ** np.arange(-3, 4 - np.log2(δ), 0.25) for χ, δ in places for side in (-1, 1)]
    table = np.unique(np.clip(np.concatenate([np.linspace(-np.pi, np.pi, 257), *near]), -np.pi, np.pi))
    levels = _stretching(table, places)[0]
    position = np.clip(np.searchsorted(levels, ψ) - 1, 0, len(table) - 2)
    low, high = table[position], table[position + 1]
    χ = (low + high) / 2
    for _ in range(_STEPS):
        value, rate = _stretching(χ, places)
        low, high = np.where(value < ψ, χ, low), np.where(value > ψ, χ, high)
        new = χ - (value - ψ) / rate
        new = np.where((new >= low) & (new <= high), new, (low + high) / 2)
        moved, χ = np.abs(new - χ), new
        if np.all(np.minimum(moved * rate, moved / 4) < 1e-15):
            break
    return χ


def _stretching(χ: Any, places: list[tuple[float, float]]) -> tuple[Any, Any]:
    """ψ(χ), −π ↦ −π, π ↦ π, and dψ/dχ."""
    total, slope = χ - 0.0, np.ones_like(χ)
    for place, width in places:
        δ = width / 2
        half = 2 * _carlson(np.array([0.0]), np.array([δ**2]), np.array([1 + δ**2]))[0]
        weight = np.pi / half
        growth = [_growth((x - place) / 2, δ, half) for x in (χ, np.array([-np.pi]))]
        total = total + weight * (growth[0] - growth[1]) - 0.0
        slope = slope + weight / np.sqrt(np.sin((χ - place) / 2) ** 2 + δ**2)
    span = 1 + len(places)
    return (total + np.pi) / span - np.pi, slope / span


def _growth(u: Any, δ: float, half: float) -> Any:
    """2 ∫₀ᵘ du/√(sin² u + δ²)."""
    turns = np.rint(u / np.pi)
    sine, cosine = np.sin(u), np.cos(u)
    part = 2 * sine * _carlson((δ * cosine) ** 2, np.full_like(u, δ**2), δ**2 + sine**2)
    return np.where(turns % 2 == 0, part, -part) + 2 * turns * half


def _carlson(x: Any, y: Any, z: Any) -> Any:
    """R_F by duplication (Carlson, Numer. Math. 33 (1979) 1), in doubles."""
    for _ in range(60):
        root = np.sqrt(x * y) + np.sqrt(y * z) + np.sqrt(z * x)
        x, y, z = (x + root) / 4, (y + root) / 4, (z + root) / 4
        mean = (x + y + z) / 3
        if np.all(np.abs(x - mean) + np.abs(y - mean) + np.abs(z - mean) < 1e-3 * mean):
            break
    X, Y = 1 - x / mean, 1 - y / mean
    Z = -X - Y
    E2, E3 = X * Y - Z * Z, X * Y * Z
    return (1 - E2 / 10 + E3 / 14 + E2 * E2 / 24 - 3 * E2 * E3 / 44) / np.sqrt(mean)
