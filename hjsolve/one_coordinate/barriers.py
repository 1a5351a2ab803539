"""Where a rotation is slowest: at the highest barrier. Its angle is counted from the place opposite to that.

There p² ≈ F₀ + ½F″ (q − q₀)² has its complex pair of zeros next to the real axis, q₀ ± i √(2F₀/F″).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.floats import Float64, multiprecision
from hjsolve.arithmetic.number_types import Elementwise, Mpf
from hjsolve.arithmetic.root_finding import stationary
from hjsolve.one_coordinate.coordinate_start import CoordinateStart

EQUAL_BARRIERS = 1e-9
"""Two barriers are called equal if p² over them differs by no more than this, over the largest p²."""

_CUT = 1e-6  # so that a barrier at angle 0, rounded to 2π − ε, stays the first
_POINTS = 96  # on a turn: two valleys nearer than 4° count as one


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
    # the least p² over the whole turn, not that next to the start: the map depends on the orbit, not on where it begins
    q = context.convert(_roughly_slow(start, bits))
    place = _valley(start, q, 0.1, context.mpf(2) ** (16 - bits // 2), bits)
    if place is None:
        return q, None
    value, _, bend = start.radicand.jet(place, bits)
    # F ≈ F₀ + ½F″(q − q₀)² vanishes at q₀ ± i√(2F₀/F″)
    return place, (2 * value / bend) ** 0.5


def _valley(start: CoordinateStart, q: Mpf, farthest: float, close: Mpf, bits: int) -> Mpf | None:
    """Return where p² is least next to a place, None where it is not within a distance."""
    return stationary(
        lambda x: start.radicand.jet(x, bits), q, lambda bend, x: bend > 0 and abs(x - q) < farthest, close
    )


def _roughly_slow(start: CoordinateStart, bits: int) -> float:
    context = multiprecision(64)
    grid = 2 * np.pi * np.arange(_POINTS) / _POINTS
    inputs = [float(x) for x in start.radicand.inputs(bits)]
    values = np.broadcast_to(start.radicand.squared.run(Float64(), [grid, *inputs])[0], grid.shape)
    valleys: list[tuple[float, float]] = []
    # every valley of the grid is brought to its bottom before the deepest is chosen: equal barriers differ on a grid
    for k in np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1))):
        q = context.convert(float(grid[k]))
        place = _valley(start, q, 2 * np.pi / _POINTS, context.mpf(2) ** -50, 64)
        place = q if place is None else place
        valleys.append((float(start.radicand.value(place, 64)), float(place)))
    if not valleys:
        return float(grid[int(np.argmin(values))])
    # of barriers that are equal but for rounding always the same one: results must not depend on it
    equal = min(valleys)[0] + EQUAL_BARRIERS * float(np.abs(values).max())
    return min((q for value, q in valleys if value <= equal), key=barrier_order)
