"""Boxes to MathML Core, the subset that browsers render: no mfenced, stretchy fences as operators."""

from __future__ import annotations

from html import escape
from typing import TypeGuard

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
from hjsolve.reports.formulas.one_line_text import plain

_THIN = '<mspace width="0.17em"/>'
_COLUMN = {"l": "text-align:left", "r": "text-align:right", "c": "text-align:center"}


def mathml_of(box: Box, *, block: bool = False) -> str:
    """Write a box as a ``<math>`` element, with the same formula in plain text for those who cannot see it.

    Args:
        box: the formula.
        block: True for a displayed formula.

    Returns:
        Markup that is valid both as HTML and as XML.
    """
    display = ' display="block"' if block else ""
    label = escape(plain(box), quote=True)
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML"{display} aria-label="{label}">{_write(box)}</math>'


def _write(box: Box) -> str:
    match box:
        case Glyph():
            return _glyph(box)
        case RowBox(items):
            return f"<mrow>{''.join(_row_items(items))}</mrow>"
        case Fraction(top, bottom):
            return f"<mfrac>{_write(top)}{_write(bottom)}</mfrac>"
        case RadicalBox(body, None):
            return f"<msqrt>{_write(body)}</msqrt>"
        case RadicalBox(body, index):
            return f"<mroot>{_write(body)}{_write(index)}</mroot>" if index else ""
        case Script():
            return _script(box)
        case Dotted(base, dots):
            over = "˙" if dots == 1 else "¨"
            return f'<mover accent="true">{_write(base)}<mo stretchy="false">{over}</mo></mover>'
        case Fence(body, left, right):
            return f"<mrow>{_fence(left, 'prefix')}{_write(body)}{_fence(right, 'postfix')}</mrow>"
        case Grid():
            return _grid(box)
        case Definite():
            return _definite(box)


def _glyph(glyph: Glyph) -> str:
    text = escape(glyph.text)
    match glyph.kind:
        case "number":
            return f"<mn>{text}</mn>"
        case "operator" if glyph.text == "\u2061":
            return "<mo>&#x2061;</mo>" + _THIN
        case "operator" if glyph.text == "/":
            return '<mo lspace="0" rspace="0" stretchy="false">/</mo>'
        case "operator":
            return f"<mo>{text}</mo>"
        case "text":
            return f"<mtext>{text.replace(' ', chr(0xA0))}</mtext>"
        case "constant":
            return f'<mi mathvariant="normal">{text}</mi>'
        case "differential":
            return (
                f'<mo lspace="0" rspace="0">{text}</mo>'
                if glyph.text == "∂"
                else f'<mi mathvariant="normal">{text}</mi>'
            )
        case _:
            return f"<mi>{text}</mi>"


def _row_items(items: tuple[Box, ...]) -> list[str]:
    """Write the items of a row; a thin space keeps a function or a fraction apart from the factor before it."""
    parts: list[str] = []
    for before, item in zip((None, *items), items):
        if before is not None and _needs_space(before, item):
            parts.append(_THIN)
        parts.append(f'<mo form="prefix">{escape(item.text)}</mo>' if _is_sign(item, before) else _write(item))
    return parts


def _is_sign(item: Box, before: Box | None) -> TypeGuard[Glyph]:
    """Whether + or − is the sign of what follows, and not between two terms: browsers look at the first place only."""
    if not isinstance(item, Glyph) or item.kind != "operator" or item.text not in {"+", "−"}:
        return False
    return isinstance(before, Glyph) and before.kind == "operator" and before.text in {"=", "<", ">", ",", "≠", "/"}


def _needs_space(before: Box, item: Box) -> bool:
    if isinstance(before, Glyph) and before.kind in {"operator", "text", "function", "differential"}:
        return False
    head = item.base if isinstance(item, Script) else item
    starts_function = isinstance(head, Glyph) and head.kind == "function"
    return (
        starts_function
        or isinstance(item, Definite | RadicalBox)
        or isinstance(before, RadicalBox)
        or _wide_name(head)
        or _wide_name(before)
    )


def _wide_name(box: Box | None) -> bool:
    inner = box.base if isinstance(box, Script) else box
    return isinstance(inner, Glyph) and inner.kind == "identifier" and len(inner.text) > 1


def _fence(sign: str, form: str) -> str:
    if not sign:
        return ""
    return f'<mo fence="true" form="{form}" stretchy="true">{escape(sign)}</mo>'


def _script(script: Script) -> str:
    base = _write(script.base)
    match script.sub, script.sup:
        case None, None:
            return base
        case None, sup if sup is not None:
            return f"<msup>{base}{_write(sup)}</msup>"
        case sub, None if sub is not None:
            return f"<msub>{base}{_write(sub)}</msub>"
        case sub, sup if sub is not None and sup is not None:
            return f"<msubsup>{base}{_write(sub)}{_write(sup)}</msubsup>"
    return base


def _grid(grid: Grid) -> str:
    columns = grid.align.ljust(len(grid.rows[0]) if grid.rows else 1, grid.align[-1:] or "c")
    rows = "".join(
        "<mtr>"
        + "".join(f'<mtd style="{_COLUMN[a]}">{_write(cell)}</mtd>' for a, cell in zip(columns, cells))
        + "</mtr>"
        for cells in grid.rows
    )
    spread = ' class="lines"' if not grid.left and not grid.right else ""
    table = f'<mtable displaystyle="true"{spread}>{rows}</mtable>'
    return f"<mrow>{_fence(grid.left, 'prefix')}{table}{_fence(grid.right, 'postfix')}</mrow>"


def _definite(box: Definite) -> str:
    sign = f'<mo largeop="true" stretchy="false">{box.sign}</mo>'
    if box.lower is not None and box.upper is not None:
        sign = f"<msubsup>{sign}{_write(box.lower)}{_write(box.upper)}</msubsup>"
    elif box.upper is not None:
        sign = f"<msup>{sign}{_write(box.upper)}</msup>"
    elif box.lower is not None:
        sign = f"<msub>{sign}{_write(box.lower)}</msub>"
    tail = f'{_THIN}<mi mathvariant="normal">d</mi>{_write(box.variable)}' if box.variable else ""
    return f"<mrow>{sign}{_write(box.body)}{tail}</mrow>"
