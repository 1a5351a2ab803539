"""V and its derivatives over cells of r, from the centre outwards: what the enclosures of radial arcs are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, Float64, multiprecision
from hjsolve.arithmetic.interval import Interval, Intervals, over_shape
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.sign_at_infinity import sign_before, sign_beyond
from hjsolve.lowering import lower

FIELD = Intervals(Float64())
_INNERMOST = 2.0**-20
"""Where the cells begin, in units of the lesser distance; within, bounds hold that are made of proved signs."""
_MARGIN = 2.0**-10
"""How far a bound on an exponent is from the exponent itself, in units of it."""
OUT = 1e-13
"""Rounding of a sum of some thousand terms, in units of the sum of their sizes."""


def root_of_positive(x: Interval) -> Interval:
    """Enclose the roots of what is not negative of an interval.

    Args:
        x: a range; what of it is negative counts as 0.
    """
    root = FIELD.unary("sqrt", Interval(np.maximum(x.low, 0), np.maximum(x.high, 0)))
    return Interval(np.maximum(root.low, 0), root.high)


def summed(x: Interval) -> Interval:
    """Enclose sums over cells; a sum that is not bounded has infinite ends.

    Args:
        x: the terms, shape (b, cells).
    """
    with np.errstate(all="ignore"):
        ends = [np.sum(end, axis=1) for end in x]
        sizes = [OUT * np.sum(np.abs(end), axis=1) for end in x]
        low, high = ends[0] - sizes[0], ends[1] + sizes[1]
    return Interval(np.where(np.isfinite(low), low, -np.inf), np.where(np.isfinite(high), high, np.inf))


class Profile(NamedTuple):
    """V, r V′ and r² V″."""

    V: Interval
    first: Interval
    second: Interval


@dataclass(frozen=True)
class CentralCell:
    """What is known of 0 < r ≤ the innermost node.

    Attributes:
        steepness: enclosure of r V′/(−V) where V is attracting without a bound, else of r V′.
        singular: whether it is the first of these.
        highest: bound on V from above.
    """

    steepness: tuple[float, float]
    singular: bool
    highest: float

    def ratio(self, E: Interval) -> Interval:
        """Enclose q = r V′/(2(E − V)); the whole line where E − V may be zero.

        Args:
            E: energies.
        """
        least = np.asarray(E.low - self.highest)
        low, high = self.steepness
        with np.errstate(all="ignore"):
            if not self.singular:
                return _where(least > 0, Interval(np.minimum(low / 2 / least, 0), np.maximum(high / 2 / least, 0)))
            # q = (a/2)·|V|/(E + |V|) with |V| from |V(ε)| to ∞
            size = -self.highest
            ends = [size / (size + e) for e in (np.asarray(E.low), np.asarray(E.high))]
            most, fewest = np.maximum(np.maximum(*ends), 1.0), np.minimum(np.minimum(*ends), 1.0)
            return _where(least > 0, Interval(low / 2 * fewest * (1 - 8 * EPS), high / 2 * most * (1 + 8 * EPS)))

    def slowest(self, E: Interval) -> Reals:
        """Return a lower bound on E − V.

        Args:
            E: energies.
        """
        return np.asarray(E.low - self.highest) * (1 - 4 * EPS)


def _where(known: np.ndarray, x: Interval) -> Interval:
    return Interval(np.where(known, x.low, -np.inf), np.where(known, x.high, np.inf))


class RadialPotential:
    """V(r) with numbers for its parameters.

    Attributes:
        r: the symbol.
        V: the formula.
    """

    def __init__(self, r: sp.Symbol, V: sp.Expr):
        self.r, self.V = r, V
        self.formulas = [V, sp.simplify(r * sp.diff(V, r)), sp.simplify(r**2 * sp.diff(V, r, 2))]
        self._tape = lower(self.formulas, [r])

    def over(self, low: Reals, high: Reals) -> Profile:
        """Enclose V, r V′ and r² V″ over cells.

        Args:
            low, high: their ends, shape (m,).
        """
        rows = self._tape.run(FIELD, [Interval(low, high)])
        return Profile(*(over_shape(row, low.shape) for row in rows))

    def at_centre(self, distance: float) -> CentralCell | None:
        """Bound V and r V′ between the centre and a distance; None where V is neither regular nor like −1/rᵃ, a < 2.

        Args:
            distance: of the innermost node.
        """
        here = self.over(np.array([distance]), np.array([distance]))
        first = sp.limit(self.formulas[1], self.r, 0, "+")
        V = sp.limit(self.V, self.r, 0, "+")
        highest = float(here.V.high[0])
        if first.is_finite and first.is_number and (V.is_finite or first.is_positive):
            bound = self._bounded(float(first), here, distance)
            if bound is None or (V.is_finite and not V.is_number):
                return None
            if V.is_finite:
                drop = max(abs(bound[0]), abs(bound[1]))
                rise = self._bounded_potential(float(V), highest, drop, distance)
                return None if rise is None else CentralCell(bound, singular=False, highest=rise)
            rising = self._sign(self.formulas[1], distance) > 0
            return CentralCell(bound, singular=False, highest=highest) if rising else None
        if not (V.is_infinite and V.is_extended_negative) or highest >= 0:
            return None
        exponent = sp.limit(-self.formulas[1] / self.V, self.r, 0, "+")
        if not (exponent.is_number and exponent.is_finite):
            return None
        size = Interval(-here.V.high, -here.V.low)
        ends = [float(exponent), float(here.first.low[0] / size.high[0]), float(here.first.high[0] / size.low[0])]
        low, high = sp.Rational(min(ends) * (1 - _MARGIN)), sp.Rational(max(ends) * (1 + _MARGIN))
        signs = (
            self._sign(self.formulas[1] + low * self.V, distance) > 0,
            self._sign(self.formulas[1] + high * self.V, distance) < 0,
            self._sign(self.formulas[1], distance) > 0,
        )
        return CentralCell((float(low), float(high)), singular=True, highest=highest) if all(signs) else None

    def _bounded(self, limit: float, here: Profile, distance: float) -> tuple[float, float] | None:
        """Bounds on r V′ up to a distance, a little wider than its limit and its value there."""
        spread = 4 * (abs(float(here.first.low[0]) - limit) + abs(float(here.first.high[0]) - limit)) + 1e-12
        low, high = sp.Rational(limit - spread), sp.Rational(limit + spread)
        inside = self._sign(self.formulas[1] - low, distance) > 0 and self._sign(self.formulas[1] - high, distance) < 0
        return (float(low), float(high)) if inside else None

    def _bounded_potential(self, limit: float, here: float, drop: float, distance: float) -> float | None:
        bound = max(limit, here) + drop + 1e-12 * (1 + abs(limit))
        return bound if self._sign(self.V - sp.Rational(bound), distance) < 0 else None

    def _sign(self, formula: sp.Expr, distance: float) -> int:
        """Return the sign of a formula for 0 < r ≤ distance; 0 where it is not known."""
        if formula == 0:
            return 0
        context = multiprecision(256)
        tape = lower([sp.expand(formula)], [self.r])
        return sign_before(tape, [], context.mpf(0), -1, context.mpf(distance))

    def is_above(self, E: float, distance: float) -> bool:
        """Whether V exceeds an energy between the centre and a distance, proved.

        Args:
            E: the energy.
            distance: from the centre.
        """
        return self._sign(self.V - sp.Rational(E), distance) > 0

    def virial_is_negative(self, distance: float) -> bool:
        """Whether 2V + r V′ < 0 between the centre and a distance, proved.

        Args:
            distance: from the centre.
        """
        return self._sign(2 * self.V + self.formulas[1], distance) < 0

    def never_turned_beyond(self, distance: float, E: float) -> bool:
        """Whether r²(E − V) rises with r from a distance on, for this energy and all above it: nothing turns there.

        Args:
            distance: where.
            E: the energy.
        """
        slope = sp.expand(2 * (sp.Rational(E) - self.V) - self.formulas[1])
        start = max(distance, 4.0)
        nodes = np.linspace(distance, start, 2000)
        cells = self.over(nodes[:-1], nodes[1:])
        near = np.all(2 * (E - cells.V.high) - cells.first.high > 0) if start > distance else True
        return bool(near) and sign_beyond(lower([slope], [self.r]), [], 1, start) > 0


@dataclass(frozen=True)
class RadialGrid:
    """Cells from the centre to far outside; the first one begins at r = 0.

    Attributes:
        r: nodes, shape (N + 1,); r[0] = 0.
        middles: of the cells, shape (N,).
        inner, outer: index of the lesser and of the greater distance.
        at_nodes, at_middles, over_cells: V and its derivatives.
        half: half the width of ln r of a cell.
        centre: bounds for the first cell; None where there are none.
    """

    r: Reals
    middles: Reals
    inner: int
    outer: int
    at_nodes: Profile
    at_middles: Profile
    over_cells: Profile
    half: Reals
    centre: CentralCell | None


def cells_about(
    potential: RadialPotential, distances: tuple[float, float], far: float, ratio: float, centre: CentralCell | None
) -> RadialGrid:
    """Lay cells of about one ratio.

    Args:
        potential: V.
        distances: the lesser and the greater one; the same where they are equal.
        far: how far they go.
        ratio: of the ends of a cell.
        centre: of the innermost cell, to ``innermost`` of the lesser distance.
    """
    low, high = distances
    parts = [_geometric(innermost(low), low, ratio), _geometric(low, high, ratio)[1:], _geometric(high, far, ratio)[1:]]
    inside = np.concatenate(parts)
    inner, outer = len(parts[0]), len(parts[0]) + len(parts[1])
    r = np.concatenate([[0.0], inside])
    middles = np.sqrt(inside[:-1] * inside[1:])
    half = np.log(inside[1:] / inside[:-1]) / 2 * (1 + 1e-12) + 4 * EPS
    return RadialGrid(
        r, np.concatenate([[inside[0]], middles]), inner, outer,
        _led(potential.over(inside, inside)), _led(potential.over(middles, middles)),
        _led(potential.over(inside[:-1], inside[1:])), np.concatenate([[0.0], half]), centre,
    )  # fmt: skip


def innermost(distance: float) -> float:
    """Return where the cells begin.

    Args:
        distance: the lesser one.
    """
    return distance * _INNERMOST


def _led(profile: Profile) -> Profile:
    """Put a first column that says nothing before a profile: that of the centre, or of the cell next to it."""
    return Profile(*(Interval(np.concatenate([[-np.inf], x.low]), np.concatenate([[np.inf], x.high])) for x in profile))


def _geometric(low: float, high: float, ratio: float) -> Reals:
    if high <= low:
        return np.array([low])
    nodes = np.geomspace(low, high, max(2, int(np.ceil(np.log(high / low) / np.log(ratio))) + 1))
    nodes[0], nodes[-1] = low, high
    return nodes
