"""Which part of the plane of two constants is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.critical_curves import ROUNDS, CriticalCurve, Window, double_zeros
from hjsolve.energy_momentum.end_curves import curves_at_ends, symmetric_curves
from hjsolve.energy_momentum.monodromy import rests_at_ends
from hjsolve.errors import InvalidInputError, MissingValueError

_LOW, _HIGH = 0.12, 0.88


def chosen_window(given: Mapping[str, tuple[float, float]] | None, names: tuple[str, str]) -> Window | None:
    """Read a window; None where none was given.

    Args:
        given: name → (low, high).
        names: of x and y.

    Raises:
        InvalidInputError: a name is missing, or a range is none.
    """
    if given is None:
        return None
    ranges = []
    for name in names:
        try:
            low, high = (float(v) for v in given[name])
        except (KeyError, TypeError, ValueError):
            low = high = np.nan
        if not (np.isfinite([low, high]).all() and low < high):
            raise InvalidInputError(f'window: write window={{"{names[0]}": (low, high), "{names[1]}": (low, high)}}')
        ranges.append((low, high))
    return ranges[0], ranges[1]


def first_window(
    coordinates: Sequence[CoordinateKinds], names: tuple[str, str], point: tuple[float, float] | None
) -> Window:
    """Choose a window: x to both sides of the motion, or of zero for a momentum; y over the critical curves there.

    Args:
        coordinates: every separated coordinate.
        names: of x and y.

    Raises:
        MissingValueError: there is no motion to go by.
    """
    if point is None:
        raise MissingValueError(
            f'energy_momentum_map: no motion to go by; write window={{"{names[0]}": (low, high), '
            f'"{names[1]}": (low, high)}}, or give a motion in place of the solution'
        )
    sizes = [abs(v) or 1.0 for v in point]
    across = (-2.2 * sizes[0], 2.2 * sizes[0])
    if not names[0].startswith("p_"):
        across = (point[0] - 1.6 * sizes[0], point[0] + 1.6 * sizes[0])
    guess = (point[1] - 3 * sizes[1], point[1] + 3 * sizes[1])
    curves = [curve for own in coordinates for curve in critical_curves(own, (across, guess), rounds=2)]
    rests = [y for own in coordinates for x, y, _ in rests_at_ends(own) if across[0] <= x <= across[1]]
    heights = [y for curve in curves for y in _heights(curve, point[0])] + rests
    seen = [y for curve in curves if len(curve.q) for y in _seen(curve, across, guess)]
    low = max((y for y in heights if y < point[1]), default=min([point[1], *seen]))
    high = min((y for y in heights if y > point[1]), default=max([point[1], *seen]))
    room = 0.9 * (high - low) or sizes[1]
    return across, (float(low - room), float(high + room))


def _heights(curve: CriticalCurve, x: float) -> list[float]:
    """Return where a curve crosses a value of x."""
    a, b = curve.x[:-1], curve.x[1:]
    k = np.flatnonzero(((a - x) * (b - x) <= 0) & (a != b))
    return [float(y) for y in curve.y[k] + (x - a[k]) / (b[k] - a[k]) * (curve.y[k + 1] - curve.y[k])]


def _seen(curve: CriticalCurve, across: tuple[float, float], up: tuple[float, float]) -> list[float]:
    """Heights that most of the curve lies between."""
    inside = (curve.x >= across[0]) & (curve.x <= across[1]) & (curve.y >= up[0]) & (curve.y <= up[1])
    return list(np.quantile(curve.y[inside], [_LOW, _HIGH])) if inside.sum() > 3 else []


def critical_curves(own: CoordinateKinds, window: Window, rounds: int = ROUNDS) -> list[CriticalCurve]:
    """Trace the critical curves of one coordinate in a window of the plane.

    Args:
        own: the coordinate.
        window: ranges of x and y.
        rounds: how often places are put between those that lie far apart.
    """
    return [*double_zeros(own, window, rounds), *symmetric_curves(own, window), *curves_at_ends(own, window)]
