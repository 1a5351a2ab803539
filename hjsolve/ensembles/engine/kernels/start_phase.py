"""The anomaly of the start: χ of a place by an elliptic integral, or next to a turning point by the momentum there.

χ = π F(φ | k²)/K, F = sin φ R_F(cos²φ, 1 − k² sin²φ, 1), by duplication (Carlson, Numer. Algorithms 10 (1995) 13);
Halley's method then undoes the crowding of nodes. Next to a turning point a the place says little of its distance from
it, and q₀ − a = P₀²/((b − q₀) S) is used.
"""

from __future__ import annotations

import math

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.compiling import helper, inlined, reducing
from hjsolve.arithmetic.machine.elementary import sincos
from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.engine.kernels.midpoint_rule import dot
from hjsolve.ensembles.engine.kernels.types import Modes, Motions, Scratch, Tables

_CLOSE = 0.05  # part of the width, next to a turning point, where the momentum tells the phase better than the place


_ROUNDED = 4.0 * EPS  # of an interpolated value, in proportion to the sum of the sizes of its terms
_TAIL = 4e-15  # of r in proportion to its mean: coefficients that n nodes miss, as ``midpoint_rule.enough`` has them


@inlined
def moved_by_barrier_top(x: float, y: float, root: float, barrier_top: float) -> tuple[float, float, float]:
    """Take the middle to a crest, x/(1 − x) times ``barrier_top``: the Möbius map of ``nodes_about_barrier_tops``.

    Args:
        x, y: distances from one end and from the other over W, x + y = 1.
        root: |dx/dχ|.
        barrier_top: x/y where the middle is to be.
    """
    below = y + barrier_top * x
    return barrier_top * x / below, y / below, barrier_top / (below * below) * root


@inlined
def _derivative(χ: float, map_: Reals) -> float:
    s, c = sincos(χ)
    return 1.0 + map_[0] * c + map_[1] * (c * c - s * s)


@inlined
def stretch(χ: float, x: float, y: float, map_: Reals, barrier_top: float) -> float:
    """(dq/dχ)²/(W² x y)."""
    if map_[7] == 1.0:
        X, Y, size = _before_barrier_top(x, y, barrier_top)
        dn2 = map_[3] + (1.0 - map_[3]) * (Y - X) * (Y - X)
        return (2.0 * map_[2] / math.pi) ** 2 * dn2 * size * size / barrier_top
    derivative = _derivative(χ, map_)
    if map_[3] == 1.0:
        return derivative * derivative
    return (2.0 * map_[2] / math.pi * derivative) ** 2 * map_[3] * (1.0 + map_[5] * y) * (1.0 + map_[4] * x)


@helper
def elliptic(s: float, c: float, map_: Reals) -> float:
    """π F(φ | k²)/K, s = sin φ, c = cos φ ≥ 0: F = sin φ R_F(cos²φ, 1 − k² sin²φ, 1) (DLMF 19.25.5, 19.36.1)."""
    x, y, z = max(c * c, 1e-300), c * c + map_[3] * s * s, 1.0
    X, Y, A = 0.0, 0.0, 1.0
    # a duplication leaves R_F as it is, and divides the distances from the mean by 4
    for _ in range(64):
        λ = np.sqrt(x * y) + np.sqrt(y * z) + np.sqrt(z * x)
        x, y, z = 0.25 * (x + λ), 0.25 * (y + λ), 0.25 * (z + λ)
        A = (x + y + z) / 3.0
        X, Y = 1.0 - x / A, 1.0 - y / A
        if max(abs(X), abs(Y)) < 2e-3:  # the series left out terms of the order of X⁶, 6e-17
            break
    Z = -X - Y
    # DLMF 19.36.1 to the fifth order
    e2, e3 = X * Y - Z * Z, X * Y * Z
    R = (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / np.sqrt(A)
    return math.pi * s * R / map_[2]


@inlined
def _before_barrier_top(x: float, y: float, barrier_top: float) -> tuple[float, float, float]:
    """Undo ``moved_by_barrier_top``: X, Y = 1 − X, and x + crest y = crest/(Y + crest X)."""
    total = x + barrier_top * y
    return x / total, barrier_top * y / total, total


@helper
def anomaly(x: float, y: float, map_: Reals, barrier_top: float) -> float:
    """χ of a place. Halley's steps inside a bracket undo the crowding."""
    x, y = max(x, 0.0), max(y, 0.0)  # a start may lie beyond a turning point by its rounding
    if map_[7] == 1.0:  # X = (1 − cn)/2, cn of 2K χ/π
        X, Y, _ = _before_barrier_top(x, y, barrier_top)
        half = 0.5 * elliptic(2.0 * np.sqrt(X * Y), abs(Y - X), map_)
        return half if Y >= X else math.pi - half
    if map_[3] == 1.0:
        goal = 2.0 * math.atan2(np.sqrt(x), np.sqrt(y))
    else:
        sine, cosine = np.sqrt(x * (1.0 + map_[4])), np.sqrt(y)
        size = np.sqrt(sine * sine + cosine * cosine)
        goal = elliptic(sine / size, cosine / size, map_)
    γ, δ = map_[0], map_[1]
    if γ == 0.0 and δ == 0.0:
        return goal
    # f = χ + γ sin χ + ½ δ sin 2χ − goal rises, as crowding keeps dχ/du > 0: one zero in [0, π]
    low, high, χ = 0.0, math.pi, goal
    for _ in range(60):
        s, c = sincos(χ)
        f = χ + γ * s + δ * s * c - goal
        slope, bend = 1.0 + γ * c + δ * (c * c - s * s), -s * (γ + 4.0 * δ * c)
        if f <= 0.0:
            low = χ
        else:
            high = χ
        # Halley: f f′/(f′² − ½ f f″)
        new = χ - f * slope / (slope * slope - 0.5 * f * bend)
        inside = new >= low and new <= high
        if not inside:
            new = 0.5 * (low + high)
        if abs(new - χ) <= (1e-6 if inside else 4.0 * EPS) * abs(new):  # the error falls with its third power
            return new
        χ = new
    return χ


@reducing
def _total(x: Reals, n: int) -> float:
    total = 0.0
    for j in range(n):
        total += x[j]
    return total


@reducing
def _rounding_error(r: Reals, w: Reals, relative: Reals, n: int) -> float:
    """Bound the error of Σ w r, r = q′/√F, where the errors of F are known relatively."""
    total, mean = 0.0, 0.0
    for j in range(n):
        total += abs(r[j] * w[j]) * (_ROUNDED + 0.5 * relative[j])
        mean += r[j]
    return total + _TAIL * mean / n


@helper
def _interpolation(weights: Reals, χ: float, n: int, cosines: Reals) -> None:
    """Weights by which values at the nodes give that at χ: the barycentric formula (Berrut & Trefethen 2004, §5.2)."""
    place, nodes, signs = math.cos(χ), cosines[:n], cosines[(n - 2) * n :]
    for j in range(n):
        gap = place - nodes[j]
        # a place that is a node gets all the weight: 1e-30 stands for a gap of 0
        weights[j] = signs[j] / (gap if gap != 0.0 else 1e-30)
    total = _total(weights, n)
    for j in range(n):
        weights[j] /= total


@helper
def running_weights(weights: Reals, scratch: Reals, χ: float, n: int, cosines: Reals) -> None:
    """Weights of the running integral less its mean growth, Σ cos kχⱼ sin kχ/k; odd k are odd about χ = π/2.

    Args:
        weights: filled.
        scratch: two rows of the same length.
        χ: where the integral ends.
        n: number of nodes.
        cosines: of the nodes, rows of cos kχ, k = 1, 2, …
    """
    # four terms at a time, by the angle-addition formulas in steps of two: odd and even k apart, since
    # cos k(π − χ) = (−1)ᵏ cos kχ gives the upper half of the nodes from the lower one
    half, odds, evens = n // 2, scratch[0], scratch[1]
    s1, c1 = sincos(χ)
    s, c = s1, c1
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    t, d = s2, c2
    for j in range(half):
        odds[j], evens[j] = 0.0, 0.0
    for k in range(1, n - 2, 4):
        s3, c3 = s * c2 + c * s2, c * c2 - s * s2
        t3, d3 = t * c2 + d * s2, d * c2 - t * s2
        odd, even, odd3, even3 = s / k, t / (k + 1), s3 / (k + 2), (t3 / (k + 3) if k + 3 < n else 0.0)
        first, second = cosines[(k - 1) * n :], cosines[k * n :]
        third, fourth = cosines[(k + 1) * n :], cosines[min(k + 2, n - 2) * n :]
        for j in range(half):
            odds[j] += odd * first[j] + odd3 * third[j]
            evens[j] += even * second[j] + even3 * fourth[j]
        s, c, t, d = s3 * c2 + c3 * s2, c3 * c2 - s3 * s2, t3 * c2 + d3 * s2, d3 * c2 - t3 * s2
    back = weights[half:n]
    for j in range(half):
        weights[j] = evens[j] + odds[j]
    for j in range(half):
        back[j] = evens[half - 1 - j] - odds[half - 1 - j]


@helper
def phase(work: Scratch, motions: Motions, i: int, t: int, place: tuple[int, int], tables: Tables,
          modes: Modes) -> tuple[float, float]:  # fmt: skip
    """Phase of the start and a bound on its error; leaves the weights of interpolation in place of the errors of F.

    Args:
        work: F and r at the nodes, and their errors; in ``fractions`` those of F, relatively.
        motions: of n orbits.
        i: which one.
        t: its place in the block.
        place: map and size.
        tables: of nodes.
        modes: what is known of the rounding of F: nothing, where integrals are rough; with chords it is relative.
    """
    m, size = place
    map_, n, cosines, barrier_top = (
        tables.maps[m],
        tables.counts[size],
        tables.cosines[tables.rows[size] :],
        motions.barrier_top[i],
    )
    weights, buffer, relative, chords = work.fractions, work.buffer, work.rows[2], modes.chords
    for j in range(n):
        relative[j] = 0.0 if modes.approximate else weights[j]
    W, P, symmetry = motions.width[i], motions.momentum[i], map_[6]
    x, y = motions.left[i] / W, motions.right[i] / W
    end, tip, squares = tables.samples[motions.first[i]] - 1, n - 1, tables.squares[int(symmetry) - 1, size]
    low, high = tables.low[m, tables.first[size]], tables.high[m, tables.first[size] + tip]
    rounding = work.drift[t, 0] / squares[0] + work.noise[t, 0, 0] / (1.0 if chords else squares[0])
    blurred = work.drift[t, end] / squares[tip] + work.noise[t, 0, end] / (1.0 if chords else squares[tip])
    if symmetry == 2.0:  # the nodes go over one half of it, and the upper end is like the lower one
        blurred, high = rounding, low
    lower, upper = low * rounding, high * blurred
    δ = y * lower + x * upper
    near = min(x * (1.0 + map_[4]), y * (1.0 + map_[5]))
    if map_[7] == 1.0:
        low, _, _ = moved_by_barrier_top(low, 1.0 - low, 0.0, barrier_top)
        high, _, _ = moved_by_barrier_top(high, 1.0 - high, 0.0, 1.0 / barrier_top)
        lower, upper = low * rounding, high * blurred
        X, Y, _ = _before_barrier_top(max(x, 0.0), max(y, 0.0), barrier_top)
        near = min(X, Y)
    if near < _CLOSE:  # beyond, a pole or a crest makes p² flat: it tells no place
        by_x, by_y, vague = x, y, 0.0
        for _ in range(2 if map_[3] == 1.0 else 3):
            χ = anomaly(by_x, by_y, map_, barrier_top)
            _interpolation(weights, symmetry * χ, n, cosines)
            # P = √F with F = (q − a)(b − q) S, r and the map give S at χ: a fixed point, which few steps reach
            r = dot(buffer[1], weights, n)
            fraction = (P / W) ** 2 / stretch(χ, by_x, by_y, map_, barrier_top) / max(by_x, by_y)
            small = fraction * r * r
            by_x, by_y = (small, 1.0 - small) if by_x < by_y else (1.0 - small, small)
            # r at the far end of a wide motion may be 1e12 times as large, whose rounding is in what is interpolated
            rounding_error = _rounding_error(buffer[1], weights, relative, n)
            vague = fraction * rounding_error * (2.0 * abs(r) + rounding_error)
        by_momentum = min(by_x * rounding, lower) if by_x < by_y else min(by_y * blurred, upper)
        by_momentum += min(by_x, by_y) * (lower + upper) + vague
        if by_momentum < δ:
            x, y, δ = by_x, by_y, by_momentum
    χ = anomaly(x, y, map_, barrier_top)
    _interpolation(weights, symmetry * χ, n, cosines)
    small, large = max(min(x, y), 0.0), max(x, y)
    # δχ = δq/(dq/dχ), and dq/dχ vanishes with √(x y) at a turning point
    root = np.sqrt(max(stretch(χ, x, y, map_, barrier_top) * large, 1e-300))
    # χ grows like √x from the turning point, where δ may be all that is known of x
    uncertainty = (δ / np.sqrt(max(small, δ, 1e-300)) + 4.0 * EPS * np.sqrt(small)) / root
    return (-χ if P < 0 else χ), 2.0 * uncertainty + 8.0 * EPS * math.pi
