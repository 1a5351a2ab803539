"""The region in which one coordinate of many orbits moves: turning points, rotation, rest; and what is near it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hjsolve.batch.columns import Status
from hjsolve.batch.model import Formula, Model, Separated
from hjsolve.batch.nodes import MOST
from hjsolve.batch.quadrature import Region
from hjsolve.batch.roots import bracket, first_step, kept, refine
from hjsolve.batch.start import Begin, slope
from hjsolve.batch.views import Knowns, Near, Raw, View, second_slope
from hjsolve.numeric.doubled import Pair, two_sum
from hjsolve.numeric.slopes import FUNCTIONS

_SMALL = 3e-14
_NEAR = 3.0
_FAR = 0.5
_GRID = 32
_ARITHMETIC = frozenset({"add", "sub", "mul", "div", "power", "rational", "pi"})


@dataclass(frozen=True)
class Found:
    """Regions of some orbits.

    Attributes:
        index: which orbits. region: where they move. status: of each.
        rest: True where the coordinate stays at a stable double zero of p².
    """

    index: Any
    region: Region
    status: Any
    rest: Any

    def take(self, index: Any) -> Found:
        """Return some of them."""
        return Found(self.index[index], self.region.take(index), self.status[index], self.rest[index])


def locate(model: Model, coordinate: Separated, start: Begin, k: int) -> list[Found]:
    """Find where one coordinate moves.

    Args:
        model: of the system.
        coordinate: the k-th separated one.
        start: of n orbits; with ``pairs`` small amplitudes are seen from the start and poles from their place.
        k: row of the coordinate.
    """
    q, P = start.q[k], start.P[k]
    with np.errstate(all="ignore"):
        raw = Raw(coordinate.plain, start.knowns)
        _, first, second = raw.jet(q)
        bend = 0.5 * second
        noise = raw.errors(q, kernels=False)[0]
        crest = P * P + np.where(bend < 0, first * first / (-4 * bend), np.inf)
        small = noise > _SMALL * crest
        found = []
        if start.pairs is not None and _has_slopes(coordinate.plain):
            index = np.flatnonzero(small)
            if len(index):
                pairs = tuple(Pair(c.high[index], c.low[index]) for c in start.pairs)
                exact = slope(coordinate.plain, pairs, model.numbers, q[index])
                near = _near(coordinate, start.knowns.take(index), q[index], P[index], exact, index)
                small[index[near.status == Status.UNBOUNDED]] = False
                inside = np.flatnonzero(near.status != Status.UNBOUNDED)
                if len(inside):
                    found.append(near.take(inside))
            small = ~small
        else:
            small = np.ones(len(q), dtype=bool)
        index = np.flatnonzero(small)
        if len(index):
            parts = start.knowns.take(index), q[index], P[index], first[index], bend[index]
            found += _wide(coordinate, *parts, index, ends=start.pairs is not None)
    return found


def _has_slopes(formula: Formula) -> bool:
    return {operation.code for operation in formula.squared.operations} <= FUNCTIONS | _ARITHMETIC


def _near(coordinate: Separated, knowns: Knowns, q: Any, P: Any, first: Any, index: Any) -> Found:
    """Small motions about a deep maximum of p²."""
    bend, doubt = second_slope(coordinate.plain, knowns, q)
    view = Near(coordinate.plain, knowns, q, P, first, doubt)
    zero = np.zeros_like(q)
    rest = (P == 0) & (np.abs(first) <= 2.0**-40 * doubt * np.maximum(np.abs(q), 2.0**-40))
    floors = [
        np.full(len(q), side * np.inf) if formula is None else -formula.sign * _offset(formula, q)
        for side, formula in ((-1, coordinate.lower), (1, coordinate.upper))
    ]
    size = np.minimum(np.abs(q) + 1.0, np.minimum(-floors[0], floors[1]))
    ends = [_end(view, zero, P, side * first, bend, side, size, floor) for side, floor in zip((-1, 1), floors, strict=True)]
    far = (ends[0] < _FAR * floors[0]) | (ends[1] > _FAR * floors[1])
    ends[0] = np.where(far, np.nan, ends[0])
    region = _region(coordinate, view, view, ends[0], ends[1], P, -ends[0], ends[1])
    status = np.where(np.isfinite(region.width) & (region.width > 0), Status.OK, Status.UNBOUNDED)
    status = np.where(rest, np.where(bend < 0, Status.OK, Status.EQUILIBRIUM), status)
    return Found(index, region, status.astype(np.uint8), rest & (bend < 0))


def _end(
    view: View, start: Any, P: Any, outward: Any, bend: Any, side: int, size: Any, floor: Any, reach: float = np.inf
) -> Any:
    """Offset of the turning point on one side; ``side`` and ``outward`` in terms of the view's offset."""
    step = first_step(P, outward, bend, size)
    below = P * P
    rising = (outward > 0) & (bend < 0)
    inner = start.copy()
    crest = np.where(rising, np.minimum(outward / (-2 * bend), 0.5 * step), 0.0)
    for _ in range(12):
        todo = np.flatnonzero(crest > 0)
        if not len(todo):
            break
        x = start[todo] + side * crest[todo]
        x = kept(x, start[todo], floor[todo])
        f = view.take(todo).value(x)
        up = f > below[todo]
        inner[todo[up]], below[todo[up]] = x[up], f[up]
        crest[todo] = np.where(up, 0.0, 0.25 * crest[todo])
        step[todo[up]] = np.maximum(step[todo[up]] - np.abs(x[up] - start[todo[up]]), 0.25 * step[todo[up]])
    moved = inner.copy()

    def value(x: Any, index: Any) -> Any:
        return view.take(index).value(x)

    inner, outer = bracket(value, moved, step, side, floor=floor, reach=reach)
    away = np.flatnonzero(inner != moved)
    below[away] = np.maximum(value(inner[away], away), 5e-324) if len(away) else below[away]
    return refine(value, inner, outer, below)


def _wide(
    coordinate: Separated, knowns: Knowns, q: Any, P: Any, first: Any, bend: Any, index: Any, *, ends: bool
) -> list[Found]:
    """Motions whose amplitude is not small: rotations first, then librations."""
    if not coordinate.periodic:
        return [_libration(coordinate, knowns, q, P, first, bend, index, ends=ends)]
    raw = Raw(coordinate.plain, knowns)
    grid = np.pi * (1 + 2 * np.arange(_GRID) / _GRID)
    values = raw.value(grid + np.zeros((len(q), 1)))
    round_ = (values > 0).all(axis=1)
    found = []
    turning, going = np.flatnonzero(~round_), np.flatnonzero(round_)
    if len(turning):
        parts = (v[turning] for v in (q, P, first, bend, index))
        found.append(_libration(coordinate, knowns.take(turning), *parts, ends=False))
    if len(going):
        found.append(_rotation(coordinate, knowns.take(going), q[going], P[going], values[going], grid, index[going]))
    return found


def _libration(
    coordinate: Separated, knowns: Knowns, q: Any, P: Any, first: Any, bend: Any, index: Any, *, ends: bool
) -> Found:
    seen: list[tuple[View, Any, Any, Any]] = []
    plain = Raw(coordinate.plain, knowns)
    scale = np.sqrt(np.abs(P * P / bend))
    length = np.where(q != 0, np.abs(q), np.where(np.isfinite(scale) & (scale > 0), scale, 1.0))
    outside = np.zeros(len(q), dtype=bool)
    for side, formula in ((-1, coordinate.lower), (1, coordinate.upper)):
        view = plain if formula is None or not ends else Raw(formula, knowns)
        start = _offset(view.formula, q)
        distance = np.inf if formula is None else _offset(formula, q)
        outside |= distance <= 0
        step_side = side * view.sign
        floor = start + step_side * distance
        size = np.minimum(length, distance)
        reach = 2 * np.pi if coordinate.periodic else np.inf
        end = _end(view, start, P, side * first, bend, step_side, size, floor, reach)
        seen.append((view, start, end, step_side * (end - start)))
    (below, _, lower, left), (above, _, upper, right) = seen
    region = _region(coordinate, below, above, lower, upper, P, left, right)
    if ends:
        region = _stretched(region)
    status = np.where(np.isfinite(region.width) & (region.width > 0), Status.OK, Status.UNBOUNDED)
    status = np.where(outside | ~np.isfinite(P), Status.FORBIDDEN, status)
    return Found(index, region, status.astype(np.uint8), np.zeros(len(q), dtype=bool))


def _offset(formula: Formula, q: Any) -> Any:
    """x of a position: (q − origin)·sign with one rounding."""
    s, e = two_sum(q, -formula.origin.high)
    return formula.sign * (s + (e - formula.origin.low))


def _region(
    coordinate: Separated, below: View, above: View, lower: Any, upper: Any, P: Any, left: Any, right: Any
) -> Region:
    zero = np.zeros_like(P)
    return Region(below, above, lower, upper, left + right, zero, zero, np.zeros(len(P), dtype=int), P, left, right)


def _stretched(region: Region) -> Region:
    """Choose the anomaly: W·|S′/S| at an end is W over the distance of the zero or pole next to it."""
    nearby = []
    for view, x, side in ((region.below, region.lower, 1), (region.above, region.upper, -1)):
        assert isinstance(view, Raw)
        _, first, second = view.jet(x)
        inward = side * view.sign * first
        ρ = np.abs(region.width * second / (2 * inward) + 1)
        nearby.append(np.where(np.isfinite(ρ) & (ρ > _NEAR), ρ, 0.0))
    d, c = nearby
    level = np.ceil(np.log2((1 + d) * (1 + c)) / 2)
    level = np.clip(level, 0, MOST).astype(int)
    goal = 4.0**level
    d, c = np.where(d >= c, goal / (1 + c) - 1, d), np.where(d >= c, c, goal / (1 + d) - 1)
    return replace(region, near_lower=d, near_upper=c, level=level)


def _rotation(
    coordinate: Separated, knowns: Knowns, q: Any, P: Any, values: Any, grid: Any, index: Any
) -> Found:
    """The slow place: the first least value on a grid, improved by Newton's method on F′."""
    raw = Raw(coordinate.plain, knowns)
    least = values.min(axis=1, keepdims=True)
    slow = grid[np.argmax(values <= least + 1e-9 * np.abs(values).max(axis=1, keepdims=True), axis=1)]
    going = np.ones(len(q), dtype=bool)
    for _ in range(8):
        _, first, second = raw.jet(slow)
        step = first / second
        going &= (second > 0) & (np.abs(step) < 0.2)
        slow = np.where(going, slow - step, slow)
    value, _, second = raw.jet(slow)
    gap = np.sqrt(2 * value / second)
    complement = np.where(going & np.isfinite(gap), (gap / 2) ** 2 / (1 + (gap / 2) ** 2), 1.0)
    level = np.where(complement < 0.125, np.rint(-np.log2(complement) / 2), 0)
    zero = np.zeros_like(q)
    region = Region(
        raw, raw, slow, slow, zero + 2 * np.pi, zero, zero, np.clip(level, 0, MOST).astype(int), P, q - slow, zero,
        turning=False,
    )  # fmt: skip
    good = np.isfinite(P) & (P != 0) & (not coordinate.shifted)
    status = np.where(good, Status.OK, Status.EXACT).astype(np.uint8)
    return Found(index, region, status, np.zeros(len(q), dtype=bool))


