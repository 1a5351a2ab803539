"""A document as plain text: what the command line prints, and the .txt report."""

from __future__ import annotations

from itertools import zip_longest
from textwrap import fill

from hjsolve.reports.document import (
    ArgumentStep,
    Block,
    Code,
    Document,
    Figure,
    Figures,
    Formula,
    Inline,
    Mathematics,
    Note,
    Number,
    Paragraph,
    Section,
    Steps,
    Strong,
    Table,
    Text,
)
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.rounded_numbers import raised

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
    return "\n\n".join([f"{section.title}\n{'-' * len(section.title)}", *map(block_text, section.blocks)])


def block_text(block: Block) -> str:
    """Write one block.

    Args:
        block: the block.

    Returns:
        Its text; a drawing is told in words.
    """
    match block:
        case Paragraph(content):
            return wrapped(content)
        case Note(content):
            return wrapped(content, "  | ")
        case Formula():
            return _formula(block, "    ")
        case Table():
            return _table(block)
        case Steps(items):
            return "\n\n".join(_step(i, step) for i, step in enumerate(items, 1))
        case Figure():
            return wrapped(("[Figure: ", block.description, "]"), "  ")
        case Figures(items):
            return "\n".join(map(block_text, items))


def _formula(formula: Formula, indent: str) -> str:
    tag = f"    [{formula.tag}]" if formula.tag else ""
    return "\n".join(indent + line for line in plain(formula.box).splitlines()) + tag


def _step(number: int, step: ArgumentStep) -> str:
    body = wrapped((f"{number}. {step.title}. ", *step.text), "  ")
    return body + ("\n" + _formula(step.formula, "       ") if step.formula else "")


def _table(table: Table) -> str:
    cells = [[line(cell).split("\n") for cell in row] for row in (table.header, *table.rows)]
    widths = [max(len(part) for row in cells for part in row[i]) for i in range(len(table.header))]
    lines = [
        "  " + "  ".join(part.ljust(w) for part, w in zip(parts, widths)).rstrip()
        for row in cells
        for parts in zip_longest(*row, fillvalue="")
    ]
    lines.insert(1, "  " + "  ".join("-" * w for w in widths))
    return "\n".join([*([f"  {table.caption}:"] if table.caption else []), *lines])


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
    return "".join(map(_inline, content))


def _inline(piece: Inline) -> str:
    match piece:
        case str():
            return piece
        case Mathematics(box):
            return plain(box)
        case Code(words) | Strong(words):
            return words
        case Number():
            proof = " (certified)" if piece.certified else ""
            return (f"{raised(piece.value)} ± {raised(piece.error)}" if piece.error else raised(piece.value)) + proof
