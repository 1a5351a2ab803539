"""Even functions of a phase that are analytic between kinks only: Chebyshev polynomials on panels of half a turn.

They answer what ``fourier_series.FourierSeries`` answers. At a kink of V the integrands of a libration have kinks
themselves, so a Fourier series would fall like a power of the number of its terms only.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hjsolve.arithmetic.chebyshev import clenshaw, in_panel
from hjsolve.arithmetic.floats import context_of
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, Reals


@dataclass(frozen=True, eq=False)
class PanelSeries:
    """An even function of period 2π on panels of [0, π]; it answers what ``FourierSeries`` answers.

    Attributes:
        edges: of the panels from 0 to π, ``mpf``, shape (panels + 1,).
        rows: Chebyshev coefficients, ``mpf``, shape (panels, degree + 1).
        sums: those of the integral from 0, shape (panels, degree + 2).
        nodes: function values behind it.
        digits: to which the coefficients are proved.
    """

    edges: Numbers
    rows: Numbers
    sums: Numbers
    nodes: int
    digits: int

    constant = False

    @property
    def mean(self) -> Mpf:
        """The mean over a turn."""
        context = self.edges[-1].context
        # Tₖ(1) = 1: the sum of the coefficients is the integral at the right edge, π
        return context.fsum(self.sums[-1]) / context.pi

    @property
    def vanishes(self) -> bool:
        """True for the zero function."""
        return False

    @property
    def tail(self) -> Mpf:
        """Size of what is left out, relative to the largest value."""
        context = self.edges[-1].context
        return context.mpf(10) ** -self.digits

    @cached_property
    def size(self) -> float:
        """What rounding of a value refers to, next to the mean."""
        return float(np.max(np.sum(np.abs(self._doubles[1]), axis=1)))

    @property
    def wave_size(self) -> float:
        """What rounding of the periodic part of the integral refers to."""
        return np.pi * self.size

    @property
    def oscillation_size(self) -> float:
        """What rounding of ``oscillation`` refers to, wherever the phase is."""
        return self.wave_size

    @property
    def left_out(self) -> Mpf:
        """A bound on the terms that the series lacks."""
        return 4 * self.tail * self.size

    def unresolved(self, χ: Mpf) -> float:
        """Return what rounded coefficients leave open of ``oscillation`` at one phase: there are none."""
        return 0.0 * float(χ)

    def wave_size_at(self, χ: Mpf | int) -> float:
        """Return what rounding of ``oscillation`` at one phase refers to; nothing at a turning point."""
        # the integral from 0 is as small as χ, and its rounding with it
        return min(abs(float(χ)), np.pi) * self.size

    def value(self, χ: Elementwise) -> Elementwise:
        """Return the function at χ."""
        if isinstance(χ, np.ndarray) and χ.dtype == object:
            return np.frompyfunc(self.value, 1, 1)(χ)
        return self._at(self.rows, 1, χ)

    def oscillation(self, χ: Elementwise) -> Elementwise:
        """Return the periodic part of the integral from 0 to χ."""
        if isinstance(χ, np.ndarray) and χ.dtype == object:
            return np.frompyfunc(self.oscillation, 1, 1)(χ)
        context = context_of(χ)
        if context is not None:
            rest = χ - 2 * context.pi * context.nint(χ / (2 * context.pi))
            inner = self._at(self.sums, 2, abs(rest))
            return (inner if rest >= 0 else -inner) - self.mean * rest
        # even with period 2π: |χ| reduced to half a turn is all that panels know
        rest = χ - 2 * np.pi * np.rint(χ / (2 * np.pi))
        # the integral of an even function is odd; its mean growth is taken off
        return np.copysign(self._at(self.sums, 2, np.abs(rest)), rest) - float(self.mean) * rest

    def combined(self, terms: list[tuple[float | Mpf, PanelSeries]]) -> PanelSeries:
        """Return Σ wⱼ·seriesⱼ, all on the same panels."""
        rows, sums = (sum(w * getattr(s, part) for w, s in terms) for part in ("rows", "sums"))
        nodes, digits = max(s.nodes for _, s in terms), min(s.digits for _, s in terms)
        return PanelSeries(self.edges, rows, sums, nodes, digits)

    @cached_property
    def _doubles(self) -> tuple[Reals, Reals, Reals]:
        edges, rows, sums = (part.astype(float) for part in (self.edges, self.rows, self.sums))
        return edges, rows, sums

    def _at(self, table: Numbers, which: int, χ: Elementwise) -> Elementwise:
        context = context_of(χ)
        if context is not None:
            a = abs(χ - 2 * context.pi * context.nint(χ / (2 * context.pi)))
            k = min(max(bisect_right(self.edges, a) - 1, 0), len(table) - 1)
            return clenshaw(table[k], in_panel(a, self.edges[k], self.edges[k + 1]))
        a = np.abs(χ - 2 * np.pi * np.rint(χ / (2 * np.pi)))
        edges, rows = self._doubles[0], self._doubles[which]
        panel = np.clip(np.searchsorted(edges, a, side="right") - 1, 0, len(rows) - 1)
        return clenshaw(np.moveaxis(rows[panel], -1, 0), in_panel(a, edges[panel], edges[panel + 1]))
