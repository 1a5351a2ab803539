"""A document as JSON, for programs: the same sections by key, formulas as sympy text and LaTeX, drawings as numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TypeAlias

from hjsolve.reports.document import Document, Figure, Formula, Number, Steps, Table, Text
from hjsolve.reports.formats.block_writer import BlockWriter
from hjsolve.reports.formats.text import line
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.formulas.one_line_text import plain

JsonTable: TypeAlias = Mapping[str, object]
"""What ``json`` writes between braces."""


def json_text(document: Document) -> str:
    """Write a document as JSON.

    Returns:
        ``{"title", "id", "answer", "sections": {key: {"title", "blocks"}}}``, indented.
    """
    sections = {s.key: {"title": s.title, "blocks": list(map(_WRITER.block, s.blocks))} for s in document.sections}
    whole = {
        "title": document.title, "id": document.subtitle, "answer": line(document.answer), "verdict": document.verdict,
        "sections": sections,
    }  # fmt: skip
    return json.dumps(whole, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


class _JsonWriter(BlockWriter[JsonTable]):
    def paragraph(self, text: Text) -> JsonTable:
        return {"kind": "text", "text": line(text)}

    def note(self, text: Text) -> JsonTable:
        return self.paragraph(text)

    def formula(self, formula: Formula) -> JsonTable:
        return {
            "kind": "formula",
            "sympy": formula.source,
            "latex": latex_of(formula.box),
            "text": plain(formula.box),
            "tag": formula.tag,
        }

    def table(self, table: Table) -> JsonTable:
        return {
            "kind": "table",
            "caption": table.caption,
            "header": [line(cell) for cell in table.header],
            "rows": [[_cell(cell) for cell in row] for row in table.rows],
        }

    def steps(self, steps: Steps) -> JsonTable:
        told = [
            {"title": s.title, "text": line(s.text), "formula": self.formula(s.formula) if s.formula else None}
            for s in steps.items
        ]
        return {"kind": "steps", "steps": told}

    def figure(self, figure: Figure) -> JsonTable:
        data = {name: [x if math.isfinite(x) else None for x in values] for name, values in figure.data.items()}
        return {"kind": "figure", "title": figure.title, "description": figure.description, "data": data}

    def figures(self, figures: tuple[Figure, ...]) -> JsonTable:
        return {"kind": "figures", "figures": [self.figure(figure) for figure in figures]}


def _cell(cell: Text) -> str | JsonTable:
    """Return a number keeps its value and error apart; everything else is text."""
    if len(cell) == 1 and isinstance(cell[0], Number):
        return {"value": cell[0].value, "error": cell[0].error or "0", "certified": cell[0].certified}
    return line(cell)


_WRITER = _JsonWriter()
