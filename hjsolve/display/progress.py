"""How far something long is: a bar by rich where it is installed, else a line that is written over; nothing unseen."""

from __future__ import annotations

import importlib
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, Self, TextIO

Progress = Callable[[float, str], None]
"""Told the part that is done, 0 … 1, and in words how far that is or what runs; empty words at the end."""
_OFTEN = 0.2
"""Seconds between two lines: a terminal shows no more than a reader follows."""
_WIDTH = 24
"""Letters of the bar."""


class ProgressBar:
    """A bar on a terminal, drawn at the first report of progress, or some seconds later.

    Args:
        stays: whether the last line stays when all is done.
        shown: True or False; None: only on a terminal.
        stream: where; standard error unless given.
        after: seconds in which nothing is drawn: what is done in no time needs no bar.
    """

    def __init__(
        self, *, stays: bool = False, shown: bool | None = None, stream: TextIO | None = None, after: float = 0.0
    ) -> None:
        self._out, self._from = stream or sys.stderr, time.monotonic() + after
        self._stays, self._shown = stays, self._out.isatty() if shown is None else shown
        self._bar: _RichBar | _Line | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def __call__(self, part: float, words: str) -> None:
        """Show how far things are.

        Args:
            part: what is done, 0 … 1.
            words: how far that is, or what runs; empty at the end.
        """
        if not self._shown or (self._bar is None and time.monotonic() < self._from):
            return
        if self._bar is None:
            self._bar = _bar(self._out, part, words, stays=self._stays)
        self._bar.show(part, words)


class Tally:
    """How many orbits are done, reported to a progress bar; threads may count together.

    Args:
        total: orbits in all.
        done: orbits that were there before.
        progress: what is told.
    """

    def __init__(self, total: int, done: int, progress: Progress) -> None:
        self._total, self._done, self._progress = total, 0, progress
        self._lock = threading.Lock()
        self.add(done)

    def add(self, more: int) -> None:
        """Count orbits that were added, and tell."""
        with self._lock:
            self._done += more
            self.tell()

    def tell(self, remark: str = "") -> None:
        """Tell how far things are.

        Args:
            remark: what else there is to say.
        """
        words = f"{self._done} of {self._total} orbits"
        self._progress(self._done / max(self._total, 1), f"{words}; {remark}" if remark else words)


def duration(value: float) -> str:
    """Return a time with two digits and the unit that suits it.

    Args:
        value: seconds.
    """
    if value < 0.9995e-3:
        return f"{value * 1e6:.0f} µs"
    return f"{value * 1e3:.0f} ms" if value < 0.9995 else f"{value:.2g} s" if value < 9.95 else f"{value:.0f} s"


def _bar(out: TextIO, part: float, words: str, *, stays: bool) -> _RichBar | _Line:
    try:
        return _RichBar(out, part, words, stays=stays)
    except ImportError:
        return _Line(out, part, stays=stays)


class _RichBar:
    def __init__(self, out: TextIO, part: float, words: str, *, stays: bool) -> None:
        console, parts = importlib.import_module("rich.console"), importlib.import_module("rich.progress")
        columns = (parts.BarColumn(_WIDTH), parts.TextColumn("{task.description}"), parts.TimeRemainingColumn())
        self._bar: Any = parts.Progress(*columns, console=console.Console(file=out), transient=not stays)
        self._task = self._bar.add_task(words, total=1.0, completed=part)
        self._bar.start()

    def show(self, part: float, words: str) -> None:
        self._bar.update(self._task, completed=part, description=words)

    def close(self) -> None:
        self._bar.stop()


class _Line:
    """The bar in letters; time left by what has been done since the first line."""

    def __init__(self, out: TextIO, part: float, *, stays: bool) -> None:
        self._out, self._stays, self._first = out, stays, part
        self._begun, self._last = time.monotonic(), -_OFTEN

    def show(self, part: float, words: str) -> None:
        now = time.monotonic() - self._begun
        if now - self._last < _OFTEN and part < 1:
            return
        self._last = now
        done, rate = round(_WIDTH * part), (part - self._first) / now if now > 0 else 0.0
        left = f", {(1 - part) / rate:.0f} s left" if rate > 0 and part < 1 else ""
        bar = f"[{'#' * done}{'.' * (_WIDTH - done)}] {words} ({100 * part:.0f} %){left}"
        self._write(f"\r\x1b[2K{bar[:78]}" if words else "\r\x1b[2K")

    def close(self) -> None:
        self._write("\n" if self._stays else "\r\x1b[2K")

    def _write(self, text: str) -> None:
        self._out.write(text)
        self._out.flush()
