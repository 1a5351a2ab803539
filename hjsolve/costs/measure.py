"""Running every method, interleaved, inside a budget of seconds.

The budget is time on the clock; what a method takes is time of the processor (all of them run in one thread), so that a
busy machine does not change the comparison.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from hjsolve.costs.answers import Answer, Ruler
from hjsolve.costs.reference import SPARE, TrueValues
from hjsolve.costs.table import Row
from hjsolve.costs.trial import Task, Trial
from hjsolve.display.progress import Progress, duration
from hjsolve.errors import HJSolveError, InvalidInputError, MissingExtraError, NotConvergedError

_SAMPLE = 12
_GROWTH = 1.6


@dataclass
class TrialRecord:
    """What is known of a trial so far.

    Attributes:
        row: without times.
        clock: seconds of each run, of the processor.
        full: whether it ran for all times.
    """

    trial: Trial
    row: Row
    clock: list[float] = field(default_factory=list)
    full: bool = False


@dataclass(frozen=True)
class Clock:
    """A budget.

    Attributes:
        begun: moment of the start.
        budget: seconds.
        progress: told how much of the budget is spent, and on what.
    """

    begun: float
    budget: float
    progress: Progress | None

    @property
    def spent(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.begun

    @property
    def left(self) -> float:
        """Seconds to the end."""
        return self.budget - self.spent

    def tell(self, what: str) -> None:
        """Report what is being done.

        Args:
            what: in words.
        """
        if self.progress is not None:
            self.progress(min(1.0, self.spent / self.budget), what)


def measured(task: Task, trials: Sequence[Trial], truth: TrueValues, clock: Clock, repeats: int) -> list[Row]:
    """Run all trials once, then again in turn as often as time allows.

    Args:
        trials: the methods; the first one also gives the sizes that errors of states are relative to.
        truth: what errors are measured against.
        clock: the budget.
        repeats: timed runs at most.

    Returns:
        One row a trial, method by method; a single one for a method that cannot start.
    """
    found: list[TrialRecord] = []
    sizes: dict[str, float] = {}
    cheap = {trial.method for trial in trials} - {"mpmath", "certified"}
    for trial in sorted(trials, key=lambda trial: (trial is not trials[0], trial.method not in cheap, trial.digits)):
        clock.tell(f"{trial.method} {trial.digits:g} digits")
        before = [f for f in found if f.trial.method == trial.method]
        if before and before[-1].row.status in ("missing", "not applicable"):
            continue
        last = before[-1] if before else next((f for f in found if f.trial.own and trial.own and f.clock), None)
        found.append(_first(task, trial, truth, clock, sizes, last))
    for _ in range(repeats):
        for one in (f for f in found if f.full):
            if one.clock and statistics.median(one.clock) * 1.5 > clock.left:
                continue
            clock.tell(f"again {one.trial.method} {one.trial.digits:g} digits")
            begin = time.thread_time()
            try:
                one.trial.compute(None, time.perf_counter() + max(clock.left, 0.1))
            except HJSolveError:
                continue
            one.clock.append(time.thread_time() - begin)
    methods = list(dict.fromkeys(trial.method for trial in trials))
    return [_closed(one) for one in sorted(found, key=lambda f: (methods.index(f.trial.method), f.trial.digits))]


def _closed(one: TrialRecord) -> Row:
    """Return the row with its time: the first run warms up and counts only where there is no other."""
    if not one.clock:
        return one.row
    runs = one.clock[1:] or one.clock
    return replace(one.row, seconds=statistics.median(runs), repeats=len(runs))


def _first(
    task: Task, trial: Trial, truth: TrueValues, clock: Clock, sizes: dict[str, float], last: TrialRecord | None
) -> TrialRecord:
    """Return the first run: its answer, or why there is none."""
    empty = Row(trial.method, trial.digits, unit=trial.unit, covers=trial.covers, note=trial.note)
    allowed = max(0.0, clock.left) * 0.25
    if trial.own and trial.digits > truth.digits - SPARE:
        return TrialRecord(
            trial, replace(empty, status="too slow", note="no reference with more digits fitted the budget")
        )
    if last is not None and last.row.status == "too slow" and trial.digits > last.trial.digits:
        return TrialRecord(trial, replace(empty, status="too slow", note="as with fewer digits"))
    try:
        trial.prepare()
        if trial.thin:
            thinned = _thinned(task, trial, truth, sizes, allowed)
            if thinned is not None:
                return thinned
        expected = _expected(trial, last)
        if expected > allowed:
            note = f"would take about {duration(expected)}, more than its fraction of what was left"
            return TrialRecord(trial, replace(empty, status="too slow", note=note))
        begin = time.thread_time()
        result = trial.compute(None, time.perf_counter() + allowed)
        spent = time.thread_time() - begin
        row = _judged(empty, trial.read(result, task.places), truth, sizes)
        return TrialRecord(trial, row, [spent], True)
    except MissingExtraError as error:
        return TrialRecord(trial, replace(empty, status="missing", note=_line(error)))
    except NotConvergedError as error:
        status = "too slow" if str(error) == "out of time" else "not converged"
        note = "stopped when its part of the time was used up" if status == "too slow" else _line(error)
        return TrialRecord(trial, replace(empty, status=status, note=note))
    except (InvalidInputError, HJSolveError) as error:
        return TrialRecord(trial, replace(empty, status="not applicable", note=_line(error)))


def _expected(trial: Trial, last: TrialRecord | None) -> float:
    """Seconds the trial will take, from the one before it."""
    if last is None or not last.clock:
        return 0.0
    ratio: float = max(1.0, trial.digits / last.trial.digits)
    return last.clock[0] * ratio**_GROWTH


def _thinned(
    task: Task, trial: Trial, truth: TrueValues, sizes: dict[str, float], allowed: float
) -> TrialRecord | None:
    """Run for some of the times; None where all of them fit in the time allowed."""
    count = len(task.every)
    if count <= 2 * _SAMPLE:
        return None
    even = {round(k * (count - 1) / (_SAMPLE - 1)) for k in range(_SAMPLE)}
    places = sorted(even | set(task.places))
    one = task.some(task.places[-1:])
    trial.compute(one, float("inf"))  # warms up
    alone = _seconds(lambda: trial.compute(one, float("inf")))
    begin = time.thread_time()
    result = trial.compute(task.some(places), float("inf"))
    several = time.thread_time() - begin
    total = alone + max(0.0, several - alone) * (count - 1) / (len(places) - 1)
    if total <= allowed / 2:
        return None
    row = Row(trial.method, trial.digits, unit=trial.unit, covers=trial.covers, note=trial.note)
    row = _judged(row, trial.read(result, [places.index(place) for place in task.places]), truth, sizes)
    note = f"time for {count} times from {len(places)}"
    status = "extrapolated" if row.status == "ok" else row.status
    return TrialRecord(trial, replace(row, status=status, note=note, count=None), [total], False)


def _seconds(work: Callable[[], object]) -> float:
    begin = time.thread_time()
    work()
    return time.thread_time() - begin


def _judged(row: Row, answer: Answer, truth: TrueValues, sizes: dict[str, float]) -> Row:
    """Return the row with its errors."""
    for name, size in answer.sizes.items():
        sizes.setdefault(name, 3.141592653589793 if name in truth.turning else size)
    ruler: Ruler = truth.ruler(sizes, proved=row.method == "certified")
    worst = ruler.measure(answer.numbers)
    row = replace(row, claimed=worst.claimed, error=worst.error, held=worst.held, count=answer.count)
    if worst.error is None:
        return replace(row, note="no reference: the true error is not known")
    if worst.error >= 0.5:
        return replace(row, status="lost")
    return replace(row, status="claim broken") if worst.held is False else row


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:160]
