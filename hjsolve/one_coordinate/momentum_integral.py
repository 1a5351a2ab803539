"""∫ P dq along the course of one coordinate, P the root of P²: its part of Hamilton's characteristic function W.

A bounded course has the series of P dq/dχ among its own. An open one has |P|/|dq/dy| times ``EndMap.rest`` in Chebyshev
polynomials on its panels, proved to be enough there; times the elementary function (dq/dy)²/rest it is |P dq/dy|, and
that product is expanded again, on panels halved until the elementary function needs few terms on each. So nothing
new must be proved of p².
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Protocol

import numpy as np

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth, waves
from hjsolve.arithmetic.number_types import Mpf, Numbers
from hjsolve.one_coordinate.chebyshev_panels import EndMap, Panels, chebyshev_points, integrated_row

_FACTOR_DEGREE = 48
"""Degree that the elementary factor may need on a panel, for 15 digits; more digits more."""
_PANEL_HALVINGS = 200
"""Of one panel, in all; what is beyond the last part that was resolved is not given."""
_GUARD_BITS = 32
"""As in ``clenshaw``: beyond the n² roundings of the recurrence."""


class OpenBranchIntegrals(Protocol):
    """One branch of an open motion, as far as it is used here; ``open_branch.Branch`` is one."""

    @property
    def end_map(self) -> EndMap: ...
    @property
    def bits(self) -> int: ...
    @property
    def digits(self) -> int: ...
    def panels(self, weights: tuple[float, ...] | None, amount: float) -> Panels: ...


@lru_cache(maxsize=32)
def swept(branch: OpenBranchIntegrals, weights: tuple[float, ...] | None, amount: float) -> Panels:
    """Return panels of |P dq/dy| that reach as far as ``branch.panels(weights, amount)``.

    Args:
        branch: one branch of an open motion.
        weights: wⱼ, one a constant; None where the phase itself is meant.
        amount: how far.
    """
    end_map, bits, digits, panels = branch.end_map, branch.bits, branch.digits, branch.panels(weights, amount)
    context = multiprecision(bits)
    edges: list[Mpf] = [context.mpf(0)]
    values: list[list[Mpf]] = []
    sums: list[list[Mpf]] = []
    total: Mpf = context.mpf(0)
    for k, row in enumerate(panels.coefficients[-1]):
        series = [context.mpf(c) for c in row]
        ends = context.mpf(panels.edges[k]), context.mpf(panels.edges[k + 1])
        # p² is resolved on the panel; the factor (dq/dy)²/rest may need shorter ones
        todo, halvings = [ends], 0
        while todo:
            low, high = todo.pop()
            product = _product(end_map, series, ends, (low, high), bits, digits)
            if product is None and halvings < _PANEL_HALVINGS:
                middle, halvings = (low + high) / 2, halvings + 1
                # the lower half is done first: integrals are added in their order
                todo += [(middle, high), (low, middle)]
                continue
            if product is None:
                # as far as it went: W is not given beyond the last part that was resolved
                return _assembled(edges, values, sums, panels.nodes, digits)
            integral = integrated_row(product, (high - low) / 2, total)
            total = context.fsum(integral)
            edges.append(high)
            values.append(product)
            sums.append(integral)
    return _assembled(edges, values, sums, panels.nodes, digits)


def _product(
    end_map: EndMap, series: list[Mpf], panel: tuple[Mpf, Mpf], part: tuple[Mpf, Mpf], bits: int, digits: int
) -> list[Mpf] | None:
    """Chebyshev coefficients on a part of a panel; None where they do not fall fast enough."""
    arithmetic, context = Multi(bits), multiprecision(bits)
    low, high = part
    points = chebyshev_points(smooth(len(series) + _FACTOR_DEGREE * max(1, digits // 15)), bits)
    samples, summed = [], _chebyshev_sum(series, panel, bits)
    for x in points:
        y = low + (high - low) * (1 + x) / 2
        slope = end_map.position(y, arithmetic)[1]
        # |P dq/dy| = (|P|/|dq/dy| · rest) · (dq/dy)²/rest
        samples.append(summed(y) * slope * slope / end_map.rest(y, arithmetic))
    if any(isinstance(value, context.mpc) for value in samples):
        return None
    product = [context.fsum(samples) / len(samples), *waves(samples, even=True, bits=bits)[0]]
    size = max(abs(c) for c in product)
    kept = next(
        (k for k in range(len(product), 0, -1) if abs(product[k - 1]) > size * context.mpf(10) ** -(digits + 3)), 1
    )
    # six coefficients below the tolerance: a series that ends by chance has not six
    return product[:kept] if kept <= len(product) - 6 else None


def _chebyshev_sum(series: list[Mpf], panel: tuple[Mpf, Mpf], bits: int) -> Callable[[Mpf], Mpf]:
    """Return y ↦ a Chebyshev series of a panel, by Clenshaw's recurrence in integers as ``clenshaw.Fixed``.

    The rounding is that of the largest coefficient, times at most the square of the number of terms, which the guard
    bits cover.
    """
    context, (left, right) = multiprecision(bits), panel
    size = max(abs(c) for c in series) or context.mpf(1)
    work = bits + 2 * len(series).bit_length() + _GUARD_BITS
    first, *others = (int(context.nint(context.ldexp(c / size, work))) for c in series)
    others.reverse()
    unit = context.ldexp(size, -work)

    def value(y: Mpf) -> Mpf:
        x = int(context.nint(context.ldexp(((y - left) - (right - y)) / (right - left), work)))
        twice, b, after = 2 * x, 0, 0
        for c in others:
            b, after = c + (twice * b >> work) - after, b
        return unit * ((x * b >> work) - after + first)

    return value


def _assembled(edges: list[Mpf], values: list[list[Mpf]], sums: list[list[Mpf]], nodes: int, digits: int) -> Panels:
    kind = float if digits <= 15 else object

    def table(rows: list[list[Mpf]]) -> Numbers:
        longest = max((len(row) for row in rows), default=1)
        return np.array([[[*row, *[0 * row[0]] * (longest - len(row))] for row in rows]], dtype=kind)

    return Panels(np.array(edges, dtype=kind), table(values), table(sums), nodes, False)
