"""One coordinate whose equation holds no other: Σⱼ wⱼ Gⱼ(χ) = value, monotone in χ."""

from __future__ import annotations

from functools import singledispatch
from typing import cast

import numpy as np

from hjsolve.arithmetic.error_free import split
from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Elementwise, Mask, Reals
from hjsolve.arithmetic.root_finding import bracketed_roots
from hjsolve.one_coordinate.coordinate_motion import (
    AtRest,
    KindOfMotion,
    Periodic,
    Unbounded,
    Weights,
)
from hjsolve.one_coordinate.fourier_series import combine
from hjsolve.time_law.phase_reduction import turns_and_rest
from hjsolve.time_law.torus import _alone


@singledispatch
def solve_alone(
    coordinate_motion: KindOfMotion,
    weights: Weights,
    value: Reals,
    residual_bound: Reals,
    own: float,
    time: tuple[Reals, Reals],
) -> tuple[Reals, Reals, Reals, Mask]:
    """Solve Σ wⱼ Gⱼ(χ) = value for one coordinate.

    Args:
        weights: w.
        value: right side at each time, shape (m,).
        residual_bound: a bound on its error, shape (m,).
        own: part of ``value`` that grows with the time, per unit; 0 where other coordinates have a fraction in it.
        time: high and low parts of the times, shape (m,).

    Returns:
        χ, whole turns, a bound on the error of χ, and True where the coordinate has ended before; shape (m,).
    """
    raise NotImplementedError(type(coordinate_motion))


@solve_alone.register
def _of_cycle(
    coordinate_motion: Periodic,
    weights: Weights,
    value: Reals,
    residual_bound: Reals,
    own: float,
    time: tuple[Reals, Reals],
) -> tuple[Reals, Reals, Reals, Mask]:
    total = combine(list(weights), coordinate_motion.kernels[: len(weights)])
    # divided by the mean growth the equation is χ + D(χ) = θ, which ``torus`` solves
    scaled = combine([1 / total.mean], [total])
    angle, whole = value / float(total.mean), 0.0 * value
    if own:
        # turns come off the part that grows with the time, to 32 digits; the rest of the right side stays bounded
        count, rest = turns_and_rest(split(own / total.mean / (2 * multiprecision(160).pi)), time)
        # what is not the time: the value at t₀ and the other coordinates
        start = angle - own / float(total.mean) * (time[0] + time[1])
        whole = count + np.rint(rest).astype(int)
        angle = 2 * np.pi * (rest - np.rint(rest)) + start
    x, error = _alone(scaled, angle, residual_bound / abs(float(total.mean)))
    return x, whole, error, np.zeros(value.shape, dtype=bool)


@solve_alone.register
def _of_rest(
    coordinate_motion: AtRest, weights: Weights, value: Reals, residual_bound: Reals, *_: object
) -> tuple[Reals, Reals, Reals, Mask]:
    rate = float(sum(w * float(r) for w, r in zip(weights, coordinate_motion.rates, strict=False)))
    # at rest Gⱼ grows evenly: the equation is linear
    error = residual_bound / abs(rate) + EPS * np.abs(value / rate)
    return value / rate, 0.0 * value, error, np.zeros(value.shape, dtype=bool)


@solve_alone.register
def _of_open(
    coordinate_motion: Unbounded, weights: Weights, value: Reals, error_bound: Reals, *_: object
) -> tuple[Reals, Reals, Reals, Mask]:
    def function(χ: Reals) -> tuple[Reals, Reals]:
        pairs = [
            (w * coordinate_motion.integral(j, χ), w * coordinate_motion.rate(j, χ)) for j, w in enumerate(weights) if w
        ]
        return cast("Reals", sum(p[0] for p in pairs)), cast("Reals", sum(p[1] for p in pairs))

    # monotone all along: one phase tells whether it rises or falls
    sign = 1.0 if function(np.array([0.1]))[1][0] > 0 else -1.0
    edges = coordinate_motion.edges()
    levels = sign * function(edges)[0]
    goal = sign * value
    # the integral at the edges of panels brackets every goal
    position = np.clip(np.searchsorted(levels, goal) - 1, 0, len(edges) - 2)
    low, high = edges[position], edges[position + 1]
    floor, ceiling = coordinate_motion.limits()
    # beyond the last panel the integral is continued by its last slope: a bracket of twice that distance and a little
    # more holds the zero
    if not np.isfinite(ceiling):
        high = np.where(
            goal > levels[-1],
            edges[-1] + 2 + 2 * (goal - levels[-1]) / np.abs(coordinate_motion.rate_sum(weights, edges[-1:]))[0],
            high,
        )
    if not np.isfinite(floor):
        low = np.where(
            goal < levels[0],
            edges[0] - 2 - 2 * (levels[0] - goal) / np.abs(coordinate_motion.rate_sum(weights, edges[:1]))[0],
            low,
        )
    ended = ((goal > levels[-1]) & np.isfinite(ceiling)) | ((goal < levels[0]) & np.isfinite(floor))

    def equation(χ: Reals) -> tuple[Reals, Reals]:
        f, slope = function(χ)
        return sign * f - goal, sign * slope

    χ, residual, slope = bracketed_roots(equation, (low + high) / 2, low, high)
    # sizes before terms cancel: that is what rounding refers to
    summed: Elementwise = sum(np.abs(w * coordinate_motion.integral(j, edges)) for j, w in enumerate(weights) if w)
    rounding = np.maximum(summed[position], summed[position + 1])  # a panel's series is rounded like its greatest value
    rounding_and_error = (
        error_bound + 4 * EPS * np.abs(goal) + 2 * EPS * rounding + np.where(ended, 0.0, np.abs(residual))
    )
    return χ, 0.0 * value, rounding_and_error / np.maximum(np.abs(slope), 1e-300) + 2 * EPS * np.abs(χ), ended
