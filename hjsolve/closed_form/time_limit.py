"""How long a derivation may take: a deadline that every step looks at, and the reason that is given where it passed."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from hjsolve.closed_form.no_form import NoFormError

_Deadline = tuple[float, float]
"""The processor time at which work ends, and the seconds that were allowed."""
_DEADLINE: ContextVar[_Deadline | None] = ContextVar("deadline", default=None)


class OutOfTimeError(NoFormError):
    """The time allowed is used up. Never leaves the room."""


@contextmanager
def within_seconds(seconds: float | None) -> Iterator[None]:
    """Allow what is done inside so many seconds of processor time; less where an outer limit ends before.

    Args:
        seconds: from now on; None for no limit.
    """
    outer = _DEADLINE.get()
    own = None if seconds is None else (time.process_time() + seconds, seconds)
    token = _DEADLINE.set(min((d for d in (outer, own) if d is not None), default=None))
    try:
        yield
    finally:
        _DEADLINE.reset(token)


def check_time() -> None:
    """End the derivation where its time is used up.

    Raises:
        OutOfTimeError: it is; the text is what ``why_not`` says.
    """
    deadline = _DEADLINE.get()
    if deadline is not None and time.process_time() > deadline[0]:
        raise OutOfTimeError(f"the derivation took longer than {deadline[1]:g} s")


def out_of_time() -> bool:
    """Whether the time is used up."""
    deadline = _DEADLINE.get()
    return deadline is not None and time.process_time() > deadline[0]
