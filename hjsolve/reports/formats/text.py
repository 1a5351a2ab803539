"""A document as plain text: what the command line prints, and the .txt report."""

from __future__ import annotations

import re
from itertools import zip_longest
from textwrap import fill, wrap

from hjsolve.reports.document import ArgumentStep, Document, Figure, Formula, Section, Steps, Table, Text
from hjsolve.reports.formats.block_writer import BlockWriter, PieceWriter
from hjsolve.reports.formulas.layout import Box
from hjsolve.reports.formulas.one_line_text import plain

_WIDTH = 96
_WIDEST = 100
"""Columns of a line; a formula or a table that needs more is broken."""
_BREAKS = re.compile(r",  ?| (?=[+−=])|(?<=[)]) (?=[(√])|; ")
"""Where a line of a formula may end."""


def text_page(document: Document) -> str:
    """Write a document as text.

    Returns:
        The whole text, lines of at most 100 letters except where a formula has no place to break it.
    """
    title = f"{document.title}  [{document.subtitle}]" if document.subtitle else document.title
    head = f"{title}\n{'=' * len(title)}\n\n{wrapped((document.sign, *document.answer))}"
    return "\n\n".join([head, *(part for part in map(section_text, document.sections) if part)]) + "\n"


def section_text(section: Section) -> str:
    """Write one section."""
    return "\n\n".join([f"{section.title}\n{'-' * len(section.title)}", *map(_WRITER.block, section.blocks)])


class _TextWriter(PieceWriter, BlockWriter[str]):
    def paragraph(self, text: Text) -> str:
        return wrapped(text)

    def note(self, text: Text) -> str:
        return wrapped(text, "  | ")

    def formula(self, formula: Formula) -> str:
        return _formula(formula, "    ")

    def steps(self, steps: Steps) -> str:
        return "\n\n".join(_step(i, step) for i, step in enumerate(steps.items, 1))

    def table(self, table: Table) -> str:
        cells = [[line(cell).split("\n") for cell in row] for row in (table.header, *table.rows)]
        cells = _narrowed(cells)
        widths = _widths(cells)
        lines = [
            "  " + "  ".join(part.ljust(w) for part, w in zip(parts, widths)).rstrip()
            for row in cells
            for parts in zip_longest(*row, fillvalue="")
        ]
        lines.insert(1, "  " + "  ".join("-" * w for w in widths))
        return "\n".join([*([f"  {table.caption}:"] if table.caption else []), *lines])

    def figure(self, figure: Figure) -> str:
        return wrapped(("[Figure: ", figure.description, "]"), "  ")

    def figures(self, figures: tuple[Figure, ...]) -> str:
        return "\n".join(map(self.figure, figures))

    def words(self, text: str) -> str:
        return text

    def mathematics(self, box: Box) -> str:
        return plain(box)

    def code(self, text: str) -> str:
        return text

    def strong(self, text: str) -> str:
        return text


def _widths(cells: list[list[list[str]]]) -> list[int]:
    """Return the letters of each column of a table."""
    return [max(len(part) for row in cells for part in row[i]) for i in range(len(cells[0]))]


def _narrowed(cells: list[list[list[str]]]) -> list[list[list[str]]]:
    """Break the cells of the widest column, as often as it takes, until the table fits a line."""
    for _ in range(4 * len(cells[0])):
        widths = _widths(cells)
        over = 2 * len(widths) + sum(widths) - _WIDEST
        if over <= 0:
            break
        i = max(range(len(widths)), key=widths.__getitem__)
        room = max(widths[i] - over, widths[i] * 2 // 3, 16)
        for row in cells:
            broken = [wrap(part, room, break_long_words=False, break_on_hyphens=False) or [""] for part in row[i]]
            row[i] = [part for parts in broken for part in parts]
    return cells


def _broken(text: str, indent: str) -> list[str]:
    """Break a line of a formula where it is longer than a page is wide."""
    lines = []
    while len(text) > _WIDEST:
        places = [match.end() for match in _BREAKS.finditer(text, len(indent) + 8, _WIDEST)]
        if not places:
            break
        lines.append(text[: places[-1]].rstrip())
        text = f"{indent}      {text[places[-1] :]}"
    return [*lines, text]


def _formula(formula: Formula, indent: str) -> str:
    lines = [part for line in plain(formula.box).splitlines() for part in _broken(indent + line, indent)]
    if formula.tag:
        tag = f"    [{formula.tag}]"
        if len(lines[-1]) + len(tag) <= _WIDEST:
            lines[-1] += tag
        else:
            lines.append(tag.rjust(_WIDEST))
    return "\n".join(lines)


def _step(number: int, step: ArgumentStep) -> str:
    body = wrapped((f"{number}. {step.title}. ", *step.text), "  ")
    return body + ("\n" + _formula(step.formula, "       ") if step.formula else "")


def wrapped(content: Text, indent: str = "") -> str:
    """Write a sentence in lines.

    Args:
        content: the sentence in pieces.
        indent: put before each line.

    Returns:
        The lines.
    """
    return fill(
        line(content),
        _WIDTH,
        initial_indent=indent,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def line(content: Text) -> str:
    """Write a sentence in one line."""
    return _WRITER.text(content)


_WRITER = _TextWriter()
