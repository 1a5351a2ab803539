"""Level curves of one separated coordinate: intervals where P² > 0, and P on them."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.root_finding import bisected
from hjsolve.reports.drawings.effective_potential import Array, EffectivePotential

_SCAN = 1200


def window_places(well: EffectivePotential) -> Array:
    """Return places across the window, without the ends of the domain, where the potential may be infinite.

    Returns:
        Increasing places, shape (1200,).
    """
    low, high = well.window
    return np.asarray(low + (high - low) * (np.arange(_SCAN) + 0.5) / _SCAN)


def allowed(well: EffectivePotential, level: float) -> list[tuple[float, float]]:
    """Find the intervals of the window where the motion is allowed at a level.

    Args:
        level: value of the level constant.

    Returns:
        (low, high) of each; an interval that reaches past the window ends at the window.
    """
    q = window_places(well)
    positive = well.momentum_squared(q, level) > 0
    change = np.flatnonzero(np.diff(positive.astype(int)))
    roots = [_root(well, level, q[i], q[i + 1]) for i in change]
    edges = [*([well.window[0]] if positive[0] else []), *roots, *([well.window[1]] if positive[-1] else [])]
    return list(zip(edges[::2], edges[1::2]))


def loop(well: EffectivePotential, level: float, low: float, high: float, points: int = 181) -> tuple[Array, Array]:
    """Give the phase curve over an allowed interval, there and back.

    The places crowd together at the ends like those of the anomaly q = m − h cos χ, so that the curve closes smoothly.

    Args:
        level: value of the level constant.
        low: lower end of the interval.
        high: upper end.
        points: places on one branch.

    Returns:
        (q, p), the upper branch to the right and the lower one back; NaN between them where the curve leaves
        the window.
    """
    q = (low + high) / 2 - (high - low) / 2 * np.cos(np.linspace(0.0, np.pi, points))
    with np.errstate(invalid="ignore"):
        square = well.momentum_squared(q, level)
    square[0], square[-1] = (
        0.0 if not np.isfinite(s) or abs(s) < 1e-9 * np.nanmax(np.abs(square)) else s for s in square[[0, -1]]
    )
    P = np.sqrt(np.where(square >= 0, square, 0.0))
    shift = well.shift(q)
    upper, lower = P - shift, (-P - shift)[::-1]
    if P[-1] > 1e-6 * np.max(P):
        lower[0] = np.nan
    return np.concatenate([q, q[::-1]]), np.concatenate([upper, lower])


def hills(well: EffectivePotential) -> list[tuple[float, str]]:
    """Find the levels that divide the motions: interior maxima of the effective potential, and its limit far out.

    Returns:
        (level, what it is), each level once; what is ``separatrix`` or ``edge of the bound motions``.
    """
    q = window_places(well)
    V = well.potential(q)
    if well.periodic and well.window[1] - well.window[0] > 6.28:
        V = np.concatenate([V[-1:], V, V[:1]])
    inner = np.flatnonzero((V[1:-1] >= V[:-2]) & (V[1:-1] > V[2:]) & np.isfinite(V[1:-1]))
    found = [(_peak(V[i : i + 3]), "separatrix") for i in inner]
    for side, end in zip((-1.0, 1.0), well.domain):
        if not np.isfinite(end) and not well.periodic:
            far = well.potential(np.array([1e7, 1e9]) * side * max(1.0, abs(well.window[1])))
            settled = np.isfinite(far).all() and abs(far[1] - far[0]) < 1e-5 * (1 + abs(far[1]))
            found += [(round(float(far[1]), 12), "edge of the bound motions")] if settled else []
    return [
        hill
        for i, hill in enumerate(found)
        if all(abs(hill[0] - other[0]) > 1e-6 * (1 + abs(hill[0])) for other in found[:i])
    ]


def _peak(three: Array) -> float:
    """Height of the parabola through three neighbouring values."""
    a, b, c = (float(v) for v in three)
    bend = a - 2 * b + c
    return b if bend == 0 or not np.isfinite(bend) else b - (c - a) ** 2 / (8 * bend)


def levels(well: EffectivePotential) -> list[float]:
    """Choose levels worth drawing next to the motion's own.

    Args:
        well: the coordinate.

    Returns:
        Levels from near the bottom of the well to above the motion.
    """
    V = well.potential(window_places(well))
    bottom = float(np.min(V[np.isfinite(V)], initial=np.inf))
    if not np.isfinite(bottom) or not well.level_name:
        return []
    top = float(np.quantile(V[np.isfinite(V)], 0.9))
    depth = well.level - bottom
    if depth < 1e-6 * max(abs(bottom), 1e-300):
        depth = 0.5 * (top - bottom) or 1.0
        return [bottom + depth * part for part in (0.12, 0.4, 0.8, 1.4)]
    return [bottom + depth * part for part in (0.1, 0.34, 0.66, 1.4, 1.9, 2.5)]


def _root(well: EffectivePotential, level: float, low: float, high: float) -> float:
    inside = bool(well.momentum_squared(np.array([low]), level)[0] > 0)
    low, high = bisected(lambda q: bool(well.momentum_squared(np.array([q]), level)[0] > 0) == inside, low, high, 50)
    return (low + high) / 2
