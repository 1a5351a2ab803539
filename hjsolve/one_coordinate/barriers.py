"""Where a rotation is slowest: at the highest barrier. Its angle is counted from the place opposite to that."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.floats import Float64, multiprecision
from hjsolve.arithmetic.number_types import Elementwise, Mpf
from hjsolve.one_coordinate.coordinate_start import CoordinateStart

EQUAL_BARRIERS = 1e-9
"""Two barriers are called equal if p² over them differs by no more than this, over the largest p²."""

_CUT = 1e-6
_POINTS = 96


def barrier_order(q: Elementwise) -> Elementwise:
    """Return what is least for that of several equal barriers from which angles are counted: first from 0 upwards.

    Args:
        q: places, angles.
    """
    return (q + _CUT) % (2 * np.pi)


def slow_place(start: CoordinateStart, bits: int) -> tuple[Mpf, Mpf | None]:
    """Return where p² is least on the circle, whatever the initial place, and how far from the real axis its zero lies.

    Args:
        start: of a coordinate that goes round.
        bits: binary digits of the place.

    Returns:
        The place, of several equal ones the first from 0 upwards; and √(2F/F″), None for no zero near.
    """
    context = multiprecision(bits)
    q = context.convert(_roughly_slow(start, bits))
    for _ in range(60):
        value, slope, bend = start.radicand.jet(q, bits)
        if not bend > 0 or abs(slope / bend) > 0.1:
            return q, None
        q -= slope / bend
        if abs(slope / bend) < context.mpf(2) ** (16 - bits // 2):
            break
    value, _, bend = start.radicand.jet(q, bits)
    gap = (2 * value / bend) ** 0.5
    return q, gap


def _roughly_slow(start: CoordinateStart, bits: int) -> float:
    grid = 2 * np.pi * np.arange(_POINTS) / _POINTS
    inputs = [float(x) for x in start.radicand.inputs(bits)]
    values = np.broadcast_to(start.radicand.squared.run(Float64(), [grid, *inputs])[0], grid.shape)
    valleys: list[tuple[float, float]] = []
    for k in np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1))):
        q = float(grid[k])
        for _ in range(8):
            _, slope, bend = (float(x) for x in start.radicand.jet(multiprecision(64).convert(q), 64))
            if not (bend > 0 and abs(slope / bend) < 2 * np.pi / _POINTS):
                break
            q -= slope / bend
        valleys.append((float(start.radicand.value(multiprecision(64).convert(q), 64)), q))
    if not valleys:
        return float(grid[int(np.argmin(values))])
    equal = min(valleys)[0] + EQUAL_BARRIERS * float(np.abs(values).max())
    return min((q for value, q in valleys if value <= equal), key=barrier_order)
