"""Enclosures of times of travel and of their slopes by E, over an interval of energies.

With dt = μ dq/√(E − V), y = E − V. On a cell where V′ has one sign, ∫ μ dq/√y lies in [μ/|V′|] · 2|√y_l − √y_r|;
else it lies in width · [μ/√y]. Beyond a place c from which V rises to the turning point b,

    d/dE ∫_c^b μ dq/√y = 1/(E − V_c) ∫_c^b [μ/2 + (V − V_c)(μ′V′ − μV″)/V′²] dq/√y

(by x = V(q) and scaling of x − V_c), and before it d/dE ∫ μ dq/√y = −½ ∫ μ y^(−3/2) dq. All sums are taken outward over
interval arithmetic; ends of cells are doubles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.asymptotic_expansion import BITS
from hjsolve.arithmetic.floats import EPS, Float64, multiprecision
from hjsolve.arithmetic.interval import Interval, Intervals, exact, over_shape
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.arithmetic.sign_at_infinity import sign_before
from hjsolve.lowering import lower

_OUT = 1 + 64 * EPS
"""Rounding of the sums below, all of whose terms have one sign."""
_FIELD = Intervals(Float64())
_DEEP = 6.0
"""How many times the width of an interval of energies E − V is where the part next to the turning point begins."""


@dataclass(frozen=True)
class Segment:
    """One part of a path.

    Attributes:
        time: its enclosure for all energies of the interval; ∞ above where it is not bounded.
        slope: of dtime/dE; (−∞, ∞) where it is not known.
        turns: True where there is a turning point for all energies, False where there is for none, None undecided.
        end: a place beyond the turning points, where there are.
    """

    time: Interval
    slope: Interval
    turns: bool | None
    end: float


class Line:
    """V and μ of one coordinate, enclosed over cells; seen upwards, or downwards with q → −q.

    Attributes:
        q: the symbol.
        low, high: the ends of its domain in doubles.
        turn: 2π for an angle, else 0.
    """

    def __init__(
        self, q: sp.Symbol, potential: sp.Expr, weight: sp.Expr, values: Mapping[sp.Symbol, sp.Expr],
        ends: tuple[float, float], turn: float,
    ):  # fmt: skip
        self.q, (self.low, self.high), self.turn = q, ends, turn
        V, μ = potential.subs(values), weight.subs(values)
        self.formulas = [V, sp.diff(V, q), sp.diff(V, q, 2), μ, sp.diff(μ, q), sp.diff(V, q, 3)]
        self._tape = lower(self.formulas, [q])
        self._samples: dict[tuple[float, float, int], tuple[Reals, Reals]] = {}
        self._tops: dict[tuple[float, float, int], Reals] = {}

    def sampled(self, begin: float, far: float, sign: int, *, ended: bool) -> tuple[Reals, Reals]:
        """Return places from one outward, and V there.

        Args:
            begin, far: the first and the last place, as seen.
            sign: as of ``over``.
            ended: whether the last place is the end of the domain, and left out.
        """
        key = (begin, far, sign)
        if key not in self._samples:
            grid = _outgoing(begin, far, 4000)[1 : -1 if ended else None]
            self._tops[key] = _around_tops(self, grid, sign)
            grid = np.unique(np.concatenate([grid, self._tops[key]]))
            self._samples[key] = grid, self.over(grid, grid, sign)[0].low
        return self._samples[key]

    def tops(self, begin: float, far: float, sign: int, *, ended: bool) -> Reals:
        """Return places in rows around those where V is greatest among its neighbours.

        Args:
            begin, far, sign, ended: as of ``sampled``.
        """
        self.sampled(begin, far, sign, ended=ended)
        return self._tops[begin, far, sign]

    def inside_to_end(self, sign: int, start: float, E: float) -> bool:
        """Whether E > V from a place to the end of the domain, proved.

        Args:
            sign: 1 for the upper end, −1 for the lower one.
            start: the place.
            E: the energy.
        """
        context = multiprecision(BITS)
        end = context.mpf(self.high if sign > 0 else self.low)
        tape = lower([sp.Rational(E) - self.formulas[0]], [self.q])
        return sign_before(tape, [], end, sign, abs(end - context.mpf(start))) > 0

    def over(self, low: Reals, high: Reals, sign: int) -> list[Interval]:
        """Return V, V′, V″, μ, μ′ and V‴ over cells.

        Args:
            low, high: ends of the cells as seen, shape (m,).
            sign: 1 upwards, −1 downwards; odd derivatives then change sign.
        """
        cell = Interval(low, high) if sign > 0 else Interval(-high, -low)
        rows = self._tape.run(_FIELD, [cell])
        found = [over_shape(row, low.shape) for row in rows]
        if sign < 0:
            found = [_FIELD.unary("neg", f) if k in (1, 4, 5) else f for k, f in enumerate(found)]
        return found

    def value(self, q: float) -> Interval:
        """Enclose V at a place."""
        V = self.over(np.array([q]), np.array([q]), 1)[0]
        return Interval(float(V.low[0]), float(V.high[0]))


class _Cells(NamedTuple):
    """What is known of cells for an interval of energies; arrays over the cells."""

    V: Interval
    rising: Mask
    falling: Mask
    low: Reals
    high: Reals
    """bounds of the integral of μ/√y, up to a turning point"""
    surely: Mask
    """whether y > 0 on the whole cell for all energies"""
    bracket: Interval
    """(μ′V′ − μV″)/V′², of the cells where V′ has a sign"""
    weight: Interval
    """μ"""
    steep: Interval
    """∫ μ y^(−3/2) dq"""
    nodes: Interval
    """V at the first ends"""
    gradient: Interval
    """the size of V′, where it has a sign"""


def _cells(line: Line, grid: Reals, energies: Interval, sign: int) -> _Cells:
    a, b = grid[:-1], grid[1:]
    V, V1, V2, μ, μ1, _ = line.over(a, b, sign)
    at = line.over(grid, grid, sign)[0]
    with np.errstate(all="ignore"):
        left, right = Interval(at.low[:-1], at.high[:-1]), Interval(at.low[1:], at.high[1:])
        rising, falling = V1.low > 0, V1.high < 0
        monotone = rising | falling
        slope = Interval(np.where(rising, V1.low, -V1.high), np.where(rising, V1.high, -V1.low))
        bottom = Interval(np.where(rising, left.low, right.low), np.where(rising, left.high, right.high))
        top = Interval(np.where(rising, right.low, left.low), np.where(rising, right.high, left.high))

        def swept(E: Reals | float, low: Reals, high: Reals) -> Reals:
            return np.sqrt(np.maximum(E - low, 0)) - np.sqrt(np.maximum(E - high, 0))

        # √(E − bottom) − √(E − top): greatest where E is at the top, least at an end
        peak = np.clip(top.high, energies.low, energies.high)
        most = np.maximum(swept(peak, bottom.low, top.high), swept(energies.low, bottom.low, top.high))
        most = np.maximum(most, swept(energies.high, bottom.low, top.high))
        least = np.minimum(swept(energies.low, bottom.high, top.low), swept(energies.high, bottom.high, top.low))
        y_low, y_high = energies.low - V.high, energies.high - V.low
        width = b - a
        plain_low = np.where(y_high > 0, width * μ.low / np.sqrt(np.maximum(y_high, 1e-300)), 0)
        plain_high = np.where(y_low > 0, width * μ.high / np.sqrt(np.maximum(y_low, 1e-300)), np.inf)
        low = np.where(monotone, np.maximum(2 * μ.low * least / slope.high, 0), plain_low)
        high = np.where(monotone, 2 * μ.high * most / slope.low, plain_high)
        low, high = np.where(np.isfinite(low), low, 0), np.where(np.isnan(high), np.inf, high)
        both = np.maximum(low, np.where(y_low > 0, plain_low, 0)), np.minimum(high, plain_high)
        # of y^(−3/2) where y > 0 on the whole cell
        steep = Interval(
            np.where(y_low > 0, width * μ.low / np.maximum(y_high, 1e-300) ** 1.5, 0),
            np.where(y_low > 0, width * μ.high / np.maximum(y_low, 1e-300) ** 1.5, np.inf),
        )
        square = Interval(slope.low**2, slope.high**2)
    bracket = _FIELD.div(
        _FIELD.sub(_FIELD.mul(μ1, V1), _FIELD.mul(μ, V2)),
        Interval(np.where(monotone, square.low / _OUT, 1), np.where(monotone, square.high * _OUT, 1)),
    )
    # where V falls from a place that E reaches, y > 0 beyond it
    surely = (y_low > 0) | (falling & (energies.low >= left.high))
    return _Cells(V, rising, falling, both[0] / _OUT, both[1] * _OUT, surely, bracket, μ, steep, left, slope)


def across(line: Line, low: float, high: float, energies: Interval, count: int) -> Segment:
    """Enclose the time between two places without a turning point.

    Args:
        line: V and μ.
        low, high: the places, low < high or the same.
        energies: the interval.
        count: of cells.
    """
    if low == high:
        return Segment(Interval(0.0, 0.0), Interval(0.0, 0.0), turns=False, end=high)
    c = _cells(line, _grid(low, high, count), energies, 1)
    time = Interval(float(np.sum(c.low)) / _OUT, float(np.sum(c.high)) * _OUT)
    slope = Interval(-float(np.sum(c.steep.high)) / 2 * _OUT, -float(np.sum(c.steep.low)) / 2 / _OUT)
    return Segment(time, slope, turns=False, end=high)


def outward(line: Line, start: float, sign: int, energies: Interval, count: int) -> Segment:
    """Enclose the time from a place to the turning point beyond it.

    Args:
        line: V and μ.
        start: the place.
        sign: 1 upwards, −1 downwards.
        energies: the interval; E ≥ V there, at least for its upper end.
        count: of cells.
    """
    begin = start * sign
    limit = (line.high if sign > 0 else -line.low) if not line.turn else begin + line.turn
    guess = _first_above(line, begin, sign, energies.high, limit)
    if guess is None:
        return _unturned(line, begin, sign, energies, limit, count)
    inner, beyond = guess
    grid = np.unique(np.concatenate([_grid(begin, inner, count), np.linspace(inner, beyond, 1 + count // 4)]))
    c = _cells(line, grid, energies, sign)
    V_after = np.append(c.nodes.low[1:], line.over(grid[-1:], grid[-1:], sign)[0].low)
    above = np.flatnonzero(V_after > energies.high)
    if not len(above):
        return _undecided(line, begin, sign, energies, limit, count)
    last = int(above[0])
    # from the last cell that is surely inside on, V has to rise
    inside = np.flatnonzero(~c.surely[: last + 1])
    first = int(inside[0]) if len(inside) else last
    decided = bool(np.all(c.rising[first : last + 1]))
    # so far inside that √y hardly varies over the energies
    while (
        first > 0
        and c.rising[first - 1]
        and energies.low - c.nodes.high[first] < _DEEP * (energies.high - energies.low)
    ):
        first -= 1
    before = Interval(float(np.sum(c.low[:first])) / _OUT, float(np.sum(c.high[:first])) * _OUT)
    if not decided:
        return _undecided(line, begin, sign, energies, limit, count)
    around, μ = _turning(c, first, last, energies), c.weight
    time = Interval(
        before.low + around.low * float(np.min(μ.low[first : last + 1])) / _OUT,
        before.high + around.high * float(np.max(μ.high[first : last + 1])) * _OUT,
    )
    return Segment(time, _slope(c, first, last, energies), turns=True, end=grid[last + 1] * sign)


def _turning(c: _Cells, first: int, last: int, energies: Interval) -> Interval:
    """∫ dq/√y over the cells in which V may reach E: 2√y at their beginning over V′, as the differences telescope."""
    zone = slice(first, last + 1)
    low = np.sqrt(max(energies.low - float(c.nodes.high[first]), 0.0))
    high = np.sqrt(max(energies.high - float(c.nodes.low[first]), 0.0))
    return Interval(
        2 * low / float(np.max(c.gradient.high[zone])) / _OUT, 2 * high / float(np.min(c.gradient.low[zone])) * _OUT
    )


def _slope(c: _Cells, first: int, last: int, energies: Interval) -> Interval:
    """dtime/dE: the first rising cells before ``first`` are taken to the part beyond c."""
    k = first
    while k > 0 and c.rising[k - 1]:
        k -= 1
    # c at about half of the rise, so that E − V_c is large and y is away from zero before it
    bottom, top = c.nodes.low[k], energies.low
    while k < first and c.nodes.high[k] < (bottom + 2 * top) / 3 and k + 1 <= first:
        k += 1
    Vc = Interval(c.nodes.low[k], c.nodes.high[k])
    gap = Interval(energies.low - float(Vc.high), energies.high - float(Vc.low))
    if gap.low <= 0 or not np.all(c.surely[:k]):
        return Interval(-np.inf, np.inf)
    part, split = slice(k, last + 1), first - k
    V = Interval(np.minimum(c.V.low[part], energies.high), np.minimum(c.V.high[part], energies.high))
    rise = Interval(np.maximum(V.low - Vc.high, 0), np.maximum(V.high - Vc.low, 0))
    bracket = Interval(c.bracket.low[part], c.bracket.high[part])
    inner = _FIELD.add(
        _FIELD.mul(rise, bracket), _FIELD.div(Interval(c.weight.low[part], c.weight.high[part]), exact(2.0))
    )
    # ∫ dq/√y of a cell: that of μ/√y over μ
    with np.errstate(all="ignore"):
        plain = Interval(c.low[part] / c.weight.high[part], c.high[part] / c.weight.low[part])
    terms = _FIELD.mul(inner, plain)
    around = _turning(c, first, last, energies)
    ends = float(np.min(inner.low[split:])), float(np.max(inner.high[split:]))
    low = float(np.sum(terms.low[:split])) + ends[0] * (around.low if ends[0] > 0 else around.high)
    high = float(np.sum(terms.high[:split])) + ends[1] * (around.high if ends[1] > 0 else around.low)
    low, high = (low / (gap.high if low > 0 else gap.low)), (high / (gap.low if high > 0 else gap.high))
    size = 64 * EPS * (abs(low) + abs(high))
    before = c.steep
    return Interval(
        low - size - float(np.sum(before.high[:k])) / 2 * _OUT, high + size - float(np.sum(before.low[:k])) / 2 / _OUT
    )


def _undecided(line: Line, begin: float, sign: int, energies: Interval, limit: float, count: int) -> Segment:
    """Bound the time from below, to the cells before a place that may or may not be the turning point."""
    return replace(_unturned(line, begin, sign, energies, limit, count), turns=None)


def _unturned(line: Line, begin: float, sign: int, energies: Interval, limit: float, count: int) -> Segment:
    """Where no turning point was seen: proved for all energies, or undecided with a lower bound on the time."""
    far = limit if np.isfinite(limit) else begin + max(1.0, abs(begin)) * 2.0**40
    tops = line.tops(begin, far, sign, ended=bool(np.isfinite(limit) and not line.turn))
    grid = np.unique(np.concatenate([_outgoing(begin, far, count), tops]))
    c = _cells(line, grid, energies, sign)
    tail = True
    if not np.isfinite(limit):
        V = line.over(np.array([far]), np.array([np.inf]), sign)[0]
        tail = bool(V.high[0] < energies.low)
    free = bool(np.all(c.surely)) and tail
    if not free and tail and np.isfinite(limit) and not line.turn:
        k = int(np.flatnonzero(~c.surely)[0])
        free = line.inside_to_end(sign, grid[k] * sign, energies.low)
    missing = np.flatnonzero(~c.surely)
    reach = int(missing[0]) if len(missing) else len(c.surely)
    time = Interval(float(np.sum(c.low[:reach])) / _OUT, np.inf)
    return Segment(time, Interval(-np.inf, np.inf), turns=False if free else None, end=limit * sign)


def _first_above(line: Line, begin: float, sign: int, E: float, limit: float) -> tuple[float, float] | None:
    """About where V first exceeds E, in doubles: a place before and one beyond; None where it does not."""
    far = limit if np.isfinite(limit) else begin + max(1.0, abs(begin)) * 2.0**40
    grid, V = line.sampled(begin, far, sign, ended=bool(np.isfinite(limit) and not line.turn))
    above = np.flatnonzero(V > E)
    if not len(above):
        return None
    k = int(above[0])
    low, high = (begin if k == 0 else float(grid[k - 1])), float(grid[k])
    for _ in range(8):
        inner = np.linspace(low, high, 66)[1:]
        k = int(np.argmax(line.over(inner, inner, sign)[0].low > E))
        low, high = (low if k == 0 else float(inner[k - 1])), float(inner[k])
    reach = max(high - begin, 1e-12 * max(1.0, abs(begin)))
    return high - 0.02 * reach, high + max(1e-6 * reach, 4 * EPS * abs(high))


def _around_tops(line: Line, grid: Reals, sign: int) -> Reals:
    """Return the places where V is greatest among its neighbours, and places next to them in geometric rows.

    An energy a little below a barrier exceeds V but for a narrow zone there, and a motion takes long before it.
    """
    V = line.over(grid, grid, sign)[0].low
    places = [np.zeros(0)]
    for k in np.flatnonzero((V[1:-1] > V[:-2]) & (V[1:-1] >= V[2:])) + 1:
        low, high = float(grid[k - 1]), float(grid[k + 1])
        reach = min(float(grid[k]) - low, high - float(grid[k]))
        for _ in range(8):
            inner = np.linspace(low, high, 33)
            top = int(np.clip(np.argmax(line.over(inner, inner, sign)[0].low), 1, 31))
            low, high = float(inner[top - 1]), float(inner[top + 1])
        row = reach * 2.0 ** -np.arange(40)
        places += [(low + high) / 2 + np.concatenate([-row, [0.0], row])]
    found = np.concatenate(places)
    return found[(found > grid[0]) & (found < grid[-1])]


def _grid(low: float, high: float, count: int) -> Reals:
    """Places between two, closer together at both ends."""
    angle = np.linspace(0, np.pi, count + 1)
    grid = low + (high - low) * np.sin(angle / 2) ** 2
    grid[0], grid[-1] = low, high
    return np.unique(grid)


def _outgoing(begin: float, far: float, count: int) -> Reals:
    """Places from one outward: finely next to it, then in a geometric row."""
    reach = far - begin
    steps = reach * np.geomspace(1e-12 if reach < 1e3 else 1e-6 / reach, 1.0, count)
    if reach < 1e3:
        steps = np.unique(np.concatenate([steps, reach * np.linspace(0, 1, count + 1)[1:]]))
    grid = np.concatenate([[begin], begin + steps])
    grid[-1] = far
    return np.unique(grid)
