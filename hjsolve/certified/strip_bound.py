"""Means of periodic integrands by the midpoint rule, with a proved error.

Where an integrand with period 2π is analytic and at most M in the strip |Im χ| ≤ a, N nodes miss its mean by no more
than 2M/(e^(aN) − 1) (Trefethen & Weideman, SIAM Review 56 (2014) 385, theorem 3.2). M is proved on the edge alone:

- p² and the kernels are analytic in the strip, by their form or because balls that cover it show it;
- so R = p²/((q − a)(b − q)) is analytic. It has no zero there if its argument returns along the edge: balls cover the
  edge, and each lies in a disk without 0 about its centre. Likewise s² + c², where q has its poles;
- so the integrand, a kernel times dq/dχ over √R, is analytic, and largest on the edge (maximum principle).

f(χ̄) = f̄(χ), and what else is known of f (``CycleIntegrand.symmetry``), let a part of the edge stand for the whole.
Doubles only choose the width a.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple, cast

import numpy as np

from hjsolve.arithmetic.ball import Ball, between, flint, hull, working
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Complexes, Reals
from hjsolve.arithmetic.work_counter import count
from hjsolve.certified.arb_integral import mean
from hjsolve.certified.integrands import TERMS, AnomalyMap, CycleIntegrand, CycleNode
from hjsolve.errors import NotConvergedError, required

_GROWTH = 2.0
"""How much longer than a ball the next may be."""
_PIECES = 8
"""Pieces of the edge to begin with, for half a turn."""
_MOST_BOXES, _MOST_CELLS = 400, 1000
"""Balls on the edge, and over the strip, beyond which a strip is given up."""
_SMALLEST_CELL = 2.0**-10
"""A part of the strip that is still not free of singularities when it is as small as that has one."""
_BITS, _SURE = 64, 40
"""Precision of these balls, and what F must have of it."""
_MOST_NODES = 12
"""Nodes for each bit beyond which Arb's own quadrature is the better way."""
_SPREAD = 2.0
"""How much wider a strip must be to be worth the costlier map."""
_PARTS, _LARGEST_PART = ((100, 0.3), (400, 0.4), (1500, 0.5)), 0.6
"""Half width of the strip of a spread map, in units of π/κ, by the bits wanted: a wider one is costlier to prove, and
q = ∞ comes at √½ in the middle."""
_NEAR = 0.35
"""Distance from a turning point, in units of b − a, up to which p² is taken from there."""
_AIM = 0.6
"""The spread of a ball on the edge that is aimed at."""
_CLEAR = 0.99
"""The spread up to which a ball is held to be clear of 0."""
_GOOD = 0.8
"""The spread above which another way to enclose R is tried."""
_PI = 3.1415926535897936
"""The double after π."""
_PORTIONS, _LARGEST_PORTION = ((100, 0.5), (200, 0.8)), 0.97
"""The part of the widest strip that is tried first, by the bits wanted: where they are few the proof costs more than
the nodes, and it is cheaper for a narrower strip."""
_SMALL = 0.1
"""W|R′/R| below which a motion is nearly harmonic, and a strip may be as wide as they are tried."""
_LN2 = math.log(2)


_HEIGHTS = 0.1 * 1.4 ** np.arange(11)
"""Half widths of a strip that are tried in doubles."""


def _grid(librates: bool) -> tuple[Complexes, Complexes, Complexes | Reals]:
    """χ − π, (q − a)/(b − a) and (q − a)(b − q)/(b − a)² on the upper edges of these strips."""
    x = np.linspace(0, np.pi, 13) if librates else np.linspace(-np.pi, np.pi, 25)
    χ: Complexes = x + 1j * _HEIGHTS[:, None]
    low = cast("Complexes", (1 - np.cos(χ)) / 2)
    return χ - np.pi, low, low * (1 + np.cos(χ)) / 2 if librates else np.ones(1)


_GRIDS = {librates: _grid(librates) for librates in (True, False)}


class StripBound(NamedTuple):
    """Proved: the integrands are analytic in |Im χ| ≤ width and at most ``most`` there, one bound an integrand."""

    width: float
    most: list[flint.arb]


class _Box(NamedTuple):
    """Sizes of the integrands on a ball, and the centres of the disks that hold R and s² + c².

    ``spread``: radius of such a disk over the distance of its centre from 0, at least; below 1 there is no 0 in it.
    """

    sizes: list[flint.arb]
    centre: Ball
    denominator: Ball
    spread: float


def certified_means(cycle: CycleIntegrand, bits: int) -> list[flint.arb]:
    """Enclose (1/π) ∫₀^π of the wanted integrands (over a full turn and divided by 2π for a rotation).

    Args:
        bits: relative precision wanted.

    Returns:
        Real balls at the current precision.

    Raises:
        NotConvergedError: a ball is wide; the motion is too close to a separatrix for the precision asked.
    """
    # two phases away from χ = 0 and π, where p dq vanishes: only the order of magnitude enters, as the unit of 2⁻ᵇⁱᵗˢ
    rows = zip(*(cycle.values(flint.arb(x)) for x in (0.7, 2.0)), strict=True)
    sizes = [max(abs(x.mid()) for x in row) for row in rows]
    found = _midpoints(cycle, bits, sizes)
    # Arb's quadrature subdivides next to singularities: slower, but it needs no strip of one width
    if found is None:
        found = [mean(cycle, j, bits, size) for j, size in zip(cycle.wanted, sizes, strict=True)]
    # rounding makes a ball no wider than that but where R is nearly 0 at a node, next to a separatrix
    if any(not x.is_finite() or x.rel_accuracy_bits() < bits - 12 for x in found):
        raise NotConvergedError(
            "the integral could not be enclosed to the digits asked: the motion is too close to a separatrix"
        )
    return found


def _midpoints(cycle: CycleIntegrand, bits: int, sizes: list[flint.arb]) -> list[flint.arb] | None:
    """Return the means by the midpoint rule; None where no strip is found, or it would need too many nodes."""
    for map_, a in _plans(cycle, bits, sizes):
        # the first strip that is proved serves: those that follow are narrower, and need more nodes
        over = cycle.over(map_)
        strip = bound_in_strip(over, a)
        if strip is not None:
            return midpoint(over, strip, bits, sizes)
    return None


def _plans(cycle: CycleIntegrand, bits: int, sizes: list[flint.arb]) -> Iterator[tuple[AnomalyMap, float]]:
    """Yield maps with half widths of strips, the most promising first; those that need too many nodes are left out."""
    wide = _widest(cycle, bits, sizes)
    if wide is None and cycle.librates and cycle.near < 1:  # F in doubles is all rounding: the motion is small
        wide = 2 * math.asinh(1 / math.sqrt(cycle.near)) if cycle.near > _SMALL else _HEIGHTS[-1]
    if cycle.spread is not None:
        # the critical point of S lies where κ sin(χ/2) = iπ/2, at a height of about π/κ: widths are counted in that
        part = next((part for most, part in _PARTS if bits <= most), _LARGEST_PART)
        κ = max(cycle.spread.lower, cycle.spread.upper)
        spread = part * math.pi / κ
        if wide is not None:  # the doubles may step over what is very near
            wide = min(wide, 2 * math.asinh(math.sqrt(2) / math.sinh(κ)))
        # the spread map costs sinh, cosh and a division for each ball
        if wide is None or _SPREAD * wide < spread:
            yield from ((cycle.spread, portion * spread) for portion in (1.0, 0.7, 0.5))
    # nodes are about bits·ln 2/wide
    if wide is not None and wide > 1 / _MOST_NODES:
        first = next((portion for most, portion in _PORTIONS if bits <= most), _LARGEST_PORTION)
        yield from ((AnomalyMap(), first * portion * wide) for portion in (1.0, 0.6, 0.36))


def midpoint(cycle: CycleIntegrand, strip: StripBound, bits: int, sizes: list[flint.arb]) -> list[flint.arb]:
    """Return the midpoint rule with the error that a bound proves.

    Args:
        cycle: the integrands, over the map of the bound.
        strip: the bound.
        bits: relative precision wanted of integrands of these sizes.
        sizes: of the integrands, roughly.
    """
    # 2M/(e^{aN} − 1) (Trefethen & Weideman 2014, theorem 3.2) below 2^−(bits + 4) of the size
    excess = max(float((4 * most / size).log().upper()) for most, size in zip(strip.most, sizes, strict=True))
    nodes = math.ceil((excess + (bits + 4) * _LN2) / (cycle.symmetry * strip.width)) + 1  # the others are mirror images
    count(squares=nodes, kernels=nodes)
    # midpoints χ = angle (m + ½): no node is a turning point, where p dq/dχ and p vanish together
    angle = 2 * flint.arb.pi() / (cycle.symmetry * nodes)
    rows = zip(*(cycle.values(angle * (2 * m + 1) / 2) for m in range(nodes)), strict=True)
    # e^(aN) − 1 with N counted over a whole turn, mirror images included
    rest = (flint.arb(strip.width) * nodes * cycle.symmetry).exp() - 1
    return [
        sum(row, flint.arb(0)) / nodes + flint.arb(0, (2 * most / rest).upper())
        for row, most in zip(rows, strip.most, strict=True)
    ]


def _widest(cycle: CycleIntegrand, bits: int, sizes: list[flint.arb]) -> float | None:
    """Return the half width of a strip over the plain map that needs the fewest nodes, as doubles see it.

    None for none.
    """
    inputs = [float(v.mid()) for v in cycle.line.inputs]
    turned, low, product = _GRIDS[cycle.librates]
    with np.errstate(all="ignore"):
        if cycle.lower is None:
            q = float(cycle.slow.mid()) + turned
        else:
            width = float(cycle.width.mid())
            q, product = float(cycle.lower.mid()) + width * low, width * width * product
        regular = np.broadcast_to(cycle.line.radicand.squared.run(Float64(), [q, *inputs])[0] / product, q.shape)
        weights = cycle.line.radicand.kernels.run(Float64(), [q, *inputs])
        root = np.sqrt(np.abs(regular))
        values = [np.abs(product) * root if j < 0 else np.abs(weights[j]) / root for j in cycle.wanted]
        # the argument principle on a few points: where arg R turns, a zero lies below this height
        turns = np.sum(np.angle(regular[:, 1:] / regular[:, :-1]), axis=1)
        # a strip that holds a zero is in every wider one: all heights above the first failure are out
        clear = np.cumprod(np.isfinite(turns) & (np.abs(turns) < 1)).astype(bool)
        excess = [np.log(4 * np.max(v, axis=-1) / float(size)) for v, size in zip(values, sizes, strict=True)]
        # from 2M/(e^(aN) − 1) = 2⁻⁽ᵇⁱᵗˢ⁺⁴⁾ size: N = (ln(4M/size) + (bits + 4) ln 2)/a for the worst integrand
        nodes = (functools.reduce(np.maximum, excess) + (bits + 4) * _LN2) / _HEIGHTS
        best = np.where(clear & np.isfinite(nodes), nodes, np.inf)
    return float(_HEIGHTS[np.argmin(best)]) if np.min(best) < np.inf else None


def bound_in_strip(cycle: CycleIntegrand, a: float) -> StripBound | None:
    """Bound the integrands in a strip.

    Args:
        a: half width of the strip.

    Returns:
        The bound; None where the strip could not be proved to be free of singularities.
    """
    with working(_BITS):
        # what cancellation in F takes at one node is added to the precision of all balls
        sure = cycle.line.value(cycle.sample(flint.arb(1)).q).rel_accuracy_bits()
    bits = _BITS + min(max(0, _SURE - sure), cycle.line.bits)
    with working(bits):
        low = cycle.rounded(bits)
        # analytic first: without that neither the argument principle nor the maximum principle holds
        if not (low.entire or _covered(low, a)):
            return None
        # no zero of R, nor of s² + c², inside: their arguments return along the edge
        # F may be zero on the real axis at the turning points alone, and R = F/((q − a)(b − q)) is not zero there
        boxes = _edge(low, a)
        if boxes is None or not _returns([b.centre for b in boxes], even=low.symmetry > 1):
            return None
        if not (low.map.plain or _returns([b.denominator for b in boxes], even=low.symmetry > 1)):
            return None
        # the maximum principle: the largest ball of the edge bounds the strip
        most = boxes[0].sizes
        for box in boxes[1:]:
            most = [x.max(y) for x, y in zip(most, box.sizes, strict=True)]
        return StripBound(a, [x.upper() for x in most])


def _edge(cycle: CycleIntegrand, a: float) -> list[_Box] | None:
    """Cover the edge Im χ = a with balls from left to right, as wide as they may be; None where that takes too many."""
    # Schwarz's reflection f(χ̄) = f̄(χ): the lower edge is the image of the upper one
    x, end = (-_PI, _PI) if cycle.symmetry == 1 else (0.0, 2 * _PI / cycle.symmetry)
    found: list[_Box] = []
    step, growth, work = _PI / _PIECES, _GROWTH, _MOST_BOXES
    while x < end:
        if (work := work - 1) < 0:
            return None
        box = _box(cycle, flint.acb(between(x, x + step), a))
        change = min(growth, max(0.5, math.sqrt(_AIM / box.spread)))  # the spread goes like the square of the step
        # spread < 1: R lies in a disk that does not hold 0, so that √R and arg R are those of one branch on it
        if box.spread < _CLEAR:
            found.append(box)
            x, step, growth = x + step, step * change, _GROWTH
        else:
            # next to an obstacle the step is not allowed to grow again at once: it would fail at every second ball
            step, growth = step * min(change, 0.7), 1.0
    return found


def _box(cycle: CycleIntegrand, χ: Ball) -> _Box:
    """Evaluate on a ball of the edge; R = F/P with P = (q − a)(b − q), or R = F for a rotation."""
    sample = cycle.sample(χ)
    # s² + c² is 1 for the plain map; of other maps its zeros are poles of q
    denominator, _, _, width = (flint.acb(1), 1, 1, 0.0) if cycle.map.plain else _ring(sample.denominator)
    if width >= 1:
        return _Box([], denominator, denominator, math.inf)
    # (q − a)(b − q) from the factors of the map, which keep their digits next to the ends
    product = flint.arb(1) if sample.from_lower is None else sample.from_lower * sample.to_upper
    best = None
    # both forms are enclosures of one number; which is sharper depends on the distance from the end
    for form in _forms(cycle, sample):
        ring = _ring(form(cycle, sample, product))
        best = ring if best is None or ring[3] < best[3] else best
        if best[3] < _GOOD:
            break
    centre, least, most, spread = required(best)
    spread = max(spread, width)
    # |R| between least and most is all that the size of the integrand needs
    sizes = cycle.integrands(sample, product, least.union(most).sqrt()) if spread < _CLEAR else []
    # 1e-9 covers the rounding of the spread to a double
    return _Box([abs(x) for x in sizes], centre, denominator, spread + 1e-9)


def _forms(cycle: CycleIntegrand, sample: CycleNode) -> list[Callable[[CycleIntegrand, CycleNode, Ball], Ball]]:
    """Ways to enclose R on a ball, the best one first."""
    if sample.from_lower is None:
        return [_of_a_rotation]
    nearest = abs(sample.nearest)
    # next to an end F and q − a are both small, and a quotient of two balls about 0 says nothing
    return [_from_an_end, _from_the_middle] if nearest < _NEAR * cycle.width else [_from_the_middle]


def _ring(x: Ball) -> tuple[Ball, flint.arb, flint.arb, float]:
    """Return centre m of a ball, bounds of |x|, and how large |x − m|/|m| may be, infinite where that is not known."""
    middle = x.mid()
    size, spread = abs(middle), abs(x - middle)
    ratio = (spread / size).upper()
    return middle, (size - spread).lower(), (size + spread).upper(), float(ratio) if ratio.is_finite() else math.inf


def _of_a_rotation(cycle: CycleIntegrand, sample: CycleNode, _product: Ball) -> Ball:
    """F from its value and slope at the centre."""
    middle = sample.q.mid()
    # F₀ and F₁ at the centre are sharp; only F₂ is taken over the ball, and it is multiplied by h²: the excess goes
    # like the square of the ball's size
    (value, slope), bend, h = cycle.line.taylor(middle, 2), cycle.line.taylor(sample.q, 3)[2], sample.q - middle
    return value + (slope + bend * h) * h


def _from_an_end(cycle: CycleIntegrand, sample: CycleNode, _product: Ball) -> Ball:
    """R from F = (q − a) F[a, q] at the nearer turning point a, by Taylor's formula with its remainder on the hull."""
    lower = sample.near_lower
    from_lower, to_upper = required(sample.from_lower), required(sample.to_upper)
    end, h = (cycle.ends[0], from_lower) if lower else (cycle.ends[1], -to_upper)
    # the remainder of Taylor's formula holds on a convex set that contains a and the ball
    value = cycle.line.taylor(hull(sample.q, end), TERMS + 1)[TERMS]
    # Horner down to the coefficient of h¹: F(a) = 0 exactly, so that this is F[a, q], and h has been divided out
    for coefficient in (cycle.lower_series if lower else cycle.upper_series)[:0:-1]:
        value = coefficient + value * h
    # from below R = F[a, q]/(b − q), from above R = −F[b, q]/(q − a)
    return value / to_upper if lower else -value / from_lower


def _from_the_middle(cycle: CycleIntegrand, sample: CycleNode, product: Ball) -> Ball:
    """R from F = F₀ + F₁h + F₂(ball)h² about the centre of the ball, h = q − m.

    With P = P₀ + P₁h − h² that is R₀ + h (F₁ − R₀P₁ + (F₂ + R₀)h)/P: no difference of quotients that are nearly equal.
    """
    middle = sample.q.mid()
    h, (value, slope), bend = sample.q - middle, cycle.line.taylor(middle, 2), cycle.line.taylor(sample.q, 3)[2]
    from_lower, to_upper = middle - cycle.ends[0], cycle.ends[1] - middle
    # R₀ = F₀/P₀ at the centre of the ball
    start = value / (from_lower * to_upper)
    return start + h * (slope - start * (to_upper - from_lower) + (bend + start) * h) / product


def _returns(centres: list[Ball], *, even: bool) -> bool:
    """Return True when the argument does not grow along an edge: common points carry it from one disk to the next.

    The part of an even function's edge begins and ends at a real value, whose sign is that of the centre: what it grows
    by is a multiple of π. The edge of a rotation closes: a multiple of 2π.
    """
    # neighbouring disks meet and neither holds 0, so arg(after/before) is below π in size and needs no choice of branch
    growth = sum(_angle(after / before) for before, after in itertools.pairwise(centres))
    first, last = centres[0], centres[-1]
    if even:
        growth += _angle(first if first.real > 0 else -first) - _angle(last if last.real > 0 else -last)
    else:
        growth += _angle(first / last)
    # the growth is a multiple of π or 2π: below 1 it is 0, with room for the rounding of the angles
    return bool(abs(growth) < 1)


def _angle(x: Ball) -> float:
    return float(x.arg().mid())  # type: ignore[attr-defined]  # a complex ball


def _covered(cycle: CycleIntegrand, a: float) -> bool:
    """Return True when p² and the kernels are finite on balls that cover the strip.

    No operation meets a singularity.
    """
    start, pieces = (0.0, 16 // cycle.symmetry) if cycle.symmetry > 1 else (-np.pi, 16)
    step = 3.1415926535897936 / 8
    todo = [(start + k * step, start + (k + 1) * step, 0.0, a) for k in range(pieces)]
    work = _MOST_CELLS
    while todo:
        x0, x1, y0, y1 = todo.pop()
        # a cell that small and still not finite holds a singularity, or is too costly to decide
        if (work := work - 1) < 0 or x1 - x0 < _SMALLEST_CELL:
            return False
        q = cycle.sample(flint.acb(between(x0, x1), between(y0, y1))).q
        if all(x.is_finite() for x in (cycle.line.value(q), *cycle.weights.run(q))):
            continue
        # the longer side is halved: enclosures over nearly square cells are the sharpest
        if x1 - x0 > y1 - y0:
            todo += [(x0, (x0 + x1) / 2, y0, y1), ((x0 + x1) / 2, x1, y0, y1)]
        else:
            todo += [(x0, x1, y0, (y0 + y1) / 2), (x0, x1, (y0 + y1) / 2, y1)]
    return True
