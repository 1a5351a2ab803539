"""A family of motions looked through in doubles: frequencies on its grid, and between which values an equation is met.

Towards the ends of a chain of motions (a separatrix, a circle, an escape) the grid is continued by halves of what is
left, since frequencies go to 0 there like 1/ln. Where an equation comes near to being met between two values of the
grid, as at an extremum of a frequency, the grid is made finer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.root_finding import bisected
from hjsolve.ensembles.orbits import ensemble
from hjsolve.errors import HJSolveError
from hjsolve.motion.formulas_at_places import tape_of, values_at
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.resonances.equations import Equation
from hjsolve.resonances.families import OneParameterFamily, Well, Wells, place_in, wells_of, with_extrema
from hjsolve.resonances.members import member_of

_HALVINGS_TO_AN_END, _TOWARDS = 60, 44
"""Bisections that find where a chain of motions ends, and steps towards there, each half of what is left."""
_FINER, _PARTS = 8, 8
"""How often the grid is made finer about a place where an equation is nearly met, and into how many parts."""
_DEEP = 0.9
"""Least value of a parabola, over that at the middle one of three motions, above which no more are looked at."""
_NOISE = 1e-13
"""Relative residual below which doubles do not tell whether an equation is met."""
_DEGENERATE = 1e-11
"""Largest relative residual, all along a chain, at which the equation is taken to hold for all of its motions."""


@dataclass(frozen=True)
class Bracket:
    """Two values of the unknown between which an equation is met, and where the coordinates move there.

    Attributes:
        low, high: the unknown.
        wells: at ``low``.
    """

    low: float
    high: float
    wells: Wells


@dataclass(frozen=True)
class Scan:
    """What was seen of a family.

    Attributes:
        brackets: where the equation is met.
        first, last: the least and the greatest unknown of a motion that was seen; NaN for none.
        rates: coordinate → frequencies of the motions seen, shape (m,).
        degenerate: whether all motions of a chain meet the equation.
    """

    brackets: tuple[Bracket, ...]
    first: float
    last: float
    rates: Mapping[str, Reals]
    degenerate: bool


def scanned(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], equation: Equation, grid: Reals,
    kinds: Mapping[str, str],
) -> Scan:  # fmt: skip
    """Look through a family.

    Args:
        family: of motions.
        curves: p² of the separated coordinates.
        equation: that is to be met.
        grid: values of the unknown, ascending.
        kinds: separated coordinate → libration or rotation; other motions are left out.
    """
    chains = _chains(family, curves, grid, kinds)
    chains = [_to_the_ends(family, curves, chain, grid, kinds) for chain in chains]
    chains, rates, good = _seen_finely(family, curves, equation, chains, kinds)
    brackets, tails, degenerate, begin = list[Bracket](), list[_Tail](), False, 0
    for chain in chains:
        part = slice(begin, begin + len(chain))
        begin += len(chain)
        value, size = equation.of({name: rate[part] for name, rate in rates.items()})
        seen = np.flatnonzero(good[part])
        if len(seen) > 2 and np.all(np.abs(value[seen]) <= _DEGENERATE * size[seen]):
            degenerate = True
            continue
        for k, m in pairwise(seen):
            if value[k] == 0 or value[k] * value[m] < 0:
                brackets.append(Bracket(chain[k][0], chain[m][0], chain[k][1]))
        if len(seen) < 3:
            continue
        own = np.array([u for u, _ in chain])
        tails += [
            _Tail(chain[k], _past(own, chain[k][0], side), _past(grid, own[-1 if side > 0 else 0], side), value[k])
            for k, m, side in ((seen[0], seen[1], -1), (seen[-1], seen[-2], 1))
            if value[k] * (value[k] - value[m]) < 0
        ]
    followed = [_followed(family, curves, equation, tail) for tail in tails]
    brackets += [found for found in followed if isinstance(found, Bracket)]
    if not brackets:
        left = [tail for tail in followed if isinstance(tail, _Tail)]
        brackets = [found for tail in left if (found := _beyond(family, curves, equation, tail)) is not None]
    known = np.array([u for chain in chains for u, _ in chain])[good]
    first, last = (float(np.min(known)), float(np.max(known))) if len(known) else (np.nan, np.nan)
    return Scan(tuple(brackets), first, last, {name: rate[good] for name, rate in rates.items()}, degenerate)


_Point = tuple[float, Wells]
"""A value of the unknown, and where the coordinates move there."""


@dataclass(frozen=True)
class _Tail:
    """The end of what is known of a chain, towards which the equation comes nearer to being met.

    Attributes:
        last: the last motion known.
        rest: unknowns of the chain past it, the next first.
        beyond: values of the grid past the chain, the next first.
        value: of the equation at ``last``.
        outside: an unknown without a motion; NaN for none.
    """

    last: _Point
    rest: Reals
    beyond: Reals
    value: float
    outside: float = np.nan


def _past(values: Reals, u: float, side: int) -> Reals:
    return values[values > u] if side > 0 else values[values < u][::-1]


def _seen_finely(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], equation: Equation, chains: list[list[_Point]],
    kinds: Mapping[str, str],
) -> tuple[list[list[_Point]], dict[str, Reals], Reals]:  # fmt: skip
    """Return chains that are finer where the equation is nearly met, their frequencies, and which are known."""
    for _ in range(_FINER):
        rates, good = _rates(family, curves, [point for chain in chains for point in chain])
        finer, begin = [], 0
        for chain in chains:
            part = slice(begin, begin + len(chain))
            begin += len(chain)
            value, size = equation.of({name: rate[part] for name, rate in rates.items()})
            finer.append(_divided(family, curves, kinds, chain, np.where(good[part], value, np.nan), size))
        if sum(map(len, finer)) == begin:
            return chains, rates, good
        chains = finer
    return chains, *_rates(family, curves, [point for chain in chains for point in chain])


def _divided(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], kinds: Mapping[str, str], chain: list[_Point],
    value: Reals, size: Reals,
) -> list[_Point]:  # fmt: skip
    """Return a chain with more motions next to those at which the equation is nearer to being met than beside them."""
    result = list(chain)
    u = np.array([place for place, _ in chain])
    for k in np.flatnonzero(_nearly_met(u, value, size)) + 1:
        for end in (k - 1, k + 1):
            for v in np.linspace(u[end], u[k], _PARTS + 1)[1:-1]:
                there = _continued(family, curves, float(v), chain[k][1], kinds)
                if there is not None and v not in (u[end], u[k]):
                    result.append((float(v), there))
    return sorted(result, key=lambda point: point[0])


def _nearly_met(u: Reals, value: Reals, size: Reals) -> Reals:
    """Tell of all motions but the first and the last whether an equation may be met twice next to them.

    It has one sign there, is least at the middle one, and a parabola through the three comes nearer to 0.
    """
    if len(u) < 3:
        return np.zeros(0, dtype=bool)
    left, middle, right = value[:-2], value[1:-1], value[2:]
    with np.errstate(all="ignore"):
        h, k = u[:-2] - u[1:-1], u[2:] - u[1:-1]
        bend = ((left - middle) / h - (right - middle) / k) / (h - k)
        slope = (left - middle) / h - bend * h
        least = (middle - slope**2 / (4 * bend)) / middle
        return np.asarray(
            (left / middle >= 1) & (right / middle >= 1) & (least < _DEEP) & (np.abs(middle) > _NOISE * size[1:-1])
        )


def _followed(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], equation: Equation, tail: _Tail
) -> Bracket | _Tail:  # fmt: skip
    """Look, by single motions, at those of a chain that doubles do not know; return what is left where none meets it.

    The last of them first: towards an end the equation is met once at most.
    """
    (inside, wells), outside = tail.last, tail.outside
    first, after, k, met = 0, len(tail.rest), len(tail.rest) - 1, False
    while first < after:
        u = float(tail.rest[k])
        value = _by_a_single_motion(family, curves, equation, (u, wells))
        if value is not None and value * tail.value > 0:
            inside, first = u, k + 1
        else:
            outside, after, met = u, k, value is not None
        k = (first + after) // 2
    if met:
        return Bracket(min(inside, outside), max(inside, outside), wells)
    return replace(tail, last=(inside, wells), outside=outside)


def _beyond(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], equation: Equation, tail: _Tail
) -> Bracket | None:  # fmt: skip
    """Look, by single motions, between the last motion that is known and the end of the chain.

    First at the values of the grid until one has no motion; then the end is halved in on.
    """
    inside, wells = tail.last
    grid, outside = list(tail.beyond), tail.outside
    for _ in range(2 * _TOWARDS):
        u = float(grid.pop(0)) if np.isnan(outside) and grid else (inside + outside) / 2
        if u in (inside, outside) or np.isnan(u):
            return None
        value = _by_a_single_motion(family, curves, equation, (u, wells))
        if value is None:
            outside = u
        elif value * tail.value <= 0:
            return Bracket(min(inside, u), max(inside, u), wells)
        else:
            inside = u
    return None


def _by_a_single_motion(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], equation: Equation, point: _Point
) -> float | None:  # fmt: skip
    u, wells = point
    try:
        motion = member_of(family, curves, wells, multiprecision(128).mpf(u)).motion(15, ("frequencies",))
    except HJSolveError:
        return None
    known = equation.weights.keys() <= motion.frequencies.keys()
    return float(equation.exactly(motion.frequencies, 128)[0]) if known else None


def _allowed(curves: Sequence[RadicandCurve], wells: Wells, kinds: Mapping[str, str]) -> bool:
    return all(
        well.round == (kinds[c.name] == "rotation") for c, well in zip(curves, wells, strict=True) if c.name in kinds
    )


def _same(curves: Sequence[RadicandCurve], one: Wells, other: Wells) -> bool:
    return all(a.meets(b, c.turn) for c, a, b in zip(curves, one, other, strict=True))


def _chains(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], grid: Reals, kinds: Mapping[str, str]
) -> list[list[_Point]]:  # fmt: skip
    """Return motions of neighbouring unknowns whose wells overlap, as chains."""
    live: list[list[_Point]] = []
    done: list[list[_Point]] = []
    for u in grid:
        here = [w for w in wells_of(curves, family.in_doubles(u)) if _allowed(curves, w, kinds)]
        # a chain goes on where no two wells join and none is cut in two: then it ends, and others begin
        going_on, after = set[int](), []
        for wells in here:
            before = [chain for chain in live if _same(curves, chain[-1][1], wells)]
            one = before[0] if len(before) == 1 else []
            if one and sum(_same(curves, one[-1][1], w) for w in here) == 1:
                going_on.add(id(one))
                after.append([*one, (float(u), wells)])
            else:
                after.append([(float(u), wells)])
        done += [chain for chain in live if id(chain) not in going_on]
        live = after
    return done + live


def _to_the_ends(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], chain: list[_Point], grid: Reals,
    kinds: Mapping[str, str],
) -> list[_Point]:  # fmt: skip
    """Return a chain with motions nearer and nearer to the unknowns at which it begins and ends."""
    result = list(chain)
    for end, side in ((chain[0], -1), (chain[-1], 1)):
        u, wells = end
        beyond = int(np.searchsorted(grid, u)) + side
        if not 0 <= beyond < len(grid):
            continue
        _, outside = bisected(
            lambda v: _continued(family, curves, v, wells, kinds) is not None,  # noqa: B023 (called at once)
            u, float(grid[beyond]), _HALVINGS_TO_AN_END,
        )  # fmt: skip
        more = []
        for k in range(1, _TOWARDS):
            v = outside + (u - outside) * 2.0**-k
            there = _continued(family, curves, v, wells, kinds)
            if there is None:
                break
            more.append((float(v), there))
            wells = there
        result = more[::-1] + result if side < 0 else result + more
    return result


def _continued(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], u: float, wells: Wells, kinds: Mapping[str, str]
) -> Wells | None:  # fmt: skip
    """Return the wells of a neighbouring unknown that overlap given ones; None where there are none, or several."""
    κ = family.in_doubles(u)
    found = []
    for curve, well in zip(curves, wells, strict=True):
        top = place_in(curve, κ, well)
        if not float(curve.value(np.array([top]), κ)[0]) > 0:
            return None
        if well.round and not np.all(with_extrema(curve, κ)[1] > 0):
            return None
        found.append(Well(well.low, well.high, top, well.round))
    combinations = [w for w in wells_of(curves, κ) if _same(curves, w, wells) and _allowed(curves, w, kinds)]
    if len(combinations) > 1 or (not combinations and not _narrow(curves, κ, wells)):
        return None
    return combinations[0] if combinations and all(
        float(c.value(np.array([w.top]), κ)[0]) > 0 for c, w in zip(curves, combinations[0], strict=True)
    ) else tuple(found)  # fmt: skip


def _narrow(curves: Sequence[RadicandCurve], κ: Reals, wells: Wells) -> bool:
    """Whether p² < 0 at the ends of the wells, so that what moves inside does come back."""
    ends = [
        curve.value(np.array([well.low, well.high]), κ)
        for curve, well in zip(curves, wells, strict=True)
        if not well.round
    ]
    return all(bool(np.all(~(values > 0))) for values in ends)


def _rates(
    family: OneParameterFamily, curves: Sequence[RadicandCurve], points: Sequence[_Point]
) -> tuple[dict[str, Reals], Reals]:  # fmt: skip
    """Return the frequencies of motions by the engine of ensembles, and which of them it knows."""
    solution = family.solution
    if not points:
        return {}, np.zeros(0, dtype=bool)
    κ = np.stack([family.in_doubles(u) for u, _ in points], axis=1)
    names = list(solution.constants)
    q: dict[str, Reals] = {c.name: np.zeros(len(points)) for c in solution.system.coordinates}
    p: dict[str, Reals] = {}
    for k, curve in enumerate(curves):
        place = np.array([wells[k].top for _, wells in points])
        squared = curve.value(place[:, None], κ[:, :, None])[:, 0]
        q[curve.name], p[curve.name] = place, np.sqrt(np.maximum(squared, 0.0))
    for c in solution.system.coordinates:
        if c.name not in p:
            p[c.name] = κ[names.index(c.momentum.name)]
    for curve in curves:
        p[curve.name] = p[curve.name] - _shifts(family, curve.name, q, p)
    batch = ensemble(
        solution, q=q, p=p, want="frequencies", parameters=dict(family.parameters), fallback=False, shown=False
    )
    return dict(batch.frequencies), np.asarray(batch.status == "ok")


def _shifts(family: OneParameterFamily, name: str, q: Mapping[str, Reals], p: Mapping[str, Reals]) -> Reals:
    """Return A(q), by which the shell momentum P = p + A of a coordinate is more than p."""
    solution = family.solution
    A = solution.shift[name]
    if A == 0:
        return np.zeros_like(q[name])
    coordinates = solution.system.coordinates
    values = {solution.system.symbols[n]: v for n, v in family.parameters.items()}
    values = {x.symbol: values.get(x.symbol, x.value) for x in solution.system.parameters}
    others = [c for c in coordinates if c.name not in solution.coordinates]
    symbols = (*(c.symbol for c in coordinates), *(c.momentum for c in others), *values)
    arrays = [*(q[c.name] for c in coordinates), *(p[c.name] for c in others)]
    return np.asarray(values_at(tape_of((A,), symbols), arrays, list(values.values()))[0], dtype=float)
