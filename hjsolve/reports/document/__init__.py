"""The document: what a report says, as frozen values, how its drawings look, and the file it goes to.

In: texts, formulas and drawings. Out: ``Document`` with its sections and blocks. Read ``blocks.py`` first; every format
is written from these.
"""

from __future__ import annotations

from hjsolve.reports.document.blocks import (
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

__all__ = [
    "ArgumentStep",
    "Block",
    "Code",
    "Document",
    "Figure",
    "Figures",
    "Formula",
    "Inline",
    "Mathematics",
    "Note",
    "Number",
    "Paragraph",
    "Section",
    "Steps",
    "Strong",
    "Table",
    "Text",
]
