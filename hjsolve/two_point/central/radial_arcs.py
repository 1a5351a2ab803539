"""Enclosures of time and angle of radial arcs, and of their slopes, over boxes of energy and angular momentum.

With λ² = L²/2m, f(r) = r²(E − V), σ² = f − λ² and tan φ = σ/λ, a mass moves by dt = √(m/2) r dr/σ and dθ = λ dr/(rσ).
Where B = f′/r = 2(E − V) − rV′ has one sign,

    dt = √(m/2) g dσ,  g = 2/B;    dθ = h dφ,  h = 2(E − V)/B,

so that turning points (σ = φ = 0) are nothing special: g and h are bounded there, and sums over cells telescope. Where
B may vanish f is nearly greatest, σ is away from 0 and the integrals over r are taken as they stand. By a parameter a
of E and λ (σ_a at fixed r; coefficients at fixed φ and fixed σ)

    dθ/da = [h φ_a] + ∫ (h_E E_a + r h′ (2λ_a(E − V)/λ − E_a)/B) dφ,
    dt/da/√(m/2) = [g σ_a] + ∫ (g_E E_a + r g′ (2λλ_a/r² − E_a)/B) dσ.

The parameters are λ and s, E = V_j + λ²/r_j² + s²: s r_j is σ at that one of the two places which a motion barely
reaches with s = 0, and there σ_a is exact. Sums are taken outward; node k has s_k = ∫ to it, so a cell's weight is that
of the difference of two nodes and widths of the nodes do not add up (Abel's summation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.interval import Interval, exact, meet
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.two_point.central.radial_grid import FIELD, OUT, RadialGrid, root_of_positive, summed

_PLAIN = 0.4
"""Where f − λ² is more than this part of its greatest value, √(f − λ²) hardly varies over a box."""
_TWO = exact(2.0)
DIRECT, OUTER, INNER = range(3)


class Boxes(NamedTuple):
    """Boxes of the parameters.

    Attributes:
        s, λ: their ranges, arrays of shape (b, 1).
        bound: index of the node r_j, shape (b,).
    """

    s: Interval
    λ: Interval
    bound: Integers


@dataclass(frozen=True)
class RadialArcs:
    """Time and angle of the arcs between the places, from the outer one outwards and from the inner one inwards.

    Attributes:
        values: of (time in units of √(m/2), angle), shape (2, 3, b); ∞ above where not bounded.
        slopes: of these by (s, λ), shape (2, 2, 3, b).
        there: 1 where the arc exists (has a turning point) all over the box, −1 where nowhere, 0 undecided; (3, b).
        momentum_high: bound on λ from above, shape (b,).
        returns: whether every motion turns before the last node, shape (b,).
        rate: of the angle by the time in these units, λ/r², over all of the motions; shape (b,).
    """

    values: Interval
    slopes: Interval | None
    there: Integers
    momentum_high: Reals
    returns: Mask
    rate: Interval

    def part(self, kept: Mask) -> RadialArcs:
        """Return those of some boxes.

        Args:
            kept: which.
        """

        def of(x: Interval) -> Interval:
            return Interval(np.asarray(x.low)[..., kept], np.asarray(x.high)[..., kept])

        values, rate = of(self.values), of(self.rate)
        slopes = None if self.slopes is None else of(self.slopes)
        return RadialArcs(values, slopes, self.there[:, kept], self.momentum_high[kept], self.returns[kept], rate)


class _Fields(NamedTuple):
    """What the arcs of a batch of boxes are made of; nodes (b, N + 1), cells (b, N)."""

    σ: Interval
    φ: Interval
    square: Interval
    """f − λ² at the nodes"""
    rising: Mask
    falling: Mask
    plain: Mask
    """cells where f is far above λ², over which the integrals over r are taken"""
    inside: Interval
    """f − λ² over cells"""
    middle: Interval
    """f − λ² at the middles of cells"""
    A: Interval
    B: Interval
    h: Interval
    g: Interval
    rh: Interval
    """r h′"""
    rg: Interval
    """r g′"""


def _column(x: Interval) -> Interval:
    return Interval(np.asarray(x.low)[None, :], np.asarray(x.high)[None, :])


def _of(x: Interval, index: Integers) -> Interval:
    return Interval(np.asarray(x.low)[index][:, None], np.asarray(x.high)[index][:, None])


def _cells(grid: RadialGrid) -> Interval:
    return Interval(grid.r[None, :-1], grid.r[None, 1:])


def _inverse_square(λ: Interval) -> Interval:
    with np.errstate(all="ignore"):
        low = 1 / np.square(λ.high) * (1 - 1e-15)
        return Interval(low, np.where(λ.low > 0, 1 / np.square(λ.low) * (1 + 1e-15), np.inf))


def _fields(grid: RadialGrid, boxes: Boxes) -> _Fields:
    mul, add, sub, div = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div
    s2, λ2 = FIELD.power(boxes.s, 2), FIELD.power(boxes.λ, 2)
    Vj, rj = _of(grid.at_nodes.V, boxes.bound), grid.r[boxes.bound][:, None]
    top = add(s2, Vj)
    E = add(top, FIELD.power(div(boxes.λ, exact(rj)), 2))
    square, tangent2 = _squares(grid.at_nodes.V, grid.r, rj, top, boxes.λ)
    middle, _ = _squares(grid.at_middles.V, grid.middles, rj, top, boxes.λ)
    there = np.arange(len(grid.r))[None, :] == boxes.bound[:, None]
    own = mul(FIELD.power(exact(rj), 2), s2)
    own_tangent = mul(own, _inverse_square(boxes.λ))
    square = Interval(np.where(there, own.low, square.low), np.where(there, own.high, square.high))
    tangent2 = Interval(
        np.where(there, own_tangent.low, tangent2.low), np.where(there, own_tangent.high, tangent2.high)
    )
    # the centre itself: every motion with L ≠ 0 turns before it, if V is known there
    known = grid.centre is not None
    for x in (square, tangent2):
        x.low[:, 0], x.high[:, 0] = (-1.0, -1.0) if known else (-np.inf, np.inf)
    σ, φ = root_of_positive(square), FIELD.unary("atan", root_of_positive(tangent2))
    φ = Interval(np.maximum(φ.low, 0), φ.high)
    cells = grid.over_cells
    low, high = _radii(grid.r[None, :-1], rj), _radii(grid.r[None, 1:], rj)
    ρ_cell, r2_cell = (Interval(a.low, b.high) for a, b in ((low[1], high[1]), (low[0], high[0])))
    inside = add(mul(r2_cell, sub(top, _column(cells.V))), mul(λ2, ρ_cell))
    return _with_coefficients(grid, E, (σ, φ, square, inside, middle))


def _squares(V: Interval, r: Reals, rj: Reals, top: Interval, λ: Interval) -> tuple[Interval, Interval]:
    """Return f − λ² and its ratio to λ² at some r; each parameter stands once in both, which are their exact ranges."""
    r2, ρ = _radii(r[None, :], rj)
    high = FIELD.mul(r2, FIELD.sub(top, _column(V)))
    return (
        FIELD.add(high, FIELD.mul(FIELD.power(λ, 2), ρ)),
        FIELD.add(FIELD.mul(high, _inverse_square(λ)), ρ),
    )


def _radii(r: Reals, rj: Reals) -> tuple[Interval, Interval]:
    """r² and r²/r_j² − 1."""
    r2 = FIELD.power(exact(np.broadcast_to(r, (len(rj), r.shape[1]))), 2)
    ρ = FIELD.mul(FIELD.sub(exact(r), exact(rj)), FIELD.add(exact(r), exact(rj)))
    return r2, FIELD.div(ρ, FIELD.power(exact(rj), 2))


def _with_coefficients(
    grid: RadialGrid, E: Interval, known: tuple[Interval, Interval, Interval, Interval, Interval]
) -> _Fields:
    σ, φ, square, inside, middle = known
    mul, add, sub, div = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div
    V, W1, W2 = (_column(x) for x in grid.over_cells)
    A = sub(E, V)
    B = sub(mul(_TWO, A), W1)
    B2 = FIELD.power(B, 2)
    rh = mul(_TWO, div(add(mul(A, add(W1, W2)), FIELD.power(W1, 2)), B2))
    rg = mul(_TWO, div(add(mul(exact(3.0), W1), W2), B2))
    V, W1, _ = (_column(x) for x in grid.at_middles)
    A_middle = sub(E, V)
    B_middle = sub(mul(_TWO, A_middle), W1)
    width = Interval(-grid.half[None, :], grid.half[None, :])
    g, h = div(_TWO, B), mul(_TWO, div(A, B))
    g = meet(g, add(div(_TWO, B_middle), mul(rg, width)))
    h = meet(h, add(mul(_TWO, div(A_middle, B_middle)), mul(rh, width)))
    # f′ = rB, and f is narrower at the nodes than over a cell
    change = mul(mul(_cells(grid), B), Interval(np.zeros(1), np.diff(grid.r)[None, :] * (1 + 1e-15)))
    inside = meet(inside, add(Interval(square.low[:, :-1], square.high[:, :-1]), change))
    inside = meet(inside, sub(Interval(square.low[:, 1:], square.high[:, 1:]), change))
    rising, falling = np.asarray(B.low > 0).copy(), np.asarray(B.high < 0)
    if grid.centre is not None:
        q, slowest = grid.centre.ratio(E), grid.centre.slowest(E)
        room = 1 - np.asarray(q.high)
        rising[:, 0] = ((room > 0) & (slowest > 0))[:, 0]
        with np.errstate(all="ignore"):
            h.low[:, 0], h.high[:, 0] = (1 / (1 - q.low))[:, 0] * (1 - 1e-14), (1 / room)[:, 0] * (1 + 1e-14)
            g.low[:, 0], g.high[:, 0] = 0.0, (1 / (slowest * room))[:, 0] * (1 + 1e-14)
    greatest = np.max(np.asarray(square.low), axis=1)[:, None]
    above = np.asarray(inside.low) > 0
    plain = above & ((np.asarray(inside.low) >= _PLAIN * greatest) | ~(rising | falling))
    return _Fields(σ, φ, square, rising & ~plain, falling & ~plain, plain, inside, middle, A, B, h, g, rh, rg)


class _Reach(NamedTuple):
    """The cells of one arc: those that count, whether it is decided, and those that it surely passes."""

    active: Mask
    there: Integers
    passed: Mask


def _reaches(grid: RadialGrid, F: _Fields) -> tuple[_Reach, _Reach, _Reach]:
    """Where the arcs run; a motion that is not at the places with these parameters does not matter."""
    cells = np.arange(len(grid.r) - 1)[None, :]
    low, high = np.asarray(F.square.low), np.asarray(F.square.high)
    first, last = low[:, :-1] > 0, low[:, 1:] > 0
    # f rises from, or falls to, the places themselves, where it is not less than λ²
    direct = (cells >= grid.inner) & (cells < grid.outer)
    sure = F.plain | (F.rising & (first | (cells == grid.inner))) | (F.falling & (last | (cells + 1 == grid.outer)))
    barred = np.any((high[:, 1:-1] < 0) & (cells[:, 1:] > grid.inner) & (cells[:, 1:] < grid.outer), axis=1)
    all_sure = np.all(sure | ~direct, axis=1)
    between = _Reach(np.broadcast_to(direct, sure.shape), np.where(barred, -1, np.where(all_sure, 1, 0)), direct & sure)
    sure = F.plain | (F.rising & (first | (cells == grid.outer))) | (F.falling & last)
    outer = _turning(sure[:, grid.outer :], F.falling[:, grid.outer :], high[:, grid.outer + 1 :] < 0)
    sure = F.plain | (F.falling & (last | (cells + 1 == grid.inner))) | (F.rising & first)
    inner = _turning(
        sure[:, : grid.inner][:, ::-1], F.rising[:, : grid.inner][:, ::-1], high[:, : grid.inner][:, ::-1] < 0
    )
    out = [np.zeros(sure.shape, dtype=bool) for _ in range(4)]
    out[0][:, grid.outer :], out[1][:, grid.outer :] = outer.active, outer.passed
    out[2][:, : grid.inner], out[3][:, : grid.inner] = inner.active[:, ::-1], inner.passed[:, ::-1]
    return between, _Reach(out[0], outer.there, out[1]), _Reach(out[2], inner.there, out[3])


def _turning(sure: Mask, closing: Mask, gone: Mask) -> _Reach:
    """Return the arc from the first cell on, in the order in which a motion passes them.

    Args:
        sure: cells that every motion passes, if it passes those before.
        closing: cells in which f falls on the way.
        gone: whether f < λ² for all motions at the far end of a cell.
    """
    count = sure.shape[1]
    if not count:
        return _Reach(sure, np.zeros(len(sure), dtype=int), sure)
    cells = np.arange(count)[None, :]
    some = np.any(gone, axis=1)
    last = np.where(some, np.argmax(gone, axis=1), count - 1)[:, None]
    unsure = ~sure & (cells <= last)
    begin = np.where(np.any(unsure, axis=1), np.argmax(unsure, axis=1), count)[:, None]
    turned = some & np.all(closing | (cells < begin) | (cells > last), axis=1)
    return _Reach(cells <= last, turned.astype(int), cells < np.minimum(begin, count))


def _telescoped(c: Interval, x: Interval, cells: Mask, rising: Mask) -> tuple[Reals, Reals]:
    """Bounds of Σ c_k (x_{k+1} − x_k) over some cells, in which x rises or falls."""
    result = []
    for upper in (False, True):
        with np.errstate(all="ignore"):
            chosen = np.where(cells, np.where(rising == upper, c.high, c.low), 0.0)
        weight = np.zeros(x.low.shape)
        with np.errstate(all="ignore"):
            weight[:, 1:] += chosen
            weight[:, :-1] -= chosen
            ends = np.where((weight > 0) == upper, x.high, x.low)
            terms = np.where(weight == 0, 0.0, weight * np.where(weight == 0, 0.0, ends))
            total, size = np.sum(terms, axis=1), np.sum(np.abs(terms), axis=1)
        bad = ~np.isfinite(total)
        total = np.where(bad, np.inf if upper else -np.inf, total + (OUT * size if upper else -OUT * size))
        result.append(total)
    return result[0], result[1]


class _Rates(NamedTuple):
    """By one parameter: that of E, λ_a and λ_a/λ, and σ_a and φ_a at the nodes."""

    E: Interval
    λ: float
    σ: Interval
    φ: Interval


def _rates(grid: RadialGrid, boxes: Boxes, F: _Fields) -> tuple[_Rates, _Rates]:
    """Return the rates by s and by λ."""
    mul, add, sub, div = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div
    s, λ = boxes.s, boxes.λ
    rj = grid.r[boxes.bound][:, None]
    r2, ρ = _radii(grid.r[None, :], rj)
    own = np.arange(len(grid.r))[None, :] == boxes.bound[:, None]
    f = add(F.square, FIELD.power(λ, 2))
    f = Interval(np.maximum(f.low, np.square(λ.low) * (1 - 1e-14)), f.high)
    by_s = div(mul(r2, s), F.σ)
    by_s = Interval(np.where(own, rj, by_s.low), np.where(own, rj, by_s.high))
    by_λ = div(mul(ρ, λ), F.σ)
    by_λ = Interval(np.where(own, 0.0, by_λ.low), np.where(own, 0.0, by_λ.high))
    turned_s = div(mul(λ, by_s), f)
    turned_λ = div(sub(mul(λ, by_λ), F.σ), f)
    E_λ = mul(mul(_TWO, λ), FIELD.div(exact(np.ones_like(rj)), FIELD.power(exact(rj), 2)))
    return _Rates(mul(_TWO, s), 0.0, by_s, turned_s), _Rates(E_λ, 1.0, by_λ, turned_λ)


def _coefficients(grid: RadialGrid, boxes: Boxes, F: _Fields, rate: _Rates) -> tuple[Interval, Interval]:
    """Return what is integrated over dσ for the time, and over dφ for the angle."""
    mul, add, sub, div = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div
    W1 = _column(grid.over_cells.first)
    B2 = FIELD.power(F.B, 2)
    h_E = div(mul(exact(-2.0), W1), B2)
    g_E = div(exact(-4.0), B2)
    time = mul(rate.E, sub(g_E, div(F.rg, F.B)))
    angle = mul(rate.E, sub(h_E, div(F.rh, F.B)))
    if rate.λ:
        r2 = FIELD.power(_cells(grid), 2)
        time = add(time, div(mul(mul(_TWO, boxes.λ), F.rg), mul(r2, F.B)))
        angle = add(angle, div(mul(F.h, F.rh), boxes.λ))
    return time, angle


def _nodes(grid: RadialGrid, boxes: Boxes) -> tuple[Interval, Interval]:
    """Return g and h at the nodes."""
    V, W1, _ = (_column(x) for x in grid.at_nodes)
    rj = grid.r[boxes.bound][:, None]
    lifted = FIELD.div(boxes.λ, exact(rj))
    E = FIELD.add(FIELD.add(FIELD.power(boxes.s, 2), _of(grid.at_nodes.V, boxes.bound)), FIELD.power(lifted, 2))
    A = FIELD.sub(E, V)
    B = FIELD.sub(FIELD.mul(_TWO, A), W1)
    return FIELD.div(_TWO, B), FIELD.mul(_TWO, FIELD.div(A, B))


def _boundary(F: _Fields, counted: Mask, weight: Interval, rate: Interval) -> tuple[Reals, Reals]:
    """Bounds of Σ [g σ_a] over the ends of the runs of counted cells, those at turning points not among them."""
    edge = np.zeros(weight.low.shape)
    edge[:, 1:] += counted
    edge[:, :-1] -= counted
    ends = (edge != 0) & ~(np.asarray(F.square.high) < 0)
    product = FIELD.mul(weight, rate)
    with np.errstate(all="ignore"):
        low = np.where(ends, np.where(edge > 0, product.low, -product.high), 0.0)
        high = np.where(ends, np.where(edge > 0, product.high, -product.low), 0.0)
        size = OUT * np.sum(np.where(ends, np.abs(product.high), 0.0), axis=1)
        return np.sum(low, axis=1) - size, np.sum(high, axis=1) + size


def _summed(x: Interval, cells: Mask) -> Interval:
    """Enclose a sum over some cells."""
    return summed(Interval(np.where(cells, x.low, 0.0), np.where(cells, x.high, 0.0)))


class _Plain(NamedTuple):
    """Integrals over whole cells as they stand: of (time, angle), and of their slopes by s and λ."""

    values: tuple[Interval, Interval]
    slopes: tuple[tuple[Interval, Interval], tuple[Interval, Interval]]


def _plain(grid: RadialGrid, boxes: Boxes, F: _Fields) -> _Plain:
    """Return the integrals over r, and by ∂σ²/∂s = 2s r² and ∂σ²/∂λ = 2λρ their slopes."""
    mul, sub, div = FIELD.mul, FIELD.sub, FIELD.div
    s, λ = boxes.s, boxes.λ
    rj = grid.r[boxes.bound][:, None]
    r = _cells(grid)
    ρ = Interval(*(np.asarray(end) for end in _radii(grid.r[None, :-1], rj)[1]))
    ρ = Interval(ρ.low, np.asarray(_radii(grid.r[None, 1:], rj)[1].high))
    width = FIELD.sub(exact(grid.r[None, 1:]), exact(grid.r[None, :-1]))
    σ = root_of_positive(F.inside)
    values = _by_middles(grid, boxes, F, σ)
    cube = FIELD.power(σ, 3)
    less = div(mul(width, r), cube)
    by_s = mul(mul(s, less), FIELD.power(r, 2)), mul(mul(s, λ), less)
    by_λ = mul(mul(λ, ρ), less), sub(div(mul(mul(FIELD.power(λ, 2), ρ), width), mul(r, cube)), div(width, mul(r, σ)))
    negative = tuple(tuple(FIELD.unary("neg", x) for x in pair) for pair in (by_s, by_λ))
    return _Plain(values, (negative[0], negative[1]))  # type: ignore[arg-type]


def _by_middles(grid: RadialGrid, boxes: Boxes, F: _Fields, σ: Interval) -> tuple[Interval, Interval]:
    """Enclose ∫ u d(ln r), u = r²/σ and λ/σ, by the middles of cells: 2δ u_m ± δ² (sup u′ − inf u′)/2."""
    mul, add, sub, div = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div
    σ_middle = root_of_positive(F.middle)
    r2 = FIELD.power(_cells(grid), 2)
    bend = div(mul(r2, F.B), mul(_TWO, F.inside))
    middles = np.square(grid.middles)[None, :]
    result = []
    for u, at, power in (
        (div(r2, σ), div(Interval(middles * (1 - 1e-15), middles * (1 + 1e-15)), σ_middle), 2.0),
        (div(boxes.λ, σ), div(boxes.λ, σ_middle), 0.0),
    ):
        slope = mul(u, sub(exact(power), bend))
        with np.errstate(all="ignore"):
            off = (np.asarray(slope.high) - np.asarray(slope.low)) / 2 * np.square(grid.half)[None, :] * (1 + 1e-12)
        width = 2 * grid.half[None, :]
        whole = mul(at, Interval(width * (1 - 1e-11), width))
        result.append(meet(add(whole, Interval(-off, off)), mul(u, Interval(width * (1 - 1e-11), width))))
    return result[0], result[1]


def arcs_of(grid: RadialGrid, boxes: Boxes, *, slopes: bool) -> RadialArcs:
    """Enclose the arcs of some boxes.

    Args:
        grid: cells of r.
        boxes: of the parameters.
        slopes: whether slopes are wanted.
    """
    F = _fields(grid, boxes)
    count, monotone = len(boxes.bound), F.rising | F.falling
    plain = _plain(grid, boxes, F)
    low, high = np.zeros((2, 3, count)), np.full((2, 3, count), np.inf)
    reaches = _reaches(grid, F)
    for arc, reach in enumerate(reaches):
        for k, (c, x) in enumerate(((F.g, F.σ), (F.h, F.φ))):
            whole = reach.active & (reach.there == 1)[:, None]
            for cells, upper in ((reach.passed | whole, False), (whole, True)):
                run = _telescoped(c, x, cells & monotone, F.rising)[upper]
                rest = _summed(plain.values[k], cells & F.plain)[upper]
                if upper:
                    high[k, arc] = np.where(reach.there == 1, run + rest, np.inf)
                else:
                    low[k, arc] = np.maximum(np.nan_to_num(run, nan=0.0, neginf=0.0) + rest, 0.0)
    there = np.stack([reach.there for reach in reaches])
    found = _slopes(grid, boxes, F, plain, reaches) if slopes else None
    returns = np.any(np.asarray(F.square.high)[:, grid.outer + 1 :] < 0, axis=1)
    unknown = Interval(np.zeros(count), np.full(count, np.inf))
    return RadialArcs(Interval(low, high), found, there, np.asarray(boxes.λ.high)[:, 0], returns, unknown)


def _slopes(
    grid: RadialGrid, boxes: Boxes, F: _Fields, plain: _Plain, reaches: tuple[_Reach, _Reach, _Reach]
) -> Interval:
    low, high = np.zeros((2, 2, 3, len(boxes.bound))), np.zeros((2, 2, 3, len(boxes.bound)))
    monotone = F.rising | F.falling
    weights = _nodes(grid, boxes)
    for a, rate in enumerate(_rates(grid, boxes, F)):
        coefficients = _coefficients(grid, boxes, F, rate)
        for k, (x, by) in enumerate(((F.σ, rate.σ), (F.φ, rate.φ))):
            for arc, reach in enumerate(reaches):
                counted = reach.active & monotone
                ends = _boundary(F, counted, weights[k], by)
                run = _telescoped(coefficients[k], x, counted, F.rising)
                rest = _summed(plain.slopes[a][k], reach.active & F.plain)
                with np.errstate(all="ignore"):
                    parts = [ends[i] + run[i] + rest[i] for i in (0, 1)]
                good = (reach.there == 1) & np.isfinite(parts[0]) & np.isfinite(parts[1])
                low[k, a, arc], high[k, a, arc] = np.where(good, parts[0], -np.inf), np.where(good, parts[1], np.inf)
    return Interval(low, high)
