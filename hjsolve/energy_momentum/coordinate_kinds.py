"""The kinds of motion of one coordinate at many points of the plane of two constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.root_finding import bisected
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.energy_momentum.exact_regions import at_place, regions_with_kinds
from hjsolve.energy_momentum.isolation import Reals
from hjsolve.energy_momentum.momentum_polynomial import MomentumPolynomial
from hjsolve.errors import NotConvergedError, required
from hjsolve.one_coordinate.classify import locate
from hjsolve.solution.quadratures import Solution

Kinds = tuple[str, ...]
UNDECIDED = "undecided"
_MARGIN = 1e-9
"""A start nearer to a turning point than this part of the domain counts as at it."""


@dataclass(frozen=True, repr=False, eq=False)
class CoordinateKinds(ByValue, Shown):
    """One separated coordinate, with every constant and parameter known but two.

    Attributes:
        solution: of the system.
        name: the coordinate.
        values: symbol → exact number, of the parameters and the other constants.
        constants: the symbols of the two.
        polynomial: its P² as a polynomial; None where no known variable makes it one.
        place: inside its domain.
        words: signature → kinds, of what was decided before.
    """

    solution: Solution = field(repr=False)
    name: str
    values: Mapping[sp.Symbol, sp.Expr] = field(repr=False)
    constants: tuple[sp.Symbol, sp.Symbol]
    polynomial: MomentumPolynomial | None = field(repr=False)
    place: sp.Expr = field(repr=False)
    words: dict[tuple[int, int], Kinds] = field(default_factory=dict, repr=False)

    def at(self, x: Reals, y: Reals, *, every: bool = True) -> Regions:
        """Find the regions at many points.

        Args:
            x, y: values of the two constants, shape (m,).
            every: also at doubtful points, by the exact search.
        """
        m = len(x)
        if self.polynomial is None:
            return self._one_by_one(_nothing(self, x, y))
        parts = self.polynomial.roots(x, y)
        doubtful = np.logical_or.reduce([part.doubtful for part in parts])
        owner = np.concatenate([part.owner for part in parts])
        low = np.concatenate([part.low + k for k, part in enumerate(parts)])
        high = np.concatenate([part.high + k for k, part in enumerate(parts)])
        order = np.lexsort((low, owner))
        order = order[~doubtful[owner[order]]]
        owner, low, high = owner[order], low[order], high[order]
        count = np.bincount(owner, minlength=m)
        first = np.concatenate([[0], np.cumsum(count)[:-1]])
        found = Regions(self, x, y, parts[0].sign, count, doubtful, first, low, high, np.empty(m, dtype=object))
        for sign in (-1, 1):
            for number in np.unique(count):
                same = np.flatnonzero(~doubtful & (parts[0].sign == sign) & (count == number))
                if len(same):
                    if (sign, int(number)) not in self.words:
                        self.words[sign, int(number)] = self._kinds_of(found, found.clearest(same))
                    _fill(found.kinds, same, self.words[sign, int(number)])
        return self._one_by_one(found) if every else found

    def exactly(self, x: float, y: float) -> dict[sp.Symbol, sp.Expr]:
        """Return the exact value of every constant and parameter at a point.

        Args:
            x, y: the point, its doubles taken for the numbers they are.
        """
        return {**self.values, self.constants[0]: sp.Rational(float(x)), self.constants[1]: sp.Rational(float(y))}

    def _kinds_of(self, found: Regions, i: int) -> Kinds:
        """Return the kinds of the regions at one point, in order of q.

        What two zeros enclose librates, the rest is asked.
        """
        count, sign = int(found.count[i]), int(found.sign[i])
        if required(self.polynomial).closed:
            return ("libration",) * (count // 2) if count else ("rotation",) * (sign > 0)
        return tuple(
            "libration" if 0 < j < count else self._open_kind(found.inside(i, j), float(found.x[i]), float(found.y[i]))
            for j in range(count + 1)
            if sign * (-1) ** j > 0
        )

    def _open_kind(self, s: float, x: float, y: float) -> str:
        place = sp.Rational(float(required(self.polynomial).places(np.array([s]))[0]))
        try:
            return str(locate(at_place(self.solution, self.name, self.exactly(x, y), place), 15).course.kind)
        except NotConvergedError:
            return UNDECIDED

    def _one_by_one(self, found: Regions) -> Regions:
        """Return the same with the doubtful points decided by the exact search."""
        for i in map(int, np.flatnonzero(found.doubtful)):
            try:
                regions = regions_with_kinds(self.solution, self.name, self.exactly(found.x[i], found.y[i]), self.place)
                found.kinds[i] = tuple(region.kind for region in regions)
            except NotConvergedError:
                found.kinds[i] = (UNDECIDED,)
        return found


@dataclass(frozen=True)
class Regions:
    """The regions of one coordinate at m points.

    Attributes:
        coordinate: which.
        x, y: the points, shape (m,).
        sign: of P² at the lower end of the domain, shape (m,).
        count: of its zeros, shape (m,).
        doubtful: what was decided by the exact search, and has no zeros here, shape (m,).
        first: where the zeros of each point begin in ``low`` and ``high``, shape (m,).
        low, high: intervals of s round the zeros.
        kinds: the kinds of each point's regions in order of q, an array of tuples, shape (m,).
    """

    coordinate: CoordinateKinds
    x: Reals
    y: Reals
    sign: NDArray[np.int64]
    count: NDArray[np.int64]
    doubtful: NDArray[np.bool_]
    first: NDArray[np.int64]
    low: Reals
    high: Reals
    kinds: NDArray[np.object_]

    def clearest(self, points: NDArray[np.int64]) -> int:
        """Return the one of some points whose first and last zeros are farthest from the ends of the domain.

        Args:
            points: all with the same number of zeros.
        """
        if not self.count[points[0]]:
            return int(points[len(points) // 2])
        first, last = self.first[points], self.first[points] + self.count[points] - 1
        room = np.minimum(self.low[first], len(required(self.coordinate.polynomial).pieces) - self.high[last])
        return int(points[np.argmax(room)])

    def inside(self, i: int, j: int) -> float:
        """Return an s between the zeros j − 1 and j of a point.

        Args:
            i: the point.
            j: from 0, between the end of the domain and the first zero.
        """
        whole, first, count = len(required(self.coordinate.polynomial).pieces), int(self.first[i]), int(self.count[i])
        begin = float(self.high[first + j - 1]) if j else 0.0
        end = float(self.low[first + j]) if j < count else float(whole)
        if begin < end or 0 < j < count:  # where two intervals meet there is a place proved to be no zero
            return (begin + end) / 2
        beside = self._beside(i, first + j, 0.0) if j < count else self._beside(i, first + j - 1, float(whole))
        return (begin + beside) / 2

    def _beside(self, i: int, root: int, end: float) -> float:
        """Return a place between an end of the domain and a root whose interval reaches up to it."""
        polynomial = required(self.coordinate.polynomial)
        other = float(self.high[root] if end == self.low[root] else self.low[root])
        sign = int(self.sign[i]) * (1 if end == 0 else (-1) ** int(self.count[i]))
        for _ in range(200):
            other = (other + end) / 2
            point = self.x[i : i + 1], self.y[i : i + 1], np.array([other])
            value, error = (float(v[0]) for v in polynomial.value(*point))
            if sign * value > error:
                return other
        return other

    def well(self, i: int) -> float | None:
        """Return a place q in the first region of a point that lies between two turning points, or is a full turn.

        Args:
            i: the point; one that is not doubtful.
        """
        polynomial = required(self.coordinate.polynomial)
        count, sign = int(self.count[i]), int(self.sign[i])
        closed = polynomial.closed
        j = 1 if sign < 0 else 0 if closed else 2  # of an angle the first reaches across the opposite place
        if self.doubtful[i] or not (j < count or (closed and sign > 0)):
            return None
        return float(polynomial.places(np.array([self.inside(i, j)]))[0])

    def first_well(self) -> tuple[Reals, Reals]:
        """Return the turning points of the first bounded region of every point, to doubles; a turn where it rotates.

        Returns:
            Lower and upper, shape (m,); NaN where there is none, and at doubtful points.
        """
        polynomial = required(self.coordinate.polynomial)
        m, first = len(self.x), self.first
        lower, upper = np.full(m, np.nan), np.full(m, np.nan)
        inner = np.where(self.sign < 0, 0, 1)
        wraps = (self.sign > 0) & polynomial.closed
        good = np.flatnonzero(~self.doubtful & ~wraps & (inner + 1 < self.count))
        lower[good], upper[good] = (self._root(first[good] + inner[good] + k, good, inner[good] + k) for k in (0, 1))
        round_ = np.flatnonzero(~self.doubtful & wraps & (self.count > 0))
        last = self.count[round_] - 1
        lower[round_] = self._root(first[round_] + last, round_, last) - 2 * np.pi
        upper[round_] = self._root(first[round_], round_, 0 * last)
        turning = ~self.doubtful & wraps & (self.count == 0)
        lower[turning], upper[turning] = -np.pi, np.pi
        return lower, upper

    def _root(self, index: NDArray[np.int64], point: NDArray[np.int64], rank: NDArray[np.int64]) -> Reals:
        """Return roots as places, by halving their intervals."""
        polynomial = required(self.coordinate.polynomial)
        before, value = self.sign[point] * (-1.0) ** rank, polynomial.values(self.x[point], self.y[point])
        low, high = bisected(lambda x: value(x) * before > 0, self.low[index], self.high[index], 54)
        return polynomial.places((low + high) / 2)

    def kind_at(self, i: int, q: float) -> str:
        """Return the kind of the motion through a place; empty where there is none.

        Args:
            i: the point.
        """
        own, x, y = self.coordinate, float(self.x[i]), float(self.y[i])
        if self.doubtful[i] or own.polynomial is None:
            return self._kind_found_exactly(x, y, q)
        s = float(own.polynomial.shares(np.array([q]))[0])
        mine = slice(int(self.first[i]), int(self.first[i] + self.count[i]))
        low, high = self.low[mine], self.high[mine]
        j = int((high <= s).sum())
        if j < len(low) and low[j] < s:
            value, error = (float(v[0]) for v in own.polynomial.value(np.array([x]), np.array([y]), np.array([s])))
            if abs(value) <= error:
                return self._kind_found_exactly(x, y, q)
            j += value * self.sign[i] * (-1) ** j < 0
        if self.sign[i] * (-1) ** j < 0:
            return ""
        if own.polynomial.closed:
            return str(self.kinds[i][0])
        return str(self.kinds[i][j // 2])

    def _kind_found_exactly(self, x: float, y: float, q: float) -> str:
        own, place = self.coordinate, sp.Rational(float(q))
        for region in regions_with_kinds(own.solution, own.name, own.exactly(x, y), own.place):
            low = -np.inf if region.low is None else region.low
            high = np.inf if region.high is None else region.high
            room = _MARGIN * (1 + abs(float(place)))
            turns = (-1, 0, 1) if own.solution.system.coordinate(own.name).domain.kind == "angle" else (0,)
            if region.kind == "rotation" or any(low - room <= q + 2 * np.pi * k <= high + room for k in turns):
                return region.kind
        return ""


def _nothing(own: CoordinateKinds, x: Reals, y: Reals) -> Regions:
    m = len(x)
    zero, none = np.zeros(m, dtype=np.int64), np.zeros(0)
    return Regions(own, x, y, zero, zero, np.ones(m, dtype=bool), zero, none, none, np.empty(m, dtype=object))


def _fill(kinds: NDArray[np.object_], where: NDArray[np.int64], words: Kinds) -> None:
    for i in where:
        kinds[i] = words
