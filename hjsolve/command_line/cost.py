"""The command ``hjsolve cost``: what accuracy costs in time, with a bar while it runs."""

from __future__ import annotations

import re
import sys
from argparse import Namespace
from typing import TYPE_CHECKING

from hjsolve.display.progress import ProgressBar
from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    from hjsolve.costs.subject import Subject


def measure_and_print(options: Namespace, subject: Subject) -> None:
    """Measure, print the table, write what is asked.

    Args:
        subject: a scene file, an entry's file or a catalog id.

    Raises:
        InvalidInputError: digits, seconds or the output make no sense.
    """
    from hjsolve.costs import cost as measured
    from hjsolve.reports.write_cost import checked_cost_path, save_cost

    target = None if options.output is None else checked_cost_path(options.output)
    with ProgressBar() as progress:
        table = measured(
            subject, motion=options.motion, digits=_levels(options.digits), seconds=options.seconds,
            rivals=not options.no_rivals, progress=progress,
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
