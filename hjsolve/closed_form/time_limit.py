"""How long a derivation may take, in processor time of its thread, and the reason given where it took longer."""

from __future__ import annotations

import time

from hjsolve.algebra.time_limit import TimeLimit
from hjsolve.closed_form.no_form import NoFormError


class OutOfTimeError(NoFormError):
    """The time allowed is used up; the text is what ``why_not`` says. Never leaves the room."""


DERIVATION = TimeLimit(
    time.thread_time, lambda seconds: OutOfTimeError(f"the derivation took longer than {seconds:g} s")
)
within_seconds, check_time, out_of_time = DERIVATION.within_seconds, DERIVATION.check_time, DERIVATION.out_of_time
