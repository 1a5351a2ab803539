"""Lambert's problem in doubles: every conic through two places in a time, with all turns and in both directions.

With the chord c, s = (r₀ + r₁ + c)/2, the sweep angle θ ∈ [0, 2π) of the last turn and λ = √(r₀ r₁) cos(θ/2)/s, so that
1 − λ² = c/s, a conic of semimajor axis a takes the time

    √(2μ/s³) t = T(x) = [(ψ + Nπ)/√u − x + λ y]/u,   u = 1 − x² = s/(2a),   y = √(1 − λ² u),   sin ψ = (y − λ x) √u

(Lancaster and Blanchard, NASA TN D-5368, 1969; Izzo, Celestial Mechanics and Dynamical Astronomy 121 (2015) 1, (18)).
T falls from ∞ to 0 on x > −1 for N = 0, and for N ≥ 1 it is ∞ at both ends of −1 < x < 1 with one minimum between: so
there is one conic with no full turn for each way round, and there are two, one (at the minimum) or none with N.

x itself is not kept: w = 1 + x and v = 1 − x are, the smaller of the two to full accuracy, so that u = w v is right
next to the ends. Differences are written as in Gooding, Celestial Mechanics 48 (1990) 145: none of near-equal numbers
is left but where the orbit is nearly parabolic, and there T is Battin's series in S = sin²(ψ/2).
"""

from __future__ import annotations

from math import asinh, atan2, inf, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.compiling import helper, kernel
from hjsolve.arithmetic.number_types import Integers, Mask, Reals

_SERIES_REACH = 0.3
"""Up to which |S| Battin's series serves."""
_TERMS = 60
"""Terms of it at most: 0.3⁶⁰ is far below half an ulp of the sum."""
_NEWTON_STEPS = 100
_LEAST = 1e-10
"""How far x may be from the minimum of T, which is then right to 10⁻²⁰ of itself."""
_ROUNDING = 12.0 * EPS
"""Rounding of T in units of the size of its terms: a test finds 4 at most against 40 digits."""


@helper
def _sums(λ: float, k: float, w: float, v: float) -> tuple[float, float, float, float, float]:
    """η = y − λx, y, S = sin²(ψ/2), u and x − λy, without differences of near-equal numbers; k = 1 − λ²."""
    x = w - 1 if w < v else 1 - v
    u, product = w * v, λ * x
    y = sqrt(k + product * product)  # 1 − λ²u = (1 − λ²) + λ²x²
    η, rest = y - product, x - λ * y
    if product > 0:
        # (y − λx)(y + λx) = 1 − λ²,   (x − λy)(x + λy) = (1 − λ²)(x² − λ²u)
        η, rest = k / (y + product), k * (x * x - λ * λ * u) / (x + λ * y)
    g = x * y + λ * u  # cos ψ
    if x * y * λ * u < 0:
        g = (x * x - λ * λ * u) / (x * y - λ * u)
    S = η * η * u / (2 * (1 + g)) if g > 0 else (1 - g) / 2
    return η, y, S, u, rest


@helper
def _battin(S: float) -> tuple[float, float]:
    """F = 4/3 ₂F₁(3, 1; 5/2; S) and F′ for |S| ≤ 0.3."""
    value, slope, c, power = 4 / 3, 0.0, 4 / 3, 1.0
    for j in range(_TERMS):
        c *= (3 + j) / (2.5 + j)
        slope += (j + 1) * c * power
        power *= S
        value += c * power
        if abs(c * power) <= EPS / 16 and j > 2:
            break
    return value, slope


@helper
def time_at(λ: float, k: float, N: int, w: float, v: float) -> tuple[float, float, float]:
    """Return T, T′ and the rounding of T.

    Args:
        λ, k: of the transfer; k = 1 − λ².
        N: full turns; where it is not 0, w and v are both positive.
        w, v: 1 + x and 1 − x.
    """
    η, y, S, u, rest = _sums(λ, k, w, v)
    if N == 0 and abs(S) <= _SERIES_REACH:
        F, bend = _battin(S)
        cube = η * η * η
        size = (cube * F + 4 * abs(λ) * η) / 2
        if y == 0:
            return size, -inf, _ROUNDING * size
        turning = -λ * η / y
        slope = (3 * η * η * turning * F - cube * η * η * bend / (2 * y) + 4 * λ * turning) / 2
        return (cube * F + 4 * λ * η) / 2, slope, _ROUNDING * size
    x, root = (w - 1 if w < v else 1 - v), sqrt(abs(u))
    ψ = atan2(η * root, 1 - 2 * S) if u >= 0 else asinh(η * root)
    angle = (ψ + N * pi) / root
    T = (angle - rest) / u
    bend = 2 * λ * λ * λ * x / y if y > 0 else 0.0
    return T, (3 * T * x - 2 + bend) / u, _ROUNDING * (abs(angle) + abs(rest)) / abs(u)


@helper
def _bend(λ: float, k: float, N: int, w: float, v: float) -> float:
    """T″: (1 − x²) T″ = 3T + 5x T′ + 2(1 − λ²) λ³/y³ (Izzo (22))."""
    T, slope, _ = time_at(λ, k, N, w, v)
    _, y, _, u, _ = _sums(λ, k, w, v)
    x = w - 1 if w < v else 1 - v
    last = 2 * k * λ * λ * λ / (y * y * y) if y > 0 else 0.0
    return (3 * T + 5 * x * slope + last) / u


@helper
def _minimum(λ: float, k: float, N: int) -> float:
    """Where T is least for N ≥ 1: Newton's method on T′ in a bracket."""
    x, low, high = 0.0, -1.0, 1.0
    for count in range(_NEWTON_STEPS):
        _, slope, _ = time_at(λ, k, N, 1 + x, 1 - x)
        if slope == 0:
            break
        if slope < 0:
            low = x
        else:
            high = x
        bend = _bend(λ, k, N, 1 + x, 1 - x)
        new = x - slope / bend if bend > 0 else low
        if not low < new < high or count % 10 == 9:
            new = (low + high) / 2
        moved, x = abs(new - x), new
        if moved <= _LEAST:
            break
    return x


@helper
def _first(λ: float, k: float, W: float, N: int, side: int) -> float:
    """Izzo's first guesses (29)–(31) as 1 + x; as 1 − x on the upper branch of N ≥ 1."""
    if side != 0:
        ratio = (8 * W / (N * pi)) ** (2 / 3) if side > 0 else ((N + 1) * pi / (8 * W)) ** (2 / 3)
        return 2 * ratio / (1 + ratio) if side < 0 else 2 / (1 + ratio)
    minus = k / (1 + λ) if λ > 0 else 1 - λ  # 1 − λ
    T0 = atan2(sqrt(k), λ) + λ * sqrt(k)
    T1 = 2 / 3 * minus * (1 + λ + λ * λ)
    if W >= T0 or T1 <= 0:
        return (T0 / W) ** (2 / 3)
    if W < T1:
        return 2 + 2.5 * T1 * (T1 - W) / (W * minus * (1 + λ + λ * λ * (1 + λ + λ * λ)))
    return (W / T0) ** (log(2.0) / log(T1 / T0))


@helper
def _middle(low: float, high: float) -> float:
    """Return the middle of a bracket of 1 + x or 1 − x, in the logarithm."""
    if high == inf:
        return max(4.0, 2 * low)
    return sqrt(max(low, 1e-3 * high) * high)


@helper
def _root(λ: float, k: float, W: float, N: int, side: int, end: float) -> tuple[float, float, float, float]:
    """Solve T(x) = W: 1 + x, 1 − x, the error of x, and T′.

    The unknown z is 1 + x, on the upper branch of N ≥ 1 (``side`` 1) 1 − x; T falls with it from ∞ at z = 0, up to
    ``end``, where T is least.
    """
    z, low, high = _first(λ, k, W, N, side), 0.0, end
    if side != 0:
        least, _, _ = time_at(λ, k, N, 1 + (end - 1), 2 - end) if side < 0 else time_at(λ, k, N, 2 - end, end)
        if least * 1.3 > W:  # the parabola of T at its minimum
            bend = _bend(λ, k, N, end, 2 - end) if side < 0 else _bend(λ, k, N, 2 - end, end)
            guess = end - sqrt(2 * (W - least) / bend) if bend > 0 else -1.0
            z = guess if guess > 0 else z
    slope, rounding, miss = -inf, 0.0, 0.0
    for count in range(_NEWTON_STEPS):
        if not low < z < high:
            z = _middle(low, high)
        w, v = (z, 2 - z) if side <= 0 else (2 - z, z)
        T, slope, rounding = time_at(λ, k, N, w, v)
        miss = T - W
        slope = slope if side <= 0 else -slope
        if miss > 0:
            low = z
        else:
            high = z
        if T <= 0:  # the same place: x > 0 takes no time
            z = _middle(low, high)
            continue
        if abs(miss) <= rounding / 4 + EPS * W or slope == 0:
            break
        # T^(−2/3) is nearly linear in z next to 0, and 1/T where the orbit is fast
        power = 1.0 if z > 2 and side == 0 else 2 / 3
        step = T * (1 - (T / W) ** power) / (power * slope)
        if abs(step) <= EPS * z:
            break
        z = z + step if count % 8 != 7 and step == step else _middle(low, high)
        if high - low <= EPS * low:
            break
    w, v = (z, 2 - z) if side <= 0 else (2 - z, z)
    error = (rounding + abs(miss) + EPS * W) / abs(slope) if slope != 0 else inf
    return w, v, error, slope if side <= 0 else -slope


@helper
def _write(table: Reals, i: int, j: int, found: tuple[float, float, float, float, float, float]) -> None:
    """Fill one row: w, v, the error of x, T′, the upper branch or not, y, x − λy, x + λy and y + λx."""
    λ, k, w, v, error, slope = found
    _, y, _, u, rest = _sums(λ, k, w, v)
    x = w - 1 if w < v else 1 - v
    plus, across = x + λ * y, y + λ * x
    if λ * x < 0:
        plus, across = k * (x * x - λ * λ * u) / (x - λ * y), k / (y - λ * x)
    row = table[i, j]
    row[0], row[1], row[2], row[3], row[4] = w, v, error, slope, j
    row[5], row[6], row[7], row[8] = y, rest, plus, across


@kernel
def _fill(λs: Reals, ks: Reals, Ws: Reals, turns: Integers, counts: Integers, table: Reals, least: Reals) -> None:
    """Solve problem after problem: how many conics, and rows of up to two of each."""
    for i in range(len(λs)):
        λ, k, W, N = λs[i], ks[i], Ws[i], turns[i]
        counts[i] = 0
        least[i] = 0.0
        if N == 0:
            if W > 0:
                counts[i] = 1
                w, v, error, slope = _root(λ, k, W, N, 0, inf)
                _write(table, i, 0, (λ, k, w, v, error, slope))
            continue
        x = _minimum(λ, k, N)
        lowest, _, rounding = time_at(λ, k, N, 1 + x, 1 - x)
        least[i] = lowest
        uncertainty = rounding + 4 * EPS * lowest
        if lowest + uncertainty < W:
            counts[i] = 2
            for j in range(2):
                side = 2 * j - 1
                end = 1 + x if side < 0 else 1 - x
                w, v, error, slope = _root(λ, k, W, N, side, end)
                _write(table, i, j, (λ, k, w, v, error, slope))
        elif lowest - uncertainty <= W:  # at the minimum: x is known to the root of the rounding
            counts[i] = 1
            bend = _bend(λ, k, N, 1 + x, 1 - x)
            _write(table, i, 0, (λ, k, 1 + x, 1 - x, sqrt(4 * uncertainty / bend), 0.0))


class Transfer(NamedTuple):
    """CentralPlaces of transfers, arrays of one shape: λ and 1 − λ² to full relative accuracy, the chord c, and s."""

    λ: Reals
    complement: Reals
    chord: Reals
    s: Reals


class Conics(NamedTuple):
    """Conics found, arrays over those found.

    Attributes:
        problem: index into the arrays asked.
        turns: N, full turns before the last one.
        w, v: 1 + x and 1 − x.
        error: of x.
        slope: T′(x).
        upper: for N ≥ 1, whether x is above the minimum of T.
        y, rest, plus, across: y, x − λy, x + λy, y + λx, without differences of near-equal numbers.
    """

    problem: Integers
    turns: Integers
    w: Reals
    v: Reals
    error: Reals
    slope: Reals
    upper: Mask
    y: Reals
    rest: Reals
    plus: Reals
    across: Reals


def transfer(r0: Reals, r1: Reals, half_sine: Reals, half_cosine: Reals) -> Transfer:
    """Return the geometry of transfers.

    Args:
        r0, r1: distances from the centre, > 0.
        half_sine, half_cosine: sin(θ/2) ≥ 0 and cos(θ/2) of the sweep angle.
    """
    mean = np.sqrt(r0) * np.sqrt(r1)
    c = np.hypot(r0 - r1, 2 * mean * half_sine)
    s = (r0 + r1 + c) / 2
    return Transfer(mean * half_cosine / s, c / s, c, s)


def conics(path: Transfer, wanted: Reals, turns: Integers) -> tuple[Conics, Reals]:
    """Return every conic with the counts of turns asked, and the least T of each problem.

    Args:
        path: the geometry, arrays of shape (n,).
        wanted: T, shape (n,), > 0.
        turns: N, shape (n,).

    Returns:
        The conics, those of a problem next to each other, that of the lower x first; and min T for N ≥ 1, 0 for N = 0,
        shape (n,).
    """
    n = len(wanted)
    counts, table, least = np.zeros(n, dtype=np.int64), np.zeros((n, 2, 9)), np.zeros(n)
    _fill(path.λ, path.complement, wanted, turns, counts, table, least)
    found = np.arange(2)[None, :] < counts[:, None]
    problem = np.repeat(np.arange(n), counts)
    w, v, error, slope, upper, *sums = table[found].T
    return Conics(problem, turns[problem], w, v, error, slope, upper > 0, *sums), least
