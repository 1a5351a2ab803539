"""How long the search for an end of the motion, or the integrals towards one, may take: processor time of the thread.

Results never depend on it: what is not decided in time is an error, and nothing of it is kept.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from hjsolve.errors import NotConvergedError

SECONDS = 30.0
"""At 15 digits; more digits have more, as their square."""


class TooSlowError(NotConvergedError):
    """The branch to infinity, or to another end, was not decided in the time allowed."""


def stopwatch(digits: int, clock: Callable[[], float] = time.thread_time) -> Callable[[Callable[[], str]], None]:
    """Return a check that raises once the time is used up, counted from now.

    Args:
        clock: seconds that have passed.

    Returns:
        (rule that says what is sought) ↦ None; raises ``TooSlowError``.
    """
    allowed = SECONDS * max(1.0, digits / 15) ** 2
    begun = clock()

    def check(sought: Callable[[], str]) -> None:
        if clock() - begun > allowed:
            raise TooSlowError(f"not decided in {allowed:g} s of the processor: {sought()}")

    return check
