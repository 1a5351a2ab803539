"""Motions in a declared frame: computed in the autonomous coordinates, expressed in the original ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import Float64, Multi, bits_for
from hjsolve.arithmetic.number_types import AtTimes, Numbers
from hjsolve.display.shown import Shown
from hjsolve.extended.change_of_frame import ChangeOfFrame, carried_initial_data
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.mechanics.system import momenta
from hjsolve.motion.initial_data import parameter_values, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State
from hjsolve.motion.times import exact_numbers
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False, repr=False)
class FramedMotion(Shown):
    """A motion of a system with explicit time.

    Attributes:
        frame: the change that makes it autonomous.
        motion: of the autonomous system; its kinds, periods and actions are those of the new coordinates.
    """

    frame: ChangeOfFrame
    motion: Motion

    @property
    def kinds(self) -> Mapping[str, str]:
        """The kinds of motion of the coordinates of the frame."""
        return self.motion.kinds

    @property
    def constants(self) -> Mapping[str, Estimate]:
        """The constants of the motion in the frame."""
        return self.motion.constants

    def at(self, t: object) -> State:
        """Return the state of the original system at a time or times; as ``Motion.at``, angles not counted in turns."""
        carried = CarriedOver(self.frame, self.motion.initial.values, self.motion.digits)
        return carried.state(self.motion.at(t), t)


@dataclass(frozen=True, eq=False)
class CarriedOver:
    """States of the coordinates Q of a frame, carried over to q = f(Q, t), with errors.

    Attributes:
        frame: the change.
        values: of the parameters, exact.
        digits: of the states.
    """

    frame: ChangeOfFrame
    values: Mapping[sp.Symbol, sp.Expr]
    digits: int

    def state(self, state: State, t: object) -> State:
        """Return the state in q; angles not counted in turns.

        Args:
            state: in Q.
            t: its times.
        """
        shape = np.shape(state.status)
        times = _numbers(t, self.digits)
        old = self.frame.original.coordinates
        speeds = self.frame.velocity
        places = {o.symbol: self.frame.place[o.name] for o in old} | {o.velocity: speeds[o.name] for o in old}
        p = {name: formula.xreplace(places) for name, formula in momenta(self.frame.original).items()}
        groups = [{c.name: self.frame.place[c.name] for c in old}, p, speeds]
        found = [{name: self._evaluated(f, state, times) for name, f in group.items()} for group in groups]

        def bounds(k: int) -> dict[str, AtTimes]:
            rows = {name: self._bound(f, found[k][name], state, times) for name, f in groups[k].items()}
            return {name: shaped(row, shape) for name, row in rows.items()}

        def errors() -> Errors:
            return Errors(bounds(0), bounds(1), bounds(2))

        q, p, velocity = ({name: shaped(row, shape) for name, row in group.items()} for group in found)
        return State(t, q, p, velocity, {}, state.status, errors)

    def _evaluated(self, formula: sp.Expr, state: State, times: Numbers) -> Numbers:
        """Return a formula at the times, shape (m,)."""
        coordinates = self.frame.system.coordinates
        variables = [c.symbol for c in coordinates] + [c.velocity for c in coordinates] + [self.frame.time]
        told = [*(state.unwrapped(c.name) for c in coordinates), *(state.velocity[c.name] for c in coordinates), times]
        arrays = [np.ravel(np.asarray(a)) for a in told]
        fixed = {s: v for s, v in self.values.items() if s not in variables}
        tape = lower([formula], [*variables, *fixed])
        if self.digits <= 15:
            approximate = [float(to_bits(v)(64)) for v in fixed.values()]
            return np.broadcast_to(tape.run(Float64(), [*arrays, *approximate])[0], times.shape)
        bits = bits_for(self.digits, 64)
        numbers = [to_bits(v)(bits) for v in fixed.values()]
        rows = zip(*arrays, strict=True)
        found = [tape.run(Multi(bits), [*(Multi(bits).convert(x) for x in row), *numbers])[0] for row in rows]
        return np.array(found, dtype=object)

    def _bound(self, formula: sp.Expr, value: Numbers, state: State, times: Numbers) -> Numbers:
        """Return the errors of Q and Q̇ carried over to first order, doubled, and the rounding of the formula."""
        total = 16 * 10.0 ** -max(self.digits, 15) * (np.abs(value) + self._size(formula, state, times))
        for c in self.frame.system.coordinates:
            for symbol, error in ((c.symbol, state.error.q[c.name]), (c.velocity, state.error.velocity[c.name])):
                slope = sp.diff(formula, symbol)
                if slope != 0:
                    total = total + 2 * np.abs(self._evaluated(slope, state, times)) * np.ravel(np.asarray(error))
        return total

    def _size(self, formula: sp.Expr, state: State, times: Numbers) -> Numbers:
        """Return the sum of the sizes of the terms: what cancellation is measured against."""
        terms = sp.Add.make_args(sp.expand(formula))
        return sum((np.abs(self._evaluated(term, state, times)) for term in terms), 0 * times)


def _numbers(t: object, digits: int) -> Numbers:
    """Return times in a row."""
    exact = [to_bits(x)(bits_for(digits, 64)) for x in exact_numbers(t, "t")[1]]
    return np.array([float(x) for x in exact]) if digits <= 15 else np.array(exact, dtype=object)


def start_framed_motion(
    frame: ChangeOfFrame, *, q: Mapping[str, object], velocity: Mapping[str, object] | None,
    p: Mapping[str, object] | None, parameters: Mapping[str, object], t0: object, digits: int,
    solution: Solution | None = None,
) -> FramedMotion:  # fmt: skip
    """Start a motion, see ``Frame.motion``; ``solution`` is that of the autonomous system."""
    time = number(t0, source="t0")
    values = {**parameter_values(frame.system, parameters), frame.time: time}
    data = carried_initial_data(frame, values, q, velocity, p)
    solved = frame.solve() if solution is None else solution
    return FramedMotion(frame, solved.motion(**data, parameters=parameters, t0=time, digits=digits))
