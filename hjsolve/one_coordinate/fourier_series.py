"""Trigonometric series of the regular integrands, and their integrals term by term.

The coefficients of an analytic periodic function fall geometrically; how many are needed is proved beforehand
(``one_coordinate.resolution``), and ∫ c₀ + Σ cₖ cos kχ dχ = c₀ χ + Σ (cₖ/k) sin kχ is an explicit time law for all
times (Trefethen & Weideman, SIAM Review 56 (2014) 385, §3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from hjsolve.arithmetic.floats import EPS, context_of, multiprecision
from hjsolve.arithmetic.fourier import waves
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers

_GUARD = 16
"""Bits beyond those of the numbers in fixed-point sums."""


@dataclass(frozen=True)
class FourierSeries:
    """c₀ + Σₖ cₖ cos kχ + sₖ sin kχ.

    In its methods χ are phases, doubles or ``mpf`` of shape (m,), or one ``mpf``.

    Attributes:
        mean: c₀, in many digits.
        cosines, sines: k = 1, 2, …; float arrays, or object arrays of ``mpf`` above 15 digits;
            sines None for an even function.
        nodes: function values behind it.
        tail: size of the first term left out, relative to the largest value.
    """

    mean: Mpf | float
    cosines: Numbers
    sines: Numbers | None
    nodes: int
    tail: Mpf | float

    def value(self, χ: Elementwise) -> Elementwise:
        """Return the function at χ."""
        real, _ = _horner(self.cosines, χ)
        total = _like(self.mean, χ) + real
        return total if self.sines is None else total + _horner(self.sines, χ)[1]

    def oscillation(self, χ: Elementwise) -> Elementwise:
        """Return the periodic part of the integral from 0 to χ, that is ∫₀^χ − c₀ χ."""
        # ∫ cos kχ = sin kχ/k and ∫ sin kχ = (1 − cos kχ)/k: 0 at χ = 0 exactly
        k = np.arange(1, len(self.cosines) + 1)
        total = _horner(self.cosines / k, χ)[1]
        if self.sines is None:
            return total
        return total + _like(np.sum(self.sines / k), χ) - _horner(self.sines / k, χ)[0]

    @property
    def vanishes(self) -> bool:
        """True for the zero function."""
        return not self.mean and self.constant

    @property
    def constant(self) -> bool:
        """True for a function that is its mean."""
        return not len(self.cosines)

    @property
    def size(self) -> float:
        """Σ |cₖ|: what rounding of a value refers to, next to the mean."""
        return float(np.sum(np.abs(self.cosines.astype(float))))

    @property
    def wave_size(self) -> float:
        """Σ |cₖ|/k: what rounding of the periodic part of the integral refers to."""
        return float(np.sum(np.abs(self.cosines.astype(float) / np.arange(1, len(self.cosines) + 1))))

    @property
    def oscillation_size(self) -> float:
        """What rounding of ``oscillation`` refers to, wherever the phase is."""
        sines = np.zeros(0) if self.sines is None else self.sines.astype(float)
        return self.wave_size + 2 * float(np.sum(np.abs(sines / np.arange(1, len(sines) + 1))))

    @property
    def left_out(self) -> Mpf | float:
        """A bound on the terms that the series lacks."""
        sines: Numbers = self.sines if self.sines is not None else np.zeros(0)
        return (
            0
            if self.constant
            else 2 * self.tail * (abs(self.mean) + sum(map(abs, self.cosines)) + sum(map(abs, sines)))
        )

    def unresolved(self, χ: Mpf) -> float:
        """Return what rounded coefficients leave open of ``oscillation`` at one phase; nothing at a turning point."""
        if self.constant or self.cosines.dtype == object:
            return 0.0
        total = self.wave_size_at(χ)
        return EPS * total if total > EPS * np.pi else 0.0

    def wave_size_at(self, χ: Mpf | int) -> float:
        """Return what rounding of ``oscillation`` at one phase refers to; nothing at a turning point."""
        if not χ:
            return 0.0
        context, total = cast("Mpf", χ).context, 0.0
        for part, wave in ((self.cosines, context.sin), (self.sines, lambda x: 1 - context.cos(x))):
            if part is not None:
                # terms as they are at this phase: next to a turning point they are small, and so is their rounding
                total += sum(abs(float(c) / k * float(wave(k * χ))) for k, c in enumerate(part, 1))
        return total

    def combined(self, terms: list[tuple[float | Mpf, FourierSeries]]) -> FourierSeries:
        """Return Σ wⱼ·seriesⱼ.

        Args:
            terms: pairs (wⱼ, seriesⱼ) of this class, none of which vanishes.
        """
        # one series of many digits makes all of the sum have them
        floats = all(s.cosines.dtype == float for _, s in terms)
        length = max(len(s.cosines) for _, s in terms)

        def total(parts: list[tuple[Any, Numbers]]) -> Numbers:
            result = np.zeros(length) if floats else np.array([0 * terms[0][0]] * length, dtype=object)
            for w, part in parts:
                result[: len(part)] += (float(w) if floats else w) * part
            return result

        sines = [(w, s.sines) for w, s in terms if s.sines is not None]
        return FourierSeries(
            sum(w * s.mean for w, s in terms),
            total([(w, s.cosines) for w, s in terms]),
            total(sines) if sines else None,
            max(s.nodes for _, s in terms),
            max(s.tail for _, s in terms),
        )


def combine(weights: list[float | Mpf], series: list[FourierSeries]) -> FourierSeries:
    """Return Σ wⱼ·seriesⱼ; a weight that is exactly zero leaves its series out.

    Args:
        weights: wⱼ.
        series: as many as there are weights.
    """
    terms = [(w, s) for w, s in zip(weights, series, strict=True) if w and not s.vanishes]
    if not terms:
        return zero()
    return terms[0][1].combined(terms)


def zero() -> FourierSeries:
    """Return the zero function."""
    return FourierSeries(0, np.zeros(0), None, 0, 0.0)


def constant_series(value: Mpf | float) -> FourierSeries:
    """Return a constant function."""
    return FourierSeries(value, np.zeros(0), None, 1, 0.0)


def midpoints(nodes: int, *, even: bool, bits: int) -> list[Mpf]:
    """Return the middles of equal parts of half a turn (a whole turn where nothing is even), as ``mpf``.

    Args:
        nodes: how many parts.
        even: whether half a turn is enough.
    """
    context = multiprecision(bits)
    step = context.pi / nodes if even else 2 * context.pi / nodes
    return [step * (2 * m + 1) / 2 for m in range(nodes)]


def fit(
    rows: Sequence[list[Mpf | None]], *, even: bool, bits: int, digits: int = 15, floors: Sequence[float] = ()
) -> list[FourierSeries]:
    """Represent periodic functions by series; ``resolution`` proves how many nodes are enough.

    Args:
        rows: the values of all functions (``mpf``) at each of the midpoints; None for one that is zero everywhere.
        even: True when all are even in χ: half the nodes serve.
        digits: relative digits wanted (of the largest value of each): 15 or fewer keep coefficients in doubles.
        floors: size below which a function counts as that size (1 for a logarithm), one a function.
    """
    floors = floors or [0.0] * len(rows[0])
    return [_one([row[j] for row in rows], even, digits, bits, floors[j]) for j in range(len(rows[0]))]


def _one(given: list[Mpf | None], even: bool, digits: int, bits: int, floor: float) -> FourierSeries:
    """Discrete cosine (or Fourier) transform of values at midpoints, and the size of its last terms."""
    values = [v for v in given if v is not None]
    if not values:
        return zero()
    context, nodes = multiprecision(bits), len(values)
    # c₀ by the midpoint rule; the rest is transformed, so that a small oscillation keeps its digits next to it
    mean = context.fsum(values) / nodes
    largest = max(floor, *(abs(v) for v in values))
    rest = [v - mean for v in values]
    if not largest or max(abs(v) for v in rest) <= largest * context.mpf(10) ** -(digits + 8):
        return constant_series(mean)
    cosines, sines = waves(rest, even=even, bits=bits)
    # the last two of each, because one of two may vanish by a symmetry
    tail = max(abs(c) for c in cosines[-2:] + sines[-2:]) / largest
    kind = object if digits > 15 else float
    return FourierSeries(
        mean,
        np.array(cosines, dtype=kind),
        None if even else np.array(sines, dtype=kind),
        nodes,
        tail if digits > 15 else float(tail),
    )


def _horner(coefficients: Numbers, χ: Elementwise) -> tuple[Elementwise, Elementwise]:
    """Σ cₖ cos kχ and Σ cₖ sin kχ for k = 1, 2, …, by Horner's rule in e^{iχ}."""
    if _holds_digits(χ):
        return _clenshaw_of_many(coefficients, cast("Numbers", χ))
    context = context_of(χ)
    if context is None:
        wave = np.exp(1j * np.asarray(χ))
        total = np.zeros_like(wave)
        for c in coefficients[::-1].astype(float):
            total = (total + c) * wave
        return total.real, total.imag
    turn = context.expj(χ)
    number = context.mpc(0)
    for c in coefficients[::-1]:
        number = (number + c) * turn
    return number.real, number.imag


def oscillations(series: Sequence[FourierSeries], χ: Numbers) -> list[Numbers | int]:
    """Return ``oscillation`` of several series at the same phases of many digits, whose sines are worked out once.

    Args:
        series: of one phase; those that are no Fourier series, through kinks, are asked one by one.
        χ: ``mpf`` of shape (m,).
    """
    # series through kinks have no coefficients of sines and cosines
    plain = {type(one) for one in series} == {FourierSeries}
    if not (χ.size and plain and all(one.sines is None for one in series)):
        return [0 if one.constant else cast("Numbers", one.oscillation(χ)) for one in series]
    terms = max((len(one.cosines) for one in series), default=0)
    waves = _waves_of_many(χ, terms)
    k = np.arange(1, terms + 1)
    heights = [one.cosines / k[: len(one.cosines)] for one in series]
    return [_clenshaw_of_many(row, χ, waves)[1] if len(row) else 0 for row in heights]


def _waves_of_many(χ: Numbers, terms: int) -> tuple[int, Numbers, Numbers]:
    """Bits after the point for a series of so many terms, and cos χ and sin χ in as many."""
    # Clenshaw's recurrence magnifies rounding by at most terms²: twice as many bits as the number of terms has
    work = cast("Mpf", χ.flat[0]).context.prec + 2 * terms.bit_length() + _GUARD
    fine = multiprecision(work)
    turns = [fine.cos_sin(fine.convert(x)) for x in χ.flat]
    cosine, sine = (np.array([int(fine.ldexp(w[i], work)) for w in turns], dtype=object) for i in (0, 1))
    return work, cosine, sine


def _clenshaw_of_many(
    coefficients: Numbers, χ: Numbers, waves: tuple[int, Numbers, Numbers] | None = None
) -> tuple[Numbers, Numbers]:
    """Return the same at many phases of many digits, in fixed-point integers: arrays of these cost a tenth of ``mpf``.

    Clenshaw's recurrence bₖ = cₖ + 2 cos χ bₖ₊₁ − bₖ₊₂ has one product a term, Horner's rule four, and ends in both
    sums, b₁ cos χ − b₂ and b₁ sin χ. It magnifies rounding by at most the square of the number of terms, relative to
    the largest coefficient: the guard bits cover it.
    """
    if not len(coefficients) or not χ.size:
        return 0 * χ, 0 * χ
    context = cast("Mpf", χ.flat[0]).context
    numbers = [context.convert(c) for c in coefficients]
    largest = max(map(abs, numbers))
    if not largest:
        return 0 * χ, 0 * χ
    work, cosine, sine = waves or _waves_of_many(χ, len(numbers))
    # scaled by the largest coefficient: the smallest keep the bits that matter for the sum
    shift = work - int(context.mag(largest))
    fixed = [int(context.nint(context.ldexp(c, shift))) for c in numbers]
    twice: Elementwise = 2 * cosine
    b, after = 0 * twice, 0 * twice
    for c in reversed(fixed):
        b, after = (twice * b >> work) - after + c, b
    number = np.frompyfunc(lambda n: context.mpf((n, -shift)), 1, 1)
    return number((b * cosine >> work) - after).reshape(χ.shape), number(b * sine >> work).reshape(χ.shape)


def _holds_digits(χ: Elementwise) -> bool:
    return isinstance(χ, np.ndarray) and χ.dtype == object


def _like(mean: Elementwise, χ: Elementwise) -> Elementwise:
    return float(mean) if not _holds_digits(χ) and context_of(χ) is None else mean
