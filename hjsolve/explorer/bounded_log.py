"""A bound on what the explorer's libraries write to its log: an event that a page forges costs a traceback each."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable

LOGGERS = ("nicegui", "asyncio", "socketio.server", "engineio.server", "uvicorn.error")
"""Who speaks of events that no page of ours sends."""
MOST_MESSAGES = 10
_MINUTE = 60.0
_LONGEST = 2000


class BoundedLog(logging.Filter):
    """Let a number of messages pass a minute, of all loggers together, and say once that the rest is left out.

    Args:
        most: messages a minute.
        clock: seconds that have passed.
    """

    def __init__(self, most: int = MOST_MESSAGES, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._most, self._clock = most, clock
        self._lock = threading.Lock()
        self._begun, self._count = clock(), 0

    def filter(self, record: logging.LogRecord) -> bool:
        """Decide about one message; the first one too many becomes the sentence that says so."""
        with self._lock:
            now = self._clock()
            if now - self._begun >= _MINUTE:
                self._begun, self._count = now, 0
            self._count += 1
            count = self._count
        if count > self._most + 1:
            return False
        if count == self._most + 1:
            _say(record, f"more than {self._most} messages in a minute; the others of this minute are left out")
        elif len(text := record.getMessage()) > _LONGEST:
            _say(record, f"{text[:_LONGEST]}… ({len(text) - _LONGEST} more characters)")
        return True


def _say(record: logging.LogRecord, text: str) -> None:
    record.msg, record.args, record.exc_info, record.exc_text, record.stack_info = text, (), None, None, None


def bound_logs(names: Iterable[str] = LOGGERS) -> BoundedLog:
    """Bound some loggers together."""
    bounded = BoundedLog()
    for name in names:
        logging.getLogger(name).addFilter(bounded)
    return bounded
