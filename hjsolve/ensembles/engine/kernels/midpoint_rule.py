"""The midpoint rule: how many nodes, and where they crowd.

A rule that cannot be enough is recognised by its last coefficients alone. These say two more things. How fast they fall
tells how many nodes would do. And a singularity of the integrand next to χ = φ gives coefficients like ρᵏ cos(kφ + θ)
(Darboux), so from one to the next they show where it is, and which clustering of nodes serves (``nodes.CLUSTERINGS``).
"""

from __future__ import annotations

import math

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.compiling import helper, inlined, reducing
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.crowding import CLUSTERINGS, EVEN
from hjsolve.ensembles.engine.kernels.types import Modes, Scratch, Tables

_EVEN = EVEN
_UNSTRETCHED = len(CLUSTERINGS)
ROUNDING_FACTOR = 1.5  # times the bound on rounding: running errors leave out terms of second order
_SHIFT_FACTOR = 3.0  # times what shifts do: those bounds are sharp, and claims leave as much room here as elsewhere
RELATIVE_GOAL = 4e-16  # of the mean of |integrand|: two spacings of doubles, less than summation loses
_NODES_WORTH_CROWDING = 44.0  # nodes needed above which a crowded map is tried
_FRACTION_OF_NODES = 0.6  # of the nodes needed without crowding, which a crowded map is tried with
_FEWEST_NODES = 32.0  # nodes that a crowded map is tried with at least
_GEOMETRIC_FALL = 0.75  # |c_{n−1}|/|c_{n−4}| below which the fall of three coefficients is extrapolated
_LARGEST_TAIL = 1e-5  # last coefficients over the mean, above which errors are not worked out: more nodes are needed
_LARGEST_TAIL_OF_SERIES = 1e-9  # the same where running integrals are wanted, which miss terms from n on, not 2n

Last = tuple[float, float, float, float, float]


@reducing
def dot(x: Reals, y: Reals, count: int) -> float:
    """Σ x y; the order of summation is the compiler's.

    Args:
        x, y: at least ``count`` doubles.
        count: how many are used.
    """
    total = 0.0
    for j in range(count):
        total += x[j] * y[j]
    return total


@reducing
def _coefficients(rows: Reals, x: Reals, n: int) -> tuple[float, float, Last]:
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


@reducing
def _middle(rows: Reals, x: Reals, n: int) -> float:
    """Return the size of the largest of three coefficients in the middle of the series."""
    p, q, r = 0.0, 0.0, 0.0
    for j in range(n):
        v = x[j]
        p += rows[0, j] * v
        q += rows[1, j] * v
        r += rows[2, j] * v
    return 2.0 / n * max(abs(p), abs(q), abs(r))


@reducing
def _between(x: Reals, start: int, stop: int) -> float:
    part, total = x[start:stop], 0.0
    for j in range(stop - start):
        total += part[j]
    return total


@reducing
def sizes(x: Reals, n: int) -> float:
    """Return Σ |x|.

    Args:
        x: at least n doubles.
        n: how many are used.
    """
    total = 0.0
    for j in range(n):
        total += abs(x[j])
    return total


@reducing
def _weighted(x: Reals, y: Reals, n: int) -> float:
    """Σ x |y|."""
    total = 0.0
    for j in range(n):
        total += x[j] * abs(y[j])
    return total


@inlined
def _needed(late: float, early: float, scale: float, n: int, wish: float) -> float:
    """Return how many nodes bring the last coefficients down to ``wish``: they fall geometrically."""
    # |cₖ| ~ ρᵏ, ρ³ = late/early three places apart: log(wish/excess)/log ρ places more are needed
    excess = max(2.0 / n * late, 1e-300) / scale
    if late < _GEOMETRIC_FALL * early:
        more = n + 3.0 * math.log(wish / excess) / math.log(max(late / early, 1e-9))
    else:
        # they do not fall yet, from place to place: the mean fall from the first coefficient on, at most three times n
        more = min(2.0 + (n - 2.0) * math.log(wish) / math.log(min(excess, 0.5)), 3.0 * n)
    return min(max(more, n + 1.0), 8.0 * n)


@inlined
def _crowding(last: Last, first: int) -> int:
    """Return the crowding for a singularity next to χ = φ.

    Cos φ and cos 2φ from correlations of the last coefficients.
    """
    if first >= _UNSTRETCHED:
        return first
    late, early = max(abs(last[3]), abs(last[4])), max(abs(last[0]), abs(last[1]))
    # without their fall ρᵏ the coefficients are cos(kφ + θ), whose correlations one and two places apart are means of
    # cos φ and cos 2φ, over five terms four and three products: hence 5/4 and 5/3
    fall = (late / early) ** (1.0 / 3.0) if early > 0.0 else 1.0
    p, q, r, s, t = last[0], last[1] / fall, last[2] / fall**2, last[3] / fall**3, last[4] / fall**4
    squares = p * p + q * q + r * r + s * s + t * t
    once, twice = 1.25 * (p * q + q * r + r * s + s * t) / squares, 5.0 / 3.0 * (p * r + q * s + r * t) / squares
    # an even motion has its series in 2χ: φ = 0 is at both ends, φ = π in the middle
    if first >= _EVEN:
        return first + 1 if once < -0.4 else first + 2 if once > 0.4 else first
    # |cos φ| < 0.35: in the middle (cos 2φ = −1), else no single place is seen
    if abs(once) < 0.35:
        return 3 if twice < -0.3 else first
    return (1 if once > 0.8 else 2) if once > 0.0 else (5 if once < -0.8 else 4)


@helper
def _roundings(work: Scratch, t: int, squares: Reals, samples: int, n: int, integrands: int, chords: bool) -> None:
    """Write n times what the rounding errors of F and of the kernels do to the means into ``found[3]``.

    Where there are no kernels F's errors are known as they are, too, and each segment takes what bounds it best.
    """
    fractions, weights, found, noise, plain = work.fractions, work.rows[0], work.found, work.noise[t], work.drift[t]
    moments, r = work.buffer[0], work.buffer[1]
    for k in range(integrands):
        found[3, k] = 0.0
    # δ(F r) = ½ r δF, and δF is proportional to F/sin²χ: weights are F r/sin²χ
    for j in range(n):
        weights[j] = moments[j] / squares[j]
    for g in range(samples - 1):
        start, stop = g * n // (samples - 1), (g + 1) * n // (samples - 1)
        # a bound of a segment between two samples is the larger of theirs
        own, segment = max(noise[0, g], noise[0, g + 1]), fractions[start:stop]
        for j in range(stop - start):
            segment[j] = own
        if not chords:
            moved = own * _between(weights, start, stop)
            if integrands == 1:
                moved = min(moved, max(plain[g], plain[g + 1]) * _between(r, start, stop))
            found[3, 0] += 0.5 * moved
        for k in range(1, integrands):
            found[3, k] += max(noise[k, g], noise[k, g + 1]) * (stop - start)
    if chords:
        found[3, 0] += 0.5 * _weighted(fractions, moments, n)
    elif integrands > 1:
        for j in range(n):
            fractions[j] /= squares[j]
    # δ(k r) = −½ k r δF/F besides r δk
    for k in range(1, integrands):
        found[3, k] += 0.5 * _weighted(fractions, work.buffer[2 + k], n)


@helper
def shifted_action(work: Scratch, residue: tuple[float, float], uncertainty: Reals, n: int, split: int) -> float:
    """Return what the errors of the constants, and of F at the turning points, do to the mean of F r.

    Args:
        work: F r, r and the kernels times r at the nodes.
        residue: bounds on F's errors at the turning points.
        uncertainty: bounds on the errors of the constants.
        n: number of nodes.
        split: how many of them belong to the lower half.
    """
    total = 0.5 * (residue[0] * _between(work.buffer[1], 0, split) + residue[1] * _between(work.buffer[1], split, n))
    for k in range(work.buffer.shape[0] - 3):
        if uncertainty[k] != 0.0:
            total += uncertainty[k] * sizes(work.buffer[3 + k], n)
    return _SHIFT_FACTOR * total / n


@inlined
def enough(tail: float, middle: float, rounding: float, scale: float, oscillations: bool) -> tuple[float, bool]:
    """Return a bound on the aliasing of a mean, and whether the rule is good enough for it.

    The midpoint rule of n nodes misses the coefficients c₂ₙ, c₄ₙ, … alone (Trefethen & Weideman 2014, §3). Where they
    fall geometrically, by tail/middle from n/2 to n, they fall by its square up to 2n: the power 3/2 is counted,
    and four times that.

    Args:
        tail: size of the last coefficients.
        middle: size of those in the middle of the series.
        rounding: bound on the rounding error of the mean.
        scale: the mean of |integrand|.
        oscillations: whether running integrals are wanted, which miss the coefficients from n on.
    """
    fraction = min(1.0, tail / max(middle, 1e-300))
    alias = 4.0 * tail * fraction * np.sqrt(fraction)
    # more nodes cannot mend an error that is below a quarter of the rounding, nor one that no double shows
    fits = alias <= max(RELATIVE_GOAL * scale, 0.25 * rounding) or tail <= 0.5 * rounding
    if oscillations:
        fits = fits and tail <= max(4e-15 * scale, rounding)
    return alias, fits


@helper
def means(work: Scratch, n: int) -> bool:
    """Leave the means of the integrands in the buffer in ``found``, without errors; return whether they are finite.

    Args:
        work: with the buffer.
        n: number of nodes.
    """
    buffer, found, fine = work.buffer, work.found, True
    for k in range(buffer.shape[0] - 2):
        mean = _between(buffer[0] if k == 0 else buffer[2 + k], 0, n) / n
        found[0, k], found[1, k], found[2, k] = mean, 0.0, 0.0
        fine = fine and math.isfinite(mean)
    return fine


@helper
def rule(work: Scratch, t: int, tables: Tables, size: int, modes: Modes, first: int) -> tuple[float, int]:
    """Apply the rule of one size to the nodes in the buffer.

    Args:
        work: with the buffer and the errors of an orbit; means and their errors are left in ``found``.
        t: the place of the orbit in the block.
        tables: of nodes.
        size: place in ``Tables.counts``.
        modes: what is wanted.
        first: the map to begin with.

    Returns:
        How many nodes are needed, −1 where these suffice, and the map that would serve.
    """
    buffer, found, n = work.buffer, work.found, tables.counts[size]
    last, middle = tables.last[size], tables.middle[size]
    integrands = buffer.shape[0] - 2
    approximate, wish = (_LARGEST_TAIL_OF_SERIES, 2e-15) if modes.oscillations else (_LARGEST_TAIL, 1e-8)
    more, node_map = -1.0, first
    for k in range(integrands):
        total, scale, ends = _coefficients(last, buffer[0] if k == 0 else buffer[2 + k], n)
        if not math.isfinite(total):  # F ≤ 0 somewhere
            return 2.0 * n, first
        # the largest of five: one alone may be a zero of cos(kφ + θ)
        tail = 2.0 / n * max(abs(ends[0]), abs(ends[1]), abs(ends[2]), abs(ends[3]), abs(ends[4]))
        found[0, k], found[1, k], found[2, k] = total / n, scale / n, tail
        found[4, k], found[5, k] = max(abs(ends[3]), abs(ends[4])), max(abs(ends[0]), abs(ends[1]))
        if tail > approximate * (scale / n):
            wanted = _needed(found[4, k], found[5, k], scale / n, n, wish)
            if wanted > more:
                more, node_map = wanted, _crowding(ends, first)
    if more > 0.0:  # errors are not worth working out for nodes that do not suffice
        return more, node_map
    squares = tables.squares[int(tables.maps[first, 6]) - 1, size]
    _roundings(work, t, squares, tables.samples[first], n, integrands, modes.chords)
    for k in range(integrands):
        scale, tail = found[1, k], found[2, k]
        rounding = ROUNDING_FACTOR * found[3, k] / n + 8.0 * EPS * scale
        half = _middle(middle, buffer[0] if k == 0 else buffer[2 + k], n)
        alias, fits = enough(tail, half, rounding, scale, modes.oscillations)
        found[1, k], found[2, k] = rounding + alias, 0.5 * rounding + tail
        if not fits and scale != 0.0:
            more = max(more, _needed(found[4, k], found[5, k], scale, n, wish))
    return more, node_map


@inlined
def next_rule(
    counts: Integers, tried: tuple[int, int], needed: tuple[float, int], first: int, attempt: int
) -> tuple[int, int]:
    """Return the size and the map to try next; −1 where the tables do not suffice.

    Args:
        counts: numbers of nodes by size.
        tried: size and map.
        needed: how many nodes, and the map that would serve, as ``rule`` returns them.
        first: the map to begin with.
        attempt: how often the orbit was tried before.
    """
    (size, m), (more, crowded) = tried, needed
    size += 1
    if size >= counts.shape[0]:
        return -1, m
    if attempt == 0 and more > _NODES_WORTH_CROWDING and crowded != first:
        m, more = crowded, max(_FEWEST_NODES, _FRACTION_OF_NODES * more)
    while size + 1 < counts.shape[0] and counts[size] < more:
        size += 1
    return size, m
