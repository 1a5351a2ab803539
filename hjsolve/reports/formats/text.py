"""A document as plain text: what the command line prints, and the .txt report."""

from __future__ import annotations

from itertools import zip_longest
from textwrap import fill

from hjsolve.arithmetic.printed_digits import raised
from hjsolve.reports.document import ArgumentStep, Document, Figure, Formula, Section, Steps, Table, Text
from hjsolve.reports.formats.block_writer import BlockWriter, PieceWriter
from hjsolve.reports.formulas.layout import Box
from hjsolve.reports.formulas.one_line_text import plain

_WIDTH = 96


def text_page(document: Document) -> str:
    """Write a document as text.

    Args:
        document: the document.

    Returns:
        The whole text, lines of at most 96 letters except where a formula is longer.
    """
    title = f"{document.title}  [{document.subtitle}]" if document.subtitle else document.title
    head = f"{title}\n{'=' * len(title)}\n\n{wrapped((document.sign, *document.answer))}"
    return "\n\n".join([head, *(part for part in map(section_text, document.sections) if part)]) + "\n"


def section_text(section: Section) -> str:
    """Write one section.

    Args:
        section: the section.

    Returns:
        Its title, underlined, and its text.
    """
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
        widths = [max(len(part) for row in cells for part in row[i]) for i in range(len(table.header))]
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

    def digits(self, text: str) -> str:
        return raised(text)


def _formula(formula: Formula, indent: str) -> str:
    tag = f"    [{formula.tag}]" if formula.tag else ""
    return "\n".join(indent + line for line in plain(formula.box).splitlines()) + tag


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
    """Write a sentence in one line.

    Args:
        content: the sentence in pieces.

    Returns:
        The line.
    """
    return _WRITER.text(content)


_WRITER = _TextWriter()
