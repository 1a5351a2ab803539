"""How long a search may take, by the clock on the wall: one deadline that its loops look at.

Closed forms have a deadline of their own (``closed_form.time_limit``), in processor time, that ends one form at a time.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_Deadline = tuple[float, float]
"""The value of the monotonic clock at which the search ends, and the seconds that were allowed."""
_DEADLINE: ContextVar[_Deadline | None] = ContextVar("deadline", default=None)


class SearchTimeError(Exception):
    """The time allowed is used up. Never leaves the search."""


@contextmanager
def within_seconds(seconds: float) -> Iterator[None]:
    """Allow what is done inside so many seconds; fewer where an outer limit ends before.

    Args:
        seconds: from now on.
    """
    outer, own = _DEADLINE.get(), (time.monotonic() + seconds, seconds)
    token = _DEADLINE.set(own if outer is None else min(outer, own))
    try:
        yield
    finally:
        _DEADLINE.reset(token)


def check_time() -> None:
    """End the search where its time is used up.

    Raises:
        SearchTimeError: it is.
    """
    deadline = _DEADLINE.get()
    if deadline is not None and time.monotonic() > deadline[0]:
        raise SearchTimeError(f"not decided in {deadline[1]:g} s")


def seconds_left(most: float) -> float:
    """Return the seconds that are left, at most so many, and none below zero.

    Args:
        most: seconds.
    """
    deadline = _DEADLINE.get()
    return most if deadline is None else max(0.0, min(most, deadline[0] - time.monotonic()))
