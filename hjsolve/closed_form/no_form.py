"""The exception inside this room: an integral that has no form here, and why."""

from __future__ import annotations

from hjsolve.closed_form.why_not import NotFound, WhyNot


class NoFormError(Exception):
    """These functions do not hold the integral. Never leaves the room.

    Args:
        why: the reason; of a text, that nothing was found.
    """

    def __init__(self, why: WhyNot | str):
        super().__init__(str(why))
        self.why = NotFound(why) if isinstance(why, str) else why
