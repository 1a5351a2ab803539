"""A document as one Markdown file: formulas between dollar signs, drawings as embedded images, tables as pipes."""

from __future__ import annotations

from base64 import b64encode

from hjsolve.reports.document import ArgumentStep, Document, Figure, Formula, Section, Steps, Table, Text
from hjsolve.reports.document.drawing_style import standalone
from hjsolve.reports.formats.block_writer import BlockWriter, PieceWriter
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.formulas.layout import Box

_SPECIAL = str.maketrans({letter: f"\\{letter}" for letter in "\\`*_[]<>|$#"})


def markdown_page(document: Document) -> str:
    """Write a document as Markdown.

    Returns:
        The whole file, for readers that know ``$…$`` (GitHub, Pandoc, Jupyter, most editors).
    """
    head = [f"# {_plain(document.title)}"]
    if document.subtitle:
        head.append(f"`{document.subtitle}`")
    head.append(f"> {document.sign}{_WRITER.text(document.answer)}")
    return "\n\n".join([*head, *map(_section, document.sections)]) + "\n"


def _section(section: Section) -> str:
    return "\n\n".join([f"## {_plain(section.title)}", *map(_WRITER.block, section.blocks)])


class _MarkdownWriter(PieceWriter, BlockWriter[str]):
    def paragraph(self, text: Text) -> str:
        return self.text(text)

    def note(self, text: Text) -> str:
        return f"> {self.text(text)}"

    def formula(self, formula: Formula) -> str:
        tag = rf" \qquad \text{{{formula.tag}}}" if formula.tag else ""
        return f"$$\n{latex_of(formula.box)}{tag}\n$$"

    def steps(self, steps: Steps) -> str:
        return "\n".join(self._step(i, step) for i, step in enumerate(steps.items, 1))

    def _step(self, number: int, step: ArgumentStep) -> str:
        body = f"{number}. **{_plain(step.title)}.** {self.text(step.text)}"
        if step.formula is None:
            return body
        return body + "\n\n" + "\n".join("   " + line for line in self.formula(step.formula).splitlines()) + "\n"

    def table(self, table: Table) -> str:
        lines = [self._row(table.header), "|" + "---|" * len(table.header), *map(self._row, table.rows)]
        caption = [f"*{_plain(table.caption)}*", ""] if table.caption else []
        return "\n".join([*caption, *lines])

    def _row(self, cells: tuple[Text, ...]) -> str:
        return f"| {' | '.join(map(self._cell, cells))} |"

    def _cell(self, cell: Text) -> str:
        line = self.text(cell).replace("\n", " ")
        return line.replace(r"\left|", r"\left\vert ").replace(r"\right|", r"\right\vert ")

    def figure(self, figure: Figure) -> str:
        image = b64encode(standalone(figure.svg).encode()).decode()
        return f"![{_plain(figure.description)}](data:image/svg+xml;base64,{image})\n\n*{self.text(figure.caption)}*"

    def figures(self, figures: tuple[Figure, ...]) -> str:
        return "\n\n".join(map(self.figure, figures))

    def words(self, text: str) -> str:
        return _plain(text)

    def mathematics(self, box: Box) -> str:
        return f"${latex_of(box)}$"

    def code(self, text: str) -> str:
        return f"`{text}`"

    def strong(self, text: str) -> str:
        return f"**{_plain(text)}**"


def _plain(text: str) -> str:
    return text.translate(_SPECIAL)


_WRITER = _MarkdownWriter()
