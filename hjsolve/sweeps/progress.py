"""How far a sweep is: a bar by rich where it is installed, a plain line else, nothing where nobody looks."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import TextIO

Advance = Callable[[int], None]
_OFTEN = 0.2


@contextlib.contextmanager
def sweep_progress(
    total: int, done: int, *, shown: bool | None = None, stream: TextIO | None = None
) -> Iterator[Advance]:
    """Show progress while the block runs.

    Args:
        total: orbits in all.
        done: orbits that were there before.
        shown: True or False; None: only on a terminal.
        stream: where; standard error unless given.

    Yields:
        A function to be told how many orbits were added.
    """
    out = stream or sys.stderr
    if not (out.isatty() if shown is None else shown):
        yield lambda _: None
        return
    try:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
    except ImportError:
        with _plain(total, done, out) as advance:
            yield advance
        return
    columns = (TextColumn("orbits"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(file=out)) as bar:
        task = bar.add_task("orbits", total=total, completed=done)
        yield lambda more: bar.advance(task, more)


@contextlib.contextmanager
def _plain(total: int, done: int, out: TextIO) -> Iterator[Advance]:
    begun, before, last = time.monotonic(), done, 0.0
    count = done

    def line() -> str:
        seconds = time.monotonic() - begun
        rate = (count - before) / seconds if seconds > 0 else 0.0
        left = f", {(total - count) / rate:.0f} s left" if rate else ""
        return f"\r{count} of {total} orbits ({100 * count // max(total, 1)} %){left}   "

    def advance(more: int) -> None:
        nonlocal count, last
        count += more
        if time.monotonic() - last >= _OFTEN or count == total:
            last = time.monotonic()
            out.write(line())
            out.flush()

    out.write(line())
    try:
        yield advance
    finally:
        out.write("\n")
        out.flush()
