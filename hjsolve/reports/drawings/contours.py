"""Lines of equal value on a grid: marching squares, each cell's crossing as a short segment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hjsolve.reports.drawings.svg import Array, DrawingFrame


def segments(x: Array, y: Array, values: Array, level: float) -> Array:
    """Find where a function given on a grid crosses a level.

    Args:
        x: places across, shape (m,).
        y: places up, shape (n,).
        values: shape (n, m); cells with a corner that is not finite are left out.
        level: the level.

    Returns:
        Segments (x0, y0, x1, y1), shape (k, 4).
    """
    v = values - level
    corners = np.stack([v[:-1, :-1], v[:-1, 1:], v[1:, 1:], v[1:, :-1]], axis=-1)
    left, low = np.broadcast_to(x[:-1], v[1:, 1:].shape), np.broadcast_to(y[:-1, None], v[1:, 1:].shape)
    right, high = np.broadcast_to(x[1:], left.shape), np.broadcast_to(y[1:, None], left.shape)
    cx, cy = np.stack([left, right, right, left], axis=-1), np.stack([low, low, high, high], axis=-1)
    good = np.isfinite(corners).all(axis=-1) & (np.ptp(np.sign(corners), axis=-1) > 0)
    c, cx, cy = corners[good], cx[good], cy[good]
    d, dx, dy = (np.roll(a, -1, axis=1) for a in (c, cx, cy))
    crossed = (c < 0) != (d < 0)
    with np.errstate(all="ignore"):
        s = np.where(crossed, c / (c - d), 0.0)
    px, py = cx + s * (dx - cx), cy + s * (dy - cy)
    found = []
    for k in range(len(c)):
        edges = np.flatnonzero(crossed[k])
        found += [(px[k, a], py[k, a], px[k, b], py[k, b]) for a, b in zip(edges[::2], edges[1::2])]
    return np.array(found).reshape(-1, 4)


def drawn_level(frame: DrawingFrame, x: Array, y: Array, values: Array, level: float) -> str:
    """Write the segments of ``segments`` as the data of a path."""
    ends = segments(x, y, values, level)
    a, b, c, d = frame.px(ends[:, 0]), frame.py(ends[:, 1]), frame.px(ends[:, 2]), frame.py(ends[:, 3])
    return "".join(f"M{p:.1f} {q:.1f}L{r:.1f} {s:.1f}" for p, q, r, s in zip(a, b, c, d))


def spread_levels(values: Array, many: int) -> Sequence[float]:
    """Choose levels that part the values into equal parts.

    Args:
        values: any; those that are not finite do not count.
        many: how many levels.
    """
    finite = values[np.isfinite(values)]
    if len(finite) < 4 or np.ptp(finite) <= 1e-12 * np.abs(finite).max():
        return ()
    return [float(v) for v in np.quantile(finite, (np.arange(many) + 0.5) / many)]
