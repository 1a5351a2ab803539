"""The front of the batch engine: which columns, in which chunks, by which pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers
from hjsolve.ensembles.engine.columns import QUANTITIES, Columns, blank, put
from hjsolve.ensembles.engine.lowered_solution import Model, lowered_model, next_to_poles
from hjsolve.ensembles.engine.passes import TIMED, TOLERANCE, run_escapes, run_pass
from hjsolve.ensembles.engine.programs import system_programs
from hjsolve.ensembles.engine.starts import MomentumRule, Starts, from_velocities, given_momenta
from hjsolve.ensembles.engine.status import ENDLESS, UNDECIDED, Status
from hjsolve.ensembles.engine.units_of_orbits import columns_in_old_units, groups, model_in_units, starts_in_units
from hjsolve.errors import InvalidInputError
from hjsolve.motion.initial_data import parameter_values
from hjsolve.solution.quadratures import Solution

CHUNK = 16384
"""Orbits worked on together."""

FAST = 4e-12
"""Largest claimed relative error with which the first pass lets an orbit go; the true one is fifty times less."""


@dataclass(frozen=True)
class Engine:
    """A system made ready for many orbits; made by ``build``.

    Attributes:
        solution: of the system.
        want: which of ``QUANTITIES`` are computed; nothing else is integrated.
        model: the solution as straight-line programs.
        names: quantity → names of its columns.
        values: every parameter → exact number.
    """

    solution: Solution
    want: frozenset[str]
    model: Model
    names: Mapping[str, tuple[str, ...]]
    values: Mapping[sp.Symbol, sp.Expr]

    def run(self, q: Mapping[str, Any], p: Mapping[str, Any]) -> Columns:
        """Compute what is wanted for many orbits, from places and momenta.

        Args:
            q, p: every coordinate → positions and canonical momenta, float64 arrays of shape (n,).

        Returns:
            Columns of shape (n,).
        """
        return self.run_starts(given_momenta(self._rows(q), self._rows(p)))

    def run_velocities(self, q: Mapping[str, Any], velocity: Mapping[str, Any], rule: MomentumRule) -> Columns:
        """Compute what is wanted for many orbits, from places and velocities; the rounding of momenta is counted.

        Args:
            q, velocity: every coordinate → positions and velocities, float64 arrays of shape (n,).
            rule: the momenta.

        Returns:
            Columns of shape (n,).
        """
        return self.run_starts(from_velocities(rule, self._rows(q), self._rows(velocity)))

    def _rows(self, given: Mapping[str, Any]) -> Any:
        return np.stack([np.asarray(given[name], dtype=float) for name in self.model.names])

    def run_starts(self, starts: Starts) -> Columns:
        """Compute what is wanted.

        A first pass knows p² in doubles, and small motions by slopes; where only its claims are too large, a second one
        knows p² to 32 digits. What is then not decided is seen by a p² that keeps its digits next to poles that cancel,
        and in units of its own. That orbits without an end run away is proved last.

        Args:
            starts: of n orbits.

        Returns:
            Columns of shape (n,); the status is ``UNBOUNDED`` where that is proved, ``ENDLESS`` where it is not.
        """
        count = starts.q.shape[1]
        # every column begins as NaN: what no pass decides stays so
        columns = blank(self.names, count)
        if not self.model.separated:
            return columns
        everything = np.arange(count)
        self._run_passes(columns, starts, everything, self.model)
        # the rest costs another p², more digits or other units: it is done for the orbits that need it
        left = everything[columns.unresolved | (columns.status == UNDECIDED)]
        # log(1 + r)/r is 0/0 at r = 0: a form of p² that keeps its digits there has other branch points
        near = next_to_poles(self.solution) if len(left) else None
        if near is not None:
            some = blank(self.names, len(left))
            self._run_passes(some, starts.take(left), np.arange(len(left)), lowered_model(near, self.values))
            solved = some.status == Status.OK
            put(columns, left[solved], some.take(solved))
        # orbits at extreme scales, or deep in a core, in units in which their numbers are of order one
        self._run_in_their_own_units(columns, starts)
        programs = system_programs(self.model, kernels=bool(TIMED & self.want))
        for index in _chunks(everything[columns.status == ENDLESS]):
            part = run_escapes(self.model, programs, dict(self.names), starts.take(index))
            proved = part.status == Status.UNBOUNDED
            put(columns, index[proved], part.take(proved))
        return columns

    def _run_in_their_own_units(self, columns: Columns, starts: Starts) -> None:
        """Fill columns of orbits that are undecided, and whose numbers are far from 1."""
        left = np.flatnonzero(columns.unresolved | (columns.status >= UNDECIDED))
        for units, orbits in groups(self.model, starts, left):
            made = model_in_units(self.model, units)
            some = blank(self.names, len(orbits))
            self._run_passes(some, starts_in_units(starts.take(orbits), units), np.arange(len(orbits)), made.model)
            some = columns_in_old_units(some, made, units)
            solved = some.status == Status.OK
            put(columns, orbits[solved], some.take(solved))

    def _run_passes(self, columns: Columns, starts: Starts, orbits: Integers, model: Model) -> None:
        """Fill columns by the two passes."""
        programs = system_programs(model, kernels=bool(TIMED & self.want))
        # doubles first, with a claim well below the tolerance; pairs of doubles for those whose claims were too large
        for tolerance, exact in ((FAST, False), (TOLERANCE, True)):
            for index in _chunks(orbits[columns.unresolved] if exact else orbits):
                part = run_pass(model, programs, dict(self.names), starts.take(index), tolerance=tolerance, exact=exact)
                put(columns, index, part)


def _chunks(orbits: Integers) -> list[Integers]:
    return [orbits[first : first + CHUNK] for first in range(0, len(orbits), CHUNK)]


def build(solution: Solution, want: frozenset[str], parameters: Mapping[str, Any] | None = None) -> Engine:
    """Make a system ready for many orbits.

    Args:
        want: quantities, of ``QUANTITIES``.
        parameters: name → value, where it differs from the default; the same for all orbits.

    Raises:
        InvalidInputError: a quantity that is not known.
        MissingValueError: a parameter without a value.
    """
    for name in sorted(want - set(QUANTITIES)):
        raise InvalidInputError(f'want: "{name}" is not known for many orbits; known are {", ".join(QUANTITIES)}')
    values = parameter_values(solution.system, parameters or {})
    return Engine(solution, want, lowered_model(solution, values), _names(solution, want), values)


def _names(solution: Solution, want: frozenset[str]) -> dict[str, tuple[str, ...]]:
    """Return columns of every quantity: coordinates that are separated or ignorable angles have actions and angles."""
    periodic = tuple(
        c.name for c in solution.system.coordinates if c.name in solution.coordinates or c.domain.kind == "angle"
    )
    ends = tuple(f"{name}.{side}" for name in solution.coordinates for side in ("lower", "upper"))
    names = dict.fromkeys(QUANTITIES, periodic) | {"constants": tuple(solution.constants), "turning_points": ends}
    return {quantity: names[quantity] for quantity in QUANTITIES if quantity in want}
