"""What accuracy costs, as a section of a report and as a document of its own."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hjsolve.costs import Cost
from hjsolve.costs.table import cells_of
from hjsolve.errors import InvalidInputError
from hjsolve.reports import svg
from hjsolve.reports.document import Block, Code, Document, Figures, Note, Paragraph, Section, Table, Text
from hjsolve.reports.numbers import seconds
from hjsolve.reports.workprecision import figure
from hjsolve.reports.write import SUFFIXES, checked_path, replace, write_document

_ASKED = (3, 6, 9, 12, 15, 20, 30, 50, 100)


def cost_section(cost: Cost) -> Section:
    """Write the section.

    Args:
        cost: what was measured.

    Returns:
        The section: figure, the cheapest method for each accuracy, and the whole table.
    """
    states = f" at {cost.times} times" if cost.times else ""
    text: Text = (
        "The same quantities (", Code(", ".join(cost.want)), f"{states}) were computed by every method that applies, "
        f"in turn, for {cost.spent:.0f} s in all. Errors are true ones, against {cost.reference}",
        f"; states were compared at {cost.checked} of the times." if cost.checked else ".",
    )  # fmt: skip
    blocks: list[Block] = [Paragraph(text), Figures((figure(cost, "cost-figure"),))]
    cheapest = _cheapest(cost)
    blocks += [cheapest] if cheapest is not None else []
    blocks.append(_table(cost))
    note = (
        "Claimed and true errors are the worst of all numbers, relative to the size of each. An integrator claims no "
        "error: its digits are those of its tolerance. Times are medians, without the symbolic solution and without "
        "compilation."
    )
    return Section("cost", "What accuracy costs", (*blocks, Note((note,))))


def _cheapest(cost: Cost) -> Table | None:
    """The quickest method for a number of right digits: for all that is wanted, and for the parts some methods give."""
    given = {row.covers for row in cost.rows if row.answered}
    columns = [("all", "Everything"), *(c for c in (("numbers", "Numbers"), ("states", "States")) if c[0] in given)]
    rows: list[tuple[Text, ...]] = []
    for digits in _ASKED:
        found = [cost.cheapest(digits, covers) for covers, _ in columns]
        if any(found):
            cells = ("–" if best is None else f"{best.method}, {_nowrap(seconds(best.seconds or 0))}" for best in found)
            rows.append(((str(digits),), *((cell,) for cell in cells)))
    head: tuple[Text, ...] = (("Right digits",), *((name,) for _, name in columns))
    return Table(head, tuple(rows), "The cheapest way to a number of right digits") if rows else None


def _nowrap(text: str) -> str:
    return text.replace(" ", "\u00a0")


def _table(cost: Cost) -> Table:
    rows = []
    for row in cost.rows:
        cells = cells_of(row, cost.floor)
        shown = (c if k == len(cells) - 1 else _nowrap(c) for k, c in enumerate(cells))
        rows.append(tuple((Code(c),) if k in (2, 3) and c else (c,) for k, c in enumerate(shown)))
    head: tuple[Text, ...] = (
        ("Method",), ("Digits",), ("Claimed error",), ("True error",), ("Count",), ("Time",), ("Remark",)
    )  # fmt: skip
    return Table(head, tuple(rows), "Accuracy against time")


def cost_document(cost: Cost) -> Document:
    """Write a document that holds nothing else.

    Args:
        cost: what was measured.

    Returns:
        The document.
    """
    best = cost.cheapest(15) or cost.cheapest(12)
    answer: Text = ("No method reached 12 right digits.",)
    if best is not None and best.seconds is not None:
        reached = "15" if cost.cheapest(15) is best else "12"
        how = f"{best.method}: {seconds(best.seconds)}"
        answer = (f"The cheapest way to {reached} right digits of all that is wanted is {how}.",)
    return Document(cost.title, cost.id, answer, (cost_section(cost),))


def checked_cost_path(path: str | Path) -> Path:
    """Check where a table shall go, as ``checked_path``; ``.svg`` is a suffix as well.

    Raises:
        InvalidInputError: unknown suffix, or a place that cannot be written to.
    """
    target = Path(path)
    if target.suffix.lower() == ".svg":
        return target.parent / checked_path(target.with_suffix(".html")).with_suffix(target.suffix).name
    if target.suffix.lower() not in SUFFIXES:
        raise InvalidInputError(f"{target}: the suffix must be one of {', '.join(SUFFIXES)} or .svg")
    return checked_path(target)


def save_cost(cost: Cost, target: Path) -> Path:
    """Write what was measured: the figure alone (``.svg``), the rows (``.json``), or a document.

    Args:
        cost: what was measured.
        target: a path that ``checked_cost_path`` has passed.

    Returns:
        The path.
    """
    suffix = target.suffix.lower()
    if suffix == ".svg":
        replace(target, svg.standalone(figure(cost, "cost-figure").svg))
    elif suffix == ".json":
        replace(target, json.dumps(plain_rows(cost), ensure_ascii=False, indent=1, allow_nan=False) + "\n")
    else:
        write_document(cost_document(cost), target)
    return target


def plain_rows(cost: Cost) -> dict[str, Any]:
    """The table as plain data, for JSON.

    Args:
        cost: what was measured.

    Returns:
        Its attributes; what is infinite is None.
    """

    def clean(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: clean(item) for key, item in value.items()}
        if isinstance(value, (list, tuple)):
            return [clean(item) for item in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    result: dict[str, Any] = clean(asdict(cost))
    return result
