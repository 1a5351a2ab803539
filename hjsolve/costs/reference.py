"""What true errors are measured against: more digits than any method is asked for, from a different method.

Numbers of the motion come from ball arithmetic (for proved ones: from mpmath), states from Taylor series of Hamilton's
equations. What neither can give (an unbounded motion's turning point, an event at a place) comes from mpmath with more
digits than are asked, and the reference says so.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.tape import Tape
from hjsolve.costs.answers import Numbers, Ruler, Value
from hjsolve.costs.own_methods import numbers_read, result_of
from hjsolve.costs.taylor import follow
from hjsolve.costs.trial import Task
from hjsolve.errors import HJSolveError, NotConvergedError, required
from hjsolve.lowering import lower
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes.crossing import as_rational
from hjsolve.scenes.events import Event, changed
from hjsolve.scenes.integrate import Numbers as Start
from hjsolve.scenes.integrate import numbers_of, slopes_of

SPARE = 15
Values = dict[str, tuple[Value, ...]]


@dataclass(frozen=True)
class TrueValues:
    """Numbers to compare with.

    Attributes:
        plain: for what is not proved.
        proved: for what is.
        digits: of both.
        turning: names that are angles.
        how: in words.
    """

    plain: Values
    proved: Values
    digits: int
    turning: frozenset[str]
    how: str

    def ruler(self, sizes: dict[str, float], *, proved: bool) -> Ruler:
        """Give the means to measure an answer.

        Args:
            sizes: name of a number → the size its error is measured against.
            proved: whether the true values that are proved are taken.
        """
        return Ruler(self.proved if proved else self.plain, self.digits, sizes, self.turning)


def true_values(task: Task, digits: int, seconds: float, *, own: bool = True, proofs: bool = True) -> TrueValues:
    """Work out the reference.

    Args:
        task: what is asked; the methods are asked at most ``digits`` less ``SPARE``.
        digits: of the reference.
        seconds: that the series may take.
        own, proofs: whether there is time for hjsolve's own methods with so many digits, and for ball arithmetic.

    Returns:
        The reference; its keys are those that could be computed.
    """
    scene, words = task.scene, list[str]()
    angles = frozenset(f"q.{c.name}" for c in scene.system.coordinates if c.domain.kind == "angle")
    others, series, balls = Values(), Values(), Values()
    if task.states:
        series = _series(task, digits, time.perf_counter() + seconds)
    if task.solution is not None and own:
        others = _own(task, digits)
        balls = _balls(task, digits) if proofs else {}
    if balls:
        words.append(f"ball arithmetic at {digits} digits (proved numbers: mpmath)")
    if series:
        words.append(f"states against Taylor series of Hamilton's equations at {digits} digits")
    plain = others | balls | series
    left = sorted({name.partition(".")[0] for name in others if name not in balls and name not in series})
    if left:
        words.append(f"{', '.join(_WORDS.get(name, name) for name in left)} against mpmath at {digits} digits")
    return TrueValues(plain, others | series, digits, angles, "; ".join(words))


_WORDS = {"q": "coordinates", "p": "momenta", "turning_points": "turning points", "boundary_times": "boundary times"}


def _first(numbers: Numbers) -> Values:
    return {name: tuple(value for value, _ in pairs) for name, pairs in numbers.items()}


def _own(task: Task, digits: int) -> Values:
    try:
        scene = replace(task.scene, digits=digits, times=task.some(task.places) if task.states else task.scene.times)
        return _first(numbers_read(result_of(scene, task), range(len(task.places))).numbers)
    except HJSolveError:
        return {}


def _balls(task: Task, digits: int) -> Values:
    want = tuple(name for name in task.scene.want if name not in ("trajectory", "orbit", "angles"))
    if not want or task.scene.events:
        return {}
    try:
        scene = replace(task.scene, digits=digits, certified=True, want=want)
        numbers = numbers_read(result_of(scene, task), ()).numbers
    except HJSolveError:
        return {}
    return {name: values for name, values in _first(numbers).items() if not name.startswith("boundary_times")}


def _series(task: Task, digits: int, deadline: float) -> Values:
    """Return states by Taylor series; nothing where an event is at a place, or the series does not end in time."""
    scene = task.scene
    if any(event.time is None for event in scene.events):
        return {}
    start = numbers_of(scene)
    variables = [c.symbol for c in scene.system.coordinates] + [c.momentum for c in scene.system.coordinates]
    tape = lower(slopes_of(scene), [*variables, *start.parameters])
    events = sorted((e for e in scene.events if e.time is not None), key=lambda e: float(e.time or 0))
    try:
        found = _followed(task, tape, start, events, digits, deadline)
    except (HJSolveError, ArithmeticError):
        return {}
    names = [f"{letter}.{c.name}" for letter in "qp" for c in scene.system.coordinates]
    return {name: tuple(state[i] for state in found) for i, name in enumerate(names)} if found else {}


def _followed(
    task: Task, tape: Tape, start: Start, events: Sequence[Event], digits: int, deadline: float
) -> list[list[Mpf]]:
    """Return states at the moments compared, on both sides of the start."""
    bits = int(3.4 * digits) + 256
    begin = task.scene.initial.t if task.scene.initial is not None else sp.S.Zero
    constants = [to_bits(value)(bits) for value in start.parameters.values()]
    moments = list(task.moments)
    reached: dict[int, list[Mpf]] = {}
    after = sorted((k for k, t in enumerate(moments) if not (t - begin).is_negative), key=lambda k: float(moments[k]))
    before = sorted((k for k in range(len(moments)) if k not in after), key=lambda k: -float(moments[k]))

    def go(now: sp.Expr, state: list[Mpf], places: list[int], stop: list[sp.Expr]) -> list[Mpf]:
        goals = [*(moments[k] for k in places), *stop]
        states = follow(tape, to_bits(now)(bits), state, constants, [to_bits(t)(bits) for t in goals], digits,
                        deadline=deadline)  # fmt: skip
        if len(states) < len(goals):
            raise NotConvergedError("out of time")
        reached.update(zip(places, states))
        return list(states[-1]) if goals else state

    state = [to_bits(value)(bits) for value in start.exact]
    go(begin, state, before, [])
    begins = [begin, *(required(e.time) for e in events)]
    for k, (low, high) in enumerate(zip(begins, [*begins[1:], None], strict=True)):
        if k:
            state = _struck(events[k - 1], task, start, state, digits)
        inside = [i for i in after if moments[i] >= low and (high is None or moments[i] < high)]
        state = go(low, state, inside, [] if high is None else [high])
    return [reached[k] for k in range(len(moments))]


def _struck(event: Event, task: Task, start: Start, state: list[Mpf], digits: int) -> list[Mpf]:
    """Return the state just after an event."""
    system, values = task.scene.system, dict(start.parameters)
    for i, c in enumerate(system.coordinates):
        values[c.symbol] = as_rational(state[i], digits + SPARE)
        values[c.momentum] = as_rational(state[len(system.coordinates) + i], digits + SPARE)
    p = changed(event, system, values)
    bits = int(3.4 * digits) + 256
    return [*state[: len(system.coordinates)], *(to_bits(p[c.name])(bits) for c in system.coordinates)]
