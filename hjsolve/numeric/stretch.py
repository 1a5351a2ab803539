"""A second change of variable where the anomaly alone would need too many nodes.

A zero or pole of p² close to the *inside* of the motion (a double well just above its barrier, a wheel that
passes two equal crests) is not at an end, and no elliptic anomaly reaches it. Where the integrands are rough is
found by bisection, whatever the cause; with a rough place at χₖ, of width δₖ, the new phase ψ grows like

    dψ/dχ ~ 1 + Σₖ cₖ / √(sin²((χ − χₖ)/2) + δₖ²/4)

(for an even anomaly with its mirror image), which spreads a square-root singularity at χₖ ± iδₖ evenly. Its integral is
2 sin u R_F(δ² cos² u, δ², δ² + sin² u), u = (χ − χₖ)/2 and δ = δₖ/2 (Carlson's form; DLMF 19.25.5): nothing cancels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from hjsolve.numeric.anomaly import Libration, Place, Rotation, as_float
from hjsolve.numeric.arithmetic import Float64, Multi, multiprecision
from hjsolve.numeric.series import Series, fit

_POINTS = 9
_RESOLVED = 1e-2
_DEEPEST = 400
_FEWEST = 8


@dataclass(frozen=True)
class Crowd:
    """A rough place of the integrands: χₖ, δₖ, and cₖ for unit length."""

    place: Any
    width: Any
    weight: Any

    def growth(self, χ: Any, context: Any) -> tuple[Any, Any]:
        """Return ∫ from χₖ to χ of cₖ/√(sin² + δ²/4), and the integrand at χ."""
        u, δ = (χ - self.place) / 2, self.width / 2
        turns = context.nint(u / context.pi)
        sine, cosine = context.sin(u), context.cos(u)
        part = 2 * sine * context.elliprf((δ * cosine) ** 2, δ**2, δ**2 + sine**2) * (-1) ** int(turns)
        return self.weight * (part + 2 * turns * _half(δ, context)), self.weight / context.sqrt(sine**2 + δ**2)


def _half(δ: Any, context: Any) -> Any:
    """∫ over half a turn of u."""
    return 2 * context.elliprf(0, δ**2, 1 + δ**2)


@dataclass(frozen=True)
class Stretched:
    """An anomaly whose phase ψ moves slowly through the rough places of another one's χ.

    Attributes:
        inner: the anomaly in χ.
        crowds: the rough places; with their mirror images where ``inner`` is even.
        slope: series of dχ/dψ in doubles.
    """

    inner: Libration | Rotation
    crowds: tuple[Crowd, ...]
    slope: Series | None = None

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

    def place(self, ψ: Any, arithmetic: Float64 | Multi) -> Place:
        """Return the place at ψ, |ψ| ≤ 2π."""
        if isinstance(arithmetic, Float64):
            assert self.slope is not None
            χ, rate = ψ + self.slope.ripple(ψ), self.slope.value(ψ)
        else:
            χ, rate = self.unstretched(ψ, arithmetic)
        place = self.inner.place(χ, arithmetic)
        return Place(place.q, place.speed * rate, place.product, place.stretch * rate)

    def phase(self, q: Any, forward: int, arithmetic: Multi) -> Any:
        """Return ψ in (−π, π] of a position."""
        return self.stretched(self.inner.phase(q, forward, arithmetic), arithmetic)[0]

    def stretched(self, χ: Any, arithmetic: Multi) -> tuple[Any, Any]:
        """Return ψ(χ), with ψ(0) = 0 and ψ(χ + 2π) = ψ(χ) + 2π, and dψ/dχ."""
        context, total, slope = arithmetic.context, χ, 1
        for crowd in self.crowds:
            value, rate = crowd.growth(χ, context)
            begin, _ = crowd.growth(0 * χ, context)
            total, slope = total + value - begin, slope + rate
        return total / self._span(arithmetic), slope / self._span(arithmetic)

    def _span(self, arithmetic: Multi) -> Any:
        """Growth of the unscaled phase over a turn, divided by 2π."""
        return 1 + sum(c.weight * _half(c.width / 2, arithmetic.context) for c in self.crowds) / arithmetic.pi()

    @cached_property
    def _table(self) -> tuple[list[Any], Any]:
        """Some χ and their ψ, close enough together for Newton's method."""
        arithmetic = Multi(128)
        near = [
            crowd.place + side * crowd.width * 2.0**k
            for crowd in self.crowds
            for side in (-1, 0, 1)
            for k in range(-1, 4 - int(arithmetic.context.log(crowd.width, 2)))
        ]
        places = sorted({arithmetic.convert(x) for x in [*near, *np.linspace(-7, 7, 57)]})
        return places, np.array([float(self.stretched(x, arithmetic)[0]) for x in places])

    def unstretched(self, ψ: Any, arithmetic: Multi) -> tuple[Any, Any]:
        """Return χ(ψ) and dχ/dψ, by Newton's method from a table."""
        places, phases = self._table
        k = int(np.clip(np.searchsorted(phases, float(ψ)), 1, len(places) - 1))
        low, high = arithmetic.convert(places[max(k - 2, 0)]), arithmetic.convert(places[min(k + 1, len(places) - 1)])
        χ = (arithmetic.convert(places[k - 1]) + arithmetic.convert(places[k])) / 2
        close = arithmetic.context.mpf(2) ** (-arithmetic.bits // 2 - 4)
        for _ in range(60):
            value, rate = self.stretched(χ, arithmetic)
            low, high = (low, χ) if value > ψ else (χ, high)
            step = (value - ψ) / rate
            new = χ - step
            if abs(step) * rate <= close:
                return new, 1 / self.stretched(new, arithmetic)[1]
            χ = new if low < new < high else (low + high) / 2
        return χ, 1 / self.stretched(χ, arithmetic)[1]


def rounded(anomaly: Libration | Rotation | Stretched) -> Libration | Rotation | Stretched:
    """Round the constants of a map to doubles, for vectorised use."""
    return replace(anomaly, inner=as_float(anomaly.inner)) if isinstance(anomaly, Stretched) else as_float(anomaly)


def stretched(
    inner: Libration | Rotation, functions: Callable[[Any], list[Any]], *, digits: int, bits: int
) -> Stretched | None:
    """Find the rough places of functions of χ and make the phase that resolves them.

    Args:
        inner: the anomaly in χ.
        functions: χ (``mpf``) ↦ the integrands there, None for one that is not wanted.
        digits: relative digits wanted of the map in doubles.
        bits: working precision.

    Returns:
        The map; None where no rough place was found, or where roughness has no end.
    """
    context = multiprecision(bits)
    leaves = _leaves(functions, 0 if inner.even else -context.pi, +context.pi, context)
    places = _rough_places(leaves, even=inner.even) if leaves else []
    if not places:
        return None
    if inner.even:
        places = places + [(-χ, δ) for χ, δ in places if 0 < χ < context.pi]
    crowds = tuple(Crowd(χ, δ, context.pi / _half(δ / 2, context)) for χ, δ in places)
    map_ = Stretched(inner, crowds)
    arithmetic = Multi(bits)
    slope = fit(lambda ψ: [map_.unstretched(ψ, arithmetic)[1]], even=inner.even, digits=min(digits, 15), bits=bits)[0]
    return replace(map_, slope=slope)


def _leaves(functions: Callable[[Any], list[Any]], begin: Any, end: Any, context: Any) -> list[tuple[Any, Any]] | None:
    """Bisect until low polynomials follow the functions roughly; None where that has no end."""
    points = [context.cos(context.pi * (2 * m + 1) / (2 * _POINTS)) for m in range(_POINTS)]
    waves = [[context.cos(k * context.acos(x)) for x in points] for k in range(_POINTS)]
    step = (end - begin) / _FEWEST
    todo = [(begin + k * step, begin + (k + 1) * step) for k in range(_FEWEST)]
    done: list[tuple[Any, Any]] = []
    while todo:
        a, b = todo.pop()
        rows = [functions((a + b) / 2 + x * (b - a) / 2) for x in points]
        columns = [column for column in zip(*rows, strict=True) if column[0] is not None]
        if all(_followed(column, waves, context) for column in columns):
            done.append((a, b))
        else:
            todo += [(a, (a + b) / 2), ((a + b) / 2, b)]
        if len(done) + len(todo) > _DEEPEST:
            return None
    return sorted(done)


def _followed(column: tuple[Any, ...], waves: list[list[Any]], context: Any) -> bool:
    largest = max(abs(v) for v in column)
    tail = max(abs(context.fdot(wave, column)) for wave in waves[-2:]) * 2 / len(column)
    return bool(tail <= _RESOLVED * largest)


def _rough_places(leaves: list[tuple[Any, Any]], *, even: bool) -> list[tuple[Any, Any]]:
    """Centres and half widths of the places where the leaves are smallest."""
    widths = [float(b - a) for a, b in leaves]
    longest = max(widths)
    runs = [list(group) for _, group in groupby(range(len(leaves)), key=lambda i: round(np.log2(widths[i] / longest)))]
    found = []
    for k, run in enumerate(runs):
        width = widths[run[0]]
        sides = [widths[runs[j][0]] for j in (k - 1, k + 1) if 0 <= j < len(runs)]
        if not sides or any(side < width for side in sides) or width > longest / 4:
            continue
        a, b = leaves[run[0]][0], leaves[run[-1]][1]
        centre = (a + b) / 2
        if even and run[0] == 0:
            centre = a
        elif even and run[-1] == len(leaves) - 1:
            centre = b
        found.append((centre, (b - a) / max(2, len(run))))
    return found
