"""A hard limit on the time of a part of a command, in whatever code it runs.

The exact arithmetic and the search for coordinates look at a budget of their own; sympy and the reader of TOML do not.
Where the system has an interval timer (POSIX, main thread), its signal ends those too.
"""

from __future__ import annotations

import math
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from hjsolve import arguments
from hjsolve.errors import NotConvergedError

_GRACE, _AGAIN = 1.0, 0.5
"""Seconds for the budgets inside to end by themselves, and between signals where one was lost in a destructor."""


class _TimeIsUp(BaseException):
    """Ends the work; no ``except`` clause of the library takes it for a fault of its own."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Allow what is done inside so many seconds, and one more.

    Args:
        seconds: from now on.

    Raises:
        NotConvergedError: they are used up.
        InvalidInputError: no number of seconds.
    """
    allowed = arguments.seconds(seconds, "--budget")
    has_timer = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
    if allowed == math.inf or not has_timer:
        yield
        return

    def stop(*_: object) -> None:
        raise _TimeIsUp

    before = signal.signal(signal.SIGALRM, stop)
    try:
        signal.setitimer(signal.ITIMER_REAL, allowed + _GRACE, _AGAIN)
        yield
    except _TimeIsUp:
        raise NotConvergedError(
            f"not decided in {seconds:g} s; give more time with --budget, or write T and V in a simpler form"
        ) from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


__all__ = ["within"]
