"""Places and momenta that orbits start with; momenta that velocities give are known to 32 digits on demand.

p = M(q) v in doubles is rounded. What that does is known at once by a running error; a pass that wants more takes p as
two doubles, and nothing is rounded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT, Float64
from hjsolve.arithmetic.number_types import Elementwise, Reals, Which
from hjsolve.arithmetic.pair_source import NamedPair, PairSource, written
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.engine.orbit_vectors import run_in_vectors, vector_text
from hjsolve.ensembles.engine.programs import program

_FINER = 2.0**-44


@dataclass(frozen=True)
class MomentumRule:
    """p from q and v.

    Attributes:
        tape: inputs all q, all v, parameters.
        numbers: the parameters in two doubles.
        compiled: whether momenta in two doubles are worked out by numba.
    """

    tape: Tape
    numbers: tuple[Pair, ...]
    compiled: bool = False

    def rounded(self, q: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        """Return p in doubles and bounds on its errors, arrays like q.

        Args:
            q, velocity: of all coordinates, shape (coordinates, n).
        """
        exact = [WithErrorBound(x) for x in (*q, *velocity)]
        known = [WithErrorBound(x.high, UNIT * abs(x.high)) for x in self.numbers]
        with np.errstate(all="ignore"):
            found = self.tape.run(RunningError(Float64()), exact + known)
        errors = [0.0 if x.error is None else x.error for x in found]
        return _rows([x.value for x in found], q), _rows(errors, q)

    def exactly(self, q: Reals, velocity: Reals) -> tuple[Reals, Reals]:
        """Return p in two doubles, arrays like q.

        Args:
            q, velocity: of all coordinates, shape (coordinates, n).
        """
        if self.compiled:
            high, low = np.split(run_in_vectors(_program(self), np.concatenate([q, velocity]), 2 * len(q)), 2)
            return high, low
        inputs = [Pair(x, 0.0 * x) for x in (*q, *velocity)]
        with np.errstate(all="ignore"):
            found = self.tape.run(DoubleDouble(), [*inputs, *self.numbers])
        return _rows([x.high for x in found], q), _rows([x.low for x in found], q)


@lru_cache(maxsize=64)
def _program(rule: MomentumRule) -> Callable[..., None]:
    source, given = PythonSource(), len(rule.tape.inputs) - len(rule.numbers)
    inputs = [*(NamedPair(f"g{k}", "(0.0)") for k in range(given)), *map(written, rule.numbers)]
    found = rule.tape.run(PairSource(source), inputs)
    results = [*(p.high for p in found), *(p.low for p in found)]
    return program(vector_text("momenta", given, source, results), "momenta")


def _rows(parts: list[Elementwise], like: Reals) -> Reals:
    return np.stack([np.broadcast_to(part, like.shape[1:]) for part in parts])


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
        if self.rule is None or self.velocity is None:
            return self
        p, low = self.rule.exactly(self.q, self.velocity)
        return replace(self, p=p, low=low, uncertainty=np.abs(low) + _FINER * self.spread)


def given_momenta(q: Reals, p: Reals) -> Starts:
    """Starts of orbits whose momenta are the doubles they are.

    Args:
        q, p: of all coordinates, shape (coordinates, n).
    """
    zero = np.zeros_like(p)
    return Starts(q, p, zero, zero, zero)


def from_velocities(rule: MomentumRule, q: Reals, velocity: Reals) -> Starts:
    """Starts of orbits whose velocities are given.

    Args:
        rule: of the system.
        q, velocity: of all coordinates, shape (coordinates, n).
    """
    p, uncertainty = rule.rounded(q, velocity)
    return Starts(q, p, uncertainty, np.zeros_like(p), uncertainty, velocity, rule)
