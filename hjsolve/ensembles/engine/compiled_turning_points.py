"""Turning points of many orbits in compiled loops. Only imported where numba is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hjsolve.arithmetic.floats import EPS
from hjsolve.ensembles.engine.elementary import OPTIONS

_SWEEPS = 5
_STEPS = 110
_STRIDE = 0.2

value: Any = None
slope: Any = None
bend: Any = None
pack: Any = None
"""Of the program; see ``programs``."""


@njit(**OPTIONS)
def _first_step(P: float, outward: float, bend: float, size: float) -> float:
    """See ``turning_points.first_step``."""
    square = P * P
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    down = (outward + root) / (-2.0 * bend) if outward > 0 else 2.0 * square / (root - outward)
    if math.isfinite(down) and down > 0:
        return min(1.0625 * down, size)
    crude = -square / outward if outward < 0 else size
    return min(0.25 * size, crude) if crude > 0 else 0.25 * size


def _bracket(x0, step, side, floor, reach, c):
    """Walk outward: the last place with F ≥ 0 and the first with F < 0; see ``turning_points.bracket``."""
    inner = x0
    for _ in range(_STEPS):
        x = inner + side * step
        if side * (x - floor) > -0.25 * side * (floor - inner):
            x = floor + 0.25 * (inner - floor)
        f = value(x, c)[0]
        if f < 0.0:
            return inner, x
        if f >= 0.0:
            inner = x
            step = min(1.6 * step, _STRIDE) if math.isfinite(reach) else 1.6 * step
            if abs(x - x0) > reach:
                break
        else:
            step *= 0.25
    return inner, np.nan


def ends(q, P, C, floors, reach, places):
    """Turning points: brackets orbit by orbit, then Newton's method for all at once.

    Args:
        q, P: starts, shape (n,).
        C: constants, shape (constants, n).
        floors: ends of the domain.
        reach: longest distance to walk.
        places: where the results go, shape (2, n); NaN where there is none.
    """
    inner, moved = np.empty(q.shape), np.empty(q.shape)
    outer = np.empty(q.shape)
    for side in range(2):
        sign, floor = 2.0 * side - 1.0, floors[side]
        for i in range(q.shape[0]):
            x0, c = q[i], pack(C, i)
            _, first, second = bend(x0, c)
            inner[i], outer[i] = x0, np.nan
            if math.isfinite(first) and P[i] != 0.0 and x0 > floors[0] and x0 < floors[1]:
                size = min(abs(x0) if x0 != 0.0 else 1.0, sign * (floor - x0))
                size = min(size, 0.2) if math.isfinite(reach) else size
                step = _first_step(P[i], sign * first, 0.5 * second, size)
                inner[i], outer[i] = _bracket(x0, step, sign, floor, reach, c)
        x = places[side]
        x[:] = outer
        for _ in range(_SWEEPS):
            _sweep(x, inner, outer, moved, C)
        for i in range(q.shape[0]):
            small = min(1e-9 * abs(x[i]), 1e-6 * abs(x[i] - q[i]))
            if not moved[i] <= small and math.isfinite(outer[i]):
                x[i] = _finish(x[i], q[i], inner[i], outer[i], pack(C, i))


def _sweep(x, inner, outer, moved, C):
    """One step of Newton's method inside the brackets, without branches."""
    for i in range(x.shape[0]):
        f, d = slope(x[i], pack(C, i))
        low = x[i] if f >= 0.0 else inner[i]
        high = outer[i] if f >= 0.0 else x[i]
        new = x[i] - f / d
        new = new if (new - low) * (new - high) <= 0.0 else 0.5 * (low + high)
        inner[i], outer[i], moved[i] = low, high, abs(new - x[i])
        x[i] = new


def _finish(x, x0, inner, outer, c):
    """The same until it stands still, for one orbit."""
    for count in range(80):
        f, d = slope(x, c)
        if f >= 0.0:
            inner = x
        else:
            outer = x
        new = x - f / d
        if not (new - inner) * (new - outer) <= 0.0 or count % 16 == 15:
            new = 0.5 * (inner + outer)
        if abs(new - x) <= 4.0 * EPS * max(abs(new), abs(x0)):
            return new
        x = new
    return np.nan


BOUND = (_bracket, ends, _sweep, _finish)
"""See ``compiled_rule.BOUND``."""
