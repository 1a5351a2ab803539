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
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Periodic
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
        courses: one a coordinate.
        equations: number of constants the quadratures are taken for, the energy first.
        steps: coordinates solved alone, in order.
        coupled: the others.
    """

    courses: tuple[CoordinateMotion, ...]
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


def plan(courses: Sequence[CoordinateMotion]) -> TriangularScheme:
    """Find which coordinates have a time of their own.

    Args:
        courses: of the separated coordinates, in their order.

    Raises:
        NotConvergedError: the integrals are beyond the range of doubles.
    """
    n = len(courses)
    samples = [_sample(c, n) for c in courses]
    steps: list[DecoupledStep] = []
    left = list(range(n))
    while left:
        found = next((step for i in left if (step := _own(i, left, samples))), None)
        if found is None:
            break
        steps.append(found)
        left.remove(found.index)
    return TriangularScheme(tuple(courses), n, tuple(steps), tuple(left))


def _sample(course: CoordinateMotion, n: int) -> Reals:
    """Rows of kernels at a few phases, each scaled to unit size; without those that are rounding.

    A periodic series is rounded like its greatest value, panels each like their own.
    """
    χ = np.array([0.37, 0.81, 1.23, 1.77, 2.41, 2.93]) * (0.3 if course.branches else 1.0)
    rows = np.stack([np.broadcast_to(course.rate(j, χ), χ.shape) for j in range(n)], axis=1)
    sizes = np.max(np.abs(rows), axis=1, keepdims=True)
    significant = sizes[:, 0] > 1e-12 * (float(np.max(sizes)) if course.one_scale else 0.0)
    if not (significant.any() and np.isfinite(sizes).all()):
        raise NotConvergedError(
            "the times of this motion are beyond doubles, 1e-308 to 1e308; write lengths and times in other "
            'units, or leave them out with want=["constants", "turning_points"]'
        )
    return rows[significant] / sizes[significant]


def _own(i: int, left: list[int], samples: list[Reals]) -> DecoupledStep | None:
    n = samples[i].shape[1]
    others = np.concatenate([samples[l] for l in left if l != i] or [np.zeros((1, n))])
    for j in range(n):
        if np.all(others[:, j] == 0) and np.min(np.abs(samples[i][:, j])) > 1e-9:
            return DecoupledStep(i, tuple(float(j == c) for c in range(n)))
    _, values, rows = np.linalg.svd(others)
    rank = int(np.sum(values > 1e-12 * max(values[0], 1e-300)))
    null = rows[rank:]
    if not len(null):
        return None
    weights = null.T @ (null @ samples[i][0])
    weights = weights / max(np.max(np.abs(weights)), 1e-300)
    weights[np.abs(weights) < 1e-11] = 0.0
    seen = samples[i] @ weights
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
        cycle = scheme.courses[step.index].cycle
        if cycle is None or not step.weights[0] or not (step == scheme.steps[0] or _alone(scheme, step)):
            continue
        kernels = cycle.kernels[: scheme.equations]
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
    others = [c for i, c in enumerate(scheme.courses) if i != step.index]
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
    courses = [reaching(c, scheme, span * 8.0**attempt, i, attempt) for i, c in enumerate(scheme.courses)]
    if scheme.steps:
        first = scheme.steps[0]
        courses[first.index] = _one_direction(courses[first.index], first, time[0])
    targets = [sum(integral_at_start(c, j) for c in courses) for j in range(scheme.equations)]
    n = len(courses)
    χ: list[Any] = [None] * n
    whole: list[Any] = [np.zeros_like(t)] * n
    errors: list[Any] = [None] * n
    ended, short = np.zeros(t.shape, dtype=bool), np.zeros(t.shape, dtype=bool)
    for step in scheme.steps:
        known = [(l, c) for l, c in enumerate(courses) if χ[l] is not None]
        full = [None if x is None else x + 2 * np.pi * n for x, n in zip(χ, whole, strict=True)]
        value, error_bound = _right_side(step, targets, known, full, errors, t)
        own = step.weights[0] if not known else 0.0
        course = courses[step.index]
        χ[step.index], whole[step.index], errors[step.index], ended_here = solve_alone(
            course, step.weights, value, error_bound, own, time
        )
        further = np.where(t >= 0, *(_goes_on(course, side) for side in (1, -1)))
        short |= ended_here & further
        ended |= ended_here & ~further
    if scheme.coupled:
        full = [None if x is None else x + 2 * np.pi * n for x, n in zip(χ, whole, strict=True)]
        pair = _couple(courses, scheme)
        if pair is None:
            _march(courses, scheme, targets, t, full, χ, errors, ended)
        else:
            goals, error_bounds = _right_sides(courses, scheme, targets, t, full, errors)
            both = solve_pair(pair, goals, error_bounds, t)
            for row, i in enumerate(scheme.coupled):
                χ[i], errors[i] = both.χ[row], both.errors[row]
            ended, short = ended | both.ended, both.short
    return χ, whole, errors, ended, short


def _goes_on(course: CoordinateMotion, side: int) -> bool:
    """Return True where a course is longer than its panels."""
    return course.ends(side) in {"infinity", "boundary"} and not course.finished(side)


def _one_direction(course: CoordinateMotion, step: DecoupledStep, times: Reals) -> CoordinateMotion:
    """Return a coordinate motion that is its own clock and starts at phase 0, with panels where there are times.

    Its phase has the sign of the time.
    """
    if not course.both_directions or course.start or not step.weights[0]:
        return course
    return course.on_sides(ahead=bool(np.max(times, initial=0.0) > 0), back=bool(np.min(times, initial=0.0) < 0))


def _couple(courses: list[CoordinateMotion], scheme: TriangularScheme) -> CoupledPair | None:
    """Return two coupled coordinates that can be searched one within the other."""
    if len(scheme.coupled) != 2:
        return None
    first, second = scheme.coupled
    return choose_pair((courses[first], courses[second]), [s.weights for s in scheme.steps], scheme.equations)


def _right_sides(
    courses: list[CoordinateMotion],
    scheme: TriangularScheme,
    targets: list[float],
    t: Reals,
    known: Sequence[Reals | None],
    errors: list[Any],
) -> tuple[Reals, Reals]:
    """Right sides of all equations for the coupled coordinates and bounds on their errors, shape (equations, m)."""
    goals = np.array(targets)[:, None] + 0 * t
    goals[0] += t
    starts = [sum(abs(float(np.ravel(c.integral(j, np.array([float(c.start)])))[0])) for c in courses)
              for j in range(scheme.equations)]  # fmt: skip
    error_bounds = 4 * EPS * (np.array(starts)[:, None] + np.abs(goals))
    for l, χ in enumerate(known):
        if χ is not None:
            for j in range(scheme.equations):
                part = courses[l].integral(j, χ)
                goals[j] -= part
                error_bounds[j] += np.abs(courses[l].rate(j, χ)) * errors[l] + 4 * EPS * np.abs(part)
    return goals, error_bounds


def reaching(
    course: CoordinateMotion, scheme: TriangularScheme, span: float, i: int, attempt: int = _REACHES - 1
) -> CoordinateMotion:
    """Let an open course hold enough panels for a time span: of its own clock, or of its part of the time.

    A coordinate that has no part in the time (another one has it alone) is held up to a phase, which is squared with
    every attempt. Where panels cannot be had so far, there are fewer.

    Args:
        course: of one coordinate; one that comes back is given back as it is.
        scheme: which coordinates have a time of their own.
        span: length of time, in the units of t.
        i: position of the coordinate.
        attempt: how often panels have been too short.
    """
    if not course.branches:
        return course
    weights = next(
        (s.weights for s in scheme.steps if s.index == i), tuple(float(j == 0) for j in range(scheme.equations))
    )
    least = max(1.0, abs(float(course.start)))
    if not any(w and course.carries(j) for j, w in enumerate(weights)):
        return course.with_amount(None, min(4.0 * least * 2.0 ** min(2**attempt - 1, 1000), 1e300), partly=True)
    begin = course.with_amount(None, least)
    here = sum(
        abs(w * float(begin.integral(j, np.array([float(course.start)]))[0])) for j, w in enumerate(weights) if w
    )
    others = 1.0 if weights[0] or len(scheme.coupled) == 2 else 64.0
    amount = here + others * span * max(abs(weights[0]), 1e-300) if weights[0] else here + others * span
    return course.with_amount(weights, amount, partly=True)


def integral_at(course: CoordinateMotion, j: int, χ: Mpf | int) -> float:
    """Return Gⱼ in doubles at a phase of many digits.

    Where Gⱼ is steep, next to the top of a barrier, the phase rounded to a double is another time.

    Args:
        j: position of the constant.
        χ: phase.
    """
    near = np.array([float(χ)])
    value, slope = (float(np.ravel(np.asarray(f(j, near)))[0]) for f in (course.integral, course.rate))
    return value + slope * float(χ - near[0])


def integral_at_start(course: CoordinateMotion, j: int) -> float:
    """Return Gⱼ in doubles at the start, as ``integral_at``."""
    return integral_at(course, j, course.start)


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
    for l, course in known:
        start = np.array([float(course.start)])
        for j, w in enumerate(step.weights):
            if w:
                part = w * course.integral(j, χ[l])
                value = value - part
                size = size + np.abs(part) + 2 * np.abs(w * course.integral(j, start))
                error_bound = error_bound + np.abs(w * course.rate(j, χ[l]) * errors[l])
    return value, error_bound + 2 * EPS * size


def _march(
    courses: list[CoordinateMotion],
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
    begin = np.array([float(courses[i].start) for i in block])
    limits = [courses[i].limits() for i in block]
    found = np.empty((len(block), len(t)))
    bounds = np.empty_like(found)
    for direction in (1, -1):
        state, now = begin.copy(), 0.0
        chosen = np.where(direction * t >= 0)[0] if direction == 1 else np.where(t < 0)[0]
        for m in chosen[np.argsort(direction * t[chosen])]:
            equations = _Equations(
                courses, scheme, targets, {l: float(x[m]) for l, x in enumerate(known) if x is not None}
            )
            state, now = equations.advance(state, now, float(t[m]), limits)
            found[:, m] = state
            bounds[:, m] = equations.bound(state, now)
            ended[m] |= now != float(t[m])
    for row, i in enumerate(block):
        χ[i], errors[i] = found[row], bounds[row]


@dataclass(frozen=True)
class _Equations:
    """Jacobi's equations in the coupled coordinates, at one value of those already known."""

    courses: list[CoordinateMotion]
    scheme: TriangularScheme
    targets: list[float]
    known: dict[int, float]

    def _evaluate(self, x: Reals, t: float) -> tuple[Reals, Reals]:
        n = self.scheme.equations
        residual = -np.array(self.targets)
        residual[0] -= t
        jacobian = np.zeros((n, len(x)))
        for l, value in self.known.items():
            residual += [float(self.courses[l].integral(j, np.array([value]))[0]) for j in range(n)]
        for column, i in enumerate(self.scheme.coupled):
            place = np.array([x[column]])
            residual += [float(np.ravel(self.courses[i].integral(j, place))[0]) for j in range(n)]
            jacobian[:, column] = [float(np.ravel(self.courses[i].rate(j, place))[0]) for j in range(n)]
        return residual, jacobian

    def advance(self, x: Reals, now: float, goal: float, limits: list[tuple[float, float]]) -> tuple[Reals, float]:
        """Walk from one time to another; stop early where a coordinate reaches the end of its domain."""
        step = goal - now
        while now != goal:
            target = goal if abs(goal - now) <= abs(step) else now + step
            trial, worked = self._newton(x, target, limits)
            if worked:
                x, now, step = trial, target, 2 * step
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
            step = np.linalg.lstsq(jacobian, -residual, rcond=None)[0]
            size = float(np.max(np.abs(step) / (1 + np.abs(x))))
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
        return np.abs(np.linalg.pinv(jacobian)) @ error_bounds + 2 * EPS * np.abs(x)
