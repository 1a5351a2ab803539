"""Places and momenta that orbits start with; momenta that velocities give are known to 32 digits on demand.

p = M(q) v in doubles is rounded. What that does is known at once by a running error; a pass that wants more takes p as
two doubles, and nothing is rounded.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.pair_writer import PairWriter
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode
from hjsolve.arithmetic.number_types import Reals, Which
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.program_parts import FINER


@dataclass(frozen=True)
class MomentumRule:
    """p from q and v.

    Attributes:
        tape: inputs all q, all v, parameters.
        numbers: the parameters in two doubles.
    """

    tape: Tape
    numbers: tuple[Pair, ...]

    def rounded(self, q: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        """Return p in doubles and bounds on its errors, arrays like q.

        Args:
            q, velocity: of all coordinates, shape (coordinates, n).
        """
        # a parameter is known to half a unit of its double; the error goes into the bound
        known = [x for pair in self.numbers for x in (float(pair.high), UNIT * abs(float(pair.high)))]
        return self._run(_rounded(self.tape, len(self.numbers)), known, q, velocity)

    def exactly(self, q: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        """Return p in two doubles, arrays like q.

        Args:
            q, velocity: of all coordinates, shape (coordinates, n).
        """
        known = [float(part) for pair in self.numbers for part in pair]
        return self._run(_exact(self.tape, len(self.numbers)), known, q, velocity)

    def _run(self, code: MachineCode, known: list[float], q: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        one, other = np.split(run_rows(code, known, np.concatenate([q, velocity])), 2)
        return one, other


@lru_cache(maxsize=64)
def _rounded(tape: Tape, parameters: int) -> MachineCode:
    """Return momenta and bounds on their errors, in doubles."""
    writer = InstructionWriter()
    given = [WithErrorBound(x) for x in writer.inputs(len(tape.inputs) - parameters)]
    known = [WithErrorBound(writer.parameter(), writer.parameter()) for _ in range(parameters)]
    found = tape.run(RunningError(writer, own=ROUNDINGS), [*given, *known])
    # a momentum that is a velocity itself has no rounding, and its bound is none
    errors = [writer.number(0.0) if p.error is None else p.error for p in found]
    return writer.code([*(p.value for p in found), *errors])


@lru_cache(maxsize=64)
def _exact(tape: Tape, parameters: int) -> MachineCode:
    """Return momenta in two doubles, high parts and then low ones."""
    writer = InstructionWriter()
    pairs = PairWriter(writer)
    given = [pairs.of(x) for x in writer.inputs(len(tape.inputs) - parameters)]
    found = tape.run(pairs, [*given, *(pairs.parameter() for _ in range(parameters))])
    return writer.code([*(p.high for p in found), *(p.low for p in found)])


@dataclass(frozen=True)
class Starts:
    """Starts of n orbits; arrays (coordinates, n).

    Attributes:
        q, p: all places and canonical momenta.
        uncertainty: bounds on the errors of p, ``low`` being left out.
        low: what is to be added to p.
        spread: bounds on the errors that p has in doubles; in two doubles it has 2^−44 of them at most.
        velocity: what p comes from, None where p was given.
        rule: how.
    """

    q: Reals
    p: Reals
    uncertainty: Reals
    low: Reals
    spread: Reals
    velocity: Reals | None = None
    rule: MomentumRule | None = None

    def take(self, index: Which) -> Starts:
        """Return those of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        some = np.flatnonzero(index) if index.dtype == bool else index
        arrays = {name: getattr(self, name).take(some, axis=1) for name in ("q", "p", "uncertainty", "low", "spread")}
        return replace(self, velocity=None if self.velocity is None else self.velocity.take(some, axis=1), **arrays)

    def precise(self) -> Starts:
        """Return the same with momenta in two doubles."""
        # momenta that were given are the doubles they are: there is nothing to sharpen
        if self.rule is None or self.velocity is None:
            return self
        p, low = self.rule.exactly(self.q, self.velocity)
        # p alone lacks its low part; both together lack 2⁻⁴⁴ of what doubles lose
        return replace(self, p=p, low=low, uncertainty=np.abs(low) + FINER * self.spread)


def given_momenta(q: Reals, p: Reals) -> Starts:
    """Return starts of orbits whose momenta are the doubles they are.

    Args:
        q, p: of all coordinates, shape (coordinates, n).
    """
    zero = np.zeros_like(p)
    return Starts(q, p, zero, zero, zero)


def from_velocities(rule: MomentumRule, q: Reals, velocity: Reals) -> Starts:
    """Return starts of orbits whose velocities are given.

    Args:
        q, velocity: of all coordinates, shape (coordinates, n).
    """
    p, uncertainty = rule.rounded(q, velocity)
    return Starts(q, p, uncertainty, np.zeros_like(p), uncertainty, velocity, rule)
