"""The loops of the compiled pass. Only imported where numba is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hjsolve.batch.elementary import OPTIONS, sincos
from hjsolve.batch.nodes import EVEN
from hjsolve.batch.programs import Programs

_EPS = 2.0**-52
_EVEN = EVEN
_SAMPLES = 5
_SAFETY = 1.5
_GOAL = 4e-16
_CLOSE = 0.05
_FIRST = 1
_MANY = 36.0
_TRIAL_SIZE = 3
_PLACES = tuple(0.5 - 0.5 * math.cos(math.pi * (g + 0.04) / (_SAMPLES - 1 + 0.08)) for g in range(_SAMPLES))
_REDUCING = OPTIONS | {"fastmath": {"contract", "reassoc"}}


@njit(**_REDUCING)
def _dot(x: Any, y: Any, count: int) -> float:
    """Σ x y; the order of summation is the compiler's."""
    total = 0.0
    for j in range(count):
        total += x[j] * y[j]
    return total


@njit(**_REDUCING)
def _moments(x: Any, count: int) -> tuple[float, float, float]:
    """Sum, sum of sizes, least value."""
    total, size, least = 0.0, 0.0, x[0]
    for j in range(count):
        total += x[j]
        size += abs(x[j])
        least = min(least, x[j])
    return total, size, least


@njit(**OPTIONS)
def _largest(rows: Any, x: Any, count: int) -> float:
    """Largest coefficient of the cosine series among some rows."""
    top = 0.0
    for k in range(rows.shape[0]):
        top = max(top, abs(_dot(rows[k], x, count)))
    return top * 2.0 / count


@njit(**OPTIONS)
def _pace(χ: float, warp: Any) -> float:
    return 1.0 + warp[0] * math.cos(χ) + warp[1] * math.cos(2.0 * χ)


@njit(**OPTIONS)
def _anomaly(x: float, y: float, warp: Any) -> float:
    """χ of a place; see ``phase._unwarped``."""
    goal = 2.0 * math.atan2(np.sqrt(max(x, 0.0)), np.sqrt(max(y, 0.0)))
    if warp[0] == 0.0 and warp[1] == 0.0:
        return goal
    low, high, χ = 0.0, math.pi, goal
    for _ in range(60):
        f = χ + warp[0] * math.sin(χ) + 0.5 * warp[1] * math.sin(2.0 * χ) - goal
        if f <= 0.0:
            low = χ
        else:
            high = χ
        new = χ - f / _pace(χ, warp)
        if not (new >= low and new <= high):
            new = 0.5 * (low + high)
        if abs(new - χ) <= 4.0 * _EPS * abs(new):
            return new
        χ = new
    return χ


@njit(**OPTIONS)
def _series(weights, χ, n, cosines, integral):
    """Rows 0 and 1: weights of the running integral (where wanted) and of interpolation."""
    for j in range(n):
        weights[0, j] = 0.0
        weights[1, j] = 1.0
    s1, c1 = sincos(χ)
    s, c = 0.0, 1.0
    for k in range(1, n):
        s, c = s * c1 + c * s1, c * c1 - s * s1
        row = cosines[k - 1]
        sine, cosine = s / k, 2.0 * c
        if integral:
            for j in range(n):
                weights[0, j] += sine * row[j]
                weights[1, j] += cosine * row[j]
        else:
            for j in range(n):
                weights[1, j] += cosine * row[j]


@njit(**OPTIONS)
def _running(buffer, weights, noise, drift, a, b, x0, P, n, low, high, warp, fold, cosines, chords):
    """Phase of the start and the weights of the running integral; see ``phase.librating``."""
    W = b - a
    x, y = (x0 - a) / W, (b - x0) / W
    end, tip = _SAMPLES - 1, n - 1
    below, first = drift[0] / buffer[2, 0] + noise[0, 0] / (1.0 if chords else buffer[2, 0]), low[0]
    above, last = drift[end] / buffer[2, tip] + noise[end, 0] / (1.0 if chords else buffer[2, tip]), high[tip]
    if fold == 2:
        above, last = below, first
    lower, upper = first * below, last * above
    δ = y * lower + x * upper
    if min(x, y) < _CLOSE:
        for _ in range(3):
            χ = _anomaly(x, y, warp)
            _series(weights, fold * χ, n, cosines, False)
            r = _dot(buffer[1], weights[1], n) / n / _pace(χ, warp)
            small = (P * r / W) ** 2 / max(x, y)
            x, y = (small, 1.0 - small) if x < y else (1.0 - small, small)
        δ = min(x * below, lower) if x < y else min(y * above, upper)
        δ += min(x, y) * (lower + upper)
    χ = _anomaly(x, y, warp)
    χ = -χ if P < 0 else χ
    _series(weights, fold * χ, n, cosines, True)
    small, large = min(x, y), max(x, y)
    doubt = (δ / np.sqrt(max(small, 1e-300)) + 4.0 * _EPS * np.sqrt(small)) / np.sqrt(large) / _pace(χ, warp)
    return χ, 2.0 * doubt + 8.0 * _EPS * math.pi


@njit(**OPTIONS)
def _shifts(buffer, scratch, n, residue, E, i, squares, slopes, found):
    """Add to the bounds what small shifts of F do: constants 2 kⱼ δcⱼ and the residue; see ``nodes.shifts``."""
    constants = E.shape[0]
    for j in range(n):
        scratch[0, j] = squares[j] / buffer[2, j]
    for k in range(constants):
        for j in range(n):
            scratch[1, j] = buffer[3 + k, j] * scratch[0, j]
        total = residue * _swing(scratch[1], slopes, n)
        for m in range(constants):
            if E[m, i] != 0.0:
                for j in range(n):
                    scratch[2, j] = scratch[1, j] * buffer[3 + m, j] / buffer[1, j]
                total += 2.0 * E[m, i] * _swing(scratch[2], slopes, n)
        found[1, 1 + k] += total
        found[2, 1 + k] += 0.5 * total


@njit(**_REDUCING)
def _swing(g: Any, slopes: Any, n: int) -> float:
    """Σ |Δg| cot χ/π, from node to node."""
    total = 0.0
    for j in range(n - 1):
        total += abs(g[j + 1] - g[j]) * slopes[j]
    return total


def kernel(made: Programs, kernels: bool, ripples: bool) -> Any:
    """Return the compiled loop over orbits of one coordinate."""
    samples = _samples_of(made, kernels)
    choose = _choice_of(_rule_of(made, kernels), ripples)
    pack, chords = made.pack, made.chords

    @njit(**OPTIONS)
    def loop(
        q, P, C, E, even_formula, warps, counts, low, high, pace, last, middle, cosines, squares, slopes,
        action, action_error, means, mean_errors, ripple, ripple_errors, phase, phase_error, speeds, good, lower, upper,
    ):  # fmt: skip
        constants = C.shape[0]
        widest = low.shape[2]
        buffer, weights, scratch = np.empty((3 + constants, widest)), np.empty((2, widest)), np.empty((3, widest))
        noise, drift = np.empty((_SAMPLES, 1 + constants)), np.empty(_SAMPLES)
        found = np.empty((4, 1 + constants))
        for i in range(q.shape[0]):
            a, b = lower[i], upper[i]
            W = b - a
            if not W > 0.0:
                continue
            c = pack(C, i)
            residue = samples(a, b, c, pack(E, i), noise, drift)
            first = _EVEN if even_formula and abs(a + b) <= 1e-13 * W else 0
            size, warp = choose(buffer, noise, drift, found, a, b, W, first, counts, low, high, pace, last, middle, c)
            if size < 0:
                continue
            good[i], action[i], action_error[i] = True, found[0, 0], found[1, 0]
            n, fold = counts[size], 2 if warp >= _EVEN else 1
            if kernels:
                _shifts(buffer, scratch, n, residue, E, i, squares[fold - 1, size], slopes[fold - 1, size], found)
                for k in range(constants):
                    means[k, i], mean_errors[k, i] = found[0, 1 + k], found[1, 1 + k]
            if ripples:
                phase[i], phase_error[i] = _running(
                    buffer, weights, noise, drift, a, b, q[i], P[i], n, low[warp, size], high[warp, size], warps[warp],
                    fold, cosines[size], chords,
                )  # fmt: skip
                for k in range(constants):
                    ripple[k, i] = 2.0 / (n * fold) * _dot(buffer[3 + k], weights[0], n)
                    speeds[k, i] = _dot(buffer[3 + k], weights[1], n) / n
                    ripple_errors[k, i] = 4.0 * found[2, 1 + k]

    return loop


def _samples_of(made: Programs, kernels: bool) -> Any:
    """Rounding errors of F and of the kernels at a few places, and what the constants add to the first.

    The first of them is relative where F comes from chords. Returns F's rounding at the turning points, if so.
    """
    doubts_of, pack, relative, value, chords = made.doubts, made.pack, made.relative, made.value, made.chords

    @njit(**OPTIONS)
    def samples(a, b, c, e, noise, drift):
        zeros, W, residue = pack(np.zeros((len(e), 1)), 0), b - a, 0.0
        if chords:  # F less its rounding at the turning points, which shifts it as a constant does
            residue = max(
                abs(value(a, c)[0]) + doubts_of(a, c, zeros)[0], abs(value(b, c)[0]) + doubts_of(b, c, zeros)[0]
            )
        for g in range(_SAMPLES):
            x = a + W * _PLACES[g]
            d = doubts_of(x, c, e)
            for k in range(len(d)):
                noise[g, k] = d[k]
            drift[g] = d[0] + residue
            if kernels and not chords:
                noise[g, 0] = doubts_of(x, c, zeros)[0]
                drift[g] = d[0] - noise[g, 0]
            if not kernels:
                drift[g] = 0.0
            if chords:
                noise[g, 0] = relative(a, x - a, c) if 2 * g < _SAMPLES else relative(b, x - b, c)
        return residue

    return samples


def _choice_of(rule: Any, ripples: bool) -> Any:
    """As many nodes as needed, crowded where that helps; size −1 where the tables do not suffice."""

    @njit(**OPTIONS)
    def choose(buffer, noise, drift, found, a, b, W, first, counts, low, high, pace, last, middle, c):
        size, warp = _FIRST, first
        for attempt in range(7):
            more = rule(
                buffer, noise, drift, found, a, b, W, size, counts, low[warp], high[warp], pace[warp], last, middle, c,
                ripples,
            )  # fmt: skip
            if more < 0:
                return size, warp
            if attempt == 0 and more > _MANY:
                least = 1e9
                for trial in range(first, first + (2 if first >= _EVEN else _EVEN)):
                    if trial == 2 or trial == 4:
                        continue
                    wish = rule(
                        buffer, noise, drift, found, a, b, W, _TRIAL_SIZE, counts, low[trial], high[trial],
                        pace[trial], last, middle, c, ripples,
                    )  # fmt: skip
                    if wish < least:
                        least, warp = wish, trial
                more, size = max(least, counts[_TRIAL_SIZE]), _TRIAL_SIZE - 1
            size += 1
            while size < counts.shape[0] and counts[size] < more:
                size += 1
            if size >= counts.shape[0]:
                break
        return -1, 0

    return choose


def _rule_of(made: Programs, kernels: bool) -> Any:
    """The midpoint rule of one size; see ``quadrature._rule``."""
    fill, chords = made.fill, made.chords
    rows = 1 if kernels else 0

    @njit(**OPTIONS)
    def rule(buffer, noise, drift, found, a, b, W, size, counts, low, high, pace, last, middle, c, ripples):
        n = counts[size]
        fill(buffer, a, b, W, low[size], high[size], pace[size], n, c)
        _, _, least = _moments(buffer[2], n)
        if not least > 0.0:
            return 2.0 * n
        integrands = 1 + rows * (buffer.shape[0] - 3)
        for k in range(integrands):
            found[3, k] = 0.0
        segment = n // (_SAMPLES - 1)
        for g in range(_SAMPLES - 1):
            start, stop = g * segment, n if g == _SAMPLES - 2 else (g + 1) * segment
            dF, dc = max(noise[g, 0], noise[g + 1, 0]), max(drift[g], drift[g + 1])
            plain, whole = 0.0, 0.0
            for j in range(start, stop):
                plain += buffer[1, j]
                whole += abs(buffer[0, j])
            found[3, 0] += 0.5 * ((dF * whole if chords else dF * plain) + dc * plain)
            for k in range(1, integrands):
                over = 0.0
                for j in range(start, stop):
                    over += abs(buffer[2 + k, j]) if chords else abs(buffer[2 + k, j]) / buffer[2, j]
                found[3, k] += 0.5 * dF * over + max(noise[g, k], noise[g + 1, k]) * plain
        more, wish = -1.0, math.log(1e-15 if ripples else 1e-8)
        for k in range(integrands):
            row = buffer[0] if k == 0 else buffer[2 + k]
            total, scale, _ = _moments(row, n)
            mean, scale = total / n, scale / n
            blur = _SAFETY * found[3, k] / n + 8.0 * _EPS * scale
            tail = _largest(last[size], row, n)
            half = _largest(middle[size], row, n)
            share = min(1.0, tail / max(half, 1e-300))
            alias = 4.0 * tail * share * np.sqrt(share)
            found[0, k], found[1, k], found[2, k] = mean, blur + alias, 0.5 * blur + tail
            fits = alias <= max(_GOAL * scale, 0.25 * blur) or tail <= 0.5 * blur
            if ripples:
                fits = fits and tail <= max(4e-15 * scale, blur)
            if not fits and scale != 0.0:
                excess = min(max(tail, 1e-300) / scale, 0.5)
                more = max(more, min(max(2.0 + (n - 2.0) * wish / math.log(excess), n + 1.0), 3.0 * n))
            if not math.isfinite(mean):
                more = 2.0 * n
        return more

    return rule
