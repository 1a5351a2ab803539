"""Families of motions with one unknown: its value gives all constants of the motion, and where coordinates may move.

p² of a separated coordinate is F(q; κ). Where the others are held, F of a place is a polynomial of the second degree in
any one constant: of the first in E and in a separation constant (Stäckel), of the second in an ignorable momentum. Its
roots at many places are the values of the unknown at which motions appear, change and end; they are the grid.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.arithmetic.root_finding import stationary
from hjsolve.motion.tori.radicand_curve import RadicandCurve, place_of_maximum
from hjsolve.solution.quadratures import Solution

_GRID = 240
"""Values of the unknown that a family is looked at for, about."""
_BEYOND = 2.0 ** np.arange(-10, 31)
"""How far the grid goes on beyond its least and greatest value, over the distance of the two: rotations never end."""
_ASCENT = 40
"""Newton steps from the top of a neighbour's well to the maximum of p²."""
Number = Callable[[int], Mpf]
"""A number to as many bits as are asked."""


class OneParameterFamily(Protocol):
    """Motions with one unknown, as ``MotionFamily``."""

    @property
    def solution(self) -> Solution:
        """The solution that the family belongs to."""
        ...

    @property
    def unknown(self) -> str:
        """Name of what they differ in."""
        ...

    @property
    def parameters(self) -> Mapping[str, sp.Expr]:
        """Name → exact number, as motions are given them."""
        ...

    def constants(self, u: Mpf, bits: int) -> dict[str, Mpf]:
        """Return all constants of the motion.

        Args:
            u: value of the unknown.
        """
        ...

    def in_doubles(self, u: float) -> Reals:
        """Return the constants in their order, shape (k,).

        Args:
            u: value of the unknown.
        """
        ...

    def grid(self, curves: Sequence[RadicandCurve], /) -> Reals:
        """Return values of the unknown between which motions may change their kind, ascending.

        Args:
            curves: p² of the separated coordinates.
        """
        ...


@dataclass(frozen=True)
class MotionFamily:
    """Motions that differ in one constant.

    Attributes:
        solution: what is solved.
        held: name of a constant → its value, of all but the unknown.
        unknown: name of the one that is not.
        parameters: name → exact number, as motions are given them.
    """

    solution: Solution
    held: Mapping[str, Number]
    unknown: str
    parameters: Mapping[str, sp.Expr]

    def constants(self, u: Mpf, bits: int) -> dict[str, Mpf]:
        """Return all constants of the motion.

        Args:
            u: value of the unknown.
        """
        context = multiprecision(bits)
        known = {name: number(bits) for name, number in self.held.items()} | {self.unknown: context.convert(u)}
        return {name: known[name] for name in self.solution.constants}

    def in_doubles(self, u: float) -> Reals:
        """Return the constants in their order, shape (k,).

        Args:
            u: value of the unknown.
        """
        return np.array([float(x) for x in self.constants(multiprecision(64).mpf(float(u)), 64).values()])

    def grid(self, curves: Sequence[RadicandCurve]) -> Reals:
        """Return values of the unknown between which motions may change their kind, ascending.

        Args:
            curves: p² of the separated coordinates.
        """
        found = np.concatenate([branch for curve in curves for branch in critical_values(curve, self)])
        found = np.unique(found[np.isfinite(found)])
        if self._even(curves):
            found = found[found > 0]
        if not len(found):
            return found
        few = found[np.unique(np.linspace(0, len(found) - 1, _GRID).astype(int))]
        room = (few[-1] - few[0] or abs(float(few[0])) or 1.0) * _BEYOND
        low = few[:1] * 0 if self._even(curves) else few[0] - room[::-1]
        ends = np.concatenate([low, few, few[-1] + room])
        return np.unique(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))

    def _even(self, curves: Sequence[RadicandCurve]) -> bool:
        """Return whether the sign of the unknown decides only in which direction an ignorable coordinate turns."""
        if self.unknown not in {c.momentum.name for c in self.solution.system.coordinates}:
            return False
        scale = 1.7 * max(1.0, float(np.max(np.abs(self.in_doubles(0.0)))))
        pairs = ([c.value(c.samples(), self.in_doubles(u)) for u in (scale, -scale)] for c in curves)
        return all(np.array_equal(one, other, equal_nan=True) for one, other in pairs)


@dataclass(frozen=True)
class Well:
    """Where one coordinate moves, on samples.

    Attributes:
        low, high: the samples next to the ends of the motion; the turn of a rotation.
        top: the sample where p² is greatest.
        round: whether the coordinate goes round.
    """

    low: float
    high: float
    top: float
    round: bool

    def meets(self, other: Well, turn: float) -> bool:
        """Return whether another well is this one for neighbouring constants.

        Args:
            other: of the same coordinate.
            turn: period of p² along it; 0 where there is none.
        """
        if self.round or other.round:
            return self.round and other.round
        least = min(self.high - self.low, other.high - other.low) / 2
        # the ends are samples outside: those of two wells with a barrier between them may overlap by a sample or two
        for s in (-turn, 0.0, turn) if turn else (0.0,):
            inside = self.low < other.top + s < self.high or other.low < self.top - s < other.high
            if inside or min(self.high, other.high + s) - max(self.low, other.low + s) > least:
                return True
        return False


Wells = tuple[Well, ...]
"""One for each separated coordinate."""


def critical_values(curve: RadicandCurve, family: MotionFamily) -> list[Reals]:
    """Return the values of the unknown at which p² is zero at samples: F(u) = F₀ + F₁ u + F₂ u² at each of them.

    Args:
        family: with one unknown.

    Returns:
        The branches, each of the shape of the samples; NaN where there is none.
    """
    q = curve.samples()
    scale = max(1.0, float(np.max(np.abs(family.in_doubles(0.0)))))
    at = [curve.value(q, family.in_doubles(u)) for u in (-scale, 0.0, scale)]
    with np.errstate(all="ignore"):
        first, second = (at[2] - at[0]) / (2 * scale), (at[2] - 2 * at[1] + at[0]) / (2 * scale**2)
        linear = np.abs(second) * scale <= 1e-9 * np.abs(first)
        straight = np.where(linear, -at[1] / first, np.nan)
        half = -(first + np.copysign(np.sqrt(first**2 - 4 * second * at[1]), first)) / 2
        curved = np.where(linear, np.nan, np.sort(np.stack([half / second, at[1] / half]), axis=0))
    return [straight, *curved]


def place_in(curve: RadicandCurve, κ: Reals, well: Well) -> float:
    """Return a place at which p² > 0 in a well of neighbouring constants: its top, or the maximum next to it.

    Args:
        κ: constants, shape (k,).
        well: of the neighbour.
    """
    q = well.top
    for _ in range(_ASCENT):
        value, slope, bend = curve.bend(q, κ)
        if value > 0:
            return q
        if not bend < 0 or not well.low < q - slope / bend < well.high:
            break
        q -= slope / bend
    return place_of_maximum(curve, κ, well.low, well.high)


def wells_of(curves: Sequence[RadicandCurve], κ: Reals) -> list[Wells]:
    """Return all combinations of wells in which the coordinates may move.

    Args:
        curves: p² of the separated coordinates.
        κ: constants, shape (k,).
    """
    return list(product(*(_wells(curve, κ) for curve in curves)))


def _wells(curve: RadicandCurve, κ: Reals) -> list[Well]:
    q, squared = with_extrema(curve, κ)
    positive = squared > 0
    if curve.turn and positive.all():
        best = float(q[int(np.argmax(squared))])
        return [Well(best, best + curve.turn, best, round=True)]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], positive, [False]]).astype(int)))
    found = []
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        open_ends = (first == 0 and not curve.walls[0]) or (after == len(q) and not curve.walls[1])
        top = float(q[first + int(np.argmax(squared[first:after]))])
        if open_ends or (curve.turn and not -curve.turn / 2 <= top < curve.turn / 2):
            continue
        low, high = float(q[max(first - 1, 0)]), float(q[min(after, len(q) - 1)])
        found.append(Well(low, high, top, round=False))
    return found


def with_extrema(curve: RadicandCurve, κ: Reals) -> tuple[Reals, Reals]:
    """Return samples and p² there, with the extrema between samples at which p² has another sign than next to them.

    A barrier or a well that is narrower than the samples are apart is seen by them.

    Args:
        κ: constants, shape (k,).
    """
    q = curve.samples()
    squared = curve.value(q, κ)
    with np.errstate(invalid="ignore"):
        inner, left, right = squared[1:-1], squared[:-2], squared[2:]
        # between samples a parabola goes beyond the middle one by an eighth of the greater difference at most
        reach = np.maximum(np.abs(left - inner), np.abs(right - inner)) / 2
        low = (inner > 0) & (inner <= left) & (inner <= right) & (inner < reach)
        high = (inner < 0) & (inner >= left) & (inner >= right) & (-inner < reach)
    places, values = [], []
    for k in np.flatnonzero(low | high) + 1:
        found = _extremum(curve, κ, float(q[k]), (float(q[k - 1]), float(q[k + 1])))
        if found is not None and found[1] * squared[k] < 0:
            places.append(found[0])
            values.append(found[1])
    if not places:
        return q, squared
    order = np.argsort(np.concatenate([q, places]), kind="stable")
    return np.concatenate([q, places])[order], np.concatenate([squared, values])[order]


def _extremum(curve: RadicandCurve, κ: Reals, q: float, bounds: tuple[float, float]) -> tuple[float, float] | None:
    """Return the place next to q where p² is stationary, and p² there; None where Newton's method leaves the bounds."""
    place = stationary(
        lambda q: curve.bend(q, κ), q, lambda _, q: bounds[0] <= q <= bounds[1], lambda q: 4 * EPS * abs(q), _ASCENT
    )
    return None if place is None else (place, curve.bend(place, κ)[0])
