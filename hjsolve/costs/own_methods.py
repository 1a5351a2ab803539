"""hjsolve's own methods: the scene itself, run at several accuracies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hjsolve.arithmetic.work_counter import counted
from hjsolve.costs.answers import Answer, scalars
from hjsolve.costs.trial import Task, Trial
from hjsolve.scenes import Scene
from hjsolve.scenes.question import Times
from hjsolve.scenes.run import Run, run_by_quadratures


@dataclass(frozen=True, eq=False)
class Result:
    """A run, its states with their errors worked out, and the evaluations it took."""

    run: Run
    states: dict[str, tuple[Any, Any]]
    count: int


def own_trials(task: Task, levels: Sequence[int]) -> list[Trial]:
    """Return the methods of hjsolve.

    Args:
        levels: digits beyond double precision.

    Returns:
        ``float64`` at 15 digits, ``mpmath`` and ``certified`` at the levels; or ``integrate`` where the scene says so.
    """
    if task.solution is None:
        return [own(task, "integrate", digits) for digits in (4, 6, 8, 10, 12)]
    found = [own(task, "float64", 15), *(own(task, "mpmath", digits) for digits in levels)]
    if set(task.scene.want) & {"constants", "turning_points", "actions", "frequencies", "periods"}:
        found += [own(task, "certified", digits) for digits in (15, *levels)]
    return found


def own(task: Task, method: str, digits: int) -> Trial:
    """One method at one accuracy.

    Args:
        method: one of hjsolve's own, such as ``quadratures``, ``mpmath`` or ``certified``.
        digits: relative digits to ask of it.
    """
    proved = method == "certified"
    want = tuple(name for name in task.scene.want if not (proved and name in ("trajectory", "orbit", "angles")))
    if task.solution is None:
        want = tuple(name for name in want if name != "constants") or want
    scene = replace(task.scene, digits=digits, certified=proved, want=want)
    if digits > 15 and task.states:
        scene = replace(scene, times=Times(listed=task.every))

    def compute(times: Times | None, _: float) -> Result:
        return result_of(scene if times is None else replace(scene, times=times), task)

    covers, note = ("numbers", "without the states") if proved and task.states else ("all", "")
    unit = "right-hand sides" if method == "integrate" else "evaluations"
    return Trial(method, digits, compute, numbers_read, unit, thin=method == "mpmath" and task.states, own=True,
                 covers=covers, note=note)  # fmt: skip


def result_of(scene: Scene, task: Task) -> Result:
    """Run a scene and work out everything it wants, errors too."""
    with counted() as work:
        done = run_by_quadratures(scene, task.solution)
        states = {}
        if done.trajectory is not None:
            error = done.trajectory.error
            for name in done.trajectory.q:
                states[f"q.{name}"] = (np.asarray(done.trajectory.q[name]), np.asarray(error.q[name]))
                states[f"p.{name}"] = (np.asarray(done.trajectory.p[name]), np.asarray(error.p[name]))
    count = work.squares + work.kernels + work.places
    return Result(done, states, count if task.solution is not None else done.work.places)


def numbers_read(result: Result, places: Sequence[int]) -> Answer:
    """Return the values of a run, its states at the places compared.

    Args:
        result: of a run.
        places: numbers of the times compared.
    """
    numbers = dict(scalars(result.run))
    sizes = {}
    for name, (values, errors) in result.states.items():
        numbers[name] = tuple((values[k], errors[k]) for k in places)
        finite = [abs(float(v)) for v in values if np.isfinite(float(v))]
        sizes[name] = max(finite, default=0.0)
    return Answer(numbers, result.count, sizes)
