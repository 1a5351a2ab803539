"""A document as JSON, for programs: the same sections by key, formulas as sympy text and LaTeX, drawings as numbers."""

from __future__ import annotations

import json
from typing import Any

from hjsolve.reports.document import (
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
    Steps,
    Strong,
    Table,
    Text,
)
from hjsolve.reports.formats.text import line
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.formulas.one_line_text import plain


def json_text(document: Document) -> str:
    """Write a document as JSON.

    Args:
        document: the document.

    Returns:
        ``{"title", "id", "answer", "sections": {key: {"title", "blocks"}}}``, indented.
    """
    sections = {s.key: {"title": s.title, "blocks": [_block(block) for block in s.blocks]} for s in document.sections}
    whole = {
        "title": document.title, "id": document.subtitle, "answer": line(document.answer), "verdict": document.verdict,
        "sections": sections,
    }  # fmt: skip
    return json.dumps(whole, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def _block(block: Block) -> dict[str, Any]:
    match block:
        case Paragraph(text) | Note(text):
            return {"kind": "text", "text": line(text)}
        case Formula():
            return _formula(block)
        case Table():
            header = [line(cell) for cell in block.header]
            return {
                "kind": "table",
                "caption": block.caption,
                "header": header,
                "rows": [[_cell(cell) for cell in row] for row in block.rows],
            }
        case Steps(items):
            steps = [
                {"title": s.title, "text": line(s.text), "formula": _formula(s.formula) if s.formula else None}
                for s in items
            ]
            return {"kind": "steps", "steps": steps}
        case Figure():
            return {"kind": "figure", "title": block.title, "description": block.description, "data": block.data}
        case Figures(items):
            return {"kind": "figures", "figures": [_block(figure) for figure in items]}


def _formula(formula: Formula) -> dict[str, Any]:
    return {
        "kind": "formula",
        "sympy": formula.source,
        "latex": latex_of(formula.box),
        "text": plain(formula.box),
        "tag": formula.tag,
    }


def _cell(cell: Text) -> Any:
    """A number keeps its value and error apart; everything else is text."""
    if len(cell) == 1 and isinstance(cell[0], Number):
        return {"value": cell[0].value, "error": cell[0].error or "0", "certified": cell[0].certified}
    return "".join(map(_inline, cell))


def _inline(piece: Inline) -> str:
    match piece:
        case Mathematics(box):
            return plain(box)
        case Code(text) | Strong(text):
            return text
    return line((piece,))
