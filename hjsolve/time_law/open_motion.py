"""Jacobi's equations where some coordinate does not come back.

A coordinate whose motion in time is its own is found first: weights w with Σⱼ wⱼ kₗⱼ = 0 for every
other coordinate l make Σⱼ wⱼ Gᵢⱼ(χᵢ) = Σⱼ wⱼ Cⱼ + w₁ (t − t₀) an equation for χᵢ alone (a Liouville time
of its own). The rest is solved together, following the motion from its start in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Counts, Mask, Mpf, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Periodic, Unbounded
from hjsolve.one_coordinate.fourier_series import FourierSeries, combine
from hjsolve.time_law.coupled_pair import CoupledPair, choose_pair, solve_pair
from hjsolve.time_law.one_phase import solve_alone

_REACHES = 12
"""How often panels are made longer that were too short: for 8 times the time, or to the square of the distance."""


@dataclass(frozen=True)
class DecoupledStep:
    """One coordinate solved alone: its index and the weights of the equations."""

    index: int
    weights: tuple[float, ...]


@dataclass(frozen=True)
class TriangularScheme:
    """How the equations are solved.

    Attributes:
        coordinate_motions: one a coordinate.
        equations: number of constants the quadratures are taken for, the energy first.
        steps: coordinates solved alone, in order.
        coupled: the others.
    """

    coordinate_motions: tuple[CoordinateMotion, ...]
    equations: int
    steps: tuple[DecoupledStep, ...]
    coupled: tuple[int, ...]

    @property
    def torus(self) -> None:
        """None: there are no angle variables."""
        return None

    @property
    def scheme(self) -> TriangularScheme:
        """These equations."""
        return self


def plan(coordinate_motions: Sequence[CoordinateMotion]) -> TriangularScheme:
    """Find which coordinates have a time of their own.

    Args:
        coordinate_motions: of the separated coordinates, in their order.

    Raises:
        NotConvergedError: the integrals are beyond the range of doubles.
    """
    n = len(coordinate_motions)
    # whether a combination of kernels vanishes identically is asked of six phases: it is a question of the form of T,
    # not of the motion
    samples = [_sample(c, n) for c in coordinate_motions]
    steps: list[DecoupledStep] = []
    left = list(range(n))
    while left:
        found = next((step for i in left if (step := _own(i, left, samples))), None)
        if found is None:
            break
        steps.append(found)
        left.remove(found.index)
    return TriangularScheme(tuple(coordinate_motions), n, tuple(steps), tuple(left))


def _sample(coordinate_motion: CoordinateMotion, n: int) -> Reals:
    """Rows of kernels at a few phases, each scaled to unit size; without those that are rounding.

    A periodic series is rounded like its greatest value, panels each like their own.
    """
    # phases of no special meaning; on an open branch nearer to the start, as y there has no period
    χ = np.array([0.37, 0.81, 1.23, 1.77, 2.41, 2.93]) * (0.3 if coordinate_motion.branches else 1.0)
    rows = np.stack([np.broadcast_to(coordinate_motion.rate(j, χ), χ.shape) for j in range(n)], axis=1)
    sizes = np.max(np.abs(rows), axis=1, keepdims=True)
    significant = sizes[:, 0] > 1e-12 * (float(np.max(sizes)) if coordinate_motion.one_scale else 0.0)
    if not (significant.any() and np.isfinite(sizes).all()):
        raise NotConvergedError(
            "the times of this motion are beyond doubles, 1e-308 to 1e308; write lengths and times in other "
            'units, or leave them out with want=["constants", "turning_points"]'
        )
    return rows[significant] / sizes[significant]


def _own(i: int, left: list[int], samples: list[Reals]) -> DecoupledStep | None:
    n = samples[i].shape[1]
    # w must be orthogonal to the kernels of every coordinate that is not yet known
    others = np.concatenate([samples[l] for l in left if l != i] or [np.zeros((1, n))])
    for j in range(n):
        if np.all(others[:, j] == 0) and np.min(np.abs(samples[i][:, j])) > 1e-9:
            return DecoupledStep(i, tuple(float(j == c) for c in range(n)))
    # the null space by singular values: rank is decided against the largest of them, at the rounding of kernels
    _, values, rows = np.linalg.svd(others)
    rank = int(np.sum(values > 1e-12 * max(values[0], 1e-300)))
    null = rows[rank:]
    if not len(null):
        return None
    # the projection of this coordinate's own kernels: of the null space the direction in which its equation is steepest
    weights = null.T @ (null @ samples[i][0])
    weights = weights / max(np.max(np.abs(weights)), 1e-300)
    # a weight that is rounding would bring a foreign kernel into the equation, and its error with it
    weights[np.abs(weights) < 1e-11] = 0.0
    seen = samples[i] @ weights
    # no sample of the sum is near 0: the equation is taken to be monotone in χᵢ
    return DecoupledStep(i, tuple(float(w) for w in weights)) if np.min(np.abs(seen)) > 1e-6 else None


@dataclass(frozen=True)
class OwnTurns:
    """A coordinate that comes back by a clock of its own, whatever the others do: χ + D(χ) = θ⁰ + Ω (t − t₀).

    Attributes:
        index: position of the coordinate.
        cycle: its motion.
        rate: Ω in many digits.
        series: D (its mean is ignored).
        start: θ⁰, the angle at t₀.
        rounding: how far the rounded series leaves θ⁰ open; 0 where the motion starts at a turning point.
    """

    index: int
    cycle: Periodic
    rate: Mpf
    series: FourierSeries
    start: Mpf
    rounding: float


def own_turns(scheme: TriangularScheme, bits: int) -> list[OwnTurns]:
    """Return the coordinates whose equation holds the time and none of the others, and which come back.

    Args:
        scheme: from ``plan``.
    """
    context, found = multiprecision(bits), []
    for step in scheme.steps:
        cycle = scheme.coordinate_motions[step.index].cycle
        if cycle is None or not step.weights[0] or not (step == scheme.steps[0] or _alone(scheme, step)):
            continue
        kernels = cycle.kernels[: scheme.equations]
        # growth of the left side a turn over 2π: divided by it the equation has slope one in the mean
        mean = sum((w * series.mean for w, series in zip(step.weights, kernels, strict=True)), context.mpf(0))
        series = combine([w / mean for w in step.weights], kernels)
        begin = context.mpf(cycle.start)
        start = begin if series.constant else begin + series.oscillation(begin)
        rounding = series.unresolved(begin)
        rate = context.mpf(step.weights[0]) / mean
        found.append(OwnTurns(step.index, cycle, rate, series, start, rounding))
    return found


def _alone(scheme: TriangularScheme, step: DecoupledStep) -> bool:
    """Return True when a coordinate's equation holds none of the other coordinates."""
    others = [c for i, c in enumerate(scheme.coordinate_motions) if i != step.index]
    phase = np.array([0.7])
    return all(
        abs(float(np.ravel(sum(w * c.rate(j, phase) for j, w in enumerate(step.weights) if w))[0])) == 0 for c in others
    )


def open_phases(
    scheme: TriangularScheme, time: tuple[Reals, Reals]
) -> tuple[list[Reals], list[Counts], list[Reals], Mask]:
    """Solve for the phases at times relative to t₀.

    Args:
        scheme: from ``plan``.
        time: high and low parts, float arrays of shape (m,).

    Returns:
        For each coordinate χ, whole turns and a bound on the error of χ, shape (m,); and an array that is True
        where the motion has ended before that time.
    """
    # a little more than the farthest time, so that it is inside its panel
    span = float(np.max(np.abs(time[0]), initial=0.0)) * (1 + 1e-9) + 1e-290
    for attempt in range(_REACHES):
        χ, whole, errors, ended, short = _phases(scheme, time, span, attempt)
        if not short.any():
            break
    return χ, whole, errors, ended | short


def _phases(
    scheme: TriangularScheme, time: tuple[Reals, Reals], span: float, attempt: int
) -> tuple[list[Reals], list[Counts], list[Reals], Mask, Mask]:
    """Return the same with panels that reach so far; True last where that is not far enough."""
    t = time[0] + time[1]
    # panels grow geometrically, so that 8 times the time is a few panels more
    coordinate_motions = [
        reaching(c, scheme, span * 8.0**attempt, i, attempt) for i, c in enumerate(scheme.coordinate_motions)
    ]
    if scheme.steps:
        first = scheme.steps[0]
        coordinate_motions[first.index] = _one_direction(coordinate_motions[first.index], first, time[0])
    targets = [sum(integral_at_start(c, j) for c in coordinate_motions) for j in range(scheme.equations)]
    n = len(coordinate_motions)
    χ: list[Any] = [None] * n
    whole: list[Any] = [np.zeros_like(t)] * n
    errors: list[Any] = [None] * n
    ended, short = np.zeros(t.shape, dtype=bool), np.zeros(t.shape, dtype=bool)
    for step in scheme.steps:
        known = [(l, c) for l, c in enumerate(coordinate_motions) if χ[l] is not None]
        # Gⱼ grows from turn to turn: kernels are asked at the full phase
        full = [None if x is None else x + 2 * np.pi * n for x, n in zip(χ, whole, strict=True)]
        value, error_bound = _right_side(step, targets, known, full, errors, t)
        # only the first equation holds the time alone; there whole turns come off in 32 digits
        own = step.weights[0] if not known else 0.0
        coordinate_motion = coordinate_motions[step.index]
        χ[step.index], whole[step.index], errors[step.index], ended_here = solve_alone(
            coordinate_motion, step.weights, value, error_bound, own, time
        )
        further = np.where(t >= 0, *(_goes_on(coordinate_motion, side) for side in (1, -1)))
        short |= ended_here & further
        # beyond the last panel of a branch that is complete the motion is over; of another one panels are too short
        ended |= ended_here & ~further
    if scheme.coupled:
        full = [None if x is None else x + 2 * np.pi * n for x, n in zip(χ, whole, strict=True)]
        # two coordinates by brackets, which cannot miss; three or more by following them in time
        pair = _couple(coordinate_motions, scheme)
        if pair is None:
            _march(coordinate_motions, scheme, targets, t, full, χ, errors, ended)
        else:
            goals, error_bounds = _right_sides(coordinate_motions, scheme, targets, t, full, errors)
            both = solve_pair(pair, goals, error_bounds, t)
            for row, i in enumerate(scheme.coupled):
                χ[i], errors[i] = both.χ[row], both.errors[row]
            ended, short = ended | both.ended, both.short
    return χ, whole, errors, ended, short


def _goes_on(coordinate_motion: CoordinateMotion, side: int) -> bool:
    """Return True where a course is longer than its panels."""
    return coordinate_motion.ends(side) in {"infinity", "boundary"} and not coordinate_motion.finished(side)


def _one_direction(coordinate_motion: CoordinateMotion, step: DecoupledStep, times: Reals) -> CoordinateMotion:
    """Return a coordinate motion that is its own clock and starts at phase 0, with panels where there are times.

    Its phase has the sign of the time.
    """
    if not isinstance(coordinate_motion, Unbounded) or not coordinate_motion.both_directions:
        return coordinate_motion
    if coordinate_motion.start or not step.weights[0]:
        return coordinate_motion
    return coordinate_motion.on_sides(
        ahead=bool(np.max(times, initial=0.0) > 0), back=bool(np.min(times, initial=0.0) < 0)
    )


def _couple(coordinate_motions: list[CoordinateMotion], scheme: TriangularScheme) -> CoupledPair | None:
    """Return two coupled coordinates that can be searched one within the other."""
    if len(scheme.coupled) != 2:
        return None
    first, second = scheme.coupled
    return choose_pair(
        (coordinate_motions[first], coordinate_motions[second]), [s.weights for s in scheme.steps], scheme.equations
    )


def _right_sides(
    coordinate_motions: list[CoordinateMotion],
    scheme: TriangularScheme,
    targets: list[float],
    t: Reals,
    known: Sequence[Reals | None],
    errors: list[Any],
) -> tuple[Reals, Reals]:
    """Right sides of all equations for the coupled coordinates and bounds on their errors, shape (equations, m)."""
    goals = np.array(targets)[:, None] + 0 * t
    goals[0] += t
    starts = [sum(abs(float(np.ravel(c.integral(j, np.array([float(c.start)])))[0])) for c in coordinate_motions)
              for j in range(scheme.equations)]  # fmt: skip
    # the right side is a difference of integrals at the start and at t: each is rounded like itself
    error_bounds = 4 * EPS * (np.array(starts)[:, None] + np.abs(goals))
    for l, χ in enumerate(known):
        if χ is not None:
            for j in range(scheme.equations):
                part = coordinate_motions[l].integral(j, χ)
                goals[j] -= part
                # |∂G/∂χ| δχ of a phase that is known, and the rounding of its integral
                error_bounds[j] += np.abs(coordinate_motions[l].rate(j, χ)) * errors[l] + 4 * EPS * np.abs(part)
    return goals, error_bounds


def reaching(
    coordinate_motion: CoordinateMotion, scheme: TriangularScheme, span: float, i: int, attempt: int = _REACHES - 1
) -> CoordinateMotion:
    """Let an open course hold enough panels for a time span: of its own clock, or of its part of the time.

    A coordinate that has no part in the time (another one has it alone) is held up to a phase, which is squared with
    every attempt. Where panels cannot be had so far, there are fewer.

    Args:
        coordinate_motion: of one coordinate; one that comes back is given back as it is.
        scheme: which coordinates have a time of their own.
        span: length of time, in the units of t.
        i: position of the coordinate.
        attempt: how often panels have been too short.
    """
    if not isinstance(coordinate_motion, Unbounded):
        return coordinate_motion
    weights = next(
        (s.weights for s in scheme.steps if s.index == i), tuple(float(j == 0) for j in range(scheme.equations))
    )
    least = max(1.0, abs(float(coordinate_motion.start)))
    if not any(w and coordinate_motion.carries(j) for j, w in enumerate(weights)):
        return coordinate_motion.with_amount(
            None, min(4.0 * least * 2.0 ** min(2**attempt - 1, 1000), 1e300), partly=True
        )
    begin = coordinate_motion.with_amount(None, least)
    here = sum(
        abs(w * float(begin.integral(j, np.array([float(coordinate_motion.start)]))[0]))
        for j, w in enumerate(weights)
        if w
    )
    others = 1.0 if weights[0] or len(scheme.coupled) == 2 else 64.0
    amount = here + others * span * max(abs(weights[0]), 1e-300) if weights[0] else here + others * span
    return coordinate_motion.with_amount(weights, amount, partly=True)


def integral_at(coordinate_motion: CoordinateMotion, j: int, χ: Mpf | int) -> float:
    """Return Gⱼ in doubles at a phase of many digits.

    Where Gⱼ is steep, next to the top of a barrier, the phase rounded to a double is another time.

    Args:
        j: position of the constant.
        χ: phase.
    """
    near = np.array([float(χ)])
    # first order in χ − fl(χ): the phase rounded to a double, times a steep slope, would be another time
    value, slope = (
        float(np.ravel(np.asarray(f(j, near)))[0]) for f in (coordinate_motion.integral, coordinate_motion.rate)
    )
    return value + slope * float(χ - near[0])


def integral_at_start(coordinate_motion: CoordinateMotion, j: int) -> float:
    """Return Gⱼ in doubles at the start, as ``integral_at``."""
    return integral_at(coordinate_motion, j, coordinate_motion.start)


def _right_side(
    step: DecoupledStep,
    targets: list[float],
    known: list[tuple[int, CoordinateMotion]],
    χ: list[Any],
    errors: list[Any],
    t: Reals,
) -> tuple[Reals, Reals]:
    value = sum(w * c for w, c in zip(step.weights, targets, strict=True)) + step.weights[0] * t
    size = sum(abs(w * c) for w, c in zip(step.weights, targets, strict=True)) + np.abs(step.weights[0] * t)
    error_bound = 0.0 * t
    for l, coordinate_motion in known:
        start = np.array([float(coordinate_motion.start)])
        for j, w in enumerate(step.weights):
            if w:
                part = w * coordinate_motion.integral(j, χ[l])
                value = value - part
                # twice the integral at the start: it stands in the target as well
                size = size + np.abs(part) + 2 * np.abs(w * coordinate_motion.integral(j, start))
                error_bound = error_bound + np.abs(w * coordinate_motion.rate(j, χ[l]) * errors[l])
    return value, error_bound + 2 * EPS * size


def _march(
    coordinate_motions: list[CoordinateMotion],
    scheme: TriangularScheme,
    targets: list[float],
    t: Reals,
    known: Sequence[Reals | None],
    χ: list[Any],
    errors: list[Any],
    ended: Reals,
) -> None:
    """Follow the coupled coordinates from t₀ through the sorted times, Newton's method at every step."""
    block = scheme.coupled
    begin = np.array([float(coordinate_motions[i].start) for i in block])
    limits = [coordinate_motions[i].limits() for i in block]
    found = np.empty((len(block), len(t)))
    bounds = np.empty_like(found)
    for direction in (1, -1):
        state, now = begin.copy(), 0.0
        chosen = np.where(direction * t >= 0)[0] if direction == 1 else np.where(t < 0)[0]
        for m in chosen[np.argsort(direction * t[chosen])]:
            equations = _Equations(
                coordinate_motions, scheme, targets, {l: float(x[m]) for l, x in enumerate(known) if x is not None}
            )
            # from one sorted time to the next: each solution starts the next search
            state, now = equations.advance(state, now, float(t[m]), limits)
            found[:, m] = state
            bounds[:, m] = equations.bound(state, now)
            ended[m] |= now != float(t[m])
    for row, i in enumerate(block):
        χ[i], errors[i] = found[row], bounds[row]


@dataclass(frozen=True)
class _Equations:
    """Jacobi's equations in the coupled coordinates, at one value of those already known."""

    coordinate_motions: list[CoordinateMotion]
    scheme: TriangularScheme
    targets: list[float]
    known: dict[int, float]

    def _evaluate(self, x: Reals, t: float) -> tuple[Reals, Reals]:
        n = self.scheme.equations
        residual = -np.array(self.targets)
        residual[0] -= t
        jacobian = np.zeros((n, len(x)))
        for l, value in self.known.items():
            residual += [float(self.coordinate_motions[l].integral(j, np.array([value]))[0]) for j in range(n)]
        for column, i in enumerate(self.scheme.coupled):
            place = np.array([x[column]])
            residual += [float(np.ravel(self.coordinate_motions[i].integral(j, place))[0]) for j in range(n)]
            jacobian[:, column] = [float(np.ravel(self.coordinate_motions[i].rate(j, place))[0]) for j in range(n)]
        return residual, jacobian

    def advance(self, x: Reals, now: float, goal: float, limits: list[tuple[float, float]]) -> tuple[Reals, float]:
        """Walk from one time to another; stop early where a coordinate reaches the end of its domain."""
        step = goal - now
        while now != goal:
            target = goal if abs(goal - now) <= abs(step) else now + step
            trial, worked = self._newton(x, target, limits)
            if worked:
                x, now, step = trial, target, 2 * step
            # time steps at rounding: a coordinate has come to its end, or the equations are singular
            elif abs(step) < 1e-13 * max(abs(goal), 1e-13):
                near = [min(v - low, high - v) < 1e-6 * (1 + abs(v)) for v, (low, high) in zip(x, limits, strict=True)]
                if not any(near):
                    raise NotConvergedError(f"coupled coordinates could not be followed beyond t - t0 = {now:.9g}")
                return x, now
            else:
                step /= 4
        return x, now

    def _newton(self, x: Reals, t: float, limits: list[tuple[float, float]]) -> tuple[Reals, bool]:
        last = np.inf
        for _ in range(12):
            residual, jacobian = self._evaluate(x, t)
            # equations may outnumber the coupled coordinates; they are consistent, so that least squares solves them
            step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
            size = float(np.max(np.abs(step) / (1 + np.abs(x))))
            # not a correction of a nearby solution: the step in time was too long
            if size > 0.5 or size > 2 * last + 1e-12:
                return x, False
            x, last = x + step, size
            if any(not low <= v <= high for v, (low, high) in zip(x, limits, strict=True)):
                return x, False
            if size < 8 * EPS:
                return x, True
        return x, last < 1e-12

    def bound(self, x: Reals, t: float) -> Reals:
        """Bound the error of a solution from its residual and the rounding of the sums."""
        residual, jacobian = self._evaluate(x, t)
        error_bounds = np.abs(residual) + 4 * EPS * (
            np.abs(self.targets) + abs(t) * (np.arange(len(residual)) == 0) + np.abs(jacobian) @ np.abs(x)
        )
        # |J⁺| times residual and rounding of the sums, to first order
        return np.abs(np.linalg.pinv(jacobian)) @ error_bounds + 2 * EPS * np.abs(x)
