"""All pairs (E, L) with which a mass goes from one distance to another in a time and about an angle, isolated in boxes.

A path passes the arc between the two distances, the one beyond the outer and the one within the inner a known number of
times (its radial branch), and sweeps a known angle (its image of q1): two equations for two parameters. A box is
discarded for a path where time or angle cannot be those asked, also after a linear change of both (Krawczyk 1969).
Where the matrix of slopes is regular over a box, the box holds one solution at most.

Motions with two apsides have the parameters of ``apsidal_arcs.py``; those that go out farther than the time allows to
return from, and those with very little angular momentum, the parameters of ``radial_arcs.py``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hjsolve.algebra.time_limit import out_of_time
from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.two_point.central.apsidal_arcs import (
    ApsidalBoxes,
    SquarePotential,
    arcs_between_apsides,
    energies_of,
)
from hjsolve.two_point.central.radial_arcs import Boxes, RadialArcs, arcs_of
from hjsolve.two_point.central.radial_grid import RadialGrid, RadialPotential
from hjsolve.two_point.one_freedom.line_branches import LineBranch

_BATCH = 48
_MOST_BOXES = 12_000
_SMALLEST = 2.0**-16
"""Parts of its own size at which a box is left undecided."""
_LEVELS = (0.12, 0.02, 0.004)
"""Relative sizes of boxes below which finer cells are taken."""
_UNTESTED = 0.3
"""Relative size of boxes of (x, y) above which enclosures say too little to pay."""
AT_OUTER, AT_INNER, APSIDAL = range(3)
"""Charts: (s, λ) with r_j the outer or the inner distance, and (x, y)."""
_APSIDAL_CELLS = (36, 48, 96, 256)
_NEWTON = 4
_INCLUDED = (0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.003, 0.001, 0.0003, 0.0001)
"""Relative sizes of the box that a solution has to itself: the largest that serves is taken."""
_FAR = 0.15
"""How far from a box its solution is looked for, as a relative size."""


class RadialProblem(NamedTuple):
    """What is to be joined.

    Attributes:
        potential: V.
        grids: coarse, medium and fine cells of r, as far out as a mass can go and return in time.
        square: u V.
        nearest: u below which there is no pericentre with more angular momentum than the least.
        least: λ below which the parameters of ``radial_arcs`` serve alone.
        time: T/√(m/2).
        angles: that may be swept, > 0, in increasing order; shape (k,).
        branches: radial paths.
        beyond: more periods than this one no branch has.
        top: an energy from which on no path without the outer arc is so slow.
        highest: an energy that no path with the outer arc exceeds.
        settled: whether that is proved; else energies above the top are not decided.
    """

    potential: RadialPotential
    grids: tuple[RadialGrid, ...]
    square: SquarePotential
    nearest: float
    least: float
    time: float
    angles: Reals
    branches: tuple[LineBranch, ...]
    beyond: int
    top: float
    highest: float
    settled: bool


@dataclass(frozen=True)
class IsolatedMotion:
    """A solution and the box that it has to itself.

    Attributes:
        branch, angle: indices of the path and of the angle swept.
        at: near the solution.
        low, high: the corners of its box.
        chart: which parameters.
    """

    branch: int
    angle: int
    at: tuple[float, float]
    low: tuple[float, float]
    high: tuple[float, float]
    chart: int


@dataclass
class RadialProof:
    """What was isolated and what was not decided.

    Attributes:
        motions: the solutions.
        undecided: energies of the boxes that were not decided.
        boxes: how many were looked at.
        high: whether energies above the top are not decided.
        ended: whether the time ended it.
    """

    motions: list[IsolatedMotion] = field(default_factory=list)
    undecided: list[tuple[float, float]] = field(default_factory=list)
    boxes: int = 0
    high: bool = False
    ended: bool = False


class _Queue(NamedTuple):
    """Boxes (b, 2 parameters, 2 ends); their charts; and which paths (b, branches + 1, angles) may be there."""

    corners: Reals
    chart: Integers
    alive: Mask

    def part(self, index: slice | Mask | Integers) -> _Queue:
        return _Queue(self.corners[index], self.chart[index], self.alive[index])


def _joined(parts: list[_Queue]) -> _Queue:
    return _Queue(*(np.concatenate([part[k] for part in parts]) for k in range(3)))


def all_motions(problem: RadialProblem) -> RadialProof:
    """Find every solution.

    Args:
        problem: what is joined.
    """
    proof = RadialProof(high=not problem.settled)
    queue = _first_boxes(problem)
    with np.errstate(all="ignore"):  # what is not known is infinite
        while len(queue.chart):
            proof.ended = out_of_time()
            if proof.ended or proof.boxes > _MOST_BOXES:
                _leave(problem, queue, proof)
                break
            batch, queue = queue.part(slice(0, _BATCH)), queue.part(slice(_BATCH, None))
            proof.boxes += len(batch.chart)
            queue = _joined([_judged(problem, batch, proof), queue])
    return proof


def _first_boxes(problem: RadialProblem) -> _Queue:
    """Return the boxes that hold every motion; λ is cut where the bound end changes."""
    grid = problem.grids[0]
    radii = grid.r[[grid.inner, grid.outer]]
    V_low, V_high = (np.array([end[grid.inner], end[grid.outer]]) for end in grid.at_nodes.V)
    cut = _cut(radii, (V_low + V_high) / 2)
    every = np.ones((len(problem.branches) + 1, len(problem.angles)), dtype=bool)
    inward = every & np.array([b.upper == 0 for b in problem.branches] + [False])[:, None]
    boxes, charts, alive = [], [], []
    for at_inner in (False, True):
        for near in (True, False):
            top = problem.highest if near else problem.top
            most_s = np.sqrt(max(top - float(np.max(V_low)), 0.0)) * (1 + 1e-12)
            most_λ = float(np.max(radii * np.sqrt(np.maximum(top - V_low, 0.0)))) * (1 + 1e-12)
            low, high = (cut, most_λ) if at_inner else (0.0, min(cut, most_λ))
            low, high = (low, min(high, problem.least)) if near else (max(low, problem.least), high)
            for λ in _edges(low, high) if high > low else ():
                for s in _edges(0.0, most_s):
                    boxes.append([s, λ])
                    charts.append(AT_INNER if at_inner else AT_OUTER)
                    alive.append(every if near else inward)
    low_u, high_u = radii**2
    most_x, most_y = np.sqrt(low_u - problem.nearest), np.sqrt(grid.r[-1] ** 2 - high_u)
    for x in _edges(0.0, most_x * (1 + 1e-15)):
        for y in _edges(0.0, most_y * (1 + 1e-15)):
            boxes.append([x, y])
            charts.append(APSIDAL)
            alive.append(every)
    return _Queue(np.array(boxes), np.array(charts), np.array(alive))


def _cut(radii: Reals, V: Reals) -> float:
    """λ at which both places are turning points at once; below it the outer one is reached last."""
    if radii[0] == radii[1] or V[1] <= V[0]:
        return 0.0
    return float(np.sqrt((V[1] - V[0]) / (1 / radii[0] ** 2 - 1 / radii[1] ** 2)))


def _edges(low: float, high: float) -> list[tuple[float, float]]:
    ends = [low, *(low + (high - low) * 2.0**-k for k in range(3, -1, -1))]
    return list(pairwise(ends))


def _arcs(problem: RadialProblem, queue: _Queue, level: int, *, slopes: bool, centres: bool = False) -> RadialArcs:
    """Enclose the arcs of boxes of one chart, or of their centres."""
    grid = problem.grids[min(level, len(problem.grids) - 1)]
    ends = np.repeat(np.mean(queue.corners, axis=2, keepdims=True), 2, axis=2) if centres else queue.corners
    first, second = (Interval(ends[:, k, :1].copy(), ends[:, k, 1:].copy()) for k in (0, 1))
    if queue.chart[0] == APSIDAL:
        low, high = grid.r[[grid.inner, grid.outer]] ** 2
        boxes = ApsidalBoxes(first, second, float(low), float(high))
        return arcs_between_apsides(problem.square, boxes, _APSIDAL_CELLS[level], slopes=slopes)
    bound = np.where(queue.chart == AT_INNER, grid.inner, grid.outer)
    return arcs_of(grid, Boxes(first, second, bound), slopes=slopes)


def _judged(problem: RadialProblem, queue: _Queue, proof: RadialProof) -> _Queue:
    """Discard paths from boxes, isolate solutions, and halve what is left."""
    queue = _in_domain(problem, queue)
    if not len(queue.chart):
        return queue
    largest = np.max(_sizes(problem, queue), axis=1)
    levels = np.sum(largest[:, None] <= np.array(_LEVELS), axis=1)
    left = []
    untested = (queue.chart == APSIDAL) & (largest > _UNTESTED)
    if np.any(untested):
        left.append(_halved(problem, queue.part(untested), proof))
        queue, levels = queue.part(~untested), levels[~untested]
    for apsidal in (False, True):
        for level in range(len(_LEVELS) + 1):
            part = queue.part(((queue.chart == APSIDAL) == apsidal) & (levels == level))
            if not len(part.chart):
                continue
            part = _tested(problem, level, part, proof)
            if len(part.chart):
                left.append(_halved(problem, part, proof))
    return _joined(left) if left else queue.part(slice(0, 0))


def _in_domain(problem: RadialProblem, queue: _Queue) -> _Queue:
    """Drop paths from boxes whose energies are too high for them."""
    least = _energies(problem, queue)[0]
    inward = np.array([b.upper == 0 for b in problem.branches] + [False])
    alive = queue.alive & ~((least >= problem.top)[:, None] & inward)[:, :, None]
    alive &= (least < problem.highest)[:, None, None]
    return _Queue(queue.corners, queue.chart, alive).part(np.any(alive, axis=(1, 2)))


def _energies(problem: RadialProblem, queue: _Queue) -> tuple[Reals, Reals]:
    """Bounds of E."""
    grid = problem.grids[0]
    apsidal = queue.chart == APSIDAL
    node = np.where(queue.chart == AT_INNER, grid.inner, grid.outer)
    r, V = grid.r[node], grid.at_nodes.V
    low, high = (
        np.asarray(end)[node] + queue.corners[:, 0, k] ** 2 + (queue.corners[:, 1, k] / r) ** 2
        for k, end in enumerate((V.low, V.high))
    )
    if np.any(apsidal):
        corners = queue.corners[apsidal]
        x, y = (Interval(corners[:, k, :1].copy(), corners[:, k, 1:].copy()) for k in (0, 1))
        low_u, high_u = grid.r[[grid.inner, grid.outer]] ** 2
        E = energies_of(problem.square, ApsidalBoxes(x, y, float(low_u), float(high_u)))
        low[apsidal], high[apsidal] = np.asarray(E.low)[:, 0], np.asarray(E.high)[:, 0]
    return low, high


def _sizes(problem: RadialProblem, queue: _Queue) -> Reals:
    """How large boxes are in each parameter, in units of what these are to a motion there."""
    grid = problem.grids[0]
    r = grid.r[np.where(queue.chart == AT_INNER, grid.inner, grid.outer)]
    width = queue.corners[:, :, 1] - queue.corners[:, :, 0]
    s, λ = queue.corners[:, 0, 1], queue.corners[:, 1, 1]
    plain = np.stack([width[:, 0] / (s + 0.5 * λ / r), width[:, 1] / (λ + 0.1 * s * r)], axis=1)
    low_u, high_u = grid.r[[grid.inner, grid.outer]] ** 2
    x, y = queue.corners[:, 0], queue.corners[:, 1]
    p, a = low_u - x**2, high_u + y**2
    whole = np.sqrt(a[:, 1] - p[:, 1] + 1e-3 * high_u)
    with np.errstate(all="ignore"):
        inner = np.maximum((p[:, 0] - p[:, 1]) / (2 * np.maximum(p[:, 1], 1e-12 * low_u)), width[:, 0] / whole)
        outer = np.maximum((a[:, 1] - a[:, 0]) / (2 * a[:, 0]), width[:, 1] / whole)
    return np.where((queue.chart == APSIDAL)[:, None], np.stack([inner, outer], axis=1), plain)


class _Paths(NamedTuple):
    """Time and angle of every branch, shape (2, b, branches), and their slopes, (2, 2, b, branches)."""

    low: Reals
    high: Reals
    slope_low: Reals
    slope_high: Reals
    there: Mask
    """whether its arcs exist all over the box"""
    never: Mask


def _counts(problem: RadialProblem) -> Reals:
    """How often each branch passes each arc; the last row is the least of what has more periods than any branch."""
    more = 2.0 * (problem.beyond + 1)
    rows = [(float(b.direct), 2.0 * b.upper, 2.0 * b.lower) for b in problem.branches]
    grid = problem.grids[0]
    return np.array([*rows, (more if grid.inner != grid.outer else 0.0, more, more)])


def _paths(problem: RadialProblem, arcs: RadialArcs) -> _Paths:
    counts = _counts(problem)
    used = counts > 0

    def total(x: Reals) -> Reals:
        with np.errstate(all="ignore"):
            terms = np.where(used[:, :, None], counts[:, :, None] * x[..., None, :, :], 0.0)
        return np.swapaxes(np.sum(terms, axis=-2), -1, -2)

    low, high = total(np.asarray(arcs.values.low)), total(np.asarray(arcs.values.high))
    never = np.any(used[:, :, None] & (arcs.there == -1)[None], axis=1).T
    there = np.all(~used[:, :, None] | (arcs.there == 1)[None], axis=1).T
    if arcs.slopes is None:
        empty = np.zeros((2, *low.shape))
        return _Paths(low, high, empty, empty, there, never)
    return _Paths(low, high, total(np.asarray(arcs.slopes.low)), total(np.asarray(arcs.slopes.high)), there, never)


def _tested(problem: RadialProblem, level: int, queue: _Queue, proof: RadialProof) -> _Queue:
    """Discard paths, isolate solutions, and return what is left."""
    natural = _arcs(problem, queue, level, slopes=bool(queue.chart[0] == APSIDAL))
    alive = queue.alive & _possible(problem, _paths(problem, natural))
    alive &= ~_isolated(queue, proof)
    alive &= ~_elsewhere(problem, queue, natural)[:, None, None]
    swept = [np.asarray(end)[:, None] * problem.time for end in natural.rate]
    alive &= ((swept[0] * (1 - 1e-14) <= problem.angles) & (swept[1] * (1 + 1e-14) >= problem.angles))[:, None, :]
    keep = np.any(alive, axis=(1, 2))
    queue = _Queue(queue.corners, queue.chart, alive).part(keep)
    if not len(queue.chart):
        return queue
    known = natural.slopes is not None
    over = _paths(problem, natural.part(keep) if known else _arcs(problem, queue, level, slopes=True))
    middle = _paths(problem, _arcs(problem, queue, level, slopes=False, centres=True))
    test = _linear_test(problem, queue, over, middle)
    alive = queue.alive & test.possible
    wanted = alive & test.regular & test.near
    for box, branch, angle in np.argwhere(wanted[:, :-1]):
        guess = test.guess[box, branch, angle]
        _isolate(problem, queue.part(slice(box, box + 1)), int(branch), int(angle), guess, proof)
    alive &= ~_isolated(queue, proof)
    keep = np.any(alive, axis=(1, 2))
    return _Queue(queue.corners, queue.chart, alive).part(keep)


def _elsewhere(problem: RadialProblem, queue: _Queue, arcs: RadialArcs) -> Mask:
    """Boxes all of whose motions another chart has."""
    if queue.chart[0] == APSIDAL:
        return np.asarray(arcs.momentum_high < problem.least)
    return np.asarray(arcs.returns & (queue.corners[:, 1, 0] >= problem.least))


def _possible(problem: RadialProblem, paths: _Paths) -> Mask:
    """Whether enclosures allow a path the time and an angle; the last row is what has more periods."""
    T, angles = problem.time, problem.angles
    time = (paths.low[0] <= T) & (paths.high[0] >= T) & ~paths.never
    angle = (paths.low[1][:, :, None] <= angles) & (paths.high[1][:, :, None] >= angles)
    possible = time[:, :, None] & angle
    possible[:, -1] = ((paths.low[0][:, -1] <= T) & ~paths.never[:, -1])[:, None] & (
        paths.low[1][:, -1, None] <= angles
    )
    return possible


class _LinearTest(NamedTuple):
    possible: Mask
    regular: Mask
    near: Mask
    guess: Reals


def _linear_test(problem: RadialProblem, queue: _Queue, over: _Paths, middle: _Paths) -> _LinearTest:
    """Krawczyk's test: with M the inverse of the mean slopes, x = c − M (F(c) − F*) ± (|M| rad J w + |M| rad F)."""
    half = (queue.corners[:, :, 1] - queue.corners[:, :, 0]) / 2 * (1 + 1e-14)
    centre = np.mean(queue.corners, axis=2)
    with np.errstate(all="ignore"):
        known = over.there & np.all(np.isfinite(over.slope_high - over.slope_low), axis=(0, 1))
        known &= np.all(np.isfinite(middle.high), axis=0)
        J = np.where(known, (over.slope_low + over.slope_high) / 2, 0.0)
        spread_J = np.where(known, (over.slope_high - over.slope_low) / 2 * (1 + 1e-12), np.inf)
        F = np.where(known, (middle.low + middle.high) / 2, 0.0)
        spread_F = np.where(known, (middle.high - middle.low) / 2 * (1 + 1e-12), np.inf)
        goal = np.stack(np.broadcast_arrays(problem.time, problem.angles))
        miss = F[:, :, :, None] - goal[:, None, None, :]
        # each component as it is
        reach = np.einsum("kabn,ba->kbn", np.abs(J) + spread_J, half) + spread_F
        possible = np.all(np.abs(miss) <= reach[:, :, :, None], axis=0) | ~known[:, :, None]
        determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        M = np.array([[J[1, 1], -J[0, 1]], [-J[1, 0], J[0, 0]]]) / determinant
        solvable = known & np.isfinite(M).all(axis=(0, 1))
        size = np.abs(M)
        rounding_error = np.einsum("akbn,kcbn,bc->abn", size, spread_J, half)
        off = -np.einsum("akbn,kbnm->abnm", M, miss)
        room = (
            half.T[:, :, None]
            + rounding_error
            + np.einsum("akbn,kbn->abn", size, spread_F)
            + 1e-12 * half.T[:, :, None]
        )
        inside = np.all(np.abs(off) <= room[:, :, :, None], axis=0)
        possible &= inside | ~solvable[:, :, None]
        regular = solvable & np.all(rounding_error < 0.999 * half.T[:, :, None], axis=0)
        near = np.all(np.abs(off) <= 1.5 * half.T[:, :, None, None], axis=0)
        guess = np.moveaxis(centre.T[:, :, None, None] + off, 0, -1)
    possible[:, -1] = True
    return _LinearTest(possible, np.broadcast_to(regular[:, :, None], possible.shape), near, guess)


def _isolated(queue: _Queue, proof: RadialProof) -> Mask:
    """Which paths have their one solution in a box that holds this box."""
    done = np.zeros(queue.alive.shape, dtype=bool)
    for motion in proof.motions:
        low, high = np.array(motion.low), np.array(motion.high)
        within = np.all((queue.corners[:, :, 0] >= low) & (queue.corners[:, :, 1] <= high), axis=1)
        done[within & (queue.chart == motion.chart), motion.branch, motion.angle] = True
    return done


def _isolate(problem: RadialProblem, box: _Queue, branch: int, angle: int, guess: Reals, proof: RadialProof) -> None:
    """Solve for one path from a guess, and give the solution the largest box that it surely has to itself."""
    chart, size = int(box.chart[0]), _sizes(problem, box)[0]
    unit = (box.corners[0, :, 1] - box.corners[0, :, 0]) / size
    known = [m for m in proof.motions if (m.branch, m.angle, m.chart) == (branch, angle, chart)]
    x = np.maximum(guess, 0.0)
    goal = np.array([problem.time, problem.angles[angle]])
    for _ in range(_NEWTON):
        if any(np.all((x >= m.low) & (x <= m.high)) for m in known):
            return
        at = _Queue(np.repeat(x[None, :, None], 2, axis=2), box.chart, box.alive)
        here = _paths(problem, _arcs(problem, at, 3, slopes=True))
        F, J = (here.low + here.high)[:, 0, branch] / 2, (here.slope_low + here.slope_high)[:, :, 0, branch] / 2
        if not (np.all(np.isfinite(F)) and np.all(np.isfinite(J))):
            return
        x = np.maximum(x + np.linalg.lstsq(J, goal - F, rcond=None)[0], 0.0)
        if np.any(np.abs(x - guess) > _FAR * unit):
            return
    low, high = (np.array([np.maximum(x + sign * k / 2 * unit, 0.0) for k in _INCLUDED]) for sign in (-1, 1))
    if chart == APSIDAL:
        most = np.sqrt(problem.grids[0].r[problem.grids[0].inner] ** 2 - problem.nearest)
        high[:, 0] = np.minimum(high[:, 0], most)
    count = len(_INCLUDED)
    boxes = _Queue(np.stack([low, high], axis=2), np.full(count, chart), np.repeat(box.alive, count, axis=0))
    regular = _regular(_paths(problem, _arcs(problem, boxes, 3, slopes=True)), boxes)[:, branch]
    if np.any(regular):
        k = int(np.argmax(regular))
        ends = [(float(e[k, 0]), float(e[k, 1])) for e in (low, high)]
        proof.motions.append(IsolatedMotion(branch, angle, (float(x[0]), float(x[1])), ends[0], ends[1], chart))


def _regular(over: _Paths, queue: _Queue) -> Mask:
    """Whether the matrix of slopes is regular, whatever its entries are within their enclosures; (b, branches)."""
    half = (queue.corners[:, :, 1] - queue.corners[:, :, 0]) / 2
    with np.errstate(all="ignore"):
        J = (over.slope_low + over.slope_high) / 2
        spread = (over.slope_high - over.slope_low) / 2 * (1 + 1e-12)
        determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        M = np.abs(np.array([[J[1, 1], -J[0, 1]], [-J[1, 0], J[0, 0]]]) / determinant)
        rounding_error = np.einsum("akbn,kcbn,bc->abn", M, spread, half)
        return over.there & np.all(rounding_error < 0.999 * half.T[:, :, None], axis=0)


def _halved(problem: RadialProblem, queue: _Queue, proof: RadialProof) -> _Queue:
    """Halve boxes on their longer side; those that are too small are left undecided."""
    size = _sizes(problem, queue)
    small = np.max(size, axis=1) < _SMALLEST
    if np.any(small):
        _leave(problem, queue.part(small), proof)
        queue, size = queue.part(~small), size[~small]
    if not len(queue.chart):
        return queue
    side = np.argmax(size, axis=1)
    rows = np.arange(len(side))
    middle = np.mean(queue.corners, axis=2)[rows, side]
    first, second = queue.corners.copy(), queue.corners.copy()
    first[rows, side, 1] = middle
    second[rows, side, 0] = middle
    return _joined([_Queue(corners, queue.chart, queue.alive) for corners in (first, second)])


def _leave(problem: RadialProblem, queue: _Queue, proof: RadialProof) -> None:
    low, high = _energies(problem, queue)
    proof.undecided += [(float(a), float(b)) for a, b in zip(low, high, strict=True)]
