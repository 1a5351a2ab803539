"""The region in which one coordinate of many orbits moves: turning points, rotation, rest; and what is near it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, two_sum
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.arithmetic.second_differences import FUNCTIONS
from hjsolve.ensembles.engine.constants import InitialConstants, initial_constants, slope
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.nodes import EVEN, MOST
from hjsolve.ensembles.engine.orbit_groups import Group, group_of
from hjsolve.ensembles.engine.orbit_regions import LocatedRegions, OrbitRegions
from hjsolve.ensembles.engine.radicand_views import (
    DifferenceEvaluation,
    DirectEvaluation,
    DoubleDoubleEvaluation,
    View,
    second_slope,
)
from hjsolve.ensembles.engine.rotations import rotation, turn
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import EQUILIBRIUM, Status
from hjsolve.ensembles.engine.turning_points import Search, both_ends

_SMALL = 3e-14
_CLEAR = 1e-12
"""Claimed relative error of p² a fiftieth of the way from a turning point; the integrals are far better."""

_LOST, _LOST_ACTIONS = 2e-13, 4e-12
"""Above these a first pass in doubles would come out worse than it may."""

_TINY = 1e-4
"""With 32 digits a motion is small only where doubles hardly see it."""

_FEW = 16
"""Steps outward in which a small motion turns; each is 1.6 times the last one."""

_NEAR = 3.0
_FAR = 0.5
_ALIKE = 2.0
"""How much larger the uncertainty of ½F″ may be at the turning points of a small motion; three times of it count."""

_WARPED = 5
_NEWTON, _CHORD = 2, 3
"""Steps that improve a turning point in 32 digits: with slopes of their own, and with the last one, for a third of the
price. A step with relative error ρ of its slope leaves ρ of the error; Newton's ρ falls from step to step."""
_ARITHMETIC = frozenset({"add", "sub", "mul", "div", "power", "rational", "pi"})


def locate_regions(
    model: Model, coordinate: Separated, start: InitialConstants, k: int, depth: int, index: Integers | None = None
) -> list[LocatedRegions]:
    """Find where one coordinate moves.

    Args:
        model: of the system.
        coordinate: the k-th separated one.
        start: of n orbits.
        k: row of the coordinate.
        depth: see ``Group``.
        index: which of the orbits; None for all.
    """
    with np.errstate(all="ignore"):
        group = group_of(model, coordinate, start, k, depth, index)
        found, left = [], np.ones(len(group.q), dtype=bool)
        if depth and has_slopes(coordinate.plain):
            noise, crest = _noise_and_crest(
                DirectEvaluation(coordinate.plain, group.knowns), group.q, group.P, group.first, 2 * group.bend
            )
            small = np.flatnonzero(noise > (_SMALL if depth < 2 else _TINY) * crest)
            if len(small):
                near = _near(group.take(small))
                inside = np.flatnonzero(near.status != Status.UNBOUNDED)
                left[small[inside]] = False
                if len(inside):
                    found.append(near.take(inside))
        rest = np.flatnonzero(left)
        if len(rest):
            found += _wide(group.take(rest))
    return found


def hopeless_in_doubles(model: Model, starts: Starts, *, kernels: bool) -> Mask:
    """Tell which orbits have a motion so small that doubles would not do: p² is hardly larger than its rounding.

    Args:
        model: of the system.
        starts: of n orbits.
        kernels: whether ∂J/∂c are wanted, which suffer most next to the turning points.

    Returns:
        Array of booleans, shape (n,).
    """
    start = initial_constants(model, starts, precise=False)
    found = np.zeros(starts.q.shape[1], dtype=bool)
    with np.errstate(all="ignore"):
        for k, coordinate in enumerate(model.separated):
            if has_slopes(coordinate.plain):
                view = DirectEvaluation(coordinate.plain, start.knowns)
                _, first, second = view.jet(start.q[k])
                noise, crest = _noise_and_crest(view, start.q[k], start.P[k], first, second)
                found |= noise > (_LOST if kernels else _LOST_ACTIONS) * crest
    return found


def _noise_and_crest(view: DirectEvaluation, q: Reals, P: Reals, first: Reals, second: Reals) -> tuple[Reals, Reals]:
    """The error of p² at the start, and about how large p² becomes."""
    crest = P * P + np.where(second < 0, first * first / (-2 * second), np.inf)
    return view.errors(q, kernels=False)[0], crest


def has_slopes(formula: LoweredFormula) -> bool:
    """Tell whether small motions can be seen from their start, by second differences.

    Args:
        formula: of p².
    """
    return {operation.code for operation in formula.squared.operations} <= FUNCTIONS | _ARITHMETIC


def _near(group: Group) -> LocatedRegions:
    """Small motions about a deep maximum of p²."""
    coordinate, knowns, q, P = group.coordinate, group.knowns, group.q, group.P
    first = slope(coordinate.plain, group.pairs, group.numbers, q)
    bend, uncertainty = second_slope(coordinate.plain, knowns, q)
    view = DifferenceEvaluation(coordinate.plain, knowns, q, P, first, uncertainty)
    zero = np.zeros_like(q)
    rest = (P == 0) & (np.abs(first) <= 2.0**-40 * uncertainty * np.maximum(np.abs(q), 2.0**-40))
    floors = [
        np.full(len(q), side * np.inf) if formula is None else -formula.sign * offset(formula, q)
        for side, formula in ((-1, coordinate.lower), (1, coordinate.upper))
    ]
    size = np.minimum(np.abs(q) + 1.0, np.minimum(-floors[0], floors[1]))
    searches = (
        Search(view, zero, P, side * first, bend, np.full(len(q), side), size, floor)
        for side, floor in zip((-1, 1), floors, strict=True)
    )
    ends = list(both_ends(*searches, steps=_FEW))
    far = (ends[0] < _FAR * floors[0]) | (ends[1] > _FAR * floors[1])
    crest = P * P + np.where(bend < 0, first * first / (-4 * bend), np.inf)
    # the uncertainty of the slopes is known at the start: it has to hold at the turning points, too
    for end in ends:
        far |= ~(second_slope(coordinate.plain, knowns, q + end)[1] <= _ALIKE * uncertainty)
        # and where p² is not known from zero nothing turns: far out the roundings of what runs away change its sign
        far |= ~(view.errors(end, kernels=False)[0] <= np.minimum(crest, P * P + np.abs(first * end)))
    ends[0] = np.where(far, np.nan, ends[0])
    region = _region(view, view, ends[0], ends[1], P, -ends[0], ends[1])
    status = np.where(np.isfinite(region.width) & (region.width > 0), Status.OK, Status.UNBOUNDED)
    status = np.where(rest, np.where(bend < 0, Status.OK, EQUILIBRIUM), status)
    return LocatedRegions(group.index, region, status.astype(np.uint8), rest & (bend < 0))


def _wide(group: Group) -> list[LocatedRegions]:
    """Motions whose amplitude is not small: rotations first, then librations."""
    if not group.coordinate.periodic:
        return _librations(group)
    values = turn(group)
    going = (values > 0).all(axis=1)
    found = []
    if not going.all():
        found += _librations(group.take(np.flatnonzero(~going)))
    if going.any():
        found.append(rotation(group.take(np.flatnonzero(going)), values[going]))
    return found


def _librations(group: Group) -> list[LocatedRegions]:
    """Librations; in the third pass those whose p² doubles know well enough are left to doubles, not in the fourth."""
    found = _libration(replace(group, depth=min(group.depth, 1)))
    if group.depth < 2:
        return [found]
    vague = ill_known(found.region) | (found.status != Status.OK) | (group.depth > 2)
    clear, vague = np.flatnonzero(~vague), np.flatnonzero(vague)
    parts = [found.take(clear)] if len(clear) else []
    return parts + ([_with_more_digits(group.take(vague), found.take(vague))] if len(vague) else [])


def ill_known(region: OrbitRegions) -> Mask:
    """Tell where the error of p² in doubles, next to the turning points and between them, is not small beside p².

    Args:
        region: of librations, p² being evaluated as it is written.
    """
    worst = np.zeros(len(region.width))
    for view, end, side in ((region.below, region.lower, 1), (region.above, region.upper, -1)):
        for share in (0.02, 0.2, 0.5):
            x = end + side * view.sign * share * region.width
            with np.errstate(all="ignore"):
                worst = np.maximum(worst, view.errors(x, kernels=False)[0] / np.abs(view.value(x)))
    return ~(worst <= _CLEAR)


def _libration(group: Group) -> LocatedRegions:
    """Librations, p² being evaluated in doubles."""
    coordinate, knowns, q, P = group.coordinate, group.knowns, group.q, group.P
    first, bend = group.first, group.bend
    searches: list[Search] = []
    plain = DirectEvaluation(coordinate.plain, knowns)
    scale = np.sqrt(np.abs(P * P / bend))
    length = np.where(q != 0, np.abs(q), np.where(np.isfinite(scale) & (scale > 0), scale, 1.0))
    outside = np.zeros(len(q), dtype=bool)
    reach = 2 * np.pi if coordinate.periodic else np.inf
    for side, formula in ((-1, coordinate.lower), (1, coordinate.upper)):
        view = plain if formula is None or not group.depth else DirectEvaluation(formula, knowns)
        start = offset(view.formula, q)
        distance = np.full(len(q), np.inf) if formula is None else offset(formula, q)
        outside |= distance <= 0
        step_side = np.full(len(q), side * view.sign)
        size = np.minimum(length, distance)
        size = np.minimum(size, 0.2) if coordinate.periodic else size
        searches.append(Search(view, start, P, side * first, bend, step_side, size, start + step_side * distance))
    seen = []
    for search, end in zip(searches, both_ends(*searches, reach=reach, careful=group.depth > 0), strict=True):
        # a start that rounds to the end of the domain
        inside = np.where(search.side * (end - search.floor) < 0, end, np.nan)
        seen.append((search.view, inside, search.side * (inside - search.start)))
    (below, lower, left), (above, upper, right) = seen
    region = _region(below, above, lower, upper, P, left, right)
    return _finished(group, region, left - right, outside | ~np.isfinite(P))


def _with_more_digits(group: Group, found: LocatedRegions) -> LocatedRegions:
    """The same librations, with p² to 32 digits."""
    seen = found.region
    return _finished(group, _fine(group, seen), seen.left - seen.right, found.status == Status.FORBIDDEN)


def _finished(group: Group, region: OrbitRegions, lean: Reals, forbidden: Mask) -> LocatedRegions:
    """Choose the anomaly, and say what was found; ``lean`` is twice the distance of the start from the middle."""
    if group.coordinate.even:
        same = np.abs(lean - 2 * group.q) <= 1e-13 * region.width
        region = replace(region, node_map=np.where(same, EVEN, 0))
    if group.depth:
        region = stretched(region)
    status = np.where(np.isfinite(region.width) & (region.width > 0), Status.OK, Status.UNBOUNDED)
    status = np.where(forbidden, Status.FORBIDDEN, status).astype(np.uint8)
    return LocatedRegions(group.index, region, status, np.zeros(len(group.q), dtype=bool))


def _fine(group: Group, region: OrbitRegions) -> OrbitRegions:
    """The same region with its turning points, and F, to 32 digits."""
    arithmetic, seen = DoubleDouble(), []
    for view, x in ((region.below, region.lower), (region.above, region.upper)):
        assert isinstance(view, DirectEvaluation)
        base, slope_ = Pair(x, 0.0 * x), x
        for step in range(_NEWTON + _CHORD):
            near = DoubleDoubleEvaluation(view, group.pairs, group.numbers, base)
            if step < _NEWTON:
                value, slope_, _ = near.jet(0.0 * x)
            else:
                value = near.value(0.0 * x)
            base = arithmetic.sub(base, Pair(value / slope_, 0.0 * x))
        s, e = two_sum(group.q, -view.formula.origin.high)
        here = Pair(view.sign * s, view.sign * (e - view.formula.origin.low))
        seen.append(
            (
                DoubleDoubleEvaluation(view, group.pairs, group.numbers, base),
                view.sign * arithmetic.sub(here, base).high,
            )
        )
    (below, left), (above, right) = seen
    zero = np.zeros_like(group.q)
    return _region(below, above, zero, zero, group.P, left, -right)


def offset(formula: LoweredFormula, q: Reals) -> Reals:
    """Return x of a position: (q − origin)·sign with one rounding.

    Args:
        formula: with its origin.
        q: positions, shape (n,).
    """
    s, e = two_sum(q, -formula.origin.high)
    return formula.sign * (s + (e - formula.origin.low))


def _region(below: View, above: View, lower: Reals, upper: Reals, P: Reals, left: Reals, right: Reals) -> OrbitRegions:
    zero, none = np.zeros_like(P), np.zeros(len(P), dtype=int)
    return OrbitRegions(below, above, lower, upper, left + right, zero, zero, none, none, P, left, right)


def stretched(region: OrbitRegions) -> OrbitRegions:
    """Choose the anomaly: W·|S′/S| at an end is W over the distance of the zero or pole next to it.

    Args:
        region: of librations, p² not being seen from the start.
    """
    nearby = []
    for view, x, side in ((region.below, region.lower, 1), (region.above, region.upper, -1)):
        assert not isinstance(view, DifferenceEvaluation)
        _, first, second = view.jet(x)
        inward = side * view.sign * first
        ρ = np.abs(region.width * second / (2 * inward) + 1)
        nearby.append(np.where(np.isfinite(ρ) & (ρ > _NEAR), ρ, 0.0))
    even = region.node_map >= EVEN
    d, c = (np.where(even, np.maximum(*nearby), ρ) for ρ in nearby)
    level = np.ceil(np.log2((1 + d) * (1 + c)) / 2)
    level = np.clip(level, 0, MOST).astype(int)
    goal = 4.0**level
    d, c = np.where(d >= c, goal / (1 + c) - 1, d), np.where(d >= c, c, goal / (1 + d) - 1)
    d, c = (np.where(even, np.sqrt(goal) - 1, ρ) for ρ in (d, c))
    where = np.log1p(d) / np.log((1 + d) * (1 + c))
    node_map = np.where(level >= _WARPED, 1 + np.rint(4 * np.nan_to_num(where)), 0).astype(int)
    node_map = np.where(even, EVEN + (level >= _WARPED), node_map)
    return replace(region, near_lower=d, near_upper=c, level=level, node_map=node_map)
