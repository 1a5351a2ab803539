"""Integration step by step, with events: each is located on the step that jumps over it, then reached exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.errors import NotConvergedError
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System
from hjsolve.scenes.events import Event, changed

MOST_STEPS = 2_000_000


@dataclass
class Flow:
    """The right-hand side of the equations of motion.

    Attributes:
        system: whose momenta the events change.
        slopes: state (2n, …) ↦ its rate of change, same shape.
        parameters: exact values by symbol.
        calls: evaluations so far.
    """

    system: System
    slopes: Callable[[Reals], Any]
    parameters: Mapping[sp.Symbol, sp.Expr]
    calls: int = field(default=0)

    def __call__(self, _: float, state: Reals) -> Any:
        """Evaluate, counted."""
        self.calls += 1
        return self.slopes(state)


@dataclass(frozen=True, eq=False)
class Sampled:
    """States at given times, shape (2n, m), and the number of events before each."""

    states: Reals
    arcs: Integers


@dataclass
class _Surface:
    """An event at a place: which side the motion is on, and how many passages it lets by."""

    event: Event
    index: int
    value: float
    turning: bool
    left: int

    def level(self, state: Reals) -> float:
        """Signed distance; for an angle, of the half turn around the surface."""
        off = state[self.index] - self.value
        return float(off - 2 * np.pi * np.rint(off / (2 * np.pi))) if self.turning else float(off)


def integrate_steps(
    flow: Flow, events: Sequence[Event], start: float, state: Reals, times: Reals, tolerance: float
) -> Sampled:
    """Integrate from the start through all times.

    Args:
        flow: the equations of motion.
        events: impulses and walls.
        start: the initial time.
        state: there, shape (2n,).
        times: increasing, shape (m,).
        tolerance: relative; the absolute one is that of the largest coordinate.

    Raises:
        NotConvergedError: the step became too small (a collision), or there were too many steps.
    """
    order = np.argsort(times)
    states, arcs = np.empty((len(state), len(times))), np.zeros(len(times), dtype=int)
    names = [c.name for c in flow.system.coordinates]
    angles = {c.name for c in flow.system.coordinates if c.domain.kind == "angle"}
    surfaces = [
        _Surface(e, names.index(e.coordinate), float(e.value), e.coordinate in angles, e.passage)
        for e in events
        if e.coordinate is not None and e.value is not None
    ]
    timed = sorted((e for e in events if e.time is not None), key=lambda e: float(e.time or 0))
    t, count, steps = start, 0, 0
    for place in order:
        goal = float(times[place])
        while t < goal or (timed and float(timed[0].time or 0) <= goal):
            stop = min(goal, float(timed[0].time or 0)) if timed else goal
            t, state, hit, used = _advance(flow, surfaces, t, state, stop, tolerance)
            steps += used
            if steps > MOST_STEPS:
                raise NotConvergedError(f"more than {MOST_STEPS} steps; ask for fewer digits or a shorter time")
            happening = list(hit)
            while timed and t >= float(timed[0].time or 0):
                happening.append(timed.pop(0))
            for event in happening:
                state, count = _changed(flow, event, state), count + 1
                surfaces = [s for s in surfaces if s.event is not event or event.kind == "wall"]
            if t >= goal and not happening:
                break
        states[:, place], arcs[place] = state, count
    return Sampled(states, arcs)


def _changed(flow: Flow, event: Event, state: Reals) -> Reals:
    n = len(flow.system.coordinates)
    values = dict(flow.parameters)
    for i, c in enumerate(flow.system.coordinates):
        values[c.symbol], values[c.momentum] = (number(float(x), source="state") for x in (state[i], state[n + i]))
    p = changed(event, flow.system, values)
    return np.array([*state[:n], *(float(sp.N(p[c.name], 20)) for c in flow.system.coordinates)])


def _advance(
    flow: Flow, surfaces: list[_Surface], t: float, state: Reals, stop: float, tolerance: float
) -> tuple[float, Reals, list[Event], int]:
    """Go on to ``stop`` or to the first event at a place, whichever comes first."""
    from scipy.integrate import DOP853

    if stop <= t:
        return t, state, [], 0
    scale = tolerance * max(float(np.max(np.abs(state))), 1e-300)
    solver = DOP853(flow, t, state, stop, rtol=tolerance, atol=scale)
    steps = 0
    leaving = {id(s) for s in surfaces if abs(s.level(state)) <= 64 * scale}
    while solver.status == "running":
        old_t, old_state = solver.t, solver.y
        message = solver.step()
        steps += 1
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            raise NotConvergedError(f"the integrator stopped at t = {old_t:.12g}: {message or 'the state is infinite'}")
        crossed = [s for s in surfaces if _crosses(s, old_state, solver.y, id(s) in leaving)]
        leaving -= {id(s) for s in surfaces if abs(s.level(solver.y)) > 64 * scale}
        if crossed:
            when, s = min(((_root(solver.dense_output(), s, old_t, solver.t), s) for s in crossed), key=lambda x: x[0])
            when, there = _reached(flow, s, old_t, old_state, when, tolerance, scale)
            if s.left:
                s.left -= 1
                return when, there, [], steps
            there[s.index] = s.value if not s.turning else there[s.index]
            return when, there, [s.event], steps
    return solver.t, solver.y, [], steps


def _crosses(surface: _Surface, before: Reals, after: Reals, leaving: bool) -> bool:
    """Return a change of sign; a motion that is just leaving the surface has not crossed it."""
    old, new = surface.level(before), surface.level(after)
    if leaving or (surface.turning and abs(old - new) > np.pi):
        return False
    return old * new < 0 or (new == 0 and old != 0)


def _root(dense: Callable[[float], Reals], surface: _Surface, low: float, high: float) -> float:
    def level(t: float) -> float:
        return surface.level(dense(t))

    return interpolated_root(level, (low, high), (level(low), level(high)), width=1e-14)


def _reached(
    flow: Flow, surface: _Surface, t: float, state: Reals, when: float, tolerance: float, scale: float
) -> tuple[float, Reals]:
    """Integrate to the event itself, the time corrected by Newton's method: steps are better than dense output."""
    from scipy.integrate import DOP853

    there = state
    for _ in range(4):
        solver = DOP853(flow, t, state, when, rtol=tolerance, atol=scale) if when > t else None
        while solver is not None and solver.status == "running":
            solver.step()
        there = solver.y.copy() if solver is not None else state.copy()
        speed = flow(when, there)[surface.index]
        change = surface.level(there) / speed if speed else 0.0
        if abs(change) <= 4e-16 * max(abs(when), 1e-300):
            break
        when -= change
    return when, there
