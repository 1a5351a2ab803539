"""Many trigonometric series over one phase at once, in integers: the waves are made once for all of them.

cos kχ and sin kχ follow from e^{i(k+1)χ} = e^{ikχ} e^{iχ}; each product is rounded by one unit of the last place, which
grows to at most k of them. The guard bits cover it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Numbers
from hjsolve.motion.derivatives.bounded import Bounded
from hjsolve.one_coordinate.fourier_series import FourierSeries

_GUARD = 24


class Waves:
    """Series with coefficients of many digits, and bounds on the terms they lack."""

    def __init__(self, series: Sequence[FourierSeries], lacks: Sequence[float], bits: int):
        """Keep the series.

        Args:
            series: over one phase.
            lacks: absolute bounds on what each leaves out.
        """
        self.series, self.lacks, self.bits = tuple(series), np.array(lacks), bits
        self.context = multiprecision(bits)

    def means(self) -> Bounded:
        """Return all means."""
        return Bounded(self._means, self.lacks)

    def at(self, χ: NDArray[np.object_], full: NDArray[np.object_]) -> tuple[Bounded, Bounded]:
        """Return all functions, and all their integrals from the phase 0, shape (series, m) each.

        Args:
            χ: phases near [−π, π], shape (m,).
            full: the same with their turns.
        """
        count, mean, unit = len(self._means), self._means[:, None], np.array([[self.context.mpf(1)]], dtype=object)
        lacks = self.lacks[:, None]
        spread = 1 + np.abs(full).astype(float)[None, :]
        if not self._terms:
            values = mean * unit + 0 * χ[None, :]
            return Bounded(values, lacks + 0 * spread), Bounded(mean * full[None, :], lacks * spread)
        cosine, sine = self._waves(χ)
        (C, S), (Ck, Sk) = self._fixed
        one = 1 << self._work
        swings = self._scaled(C @ cosine + S @ sine, count)
        heights = self._scaled(Ck @ sine + Sk @ (one - cosine), count)
        return Bounded(mean + swings, lacks + 0 * spread), Bounded(mean * full[None, :] + heights, lacks * spread)

    def _scaled(self, whole: Numbers, count: int) -> Numbers:
        result = np.empty(whole.shape, dtype=object)
        for k in range(count):
            shift = -self._shifts[k] - self._work
            result[k] = [self.context.mpf((int(x), shift)) for x in whole[k]]
        return result

    @cached_property
    def _means(self) -> Numbers:
        return np.array([self.context.mpf(0) + s.mean for s in self.series], dtype=object)

    @cached_property
    def _terms(self) -> int:
        return max((len(s.cosines) for s in self.series), default=0)

    @cached_property
    def _work(self) -> int:
        return self.bits + 2 * self._terms.bit_length() + _GUARD

    @cached_property
    def _shifts(self) -> list[int]:
        return [self._work - int(self.context.mag(largest)) if largest else 0 for largest in map(_largest, self.series)]

    @cached_property
    def _fixed(self) -> tuple[tuple[Numbers, Numbers], tuple[Numbers, Numbers]]:
        """Coefficients of cosines and sines as whole numbers; the same over k."""
        shape, c = (len(self.series), self._terms), self.context
        tables = tuple(np.zeros(shape, dtype=object) for _ in range(4))
        for row, (s, shift) in enumerate(zip(self.series, self._shifts, strict=True)):
            for table, part in ((0, s.cosines), (1, s.sines)):
                for k, x in enumerate(part if part is not None else ()):
                    number = c.ldexp(c.convert(x), shift)
                    tables[table][row, k] = int(c.nint(number))
                    tables[table + 2][row, k] = int(c.nint(number / (k + 1)))
        return (tables[0], tables[1]), (tables[2], tables[3])

    def _waves(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        work, fine = self._work, multiprecision(self._work + 8)
        cosine, sine = (np.empty((self._terms, len(χ)), dtype=object) for _ in range(2))
        for m, phase in enumerate(χ):
            x, y = (int(fine.nint(fine.ldexp(part, work))) for part in fine.cos_sin(fine.convert(phase)))
            a, b = x, y
            for k in range(self._terms):
                cosine[k, m], sine[k, m] = a, b
                a, b = (a * x - b * y) >> work, (a * y + b * x) >> work
        return cosine, sine


def _largest(series: FourierSeries) -> object:
    parts = [series.cosines] if series.sines is None else [series.cosines, series.sines]
    return max((abs(x) for part in parts for x in part), default=0)
