"""Where a motion turns: the zeros of p² next to the initial place, found by exclusion, not by luck.

From the start the scan walks outward over cells. One is passed only when interval arithmetic proves F = p² > 0, or F′
or F″ of one sign so that a few exact values decide it. What doubles cannot decide (near-circular,
near-separatrix) is decided with more digits, and what no cell decides far out, where F tends to zero or its terms
overflow, by how F grows towards infinity (``asymptotic_expansion``). A zero of F at a critical point that stays zero to
``_LAST_BITS`` digits is a double zero: the motion needs infinite time to reach it (Greenwood, item 41).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from hjsolve.arithmetic.asymptotic_expansion import BITS
from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf, Numeric, Reals
from hjsolve.arithmetic.root_finding import bracketed_root, leading_power
from hjsolve.errors import NotConvergedError, required
from hjsolve.one_coordinate.momentum_squared import Number
from hjsolve.one_coordinate.ray import Ray, SimpleZero
from hjsolve.one_coordinate.time_along_a_path import stopwatch

EndKind = Literal["turning", "wall", "asymptote", "boundary", "fall", "infinity", "round", "kink"]
_LAST_BITS = 2048  # 616 digits: zeros that are nearer to each other count as a double one
_DEPTH = 40  # halvings of a cell before it is given up
_MOST_WORK, _COST_OF_MANY_DIGITS = 2000, 10
"""Divisions of cells before a search is given up; what one costs in many digits, in doubles 1."""
_EXACT = 6  # halvings after which many digits decide: doubles have not
_STUBBORN = 3
"""Divisions of a cell after which what lies beyond it is looked at as a whole."""
_FARTHEST = 2032
"""How far p² is sampled beyond all cells, as a power of two: over all places that are doubles."""
_TOGETHER = 48  # cells in one call of numpy, which costs as much as one


@dataclass(frozen=True)
class End:
    """Where the allowed region stops on one side.

    Attributes:
        kind: ``turning`` a simple zero of p²; ``wall`` a jump of V that it is thrown back by; ``asymptote`` a multiple
            zero, never reached; ``boundary`` an end of the coordinate's domain (``fall`` where an integral over the way
            there has no limit, see ``chebyshev_panels``); ``infinity``; ``round`` none within a full turn of an angle;
            ``kink`` where p² goes on with another formula.
        place: the position at any precision; None for infinity and round.
        power: at a boundary or at infinity, p² ~ distance**power.
    """

    kind: EndKind
    place: Number | None = None
    power: float = 1.0


def first_end(ray: Ray, *, digits: int) -> End:
    """Walk along the ray to the first zero of p², or to the end of the domain.

    p² must be positive just after the origin (zero at the origin itself is allowed).

    Args:
        ray: where to look.
        digits: relative digits wanted of a turning point's distance from the origin.

    Raises:
        NotConvergedError: a cell could not be decided even with many digits.
    """
    cells = _cells(ray)
    todo = list(itertools.pairwise(cells))
    exact = not _within_doubles(ray)
    enclosures = _enclose(ray, todo, 256 if exact else 53)
    found = _search(ray, [_Cell(c, e, 0, exact) for c, e in zip(todo, enclosures, strict=True)], digits)
    if found is not None:
        return found
    if ray.turns:
        return End("round")
    return _beyond(ray, float(cells[-1]), digits)


def _within_doubles(ray: Ray) -> bool:
    """Return False where p² at the start is so small or large that intervals of doubles tell nothing of it."""
    jet, length = ray.jet(0, 256), multiprecision(256).mpf(_scale(ray))
    return 1e-250 < max(abs(part) * length**k for k, part in enumerate(jet)) < 1e250


def _cells(ray: Ray) -> Reals:
    """Edges growing geometrically from the origin and, where the domain ends, shrinking towards its end."""
    if ray.reach is None:
        # powers of two of a length of the motion: a cell is as long as its distance from the origin, which intervals
        # resolve
        edges = np.ldexp(_scale(ray), np.arange(-50, min(120, 1023 - int(np.frexp(_scale(ray))[1]))))
        return np.concatenate([[0.0], edges])
    reach = float(ray.reach(128))
    outward = reach * 2.0 ** np.arange(-50, 0)
    # towards an end of the domain cells shrink with the distance to it: p² may have a pole there
    inward = np.zeros(0) if ray.turns else reach * (1 - 2.0 ** -np.arange(2, 41))
    return np.concatenate([[0.0], outward, inward, [reach] if ray.turns else []])


def _scale(ray: Ray) -> float:
    """Return a length typical of the start: |q|, or where p² changes by itself."""
    q = abs(float(ray.origin(128)))
    if q:
        return q
    value, first, second = (abs(float(part)) for part in ray.jet(0, 128))
    # at q = 0 the lengths F/F′ and √(F/F″) take the place of |q|
    guesses = [value / first if first else 0.0, (value / second) ** 0.5 if second else 0.0]
    return max(guesses) or 1.0


def _enclose(ray: Ray, cells: list[tuple[float, float]], bits: int) -> list[_Enclosure]:
    x0, x1 = (np.array(ends) for ends in zip(*cells, strict=True))
    value, first, second = ray.enclose(x0, x1, bits)
    return list(zip(value.low, value.high, first.low, first.high, second.low, second.high, strict=True))


_Enclosure = tuple[Numeric, Numeric, Numeric, Numeric, Numeric, Numeric]
"""Both ends of the enclosures of F, F′ and F″."""


class _Cell(NamedTuple):
    """A piece of the ray, its enclosures of F, F′ and F″ (two ends each), and how often it was divided.

    ``unresolved``: its enclosure of F is no narrower than that of what it is a part of, so it is all rounding, or
    doubles do not reach that far. ``singular``: F has no bounds there in any precision. ``rounded``: no part of it has
    a narrower enclosure in doubles than it has itself; it waits for many digits, undivided.
    """

    ends: tuple[float, float]
    enclosure: _Enclosure
    depth: int
    unresolved: bool = False
    singular: bool = False
    rounded: bool = False

    @property
    def overflowed(self) -> bool:
        """True where doubles found nothing, because they do not reach that far."""
        return self.undecided and not (self.unresolved or self.singular or _finite(self.enclosure))

    @property
    def positive(self) -> bool:
        return bool(self.enclosure[0] > 0)

    @property
    def undecided(self) -> bool:
        """True where F may vanish and neither F nor F′ is known to be monotone."""
        low, _, slope_low, slope_high, bend_low, bend_high = self.enclosure
        return bool(not low > 0 and not (slope_low > 0 or slope_high < 0 or bend_low > 0 or bend_high < 0))


def _search(ray: Ray, cells: list[_Cell], digits: int) -> End | None:
    """Decide cells in their order: the first end in them, or None where p² stays positive.

    Raises:
        TooSlowError: not in the time that it may take.
        NotConvergedError: the work is beyond ``_MOST_WORK``: interval arithmetic does not see what p² does there.
    """
    work, outlook, check = 0, _Outlook(ray), stopwatch(digits)
    while cells:
        first = cells[0]
        check(partial(_sought, ray, first))
        # a cell that dividing does not settle: what lies beyond it may be decided as a whole, by the expansion at
        # infinity
        stubborn = first.undecided and (first.unresolved or first.depth >= _STUBBORN)
        if (first.overflowed or stubborn) and outlook.clear(first.ends[0]):
            return None
        # doubles have said all they can: many digits decide this one cell
        if first.overflowed or first.rounded:
            work += 1 if first.rounded else _COST_OF_MANY_DIGITS
            cells = [_exactly(ray, first), *cells[1:]]
            continue
        if first.undecided and _pieces(ray, first):
            work += 1 if first.depth < _EXACT else _COST_OF_MANY_DIGITS
            if work > _MOST_WORK:
                raise NotConvergedError(
                    f"p² could not be decided near q = {float(ray.place(first.ends[0], 128)):.15g}: its terms vary by "
                    "too many orders of magnitude on the way there; give the coordinate a domain that ends before"
                )
            cells = _divided(ray, cells)
            continue
        # F, F′ or F″ has one sign on it: a few exact values decide
        found = None if first.positive else _settle(ray, first.ends, digits)
        if found is not None:
            return found
        cells = cells[1:]
    return None


def _sought(ray: Ray, cell: _Cell) -> str:
    return f"where p² vanishes beyond q = {float(ray.place(cell.ends[0], 128)):.9g}"


class _Outlook:
    """Where p² is known to stay positive up to infinity, or to the end of the domain; asked once a factor of two."""

    def __init__(self, ray: Ray):
        self.ray = ray
        self.asked: set[int] = set()

    def clear(self, x: float) -> bool:
        """Return True when p² > 0 from a distance x on."""
        if self.ray.turns:
            return False
        # an expansion holds from a place on: asked once an octave, it costs what a few cells cost
        left = x if self.ray.reach is None else float(self.ray.reach(BITS) - x)
        octave = int(np.frexp(left)[1])
        if octave in self.asked:
            return False
        self.asked.add(octave)
        return _stays_positive(self.ray, x)


def _stays_positive(ray: Ray, x: float) -> bool:
    if ray.reach is not None:
        bits = BITS + 2 * ray.radicand.guard
        reach = ray.reach(bits)
        # the expansion in the distance that is left to the end
        return ray.radicand.sign_before(ray.place(reach, bits), ray.side, reach - x) > 0
    # a little nearer than the cell: its rounded edge may lie beyond it
    far = ray.side * float(ray.place(x, 128))
    return ray.radicand.sign_beyond(ray.side, far * (1 - 2.0**-50)) > 0


def _exactly(ray: Ray, cell: _Cell) -> _Cell:
    """Return the same cell in many digits."""
    enclosure = _enclose(ray, [cell.ends], 256)[0]
    return _Cell(cell.ends, enclosure, cell.depth, unresolved=_finite(enclosure), singular=not _finite(enclosure))


def _finite(enclosure: _Enclosure) -> bool:
    return bool(abs(enclosure[0]) < np.inf and abs(enclosure[1]) < np.inf)


def _divided(ray: Ray, cells: list[_Cell]) -> list[_Cell]:
    """Divide the first cell, and with it those that wait behind it for the same: many enclosures cost little more."""
    depth = cells[0].depth
    # many digits where doubles were divided often, or have rounded away what is asked
    exact = depth >= _EXACT or cells[0].unresolved
    together = 1 if exact else _TOGETHER
    alike = [c.undecided and c.depth == depth and c.unresolved <= exact for c in cells[:together]]
    pieces = [_pieces(ray, c) if same else [] for c, same in zip(cells[:together], alike, strict=True)]
    bits = max(64 * depth, 256) if exact else 53
    enclosures = iter(_enclose(ray, list(itertools.chain(*pieces)), bits))
    result: list[_Cell] = []
    for cell, parts in zip(cells[:together], pieces, strict=True):
        inner = [next(enclosures) for _ in parts]
        # an enclosure that does not shrink with its cell is rounding, not range: dividing it further is idle
        widths, enough = [e[1] - e[0] for e in inner], 0.6 * (cell.enclosure[1] - cell.enclosure[0])
        if parts and not exact and enough <= min(widths) <= max(widths) < np.inf:
            result.append(cell._replace(rounded=True))
            continue
        unresolved = bool(parts) and not max(widths) < enough
        unresolved = cell.unresolved or (depth > 0 and unresolved)
        result += [
            _Cell(part, e, depth + 1, unresolved, cell.singular) for part, e in zip(parts, inner, strict=True)
        ] or [cell]
    return result + cells[together:]


def _pieces(ray: Ray, cell: _Cell) -> list[tuple[float, float]]:
    """Return the parts of a cell; none where doubles cannot divide it.

    Raises:
        NotConvergedError: it was divided too often already.
    """
    if cell.depth > _DEPTH:
        why = (
            "it may have a zero of high multiplicity there"
            if _finite(cell.enclosure)
            else "it has a pole or no real value there; give the coordinate a domain that ends at that place"
        )
        raise NotConvergedError(f"p² could not be decided near q = {float(ray.place(cell.ends[0], 128)):.15g}: {why}")
    # eight at first, when a cell is still an octave long; later halves, towards the one place that does not settle
    parts = 8 if cell.depth < 4 else 2
    edges = np.linspace(*cell.ends, parts + 1)
    return [] if len(set(edges)) < parts + 1 else list(itertools.pairwise(edges))


def _settle(ray: Ray, cell: tuple[float, float], digits: int) -> End | None:
    """Decide a cell on which F is monotone or F′ is: at most one critical point, found exactly."""
    x0, x1 = cell
    bits = 256
    # 256 bits: what interval arithmetic left open is decided at the ends, with digits to spare
    f0, d0, _ = ray.jet(x0, bits)
    f1, d1, _ = ray.jet(x1, bits)
    # F = F′ = 0 at the end of a cell: a double zero, as exactly as 256 bits tell
    if d1 == 0 and abs(f1) <= abs(f0) * multiprecision(bits).mpf(2) ** (24 - bits):
        return End("asymptote", partial(_at, ray, x1), 2.0)
    # F is monotone on the cell: a sign change is one simple zero
    if d0 * d1 >= 0:
        return _turning(ray, x0, x1, digits) if f1 < 0 else None
    # F rises to a maximum: the zero, if there is one, lies beyond it
    if d0 > 0:
        maximum = _critical(ray, x0, x1, bits)
        return _turning(ray, maximum, x1, digits) if f1 < 0 else None
    while True:
        # F falls and rises: two zeros, one double zero or none, by the value at the minimum
        minimum = _critical(ray, x0, x1, bits)
        value, _, bend = ray.jet(minimum, bits)
        # what 24 bits less than the precision leave of the largest terms: below it the sign is not known
        rounding = max(abs(f0), abs(f1), abs(bend) * (x1 - x0) ** 2) * multiprecision(bits).mpf(2) ** (24 - bits)
        if value < -rounding:
            return _turning(ray, x0, minimum, digits)
        if value > rounding:
            return None
        if bits >= _LAST_BITS:
            return End("asymptote", partial(_at_critical, ray, x0, x1), 2.0)
        # a close pair of zeros and a double one look alike until the precision tells them apart
        bits *= 2


def _at(ray: Ray, x: float | Mpf, bits: int) -> Mpf:
    return ray.place(x, bits + 32)


def _at_critical(ray: Ray, x0: float | Mpf, x1: float | Mpf, bits: int) -> Mpf:
    return _at(ray, _critical(ray, x0, x1, bits + 32), bits)


def _at_reach(ray: Ray, bits: int) -> Mpf:
    return _at(ray, required(ray.reach)(bits + 32), bits)


def _critical(ray: Ray, x0: float | Mpf, x1: float | Mpf, bits: int) -> Mpf:
    """Return the zero of F′ in a cell where F′ is monotone."""
    return bracketed_root(lambda x: ray.jet(x, bits)[1:], x0, x1, bits)


def _turning(ray: Ray, x0: float | Mpf, x1: float | Mpf, digits: int) -> End:
    """Return a simple zero of F in a cell where F is monotone."""
    return End("turning", SimpleZero(ray, x0, x1, digits))


def end_of(ray: Ray, inside: float, outside: float) -> End:
    """Return the only zero of F between two distances, a simple one; at the origin if both are 0.

    Args:
        ray: the half line.
        inside, outside: the distances.
    """
    return _turning(ray, inside, outside, 15) if outside else End("turning", ray.origin)


def _positive_to_infinity(ray: Ray, last: float) -> bool:
    """Whether p² is enclosed in positive numbers from a distance on."""
    with np.errstate(all="ignore"):
        value, _, _ = ray.enclose(np.array([last]), np.array([np.inf]), 53)
    return bool(value.low[0] > 0)


def _beyond(ray: Ray, last: float, digits: int) -> End:
    """Return what p² does past the last cell: a power of the distance to the end of the domain, or of q.

    Signs are sampled along a geometric sequence; a sign change is a turning point.
    """
    if ray.reach is None and _stays_positive(ray, last):
        return End("infinity")
    # a place that is 2⁻²⁰⁸⁸ of the way before an end is told from it by so many bits alone
    bits = 3072
    context = multiprecision(bits)
    powers = [*range(0, 400, 16), *range(432, _FARTHEST, 64), _FARTHEST, _FARTHEST + 16]
    if ray.reach is None:
        # a geometric sequence: p² behaves like a power there, and a sign change between two samples is one
        steps = [context.mpf(last) * context.mpf(2) ** k for k in powers]
    else:
        steps = [ray.reach(bits) * (1 - context.mpf(2) ** -(40 + k)) for k in powers]
    before = context.convert(last)
    values = []
    for x in steps:
        values.append(ray.radicand.value(ray.place(x, bits), bits))
        if values[-1] < 0:
            return _turning(ray, before, x, digits)
        before = x
    end = None if ray.reach is None else ray.place(ray.reach(bits), bits)
    # the sign of the leading term decides what samples cannot: a zero farther out than any double
    sign = ray.radicand.sign_in_the_end(ray.side, end)
    if sign < 0 or (sign == 0 and ray.reach is None and not _positive_to_infinity(ray, last)):
        where = f"beyond q = {context.nstr(ray.place(steps[-1], bits), 3)}"
        if end is not None:
            where = f"within {context.nstr(abs(end - ray.place(steps[-1], bits)), 3)} of {context.nstr(end, 6)}"
        raise NotConvergedError(
            f"p² vanishes {where}, which is farther than it is looked for" if sign < 0
            else f"whether p² vanishes {where} was not decided"
        )  # fmt: skip
    # the steps grow towards infinity, and the distances to an end shrink: hence the sign
    power = leading_power(values, context) * (1 if ray.reach is None else -1)
    if ray.reach is None:
        return End("infinity", None, power)
    # ∫ dq/p ~ ∫ x^(−power/2) dx is finite for power < 2
    return End("boundary" if power < 2 else "asymptote", partial(_at_reach, ray), power)
