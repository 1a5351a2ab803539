"""A document as one self-contained HTML file: MathML formulas, inline SVG drawings, no script, nothing fetched."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape

from hjsolve.reports.document import (
    ArgumentStep,
    Block,
    Document,
    Figure,
    Formula,
    Inline,
    Mathematics,
    Number,
    Section,
    Steps,
    Table,
    Text,
)
from hjsolve.reports.document.drawing_style import STYLE
from hjsolve.reports.formats.block_writer import BlockWriter, PieceWriter
from hjsolve.reports.formats.stylesheet import CSS
from hjsolve.reports.formats.text import line
from hjsolve.reports.formulas.in_words import formulas_in_words
from hjsolve.reports.formulas.layout import Box, width
from hjsolve.reports.formulas.line_breaks import LINE, NARROW, narrowed
from hjsolve.reports.formulas.mathml import mathml_of

_FULL, _CLOSING = 1.05, tuple(",.;:)")
_NUMBER_OF_EQUATION = re.compile(r"(?:Greenwood )?\(\d+-\d+\)")
_MOST_ROWS_UNBROKEN, _SIDE_BY_SIDE = 8, 2
_REACHED = 'tabindex="0" role="group"'


def html_page(document: Document) -> str:
    """Write a document as HTML.

    Returns:
        The whole file; valid as HTML and well-formed as XML after the first line.
    """
    title = escape(document.title)
    entries = "".join(f'<li><a href="#{s.key}">{escape(s.title)}</a></li>' for s in document.sections)
    subtitle = f'<p class="id"><code>{escape(document.subtitle)}</code></p>' if document.subtitle else ""
    sign = f'<span class="sign" aria-hidden="true">{document.sign}</span>' if document.sign else ""
    sections = "\n".join(_section(section) for section in document.sections)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8"/>
<meta name="viewport" content="width=device-width, initial-scale=1"/>
<meta name="color-scheme" content="light dark"/>
<title>{title}</title>
<style>{CSS}{STYLE}</style>
</head>
<body>
<header>
<h1>{title}</h1>
{subtitle}
<p class="answer {document.verdict}">{sign}{_WRITER.text(document.answer)}</p>
<nav aria-label="Contents"><ol>{entries}</ol></nav>
</header>
<main>
{sections}
</main>
</body>
</html>
"""


def _section(section: Section) -> str:
    body = "\n".join(map(_WRITER.block, section.blocks))
    head = f'<h2 id="{section.key}-h">{escape(section.title)}</h2>'
    return f'<section id="{section.key}" aria-labelledby="{section.key}-h">\n{head}\n{body}\n</section>'


def block_html(block: Block) -> str:
    """Write one block.

    Returns:
        Its HTML, for a page that has the style sheet.
    """
    return _WRITER.block(block)


class _HtmlWriter(PieceWriter, BlockWriter[str]):
    def paragraph(self, text: Text) -> str:
        return f"<p>{self.text(text)}</p>"

    def note(self, text: Text) -> str:
        return f'<p class="note">{self.text(text)}</p>'

    def formula(self, formula: Formula) -> str:
        """Return the formula; a long one twice, in shorter lines for narrow screens (CSS shows one)."""
        tag = f'<span class="tag">{self.words(formula.tag)}</span>' if formula.tag else ""
        if width(formula.box) <= _FULL * NARROW:
            return f'<div class="formula">{_set(formula.box, LINE, "scroll")}{tag}</div>'
        both = _set(formula.box, LINE, "scroll wide") + _set(narrowed(formula.box), NARROW, "scroll narrow")
        return f'<div class="formula">{both}{tag}</div>'

    def steps(self, steps: Steps) -> str:
        return f'<ol class="steps">{"".join(map(self._step, steps.items))}</ol>'

    def _step(self, step: ArgumentStep) -> str:
        formula = self.formula(step.formula) if step.formula else ""
        return f"<li><p><strong>{escape(step.title)}.</strong> {self.text(step.text)}</p>{formula}</li>"

    def table(self, table: Table) -> str:
        numeric = [any(_is_number(row[i]) for row in table.rows) for i in range(len(table.header))]
        heads_said = [escape(line(cell), quote=True) for cell in table.header]
        heads = "".join(f'<th scope="col"{_class(n)}>{self.text(cell)}</th>' for cell, n in zip(table.header, numeric))
        rows = "".join(
            "<tr>"
            + "".join(
                f'<th scope="row">{self.text(cell)}</th>'
                if i == 0
                else f'<td{_class(numeric[i])} data-label="{heads_said[i]}">{self.text(cell)}</td>'
                for i, cell in enumerate(row)
            )
            + "</tr>"
            for row in table.rows
        )
        caption = f"<caption>{self.plain(table.caption)}</caption>" if table.caption else ""
        label = escape(table.caption or "Table", quote=True)
        many, wide = len(table.rows) > _MOST_ROWS_UNBROKEN, len(table.header) > _SIDE_BY_SIDE
        names = _classes("long" * many, "stack" * wide)
        whole = f"<table{names}>{caption}<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
        return f'<div class="scroll" {_REACHED} aria-label="{label}">{whole}</div>'

    def figure(self, figure: Figure) -> str:
        return f"<figure>{figure.svg}<figcaption>{self.text(figure.caption)}</figcaption></figure>"

    def figures(self, figures: tuple[Figure, ...]) -> str:
        return f'<div class="figures">{"".join(map(self.figure, figures))}</div>'

    def text(self, text: Text) -> str:
        """Return the pieces; a sign that follows a formula stays on its line."""
        parts: list[str] = []
        for piece in _with_formulas(text):
            if parts and isinstance(piece, str) and piece[:1] in _CLOSING and parts[-1].endswith("</math>"):
                parts[-1] = f'<span class="together">{parts[-1]}{piece[0]}</span>'
                piece = piece[1:]
            parts.append(self.piece(piece))
        return "".join(parts)

    def words(self, text: str) -> str:
        return _NUMBER_OF_EQUATION.sub(r'<span class="together">\g<0></span>', escape(text))

    def plain(self, text: str) -> str:
        """Return a text without pieces, such as a caption, with its formulas set."""
        return self.text((text,))

    def mathematics(self, box: Box) -> str:
        return mathml_of(box)

    def code(self, text: str) -> str:
        return f"<code>{escape(text)}</code>"

    def strong(self, text: str) -> str:
        return f"<strong>{escape(text)}</strong>"

    def number(self, number: Number) -> str:
        value = self.digits(number.value)
        if not number.error:
            return f'<span class="value">{value}</span>'
        proof = ' <abbr title="the error is a proved bound">certified</abbr>' if number.certified else ""
        return f'<span class="value">{value} <span class="error">± {self.digits(number.error)}</span>{proof}</span>'

    def digits(self, text: str) -> str:
        mantissa, _, exponent = text.replace("-", "−").partition("e")
        return f"{mantissa}×10<sup>{exponent}</sup>" if exponent else mantissa


def _set(box: Box, letters: float, names: str) -> str:
    small = _smaller(width(box), letters)
    return f'<div class="{names}" {_REACHED} aria-label="Formula"{small}>{mathml_of(box, block=True)}</div>'


def _smaller(letters: float, room: float) -> str:
    """Return a smaller size for a formula whose lines are still too long, down to three fifths."""
    scale = max(0.6, _FULL * room / letters) if letters > _FULL * room else 1.0
    return f' style="font-size:{100 * scale:.0f}%"' if scale < 1 else ""


def _with_formulas(text: Text) -> Iterator[Inline]:
    """Set the formulas that stand between words: all but numbers of equations."""
    for piece in text:
        if not isinstance(piece, str):
            yield piece
            continue
        for k, part in enumerate(re.split(f"({_NUMBER_OF_EQUATION.pattern})", piece)):
            found = [part] if k % 2 else formulas_in_words(part)
            yield from (one if isinstance(one, str) else Mathematics(one) for one in found)


def _is_number(cell: Text) -> bool:
    return any(isinstance(piece, Number) for piece in cell)


def _classes(*names: str) -> str:
    return f' class="{given}"' if (given := " ".join(filter(None, names))) else ""


def _class(numeric: bool) -> str:
    return ' class="num"' if numeric else ""


_WRITER = _HtmlWriter()
