"""A limit on the time of sympy's own algorithms, which know no budget.

Where the system has an interval timer (POSIX, main thread) its signal ends the work; elsewhere the work runs to its
end, and only the length of what is given to it is bounded by the caller. A timer that runs already, as that of the
command line, is put back with what is left of it.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
"""What the work gives."""
_LEAST = 0.01


class _TimeIsUp(BaseException):
    """Ends the work; no ``except`` clause of sympy takes it for a fault of its own."""


def within_seconds(seconds: float, work: Callable[[], T]) -> T | None:
    """Return what the work gives, or None where it takes longer.

    Args:
        seconds: allowed.
        work: without arguments.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        return work()
    left, interval = signal.getitimer(signal.ITIMER_REAL)
    if 0 < left <= seconds:
        return work()  # the timer that runs ends it sooner
    up = _TimeIsUp()

    def stop(*_: object) -> None:
        raise up

    before, start = signal.signal(signal.SIGALRM, stop), time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, seconds)
        return work()
    except _TimeIsUp as end:
        if end is not up:
            raise
        return None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if left > 0:
            signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - start), _LEAST), interval)


__all__ = ["within_seconds"]
