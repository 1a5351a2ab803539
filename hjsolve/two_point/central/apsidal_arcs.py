"""Enclosures of time and angle of radial arcs, and of their slopes, over boxes of the squares of both apsides.

With u = r², P(u) = u V and L²/2m = λ², the radial motion is u̇² ∝ E u − λ² − P(u). Between the apsides p < u < a

    E = P[p, a],   λ² = p E − P(p),   E u − λ² − P(u) = (u − p)(a − u) G(u),   G(u) = P[p, u, a]

(divided differences), so that with u = p cos²(θ/2) + a sin²(θ/2) for the time, and 1/u = cos²(ν/2)/p + sin²(ν/2)/a for
the angle,

    dt = √(m/2) K dθ,  K = 1/(2√G);    dφ = h dν,  h = √((E − V(p))/aG)/2,

without a singularity at either end. G is constant for an isotropic oscillator, and ν is the true anomaly of a Kepler
ellipse; G > 0 wherever u V is convex. The slopes of divided differences are divided differences with a repeated
argument: ∂P[p, u, a]/∂p = P[p, p, u, a], and ∂E/∂p = P[p, p, a]. The parameters are x and y with p = u_low − x² and
a = u_high + y²; the places are passed at

    tan(θ/2) = x/√(a − u_low),  tan((π − θ)/2) = y/√(u_high − p),  tan(ν/2) = √(a/p) tan(θ/2),

which are smooth functions of x and y where a place is an apsis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.interval import Interval, exact, hull, meet, over_shape
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.lowering import lower
from hjsolve.two_point.central.radial_arcs import DIRECT, INNER, OUTER, RadialArcs
from hjsolve.two_point.central.radial_grid import FIELD, root_of_positive, summed

_EPS = 1e-15
mul, add, sub, div, power = FIELD.mul, FIELD.add, FIELD.sub, FIELD.div, FIELD.power


_HALF, _ONE, _TWO, _SIXTH = exact(0.5), exact(1.0), exact(2.0), div(exact(1.0), exact(6.0))


def _middle(x: Interval) -> Interval:
    return exact((np.asarray(x.low) + np.asarray(x.high)) / 2)


def _from(x: Interval, middle: Interval) -> Interval:
    """Return x − its middle."""
    return Interval(
        np.minimum(np.asarray(x.low) - middle.low, 0) * (1 + _EPS),
        np.maximum(np.asarray(x.high) - middle.low, 0) * (1 + _EPS),
    )


def _positive(x: Interval) -> Interval:
    return Interval(np.maximum(x.low, 0), x.high)


class PotentialJet(NamedTuple):
    """P, P′, P″ and P‴ at one place, or over a range."""

    value: Interval
    first: Interval
    second: Interval
    third: Interval


class SquarePotential:
    """P(u) = u V(√u) with its derivatives."""

    def __init__(self, r: sp.Symbol, V: sp.Expr):
        u = sp.Symbol("u", positive=True)
        P = sp.simplify(u * V.subs(r, sp.sqrt(u)))
        self._tape = lower([P, *(sp.simplify(sp.diff(P, u, k)) for k in (1, 2, 3))], [u])
        plain = sp.simplify(V.subs(r, sp.sqrt(u)))
        self._plain = lower([plain, sp.simplify(sp.diff(plain, u))], [u])

    def plain(self, u: Interval) -> tuple[Interval, Interval]:
        """Enclose V and its derivative by u.

        Args:
            u: a range of u > 0.
        """
        rows = self._plain.run(FIELD, [u])
        shape = np.shape(u.low)
        V, slope = (over_shape(row, shape) for row in rows)
        return V, slope

    def over(self, u: Interval) -> PotentialJet:
        """Enclose P and its derivatives.

        Args:
            u: a range of u > 0.
        """
        rows = self._tape.run(FIELD, [u])
        shape = np.shape(u.low)
        return PotentialJet(*(over_shape(row, shape) for row in rows))


class _Pair(NamedTuple):
    """Divided differences of two arguments v < w: P[v, w], P[v, v, w] and P[v, w, w]."""

    plain: Interval
    lower: Interval
    upper: Interval


def _pair(P: SquarePotential, v: Interval, w: Interval) -> _Pair:
    """Enclose them by derivatives over the hull, by quotients, and by quotients at the middles with slopes.

    The first also serve where v = w, and the last for narrow ranges of both.
    """
    between = P.over(hull(v, w))
    shape = np.broadcast_shapes(np.shape(v.low), np.shape(w.low))
    v0, w0 = (exact(np.broadcast_to(_middle(x).low, shape)) for x in (v, w))
    dv, dw = _from(v, _middle(v)), _from(w, _middle(w))
    at_v, at_w, over_v, over_w = P.over(v0), P.over(w0), P.over(v), P.over(w)
    gap, gap0 = sub(w, v), sub(w0, v0)
    plain0 = div(sub(at_w.value, at_v.value), gap0)
    low0, high0 = div(sub(plain0, at_v.first), gap0), div(sub(at_w.first, plain0), gap0)
    plain = meet(between.first, div(sub(over_w.value, over_v.value), gap))
    second, third = mul(_HALF, between.second), mul(_SIXTH, between.third)
    low = meet(second, div(sub(plain, over_v.first), gap))
    high = meet(second, div(sub(over_w.first, plain), gap))
    for _ in range(2):
        plain = meet(plain, add(plain0, add(mul(low, dv), mul(high, dw))))
        low = meet(low, div(sub(plain, over_v.first), gap))
        high = meet(high, div(sub(over_w.first, plain), gap))
        mixed = meet(third, div(sub(high, low), gap))
        first = meet(third, div(sub(low, mul(_HALF, over_v.second)), gap))
        last = meet(third, div(sub(mul(_HALF, over_w.second), high), gap))
        low = meet(low, add(low0, add(mul(mul(_TWO, first), dv), mul(mixed, dw))))
        high = meet(high, add(high0, add(mul(mixed, dv), mul(mul(_TWO, last), dw))))
    return _Pair(meet(plain, add(plain0, add(mul(low, dv), mul(high, dw)))), low, high)


class ApsidalBoxes(NamedTuple):
    """Boxes of (x, y), arrays of shape (b, 1); and u at the places."""

    x: Interval
    y: Interval
    u_low: float
    u_high: float


class _Orbit(NamedTuple):
    """What does not depend on u: apsides, their difference, P[p, a], and λ²/p = E − V(p) with slopes by p and a."""

    p: Interval
    a: Interval
    width: Interval
    ends: _Pair
    excess: Interval
    excess_p: Interval
    excess_a: Interval

    @property
    def λ2(self) -> Interval:
        """λ²."""
        return mul(self.p, self.excess)


class Triple(NamedTuple):
    """G = P[p, u, a] and its slopes by p, u and a."""

    G: Interval
    p: Interval
    u: Interval
    a: Interval


def _orbit(P: SquarePotential, boxes: ApsidalBoxes) -> _Orbit:
    p = sub(exact(boxes.u_low), power(boxes.x, 2))
    p = Interval(np.maximum(p.low, 1e-300), np.maximum(p.high, 1e-300))
    a = add(exact(boxes.u_high), power(boxes.y, 2))
    width = add(add(exact(boxes.u_high - boxes.u_low), power(boxes.x, 2)), power(boxes.y, 2))
    ends = _pair(P, p, a)
    p0, a0 = _middle(p), _middle(a)
    (V, slope), (V0, _) = P.plain(p), P.plain(p0)
    by_p, by_a = sub(ends.lower, slope), ends.upper
    excess = add(sub(_pair(P, p0, a0).plain, V0), add(mul(by_p, _from(p, p0)), mul(by_a, _from(a, a0))))
    return _Orbit(p, a, width, ends, meet(excess, sub(ends.plain, V)), by_p, by_a)


def energies_of(P: SquarePotential, boxes: ApsidalBoxes) -> Interval:
    """Enclose E, shape (b, 1).

    Args:
        P: u V.
        boxes: of (x, y).
    """
    return _orbit(P, boxes).ends.plain


def constants_of(P: SquarePotential, boxes: ApsidalBoxes) -> tuple[float, float]:
    """Return E and λ² of one pair (x, y), in the middle of their enclosures.

    Args:
        P: u V.
        boxes: the pair.
    """
    orbit = _orbit(P, boxes)
    E, λ2 = _middle(orbit.ends.plain), _middle(orbit.λ2)
    return float(np.asarray(E.low)[0, 0]), float(np.asarray(λ2.low)[0, 0])


def _triple(P: SquarePotential, orbit: _Orbit, u: Interval) -> Triple:
    """Enclose G and its slopes at places of the orbit; shape (b, cells)."""
    p, a, width = orbit.p, orbit.a, orbit.width
    low, high = _pair(P, p, u), _pair(P, u, a)
    G = div(sub(high.plain, low.plain), width)
    between = P.over(hull(hull(p, u), a))
    G = meet(G, mul(_HALF, between.second))
    third = mul(_SIXTH, between.third)

    def slopes(G: Interval) -> tuple[Interval, Interval, Interval]:
        return (
            meet(div(sub(G, low.lower), width), third),
            meet(div(sub(high.lower, low.upper), width), third),
            meet(div(sub(high.upper, G), width), third),
        )

    by_p, by_u, by_a = slopes(G)
    p0, u0, a0 = _middle(p), _middle(u), _middle(a)
    thin = div(sub(_pair(P, u0, a0).plain, _pair(P, p0, u0).plain), sub(a0, p0))
    spread = add(add(mul(by_p, _from(p, p0)), mul(by_u, _from(u, u0))), mul(by_a, _from(a, a0)))
    G = meet(G, add(thin, spread))
    return Triple(G, *slopes(G))


class _Passage(NamedTuple):
    """θ or ν at a place, or what it lacks to π, with its slopes by x and y."""

    angle: Interval
    x: Interval
    y: Interval


class _Stretch(NamedTuple):
    """One arc: from where to where in θ or ν, how long, and the parts at which it is cut, shape (b, n + 1)."""

    begin: _Passage
    end: _Passage
    length: Interval
    parts: Reals


def _passages(boxes: ApsidalBoxes, orbit: _Orbit, *, anomaly: bool) -> tuple[_Passage, _Passage]:
    """θ or ν of the lower place, and π less that of the upper one."""
    gap, x, y, width = exact(boxes.u_high - boxes.u_low), boxes.x, boxes.y, orbit.width
    # what tan(θ/2) is multiplied by for tan(ν/2), and its inverse for what lacks to π
    factor = root_of_positive(div(orbit.a, orbit.p)) if anomaly else _ONE
    inverse = root_of_positive(div(orbit.p, orbit.a)) if anomaly else _ONE
    result = []
    for z, other, by_z, by_other, swap in ((x, y, factor, inverse, False), (y, x, inverse, factor, True)):
        c = root_of_positive(add(gap, power(other, 2)))
        with np.errstate(all="ignore"):
            angle = mul(_TWO, FIELD.unary("atan", mul(by_z, div(z, c))))
        angle = meet(angle, Interval(np.zeros(1), np.full(1, np.pi * (1 + _EPS))))
        own = div(mul(_TWO, mul(by_z, c)), width)
        cross = FIELD.unary("neg", div(mul(_TWO, mul(by_other, mul(z, div(other, c)))), width))
        result.append(_Passage(_positive(angle), *((cross, own) if swap else (own, cross))))
    return result[0], result[1]


def _stretches(boxes: ApsidalBoxes, orbit: _Orbit, count: int, *, anomaly: bool) -> tuple[_Stretch, _Stretch, _Stretch]:
    """Return the direct, the outer and the inner arc, cut so that neither θ nor ν changes much over a cell."""
    lower_, upper = _passages(boxes, orbit, anomaly=anomaly)
    zero, π = exact(np.zeros_like(boxes.x.low)), FIELD.pi()
    start, finish = _Passage(zero, zero, zero), _Passage(add(zero, π), zero, zero)
    away = _Passage(_positive(sub(π, upper.angle)), FIELD.unary("neg", upper.x), FIELD.unary("neg", upper.y))
    result = []
    between = sub(away.angle, lower_.angle)
    for begin, end, length in ((lower_, away, between), (away, finish, upper.angle), (start, lower_, lower_.angle)):
        first, last = (
            np.clip((np.asarray(e.angle.low) + np.asarray(e.angle.high)) / 2, 0, np.pi) for e in (begin, end)
        )
        result.append(_Stretch(begin, end, _positive(length), _parts(orbit, first, last, count, anomaly=anomaly)))
    return result[0], result[1], result[2]


def _parts(orbit: _Orbit, first: Reals, last: Reals, count: int, *, anomaly: bool) -> Reals:
    """Cut an arc at even steps of θ, of ν and of ln u, a third each, so that a cell is short in all of them."""
    p, a = (np.maximum(_middle(x).low, 1e-300) for x in (orbit.p, orbit.a))
    stretch = np.sqrt(a / p)
    third = count // 3
    even, some, rest = (np.linspace(0, 1, n + 1)[None, 1:-1] for n in (count - 2 * third, third + 1, third + 1))

    def mapped(angle: Reals, factor: Reals) -> Reals:
        return 2 * np.arctan2(factor * np.sin(angle / 2), np.cos(angle / 2))

    θ0, θ1 = (mapped(e, 1 / stretch) if anomaly else e for e in (first, last))
    ν0, ν1 = (mapped(e, stretch) for e in (θ0, θ1))
    logs = [np.log(p + (a - p) * np.sin(e / 2) ** 2) for e in (θ0, θ1)]
    with np.errstate(all="ignore"):
        sine2 = (np.exp(logs[0] + (logs[1] - logs[0]) * rest) - p) / (a - p)
        places = [θ0 + (θ1 - θ0) * even, mapped(ν0 + (ν1 - ν0) * some, 1 / stretch), 2 * np.arcsin(np.sqrt(sine2))]
        angles = [mapped(e, stretch) if anomaly else e for e in places]
        inner = (np.concatenate(angles, axis=1) - first) / (last - first)
    inner = np.clip(np.where(np.isfinite(inner), inner, 0.5), 0, 1)
    ends = np.zeros((len(inner), 1)), np.ones((len(inner), 1))
    return np.sort(np.concatenate([ends[0], inner, ends[1]], axis=1), axis=1)


def _angles(arc: _Stretch, parts: Reals) -> Interval:
    """θ or ν at parts of an arc."""
    return add(mul(arc.begin.angle, sub(_ONE, exact(parts))), mul(arc.end.angle, exact(parts)))


class _Columns(NamedTuple):
    """u, and cos² and sin² of θ/2 or ν/2, over cells or at their middles; shape (b, m)."""

    u: Interval
    cosine2: Interval
    sine2: Interval


def _columns(orbit: _Orbit, arcs: tuple[_Stretch, ...], *, anomaly: bool) -> _Columns:
    """All cells of the arcs, then the middles of all cells."""
    cells, middles = [], []
    for arc in arcs:
        angle = _angles(arc, arc.parts)
        cells.append(Interval(np.asarray(angle.low)[:, :-1], np.asarray(angle.high)[:, 1:]))
        middles.append(_angles(arc, (arc.parts[:, :-1] + arc.parts[:, 1:]) / 2))
    ends = [np.concatenate([np.asarray(x[k]) for x in (*cells, *middles)], axis=1) for k in (0, 1)]
    half = Interval(np.maximum(ends[0], 0) / 2, np.minimum(ends[1], np.pi * (1 + _EPS)) / 2)
    sine2, cosine2 = (power(FIELD.unary(name, half), 2) for name in ("sin", "cos"))
    # u rises with the angle, with p and with a
    u = []
    for k, place in enumerate((half.low, half.high)):
        at = exact(place)
        s2, c2 = (power(FIELD.unary(name, at), 2) for name in ("sin", "cos"))
        p, a = exact(orbit.p[k]), exact(orbit.a[k])
        value = div(_ONE, add(div(c2, p), div(s2, a))) if anomaly else add(mul(c2, p), mul(s2, a))
        u.append(np.asarray(value[k]))
    inside = Interval(np.maximum(u[0], orbit.p.low), np.minimum(u[1], orbit.a.high))
    return _Columns(inside, cosine2, sine2)


def _rates(
    boxes: ApsidalBoxes, orbit: _Orbit, T: Triple, at: _Columns, *, anomaly: bool, slopes: bool
) -> tuple[Interval, Interval, tuple[Interval, ...]]:
    """K or h; its rate by θ or ν; and by x and y. Where G may be zero it is bounded from below alone."""
    with np.errstate(all="ignore"):
        value = Interval(
            0.5 / np.sqrt(np.maximum(T.G.high, 0)) * (1 - _EPS),
            np.where(T.G.low > 0, 0.5 / np.sqrt(np.maximum(T.G.low, 0)) * (1 + _EPS), np.inf),
        )
    double, u2 = mul(_TWO, T.G), power(at.u, 2)
    turn = mul(orbit.width, root_of_positive(mul(at.sine2, at.cosine2)))  # du/dθ = (a − p) sin(θ/2) cos(θ/2)
    by_p, by_a = at.cosine2, at.sine2
    relative_p, relative_a = exact(0.0), exact(0.0)
    if anomaly:
        value = mul(value, root_of_positive(div(orbit.excess, orbit.a)))
        turn = div(mul(turn, u2), mul(orbit.p, orbit.a))
        by_p, by_a = mul(at.cosine2, div(u2, power(orbit.p, 2))), mul(at.sine2, div(u2, power(orbit.a, 2)))
        relative_p = mul(_HALF, div(orbit.excess_p, orbit.excess))
        relative_a = mul(_HALF, sub(div(orbit.excess_a, orbit.excess), div(_ONE, orbit.a)))
    by_angle = mul(mul(value, turn), FIELD.unary("neg", div(T.u, double)))
    if not slopes:
        return value, by_angle, ()
    found = []
    for z, own, moved, relative in (
        (mul(exact(-2.0), boxes.x), T.p, by_p, relative_p),
        (mul(_TWO, boxes.y), T.a, by_a, relative_a),
    ):
        found.append(mul(mul(value, z), sub(relative, div(add(own, mul(T.u, moved)), double))))
    return value, by_angle, (found[0], found[1])


def _taken(x: Interval, columns: slice) -> Interval:
    return Interval(np.asarray(x.low)[:, columns], np.asarray(x.high)[:, columns])


def _sum(x: Interval) -> Interval:
    """Σ over cells, shape (b, 1)."""
    total = summed(x)
    return Interval(total.low[:, None], total.high[:, None])


class _Found(NamedTuple):
    """Of the three arcs, shape (b, 1) each: the integral, and its slopes by x and y; and where G has a sign."""

    values: list[Interval]
    slopes: list[tuple[Interval, ...]]
    positive: Mask
    negative: Mask


def _integrals(
    P: SquarePotential, boxes: ApsidalBoxes, orbit: _Orbit, count: int, *, anomaly: bool, slopes: bool
) -> _Found:
    """∫ K dθ or ∫ h dν over the arcs."""
    arcs = _stretches(boxes, orbit, count, anomaly=anomaly)
    at = _columns(orbit, arcs, anomaly=anomaly)
    places = [exact(np.full_like(boxes.x.low, u)) for u in (boxes.u_low, boxes.u_high)]
    T = _triple(P, orbit, at.u)
    value, by_angle, by_xy = _rates(boxes, orbit, T, at, anomaly=anomaly, slopes=slopes)
    ends = []
    for u in places if slopes else ():
        still = _Columns(u, exact(0.0), exact(0.0))
        ends.append(_rates(boxes, orbit, _triple(P, orbit, u), still, anomaly=anomaly, slopes=False)[0])
    values, found = [], []
    for k, arc in enumerate(arcs):
        cells, middles = (slice(n * count, (n + 1) * count) for n in (k, k + 3))
        width = mul(arc.length, sub(exact(arc.parts[:, 1:]), exact(arc.parts[:, :-1])))
        rate = _taken(by_angle, cells)
        with np.errstate(all="ignore"):
            off = (np.asarray(rate.high) - np.asarray(rate.low)) / 8 * np.square(width.high) * (1 + 1e-12)
            off = np.where(np.isfinite(off), off, np.inf)
        by_middle = add(mul(_taken(value, middles), width), Interval(-off, off))
        values.append(_sum(meet(mul(_taken(value, cells), width), by_middle)))
        totals = []
        for j in (0, 1) if slopes else ():
            total = _sum(mul(_taken(by_xy[j], cells), width))
            if k != INNER:
                upper = arc.begin if k == OUTER else arc.end
                total = add(total, mul(exact(-1.0 if k == OUTER else 1.0), mul(ends[1], upper[1 + j])))
            if k != OUTER:
                lower_ = arc.end if k == INNER else arc.begin
                total = add(total, mul(exact(1.0 if k == INNER else -1.0), mul(ends[0], lower_[1 + j])))
            totals.append(total)
        found.append(tuple(totals))
    return _Found(values, found, np.all(T.G.low > 0, axis=1), np.any(T.G.high < 0, axis=1))


def arcs_between_apsides(P: SquarePotential, boxes: ApsidalBoxes, count: int, *, slopes: bool) -> RadialArcs:
    """Enclose the arcs of some boxes, in the order of ``radial_arcs``.

    Args:
        P: u V.
        boxes: of (x, y).
        count: of cells of an arc.
        slopes: by x and y, whether they are wanted.
    """
    orbit = _orbit(P, boxes)
    found = [_integrals(P, boxes, orbit, count, anomaly=anomaly, slopes=slopes) for anomaly in (False, True)]
    λ_low, λ_high = (np.asarray(x)[:, 0] for x in orbit.λ2)
    bounded = found[0].positive & found[1].positive & (λ_low > 0)
    never = found[0].negative | found[1].negative | (λ_high < 0)
    b = len(boxes.x.low)
    low, high = np.zeros((2, 3, b)), np.full((2, 3, b), np.inf)
    slope_low, slope_high = np.full((2, 2, 3, b), -np.inf), np.full((2, 2, 3, b), np.inf)
    for i, integrals in enumerate(found):
        for k in range(3):
            if k == DIRECT and boxes.u_low == boxes.u_high:
                high[i, k], slope_low[i, :, k], slope_high[i, :, k] = 0.0, 0.0, 0.0
                continue
            value = integrals.values[k]
            low[i, k] = np.maximum(value.low[:, 0], 0)
            high[i, k] = np.where(bounded, value.high[:, 0], np.inf)
            for j, slope in enumerate(integrals.slopes[k]):
                slope_low[i, j, k] = np.where(bounded, slope.low[:, 0], -np.inf)
                slope_high[i, j, k] = np.where(bounded, slope.high[:, 0], np.inf)
    there = np.broadcast_to(np.where(never, -1, np.where(bounded, 1, 0)), (3, b)).copy()
    most = np.sqrt(np.maximum(λ_high, 0)) * (1 + _EPS)
    sloped = Interval(slope_low, slope_high) if slopes else None
    fastest, slowest = (np.asarray(x)[:, 0] for x in (orbit.p.low, orbit.a.high))
    rate = Interval(np.sqrt(np.maximum(λ_low, 0)) / slowest * (1 - 4 * _EPS), most / fastest * (1 + 4 * _EPS))
    return RadialArcs(Interval(low, high), sloped, there, most, np.ones(b, dtype=bool), rate)
