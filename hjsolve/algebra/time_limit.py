"""How long a computation may take: a deadline that its loops look at.

``SEARCH`` limits searches for coordinates, and for all motions between two places, by the clock on the wall. Closed
forms have a limit of their own, in processor time, that ends one form at a time (``closed_form.time_limit``).
``interrupted`` ends code that looks at no deadline, such as sympy's own algorithms and the reader of TOML, by a signal.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")
"""What a piece of work gives."""
_Deadline = tuple[float, float]
"""The value of the clock at which the work ends, and the seconds that were allowed."""


class SearchTimeError(Exception):
    """The time allowed is used up. Never leaves the search."""


class TimeLimit:
    """A deadline of the present context.

    Args:
        clock: seconds that have passed, such as ``time.monotonic``.
        error: makes the exception that ends the work, from the seconds that were allowed.
    """

    def __init__(self, clock: Callable[[], float], error: Callable[[float], Exception]) -> None:
        self._clock, self._error = clock, error
        self._deadline: ContextVar[_Deadline | None] = ContextVar("deadline", default=None)

    @contextmanager
    def within_seconds(self, seconds: float | None) -> Iterator[None]:
        """Allow what is done inside so many seconds; fewer where an outer limit ends before.

        Args:
            seconds: from now on; None for no limit.
        """
        own = None if seconds is None else (self._clock() + seconds, seconds)
        known = (deadline for deadline in (self._deadline.get(), own) if deadline is not None)
        token = self._deadline.set(min(known, default=None))
        try:
            yield
        finally:
            self._deadline.reset(token)

    def out_of_time(self) -> bool:
        """Tell whether the time is used up."""
        deadline = self._deadline.get()
        return deadline is not None and self._clock() > deadline[0]

    def check_time(self) -> None:
        """End the work where its time is used up; raises what ``error`` makes."""
        deadline = self._deadline.get()
        if deadline is not None and self._clock() > deadline[0]:
            raise self._error(deadline[1])

    def seconds_left(self, most: float) -> float:
        """Return the seconds that are left, at most so many, and none below zero."""
        deadline = self._deadline.get()
        return most if deadline is None else max(0.0, min(most, deadline[0] - self._clock()))


class TimeIsUp(BaseException):
    """Ends the work inside ``interrupted``."""


_AGAIN, _LEAST = 0.5, 0.01
"""Seconds between signals, where one was lost in a destructor, and the least that an outer timer has left."""


@contextmanager
def interrupted(seconds: float) -> Iterator[TimeIsUp]:
    """End what is done inside after so many seconds of the clock on the wall, in whatever code it runs.

    Without an interval timer (not POSIX, or not the main thread) the work runs to its end. A timer that runs already is
    put back with what it has left; where it ends sooner it is left alone.

    Args:
        seconds: from now on; infinity for no limit.

    Yields:
        The exception that ends the work: that of an outer timer is another one.
    """
    up = TimeIsUp()
    timed = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    left, interval = signal.getitimer(signal.ITIMER_REAL) if timed else (0.0, 0.0)
    if not timed or seconds == float("inf") or 0 < left <= seconds:
        yield up
        return

    def stop(*_: object) -> None:
        raise up

    before, start = signal.signal(signal.SIGALRM, stop), time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
        yield up
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if left > 0:
            signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - start), _LEAST), interval)


def in_time(seconds: float, work: Callable[[], T]) -> T | None:
    """Return what the work gives, or None where it takes longer.

    Args:
        seconds: allowed.
        work: without arguments.
    """
    up = None
    try:
        with interrupted(seconds) as up:
            return work()
    except TimeIsUp as end:
        if end is not up:
            raise
        return None


SEARCH = TimeLimit(time.monotonic, lambda seconds: SearchTimeError(f"not decided in {seconds:g} s"))
within_seconds, check_time, out_of_time = SEARCH.within_seconds, SEARCH.check_time, SEARCH.out_of_time
seconds_left = SEARCH.seconds_left
