"""The loops of the compiled pass. Only imported where numba is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hjsolve.batch.elementary import OPTIONS, sincos
from hjsolve.batch.programs import Programs

_EPS = 2.0**-52
_SAMPLES = 5
_SAFETY = 1.5
_GOAL = 4e-16
_CLOSE = 0.05
_MANY = 36.0
_TRIALS = (0, 1, 3, 5)
_TRIAL_SIZE = 3
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
def _first_step(P: float, outward: float, bend: float, size: float) -> float:
    """See ``roots.first_step``."""
    square = P * P
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    down = (outward + root) / (-2.0 * bend) if outward > 0 else 2.0 * square / (root - outward)
    if math.isfinite(down) and down > 0:
        return min(1.0625 * down, size)
    crude = -square / outward if outward < 0 else size
    return min(0.25 * size, crude) if crude > 0 else 0.25 * size


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


def kernel(made: Programs, kernels: bool, ripples: bool) -> Any:
    """Return the compiled loop over orbits of one coordinate."""
    end = _end_of(made)
    rule = _rule_of(made, kernels)
    running = _running_of(made)
    bend_of, pack, doubts_of = made.bend, made.pack, made.doubts

    @njit(**OPTIONS)
    def loop(
        q, P, C, E, floor, ceiling, reach, warps, counts, low, high, pace, last, middle, cosines,
        action, action_error, means, mean_errors, ripple, ripple_errors, phase, phase_error, speeds, good, lower, upper,
    ) -> None:  # fmt: skip
        constants = C.shape[0]
        buffer = np.empty((3 + constants, low.shape[2]))
        noise, drift = np.empty((_SAMPLES, 1 + constants)), np.empty(_SAMPLES)
        found = np.empty((4, 1 + constants))
        weights = np.empty((3, low.shape[2]))
        guess = 1
        zeros = pack(np.zeros((constants, 1)), 0)
        for i in range(q.shape[0]):
            x0, P0 = q[i], P[i]
            c, e = pack(C, i), pack(E, i)
            _, first, second = bend_of(x0, c)
            if not (math.isfinite(first) and P0 != 0.0 and x0 > floor and x0 < ceiling):
                continue
            length = min(abs(x0) if x0 != 0.0 else 1.0, reach)
            a = end(x0, P0, -first, 0.5 * second, -1.0, min(length, x0 - floor), floor, reach, c)
            b = end(x0, P0, first, 0.5 * second, 1.0, min(length, ceiling - x0), ceiling, reach, c)
            W = b - a
            if not W > 0.0:
                continue
            for g in range(_SAMPLES):
                x = a + W * (0.5 - 0.5 * math.cos(math.pi * (g + 0.04) / (_SAMPLES - 1 + 0.08)))
                d = doubts_of(x, c, e)
                own = doubts_of(x, c, zeros)
                for k in range(len(d)):
                    noise[g, k] = d[k]
                drift[g] = d[0] - own[0]
                noise[g, 0] = own[0]
            size, warp = guess, 0
            for attempt in range(7):
                more = rule(
                    buffer, noise, drift, found, a, b, W, size, counts, low[warp], high[warp], pace[warp], last, middle,
                    c, ripples,
                )  # fmt: skip
                if more < 0:
                    break
                if attempt == 0 and more > _MANY:
                    least = 1e9
                    for trial in _TRIALS:
                        wish = rule(
                            buffer, noise, drift, found, a, b, W, _TRIAL_SIZE, counts, low[trial], high[trial],
                            pace[trial], last, middle, c, ripples,
                        )  # fmt: skip
                        if wish < least:
                            least, warp = wish, trial
                    more = max(least, counts[_TRIAL_SIZE])
                    size = _TRIAL_SIZE - 1
                bigger = size + 1
                while bigger < counts.shape[0] and counts[bigger] < more:
                    bigger += 1
                size = bigger
                if size >= counts.shape[0]:
                    more = 1
                    break
            if more >= 0:
                continue
            good[i], lower[i], upper[i] = True, a, b
            action[i], action_error[i] = found[0, 0], found[1, 0]
            if kernels:
                for k in range(constants):
                    means[k, i], mean_errors[k, i] = found[0, 1 + k], found[1, 1 + k]
            if ripples:
                n = counts[size]
                χ, blur = running(buffer, weights, noise, drift, a, b, W, x0, P0, n, low[warp, size], high[warp, size], pace[warp, size], warps[warp], cosines[size])
                phase[i], phase_error[i] = χ, blur
                for k in range(constants):
                    ripple[k, i] = 2.0 / n * _dot(buffer[3 + k], weights[0], n)
                    speeds[k, i] = _dot(buffer[3 + k], weights[1], n) / n
                    ripple_errors[k, i] = 4.0 * found[2, 1 + k]

    return loop


def _end_of(made: Programs) -> Any:
    """Turning point on one side: steps outward, then Newton's method inside the bracket."""
    value, slope = made.value, made.slope

    @njit(**OPTIONS)
    def end(x0, P, outward, bend, side, size, floor, reach, c) -> float:  # type: ignore[no-untyped-def]
        step = _first_step(P, outward, bend, size)
        inner, outer = x0, np.nan
        for _ in range(48):
            x = inner + side * step
            if side * (x - floor) > -0.25 * side * (floor - inner):
                x = floor + 0.25 * (inner - floor)
            f = value(x, c)[0]
            if f < 0.0:
                outer = x
                break
            if f >= 0.0:
                inner = x
                step *= 1.6
                if abs(x - x0) > reach:
                    break
            else:
                step *= 0.25
        if not math.isfinite(outer):
            return np.nan
        x = outer
        for _ in range(60):
            f, d = slope(x, c)
            if f >= 0.0:
                inner = x
            else:
                outer = x
            new = x - f / d
            if not (new - inner) * (new - outer) <= 0.0:
                new = 0.5 * (inner + outer)
            if abs(new - x) <= 1e-9 * abs(new) and abs(new - x) <= 1e-6 * abs(new - x0):
                f, d = slope(new, c)
                last = new - f / d
                return last if abs(last - new) <= 1e-8 * abs(new) else new
            if abs(new - x) <= 8.0 * _EPS * max(abs(new), abs(x0)):
                return new
            x = new
        return np.nan

    return end


def _rule_of(made: Programs, kernels: bool) -> Any:
    """The midpoint rule of one size; see ``quadrature._rule``."""
    fill = made.fill
    rows = 1 if kernels else 0

    @njit(**OPTIONS)
    def rule(buffer, noise, drift, found, a, b, W, size, counts, low, high, pace, last, middle, c, ripples) -> float:  # type: ignore[no-untyped-def]
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
            plain, over, damped = 0.0, 0.0, 0.0
            for j in range(start, stop):
                plain += buffer[1, j]
            found[3, 0] += 0.5 * (dF + dc) * plain
            for k in range(1, integrands):
                over, damped = 0.0, 0.0
                for j in range(start, stop):
                    share = abs(buffer[2 + k, j]) / buffer[2, j]
                    over += share
                    damped += share * low[size, j] * high[size, j]
                found[3, k] += 0.5 * dF * over + 2.0 * dc * damped + max(noise[g, k], noise[g + 1, k]) * plain
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


def _running_of(made: Programs) -> Any:  # noqa: ARG001  (one compiled function a system, like the others)
    """Phase of the start and the weights of the running integral; see ``phase`` and ``quadrature._running``."""

    @njit(**OPTIONS)
    def series(weights, χ, n, cosines, integral) -> None:  # type: ignore[no-untyped-def]
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
    def running(buffer, weights, noise, drift, a, b, W, x0, P, n, low, high, pace, warp, cosines) -> tuple[float, float]:  # type: ignore[no-untyped-def]
        x, y = (x0 - a) / W, (b - x0) / W
        shake = 0.0
        for g in range(_SAMPLES):
            j = min(n - 1, g * n // (_SAMPLES - 1))
            shake = max(shake, (noise[g, 0] + drift[g]) / buffer[2, j] * low[j] * high[j])
        if min(x, y) < _CLOSE:
            for _ in range(3):
                χ = _anomaly(x, y, warp)
                series(weights, χ, n, cosines, False)
                r = _dot(buffer[1], weights[1], n) / n / _pace(χ, warp)
                small = (P * r / W) ** 2 / max(x, y)
                x, y = (small, 1.0 - small) if x < y else (1.0 - small, small)
        χ = _anomaly(x, y, warp)
        χ = -χ if P < 0 else χ
        series(weights, χ, n, cosines, True)
        shake /= _pace(χ, warp)
        return χ, 2.0 * ((shake + 4.0 * _EPS) / np.sqrt(max(x * y, _CLOSE / 2)) + 4.0 * _EPS * math.pi)

    return running
