"""The loops of the compiled pass. Only imported where numba is.

Functions that call a program of the coordinate know it by its global name; ``programs`` binds them to each.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hjsolve.arithmetic.floats import EPS
from hjsolve.ensembles.engine.compiled_rule import REDUCING, SAMPLES, choose, dot
from hjsolve.ensembles.engine.elementary import OPTIONS, sincos
from hjsolve.ensembles.engine.nodes import EVEN

_EVEN = EVEN
_CLOSE = 0.05
_LANES = 8
"""Places at which rounding errors are looked at: whole vectors."""

doubts: Any = None
relative: Any = None
pack: Any = None
"""Of the program; see ``programs``."""

_PLACES = tuple(0.5 - 0.5 * math.cos(math.pi * (g + 0.04) / (SAMPLES - 1 + 0.08)) for g in range(SAMPLES))


@njit(**OPTIONS)
def _pace(χ, warp):
    s, c = sincos(χ)
    return 1.0 + warp[0] * c + warp[1] * (c * c - s * s)


@njit(**OPTIONS)
def _anomaly(x, y, warp):
    """χ of a place; see ``initial_phase._unwarped``. Halley's steps inside a bracket."""
    goal = 2.0 * math.atan2(np.sqrt(max(x, 0.0)), np.sqrt(max(y, 0.0)))
    γ, δ = warp[0], warp[1]
    if γ == 0.0 and δ == 0.0:
        return goal
    low, high, χ = 0.0, math.pi, goal
    for _ in range(60):
        s, c = sincos(χ)
        f = χ + γ * s + δ * s * c - goal
        slope, bend = 1.0 + γ * c + δ * (c * c - s * s), -s * (γ + 4.0 * δ * c)
        if f <= 0.0:
            low = χ
        else:
            high = χ
        new = χ - f * slope / (slope * slope - 0.5 * f * bend)
        inside = new >= low and new <= high
        if not inside:
            new = 0.5 * (low + high)
        if abs(new - χ) <= (1e-6 if inside else 4.0 * EPS) * abs(new):  # the error falls with its third power
            return new
        χ = new
    return χ


@njit(**OPTIONS)
def _interpolation(weights, χ, n, cosines):
    """Weights by which values at the nodes give that at χ: the barycentric formula (Berrut & Trefethen 2004, §5.2)."""
    place, nodes, signs, total = math.cos(χ), cosines[0], cosines[n - 2], 0.0
    for j in range(n):
        gap = place - nodes[j]
        weights[j] = signs[j] / (gap if gap != 0.0 else 1e-30)
    total = _total(weights, n)
    for j in range(n):
        weights[j] /= total


@njit(**REDUCING)
def _total(x: Any, n: int) -> float:
    total = 0.0
    for j in range(n):
        total += x[j]
    return total


@njit(**OPTIONS)
def _integration(weights, scratch, χ, n, cosines):
    """Weights of the running integral less its mean growth, Σ cos kχⱼ sin kχ/k; odd k are odd about χ = π/2."""
    half = n // 2
    s1, c1 = sincos(χ)
    s, c = s1, c1
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    t, d = s2, c2
    scratch[0, :half] = 0.0
    scratch[1, :half] = 0.0
    for k in range(1, n - 2, 4):
        s3, c3 = s * c2 + c * s2, c * c2 - s * s2
        t3, d3 = t * c2 + d * s2, d * c2 - t * s2
        odd, even, odd3, even3 = s / k, t / (k + 1), s3 / (k + 2), (t3 / (k + 3) if k + 3 < n else 0.0)
        first, second, third, fourth = cosines[k - 1], cosines[k], cosines[k + 1], cosines[min(k + 2, n - 2)]
        for j in range(half):
            scratch[0, j] += odd * first[j] + odd3 * third[j]
            scratch[1, j] += even * second[j] + even3 * fourth[j]
        s, c, t, d = s3 * c2 + c3 * s2, c3 * c2 - s3 * s2, t3 * c2 + d3 * s2, d3 * c2 - t3 * s2
    for j in range(half):
        weights[j] = scratch[1, j] + scratch[0, j]
        weights[n - 1 - j] = scratch[1, j] - scratch[0, j]


@njit(**OPTIONS)
def _phase(buffer, weights, noise, drift, a, b, x0, P, n, low, high, warp, fold, cosines, chords):
    """Phase of the start and a bound on its error; see ``initial_phase``. Leaves the weights of interpolation."""
    W = b - a
    x, y = (x0 - a) / W, (b - x0) / W
    end, tip = SAMPLES - 1, n - 1
    below, first = drift[0] / buffer[2, 0] + noise[0, 0] / (1.0 if chords else buffer[2, 0]), low[0]
    above, last = drift[end] / buffer[2, tip] + noise[0, end] / (1.0 if chords else buffer[2, tip]), high[tip]
    if fold == 2:
        above, last = below, first
    lower, upper = first * below, last * above
    δ = y * lower + x * upper
    if min(x, y) < _CLOSE:
        for _ in range(2):
            χ = _anomaly(x, y, warp)
            _interpolation(weights, fold * χ, n, cosines)
            r = dot(buffer[1], weights, n) / _pace(χ, warp)
            small = (P * r / W) ** 2 / max(x, y)
            x, y = (small, 1.0 - small) if x < y else (1.0 - small, small)
        δ = min(x * below, lower) if x < y else min(y * above, upper)
        δ += min(x, y) * (lower + upper)
    χ = _anomaly(x, y, warp)
    _interpolation(weights, fold * χ, n, cosines)
    small, large = min(x, y), max(x, y)
    doubt = (δ / np.sqrt(max(small, 1e-300)) + 4.0 * EPS * np.sqrt(small)) / np.sqrt(large) / _pace(χ, warp)
    return (-χ if P < 0 else χ), 2.0 * doubt + 8.0 * EPS * math.pi


@njit(**OPTIONS)
def _shifts(buffer, scratch, n, residue, E, i, rules, found):
    """Add to the bounds what small shifts of F do: constants 2 kⱼ δcⱼ and the residues; see ``nodes.shifts``.

    Below the middle F is seen from the lower turning point and has its residue, above it that of the upper one.
    """
    constants, (low, squares, slopes) = E.shape[0], rules
    for j in range(n):
        scratch[0, j] = squares[j] / buffer[2, j]
        scratch[1, j] = scratch[0, j] / buffer[1, j]
    for k in range(constants):
        row = buffer[3 + k]
        if residue[0] != 0.0 or residue[1] != 0.0:
            for j in range(n):
                scratch[2, j] = row[j] * scratch[0, j] * (residue[0] if low[j] <= 0.5 else residue[1])
            total = _swing(scratch[2], slopes, n)
            found[1, 1 + k] += total
            found[2, 1 + k] += 0.5 * total
        for m in range(k + 1):
            if E[m, i] != 0.0 or E[k, i] != 0.0:
                other = buffer[3 + m]
                for j in range(n):
                    scratch[2, j] = row[j] * other[j] * scratch[1, j]
                total = _swing(scratch[2], slopes, n)
                found[1, 1 + k] += 2.0 * E[m, i] * total
                found[2, 1 + k] += E[m, i] * total
                if m < k:
                    found[1, 1 + m] += 2.0 * E[k, i] * total
                    found[2, 1 + m] += E[k, i] * total


@njit(**REDUCING)
def _swing(g: Any, slopes: Any, n: int) -> float:
    """Σ |Δg| cot χ/π, from node to node."""
    total = 0.0
    for j in range(n - 1):
        total += abs(g[j + 1] - g[j]) * slopes[j]
    return total


def _samples(a, b, c, e, lanes, bounds, noise, drift, chords, kernels):
    """Rounding errors of F and of the kernels at a few places, and what the constants add to the first.

    The first of them is relative where F comes from chords. Returns F's rounding at either turning point, if so.
    """
    x, mask, base, offset = lanes[0], lanes[1], lanes[2], lanes[3]
    W, rows, below, above = b - a, noise.shape[0], 0.0, 0.0
    for g in range(SAMPLES):
        x[g], mask[g] = a + W * _PLACES[g], 1.0
        if kernels and not chords:
            x[_LANES + g], mask[_LANES + g] = x[g], 0.0
        base[g] = a if 2 * g < SAMPLES else b
        offset[g] = x[g] - base[g]
    if chords:
        x[SAMPLES], x[SAMPLES + 1], mask[SAMPLES], mask[SAMPLES + 1] = a, b, 0.0, 0.0
    doubts(bounds, x, mask, c, e)
    if chords:  # F less its rounding at the turning points, which shifts it as a constant does
        below = abs(bounds[rows, SAMPLES]) + bounds[0, SAMPLES]
        above = abs(bounds[rows, SAMPLES + 1]) + bounds[0, SAMPLES + 1]
        relative(bounds[rows], base, offset, c)
    for g in range(SAMPLES):
        for k in range(rows):
            noise[k, g] = bounds[k, g]
        drift[g] = 0.0
        if chords:
            noise[0, g], drift[g] = bounds[rows, g], bounds[0, g] + (below if 2 * g < SAMPLES else above)
            if 2 * g == SAMPLES + 1:  # the first place seen from above stands for those between it and the middle
                drift[g] = max(bounds[0, g - 1], bounds[0, g]) + above
        elif kernels:
            noise[0, g] = bounds[0, _LANES + g]
            drift[g] = bounds[0, g] - noise[0, g]
    return below, above


def orbits(chords, kernels, ripples, q, P, C, E, lower, upper, least, first, tables, results):
    """The integrals of one coordinate of many orbits; see ``compiled_pass.librations``.

    Args:
        chords, kernels, ripples: whether the formula is used as a slope, and whether ∂J/∂c and the running integrals
            are wanted.
        q, P: starts, shape (n,).
        C, E: constants and bounds on their errors, shape (constants, n).
        lower, upper: turning points, shape (n,).
        least, first: size in the tables and crowding to begin with, shape (n,); a negative size leaves the orbit out.
        tables: of the midpoint rules, as ``compiled_pass`` makes them.
        results: arrays filled here.
    """
    warps, counts, low, high, pace, last, middle, cosines, squares, slopes = tables
    (
        action, action_error, means, mean_errors, ripple, ripple_errors, phase, phase_error, speeds, good, chosen,
    ) = results  # fmt: skip
    constants, widest = C.shape[0], low.shape[2]
    rows = constants if kernels else 0
    buffer, weights, scratch = np.empty((3 + rows, widest)), np.empty(widest), np.empty((3, widest))
    width = 2 * _LANES if kernels and not chords else _LANES
    lanes, bounds = np.full((4, width), 0.5), np.empty((2 + rows, width))
    noise, drift, found = np.empty((1 + rows, SAMPLES)), np.empty(SAMPLES), np.empty((5, 1 + rows))
    for i in range(q.shape[0]):
        a, b = lower[i], upper[i]
        W = b - a
        if not W > 0.0 or least[i] < 0:
            continue
        c = pack(C, i)
        residue = _samples(a, b, c, pack(E, i), lanes, bounds, noise, drift, chords, kernels)
        size, warp = choose(
            buffer, weights, noise, drift, found, a, b, first[i], least[i], counts, low, high, pace, last, middle, c,
            chords, ripples,
        )  # fmt: skip
        if size < 0:
            continue
        chosen[0, i], chosen[1, i] = size, warp
        good[i], action[i], action_error[i] = True, found[0, 0], found[1, 0]
        n, fold = counts[size], 2 if warp >= _EVEN else 1
        if kernels:
            rules = low[warp, size], squares[fold - 1, size], slopes[fold - 1, size]
            _shifts(buffer, scratch, n, residue, E, i, rules, found)
            for k in range(constants):
                means[k, i], mean_errors[k, i] = found[0, 1 + k], found[1, 1 + k]
        if ripples:
            phase[i], phase_error[i] = _phase(
                buffer, weights, noise, drift, a, b, q[i], P[i], n, low[warp, size], high[warp, size], warps[warp],
                fold, cosines[size], chords,
            )  # fmt: skip
            for k in range(constants):
                speeds[k, i] = dot(buffer[3 + k], weights, n)
            _integration(weights, scratch, fold * phase[i], n, cosines[size])
            for k in range(constants):
                ripple[k, i] = 2.0 / (n * fold) * dot(buffer[3 + k], weights, n)
                ripple_errors[k, i] = 4.0 * found[2, 1 + k]


BOUND = (_samples, orbits)
"""See ``compiled_rule.BOUND``."""
