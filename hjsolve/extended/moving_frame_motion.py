"""Motions in a declared frame: computed in the autonomous coordinates, expressed in the original ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for
from hjsolve.arithmetic.number_types import Numbers
from hjsolve.display.shown import Shown
from hjsolve.extended.change_of_frame import ChangeOfFrame, carried_initial_data
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import momenta
from hjsolve.motion.formulas_at_places import bits_in, bounded_at, tape_of, values_at
from hjsolve.motion.initial_data import parameter_values, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.shapes import by_coordinate
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
        shape, frame, speeds = np.shape(state.status), self.frame, self.frame.velocity
        old, new = frame.original.coordinates, frame.system.coordinates
        places = {o.symbol: frame.place[o.name] for o in old} | {o.velocity: speeds[o.name] for o in old}
        p = {name: formula.xreplace(places) for name, formula in momenta(frame.original).items()}
        variables = [*(c.symbol for c in new), *(c.velocity for c in new), frame.time]
        fixed = {s: v for s, v in self.values.items() if s not in variables}
        formulas = tuple(group[o.name] for group in (frame.place, p, speeds) for o in old)
        tape, numbers = tape_of(formulas, (*variables, *fixed)), list(fixed.values())
        told = [*(state.unwrapped(c.name) for c in new), *(state.velocity[c.name] for c in new)]
        arrays = [*(np.ravel(np.asarray(a)) for a in told), _numbers(t, self.digits)]
        names = [o.name for o in old]

        def errors() -> Errors:
            groups = (state.error.q, state.error.velocity)
            uncertain = [np.ravel(np.asarray(group[c.name], dtype=float)) for group in groups for c in new]
            bits = bits_in(arrays[0])
            clock = 2.0**-bits * np.abs(arrays[-1].astype(float))  # times are rounded as well
            found = bounded_at(tape, arrays, [*uncertain, clock], numbers, bits)
            return Errors(*by_coordinate(names, [error for _, error in found], shape))

        q, p_, velocity = by_coordinate(names, values_at(tape, arrays, numbers), shape)
        return State(t, q, p_, velocity, {}, state.status, errors)


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
