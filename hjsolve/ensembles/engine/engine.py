"""The front of the batch engine: which columns, in which chunks, by which pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hjsolve.arithmetic.machine.compiling import available
from hjsolve.arithmetic.number_types import Integers
from hjsolve.ensembles.engine.columns import QUANTITIES, Columns, blank, put
from hjsolve.ensembles.engine.lowered_solution import Model, lowered_model
from hjsolve.ensembles.engine.passes import TIMED, TOLERANCE, run_compiled, run_escapes, run_pass, worst
from hjsolve.ensembles.engine.programs import SystemPrograms, system_programs
from hjsolve.ensembles.engine.regions import hopeless_in_doubles
from hjsolve.ensembles.engine.starts import MomentumRule, Starts, from_velocities, given_momenta
from hjsolve.ensembles.engine.status import ENDLESS, Status
from hjsolve.errors import InvalidInputError
from hjsolve.motion.initial_data import parameter_values
from hjsolve.solution.quadratures import Solution

CHUNK = 16384
"""Orbits worked on together: enough for numpy to spend its time in loops; ``midpoint_rule`` bounds temporaries."""

FAST = 1e-11
"""Largest claimed relative error with which the compiled pass lets an orbit go; the true one is fifty times less."""

GOOD = 3e-12
"""The same where p² is taken as written, in numpy's first pass and in the second one: true errors stay below 1e-13."""


@dataclass(frozen=True)
class Engine:
    """A system made ready for many orbits; made by ``build``.

    Attributes:
        solution: of the system.
        want: which of ``QUANTITIES`` are computed; nothing else is integrated.
        model: the solution as straight-line programs.
        names: quantity → names of its columns.
        compiled: True where the first pass runs as compiled loops (numba is there).
    """

    solution: Solution
    want: frozenset[str]
    model: Model
    names: Mapping[str, tuple[str, ...]]
    compiled: bool

    def run(self, q: Mapping[str, Any], p: Mapping[str, Any]) -> Columns:
        """Compute what is wanted for many orbits, from places and momenta.

        Args:
            q, p: every coordinate → positions and canonical momenta, float64 arrays of shape (n,).

        Returns:
            Columns of shape (n,).
        """
        return self.run_starts(given_momenta(self._rows(q), self._rows(p)), escapes=True)

    def run_velocities(self, q: Mapping[str, Any], velocity: Mapping[str, Any], rule: MomentumRule) -> Columns:
        """Compute what is wanted for many orbits, from places and velocities; the rounding of momenta is counted.

        Args:
            q, velocity: every coordinate → positions and velocities, float64 arrays of shape (n,).
            rule: the momenta.

        Returns:
            Columns of shape (n,).
        """
        return self.run_starts(from_velocities(rule, self._rows(q), self._rows(velocity)), escapes=True)

    def _rows(self, given: Mapping[str, Any]) -> Any:
        return np.stack([np.asarray(given[name], dtype=float) for name in self.model.names])

    def run_starts(self, starts: Starts, *, escapes: bool = False) -> Columns:
        """Compute what is wanted.

        A first pass works in doubles: by numpy with plain anomalies; as compiled loops with stretched ones, 32-digit
        constants and slopes for small amplitudes. Orbits that it leaves go through a second one by numpy, with all of
        these, and if errors come out too large (a separatrix) through a third one with 32-digit radicands, if it is
        doubles that do not know them. Where compiled loops fail by their claims alone these come at once, compiled
        too.

        Args:
            starts: of n orbits.
            escapes: whether to prove that orbits run away, from places that are exact.

        Returns:
            Columns of shape (n,); the status is ``UNBOUNDED`` where that is proved, ``ENDLESS`` where it is not.
        """
        count = starts.q.shape[1]
        columns = blank(self.names, count)
        if not self.model.separated:
            return columns
        everything = np.arange(count)
        if self.compiled:
            made = system_programs(self.model, kernels=bool(TIMED & self.want))
            self._deeper(columns, everything, starts, -2, made)
            self._deeper(columns, everything[columns.vague], starts, -1, made)
            self._deeper(columns, everything[columns.vague], starts, 3)
        if not self.compiled or any(c.periodic for c in self.model.separated):
            left = everything[columns.status != Status.OK]
            lost = hopeless_in_doubles(self.model, starts.take(left), kernels=bool(TIMED & self.want))
            self._deeper(columns, left[~lost], starts, 0)
        hard = columns.status != Status.OK
        self._deeper(columns, everything[hard], starts, 1)
        proved = everything[:0]
        if escapes:
            proved = self._escapes(columns, everything[columns.status == Status.UNBOUNDED], starts)
            hard[proved] = False
        rough = (columns.status != Status.OK) | (columns.vague & (worst(columns) > GOOD))
        self._deeper(columns, everything[hard & rough], starts, 2)
        columns.status[columns.status == Status.UNBOUNDED] = ENDLESS
        columns.status[proved] = Status.UNBOUNDED
        return columns

    def _escapes(self, columns: Columns, orbits: Integers, starts: Starts) -> Integers:
        """Prove of some orbits that they run away; return those of which it is proved."""
        found = [orbits[:0]]
        for first in range(0, len(orbits), CHUNK // 4):
            index = orbits[first : first + CHUNK // 4]
            part = run_escapes(self.model, dict(self.names), starts.take(index))
            proved = part.status == Status.UNBOUNDED
            put(columns, index[proved], part.take(proved))
            found.append(index[proved])
        return np.concatenate(found)

    def _deeper(self, columns: Columns, orbits: Any, starts: Starts, depth: int, programs: SystemPrograms | None = None) -> None:
        """Run a pass over some orbits, and keep what it makes good.

        Depths are those of ``run_pass``; −2 is the compiled pass, −1 the same with p² to 32 digits.
        """
        size = CHUNK if depth <= 0 else CHUNK // 2 if depth == 1 else CHUNK // 4
        tolerance = FAST if depth < 0 else GOOD if depth == 0 else TOLERANCE
        for first in range(0, len(orbits), size):
            index = orbits[first : first + size]
            chunk = self.model, dict(self.names), starts.take(index)
            part = (
                run_compiled(*chunk, programs=programs, tolerance=tolerance, exact=depth == -1)
                if programs is not None
                else run_pass(*chunk, depth=depth, tolerance=tolerance)
            )
            if depth == 2:
                better = (part.status == Status.OK) | (columns.status[index] != Status.OK)
                index, part = index[better], part.take(better)
            put(columns, index, part)


def build(
    solution: Solution,
    want: frozenset[str],
    parameters: Mapping[str, Any] | None = None,
    compiled: bool | None = None,
) -> Engine:
    """Make a system ready for many orbits.

    Args:
        solution: of the system.
        want: quantities, of ``QUANTITIES``.
        parameters: name → value, where it differs from the default; the same for all orbits.
        compiled: whether to compile the first pass with numba; None for where numba is there.

    Raises:
        InvalidInputError: a quantity that is not known.
        MissingValueError: a parameter without a value.
    """
    for name in sorted(want - set(QUANTITIES)):
        raise InvalidInputError(f'want: "{name}" is not known for many orbits; known are {", ".join(QUANTITIES)}')
    values = parameter_values(solution.system, parameters or {})
    return Engine(
        solution,
        want,
        lowered_model(solution, values),
        _names(solution, want),
        available() if compiled is None else compiled,
    )


def _names(solution: Solution, want: frozenset[str]) -> dict[str, tuple[str, ...]]:
    """Columns of every quantity: coordinates that are separated or ignorable angles have actions and angles."""
    periodic = tuple(
        c.name for c in solution.system.coordinates if c.name in solution.coordinates or c.domain.kind == "angle"
    )
    ends = tuple(f"{name}.{side}" for name in solution.coordinates for side in ("lower", "upper"))
    names = dict.fromkeys(QUANTITIES, periodic) | {"constants": tuple(solution.constants), "turning_points": ends}
    return {quantity: names[quantity] for quantity in QUANTITIES if quantity in want}
