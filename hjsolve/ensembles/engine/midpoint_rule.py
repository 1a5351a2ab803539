"""Integrals over one cycle of one coordinate for many orbits: the midpoint rule in the anomaly.

With F = (q − a)(b − q) S and the anomaly χ, the integrands are F·r for the action and kⱼ·r for ∂J/∂cⱼ, where
r = |dq/dχ|/√F = stretch/√S is regular. Coefficients of an analytic function fall geometrically, so the last ones of
the discrete cosine series tell the error: of the running integral as they are; of the mean, which aliases at twice the
number of nodes, nearly squared (Trefethen & Weideman, SIAM Review 56 (2014) 385, §3). That p² does nothing between the
nodes which they do not show is proved (``resolution``); a region that holds a place with p² < 0 does not converge then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals, Which
from hjsolve.arithmetic.reproducible_products import rowwise
from hjsolve.ensembles.engine import nodes as tables
from hjsolve.ensembles.engine.initial_phase import EndNodes, phase_of_libration, phase_of_rotation
from hjsolve.ensembles.engine.orbit_regions import OrbitRegions
from hjsolve.ensembles.engine.radicand_views import View
from hjsolve.ensembles.engine.resolution import least
from hjsolve.ensembles.engine.turned_circle import moved

_SAFETY = 1.5
_GOAL = 4e-16
_HOPELESS = 2.0
"""How many times the largest number of nodes may seem to be needed where that is tried all the same."""
_PLACES = 5
_ELEMENTS = 1 << 18
_MANY, _FINE = 512, 5e-13
"""Beyond so many nodes p² is small somewhere: what doubles do not know to this is for engines with more digits."""
_FEW = 1 << 13
"""Nodes of all orbits of a task below which it shares its evaluations with others."""


@dataclass(frozen=True)
class Sums:
    """Integrals of one coordinate; arrays (n,), or (constants, n).

    Attributes:
        action: (1/2π) ∮ |p| dq.
        means: ∂J/∂cⱼ.
        oscillations: ∫₀^χ₀ kⱼ r dχ less its mean growth.
        phase: χ of the start.
        speeds: kⱼ r there.
        action_error, mean_errors, oscillation_errors, phase_error: bounds.
        good: True where the nodes sufficed.
    """

    action: Reals
    action_error: Reals
    means: Reals
    mean_errors: Reals
    oscillations: Reals
    oscillation_errors: Reals
    phase: Reals
    phase_error: Reals
    speeds: Reals
    good: Mask

    def put(self, index: Which, other: Sums) -> None:
        """Write the results of some orbits into these.

        Args:
            index: the places of the orbits, positions or a mask.
            other: their results, in the same order.
        """
        for name in self.__dataclass_fields__:
            mine, theirs = getattr(self, name), getattr(other, name)
            mine[..., index] = theirs

    def take(self, index: Which) -> Sums:
        """Return the results of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        return Sums(**{name: getattr(self, name)[..., index] for name in self.__dataclass_fields__})


def empty(constants: int, count: int) -> Sums:
    """Return sums that hold nothing: nan, and ``good`` nowhere true.

    Args:
        constants: how many constants of the motion there are.
        count: how many orbits.
    """
    row, block = (lambda: np.full(count, np.nan)), (lambda: np.full((constants, count), np.nan))
    return Sums(row(), row(), block(), block(), block(), block(), row(), row(), block(), np.zeros(count, dtype=bool))


def integrate(region: OrbitRegions, constants: int, *, kernels: bool, oscillations: bool, first: int = 32) -> Sums:
    """Integrate with as many nodes as every orbit needs, and no fewer than are proved to resolve it.

    Args:
        region: of n orbits.
        constants: how many there are.
        kernels: True when ∂J/∂c are wanted.
        oscillations: True when the phase and the running integrals are, too.
        first: number of nodes to begin with.
    """
    count = len(region.width)
    sums = empty(constants, count)
    needed = least(region, first)
    while True:
        size = np.zeros(count, dtype=int)
        for c in tables.COUNTS[::-1]:
            size[needed <= c] = c
        size[needed > tables.COUNTS[-1]] = 0
        if not size.any():
            return sums
        needed[:] = np.inf
        codes = np.where(size > 0, (size * 64 + region.level) * 8 + region.node_map, -1)
        tasks = [
            _Task.of(region, part, table)
            for code in np.unique(codes[size > 0])
            for group, table in [(np.flatnonzero(codes == code), _table(region, int(code)))]
            for part in np.array_split(group, len(group) * len(table.χ) // _ELEMENTS + 1)
        ]
        for together in _companies(tasks):
            for task, seen in zip(together, _integrands(region, together, kernels), strict=True):
                result, more = _rule(task, seen, constants, kernels=kernels, oscillations=oscillations)
                if task.count < tables.COUNTS[-1]:  # coefficients promise little: the largest rule is tried once
                    more = np.where(more < _HOPELESS * tables.COUNTS[-1], np.minimum(more, tables.COUNTS[-1]), more)
                needed[task.orbits] = np.where(result.good, np.inf, more)
                sums.put(task.orbits, result)


def _table(region: OrbitRegions, code: int) -> tables.Nodes:
    count, level, node_map = code // 512, code // 8 % 64, code % 8
    return tables.node_table(region.turning, count, level, node_map)


_Seen = tuple[Reals, Reals, list[Reals], list[Reals], Reals]
"""F, r, the kernels, bounds on errors of F and of them, and the smooth part of the first, at the nodes."""


@dataclass(frozen=True)
class _Task:
    """Orbits that share their nodes.

    Attributes:
        orbits: which they are.
        region: of these.
        table: their nodes.
        places: offsets in the two views, and (dq/dχ)², at the nodes; arrays (n, nodes).
    """

    orbits: Integers
    region: OrbitRegions
    table: tables.Nodes
    places: tuple[Reals, Reals, Reals]

    @staticmethod
    def of(region: OrbitRegions, orbits: Integers, table: tables.Nodes) -> _Task:
        """Some of the orbits of a region."""
        own = region.take(orbits)
        with np.errstate(all="ignore"):
            return _Task(orbits, own, table, _librating(own, table) if region.turning else _rotating(own, table))

    @property
    def count(self) -> int:
        """How many nodes there are in half a period."""
        return len(self.table.χ) if self.region.turning else len(self.table.χ) // 2

    @property
    def smooth(self) -> bool:
        """Whether nodes are nowhere crowded."""
        return self.table.complement == 1.0 and self.table.node_map == (0.0, 0.0)


def _companies(tasks: list[_Task]) -> Iterator[list[_Task]]:
    """Small tasks are evaluated together: numpy's price is by the call."""
    together: list[_Task] = []
    total = 0
    for task in tasks:
        size = len(task.orbits) * len(task.table.χ)
        if size > _FEW:
            yield [task]
            continue
        if total + size > _ELEMENTS:
            yield together
            together, total = [], 0
        together.append(task)
        total += size
    if together:
        yield together


def _rule(task: _Task, seen: _Seen, constants: int, *, kernels: bool, oscillations: bool) -> tuple[Sums, Reals]:
    """Apply the rule with a number of nodes; also return how many would be needed."""
    region, table, count = task.region, task.table, task.count
    with np.errstate(all="ignore"):
        F, ratio, weights, uncertainties, drift = seen
        n = len(F)
        rows = [F * ratio, *(w * ratio for w in weights)]
        noise = [0.5 * ratio * uncertainties[0]]
        # a smooth error moves the turning points along: it is not magnified at the nodes next to them
        damping = np.minimum(1.0, 24 * np.abs(table.low * table.high)) if region.turning else 1.0
        relative = 0.5 * (uncertainties[0] - (1 - damping) * drift) / F
        noise += [ratio * (np.abs(w) * relative + e) for w, e in zip(weights, uncertainties[1:], strict=True)]
        values = np.stack([np.broadcast_to(row, F.shape) for row in rows])
        mean, size = values.mean(axis=2), np.abs(values).mean(axis=2)
        rounding = _SAFETY * np.stack([np.broadcast_to(e, F.shape).mean(axis=1) for e in noise]) + 8 * EPS * size
        tail, middle = (_largest(values, table, rows) for rows in (table.last, table.middle))
        alias = 4 * tail * np.minimum(1.0, tail / np.maximum(middle, 1e-300)) ** 1.5
        mean_error = rounding + alias
        goal = np.maximum(_GOAL * size, 0.25 * rounding)
        excess = np.where(tail > 0, tail, 1e-300) / size
        wish = 1e-10 if not oscillations else 1e-15
        more = np.max(2 + (count - 2) * np.log(wish) / np.log(np.minimum(excess, 0.5)), axis=0)
    fits = (alias <= goal) | (tail <= 0.5 * rounding)
    if oscillations:
        fits &= tail <= np.maximum(4e-15 * size, rounding)
    if count > _MANY:
        fits &= mean_error <= _FINE * size
    real = np.all(F > 0, axis=1) & np.isfinite(mean).all(axis=0)
    good = np.all(fits | (size == 0), axis=0) & real
    more = np.where(real, np.clip(more, count + 1, 3 * count), 2 * count)
    sums = empty(constants, n)
    sums.action[:], sums.action_error[:], sums.good[:] = mean[0], mean_error[0], good
    if kernels:
        sums.means[:], sums.mean_errors[:] = mean[1:], mean_error[1:]
    if oscillations and good.any():  # the others come again with more nodes
        chosen = np.flatnonzero(good)
        own, noise_there = region.take(chosen), (tail[1:] + 0.5 * rounding[1:])[:, chosen]
        with np.errstate(all="ignore"):
            ends = _ends(own, table, uncertainties[0][chosen] / F[chosen])
            part = _running(own, table, np.ascontiguousarray(values[1:, chosen]), ratio[chosen], noise_there, ends)
        for name, value in part.items():
            getattr(sums, name)[..., chosen] = value
    return sums, more


def _ends(region: OrbitRegions, table: tables.Nodes, uncertainty: Reals) -> EndNodes:
    """The nodes next to the turning points; an even motion has only the first of them."""
    d = region.near_lower if table.complement < 1 else 0.0 * region.width
    low = table.low[0] / (1 + d * table.high[0])
    if table.symmetry == 2:
        return EndNodes(low, low, uncertainty[:, 0], uncertainty[:, 0])
    return EndNodes(low, (1 + d) * table.high[-1] / (1 + d * table.high[-1]), uncertainty[:, 0], uncertainty[:, -1])


def _largest(values: Reals, table: tables.Nodes, rows: slice) -> Reals:
    """Largest coefficient of the discrete series among some rows, shape (integrands, n)."""
    parts = [2 / len(table.χ) * np.abs(rowwise(values, table.cosines[rows].T)).max(axis=2)]
    if table.low[0] < 0:
        parts.append(2 / len(table.χ) * np.abs(rowwise(values, table.sines[rows].T)).max(axis=2))
    return np.maximum.reduce(parts)


def _librating(region: OrbitRegions, table: tables.Nodes) -> tuple[Reals, Reals, Reals]:
    """Offsets in the two views, and (dq/dχ)², at the nodes: arrays (n, nodes)."""
    half = len(table.χ) if table.symmetry == 2 else len(table.χ) // 2
    W = region.width[:, None]
    if table.complement == 1.0:
        low, high = W * table.low, W * table.high
        scale = low * high * table.derivative**2
    else:
        d, c = region.near_lower[:, None], region.near_upper[:, None]
        D = 1 + d * table.high
        x, y = table.low / D, (1 + d) * table.high / D
        low, high = W * x, W * y
        square = (2 * table.quarter / np.pi * table.derivative) ** 2 * table.complement
        scale = square * (1 + c * y) * (1 + d * x) * (low * high)
    below = region.lower[:, None] + region.below.sign * low[:, :half]
    above = region.upper[:, None] - region.above.sign * high[:, half:]
    return below, above, scale


def _rotating(region: OrbitRegions, table: tables.Nodes) -> tuple[Reals, Reals, Reals]:
    half = len(table.χ) // 2
    direction = np.sign(region.momentum)[:, None]
    angle, speed = table.low, 2 * table.quarter / np.pi * table.high
    if table.slow == 2:
        angle, factor = moved(angle, region.near_lower[:, None])
        speed = speed * factor
    q = region.lower[:, None] + direction * angle
    scale = speed**2 + 0.0 * q
    return q[:, :half], q[:, half:], scale


def _integrands(region: OrbitRegions, tasks: list[_Task], kernels: bool) -> Iterator[_Seen]:
    """F, r = |dq/dχ|/√F, the kernels, bounds on the errors of F and kernels, and the smooth part of the first."""
    with np.errstate(all="ignore"):
        if region.below is region.above:
            blocks = [_Block(t.orbits, np.concatenate(t.places[:2], axis=1), t.smooth) for t in tasks]
            found = _evaluated(region.below, blocks, kernels)
        else:
            halves = [
                _evaluated(view, [_Block(t.orbits, t.places[side], t.smooth) for t in tasks], kernels)
                for side, view in enumerate((region.below, region.above))
            ]
            found = [
                [np.concatenate(both, axis=1) for both in zip(*parts, strict=True)]
                for parts in zip(*halves, strict=True)
            ]
        for task, joined in zip(tasks, found, strict=True):
            m, F = len(joined) // 2, joined[0]
            yield F, np.sqrt(task.places[2] / F), joined[1:m], joined[m:-1], joined[-1]


class _Block(NamedTuple):
    """Places at which p² is wanted: of which orbits, offsets (n, nodes), and whether nodes are nowhere crowded."""

    orbits: Integers
    x: Reals
    smooth: bool

    @property
    def few(self) -> Integers:
        """The nodes at which errors are worked out: they vary slowly where nodes are nowhere crowded."""
        count = self.x.shape[1]
        few: Integers = np.unique(np.linspace(0, count - 1, _PLACES).astype(np.int64))
        return few if self.smooth and count >= 2 * len(few) else np.arange(count)


def _evaluated(view: View, blocks: list[_Block], kernels: bool) -> list[list[Reals]]:
    """For each block F, kernels, bounds on their errors, and the smooth part of the first, all of shape (n, nodes)."""
    if len(blocks) == 1:
        (block,) = blocks
        seen, x, few = view.take(block.orbits), block.x, block.few
        values = [np.broadcast_to(v, x.shape) for v in _values(seen, x, kernels)]
        return [values + _uncertainties(block, few, _bounds(seen, x[:, few], [v[:, few] for v in values]))]
    seen = view.take(np.concatenate([np.repeat(b.orbits, b.x.shape[1]) for b in blocks]))
    x = np.concatenate([b.x.ravel() for b in blocks])
    values = [np.broadcast_to(v, x.shape) for v in _values(seen, x, kernels)]
    starts = np.cumsum([0, *(b.x.size for b in blocks)])
    chosen = [
        (first + np.arange(len(b.x))[:, None] * b.x.shape[1] + b.few).ravel()
        for first, b in zip(starts, blocks, strict=False)
    ]
    some = np.concatenate(chosen)
    bounds = _bounds(seen.take(some), x[some], [v[some] for v in values])
    begins = np.cumsum([0, *(len(c) for c in chosen)])
    found = []
    for k, block in enumerate(blocks):
        own = [v[starts[k] : starts[k + 1]].reshape(block.x.shape) for v in values]
        few = block.few
        parts = [e[begins[k] : begins[k + 1]].reshape(len(block.x), len(few)) for e in bounds]
        found.append(own + _uncertainties(block, few, parts))
    return found


def _values(view: View, x: Reals, kernels: bool) -> Sequence[Reals]:
    return view.full(x) if kernels else [view.value(x)]


def _bounds(view: View, x: Reals, values: list[Reals]) -> list[Reals]:
    """Bounds on the errors of F and of the kernels, and the smooth part of the first, all of the shape of x."""
    x = np.ascontiguousarray(x)
    first, *others = view.errors(x, kernels=len(values) > 1, known=values[0])
    drift = view.drift(values[1:], x) if others else 0.0 * first
    return [np.broadcast_to(e, x.shape) for e in (first, *others, drift)]


def _uncertainties(block: _Block, few: Integers, bounds: list[Reals]) -> list[Reals]:
    """The same at all nodes: a few stand for those between them, the larger for both."""
    first, *others, drift = bounds
    count = block.x.shape[1]
    if len(few) == count:
        return bounds
    after = np.searchsorted(few, np.arange(count))
    before = np.maximum(after - 1, 0)
    noise, drift, *others = (np.maximum(e[:, after], e[:, before]) for e in (first - drift, drift, *others))
    return [noise + drift, *others, drift]


def _running(
    region: OrbitRegions, table: tables.Nodes, values: Reals, ratio: Reals, noise: Reals, ends: EndNodes
) -> dict[str, Reals]:
    """The phase of the start, integrals from χ = 0 to it less their mean growth, and bounds, by name in ``Sums``."""
    count = len(table.χ)
    terms = np.arange(1, len(table.cosines) + 1)
    phase, rounding = (
        phase_of_libration(region, table, ratio, ends) if region.turning else phase_of_rotation(region, table)
    )
    angle = table.symmetry * terms * phase[:, None]
    sine, cosine = np.sin(angle), np.cos(angle)
    delta = 1 + 2 * table.cosine_sums(cosine)
    if table.slow == 2:  # angles begin opposite to the slower place, where χ is not zero
        begin, uncertain = phase_of_rotation(replace(region, left=region.near_upper), table)
        phase, rounding = phase - begin, rounding + uncertain
        sine, cosine = sine - np.sin(terms * begin[:, None]), cosine - np.cos(terms * begin[:, None]) + 1
    weights = table.cosine_sums(sine / terms)
    if not region.turning:
        weights += rowwise((1 - cosine) / terms, table.sines)
        delta += 2 * rowwise(np.sin(angle), table.sines)
    return {
        "oscillations": 2 / (count * table.symmetry) * np.einsum("knj,nj->kn", values, weights),
        "speeds": np.einsum("knj,nj->kn", values, delta) / count,
        "oscillation_errors": 4 * noise,
        "phase": phase,
        "phase_error": rounding,
    }
