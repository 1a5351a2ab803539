"""How long a computation may take: a deadline that its loops look at.

``SEARCH`` limits searches for coordinates by the clock on the wall. Closed forms have a limit of their own, in
processor time, that ends one form at a time (``closed_form.time_limit``).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

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
        """Return the seconds that are left, at most so many, and none below zero.

        Args:
            most: seconds.
        """
        deadline = self._deadline.get()
        return most if deadline is None else max(0.0, min(most, deadline[0] - self._clock()))


SEARCH = TimeLimit(time.monotonic, lambda seconds: SearchTimeError(f"not decided in {seconds:g} s"))
within_seconds, check_time, seconds_left = SEARCH.within_seconds, SEARCH.check_time, SEARCH.seconds_left
