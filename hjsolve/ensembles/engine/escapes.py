"""Proof that coordinates of many orbits run away: p² > 0 from the last turning point to infinity.

That no turning point was met on the route outwards proves nothing: a narrow barrier may stand between two trials. Here
interval arithmetic covers the route with cells over which p² is positive, up to a place X, for many orbits at once;
beyond X the asymptotic expansion of p² is positive (``arithmetic/sign_at_infinity``), for all orbits whose constants
lie in a box at once: few boxes hold them all. At a turning point F changes its sign between two places a rounding
apart, and its slope does not vanish in the cell next to it. What is not proved is left to the engine of single motions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS, Float64, Multi
from hjsolve.arithmetic.interval import Interval, Intervals
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.machine.code import MachineCode
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Mpf, Reals, Which
from hjsolve.arithmetic.sign_at_infinity import sign_beyond_for_all
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, place
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model
from hjsolve.ensembles.engine.programs import sides

_INTERVALS = Intervals(Float64())
_FAR = (6, 24, 80)
"""Powers of two, over the size of the orbit, at which the expansion at infinity is asked to hold."""

_RATIO = 4.0
"""Of the distances at which a cell ends and begins, before it is divided."""

_CELL_HALVINGS = 8
"""Of a cell, until the ratio of its ends is 4^(2⁻⁸) = 1.005; narrower ones are left to the engine of single motions."""
_MOST_CELLS = 64
"""Cells of one orbit that may wait to be divided."""

_MOST_FIRST_CELLS = 10
"""Of the length of the cell next to a turning point, each a fourth of the last."""

_MIXED = 0.5
"""Powers of two that a constant of both signs counts as: it is divided before one that spans more than √2 of one sign
only if nothing else does, since the energy, which leads p² at infinity, has one sign."""
_BITS = 256
"""Of the ends of a box: those are doubles, so that rounding at 2⁻²⁵⁶ widens a box by nothing that matters."""


@dataclass(frozen=True)
class EscapeRoute:
    """The route of n orbits, from a place to infinity; arrays (n,).

    In its methods x are cells, ``index`` the orbit of every cell.

    Attributes:
        formula: of p² as a function of x.
        constants, uncertainty: of the motion, and bounds on their errors, shape (constants, n).
        parameters: in two doubles.
        exact: the same as fractions.
        side: +1 or −1, in which direction of x infinity lies.
        start: x of the turning point, or of the orbit where there is none on the other side.
        error: how far the turning point may be from there; 0 where there is none.
        size: a length of the orbit.
    """

    formula: LoweredFormula
    constants: Reals
    uncertainty: Reals
    parameters: tuple[Pair, ...]
    exact: tuple[Fraction, ...]
    side: int
    start: Reals
    error: Reals
    size: Reals

    def take(self, index: Which) -> EscapeRoute:
        """Return those of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        arrays = (self.start[index], self.error[index], self.size[index])
        known = self.constants[:, index], self.uncertainty[:, index], self.parameters, self.exact
        return EscapeRoute(self.formula, *known, self.side, *arrays)

    def numbers(self, index: Integers) -> list[Interval]:
        """Return enclosures of the constants of some orbits, and of the parameters.

        Args:
            index: which orbits, one for every cell.
        """
        parameters = []
        for pair in self.parameters:
            value, reach = np.array(pair.high), abs(pair.high) * EPS if pair.low else 0.0
            parameters.append(Interval(value - reach, value + reach))
        return self.enclosed(index) + parameters

    def enclosed(self, index: Integers) -> list[Interval]:
        """Return enclosures of the constants of some orbits."""
        pairs = zip(self.constants, self.uncertainty, strict=True)
        # the bound of the constant and the rounding of c ± e
        wide = [(c[index], e[index] + EPS * np.abs(c[index])) for c, e in pairs]
        return [Interval(c - e, c + e) for c, e in wide]

    def radicand(self, index: Integers, x: Interval) -> Interval:
        """Return an enclosure of F over cells."""
        found = self.formula.squared.run(_INTERVALS, [x, *self.numbers(index)])[0]
        # a formula that lacks x gives one number: it is spread over the cells
        return Interval(found.low + 0.0 * x.low, found.high + 0.0 * x.low)

    def slope(self, index: Integers, x: Interval) -> Interval:
        """Return an enclosure of F′ over cells."""
        jets = Jets(_INTERVALS)
        known = [Jet(number) for number in self.numbers(index)]
        first = self.formula.squared.run(jets, [jets.variable(x), *known])[0].first
        return Interval(0.0 * x.low, 0.0 * x.low) if first is None else first

    def about_middle(self, index: Integers, x: Interval) -> Reals:
        """Return a lower bound of F over cells by its mean value form, F(m) + F′·(x − m).

        Where large terms nearly cancel, F = 2E + 1 − √(x/(x + a)) far out, the plain enclosure is useless.
        """
        middle = 0.5 * (x.low + x.high)
        point = Interval(middle, middle)
        # F(m) is sharp, and F′ is multiplied by half the length of the cell
        away = _INTERVALS.mul(self.slope(index, x), _INTERVALS.sub(x, point))
        return _INTERVALS.add(self.radicand(index, point), away).low


def escaping(one: CoordinateOfOrbits, model: Model, offsets: Reals) -> tuple[Mask, Reals]:
    """Prove that a coordinate runs away, of orbits that met no end on a side.

    Args:
        model: with the parameters.
        offsets: of the turning points, NaN where none was met, shape (2, n).

    Returns:
        True where it is proved, shape (n,), and the errors of the turning points, NaN on a side that has none.
    """
    coordinate, count = one.coordinate, len(one.q)
    proved, errors = np.zeros(count, dtype=bool), np.full((2, count), np.nan)
    endless = np.isnan(offsets)
    for k, formula in enumerate((coordinate.lower, coordinate.upper)):
        index = np.flatnonzero(endless[k] & ~endless[1 - k])
        if formula is None and len(index):
            seen, x = sides(coordinate)[1 - k], offsets[1 - k, index]
            slopes = one.programs.views[1 - k].slopes
            route = _from_turning_point(one.take(index), seen, slopes, model, x, (2 * k - 1) * seen.sign)
            proved[index] = _free(route)
            errors[1 - k, index] = route.error + 2 * EPS * (np.abs(place(seen, x)) + np.abs(x))
    both = np.flatnonzero(endless[0] & endless[1])
    if coordinate.lower is None and coordinate.upper is None and len(both):
        some = one.take(both)
        known = some.constants, some.uncertainty, model.numbers, model.exact
        routes = (EscapeRoute(coordinate.plain, *known, k, some.q, 0.0 * some.q, 1.0 + np.abs(some.q)) for k in (-1, 1))
        proved[both] = np.logical_and.reduce([_free(route) for route in routes])
    return proved, errors


def _from_turning_point(
    one: CoordinateOfOrbits, seen: LoweredFormula, slopes: MachineCode, model: Model, x: Reals, outward: int
) -> EscapeRoute:
    size = np.maximum(np.abs(x), np.abs(one.q - place(seen, x)))
    known = one.constants, one.uncertainty, model.numbers, model.exact
    route = EscapeRoute(seen, *known, outward, x, np.zeros_like(x), size)
    with np.errstate(all="ignore"):
        here = route.radicand(np.arange(len(x)), Interval(x, x))
        slope = run_rows(slopes, one.parameters, np.stack([x, *one.constants]))[1]
        # twice what F may be at the place over its slope: the sign change on both sides of it is proved later
        error = 2 * np.maximum(-here.low, here.high) / np.abs(slope) + 4 * EPS * np.abs(x) + 1e-300
    return replace(route, error=error)


def _free(route: EscapeRoute) -> Mask:
    """Return whether F > 0 along the whole route, and the turning point is where it is said to be."""
    with np.errstate(all="ignore"):
        left = np.flatnonzero(np.isfinite(route.start) & np.isfinite(route.error) & np.isfinite(route.size))
        proved, begin = np.zeros(len(route.start), dtype=bool), np.full(len(route.start), np.nan)
        begin[left] = _begun(route.take(left))
        left = left[np.isfinite(begin[left])]
        for power in _FAR:
            # the expansion holds from some distance on: three are tried, the nearest first, which needs fewest cells
            far = 2.0**power * np.maximum(route.size[left], 1.0)
            good = _beyond(route.take(left), far)
            clear = np.zeros(len(left), dtype=bool)
            clear[good] = _positive(route.take(left[good]), begin[left[good]], far[good])
            proved[left[clear]] = True
            left = left[~good]
            if not len(left):
                break
    return proved


def _begun(route: EscapeRoute) -> Reals:
    """Return the distance up to which the first cell is settled, NaN where it is not."""
    everything, side = np.arange(len(route.start)), route.side
    turning = route.error > 0
    outer, inner = route.start - side * route.error, route.start + side * route.error
    # F < 0 just outside and F > 0 just inside: the turning point lies between
    sure = ~turning | (
        (route.radicand(everything, Interval(outer, outer)).high < 0)
        & (route.radicand(everything, Interval(inner, inner)).low > 0)
    )
    begin, length = np.full(len(route.start), np.nan), 0.5 * route.size
    left = np.flatnonzero(sure)
    for _ in range(_MOST_FIRST_CELLS):
        some = route.take(left)
        first = np.where(turning[left], outer[left], some.start)
        cell = _cell(first, some.start + side * length[left])
        slope, value = some.slope(np.arange(len(left)), cell), some.radicand(np.arange(len(left)), cell)
        # F rises outward all along the first cell: no second zero next to the turning point
        rising = slope.low > 0 if side > 0 else slope.high < 0
        good = np.where(turning[left], rising, value.low > 0) & (length[left] > 4 * route.error[left])
        begin[left[good]] = length[left[good]]
        left = left[~good]
        length[left] *= 0.25
        if not len(left):
            break
    return begin


def _cell(one: Reals, other: Reals) -> Interval:
    return Interval(np.minimum(one, other), np.maximum(one, other))


def _positive(route: EscapeRoute, begin: Reals, far: Reals) -> Mask:
    """Return whether F > 0 at all distances from ``begin`` to beyond x = ``far``."""
    n, side = len(begin), route.side
    end = far + np.abs(route.start)
    # a geometric sequence of cells: F behaves like a power over each
    steps = np.ceil(np.log(end / begin) / np.log(_RATIO)).astype(int)
    orbit = np.repeat(np.arange(n), steps)
    place = np.arange(len(orbit)) - np.repeat(np.cumsum(steps) - steps, steps)
    near, away = (begin[orbit] * _RATIO ** (place + k) for k in (0.0, 1.0))
    lost = np.zeros(n, dtype=bool)
    for _ in range(_CELL_HALVINGS):
        cell = _cell(route.start[orbit] + side * near, route.start[orbit] + side * away)
        bad = ~(route.radicand(orbit, cell).low > 0)
        # the costlier form for the cells alone that the plain one left open
        bad[bad] = ~(route.about_middle(orbit[bad], Interval(cell.low[bad], cell.high[bad])) > 0)
        orbit, near, away = orbit[bad], near[bad], away[bad]
        # an orbit that keeps dividing is left to the engine of single motions
        lost |= np.bincount(orbit, minlength=n) > _MOST_CELLS
        kept = ~lost[orbit]
        orbit, near, away = orbit[kept], near[kept], away[kept]
        if not len(orbit):
            break
        # the geometric mean: halves are alike
        middle = np.sqrt(near * away)
        orbit = np.concatenate([orbit, orbit])
        near, away = np.concatenate([near, middle]), np.concatenate([middle, away])
    lost[orbit] = True
    return ~lost


# ------------------------------------------------------------------------------------------------ to infinity
def _beyond(route: EscapeRoute, far: Reals) -> Mask:
    """Return whether F > 0 wherever side·x ≥ far: over one endless cell, or by expansions."""
    proved = (
        route.radicand(np.arange(len(far)), _cell(route.side * far, np.full_like(far, route.side * np.inf))).low > 0
    )
    left = np.flatnonzero(~proved)
    if len(left):
        _for_box(route, far, left, proved)
    return proved


def _for_box(route: EscapeRoute, far: Reals, index: Integers, proved: Mask) -> None:
    """Prove it for the box that holds the constants of some orbits, or for two halves of them.

    ``far`` becomes the greatest of a box where it is proved.
    """
    most = far[index].max()
    # one expansion for all orbits whose constants lie in the box
    if sign_beyond_for_all(route.formula.squared, _box(route, index), route.side, float(most), _BITS) > 0:
        proved[index], far[index] = True, most
        return
    values = [c[index] for c in route.constants]
    widths = [_spread(c) for c in values]
    if len(index) == 1 or not any(widths):
        return
    widest = widths.index(max(widths))
    order = index[np.argsort(values[widest], kind="stable")]
    cut = _cut(route.constants[widest][order])
    _for_box(route, far, order[:cut], proved)
    _for_box(route, far, order[cut:], proved)


def _spread(values: Reals) -> float:
    """Return how many powers of two values span; those with both signs come next to those that span half a power.

    What leads p² at infinity is mostly a constant of one sign, the energy, and has to be known best.
    """
    least, most = float(np.min(values)), float(np.max(values))
    if least == most:
        return 0.0
    return float(abs(np.log2(most / least))) if least * most > 0 else _MIXED


def _cut(values: Reals) -> int:
    """Return where to divide sorted values: at a change of sign, else in the middle of their logarithms."""
    negative = int(np.searchsorted(values, 0.0))
    if 0 < negative < len(values):
        return negative
    level = np.sign(values[-1] or values[0]) * np.sqrt(values[0] * values[-1])
    return int(np.clip(np.searchsorted(values, level), 1, len(values) - 1))


def _box(route: EscapeRoute, index: Integers) -> list[tuple[Mpf, Mpf]]:
    convert = Multi(_BITS).convert
    known = route.enclosed(index)
    boxes = [(convert(float(np.min(c.low))), convert(float(np.max(c.high)))) for c in known]
    # sharp, as for single motions: log R of two terms with one factor G cancels whatever G is, in a range it would not
    return boxes + [(convert(number),) * 2 for number in route.exact]
