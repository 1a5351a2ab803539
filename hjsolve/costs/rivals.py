"""Rivals: integrators of Hamilton's equations in double precision, at rising tolerances.

They are measured on the states alone. They claim no error; the tolerance asked stands in the column of digits.
DOP853: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, §II.10, from scipy. heyoka: Biscani &
Izzo, MNRAS 504 (2021) 2614, Taylor series compiled for the system.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from types import ModuleType
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import ByOperators
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.costs.answers import Answer
from hjsolve.costs.trial import Task, Trial
from hjsolve.errors import InvalidInputError, MissingExtraError, NotConvergedError, required
from hjsolve.formulas.read import number
from hjsolve.lowering import lower
from hjsolve.scenes.events import Event, changed
from hjsolve.scenes.integrate import Numbers, numbers_of, slopes_of
from hjsolve.scenes.question import Times
from hjsolve.scenes.run import sampled
from hjsolve.scenes.steps import Flow, integrate_steps

if TYPE_CHECKING:
    import heyoka


_NAMES = {"abs": "fabs"}


@dataclass(frozen=True, slots=True)
class ScalarFloat(ByOperators):
    """Double precision for scalars; what leaves the domain of a function is not a number."""

    def rational(self, numerator: int, denominator: int) -> float:
        """Return the float next to a fraction."""
        return numerator / denominator

    def pi(self) -> float:
        """Give π."""
        return math.pi

    def div(self, x: float, y: float) -> float:
        """Return x/y; nan for a zero y."""
        return x / y if y else math.nan

    def power(self, x: float, n: int) -> float:
        """Return xⁿ; nan for a pole."""
        return x**n if x or n > 0 else math.nan

    def unary(self, name: str, x: float) -> float:
        """Return a function of x; nan outside its domain."""
        if name == "neg":
            return -x
        try:
            return float(getattr(math, _NAMES.get(name, name))(x))
        except (ValueError, OverflowError):
            return math.nan


TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 2.3e-14)


@dataclass(frozen=True, eq=False)
class States:
    """States at times, shape (2n, m), and what they took."""

    values: Reals
    count: int


Compute: TypeAlias = Callable[[Times | None, float], States]
"""(times or None for the scene's own, the moment by which to be done) ↦ states."""


def rival_trials(task: Task) -> list[Trial]:
    """DOP853 and heyoka for the states a scene wants.

    Returns:
        One trial a tolerance; none where no states are wanted.
    """
    if not task.states:
        return []
    more = task.solution is not None and set(task.scene.want) - {"trajectory", "kinds"}
    covers, note = ("states", "states alone") if more else ("all", "")
    kinds: tuple[tuple[str, str, Callable[[Task, float], Compute], Sequence[float]], ...] = (
        ("DOP853", "right-hand sides", _dop853, TOLERANCES),
        ("heyoka", "Taylor steps", _heyoka, (1e-6, 1e-9, 1e-12, 2.3e-16)),
    )
    found = []
    for method, unit, make, tolerances in kinds:
        for tolerance in tolerances:
            ready = cache(partial(make, task, tolerance))
            found.append(
                Trial(
                    method, round(-math.log10(tolerance), 1), partial(_run, ready), partial(_read, task), unit, ready,
                    covers=covers, note=note,
                )
            )  # fmt: skip
    return found


def _run(ready: Callable[[], Callable[[Times | None, float], States]], times: Times | None, deadline: float) -> States:
    return ready()(times, deadline)


def _read(task: Task, states: States, places: Sequence[int]) -> Answer:
    names = [c.name for c in task.scene.system.coordinates]
    keys = [f"q.{name}" for name in names] + [f"p.{name}" for name in names]
    numbers = {key: tuple((states.values[i][k], None) for k in places) for i, key in enumerate(keys)}
    sizes = {key: float(np.nanmax(np.abs(states.values[i]))) for i, key in enumerate(keys)}
    return Answer(numbers, states.count, sizes)


def _slopes(task: Task, numbers: Numbers) -> tuple[Tape, list[float]]:
    """Return the right-hand side in (q, p) and parameters, and the parameters' values."""
    system = task.scene.system
    variables = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    tape = lower(slopes_of(task.scene), [*variables, *numbers.parameters])
    return tape, [float(sp.N(value, 20)) for value in numbers.parameters.values()]


def _when(task: Task, times: Times | None) -> Reals:
    chosen = required(times or task.scene.times)
    return np.array([float(t) for t in sampled(chosen, 15)])


def _sides(when: Reals, start: float) -> list[tuple[Integers, Reals]]:
    """Return the places of the times after the start and before it, each in the order in which they are reached."""
    found = []
    for side in (when >= start, when < start):
        places = np.nonzero(side)[0]
        if len(places):
            places = places[np.argsort(np.abs(when[places] - start), kind="stable")]
            found.append((places, when[places]))
    return found


def _piecewise(task: Task, numbers: Numbers, when: Reals, carried: Callable[[float, Reals, Reals], Reals]) -> Reals:
    """Return states at all times, the impulses given at their times in between.

    Args:
        task: whose events, if any, are all at given times.
        when: times, shape (m,).
        carried: (begin, state there, times in the order they are reached) ↦ states at the times.
    """
    values = np.empty((len(numbers.state), len(when)))
    events = sorted(task.scene.events, key=lambda event: float(event.time or 0))
    for places, goal in _sides(when, numbers.start):
        begin, state, left = numbers.start, numbers.state, np.ones(len(goal), dtype=bool)
        for event in events if goal[-1] >= numbers.start else ():
            end = float(event.time or 0)
            inside = left & (goal < end)
            states = carried(begin, state, np.append(goal[inside], end))
            values[:, places[inside]] = states[:, :-1]
            begin, state, left = end, _struck(task, numbers, event, states[:, -1]), left & ~inside
        if left.any():
            values[:, places[left]] = carried(begin, state, goal[left])
    return values


def _struck(task: Task, numbers: Numbers, event: Event, state: Reals) -> Reals:
    """Return the state just after an event, in double precision."""
    coordinates = task.scene.system.coordinates
    symbols = [c.symbol for c in coordinates] + [c.momentum for c in coordinates]
    exact = {s: number(float(x), source="state") for s, x in zip(symbols, state)}
    p = changed(event, task.scene.system, {**numbers.parameters, **exact})
    return np.array([*state[: len(coordinates)], *(float(sp.N(p[c.name], 20)) for c in coordinates)])


def _dop853(task: Task, tolerance: float) -> Compute:
    try:
        from scipy.integrate import solve_ivp
    except ImportError as missing:
        raise MissingExtraError('needs scipy: pip install "hjsolve[integrate]"') from missing
    scene, numbers = task.scene, numbers_of(task.scene)
    tape, fixed = _slopes(task, numbers)
    absolute = tolerance * max(float(np.max(np.abs(numbers.state))), 1e-300)
    relative = max(tolerance, 2.3e-14)

    def compute(times: Times | None, deadline: float) -> States:
        calls, arithmetic, when = 0, ScalarFloat(), _when(task, times)

        def slopes(_: float, state: Reals) -> list[float]:
            nonlocal calls
            calls += 1
            if time.perf_counter() > deadline:
                raise NotConvergedError("out of time")
            return tape.run(arithmetic, [*state.tolist(), *fixed])

        if any(event.time is None for event in scene.events):
            flow = Flow(scene.system, lambda state: slopes(0.0, state), numbers.parameters)
            done = integrate_steps(flow, scene.events, numbers.start, numbers.state, when, relative)
            return States(done.states, calls)

        def carried(begin: float, state: Reals, goal: Reals) -> Reals:
            with np.errstate(all="ignore"):
                whole = solve_ivp(slopes, (begin, goal[-1]), state, "DOP853", goal, rtol=relative, atol=absolute)
            if not whole.success:
                raise NotConvergedError("the step became too small")
            return whole.y

        return States(_piecewise(task, numbers, when, carried), calls)

    return compute


@dataclass(frozen=True, slots=True)
class _Symbols(ScalarFloat):
    """A tape run over heyoka's expressions."""

    library: ModuleType

    def div(self, x: heyoka.expression, y: heyoka.expression) -> heyoka.expression:
        return x / y

    def power(self, x: heyoka.expression, n: int) -> heyoka.expression:
        return x ** float(n)

    def unary(self, name: str, x: heyoka.expression | float) -> heyoka.expression | float:
        if isinstance(x, float):
            return ScalarFloat().unary(name, x)
        return -x if name == "neg" else getattr(self.library, name)(x)


def _heyoka(task: Task, tolerance: float) -> Compute:
    try:
        import heyoka
    except ImportError as missing:
        raise MissingExtraError("needs heyoka: pip install heyoka") from missing
    numbers = numbers_of(task.scene)
    if task.scene.events:
        raise InvalidInputError("the scene's events are not given to it")
    tape, fixed = _slopes(task, numbers)
    left = [heyoka.make_vars(f"y{i}") for i in range(len(numbers.state))]
    right = tape.run(_Symbols(heyoka), [*left, *fixed])
    right = [f if isinstance(f, heyoka.expression) else heyoka.expression(f) for f in right]
    machine = heyoka.taylor_adaptive(list(zip(left, right)), numbers.state.tolist(), tol=tolerance)

    def compute(times: Times | None, _: float) -> States:
        when, steps = _when(task, times), 0
        values = np.empty((len(numbers.state), len(when)))
        for places, goal in _sides(when, numbers.start):
            machine.time, machine.state[:] = numbers.start, numbers.state
            grid, back = np.unique(np.abs(np.concatenate([[numbers.start], goal]) - numbers.start), return_inverse=True)
            sign = 1.0 if goal[-1] >= numbers.start else -1.0
            outcome = machine.propagate_grid(numbers.start + sign * grid, max_steps=2_000_000)
            reached = np.asarray(outcome[-1])
            if len(reached) != len(grid) or not np.isfinite(reached).all():
                raise NotConvergedError("the state became infinite, or the steps too many")
            steps += int(outcome[3])
            values[:, places] = reached[back[1:]].T
        return States(values, steps)

    return compute
