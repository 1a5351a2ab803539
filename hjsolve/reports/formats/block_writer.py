"""The walk through a document: one for all formats. A format says what each kind of block and of piece becomes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

from hjsolve.arithmetic.printed_digits import raised
from hjsolve.reports.document import (
    Block,
    Code,
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
from hjsolve.reports.formulas.layout import Box

W = TypeVar("W")
"""What a block becomes: text, or a table of JSON."""


class PieceWriter(ABC):
    """Goes through the pieces of a sentence."""

    def text(self, text: Text) -> str:
        """Write a sentence."""
        return "".join(map(self.piece, text))

    def piece(self, piece: Inline) -> str:
        """Write one piece of a sentence."""
        match piece:
            case str():
                return self.words(piece)
            case Mathematics(box):
                return self.mathematics(box)
            case Code(text):
                return self.code(text)
            case Strong(text):
                return self.strong(text)
            case Number():
                return self.number(piece)

    def number(self, number: Number) -> str:
        """Write a value with its error.

        Args:
            number: rounded already.
        """
        value = self.digits(number.value)
        proof = " (certified)" if number.certified else ""
        return (f"{value} ± {self.digits(number.error)}" if number.error else value) + proof

    @abstractmethod
    def words(self, text: str) -> str:
        """Write plain words.

        Args:
            text: as they are read.
        """

    @abstractmethod
    def mathematics(self, box: Box) -> str:
        """Write a formula inside a sentence."""

    @abstractmethod
    def code(self, text: str) -> str:
        """Write something to type.

        Args:
            text: as it is typed.
        """

    @abstractmethod
    def strong(self, text: str) -> str:
        """Write words that carry the answer."""

    def digits(self, text: str) -> str:
        """Write the digits of a number.

        Args:
            text: digits, with ``e`` before an exponent.
        """
        return raised(text)


class BlockWriter(ABC, Generic[W]):
    """Goes through the blocks of a document."""

    def block(self, block: Block) -> W:
        """Write one block."""
        match block:
            case Paragraph(text):
                return self.paragraph(text)
            case Note(text):
                return self.note(text)
            case Formula():
                return self.formula(block)
            case Table():
                return self.table(block)
            case Steps():
                return self.steps(block)
            case Figure():
                return self.figure(block)
            case Figures(items):
                return self.figures(items)

    @abstractmethod
    def paragraph(self, text: Text) -> W:
        """Write a paragraph of prose."""

    @abstractmethod
    def note(self, text: Text) -> W:
        """Write a paragraph set apart."""

    @abstractmethod
    def formula(self, formula: Formula) -> W:
        """Write a displayed formula.

        Args:
            formula: with its tag.
        """

    @abstractmethod
    def table(self, table: Table) -> W:
        """Write a table.

        Args:
            table: with header, rows and caption.
        """

    @abstractmethod
    def steps(self, steps: Steps) -> W:
        """Write an argument, step by step.

        Args:
            steps: in order.
        """

    @abstractmethod
    def figure(self, figure: Figure) -> W:
        """Write a drawing, or what it shows in words.

        Args:
            figure: with its caption and description.
        """

    @abstractmethod
    def figures(self, figures: tuple[Figure, ...]) -> W:
        """Write drawings that are read together.

        Args:
            figures: in order.
        """
