"""The command ``hjsolve cost``: what accuracy costs in time, with a bar while it runs."""

from __future__ import annotations

import re
import sys
from argparse import Namespace
from collections.abc import Callable
from typing import Any

from hjsolve.errors import InvalidInputError

_WIDTH = 24


def measure_and_print(options: Namespace, subject: Any) -> None:
    """Measure, print the table, write what is asked.

    Args:
        options: the parsed arguments.
        subject: a scene file, an entry's file or a catalog id.

    Raises:
        InvalidInputError: digits, seconds or the output make no sense.
    """
    from hjsolve.costs import cost as measured
    from hjsolve.reports.write_cost import checked_cost_path, save_cost

    target = None if options.output is None else checked_cost_path(options.output)
    table = measured(
        subject, motion=options.motion, digits=_levels(options.digits), seconds=options.seconds,
        rivals=not options.no_rivals, progress=progress_bar(),
    )  # fmt: skip
    sys.stdout.write(f"{table.title}\n\n{table.text}\n")
    if target is not None:
        sys.stdout.write(f"\nwrote {save_cost(table, target)}\n")


def _levels(text: str | None) -> list[int] | None:
    if text is None:
        return None
    if not re.fullmatch(r"\d{1,4}(,\d{1,4})*", text.replace(" ", "")):
        raise InvalidInputError(f'--digits "{text}": write whole numbers with commas between them, e.g. 20,30,50')
    return [int(part) for part in text.split(",")]


def progress_bar() -> Callable[[float, str], None] | None:
    """Make a bar on the terminal.

    Returns:
        (part of the time, what is running) ↦ nothing; None where messages do not go to a terminal.
    """
    if not sys.stderr.isatty():
        return None

    def show(part: float, what: str) -> None:
        done = round(_WIDTH * part)
        bar = f"[{'#' * done}{'.' * (_WIDTH - done)}] {what}"[:78] if what else ""
        sys.stderr.write(f"\r\x1b[2K{bar}")
        sys.stderr.flush()

    return show
