"""Boxes to one line of Unicode text: ½ m ṙ², √(2 m (E + k/r)), ∫ₐ… as ∫[a, q] … dq."""

from __future__ import annotations

import re
import unicodedata

from hjsolve.formulas.checked_arithmetic import FUNCTIONS
from hjsolve.reports.formulas.layout import (
    Box,
    Definite,
    Dotted,
    Fence,
    Fraction,
    Glyph,
    Grid,
    RadicalBox,
    RowBox,
    Script,
)
from hjsolve.reports.formulas.names import FUNCTION_NAMES, LOWERED, RAISED, name_box

_VULGAR = {
    ("1", "2"): "½", ("1", "3"): "⅓", ("1", "4"): "¼", ("3", "4"): "¾", ("2", "3"): "⅔", ("1", "8"): "⅛",
    ("1", "6"): "⅙",
}  # fmt: skip
_APPLY = Glyph("\u2061", "operator")
_LETTERS = {"K", "F", "E", "Π"}
"""Legendre's functions, which a formula calls by letters that are names of constants far more often."""
_CALLED = frozenset({*FUNCTION_NAMES.values(), *FUNCTION_NAMES, *FUNCTIONS, "exp", "abs"} - _LETTERS)
_SPACED = {"=", "+", "−", "<", ">", "≤", "≥", "≠"}


def plain(box: Box) -> str:
    """Write a box as one line of text that can be read in one way only; a grid takes one line a row.

    A blank between factors is a product and binds closer than a slash; a function takes the one letter after it or a
    bracket. Nothing follows a quotient but a sum, so a quotient that is a factor, a function that is divided and a
    function before a bracket get brackets of their own. A letter never means a differential.

    Returns:
        Unicode text; index letters without a Unicode form are written ``p_θ``.
    """
    match box:
        case Glyph(text, "identifier") if text in _CALLED:
            return f"({text})"  # a letter called ln
        case Glyph(_, "differential"):
            return "∂"  # dx could be a letter
        case Glyph(text, kind):
            return text if kind != "operator" or text != "\u2061" else " "
        case RowBox(items):
            return _row(items)
        case Fraction(top, bottom):
            return _fraction(top, bottom)
        case RadicalBox(body, index):
            sign = {"3": "∛", "4": "∜"}.get(plain(index), f"root{plain(index)}") if index else "√"
            return f"{sign}{_wrapped(body)}"
        case Script(Glyph("e", "constant"), None, sup) if sup is not None:
            return f"exp({plain(sup)})"
        case Script(base, sub, sup):
            return plain(base) + (_index(plain(sub)) if sub else "") + (_exponent(plain(sup)) if sup else "")
        case Dotted(base, dots):
            text, over = plain(base), "\u0307" if dots == 1 else "\u0308"
            return unicodedata.normalize("NFC", text[0] + over + text[1:])
        case Fence(body, "|", "|"):
            return f"|{plain(body)}|" if "|" not in plain(body) else f"abs({plain(body)})"
        case Fence(body, left, right):
            return f"{left}{plain(body)}{right}"
        case Grid(rows, left, right):
            return _grid(rows, left, right)
        case Definite():
            return _definite(box)


def spoken(name: str) -> str:
    """Write a name as it stands in a sentence that has no formulas, such as the description of a drawing."""
    return plain(name_box(name))


def _row(items: tuple[Box, ...]) -> str:
    parts: list[str] = []
    previous: Box | None = None
    for place, item in enumerate(items):
        following, second = (*items[place + 1 : place + 3], None, None)[:2]
        if item == _APPLY and isinstance(second, Fence):
            previous = item
            continue
        text = _factor(item, previous, following)
        if isinstance(item, Glyph) and item.kind == "operator":
            binary = previous is not None and not _is_operator(previous)
            applied = item.text == "\u2061" and text != " "
            spaced = item.text in _SPACED and binary and not applied
            parts.append(f" {text} " if spaced else f"{text} " if text == "," else text)
        else:
            glued = previous is None or _is_operator(previous) or _touching(previous, item)
            parts.append(text if glued else f" {text}")
        previous = item
    return "".join(parts)


def _factor(item: Box, previous: Box | None, following: Box | None) -> str:
    """One item of a row, in brackets where it would not be read alone next to its neighbours."""
    text = plain(item)
    if isinstance(item, Fraction) and "/" in text and _continues(following):
        return f"({text})"
    if previous == _APPLY and isinstance(following, Fence):
        return f"({text})"  # cos(θ) (1 − r)
    return text


def _continues(following: Box | None) -> bool:
    """Return whether another factor follows."""
    return following is not None and not (isinstance(following, Glyph) and following.kind in {"operator", "text"})


def _is_operator(box: Box) -> bool:
    return isinstance(box, Glyph) and box.kind in {"operator", "text", "differential"}


def _touching(left: Box, right: Box) -> bool:
    head = left.base if isinstance(left, Script) else left
    if isinstance(head, Glyph) and head.kind == "differential":
        return True
    if isinstance(right, Fence):
        return isinstance(head, Glyph) and head.kind == "function"
    return isinstance(right, Glyph) and right.kind == "text"


def _atomic(box: Box) -> bool:
    """Tell whether a numerator needs no brackets: factors only, and no function of a bare letter."""
    if isinstance(box, RowBox):
        signs = [item.text for item in box.items if isinstance(item, Glyph) and item.kind == "operator"]
        return not any(sign in _SPACED or sign == "\u2061" for sign in signs) and not _divided(box.items)
    return isinstance(box, Glyph | Script | Fence | Dotted | RadicalBox)


def _divided(items: tuple[Box, ...]) -> bool:
    return any(isinstance(item, Fraction | Definite) for item in items)


def _single(box: Box) -> bool:
    """Tell whether a denominator needs no brackets: a letter, a root, one call of a function, or a differential."""
    if isinstance(box, RowBox):
        head = box.items[0].base if isinstance(box.items[0], Script) else box.items[0]
        kind, rest = head.kind if isinstance(head, Glyph) else "", box.items[1:]
        called = kind == "function" and (len(rest) == 1 or (len(rest) == 2 and rest[0] == _APPLY))
        return called or (kind == "differential" and len(rest) == 1 and isinstance(rest[0], Glyph | Script))
    return isinstance(box, Glyph | Script | Fence | Dotted | RadicalBox)


def _wrapped(box: Box) -> str:
    single = isinstance(box, Glyph | Dotted) or (isinstance(box, Script) and box.sup is None)
    return plain(box) if single else f"({plain(box)})"


def _fraction(top: Box, bottom: Box) -> str:
    over, under = plain(top), plain(bottom)
    if (over, under) in _VULGAR:
        return _VULGAR[over, under]
    left = over if _atomic(top) else f"({over})"
    right = under if _single(bottom) else f"({under})"
    return f"{left}/{right}"


def _exponent(text: str) -> str:
    if all(letter in RAISED for letter in text):
        return "".join(RAISED[letter] for letter in text)
    return f"^{text}" if len(text) == 1 else f"^({text})"


def _index(text: str) -> str:
    if "," in text:
        return ",".join(_index(part.strip()) for part in text.split(","))
    if all(letter in LOWERED for letter in text):
        return "".join(LOWERED[letter] for letter in text)
    return f"_{text}" if text.isalnum() or len(text) == 1 else f"_({text})" if " " in text else f"_{text}"


def _grid(rows: tuple[tuple[Box, ...], ...], left: str, right: str) -> str:
    if left or right:
        return "[" + "; ".join(", ".join(plain(cell) for cell in cells) for cells in rows) + "]"
    shown = [[plain(cell).strip() for cell in cells] for cells in rows]
    across = [max(map(len, column)) for column in zip(*shown)]
    return "\n".join(" ".join(c.ljust(w) for c, w in zip(cells, across)).rstrip() for cells in shown)


def _definite(box: Definite) -> str:
    limits = ""
    if box.upper is not None:
        limits = f"[{plain(box.lower)}, {plain(box.upper)}]" if box.lower is not None else f"^{plain(box.upper)}"
    body = plain(box.body)
    if box.variable is None:
        return f"{box.sign}{limits} {body}"
    end = f"d{plain(box.variable)}"
    body = f"({body})" if end in re.split(r"[^\w′]+", body) else body  # a letter called dx
    return f"{box.sign}{limits} {body} {end}"
