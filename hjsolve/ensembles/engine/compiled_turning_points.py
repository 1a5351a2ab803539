"""Turning points of many orbits in compiled loops. Only imported where numba is.

The programs of the coordinate come in as functions; see ``program_texts``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.engine.elementary import INLINED

_SWEEPS = 5
_STEPS = 110
_STRIDE = 0.2
_HALVINGS = 40
_FIXED = 40
_ALIKE = 2.0
_FAR = 0.5

Value = Callable[[float, Reals], float]
Bend = Callable[[float, Reals], tuple[float, float, float]]
Slopes = Callable[[Reals, Reals, Reals, Reals], None]
Bounds = Callable[[Reals, Reals, Reals, Reals], None]
Uncertainties = Callable[[Reals, Reals, Reals, Reals, Reals, Reals], None]


class SearchSide(NamedTuple):
    """Where turning points are looked for in one view, on one side.

    Attributes:
        start: offsets of the start, shape (n,).
        momentum: P₀.
        known: constants, shape (n, constants).
        columns: the same, shape (constants, n).
        floor: offset of the end of the domain on this side.
        side: +1 or −1, in terms of the offset.
        reach: longest distance to walk.
    """

    start: Reals
    momentum: Reals
    known: Reals
    columns: Reals
    floor: float
    side: float
    reach: float


@njit(**INLINED)
def _first_step(P: float, outward: float, bend: float, size: float) -> float:
    """See ``turning_points.first_step``."""
    square = P * P
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    down = (outward + root) / (-2.0 * bend) if outward > 0 else 2.0 * square / (root - outward)
    if math.isfinite(down) and down > 0:
        return min(1.0625 * down, size)
    crude = -square / outward if outward < 0 else size
    return min(0.25 * size, crude) if crude > 0 else 0.25 * size


@njit(**INLINED)
def _below_zero(bend: Bend, side: float, near: float, far: float, c: Reals) -> float:
    """A place with F < 0 in a valley of F, by bisection of F′; NaN where there is none."""
    for _ in range(_HALVINGS):
        x = 0.5 * (near + far)
        f, slope, _ = bend(x, c)
        if f < 0.0:
            return x
        if side * slope < 0.0:
            near = x
        else:
            far = x
    return np.nan


@njit(**INLINED)
def _bracket(bend: Bend, walk: SearchSide, x0: float, step: float, c: Reals) -> tuple[float, float]:
    """SearchSide outward: the last place with F ≥ 0 and the first with F < 0; see ``turning_points.bracket``."""
    inner, side, floor = x0, walk.side, walk.floor
    falling = True  # also from the top of F, where F′ is what rounding leaves
    for _ in range(_STEPS):
        x = inner + side * step
        if side * (x - floor) > -0.25 * side * (floor - inner):
            x = floor + 0.25 * (inner - floor)
        f, slope, _ = bend(x, c)
        if f < 0.0:
            return inner, x
        if f >= 0.0:
            if falling and side * slope > 0.0:
                bottom = _below_zero(bend, side, inner, x, c)
                if math.isfinite(bottom):
                    return inner, bottom
            inner, falling = x, side * slope < 0.0
            step = min(1.6 * step, _STRIDE) if math.isfinite(walk.reach) else 1.6 * step
            if abs(x - x0) > walk.reach:
                break
        else:
            step *= 0.25
    return inner, np.nan


@njit(**INLINED)
def ends(bend: Bend, slopes: Slopes, walk: SearchSide, places: Reals, bends: Reals,
         work: Reals) -> None:  # fmt: skip
    """Turning points on one side: brackets orbit by orbit, then Newton's method for all at once.

    Args:
        bend, slopes: programs of the view.
        walk: the starts.
        places: where the results go, shape (n,); NaN where there is none.
        bends: F′ and ½F″ there, shape (2, n).
        work: scratch, shape (5, n).
    """
    n, side, floor = places.shape[0], walk.side, walk.floor
    inner, outer, moved, f, d = work[0], work[1], work[2], work[3], work[4]
    for i in range(n):
        x0, c, P = walk.start[i], walk.known[i], walk.momentum[i]
        _, first, second = bend(x0, c)
        inner[i], outer[i] = x0, np.nan
        if math.isfinite(first) and P != 0.0 and side * (floor - x0) > 0.0:
            size = min(abs(x0) if x0 != 0.0 else 1.0, side * (floor - x0))
            size = min(size, 0.2) if math.isfinite(walk.reach) else size
            step = _first_step(P, side * first, 0.5 * second, size)
            inner[i], outer[i] = _bracket(bend, walk, x0, step, c)
    for i in range(n):
        places[i] = outer[i]
    for _ in range(_SWEEPS):
        slopes(places, walk.columns, f, d)
        _improved(places, inner, outer, moved, f, d)
    for i in range(n):
        x = places[i]
        small = min(1e-9 * abs(x), 1e-6 * abs(x - walk.start[i]))
        if not moved[i] <= small and math.isfinite(outer[i]):
            places[i] = _finish(bend, x, walk.start[i], (inner[i], outer[i]), walk.known[i])
        _, first, second = bend(places[i], walk.known[i])
        bends[0, i], bends[1, i] = first, 0.5 * second


@njit(**INLINED)
def _improved(x: Reals, inner: Reals, outer: Reals, moved: Reals, f: Reals, d: Reals) -> None:
    """One step of Newton's method inside the brackets, without branches."""
    for i in range(x.shape[0]):
        low = x[i] if f[i] >= 0.0 else inner[i]
        high = outer[i] if f[i] >= 0.0 else x[i]
        new = x[i] - f[i] / d[i]
        new = new if (new - low) * (new - high) <= 0.0 else 0.5 * (low + high)
        inner[i], outer[i], moved[i] = low, high, abs(new - x[i])
        x[i] = new


@njit(**INLINED)
def _finish(bend: Bend, x: float, x0: float, span: tuple[float, float], c: Reals) -> float:
    """The same until it stands still, for one orbit: to the last bits of x, or as far as p² tells.

    Next to an end of the domain x is small beside x₀ and has digits of its own, so that a step which is nothing beside
    x₀ does not end the search while steps still shrink.
    """
    inner, outer = span
    before = np.inf
    for count in range(80):
        f, d, _ = bend(x, c)
        if f >= 0.0:
            inner = x
        else:
            outer = x
        new = x - f / d
        halved = not (new - inner) * (new - outer) <= 0.0 or count % 16 == 15
        if halved:
            new = 0.5 * (inner + outer)
        step = abs(new - x)
        lost = step <= 4.0 * EPS * abs(x0) and step >= 0.25 * before and not halved
        if step <= 4.0 * EPS * abs(new) or lost:
            return new
        x, before = new, step
    return np.nan


@njit(**INLINED)
def crests(bend: Bend, uncertainties: Uncertainties, walk: SearchSide, uncertainty: Reals, small: Reals, place: Reals,
           out: Reals) -> None:  # fmt: skip
    """The error of p² at the start over about how large p² becomes; see ``regions.hopeless_in_doubles``.

    Args:
        bend, uncertainties: programs of the view.
        walk: the starts; P₀ and constants.
        uncertainty: bounds on the errors of the constants, shape (n, constants).
        small: where the results go, shape (n,).
        place: scratch, one place, its size and what counts the constants there, shape (3, 1).
        out: scratch, errors and F, shape (2 + kernels of the second program, 1).
    """
    place[2, 0] = 1.0
    for i in range(small.shape[0]):
        c, P = walk.known[i], walk.momentum[i]
        place[0, 0], place[1, 0] = walk.start[i], abs(walk.start[i])
        uncertainties(out, place[0], place[1], place[2], c, uncertainty[i])
        _, first, second = bend(walk.start[i], c)
        crest = P * P + (first * first / (-2.0 * second) if second < 0.0 else np.inf)
        small[i] = out[0, 0] / crest


@njit(**INLINED)
def _quadratic(square: float, outward: float, bend: float) -> float:
    """The positive zero of square + outward d + bend d², bend < 0."""
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    return (outward + root) / (-2.0 * bend) if outward > 0.0 else 2.0 * square / (root - outward)


@njit(**INLINED)
def _small_end(value: Value, c: Reals, side: float, start: tuple[float, float, float]) -> float:
    """Offset of a turning point: P₀² + F′₀ x + F[q₀, q₀, q₀ + x] x² = 0 solved again and again, by secants."""
    square, first, bend = start
    d = _quadratic(square, side * first, bend)
    if d == 0.0:
        return 0.0
    before, off = d, 0.0
    for count in range(_FIXED):
        here = _quadratic(square, side * first, value(side * d, c)) - d
        if not math.isfinite(here):
            return np.nan
        step = here
        if count and here != off:
            secant = -here * (d - before) / (here - off)
            step = secant if abs(secant) <= 2.0 * abs(here) else here
        before, off = d, here
        d += step
        if abs(step) <= 2.0 * EPS * d:
            return side * d
    return np.nan


@njit(**INLINED)
def small_ends(value: Value, bounds: Bounds, known: Reals, uncertainty: Reals, floors: Reals, places: Reals,
               place: Reals, out: Reals) -> None:  # fmt: skip
    """Turning points of small motions as offsets from the start; NaN where the motion is not as small as that.

    Args:
        value, bounds: programs; see ``program_texts.small_text``.
        known: constants, q₀, P₀², F′₀, and room for a bound on the error of F[b, b, q], b being the start or a turning
            point, and for the width, which are filled in; shape (n, constants + 5).
        uncertainty: bounds on the errors of the constants, shape (n, constants).
        floors: distances of the ends of the domain, shape (2, n), the first negative.
        places: where the results go, shape (2, n).
        place, out: scratch, shapes (3,) and (2, 3).
    """
    m = known.shape[1] - 5
    for i in range(known.shape[0]):
        c = known[i]
        q, square, first = c[m], c[m + 1], c[m + 2]
        bend, low, high = value(0.0, c), np.nan, np.nan
        if bend < 0.0 and (square > 0.0 or first != 0.0):
            low = _small_end(value, c, -1.0, (square, first, bend))
            high = _small_end(value, c, 1.0, (square, first, bend))
        place[0], place[1], place[2] = q, q + low, q + high
        bounds(out, place, c, uncertainty[i])
        c[m + 3], c[m + 4] = max(out[1, 0], out[1, 1], out[1, 2]), high - low
        # the uncertainty of the slopes is known at the start: it has to hold at the turning points, too
        alike = out[1, 1] <= _ALIKE * out[1, 0] and out[1, 2] <= _ALIKE * out[1, 0]
        near = low >= _FAR * floors[0, i] and high <= _FAR * floors[1, i]
        places[0, i], places[1, i] = (low, high) if alike and near else (np.nan, np.nan)
