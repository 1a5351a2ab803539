"""Where p² is nearly zero, or nearly infinite, in the middle of a motion.

A barrier that is just overcome is a pair of complex zeros c ± iδ of F = p² close to the real axis: there F has a
minimum, and F ≈ F(c) + ½F″(c)(q − c)² vanishes at δ = √(2F/F″). A pair of poles (a softened centre of force) is a
maximum in the same way, with δ = √(2F/|F″|) up to a factor of order one. The pairs only choose a change of variable;
no integral depends on how well they are known.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.work_counter import count
from hjsolve.one_coordinate.momentum_squared import MomentumSquared

_GRID_PLACES = 257
_NEWTON_STEPS = 40
"""A simple zero of F′ takes log₂(bits) of them from nearby; a multiple one gains a bit a step."""


class ComplexZeroPair(NamedTuple):
    """A complex pair place ± i·gap of zeros or poles of p²."""

    place: Mpf
    gap: Mpf


def complex_zero_pairs(radicand: MomentumSquared, lower: Mpf, upper: Mpf, bits: int) -> list[ComplexZeroPair]:
    """Return the pairs over a stretch of q, the closest to the real axis first.

    Args:
        radicand: p².
        lower, upper: ends of the stretch, in many digits.
        bits: working precision.
    """
    context = multiprecision(bits)
    width = upper - lower
    found = [
        pair
        for q in _extrema(radicand, float(lower), float(upper))
        if (pair := _refined(radicand, context.convert(q), lower, upper, bits)) and pair.gap < width / 4
    ]
    distinct: list[ComplexZeroPair] = []
    for pair in sorted(found, key=lambda c: c.gap):
        if all(abs(pair.place - other.place) > width / _GRID_PLACES for other in distinct):
            distinct.append(pair)
    return distinct


def _extrema(radicand: MomentumSquared, lower: float, upper: float) -> list[float]:
    """Return places on a grid where p² stops growing or falling."""
    q = np.linspace(lower, upper, _GRID_PLACES + 2)[1:-1]
    count(squares=q.size)
    inputs = [float(x) for x in radicand.inputs(64)]
    with np.errstate(all="ignore"):
        rise = np.diff(np.broadcast_to(radicand.squared.run(Float64(), [q, *inputs])[0], q.shape))
    return [float(x) for x in q[1:-1][rise[:-1] * rise[1:] <= 0]]


def _refined(radicand: MomentumSquared, q: Mpf, lower: Mpf, upper: Mpf, bits: int) -> ComplexZeroPair | None:
    """Newton's method for F′ = 0; None where it leaves the stretch."""
    tiny = (upper - lower) * Multi(bits).context.mpf(2) ** (32 - bits)
    for _ in range(_NEWTON_STEPS):
        value, slope, bend = radicand.jet(q, bits)
        if not bend:
            return None
        q -= slope / bend
        if not lower < q < upper:
            return None
        if abs(slope / bend) <= tiny:
            break
    value, _, bend = radicand.jet(q, bits)
    return ComplexZeroPair(q, (2 * abs(value / bend)) ** 0.5) if value > 0 and bend else None
