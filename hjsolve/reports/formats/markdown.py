"""A document as one Markdown file: formulas between dollar signs, drawings as embedded images, tables as pipes."""

from __future__ import annotations

from base64 import b64encode

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
from hjsolve.reports.drawings.svg import standalone
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.sections.rounded_numbers import raised

_SPECIAL = str.maketrans({letter: f"\\{letter}" for letter in "\\`*_[]<>|$#"})


def markdown_page(document: Document) -> str:
    """Write a document as Markdown.

    Args:
        document: the document.

    Returns:
        The whole file, for readers that know ``$…$`` (GitHub, Pandoc, Jupyter, most editors).
    """
    head = [f"# {_plain(document.title)}"]
    if document.subtitle:
        head.append(f"`{document.subtitle}`")
    head.append(f"> {document.sign}{_text(document.answer)}")
    return "\n\n".join([*head, *map(_section, document.sections)]) + "\n"


def _section(section: Section) -> str:
    return "\n\n".join([f"## {_plain(section.title)}", *map(_block, section.blocks)])


def _block(block: Block) -> str:
    match block:
        case Paragraph(text):
            return _text(text)
        case Note(text):
            return f"> {_text(text)}"
        case Formula():
            return _formula(block)
        case Table():
            return _table(block)
        case Steps(items):
            return "\n".join(_step(i, step) for i, step in enumerate(items, 1))
        case Figure():
            return _figure(block)
        case Figures(items):
            return "\n\n".join(map(_figure, items))


def _formula(formula: Formula) -> str:
    tag = rf" \qquad \text{{{formula.tag}}}" if formula.tag else ""
    return f"$$\n{latex_of(formula.box)}{tag}\n$$"


def _step(number: int, step: ArgumentStep) -> str:
    body = f"{number}. **{_plain(step.title)}.** {_text(step.text)}"
    if step.formula is None:
        return body
    return body + "\n\n" + "\n".join("   " + line for line in _formula(step.formula).splitlines()) + "\n"


def _table(table: Table) -> str:
    lines = [_row(table.header), "|" + "---|" * len(table.header), *map(_row, table.rows)]
    caption = [f"*{_plain(table.caption)}*", ""] if table.caption else []
    return "\n".join([*caption, *lines])


def _row(cells: tuple[Text, ...]) -> str:
    return (
        "| "
        + " | ".join(
            _text(cell).replace("\n", " ").replace(r"\left|", r"\left\vert ").replace(r"\right|", r"\right\vert ")
            for cell in cells
        )
        + " |"
    )


def _figure(figure: Figure) -> str:
    image = b64encode(standalone(figure.svg).encode()).decode()
    return f"![{_plain(figure.description)}](data:image/svg+xml;base64,{image})\n\n*{_text(figure.caption)}*"


def _text(text: Text) -> str:
    return "".join(map(_inline, text))


def _inline(piece: Inline) -> str:
    match piece:
        case str():
            return _plain(piece)
        case Mathematics(box):
            return f"${latex_of(box)}$"
        case Code(text):
            return f"`{text}`"
        case Strong(text):
            return f"**{_plain(text)}**"
        case Number():
            proof = " (certified)" if piece.certified else ""
            return (f"{raised(piece.value)} ± {raised(piece.error)}" if piece.error else raised(piece.value)) + proof


def _plain(text: str) -> str:
    return text.translate(_SPECIAL)
