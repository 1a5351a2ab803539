"""A hard limit on the time of a part of a command, in whatever code it runs.

The exact arithmetic and the search for coordinates look at a budget of their own; sympy and the reader of TOML do not,
and are ended by a signal (``algebra.time_limit.interrupted``).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hjsolve import arguments
from hjsolve.algebra.time_limit import TimeIsUp, interrupted
from hjsolve.errors import NotConvergedError

_GRACE = 1.0
"""Seconds for the budgets inside to end by themselves."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Allow what is done inside so many seconds, and one more.

    Args:
        seconds: from now on.

    Raises:
        NotConvergedError: they are used up.
        InvalidInputError: no number of seconds.
    """
    try:
        with interrupted(arguments.seconds(seconds, "--budget") + _GRACE):
            yield
    except TimeIsUp:
        raise NotConvergedError(
            f"not decided in {seconds:g} s; give more time with --budget, or write T and V in a simpler form"
        ) from None
