"""How many nodes resolve a motion, proved: nothing can hide between them.

Over an anomaly χ the integrands of a bounded motion are periodic. If one is analytic in the strip |Im χ| ≤ a and at
most M there, its Fourier coefficients are at most 2M e^{−ak}, so that N nodes over half a turn of an even function (2N
over a turn) give it everywhere to within 4M e^{−aN}/(1 − e^{−a}) (Trefethen & Weideman, SIAM Review 56 (2014) 385,
Theorem 3.1). The strip is proved by covering it with disks: over each the regular factor R of p² is evaluated in disk
arithmetic (``one_coordinate.regular_factor``), and where every operation is defined and 0 is not in the disk of R, all
integrands are analytic. Squares that cannot be decided are divided; one that still cannot be decided when it is small
against its height bounds the strip from above. A dip, a step or a pole of whatever width is in the formula, so it is in
the disks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks
from hjsolve.arithmetic.floats import ComplexPoints
from hjsolve.arithmetic.number_types import Complexes, Elementwise, Integers, Mask, Reals
from hjsolve.arithmetic.reciprocals import without_overflow
from hjsolve.arithmetic.tape import BoundTape
from hjsolve.arithmetic.work_counter import count
from hjsolve.one_coordinate.complex_anomaly import ComplexPlace, PlaceDisks, complex_place, place_disks
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.regular_factor import Deflated, deflated
from hjsolve.one_coordinate.stretched_anomaly import Inner, Stretched
from hjsolve.one_coordinate.strip_squares import StripSquares, in_a_cone, straight_above

_DISKS, _POINTS = Disks(), ComplexPoints()
_CIRCLE = np.exp(2j * np.pi * np.arange(20) / 20)
"""Places at which a function is looked at: with t = 1/``_WIDER`` they miss 2t²⁰/(1 − t) = 1.2e-4 of its bound on the
wider disk, so that a bound a thousand times too large still tells a tenth."""
_WIDER = 1.7
"""The disk over which a formula is enclosed, in units of the one over which its series is taken. With 1.35 twenty
points would miss 2 % of the bound; with 2.4 the bounds themselves are so wide that 27 motions took 15 % longer."""
_ROUNDING = 2.0**-40
"""Rounding of a value at a point, relative to the bound of the formula as it stands, with room to spare."""
_HIGHEST, _LOWEST = 3.2, 1e-9
"""Half widths of a strip that are tried: 12 nodes need no more than the highest."""
_HEIGHTS = _HIGHEST * 0.85 ** np.arange(30)[::-1]
"""Half widths at which points are tried first."""
_WIDE = 0.7
"""Half width from which on the nodes are so few that a wider strip would cost more than it saves."""
_FIRST, _ROWS, _HIGH = 0.85, 4, 0.7
"""Part of such a half width that is to be proved; rows of squares; part of it that is enough. Eight rows cost a quarter
of the time of a motion more and changed no digit in doubles; with two, strips are proved less wide."""
_EXPLAINED = 0.6
"""What lies higher than that part of its distance from an obstacle is explained by it. 0.3 and 0.8 gave the same 27
motions the same bits."""
_COARSE, FINE = 0.15, 0.05
"""A square of that fraction of its height which cannot be decided bounds the strip; where many nodes are at stake.
Twice of both gives the same bits in doubles, half of them other nodes in no less time."""
_MOST_PLACES = 300
"""Rough places through which a phase is stretched; where there are more, the nodes are spaced evenly."""
_MOST_SQUARES, _MOST_SQUARES_SEARCHED, _MOST_OBSTACLES = 40000, 40000, 4000
"""Squares evaluated before a strip is taken as it is, or a search for obstacles is given up; most obstacles."""
_BLOCK = 512
"""Squares evaluated at once: a square is twenty points of every operation of a formula, some 50 kB."""


class Strip(NamedTuple):
    """Proved: over |Im χ| ≤ width the integrands are analytic.

    Attributes:
        width: half width of the strip.
        growth: the greatest ln(M/size) of an integrand, size being what it reaches on the real axis.
    """

    width: float
    growth: float

    def nodes(self, digits: int) -> int:
        """Return the nodes, for half a turn, that leave less than 10^−(digits + 1) of the size."""
        # 4M e^(−aN)/(1 − e^(−a)) ≤ 10^−(digits + 1) size, solved for N
        wanted = (digits + 1) * math.log(10) + self.growth + math.log(4 / -math.expm1(-self.width))
        return math.ceil(wanted / self.width)


@dataclass(frozen=True)
class AsItStands:
    """p² of a rotation, which has no turning points to be divided by: R = p².

    Attributes:
        disks, points: its tape with all but q known, over disks and at points.
    """

    disks: BoundTape[Disk]
    points: BoundTape[Complexes]

    def over(self, q: Disk, *_: Disk | None) -> tuple[Disk, int]:
        """Enclose R over disks, as ``Deflated.over`` does; one method gives it."""
        return self.disks.run(q)[0], 0

    def at(self, q: Complexes, *_: Complexes | Integers | int | None) -> Complexes:
        """Return R at complex places, in doubles.

        Args:
            q: complex, shape (m,).
            *_: for q − a, q − b and the method that gives R.
        """
        return self.points.run(q)[0]

    def methods(self, q: Complexes, *_: Complexes | None) -> tuple[Complexes, ...]:
        """Return R at complex places by every method; there is one.

        Args:
            q: complex, shape (m,).
            *_: for q − a and q − b, which a rotation has not.
        """
        return (self.points.run(q)[0],)


@dataclass(frozen=True)
class Integrands:
    """What is to be resolved, bound to the constants of a motion.

    Attributes:
        anomaly: the map.
        squared: p², by its second difference for a libration.
        kernels: those that are integrated, in disks; and in complex doubles.
    """

    anomaly: Inner | Stretched
    squared: Deflated | AsItStands
    kernels: tuple[BoundTape[Disk], BoundTape[Complexes]]

    def over(self, seen: PlaceDisks) -> tuple[list[Disk], Integers | int]:
        """Enclose R and the kernels over disks; and tell how R is known best, see ``Deflated.over``.

        Args:
            seen: disks that hold q, q − a and q − b.
        """
        factor, method = self.squared.over(seen.q, seen.from_lower, seen.from_upper)
        return [factor, *self.kernels[0].run(seen.q)], method

    def at(self, seen: ComplexPlace, method: Integers | int = 0) -> list[Complexes]:
        """Return R and the kernels at points.

        Args:
            seen: complex places.
            method: which of the methods that give R, see ``Deflated.methods``.
        """
        factor = self.squared.at(seen.q, seen.from_lower, seen.from_upper, method)
        return [factor, *self.kernels[1].run(seen.q)]

    def factors(self, seen: ComplexPlace) -> tuple[Complexes, ...]:
        """Return R at points in every available form; where terms cancel one of them may be nothing but rounding."""
        return self.squared.methods(seen.q, seen.from_lower, seen.from_upper)


def integrands_to_resolve(
    anomaly: Inner | Stretched, radicand: MomentumSquared, skipped: tuple[bool, ...], parts: frozenset[str], bits: int
) -> Integrands:
    """Bind the formulas of a motion to its constants.

    Args:
        anomaly: the map, even or not.
        radicand: p² and its kernels.
        skipped: kernels that are zero everywhere.
        parts: what is integrated, of ``PARTS``.
        bits: of the constants.
    """
    exact = radicand.inputs(bits)
    points: list[Disk] = [_DISKS.point(x) for x in exact]
    numbers: list[Elementwise] = [float(x) for x in exact]
    # over disks a quotient of two overflows is unknown: exponentials are written so that they decay
    squared, kernels = (without_overflow(tape, packets=True) for tape in (radicand.squared, radicand.kernels))
    kernels = kernels.only(*(j for j, skip in enumerate(skipped) if not skip and "time" in parts))
    with np.errstate(all="ignore"):
        both = kernels.bind(_DISKS, points), kernels.bind(_POINTS, numbers)
        if not anomaly.even:
            return Integrands(anomaly, AsItStands(squared.bind(_DISKS, points), squared.bind(_POINTS, numbers)), both)
        inner: Any = getattr(anomaly, "inner", anomaly)
        # the width apart from the ends: b − a of close turning points is not the difference of two doubles
        ends = (_DISKS.point(x) for x in (inner.lower, inner.upper, inner.width))
        return Integrands(anomaly, deflated(squared, points, *ends), both)


def strip(subject: Integrands, digits: int, coarse: float = _COARSE, *, zeros: bool = True) -> Strip | None:
    """Find a strip in which the integrands are analytic, as wide as disks can prove.

    Args:
        digits: for which the strip should need few nodes.
        coarse: a square of that share of its height which cannot be decided bounds the strip.
        zeros: False to let R have zeros in the strip: then R and the kernels are analytic in it, and the growth is
            theirs, but not the integrands. Where doubles cannot tell R from 0, next to a separatrix, this is what
            they can prove; a zero of R shows in the values of R at the nodes, which tell all of R.

    Returns:
        The strip that needs the fewest nodes; None where no strip could be proved in doubles.
    """
    # points say how wide the strip may be; where it is wide, a part of it is enough, for the nodes are few
    # points are cheap against disks: they say how high it is worth to go
    cap = _foreseen(subject) if zeros else _HIGHEST / 2
    high = _HIGH * cap if cap > _WIDE and coarse == _COARSE else cap
    done: list[tuple[Reals, Reals]] = []
    size, work = np.zeros(len(subject.kernels[0].outputs) + (2 if zeros else 1)), 0
    todo, waiting = _covering(subject, cap), StripSquares.none()
    while todo.x.size and cap > 0:
        work += todo.x.size
        logs, here = _sizes(subject, todo, zeros=zeros)
        fine = np.all(np.isfinite(logs), axis=0)
        # the size on the real axis, from squares with y = 0, is what errors are relative to
        size = np.maximum(size, here)
        done.append((todo.y[fine], logs[:, fine]))
        # a square that will not be decided any more bounds the strip from above; whatever lies higher is dropped
        left = todo.chosen(~fine)
        # small against its height: dividing it further would gain less of the width than it costs
        hopeless = _hopeless(left, coarse) | ((left.y >= high) & (len(done) > 1)) | (work > _MOST_SQUARES)
        # its lower edge is the top of the strip: the squares below it are proved
        cap = min([cap, *left.y[hopeless]])
        left = left.chosen(~hopeless).beside(waiting)
        left = left.chosen(left.y < cap)
        # the lowest rows go first, since they may lower the cap; squares that are above the cap then need not be seen
        # rows next to the axis first: one of them that fails makes all higher ones needless
        low = left.y < 2 * np.min(left.top, initial=cap)
        todo, waiting = left.chosen(low).divided(), left.chosen(~low)
        todo = todo.chosen(todo.y < cap)
    if cap <= 0:
        return None
    return _cheapest(cap, np.concatenate([y for y, _ in done]), np.hstack([logs for _, logs in done]), size, digits)


def obstacles(subject: Integrands) -> list[tuple[float, float]] | None:
    """Find where the integrands may be singular next to the real axis: the places a change of variable must spread.

    A square that cannot be decided and is small against its height is an obstacle; what lies straight above a square
    that is not decided either waits, and what lies above the cone over an obstacle is not looked at.

    Returns:
        (Re χ, Im χ) of obstacles, the lowest first; None where they are too many, or one is as good as real.
    """
    found, work = np.zeros((2, 0)), 0
    todo, waiting = _covering(subject, _HIGHEST / 4), StripSquares.none()
    while todo.x.size:
        work += todo.x.size
        fine = np.all(np.isfinite(_sizes(subject, todo)[0]), axis=0)
        left = todo.chosen(~fine).beside(waiting)
        # what lies over an undecided square waits: its obstacle may be the same one
        above = straight_above(left)
        left, waiting = left.chosen(~above), left.chosen(above)
        # an obstacle: a singularity lies in the square or next to it
        hopeless = _hopeless(left)
        if work > _MOST_SQUARES_SEARCHED or found.shape[1] > _MOST_OBSTACLES or np.any(left.y[hopeless] == 0):
            return None
        found = np.concatenate([found, np.stack([left.x + left.side / 2, left.y])[:, hopeless]], axis=1)
        todo = left.chosen(~hopeless).divided()
        # what lies in the cone over an obstacle is explained by it: the stretched phase is slow there already
        todo, waiting = (part.chosen(~in_a_cone(part, found)) for part in (todo, waiting))
        if not todo.x.size:
            todo, waiting = waiting, StripSquares.none()
    order = np.argsort(found[1])
    return [(float(x), float(y)) for x, y in found[:, order].T]


def approximate_places(subject: Integrands) -> list[tuple[float, float]] | None:
    """Choose the obstacles that explain all others: what lies as high as half its distance from one of them is its.

    Returns:
        (χₖ, δₖ), the distance from the real axis below 1; None where they are too many or imprecise in doubles.
    """
    x, y = np.zeros(0), np.zeros(0)
    for χ, height in obstacles(subject) or []:
        # the lowest first: each explains the higher ones about it
        if height < 1 and not np.any(height > _EXPLAINED * np.hypot(_apart(χ - x, subject), y)):
            x, y = np.append(x, χ), np.append(y, height)
    return list(zip(x.tolist(), y.tolist(), strict=True)) if len(x) <= _MOST_PLACES else None


def _apart(x: Reals, subject: Integrands) -> Reals:
    """Return the distance of two phases of a circle."""
    return np.abs(x) if subject.anomaly.even else np.abs(np.remainder(x + np.pi, 2 * np.pi) - np.pi)


def _covering(subject: Integrands, height: float) -> StripSquares:
    """Squares that cover the strip up to a height, of a quarter of its size."""
    begin, length = (0.0, np.pi) if subject.anomaly.even else (-np.pi, 2 * np.pi)
    columns = math.ceil(_ROWS * length / height)
    # squares and no flat rectangles: a disk is put about each
    side = length / columns
    x, y = np.meshgrid(begin + side * np.arange(columns), side * np.arange(math.ceil(height / side)))
    return StripSquares(x.ravel(), y.ravel(), np.full(x.size, side))


def _hopeless(squares: StripSquares, coarse: float = _COARSE) -> Mask:
    return squares.side <= np.maximum(coarse * squares.y, _LOWEST)


def _foreseen(subject: Integrands) -> float:
    """Return a half width to begin with: the greatest at which R does not yet turn round 0, as points tell."""
    begin, turn = (0.0, 1) if subject.anomaly.even else (-np.pi, 2)
    columns = 192 if isinstance(subject.anomaly, Stretched) else 12
    χ = np.linspace(begin, np.pi, turn * columns + 1) + 1j * _HEIGHTS[:, None]
    with np.errstate(all="ignore"):
        # each form of R cancels elsewhere: a height is clear if one of them says so
        methods = [np.broadcast_to(R, χ.shape) for R in subject.factors(complex_place(subject.anomaly, χ))]
        # the argument principle: a zero or pole of R below this height turns R along it
        turns = [np.sum(np.angle(R[:, 1:] / R[:, :-1]), axis=1) for R in methods]
        calm = np.any([np.isfinite(t) & (np.abs(t) < 1) for t in turns], axis=0)
        clear = np.cumprod(calm).astype(bool)
    found = float(np.max(_HEIGHTS[clear], initial=_HEIGHTS[0]))
    return found * _FIRST if found > _WIDE else found


def _cheapest(cap: float, y: Reals, logs: Reals, size: Reals, digits: int) -> Strip:
    """Return the strip, of all that are proved, that needs the fewest nodes."""
    with np.errstate(all="ignore"):
        # ln(M/size) of the worst integrand on every square; a strip is as bad as the worst square in it
        excess = np.max(np.where(size[:, None] > 0, logs - np.log(size)[:, None], -np.inf), axis=0, initial=0.0)
    order = np.argsort(y)
    # the growth over a strip is the greatest of all squares below its edge: a narrower strip may need fewer nodes
    heights, growths = y[order], np.maximum.accumulate(excess[order])
    # the lower edges of squares are the widths for which all below is proved
    edges = np.unique(heights[(heights > 0) & (heights < cap)])
    found = [Strip(float(h), float(growths[np.searchsorted(heights, h, side="left") - 1])) for h in (*edges, cap)]
    return min(found, key=lambda s: s.nodes(digits))


def _sizes(subject: Integrands, squares: StripSquares, *, zeros: bool = True) -> tuple[Reals, Reals]:
    """Return what ``_sizes_of_block`` returns, for any number of squares."""
    blocks = (squares.chosen(slice(k, k + _BLOCK)) for k in range(0, squares.x.size, _BLOCK))
    logs, sizes = zip(*(_sizes_of_block(subject, block, zeros) for block in blocks), strict=True)
    return np.hstack(logs), np.max(sizes, axis=0)


def _sizes_of_block(subject: Integrands, squares: StripSquares, zeros: bool) -> tuple[Reals, Reals]:
    """Return the logarithm of the greatest size of each integrand over squares, not finite where unknown.

    Sizes on the axis.

    A square lies in a disk of radius ρ; over that of radius ``_WIDER``·ρ the formulas are enclosed as they
    stand, which shows that they are analytic there and bounds them, be it far from sharply. So the power series of an
    integrand about the centre is known from values at points of the circle: what they do not tell is less than
    2Bt^n/(1 − t) for n points, t = 1/``_WIDER`` and the bound B, and the values themselves suffer from no dependency.
    """
    χ = squares.x + squares.side / 2 + 1j * (squares.y + squares.side / 2)
    radius = squares.side * 0.7072
    count(squares=χ.size * (len(_CIRCLE) + 1))
    with np.errstate(all="ignore"):
        disks, method = subject.over(place_disks(subject.anomaly, χ, _WIDER * radius))
        bounds = [x.largest + 0 * radius for x in disks]
        # power series from values on circles: |f| at the centres, and what f varies by on the smaller disks
        # twenty points of a circle give the Taylor coefficients by the trapezoidal rule (Cauchy's integral)
        points = complex_place(subject.anomaly, χ + radius * _CIRCLE[:, None])
        (centre, spread), *weights = (
            _series(values, bound) for values, bound in zip(subject.at(points, method), bounds, strict=True)
        )
        if not zeros:
            logs = np.log(np.maximum(np.stack(bounds), 1e-300))
            axis = np.isfinite(logs).all(axis=0) & (squares.y == 0)
            usual = np.stack([np.broadcast_to(c, radius.shape) for c in (centre, *(c for c, _ in weights))])
            return logs, np.max(np.where(axis & np.isfinite(usual), usual, 0.0), axis=1, initial=0.0)
        # R has no zero on a disk where its variation is below its value at the centre
        # |R| over the square from its Taylor series, far sharper than the disk of its formula
        least, most = centre - spread, centre + spread
        # analytic, as every operation was defined on the wider disk, and without zero: √R is analytic too
        known = np.isfinite(np.stack(bounds)).all(axis=0) & (least > 0)
        product = _product(points)
        stretch = np.max(points.stretch, axis=0)
        sizes = _rows([c + s for c, s in weights], least, most, product, stretch)
        usual = _rows([c for c, _ in weights], centre, centre, product, stretch)
        logs = np.where(known, np.log(np.maximum(sizes, 1e-300)), np.nan)
    return logs, np.max(np.where(known & (squares.y == 0), usual, 0.0), axis=1, initial=0.0)


def _product(points: ComplexPlace) -> Elementwise:
    """Return the greatest |(q − a)(b − q)| of each square; 1 for a rotation."""
    if points.from_lower is None or points.to_upper is None:
        return 1.0
    return np.max(np.abs(points.from_lower * points.to_upper), axis=0)


def _series(values: Complexes, bound: Reals) -> tuple[Reals, Reals]:
    """|f(centre)| and the greatest |f(z) − f(centre)| of a function that is known at points of circles."""
    values = np.broadcast_to(values, (len(_CIRCLE), *bound.shape))
    # |aₖ|ρᵏ from n values; aliasing and the rest of the series are below 2B t^n/(1 − t), t = 1/_WIDER (Cauchy)
    powers = np.abs(np.fft.fft(values, axis=0)) / len(_CIRCLE)
    rest = 2 * bound * (_WIDER ** -len(_CIRCLE) / (1 - 1 / _WIDER) + _ROUNDING)
    return powers[0], np.sum(powers[1:], axis=0) + rest


def _rows(weights: list[Reals], least: Reals, most: Reals, product: Elementwise, stretch: Reals) -> Reals:
    """Sizes of the kernels' integrands, of ln(p/(dq/dχ)) (at least 1) and of p dq, where √R lies between two sizes."""
    angle = 4.0  # the argument of R on the way from the real axis
    low, high = (np.abs(np.log(x) / 2 - np.log(stretch)) for x in (least, most))
    rows = [w * stretch / np.sqrt(least) for w in weights]
    return np.stack([*rows, 1.0 + angle + np.maximum(low, high), product * np.sqrt(most) * stretch])
