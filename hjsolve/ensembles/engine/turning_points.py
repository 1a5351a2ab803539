"""Turning points of many orbits at once: a bracket found outward from the start, then Chandrupatla's method.

Chandrupatla, Advances in Engineering Software 28 (1997) 145: inverse quadratic steps where they are safe, bisection
elsewhere, so a sign change is never lost. Which sign change it is cannot be proved in doubles: a pair of zeros between
two trials goes unseen, if F does not fall at the one and rise at the other. It leaves a place where p² < 0, or a
function with a kink, between the turning points, and the quadrature refuses those (``midpoint_rule``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.radicand_views import DifferenceEvaluation, View

Function = Callable[[Reals, Integers], Reals]
"""(x, index of the orbits) ↦ F, arrays of shape (m,)."""

STEPS = 110
_STRIDE = 0.2
_HALVINGS, _SURE = 40, 10


@dataclass(frozen=True)
class Search:
    """The way from the start to the turning point on one side, arrays (n,); all in terms of the view's offset.

    Attributes:
        view: of p².
        start: where it begins.
        P, outward, bend: the momentum there, dF/dd outward, ½F″.
        side: +1 or −1.
        size: a length typical of the coordinate.
        floor: an end of the domain; infinite for none.
    """

    view: View
    start: Reals
    P: Reals
    outward: Reals
    bend: Reals
    side: Integers
    size: Reals
    floor: Reals

    def and_then(self, other: Search) -> Search:
        """Return both searches, where they have the same view, as one: numpy's price is by the call.

        Args:
            other: searches of the same orbits.
        """
        twice = np.tile(np.arange(len(self.P)), 2)
        names = ("start", "P", "outward", "bend", "side", "size", "floor")
        return Search(self.view.take(twice), *(np.concatenate([getattr(w, n) for w in (self, other)]) for n in names))


def both_ends(
    lower: Search, upper: Search, *, reach: float = np.inf, careful: bool = False, steps: int = STEPS
) -> tuple[Reals, Reals]:
    """Return offsets of the turning points, NaN where there is none.

    Args:
        lower, upper: the searches.
        reach: longest distance to walk.
        careful: whether valleys between two trials are looked into.
        steps: how many at most.
    """
    if lower.view is not upper.view:
        return _end(lower, reach, careful, steps), _end(upper, reach, careful, steps)
    found = _end(lower.and_then(upper), reach, careful, steps)
    return found[: len(found) // 2], found[len(found) // 2 :]


def _end(search: Search, reach: float, careful: bool, steps: int) -> Reals:
    """Offset of the turning point that a search finds."""
    view, start, side, floor = search.view, search.start, search.side, search.floor
    step, below = first_step(search.P, search.outward, search.bend, search.size), search.P * search.P
    rising = (search.outward > 0) & (search.bend < 0)
    inner = start.copy()
    crest = np.where(rising, np.minimum(search.outward / (-2 * search.bend), 0.5 * step), 0.0)
    for _ in range(12):
        todo = np.flatnonzero(crest > 0)
        if not len(todo):
            break
        x = start[todo] + side[todo] * crest[todo]
        x = kept_inside(x, start[todo], floor[todo])
        f = view.take(todo).value(x)
        up = f > below[todo]
        inner[todo[up]], below[todo[up]] = x[up], f[up]
        crest[todo] = np.where(up, 0.0, 0.25 * crest[todo])
        step[todo[up]] = np.maximum(step[todo[up]] - np.abs(x[up] - start[todo[up]]), 0.25 * step[todo[up]])
    moved = inner.copy()

    def value(x: Reals, index: Integers) -> Reals:
        return view.take(index).value(x)

    def slope(x: Reals, index: Integers) -> Reals:
        some = view.take(index)
        assert not isinstance(some, DifferenceEvaluation)
        return some.jet(x)[1]

    derivative = slope if careful else None
    inner, outer = bracket(value, moved, step, side, floor=floor, reach=reach, slope=derivative, steps=steps)
    away = np.flatnonzero(inner != moved)
    below[away] = np.maximum(value(inner[away], away), 5e-324) if len(away) else below[away]
    return refine(value, inner, outer, below)


def first_step(momentum: Reals, slope: Reals, bend: Reals, size: Reals) -> Reals:
    """Distance at which P₀² + slope·d + bend·d² vanishes, a little more, at most ``size``; less where it never does.

    Args:
        momentum: P₀.
        slope: dF/dd outward.
        bend: ½ F″.
        size: a length typical of the coordinate.
    """
    square = momentum * momentum
    with np.errstate(all="ignore"):
        root = np.sqrt(slope * slope - 4 * bend * square)
        down = np.where(slope > 0, (slope + root) / (-2 * bend), 2 * square / (root - slope))
        crude = np.minimum(0.25 * size, np.where(slope < 0, -square / slope, np.inf))
    found = np.isfinite(down) & (down > 0)
    return np.where(found, np.minimum(1.0625 * down, size), np.where(crude > 0, crude, 0.25 * size))


def bracket(
    function: Function, start: Reals, step: Reals, side: Integers, *, floor: Reals, reach: float,
    slope: Function | None = None, steps: int = STEPS,
) -> tuple[Reals, Reals]:  # fmt: skip
    """Walk from the start until F < 0.

    Args:
        function: F.
        start: offsets where the walk begins, shape (n,).
        step: first step, positive.
        side: +1 or −1, shape (n,).
        floor: an end of the domain that x may come near to only in ever smaller steps, shape (n,); infinite for none.
        reach: longest distance to walk.
        slope: F′; where it is given, a valley between two trials is looked into.
        steps: how many at most.

    Returns:
        The last place with F ≥ 0 and the first with F < 0; NaN where there was none.
    """
    inner, outer, step = start.copy(), np.full(start.shape, np.nan), step.copy()
    index = np.arange(len(start))
    falling = np.ones(len(start), dtype=bool)  # also from the top of F, where F′ is what rounding leaves
    for _ in range(steps):
        x = inner[index] + side[index] * step[index]
        x = kept_inside(x, inner[index], floor[index])
        f = function(x, index)
        negative = f < 0
        outer[index[negative]] = x[negative]
        if slope is not None:
            steep = side[index] * slope(x, index)
            some = np.flatnonzero((f >= 0) & falling[index] & (steep > 0))
            bottom = _below_zero(function, slope, inner[index[some]], x[some], index[some], side[index[some]])
            outer[index[some]] = bottom
            falling[index] = steep < 0
            f[some[np.isfinite(bottom)]] = -1.0
        lost = ~np.isfinite(f)
        step[index[lost]] *= 0.25
        onward = (f >= 0) & (np.abs(x - start[index]) < reach)
        inner[index[onward]] = x[onward]
        step[index[onward]] = np.minimum(1.6 * step[index[onward]], _STRIDE if np.isfinite(reach) else np.inf)
        index = index[onward | lost]
        if not len(index):
            break
    return inner, outer


def _below_zero(
    function: Function, slope: Function, near: Reals, far: Reals, index: Integers, side: Integers
) -> Reals:
    """Places with F < 0 in valleys of F, by bisection of F′; NaN where there are none.

    After some halvings a valley has none if its sides would end above zero though they went on twice as steep.
    """
    found, near, far = np.full(len(near), np.nan), near.copy(), far.copy()
    left = np.arange(len(near))
    for halving in range(_HALVINGS):
        if not len(left):
            break
        x = 0.5 * (near[left] + far[left])
        value, steep = function(x, index[left]), side[left] * slope(x, index[left])
        below, down = value < 0, steep < 0
        found[left[below]] = x[below]
        near[left[down]], far[left[~down]] = x[down], x[~down]
        above = (value > 2 * np.abs(steep * (far[left] - near[left]))) & (halving >= _SURE)
        left = left[~below & ~above]
    return found


def kept_inside(x: Reals, inner: Reals, floor: Reals) -> Reals:
    """Return x, or three quarters of the way to the floor where x lies beyond that.

    Args:
        x: places searched, shape (n,).
        inner: places inside the motion.
        floor: ends of the domain beyond x.
    """
    with np.errstate(invalid="ignore"):
        limit = floor + 0.25 * (inner - floor)
        return np.where((x - inner) / (floor - inner) > 0.75, limit, x)


def refine(function: Function, inner: Reals, outer: Reals, below: Reals) -> Reals:
    """Return the zero between ``inner`` (F ≥ 0) and ``outer`` (F < 0), to the last bits of x; NaN stays NaN.

    Args:
        function: F.
        inner, outer: the bracket.
        below: F at ``inner``, known to be at least zero there.
    """
    result = inner.copy()
    result[np.isnan(outer)] = np.nan
    index = np.flatnonzero(~np.isnan(outer) & (below > 0))
    a, b = outer[index], inner[index]
    fa, fb = function(a, index), below[index].copy()
    c, fc, t = a.copy(), fa.copy(), np.full(len(index), 0.5)
    falsi = fa / (fa - fb)
    t = np.where(np.isfinite(falsi), np.clip(falsi, 0.02, 0.98), 0.5)
    for _ in range(80):
        x = a + t * (b - a)
        f = function(x, index)
        same = np.sign(f) == np.sign(fa)
        c, fc, b, fb = np.where(same, a, b), np.where(same, fa, fb), np.where(same, b, a), np.where(same, fb, fa)
        a, fa = x, f
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        limit = EPS * np.abs(best) / np.abs(b - a)
        done = (limit > 0.5) | (f == 0) | ~np.isfinite(f)
        if done.any():
            ready = index[done]
            result[ready] = np.where(np.isfinite(f), np.where(f == 0, a, best), np.nan)[done]
            keep = ~done
            index, a, fa, b, fb, c, fc, limit = (v[keep] for v in (index, a, fa, b, fb, c, fc, limit))
            if not len(index):
                return result
        t = _next(a, fa, b, fb, c, fc, limit)
    result[index] = np.nan
    return result


def _next(a: Reals, fa: Reals, b: Reals, fb: Reals, c: Reals, fc: Reals, limit: Reals) -> Reals:
    """Chandrupatla's choice of the next place, as a fraction of the way from a to b."""
    with np.errstate(all="ignore"):
        ξ, φ = (a - b) / (c - b), (fa - fb) / (fc - fb)
        safe = (φ * φ < ξ) & ((1 - φ) ** 2 < 1 - ξ)
        t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return np.clip(np.where(safe & np.isfinite(t), t, 0.5), limit, 1 - limit)
