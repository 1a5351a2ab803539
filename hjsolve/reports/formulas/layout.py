"""Formulas as boxes: the one layout that MathML, LaTeX and plain text are all written from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

GlyphKind: TypeAlias = Literal["identifier", "number", "operator", "function", "text", "constant", "differential"]


@dataclass(frozen=True)
class Glyph:
    """A letter, number, operator, function name or piece of prose.

    A constant (e of the exponential function) and a differential (d of a derivative) are letters that no name is.
    """

    text: str
    kind: GlyphKind = "identifier"


@dataclass(frozen=True)
class RowBox:
    """Boxes side by side."""

    items: tuple[Box, ...]


@dataclass(frozen=True)
class Fraction:
    """One box over another."""

    top: Box
    bottom: Box


@dataclass(frozen=True)
class RadicalBox:
    """A root sign; ``index`` is None for a square root."""

    body: Box
    index: Box | None = None


@dataclass(frozen=True)
class Script:
    """A base with a subscript, a superscript or both."""

    base: Box
    sub: Box | None = None
    sup: Box | None = None


@dataclass(frozen=True)
class Dotted:
    """A base with one dot over it, a velocity, or with two, an acceleration."""

    base: Box
    dots: int = 1


@dataclass(frozen=True)
class Fence:
    """A box between two delimiters."""

    body: Box
    left: str = "("
    right: str = ")"


@dataclass(frozen=True)
class Grid:
    """Rows of cells between two delimiters, which may be empty: matrices, cases, aligned lines.

    ``align`` is one letter, c, l or r, for each column.
    """

    rows: tuple[tuple[Box, ...], ...]
    left: str = "("
    right: str = ")"
    align: str = "c"


@dataclass(frozen=True)
class Definite:
    """∫ or ∑ with limits, its body and, for an integral, the variable of dq."""

    sign: str
    body: Box
    lower: Box | None
    upper: Box | None
    variable: Box | None = None


Box: TypeAlias = Glyph | RowBox | Fraction | RadicalBox | Script | Dotted | Fence | Grid | Definite


def row(*items: Box) -> Box:
    """Put boxes side by side, flattening rows and leaving a single box alone.

    Args:
        items: the boxes, from left to right.

    Returns:
        One box.
    """
    flat: list[Box] = []
    for item in items:
        flat.extend(item.items if isinstance(item, RowBox) else (item,))
    return flat[0] if len(flat) == 1 else RowBox(tuple(flat))


_SPACE_ABOUT = {"=": 1.2, "+": 1.2, "−": 1.2, ",": 0.6}
"""Room beside an operator, in letters."""


def width(box: Box) -> float:
    """Estimate how wide a box is, in letters; good enough to decide where a line must break."""
    match box:
        case Glyph(text, kind):
            return len(text) + (_SPACE_ABOUT.get(text, 0.1) if kind == "operator" else 0.1)
        case RowBox(items):
            return sum(width(item) for item in items)
        case Fraction(top, bottom):
            return max(width(top), width(bottom)) + 0.3
        case RadicalBox(body, _):
            return width(body) + 1.5
        case Script(base, sub, sup):
            return width(base) + 0.7 * max(width(s) if s else 0.0 for s in (sub, sup))
        case Dotted(base):
            return width(base)
        case Fence(body, left, right):
            return width(body) + 0.6 * (len(left) + len(right))
        case Grid(rows):
            return sum(max(width(cell) for cell in column) + 1.5 for column in zip(*rows))
        case Definite(_, body, _, _, variable):
            return width(body) + 2.5 + (width(variable) + 1.0 if variable else 0.0)
