"""What a report says, once, as frozen values; every format is written from these."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from hjsolve.reports.formulas.layout import Box


@dataclass(frozen=True)
class Mathematics:
    """A formula inside a sentence or a cell."""

    box: Box


@dataclass(frozen=True)
class Code:
    """Something to type, or a name as the user wrote it."""

    text: str


@dataclass(frozen=True)
class Strong:
    """Words that carry the answer."""

    text: str


@dataclass(frozen=True)
class Number:
    """A value with its error, both already rounded to the digits they deserve (``sections.rounded_numbers.quantity``).

    Attributes:
        value: digits, with ``×10^n`` written as ``e``.
        error: the error with one or two digits; empty where the number is exact.
        certified: the error is a proved bound.
    """

    value: str
    error: str = ""
    certified: bool = False


Inline: TypeAlias = str | Mathematics | Code | Strong | Number
Text: TypeAlias = tuple[Inline, ...]


@dataclass(frozen=True)
class Paragraph:
    """One paragraph of prose."""

    text: Text


@dataclass(frozen=True)
class Formula:
    """A displayed formula.

    Attributes:
        box: the formula.
        source: the same formula as sympy text, for machines and for pasting.
        tag: the equation's number in the literature, e.g. ``Greenwood (5-142)``; may be empty.
    """

    box: Box
    source: str = ""
    tag: str = ""


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names the row.

    Attributes:
        header: one text for each column.
        rows: cells, as many in each row as the header has.
        caption: what the table shows.
    """

    header: tuple[Text, ...]
    rows: tuple[tuple[Text, ...], ...]
    caption: str = ""


@dataclass(frozen=True)
class ArgumentStep:
    """One step of an argument: what was done, why, and the formula it gave."""

    title: str
    text: Text
    formula: Formula | None = None


@dataclass(frozen=True)
class Steps:
    """An argument, step by step."""

    items: tuple[ArgumentStep, ...]


@dataclass(frozen=True, repr=False)
class Figure:
    """A drawing.

    Attributes:
        svg: a complete ``<svg>`` element.
        title: a few words.
        description: what a reader who cannot see it should know.
        caption: the sentence under the figure.
        data: the numbers behind it, name → list, for the JSON report.
    """

    svg: str
    title: str
    description: str
    caption: Text
    data: dict[str, list[float]] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Figure({self.title}: {self.description})"

    def _repr_svg_(self) -> str:
        """Return what a notebook shows."""
        from hjsolve.reports.document.drawing_style import standalone

        return standalone(self.svg)

    def save(self, path: str | Path) -> Path:
        """Write the drawing as a file of its own, which follows the reader's light or dark page.

        Args:
            path: of the file; it ends in ``.svg``.

        Returns:
            The path.

        Raises:
            InvalidInputError: another suffix, or a place that cannot be written to.
        """
        from hjsolve.reports.document.drawing_style import standalone
        from hjsolve.reports.document.files import checked_path, replace

        target = checked_path(path, (".svg",))
        replace(target, standalone(self.svg))
        return target


@dataclass(frozen=True)
class Figures:
    """Drawings that are read together, side by side where there is room."""

    items: tuple[Figure, ...]


@dataclass(frozen=True)
class Note:
    """A paragraph set apart: advice, a limit, something that was not computed."""

    text: Text


Block: TypeAlias = Paragraph | Formula | Table | Steps | Figure | Figures | Note


@dataclass(frozen=True)
class Section:
    """A titled part.

    Attributes:
        key: a short permanent name, e.g. ``time-law``; the anchor in HTML and the key in JSON.
    """

    key: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Document:
    """A whole report.

    Attributes:
        title: the system's title.
        subtitle: its id, or the T and V it was given by.
        answer: the verdict in a sentence or two; stands first.
        sections: in reading order.
        verdict: ``yes``, ``no`` or ``open`` where the answer is one to a question; else empty.
        unsettled: which number fell short, and why; empty where none did.
    """

    title: str
    subtitle: str
    answer: Text
    sections: tuple[Section, ...]
    verdict: str = ""
    unsettled: str = ""

    @property
    def sign(self) -> str:
        """The verdict as a sign that stands before the answer, so that colour is not all that tells it."""
        return {"yes": "✓ ", "no": "✗ ", "open": "? "}.get(self.verdict, "")
