"""The verb of this package."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress

from hjsolve import arguments
from hjsolve.costs.closed_forms import closed_trials
from hjsolve.costs.derived_forms import derived_trials
from hjsolve.costs.measure import Clock, measured
from hjsolve.costs.own_methods import own_trials
from hjsolve.costs.reference import SPARE, TrueValues, true_values
from hjsolve.costs.rivals import rival_trials
from hjsolve.costs.subject import Subject, scene_of
from hjsolve.costs.table import Cost
from hjsolve.costs.trial import Task, Trial
from hjsolve.display.progress import Progress
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes import Scene

DIGITS = (20, 30, 50, 100)
"""Beyond double precision, by default; the last of them only where the budget is half a minute or more."""
_PARTS = (8, 4, 2, 1)
_MOST_DIGITS, _LONG = 250, 30.0


@arguments.with_known_names('cost("kepler-planar", digits=[15, 30])')
def cost(
    subject: Subject,
    *,
    digits: Sequence[int] | None = None,
    seconds: float = 20.0,
    repeats: int = 5,
    motion: str = "default",
    rivals: bool = True,
    progress: Progress | None = None,
) -> Cost:
    """Measure what accuracy costs in time.

    Every method that applies computes the scene's own quantities: double precision, mpmath at rising digits, ball
    arithmetic with proof, the closed form that the catalog has or that can be derived, and, for states, integrators of
    Hamilton's equations. They run in turn, several times; errors are true ones, against a reference that another
    backend computed with more digits.

    Args:
        subject: a ``Scene``, its table or its file; a catalog id or an entry's file; a ``Motion``; a
            ``System`` or a ``Solution`` of the catalog, for its motion there.
        digits: beyond double precision; None for ``DIGITS``.
        seconds: budget for everything. What does not fit is marked, not dropped.
        repeats: timed runs of each method at most; the median counts.
        motion: which motion of a catalog entry.
        rivals: whether DOP853 and heyoka run as well.
        progress: called with the part of the budget spent and what is running; at the end with an empty text.

    Returns:
        The table.

    Raises:
        InvalidInputError: the subject is none of these, or the numbers asked make no sense.
        NotSeparableError: the system does not separate and the scene does not ask for an integrator.

    Example:
        >>> table = cost("harmonic-oscillator", digits=(20,), seconds=20, repeats=1)
        >>> [row.held for row in table.of("float64")]
        [True]
    """
    if not seconds > 0 or type(repeats) is not int or repeats < 1:
        wrong = f"repeats: a whole number > 0 is needed, not {repeats!r}"
        wrong = wrong if seconds > 0 else f"seconds: a number > 0 is needed, not {seconds!r}"
        raise InvalidInputError(f"cost: {wrong}")
    levels = _levels(digits if digits is not None else DIGITS if seconds >= _LONG else DIGITS[:-1])
    clock = Clock(time.perf_counter(), seconds, progress)
    scene, solution = scene_of(subject, motion)
    task = Task(scene, solution, _places(scene))
    closed = closed_trials(task, levels) or derived_trials(task, levels, seconds)
    trials = [*own_trials(task, levels), *closed, *(rival_trials(task) if rivals else [])]
    truth = _truth(task, trials[0], levels, clock)
    rows = measured(task, trials, truth, clock, repeats)
    clock.tell("")
    return Cost(
        title=scene.title or scene.system.title or "A scene", id=scene.system.id, want=scene.want,
        times=len(scene.times.exact()) if scene.times is not None and task.states else 0,
        checked=len(task.places) if task.states else 0, rows=tuple(rows), reference=truth.how,
        floor=10.0 ** (5 - truth.digits), budget=seconds, spent=clock.spent,
    )  # fmt: skip


def _truth(task: Task, first: Trial, levels: Sequence[int], clock: Clock) -> TrueValues:
    """Return the reference: as many digits as the time allows, judged by the first method."""
    clock.tell(first.method)
    begin = time.perf_counter()
    with suppress(NotConvergedError):  # its row will say so
        first.compute(task.some(task.places) if task.states else None, begin + clock.budget / 4)
    once, third = time.perf_counter() - begin, clock.budget / 3

    def expected(digits: int) -> float:
        return once * ((digits + SPARE) / 15) ** 1.2

    fit = [digits for digits in levels if expected(digits) <= third] if task.solution is not None else []
    digits = max(fit, default=15) + SPARE
    clock.tell(f"reference, {digits} digits")
    proofs = 5 * once * ((digits + SPARE) / 15) ** 0.6 <= clock.budget / 2
    return true_values(task, digits, clock.budget / 4, own=expected(digits - SPARE) <= third, proofs=proofs)


def _levels(digits: Sequence[int]) -> tuple[int, ...]:
    for value in digits:
        if type(value) is not int or not 16 <= value <= _MOST_DIGITS:
            raise InvalidInputError(f"digits: whole numbers from 16 to {_MOST_DIGITS} are needed, not {value!r}")
    return tuple(sorted(set(digits)))


def _places(scene: Scene) -> tuple[int, ...]:
    """Return which times are compared: a few, the farthest from the start among them."""
    if scene.times is None or "trajectory" not in scene.want:
        return ()
    every = [to_bits(t)(64) for t in scene.times.exact()]
    start = to_bits(scene.initial.t)(64) if scene.initial is not None else 0
    order = sorted(range(len(every)), key=lambda k: abs(every[k] - start))
    chosen = {order[max(0, len(order) // part - 1)] for part in _PARTS}
    return tuple(sorted(chosen))
