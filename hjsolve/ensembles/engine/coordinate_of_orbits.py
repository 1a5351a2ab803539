"""One separated coordinate of many orbits: its programs, and where they start.

A place is an offset x in a view of p², q = origin ± x, with the origin in two doubles: x next to an end of the domain
has digits of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hjsolve.arithmetic.error_free import Pair, two_sum
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.constants import InitialConstants
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.programs import CoordinatePrograms, SystemPrograms, sides


@dataclass(frozen=True)
class CoordinateOfOrbits:
    """One coordinate of n orbits.

    Attributes:
        coordinate: which.
        programs: its own.
        parameters: of the programs.
        q, P: starts, shape (n,).
        constants, low, uncertainty: of the motion, in two doubles, shape (constants, n).
        rest: what the rounding of q leaves of the starts, shape (n,); None where q is exact.
    """

    coordinate: Separated
    programs: CoordinatePrograms
    parameters: tuple[float, ...]
    q: Reals
    P: Reals
    constants: Reals
    low: Reals
    uncertainty: Reals
    rest: Reals | None = None

    @staticmethod
    def of(model: Model, programs: SystemPrograms, start: InitialConstants, k: int) -> CoordinateOfOrbits:
        """Return the k-th separated one.

        Args:
            k: row.
        """
        q, P = (np.ascontiguousarray(x[k]) for x in (start.q, start.P))
        known = programs.coordinates[k], programs.parameters
        return CoordinateOfOrbits(model.separated[k], *known, q, P, start.values, start.low, start.uncertainty)

    def take(self, index: Integers) -> CoordinateOfOrbits:
        """Return some of the orbits."""
        # all of them, in order: nothing need be copied
        if len(index) == len(self.q) and bool((index == np.arange(len(index))).all()):
            return self
        constants, low, uncertainty = (np.take(x, index, axis=1) for x in (self.constants, self.low, self.uncertainty))
        q, P, rest = self.q[index], self.P[index], None if self.rest is None else self.rest[index]
        return replace(self, q=q, P=P, constants=constants, low=low, uncertainty=uncertainty, rest=rest)


def squares(one: CoordinateOfOrbits, q: Reals) -> Reals:
    """Return p² at places, from 32 digits.

    Args:
        one: the coordinate of n orbits.
        q: places, shape (n,).
    """
    x = offset_in_pairs(sides(one.coordinate)[0], q)
    with np.errstate(all="ignore"):
        return run_rows(one.programs.exact[0].squares, one.parameters, np.stack([*x, *one.constants, *one.low]))[0]


def offset_in_pairs(formula: LoweredFormula, q: Reals, rest: Reals | float = 0.0) -> Pair:
    """Return x of a position in two doubles.

    Args:
        formula: with its origin.
        q: positions, shape (n,).
        rest: what their rounding leaves.
    """
    s, e = two_sum(q, -formula.origin.high)
    return Pair(formula.sign * s, formula.sign * (e - formula.origin.low + rest))


def offset(formula: LoweredFormula, q: Reals) -> Reals:
    """Return x of a position: (q − origin)·sign with one rounding.

    Args:
        formula: with its origin.
        q: positions, shape (n,).
    """
    # q − origin with the part that rounding cuts off, and the low part of the origin: one rounding in all
    s, e = two_sum(q, -formula.origin.high)
    return formula.sign * (s + (e - formula.origin.low))


def place(formula: LoweredFormula, x: Reals) -> Reals:
    """Return the position at an offset.

    Args:
        formula: with its origin.
        x: offsets, shape (n,).
    """
    # the low part of the origin first: it is as small as what x may be next to an end
    found: Reals = formula.origin.high + (formula.origin.low + formula.sign * x)
    return found
