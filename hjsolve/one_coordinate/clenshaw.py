"""A trigonometric series and its integral at one phase in many digits, in fixed-point integers.

Σ uₖ cos kχ and Σ uₖ sin kχ by Clenshaw's recurrence bₖ = uₖ + 2 cos χ bₖ₊₁ − bₖ₊₂ (Math. Tables Aids Comput. 9
(1955) 118): one product of integers a term, some fifty times faster than complex numbers of mpmath. The recurrence
magnifies rounding by at most the square of the number of terms, which the guard bits cover, so the sums are as good as
the coefficients, relative to the largest of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.one_coordinate.fourier_series import FourierSeries

_GUARD = 32
"""Bits beyond those that the recurrence loses, n² roundings for n terms (Gentleman 1969; counted apart): coefficients
of the integral are divided by k, and 2^−32 of a unit is left for the argument."""


class Fixed:
    """A series ready for many single phases; it answers what ``FourierSeries`` answers.

    Args:
        series: with coefficients of many digits.
        bits: working precision, at least that of the coefficients.
    """

    def __init__(self, series: FourierSeries, bits: int):
        self.series, self.context = series, multiprecision(bits)
        parts = [part for part in (series.cosines, series.sines) if part is not None]
        self.size = max((abs(c) for part in parts for c in part), default=0)
        # rounding grows like the square of the number of terms at most
        self.work = bits + 2 * max(len(series.cosines), 1).bit_length() + _GUARD

    def _integers(self, coefficients: Iterable[object], divided: bool) -> list[int]:
        """Coefficients, or those of the integral, from the last on, as multiples of 2^−work of the largest."""
        with_order = [(c / k if divided else c) for k, c in enumerate(map(self.context.convert, coefficients), start=1)]
        return [int(self.context.nint(self.context.ldexp(c / self.size, self.work))) for c in reversed(with_order)]

    @cached_property
    def _slopes(self) -> tuple[list[int], list[int]]:
        sines = self.series.sines if self.series.sines is not None else ()
        return self._integers(self.series.cosines, False), self._integers(sines, False)

    @cached_property
    def _heights(self) -> tuple[list[int], list[int], int]:
        sines = self._integers(self.series.sines if self.series.sines is not None else (), True)
        return self._integers(self.series.cosines, True), sines, sum(sines)

    def _wave(self, χ: Mpf) -> tuple[int, int]:
        c, s = self.context.cos_sin(self.context.convert(χ))
        return tuple(int(self.context.nint(self.context.ldexp(x, self.work))) for x in (c, s))  # type: ignore[return-value]

    def _total(self, coefficients: list[int], c: int) -> tuple[int, int]:
        work, twice = self.work, 2 * c
        b, after = 0, 0
        for u in coefficients:
            # bₖ = uₖ + 2 cos χ bₖ₊₁ − bₖ₊₂, a shift in place of a division
            b, after = u + (twice * b >> work) - after, b
        return b, after

    def _number(self, value: int) -> Mpf:
        return self.size * self.context.ldexp(self.context.mpf(value), -self.work)

    def value(self, χ: Mpf) -> Mpf:
        """Return the function at a phase."""
        if not self.size:
            return self.context.convert(self.series.mean)
        c, s = self._wave(χ)
        cosines, sines = self._slopes
        b, after = self._total(cosines, c)
        # Σ uₖ cos kχ = b₁ cos χ − b₂
        total = (b * c >> self.work) - after
        if sines:
            # Σ uₖ sin kχ = b₁ sin χ
            total += self._total(sines, c)[0] * s >> self.work
        return self.series.mean + self._number(total)

    def oscillation(self, χ: Mpf) -> Mpf:
        """Return the periodic part of its integral from 0, as in ``FourierSeries``."""
        if not self.size:
            return self.context.mpf(0)
        c, s = self._wave(χ)
        cosines, sines, all_sines = self._heights
        total = self._total(cosines, c)[0] * s >> self.work
        if sines:
            b, after = self._total(sines, c)
            # ∫ of sines: Σ (sₖ/k)(1 − cos kχ), which is 0 at χ = 0
            total += all_sines - ((b * c >> self.work) - after)
        return self._number(total)
