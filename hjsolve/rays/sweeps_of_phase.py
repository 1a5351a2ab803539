"""One coordinate of a family: its phase, what the phase adds to W, and where the coordinate is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.root_finding import bracketed_roots
from hjsolve.display.shown import Shown
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion

_CELLS = 1024
_WIDENINGS = 70


@dataclass(frozen=True, repr=False)
class IgnorableSweep(Shown):
    """An ignorable coordinate: its phase is the coordinate itself, or minus it; W grows by |c| per unit.

    Attributes:
        name: of the coordinate.
        low, high: phases of the family.
        momentum: c.
        start: the coordinate at t₀.
        angle: whether it goes round.
        turning: phases at which the momentum vanishes: none.
    """

    name: str
    low: float
    high: float
    momentum: float
    start: float
    angle: bool

    turning: tuple[float, ...] = ()

    @property
    def turn(self) -> float:
        """W of a whole turn."""
        return 2 * np.pi * abs(self.momentum) if self.angle else 0.0

    @property
    def _sense(self) -> float:
        return -1.0 if self.momentum < 0 else 1.0

    def gained(self, χ: Reals) -> tuple[Reals, Reals, Reals]:
        """Return |c| (χ − χ₀), |c| and its rounding.

        Args:
            χ: phases, shape (m,).
        """
        c, begin = abs(self.momentum), self._sense * self.start
        return c * (χ - begin), c + 0 * χ, 4 * EPS * c * (np.abs(χ) + abs(begin))

    def place(self, χ: Reals) -> tuple[Reals, Reals, Reals, Reals]:
        """Return ±χ, c and their rounding.

        Args:
            χ: phases, shape (m,).
        """
        return self._sense * χ, self.momentum + 0 * χ, EPS * np.abs(χ), EPS * abs(self.momentum) + 0 * χ

    def phase_of(self, amount: Reals) -> Reals:
        """Return χ₀ + amount/|c|; NaN outside the family, and where c = 0.

        Args:
            amount: shape (m,).
        """
        if self.momentum == 0:
            return np.full_like(amount, np.nan)
        χ = self._sense * self.start + amount / abs(self.momentum)
        return χ if self.angle else np.where((χ >= self.low) & (χ <= self.high), χ, np.nan)


@dataclass(frozen=True, repr=False, eq=False)
class SeparatedSweep(Shown):
    """A separated coordinate: its phase is that of its course (``one_coordinate``).

    Attributes:
        name: of the coordinate.
        low, high: phases of the family.
        course: reaching over all of them.
        turning: phases in [low, high] at which the momentum vanishes.
        table: phases all along, and W there from phase 0.
        begin: W of the start from phase 0.
    """

    name: str
    low: float
    high: float
    course: CoordinateMotion = field(repr=False)
    turning: tuple[float, ...]
    table: tuple[Reals, Reals] = field(repr=False)
    begin: float

    @property
    def turn(self) -> float:
        """W of a whole turn of a rotation."""
        return 2 * np.pi * float(self.course.cycle.action or 0) if self.course.rotates and self.course.cycle else 0.0

    def gained(self, χ: Reals) -> tuple[Reals, Reals, Reals]:
        """Return ∫ P dq from the start, its slope, and its rounding."""
        value, slope, size = (cast("Reals", x) for x in self.course.momentum_integral(χ))
        return value - self.begin, slope, 8 * EPS * (size + np.abs(value) + abs(self.begin))

    def place(self, χ: Reals) -> tuple[Reals, Reals, Reals, Reals]:
        """Return q, P and their rounding."""
        q, p = (cast("Reals", x) for x in self.course.place(χ))
        noise = 16 + np.asarray(self.course.momentum_noise(χ))
        rounding = np.asarray(self.course.phase_rounding(χ)) + 4 * EPS * np.abs(χ)
        beside, steeper = (cast("Reals", x) for x in self.course.place(χ + rounding))
        return q, p, 8 * EPS * np.abs(q) + 2 * np.abs(beside - q), noise * EPS * np.abs(p) + 2 * np.abs(steeper - p)

    def phase_of(self, amount: Reals) -> Reals:
        """Return the phase by Newton's steps between brackets from a table."""
        table, sums = self.table[0], self.table[1] - self.begin
        first = sums[0]
        turns = np.floor((amount - first) / self.turn) if self.turn else np.zeros_like(amount)
        goal = amount - turns * self.turn
        inside = (goal >= first) & (goal <= sums[-1])
        left = goal[inside]
        cell = np.clip(np.searchsorted(sums, left, side="right") - 1, 0, _CELLS - 1)
        low, high = table[cell], table[cell + 1]

        def off(χ: Reals) -> tuple[Reals, Reals]:
            value, slope, _ = self.gained(χ)
            return value - left, slope

        found = np.full_like(goal, np.nan)
        found[inside] = bracketed_roots(off, (low + high) / 2, low, high)[0]
        return found + 2 * np.pi * turns


PhaseSweep = IgnorableSweep | SeparatedSweep
"""A coordinate as a function of its phase; W grows with every phase."""


def separated_sweep(
    name: str, low: float, high: float, course: CoordinateMotion, turning: tuple[float, ...]
) -> SeparatedSweep:
    """Make a coordinate ready.

    Args:
        name, low, high, turning: see ``SeparatedSweep``.
    """
    table = np.linspace(low, high, _CELLS + 1)
    sums = np.maximum.accumulate(cast("Reals", course.momentum_integral(table)[0]))
    begin = float(course.momentum_integral(np.array([float(course.start)]))[0][0])
    return SeparatedSweep(name, low, high, course, turning, (table, sums), begin)


def phase_slack(sweep: PhaseSweep, χ: Reals, doubt: Reals) -> Reals:
    """Return how far a phase may be from the one at which W has the value wanted, from how W changes next to it.

    Args:
        χ: phases found, shape (m,).
        doubt: how far W there may be from the value wanted.
    """
    here = sweep.gained(χ)[0]
    slack = 4 * EPS * (1 + np.abs(χ))
    left = np.flatnonzero(np.isfinite(χ))
    for _ in range(_WIDENINGS):
        if not left.size:
            break
        ahead, _, noise = sweep.gained(χ[left] + slack[left])
        behind, _, more = sweep.gained(χ[left] - slack[left])
        needed = doubt[left] + noise + more
        enough = (ahead - here[left] >= needed) & (here[left] - behind >= needed)
        left = left[~enough]
        slack[left] *= 2
    return slack


def doubt_of_place(sweep: PhaseSweep, χ: Reals, slack: Reals) -> tuple[Reals, Reals]:
    """Return how far q and p may be from their values where the phase is only known so well.

    Args:
        χ: phases, shape (m,).
        slack: how far each may be off, shape (m,).
    """
    q, p, rough, coarse = sweep.place(χ)
    beyond = [sweep.place(χ + side * slack) for side in (-1.0, -0.5, 0.5, 1.0)]
    reach = np.max([np.abs(x[0] - q) for x in beyond], axis=0)
    swing = np.max([np.abs(x[1] - p) for x in beyond], axis=0)
    return 2 * reach + rough, 2 * swing + coarse
