"""Boxes to one line of Unicode text: ½ m ṙ², √(2 m (E + k/r)), ∫ₐ… as ∫[a, q] … dq."""

from __future__ import annotations

import unicodedata

from hjsolve.reports.boxes import Box, Definite, Dotted, Fence, Fraction, Glyph, Grid, Root, Row, Script

_SUPERSCRIPTS = dict(zip("0123456789−-+nT", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁻⁺ⁿᵀ"))
_SUBSCRIPTS = dict(zip("0123456789aehijklmnoprstuvx", "₀₁₂₃₄₅₆₇₈₉ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ"))
_VULGAR = {
    ("1", "2"): "½",
    ("1", "3"): "⅓",
    ("1", "4"): "¼",
    ("3", "4"): "¾",
    ("2", "3"): "⅔",
    ("3", "2"): "3/2",
    ("1", "8"): "⅛",
    ("1", "6"): "⅙",
}
_SPACED = {"=", "+", "−", "<", ">", "≤", "≥", "≠"}


def plain(box: Box) -> str:
    """Write a box as one line of text; a grid takes one line a row.

    Args:
        box: the formula.

    Returns:
        Unicode text; index letters without a Unicode form are written ``p_θ``.
    """
    match box:
        case Glyph(text, kind):
            return text if kind != "operator" or text != "\u2061" else " "
        case Row(items):
            return _row(items)
        case Fraction(top, bottom):
            return _fraction(top, bottom)
        case Root(body, index):
            sign = {"3": "∛", "4": "∜"}.get(plain(index), f"root{plain(index)} of ") if index else "√"
            return f"{sign}{_wrapped(body)}"
        case Script(base, sub, sup):
            return plain(base) + (_index(plain(sub)) if sub else "") + (_exponent(plain(sup)) if sup else "")
        case Dotted(base):
            text = plain(base)
            return unicodedata.normalize("NFC", text[0] + "\u0307" + text[1:])
        case Fence(body, left, right):
            return f"{left}{plain(body)}{right}"
        case Grid(rows, left, right):
            return _grid(rows, left, right)
        case Definite():
            return _definite(box)


def _row(items: tuple[Box, ...]) -> str:
    parts: list[str] = []
    previous: Box | None = None
    for item in items:
        text = plain(item)
        if isinstance(item, Glyph) and item.kind == "operator":
            binary = previous is not None and not _is_operator(previous)
            parts.append(f" {text} " if text in _SPACED and binary else f"{text} " if text == "," else text)
        else:
            glued = previous is None or _is_operator(previous) or _touching(previous, item)
            parts.append(text if glued else f" {text}")
        previous = item
    return "".join(parts)


def _is_operator(box: Box) -> bool:
    return isinstance(box, Glyph) and box.kind in {"operator", "text"}


def _touching(left: Box, right: Box) -> bool:
    head = left.base if isinstance(left, Script) else left
    if isinstance(right, Fence):
        return isinstance(head, Glyph) and head.kind == "function"
    return isinstance(right, Glyph) and right.kind == "text"


def _atomic(box: Box) -> bool:
    if isinstance(box, Row):
        return not any(
            isinstance(item, Glyph) and item.kind == "operator" and item.text in _SPACED for item in box.items
        )
    return isinstance(box, Glyph | Script | Fence | Dotted | Root)


def _single(box: Box) -> bool:
    """Tell whether a denominator needs no brackets: a letter, a root, or one call of a function."""
    if isinstance(box, Row) and len(box.items) <= 3:
        head = box.items[0].base if isinstance(box.items[0], Script) else box.items[0]
        return isinstance(head, Glyph) and (head.kind == "function" or head.text in {"∂", "d"})
    return isinstance(box, Glyph | Script | Fence | Dotted | Root)


def _wrapped(box: Box) -> str:
    single = isinstance(box, Glyph | Script | Dotted)
    return plain(box) if single else f"({plain(box)})"


def _fraction(top: Box, bottom: Box) -> str:
    over, under = plain(top), plain(bottom)
    if (over, under) in _VULGAR:
        return _VULGAR[over, under]
    left = over if _atomic(top) else f"({over})"
    right = under if _single(bottom) else f"({under})"
    return f"{left}/{right}"


def _exponent(text: str) -> str:
    if all(letter in _SUPERSCRIPTS for letter in text):
        return "".join(_SUPERSCRIPTS[letter] for letter in text)
    return f"^{text}" if len(text) == 1 else f"^({text})"


def _index(text: str) -> str:
    if all(letter in _SUBSCRIPTS for letter in text):
        return "".join(_SUBSCRIPTS[letter] for letter in text)
    return f"_{text}" if text.isalnum() or len(text) == 1 else f"_({text})" if " " in text else f"_{text}"


def _grid(rows: tuple[tuple[Box, ...], ...], left: str, right: str) -> str:
    if left or right:
        return "[" + "; ".join(", ".join(plain(cell) for cell in cells) for cells in rows) + "]"
    return "\n".join(" ".join(plain(cell) for cell in cells).rstrip() for cells in rows)


def _definite(box: Definite) -> str:
    limits = ""
    if box.upper is not None:
        limits = f"[{plain(box.lower)}, {plain(box.upper)}]" if box.lower is not None else f"^{plain(box.upper)}"
    tail = f" d{plain(box.variable)}" if box.variable else ""
    return f"{box.sign}{limits} {plain(box.body)}{tail}"
