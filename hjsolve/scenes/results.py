"""What the run of a scene gives: values, all frozen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.work_counter import WorkCount
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import Errors, KnownErrors, State
from hjsolve.scenes.events import Event
from hjsolve.scenes.impact_budgets import ImpactBudget
from hjsolve.scenes.question import Question
from hjsolve.scenes.resting_contact import Rest
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False, repr=False)
class Arc(Shown):
    """One smooth arc.

    Attributes:
        begins, ends: its times; ``ends`` None for the last.
        events: those that end it.
        turns: angle → whole turns made before the arc.
        quantities: wanted quantity → its values, as in ``Motion``.
        started: the rule behind ``motion``.
    """

    begins: Estimate
    ends: Estimate | None
    events: tuple[Event, ...]
    turns: Mapping[str, int]
    quantities: Mapping[str, Any] = field(repr=False)
    started: Callable[[], Motion] = field(repr=False)

    @property
    def motion(self) -> Motion:
        """What was computed, of the wanted quantities only; of an arc without a wanted time, when it is read."""
        return self.started()


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Shown):
    """The states at the times of a scene; at the time of an event, the state just after it.

    Attributes:
        t: the times, shape (m,); float64 up to 15 digits, ``mpf`` above.
        q, p, velocity: coordinate → array (m,); angles in (−π, π].
        turns: angle → whole turns to be added to ``q``.
        status: for each time ``ok``, ``reaches_boundary``, ``at_rest`` (on a wall that keeps the body), or ``ended``
            (beyond such a wall, where other coordinates still move: the numbers are NaN).
        arc: number of the arc each time belongs to.
        errors: the rule behind ``error``.
    """

    t: Any
    q: Mapping[str, Any]
    p: Mapping[str, Any]
    velocity: Mapping[str, Any]
    turns: Mapping[str, Any]
    status: Any
    arc: Any
    errors: Callable[[], Errors]

    def __reduce__(self) -> tuple[Any, ...]:
        numbers = (self.q, self.p, self.velocity, self.turns)
        return Trajectory, (self.t, *map(dict, numbers), self.status, self.arc, KnownErrors(self.error))

    @property
    def error(self) -> Errors:
        """Bounds on the errors of q, p and velocity, worked out when asked for."""
        return self.errors()

    def unwrapped(self, name: str) -> Any:
        """Return q with its whole turns.

        Args:
            name: of the coordinate.
        """
        return State(self.t, self.q, self.p, self.velocity, self.turns, self.status, self.errors).unwrapped(name)


@dataclass(frozen=True, repr=False)
class Choice(Shown):
    """How a scene was run.

    Attributes:
        method: ``float64``, ``mpmath``, ``certified`` (ball arithmetic) or ``integrate``.
        digits: it was run with.
        why: in words.
        tried: (method, digits, seconds) of every run made, in order; the last one gave the answer.
    """

    method: str
    digits: int
    why: str
    tried: tuple[tuple[str, int, float], ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class Run(Shown):
    """What a scene gave; see ``Scene.run``.

    Attributes:
        scene: what was asked.
        solution: the quadratures; None where the scene was integrated.
        arcs: the smooth arcs in order; none where the scene was integrated.
        trajectory: the states, where they are wanted.
        drift: former constant → its change since the start at every time, where the scene was integrated.
        work: evaluations of p², of kernels, and of places, all that the run needed.
        choice: which method was chosen, and why.
        rest: how the scene ended before its last time, if a wall that takes energy keeps the body.
        impacts: what each impact did, with the budgets of momentum and energy; in the coordinates of its arc.
        lasting: the run in the coordinates that a constraint that lasts has left; its arcs and states are those of this
            run too, the states in the coordinates of this one.
    """

    scene: Question
    solution: Solution | None
    arcs: tuple[Arc, ...]
    trajectory: Trajectory | None
    drift: Mapping[str, Any]
    work: WorkCount
    choice: Choice | None = None
    rest: Rest | None = None
    impacts: tuple[ImpactBudget, ...] = ()
    lasting: Run | None = None

    def quantity(self, name: str, arc: int = 0) -> Any:
        """Return a wanted quantity of one arc, as in ``Motion``.

        Args:
            name: one of those the scene wants.
            arc: its number, from 0 on; negative ones count from the last.

        Raises:
            InvalidInputError: the scene does not want it, or there is no such arc.
        """
        if not -len(self.arcs) <= arc < len(self.arcs):
            raise InvalidInputError(f"arc: {arc} does not exist; the scene has {len(self.arcs)}")
        if name not in self.arcs[arc].quantities:
            raise InvalidInputError(f'"{name}" was not computed; add it to want')
        return self.arcs[arc].quantities[name]
