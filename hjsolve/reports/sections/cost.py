"""What accuracy costs, as a section of a report and as a document of its own."""

from __future__ import annotations

import math
from dataclasses import asdict
from dataclasses import replace as replace_fields
from typing import TypeAlias

from hjsolve.costs import Cost, cost
from hjsolve.costs.table import cells_of
from hjsolve.display.progress import Progress, duration
from hjsolve.errors import HJSolveError, InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Block, Code, Document, Figures, Note, Paragraph, Section, Table, Text
from hjsolve.reports.drawings.work_precision import figure
from hjsolve.scenes import Scene

Wish: TypeAlias = bool | float
IN_A_REPORT, MOST_IN_A_REPORT = 3.0, 10.0
"""Seconds that the section of a report may take: by default, and at most."""
_IN_A_REPORT_DIGITS = (20, 30, 50)
_ASKED = (3, 6, 9, 12, 15, 20, 30, 50, 100)


def cost_section(table: Cost) -> Section:
    """Write the section.

    Returns:
        The section: figure, the cheapest method for each accuracy, and the whole table.
    """
    states = f" at {table.times} times" if table.times else ""
    text: Text = (
        "The same quantities (", Code(", ".join(table.want)), f"{states}) were computed by every method that applies, "
        f"in turn, within a budget of {table.budget:.3g} s. ", _against(table),
    )  # fmt: skip
    known = any(row.answered and row.error is not None for row in table.rows)
    blocks: list[Block] = [Paragraph(text), *([Figures((figure(table, "cost-figure"),))] if known else [])]
    cheapest = _cheapest(table)
    blocks += [cheapest] if cheapest is not None else []
    blocks.append(_table(table))
    note = (
        "Claimed and true errors are the largest of all results, relative to the size of each. An integrator claims no "
        "error; its digits are those of its tolerance. Times are processor time, medians, without the symbolic "
        "solution and without compilation."
    )
    return Section("cost", "What accuracy costs", (*blocks, Note((note,))))


def _against(table: Cost) -> str:
    """Return what the errors were measured against."""
    if not table.reference:
        return (
            "No reference with more digits could be computed in that time, so no true errors are known; `hjsolve cost` "
            "takes a longer one."
        )
    states = f"; states were compared at {table.checked} of the times" if table.checked else ""
    return f"Errors are true ones, against {table.reference}{states}."


def _cheapest(table: Cost) -> Table | None:
    """Return the quickest method for a number of right digits.

    For all that is wanted, and for the parts some methods give.
    """
    given = {row.covers for row in table.rows if row.answered}
    columns = [("all", "Everything"), *(c for c in (("numbers", "Numbers"), ("states", "States")) if c[0] in given)]
    rows: list[tuple[Text, ...]] = []
    for digits in _ASKED:
        found = [table.cheapest(digits, covers) for covers, _ in columns]
        if any(found):
            cells = (
                "–" if best is None else f"{best.method}, {_nowrap(duration(best.seconds or 0))}" for best in found
            )
            rows.append(((str(digits),), *((cell,) for cell in cells)))
    head: tuple[Text, ...] = (("Correct digits",), *((name,) for _, name in columns))
    return Table(head, tuple(rows), "The fastest method for a number of correct digits") if rows else None


def _nowrap(text: str) -> str:
    return text.replace(" ", "\u00a0")


def _table(table: Cost) -> Table:
    rows = []
    for row in table.rows:
        cells = cells_of(row, table.floor)
        shown = (c if k == len(cells) - 1 else _nowrap(c) for k, c in enumerate(cells))
        rows.append(tuple((Code(c),) if k in (2, 3) and c else (c,) for k, c in enumerate(shown)))
    head: tuple[Text, ...] = (
        ("Method",), ("Digits",), ("Claimed error",), ("True error",), ("Count",), ("Time",), ("Remark",)
    )  # fmt: skip
    return Table(head, tuple(rows), "Accuracy against time")


def with_cost(document: Document, subject: Motion | Scene, wish: Wish, progress: Progress | None = None) -> Document:
    """Add the section to a report, just before the last one.

    Args:
        document: the report.
        subject: the motion or scene it is about.
        wish: whether the section is wanted, or the seconds it may take (at most 10).
        progress: as in ``hjsolve.cost``.

    Returns:
        The report with the section; as it was where it is not wanted.

    Raises:
        InvalidInputError: the seconds make no sense.
    """
    seconds = IN_A_REPORT if wish is True else wish
    if seconds is False:
        return document
    if not 0 < seconds <= MOST_IN_A_REPORT:
        raise InvalidInputError(f"cost: True, False, or seconds up to {MOST_IN_A_REPORT:g} are needed, not {wish!r}")
    try:
        table = cost(subject, seconds=seconds, digits=_IN_A_REPORT_DIGITS, repeats=3, progress=progress)
    except HJSolveError as error:
        words = " ".join(str(error).split())
        section = Section("cost", "What accuracy costs", (Note((f"This could not be measured: {words}",)),))
    else:
        section = cost_section(table)
    return replace_fields(document, sections=(*document.sections[:-1], section, *document.sections[-1:]))


def cost_document(table: Cost) -> Document:
    """Write a document that holds nothing else."""
    best = table.cheapest(15) or table.cheapest(12)
    answer: Text = ("No method reached 12 correct digits.",)
    if best is not None and best.seconds is not None:
        reached = "15" if table.cheapest(15) is best else "12"
        how = f"{best.method}: {duration(best.seconds)}"
        answer = (f"The fastest method with {reached} correct digits in every result is {how}.",)
    return Document(table.title, table.id, answer, (cost_section(table),))


def plain_rows(table: Cost) -> dict[str, object]:
    """Return the table as plain data, for JSON.

    Returns:
        Its attributes; what is infinite is None.
    """

    def clean(value: object) -> object:
        if isinstance(value, dict):
            return {key: clean(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [clean(item) for item in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return {key: clean(item) for key, item in asdict(table).items()}
