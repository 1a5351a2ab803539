"""The midpoint rule of the compiled pass: how many nodes, and where they crowd. Only imported where numba is.

A rule that cannot be enough is told from its last coefficients alone. These say two more things. How fast they fall
tells how many nodes would do. And a singularity of the integrand beside χ = φ gives coefficients like ρᵏ cos(kφ + θ)
(Darboux), so from one to the next they show where it is, and which crowding of the nodes serves (``nodes.WARPS``).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from hjsolve.arithmetic.floats import EPS
from hjsolve.ensembles.engine.elementary import OPTIONS
from hjsolve.ensembles.engine.nodes import EVEN

SAMPLES = 5
REDUCING = OPTIONS | {"fastmath": {"contract", "reassoc"}}
_EVEN = EVEN
_SAFETY = 1.5
_GOAL = 4e-16
_TRIES = 6
_MANY = 44.0
_GAIN = 0.6
_LEAST = 32.0
_STEEP = 0.75
_ROUGH = 1e-5
_RIPPLED = 1e-9

fill: Any = None
"""Of the program; see ``programs``."""


@njit(**REDUCING)
def dot(x: Any, y: Any, count: int) -> float:
    """Σ x y; the order of summation is the compiler's.

    Args:
        x, y: at least ``count`` doubles.
        count: how many are used.
    """
    total = 0.0
    for j in range(count):
        total += x[j] * y[j]
    return total


@njit(**REDUCING)
def _coefficients(rows, x, n):
    """Sum, sum of sizes, and n/2 times the last five coefficients of the cosine series."""
    total, size, p, q, r, s, t = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        v = x[j]
        total += v
        size += abs(v)
        p += rows[0, j] * v
        q += rows[1, j] * v
        r += rows[2, j] * v
        s += rows[3, j] * v
        t += rows[4, j] * v
    return total, size, (p, q, r, s, t)


@njit(**REDUCING)
def _middle(rows, x, n):
    """Size of the largest of three coefficients in the middle of the series."""
    p, q, r = 0.0, 0.0, 0.0
    for j in range(n):
        v = x[j]
        p += rows[0, j] * v
        q += rows[1, j] * v
        r += rows[2, j] * v
    return 2.0 / n * max(abs(p), abs(q), abs(r))


@njit(**REDUCING)
def _between(x, start, stop):
    total = 0.0
    for j in range(start, stop):
        total += x[j]
    return total


@njit(**REDUCING)
def _weighted(x, y, n):
    """Σ x |y|."""
    total = 0.0
    for j in range(n):
        total += x[j] * abs(y[j])
    return total


@njit(**OPTIONS)
def _needed(last, scale, n, wish):
    """How many nodes bring the last coefficients down to ``wish``: they fall geometrically."""
    late, early = max(abs(last[3]), abs(last[4])), max(abs(last[0]), abs(last[1]))
    excess = max(2.0 / n * late, 1e-300) / scale
    if late < _STEEP * early:
        more = n + 3.0 * math.log(wish / excess) / math.log(max(late / early, 1e-9))
    else:
        more = min(2.0 + (n - 2.0) * math.log(wish) / math.log(min(excess, 0.5)), 3.0 * n)
    return min(max(more, n + 1.0), 8.0 * n)


@njit(**OPTIONS)
def _crowding(last, first):
    """The crowding for a singularity beside χ = φ; cos φ and cos 2φ from correlations of the last coefficients."""
    late, early = max(abs(last[3]), abs(last[4])), max(abs(last[0]), abs(last[1]))
    fall = (late / early) ** (1.0 / 3.0) if early > 0.0 else 1.0
    p, q, r, s, t = last[0], last[1] / fall, last[2] / fall**2, last[3] / fall**3, last[4] / fall**4
    squares = p * p + q * q + r * r + s * s + t * t
    once, twice = 1.25 * (p * q + q * r + r * s + s * t) / squares, 5.0 / 3.0 * (p * r + q * s + r * t) / squares
    if first >= _EVEN:
        return first + 1 if once < -0.4 else first + 2 if once > 0.4 else first
    if abs(once) < 0.35:
        return 3 if twice < -0.3 else first
    return (1 if once > 0.8 else 2) if once > 0.0 else (5 if once < -0.8 else 4)


@njit(**OPTIONS)
def _blurs(buffer, shares, noise, drift, n, integrands, chords, found):
    """Write n times what the rounding errors of F and of the kernels do to the means into ``found[3]``."""
    found[3, :integrands] = 0.0
    segment = n // (SAMPLES - 1)
    for g in range(SAMPLES - 1):
        start, stop = g * segment, n if g == SAMPLES - 2 else (g + 1) * segment
        plain, own = _between(buffer[1], start, stop), max(noise[0, g], noise[0, g + 1])
        shares[start:stop] = own
        found[3, 0] += 0.5 * ((0.0 if chords else own) + max(drift[g], drift[g + 1])) * plain
        for k in range(1, integrands):
            found[3, k] += max(noise[k, g], noise[k, g + 1]) * plain
    if chords:
        found[3, 0] += 0.5 * _weighted(shares, buffer[0], n)
    elif integrands > 1:
        for j in range(n):
            shares[j] /= buffer[2, j]
    for k in range(1, integrands):
        found[3, k] += 0.5 * _weighted(shares, buffer[2 + k], n)


def _rule(buffer, shares, noise, drift, found, a, b, n, low, high, pace, last, middle, c, chords, ripples, first):
    """The rule of one size; see ``midpoint_rule._rule``. How many nodes are needed (−1: these do), and where."""
    fill(buffer, a, b, b - a, low, high, pace, n, c)
    integrands = buffer.shape[0] - 2
    rough, wish = (_RIPPLED, 2e-15) if ripples else (_ROUGH, 1e-8)
    more, warp = -1.0, first
    for k in range(integrands):
        total, scale, ends = _coefficients(last, buffer[0] if k == 0 else buffer[2 + k], n)
        if not math.isfinite(total):  # F ≤ 0 somewhere
            return 2.0 * n, first
        tail = 2.0 / n * max(abs(ends[0]), abs(ends[1]), abs(ends[2]), abs(ends[3]), abs(ends[4]))
        found[0, k], found[1, k], found[2, k], found[4, k] = total / n, scale / n, tail, 0.0
        if tail > 0.0 and scale > 0.0:
            found[4, k] = _needed(ends, scale / n, n, wish)
        if tail > rough * (scale / n) and found[4, k] > more:
            more, warp = found[4, k], _crowding(ends, first)
    if more > 0.0:
        return more, warp
    _blurs(buffer, shares, noise, drift, n, integrands, chords, found)
    for k in range(integrands):
        scale, tail = found[1, k], found[2, k]
        blur = _SAFETY * found[3, k] / n + 8.0 * EPS * scale
        half = _middle(middle, buffer[0] if k == 0 else buffer[2 + k], n)
        share = min(1.0, tail / max(half, 1e-300))
        alias = 4.0 * tail * share * np.sqrt(share)
        found[1, k], found[2, k] = blur + alias, 0.5 * blur + tail
        fits = alias <= max(_GOAL * scale, 0.25 * blur) or tail <= 0.5 * blur
        if ripples:
            fits = fits and tail <= max(4e-15 * scale, blur)
        if not fits and scale != 0.0:
            more = max(more, found[4, k])
    return more, warp


def choose(
    buffer, shares, noise, drift, found, a, b, first, size, counts, low, high, pace, last, middle, c, chords, ripples,
):  # fmt: skip
    """As many nodes as needed, from ``size`` on, crowded where that helps; −1 where the tables do not suffice.

    Args:
        buffer, shares: scratch for the integrands at the nodes, shape (integrands + 2, nodes) and (nodes,).
        noise, drift: errors of F and of the kernels at ``SAMPLES`` places between the turning points.
        found: the means, their errors, last coefficients, rounding errors and wanted numbers of nodes, filled here,
            shape (5, integrands).
        a, b: turning points.
        first, size: crowding and place in the tables to begin with.
        counts, low, high, pace, last, middle: tables of nodes, by crowding and size; see ``nodes.Nodes``.
        c: constants of the orbit.
        chords: whether the formula gives slopes of p² from the turning points.
        ripples: whether running integrals are wanted besides means.
    """
    warp = first
    for attempt in range(_TRIES):
        more, crowded = _rule(
            buffer, shares, noise, drift, found, a, b, counts[size], low[warp, size], high[warp, size],
            pace[warp, size], last[size], middle[size], c, chords, ripples, first,
        )  # fmt: skip
        if more < 0.0:
            return size, warp
        size += 1
        if size >= counts.shape[0]:
            break
        if attempt == 0 and more > _MANY and crowded != first:
            warp, more = crowded, max(_LEAST, _GAIN * more)
        while size + 1 < counts.shape[0] and counts[size] < more:
            size += 1
    return -1, 0


BOUND = (_rule, choose)
"""Functions that are compiled anew beside each program, whose functions are global names to them."""
