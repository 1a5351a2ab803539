"""Every torus that may have some actions, in doubles: samples of phase space sorted by family, then Newton's method.

A sample of phase space gives constants, and p² on samples of each coordinate gives the interval it moves in and a crude
action. Samples whose intervals overlap, with as many maxima of p² inside, belong to one family. Newton's method on
J(α) starts from the sample of each family whose crude actions are nearest; steps are halved until every coordinate
stays bounded and of its kind and the residual falls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.arithmetic.root_finding import bisected
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.tori.radicand_curve import Cycle, RadicandCurve, cycle_near
from hjsolve.solution.quadratures import Solution

_SAMPLES = 900
"""About how many samples of phase space are taken, and at most how many of them are sorted into families."""
_FAMILIES, _ATTEMPTS = 24, (0, 1, 3, 7, 15, 31)
"""How many families are looked at, and from which samples of each, the nearest first, Newton's method begins."""
_WELLS = 4
"""How many wells of one family are looked for."""
_AROUND, _FINE = 10.0, 4000
"""How far beyond the action asked ranges of actions are looked at, and nodes of the actions at their ends."""
_NEWTON_STEPS, _CLOSE = 60, 1e-11
"""Steps of Newton's method, and the relative residual at which it ends."""
_FRACTIONS_OF_A_STEP = (1.0, *(0.9 * 2.0**-k for k in range(8)))
"""Tried one after the other: next to a separatrix a whole step goes beyond it, nine tenths stay before it."""


Meant = Callable[[Sequence[tuple[float, float, bool]]], bool]
"""Of each coordinate: lower and upper end of where it moves on samples, and whether it goes round."""


@dataclass(frozen=True)
class Wanted:
    """The actions wanted.

    Attributes:
        actions: of the separated coordinates, in their order, signed; shape (n,).
        shifts: what a rotation adds to J for the action of its shell momentum P = p + A, shape (n,).
        constants: all constants κ; those of the unknowns are arbitrary, shape (k,).
        unknown: positions of the unknown constants, shape (n,).
    """

    actions: Reals
    shifts: Reals
    constants: Reals
    unknown: Integers

    @property
    def scale(self) -> float:
        """The size of all actions together."""
        known = np.delete(self.constants, self.unknown)
        return float(np.sum(np.abs(self.actions)) + np.sum(np.abs(known))) or 1.0

    def of(self, i: int, kind: str) -> float:
        """Return the action of the shell momentum of one coordinate, without a sign.

        Args:
            i: position of the coordinate.
            kind: what it does.
        """
        return abs(self.actions[i] + self.shifts[i]) if kind == "rotation" else self.actions[i]


@dataclass(frozen=True)
class Candidate:
    """A torus that has the actions wanted, in doubles.

    Attributes:
        constants: κ, shape (k,).
        cycles: one a separated coordinate.
    """

    constants: Reals
    cycles: tuple[Cycle, ...]


@dataclass(frozen=True)
class _Samples:
    """Samples of phase space: constants (k, s), positions of the coordinates among the samples of each (n, s)."""

    constants: Reals
    positions: Integers


def candidates(
    solution: Solution,
    values: Mapping[sp.Symbol, sp.Expr],
    curves: Sequence[RadicandCurve],
    wanted: Wanted,
    kinds: Mapping[str, object],
    meant: Meant | None = None,
) -> Iterator[Candidate]:
    """Yield the tori found that have the actions wanted, one of each family.

    Args:
        values: symbol → exact number, for parameters and the momenta of ignorable coordinates.
        curves: p² of the separated coordinates.
        wanted: the actions.
        kinds: separated coordinate → the kind that is meant; other families are left out.
        meant: tells of the intervals in which the coordinates move whether they are meant; None for all.
    """
    samples = _sampled(solution, values, curves, wanted)
    tables = [_runs(curve, samples.constants, at) for curve, at in zip(curves, samples.positions, strict=True)]
    scores = _scores(tables, wanted)
    for curve, table in zip(curves, tables, strict=True):
        if curve.name in kinds:
            scores = np.where(table.round == (kinds[curve.name] == "rotation"), scores, np.inf)
    allowed = np.flatnonzero(np.isfinite(scores))
    if meant is not None:
        rows = ([(float(t.low[s]), float(t.high[s]), bool(t.round[s])) for t in tables] for s in allowed)
        allowed = allowed[np.fromiter((meant(row) for row in rows), dtype=bool, count=len(allowed))]
    allowed = np.sort(allowed[np.argsort(scores[allowed], kind="stable")][:_SAMPLES])
    families = _families(curves, tables, allowed)
    found: list[Candidate] = []
    first = {int(f): float(np.min(scores[allowed[families == f]])) for f in np.unique(families)}
    for family in sorted(first, key=lambda f: first[f])[:_FAMILIES]:
        own = allowed[families == family]
        left = own[np.argsort(scores[own], kind="stable")]
        for _ in range(_WELLS):
            candidate = _begun_nearest(curves, wanted, samples.constants, tables, left)
            if candidate is None:
                break
            if not any(_same(curves, candidate, other) for other in found):
                found.append(candidate)
                yield candidate
            # wells that are joined above a barrier are one family: the others are looked at as well
            left = left[~_overlapping(curves, tables, left, candidate)]
            if not len(left):
                break


def _begun_nearest(
    curves: Sequence[RadicandCurve], wanted: Wanted, constants: Reals, tables: Sequence[_Runs], samples: Integers
) -> Candidate | None:
    """Return the torus to which Newton's method leads from some samples, the nearest first."""
    for s in samples[[k for k in _ATTEMPTS if k < len(samples)]]:
        intervals = [(float(t.low[s]), float(t.high[s])) for t in tables]
        kinds = ["rotation" if t.round[s] else "libration" for t in tables]
        candidate = _newton(curves, wanted, constants[:, s], intervals, kinds)
        if candidate is not None:
            return candidate
    return None


def _overlapping(
    curves: Sequence[RadicandCurve], tables: Sequence[_Runs], samples: Integers, candidate: Candidate
) -> Mask:
    """Return which samples move, along every coordinate, in an interval that overlaps that of a candidate."""
    result = np.ones(len(samples), dtype=bool)
    for curve, t, cycle in zip(curves, tables, candidate.cycles, strict=True):
        overlap = t.round[samples] | np.full(len(samples), cycle.kind == "rotation")
        for shift in (-curve.turn, 0.0, curve.turn):
            overlap |= (t.low[samples] + shift <= cycle.high) & (cycle.low <= t.high[samples] + shift)
        result &= overlap
    return result


def _families(curves: Sequence[RadicandCurve], tables: Sequence[_Runs], allowed: Integers) -> Integers:
    """Return number the families of some samples: those connected through samples whose intervals overlap alike."""
    joined = np.ones((len(allowed), len(allowed)), dtype=bool)
    for curve, t in zip(curves, tables, strict=True):
        low, high = t.low[allowed], t.high[allowed]
        round_, maxima = t.round[allowed], t.maxima[allowed]
        shifts = (-curve.turn, 0.0, curve.turn) if curve.turn else (0.0,)
        overlap = np.zeros_like(joined)
        for shift in shifts:
            overlap |= (low[:, None] < high[None, :] + shift) & (low[None, :] + shift < high[:, None])
        both = round_[:, None] & round_[None, :]
        # as many maxima of p², and intervals in common: nothing was joined or cut between the two
        same = (round_[:, None] == round_[None, :]) & (maxima[:, None] == maxima[None, :])
        joined &= both | (same & overlap)
    np.fill_diagonal(joined, val=True)
    numbers = np.arange(len(allowed))
    while True:
        # every sample takes the smallest number among those joined to it, until none changes (connected components)
        least = np.min(np.where(joined, numbers[None, :], len(allowed)), axis=1, initial=len(allowed))
        least = least[least] if len(least) else least
        if np.array_equal(least, numbers):
            return numbers
        numbers = least


@dataclass(frozen=True)
class _Runs:
    """For every sample the interval in which one coordinate moves, on its samples; arrays of shape (s,)."""

    low: Reals
    high: Reals
    action: Reals
    bounded: Mask
    round: Mask
    maxima: Integers


def _sampled(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], curves: Sequence[RadicandCurve], wanted: Wanted
) -> _Samples:
    """Return samples at rest, and with the momenta of rotations that have the actions wanted."""
    system, n = solution.system, len(curves)
    most = max(2, round(_SAMPLES ** (1 / n)))
    choices = []
    for i, curve in enumerate(curves):
        grid = curve.samples()
        inner = np.arange(len(grid) // 4, 3 * len(grid) // 4) if curve.turn else np.arange(len(grid))
        places = np.unique(inner[np.linspace(0, len(inner) - 1, min(most, len(inner))).astype(int)])
        # p of a free rotation with this J; what the potential makes of it Newton's method finds
        momentum = wanted.of(i, "rotation") if curve.turn else 0.0
        if all(curve.walls):  # between walls there need not be a place of rest
            momentum = np.pi * wanted.of(i, "libration") / (curve.upper - curve.lower)
        choices.append([(k, p) for p in ((0.0, momentum) if momentum > 0 else (0.0,)) for k in places])
    table = np.array(np.meshgrid(*(np.arange(len(c)) for c in choices), indexing="ij")).reshape(n, -1)
    positions = np.stack([np.array([k for k, _ in c])[row] for c, row in zip(choices, table, strict=True)])
    momenta = np.stack([np.array([p for _, p in c])[row] for c, row in zip(choices, table, strict=True)])
    names = [system.coordinate(curve.name) for curve in curves]
    known = {s: v for s, v in values.items() if s not in {c.symbol for c in names} | {c.momentum for c in names}}
    symbols = [*(c.symbol for c in names), *(c.momentum for c in names), *known]
    # constants of the motion through each sample: κ needs no search of its own
    tape = lower([c.expression for c in solution.constants.values()], symbols)
    starts = [curve.samples()[at] for curve, at in zip(curves, positions, strict=True)]
    with np.errstate(all="ignore"):
        rows = tape.run(Float64(), [*starts, *momenta, *(float(to_bits(v)(64)) for v in known.values())])
    return _Samples(np.stack([np.broadcast_to(row, positions.shape[1:]) for row in rows]), positions)


def _runs(curve: RadicandCurve, constants: Reals, at: Integers) -> _Runs:
    """Return the interval of p² > 0 next to each sample, and what is crudely its action."""
    grid = curve.samples()
    squared = curve.value(grid[None, :], constants[:, :, None])
    positive, size = squared > 0, len(grid)
    rows, index = np.arange(len(at)), np.arange(size)
    # a sample at rest has p² = 0: the interval begins on one of its sides
    start = np.where(positive[rows, at], at, np.where(positive[rows, np.minimum(at + 1, size - 1)], at + 1, at - 1))
    start = np.clip(start, 0, size - 1)
    before = np.maximum.accumulate(np.where(positive, -1, index), axis=1)[rows, start]
    after = np.minimum.accumulate(np.where(positive, size, index)[:, ::-1], axis=1)[:, ::-1][rows, start]
    inside = (index > before[:, None]) & (index < after[:, None])
    p = np.sqrt(np.where(inside, squared, 0))
    steps = np.gradient(grid)
    action = np.sum(p * steps, axis=1) / np.pi
    at_wall = (before < 0) & curve.walls[0], (after >= size) & curve.walls[1]
    bounded = ((before >= 0) | at_wall[0]) & ((after < size) | at_wall[1]) & positive[rows, start]
    around = np.zeros(len(at), dtype=bool)
    if curve.turn:
        around = np.all(positive, axis=1)
        action = np.where(around, action / 4, action)  # of two turns, by 2π instead of π
        bounded = bounded | around
    peaks = (squared[:, 1:-1] > squared[:, :-2]) & (squared[:, 1:-1] >= squared[:, 2:]) & inside[:, 1:-1]
    maxima = np.where(around, 1, np.maximum(np.sum(peaks, axis=1), 1))
    low, high = grid[np.maximum(before, 0)], grid[np.minimum(after, size - 1)]
    return _Runs(low, high, action, bounded & np.isfinite(action), around, maxima)


def _scores(tables: Sequence[_Runs], wanted: Wanted) -> Reals:
    """Return how far crude actions are from those wanted; infinite where the kind does not allow them."""
    total = np.zeros(len(tables[0].low))
    least = 1e-3 * wanted.scale
    for i, table in enumerate(tables):
        goal = np.where(table.round, wanted.of(i, "rotation"), wanted.of(i, "libration"))
        total = total + np.abs(np.log((table.action + least) / (np.abs(goal) + least)))
        allowed = table.bounded & np.where(table.round, goal > 0, goal >= 0)
        total = np.where(allowed, total, np.inf)
    return total


def _newton(
    curves: Sequence[RadicandCurve], wanted: Wanted, begin: Reals, intervals: Sequence[tuple[float, float]],
    kinds: Sequence[str],
) -> Candidate | None:  # fmt: skip
    """Solve J(α) = J from a sample; None where the steps lead nowhere."""
    κ = begin.copy()
    goals = np.array([wanted.of(i, kind) for i, kind in enumerate(kinds)])
    # relative to each J, but not below a millionth of all: of a J of 0 nothing relative is known
    size = np.abs(goals) + 1e-6 * wanted.scale
    cycles = _cycles(curves, κ, intervals, kinds, goals)
    if cycles is None:
        return None
    for _ in range(_NEWTON_STEPS):
        residual = goals - np.array([c.action for c in cycles])
        now = float(np.max(np.abs(residual) / size))
        if now < _CLOSE:
            break
        try:
            step = np.linalg.solve(np.stack([c.slopes[wanted.unknown] for c in cycles]), residual)
        except np.linalg.LinAlgError:
            return None
        wells = [(c.low, c.high) for c in cycles]
        for fraction in _FRACTIONS_OF_A_STEP:
            trial = κ.copy()
            trial[wanted.unknown] += step * fraction
            new = _cycles(curves, trial, wells, kinds, goals, [c.top for c in cycles])
            if new is None:
                continue
            left = float(np.max(np.abs(goals - np.array([c.action for c in new])) / size))
            # a whole step of Newton's method must gain an eighth, a part of it as much in proportion (Armijo's rule)
            if left < now * (1 - fraction / 8):
                κ, cycles = trial, new
                break
        else:
            break
    residual = goals - np.array([c.action for c in cycles])
    # of a very small libration doubles see only the rounding of p²: whether it has this J is for many digits to tell
    if any(abs(r) > 1e-2 * a and c.kind != "equilibrium" for r, a, c in zip(residual, size, cycles, strict=True)):
        return None
    return Candidate(κ, tuple(cycles))


def _cycles(
    curves: Sequence[RadicandCurve], κ: Reals, intervals: Sequence[tuple[float, float]], kinds: Sequence[str],
    goals: Reals, starts: Sequence[float] | None = None,
) -> list[Cycle] | None:  # fmt: skip
    """Return the cycles of all coordinates; None where one does not come back, or is of another kind."""
    result = []
    for i, (curve, (low, high), kind, goal) in enumerate(zip(curves, intervals, kinds, goals, strict=True)):
        start = None if starts is None else starts[i]
        cycle = cycle_near(curve, κ, low, high, harmonic=goal == 0, start=start)
        if cycle is None or not np.isfinite(cycle.action) or (cycle.kind == "rotation") != (kind == "rotation"):
            return None
        result.append(cycle)
    return result


def _same(curves: Sequence[RadicandCurve], one: Candidate, other: Candidate) -> bool:
    """Return whether two candidates are one torus: the same constants and wells."""
    if not np.allclose(one.constants, other.constants, rtol=1e-6, atol=1e-12 * min(np.max(np.abs(one.constants)), 1)):
        return False
    for curve, a, b in zip(curves, one.cycles, other.cycles, strict=True):
        apart = abs(a.top - b.top)
        apart = min(apart, abs(apart - curve.turn)) if curve.turn else apart
        width = max(a.high - a.low, b.high - b.low) + 1e-6 * (abs(a.top) + curve.turn)
        if (a.kind == "rotation") != (b.kind == "rotation") or (a.kind != "rotation" and 2 * apart > width):
            return False
    return True


@dataclass(frozen=True)
class SampledActions:
    """What samples of phase space show: bounded motions below some energy; crude.

    Attributes:
        energies: of the samples, shape (s,).
        low, high: the intervals in which each coordinate moves, shape (n, s).
        actions: shape (n, s).
        rotations: which of them go round, shape (n, s).
        at_ends: whether p² > 0 next to an end of the domain that is not a wall, of each coordinate; shape (n,).
    """

    energies: Reals
    low: Reals
    high: Reals
    actions: Reals
    rotations: Mask
    at_ends: Mask


def sampled_actions(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], curves: Sequence[RadicandCurve], wanted: Wanted,
    energy: float,
) -> SampledActions:  # fmt: skip
    """Look at samples of phase space for the actions that there are below an energy.

    Args:
        values: symbol → exact number, for parameters and the momenta of ignorable coordinates.
        curves: p² of the separated coordinates.
        wanted: actions that samples of rotations get.
        energy: the greatest one, of the first constant.
    """
    samples = _sampled(solution, values, curves, wanted)
    E = samples.constants[0]
    tables = [_runs(curve, samples.constants, at) for curve, at in zip(curves, samples.positions, strict=True)]
    with np.errstate(invalid="ignore"):
        low = np.isfinite(E) & (energy >= E)
    met = np.array([_meets_an_end(curve, samples.constants[:, low]) for curve in curves])
    some = np.flatnonzero(low & np.logical_and.reduce([table.bounded for table in tables]))
    low_, high, action = (np.stack([getattr(t, part)[some] for t in tables]) for part in ("low", "high", "action"))
    return SampledActions(E[some], low_, high, action, np.stack([t.round[some] for t in tables]), met)


def _meets_an_end(curve: RadicandCurve, constants: Reals) -> bool:
    """Whether p² > 0 next to a finite end of the domain that is not a wall, for some of the constants."""
    if curve.turn or not constants.shape[1]:
        return False
    grid = curve.samples()
    ends = [(grid[0], curve.lower, curve.walls[0]), (grid[-1], curve.upper, curve.walls[1])]
    places = np.array([q for q, end, wall in ends if np.isfinite(end) and not wall])
    return bool(len(places)) and bool(np.any(curve.value(places[None, :], constants[:, :, None]) > 0))


@dataclass(frozen=True)
class ActionRange:
    """Between which values J of one coordinate lies, over the tori of one family.

    Attributes:
        kind: libration or rotation.
        low, high: where the coordinate moves on the outermost of them seen; a turn of a rotation.
        least, most: of abs(J); infinite where no end of the family was seen.
    """

    kind: str
    low: float
    high: float
    least: float
    most: float


def action_ranges(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], curves: Sequence[RadicandCurve], wanted: Wanted
) -> tuple[ActionRange, ...]:
    """Return between which values the action of the only separated coordinate lies, family by family.

    The ends of a family lie between a sample of it and the next one that is none of it; there they are bisected.
    None where several coordinates are separated: the range of one action depends on the others.

    Args:
        values: symbol → exact number, for parameters and the momenta of ignorable coordinates.
        curves: p² of the separated coordinates.
        wanted: actions that were asked.
    """
    if len(curves) != 1:
        return ()
    samples = _sampled(solution, values, curves, wanted)
    table, unknown = _runs(curves[0], samples.constants, samples.positions[0]), int(wanted.unknown[0])
    E = samples.constants[unknown]
    allowed = np.flatnonzero(table.bounded & np.isfinite(E) & np.isfinite(table.action))
    if not len(allowed):
        return ()
    # far out the samples of the coordinate lie too wide apart to tell wells from one another
    near = _AROUND * max(wanted.scale, float(np.quantile(table.action[allowed], 0.25)))
    allowed = allowed[table.action[allowed] <= near]
    allowed = allowed[np.linspace(0, len(allowed) - 1, min(len(allowed), _SAMPLES)).astype(int)]
    families = _families(curves, [table], allowed)
    found = []
    for family in np.unique(families):
        own = allowed[families == family]
        ends = []
        for side in (-1, 1):
            last = own[np.argmax(side * E[own])]
            beyond = E[np.isfinite(E) & (side * E > side * E[last])]
            ends.append(_action_at_the_end(curves[0], samples, int(last), unknown, beyond, side))
        s = own[np.argmax(E[own])]
        kind = "rotation" if table.round[s] else "libration"
        least = 0.0 if kind == "libration" and table.maxima[s] == 1 else min(ends)  # it ends at the bottom of its well
        most = max(ends) if max(ends) <= near else np.inf
        found.append(ActionRange(kind, float(table.low[s]), float(table.high[s]), least, most))
    return tuple(found)


def _action_at_the_end(
    curve: RadicandCurve, samples: _Samples, last: int, unknown: int, beyond: Reals, side: int
) -> float:
    """Return J where a family ends beyond one of its samples; infinite where no end was seen.

    Args:
        curve: p².
        samples: of phase space.
        last: sample of the family with the extreme unknown.
        unknown: position of the unknown constant.
        beyond: values of it past that sample, of others.
        side: in which direction, ±1.
    """
    κ = samples.constants[:, last].copy()
    own = _runs(curve, κ[:, None], samples.positions[0][last : last + 1])
    grid = curve.samples()
    inside = float(κ[unknown])
    low, high = float(own.low[0]), float(own.high[0])
    if not len(beyond):
        return np.inf if side > 0 else 0.0
    outside = float(side * np.min(side * beyond))

    def belongs(middle: float) -> bool:
        nonlocal low, high
        trial = κ.copy()
        trial[unknown] = middle
        within = np.where((grid >= low) & (grid <= high), np.nan_to_num(curve.value(grid, trial), nan=-np.inf), -np.inf)
        at = np.array([int(np.clip(np.argmax(within), 1, len(grid) - 2))])
        run = _runs(curve, trial[:, None], at)
        if not (run.bounded[0] and run.round[0] == own.round[0] and run.maxima[0] == own.maxima[0]):
            return False
        low, high = float(run.low[0]), float(run.high[0])
        return True

    κ[unknown] = bisected(belongs, inside, outside, _NEWTON_STEPS)[0]
    if own.round[0]:
        low, high = float(grid[0]), float(grid[0]) + curve.turn
    # next to a barrier: between samples that are outside, whatever lies beyond the barrier
    χ = (np.arange(_FINE) + 0.5) * np.pi / _FINE
    q = (low + high) / 2 - (high - low) / 2 * np.cos(χ)
    p = np.sqrt(np.maximum(np.nan_to_num(curve.value(q, κ)), 0))
    J = float(np.mean(p * np.sin(χ))) * (high - low) / 2
    return J / 2 if own.round[0] else J
