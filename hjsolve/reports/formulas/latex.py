"""Boxes to LaTeX, for Markdown and TeX reports."""

from __future__ import annotations

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
from hjsolve.reports.formulas.names import LATEX_SIGNS

_OPERATORS = {sign: f"{latex} " if latex[0] == "\\" else latex for sign, latex in LATEX_SIGNS.items()} | {"\u2061": ""}
_NAMED = {"sin", "cos", "tan", "ln", "exp", "sinh", "cosh", "tanh", "arcsin", "arccos", "arctan"}
_WORDS = tuple(f"\\{name}" for name in sorted(_NAMED)) + (r"\sqrt", r"\int", r"\operatorname")


def latex_of(box: Box) -> str:
    r"""Write a box as LaTeX mathematics, without the dollar signs.

    Returns:
        Text for mathematics mode; needs ``amsmath`` only.
    """
    match box:
        case Glyph():
            return _glyph(box)
        case RowBox(items):
            return "".join(_row_items(items))
        case Fraction(top, bottom):
            return rf"\frac{{{latex_of(top)}}}{{{latex_of(bottom)}}}"
        case RadicalBox(body, index):
            return rf"\sqrt{f'[{latex_of(index)}]' if index else ''}{{{latex_of(body)}}}"
        case Script(base, sub, sup):
            scripts = (f"_{{{latex_of(sub)}}}" if sub else "") + (f"^{{{latex_of(sup)}}}" if sup else "")
            return latex_of(base) + scripts
        case Dotted(base, dots):
            return rf"\{'d' * dots}ot{{{latex_of(base)}}}"
        case Fence(body, left, right):
            return rf"\left{left}{latex_of(body)}\right{right}"
        case Grid():
            return _grid(box)
        case Definite():
            return _definite(box)


def _glyph(glyph: Glyph) -> str:
    match glyph.kind:
        case "number":
            return LATEX_SIGNS.get(glyph.text, glyph.text)
        case "operator":
            return _OPERATORS.get(glyph.text, glyph.text)
        case "text":
            return rf"\text{{{escape(glyph.text)}}}" if glyph.text else ""
        case "function":
            if glyph.text in _NAMED:
                return rf"\{glyph.text}"
            return rf"\operatorname{{{LATEX_SIGNS.get(glyph.text, escape(glyph.text))}}}"
        case "constant" | "differential" if glyph.text.isalpha():
            return rf"\mathrm{{{glyph.text}}}"
        case "differential":
            return _OPERATORS.get(glyph.text, glyph.text)
        case _:
            if "′" in glyph.text:
                return latex_of(Glyph(glyph.text.rstrip("′"))) + "'" * glyph.text.count("′")
            if glyph.text in LATEX_SIGNS:
                return LATEX_SIGNS[glyph.text]
            return glyph.text if len(glyph.text) == 1 else rf"\mathrm{{{escape(glyph.text)}}}"


def _row_items(items: tuple[Box, ...]) -> list[str]:
    """Keep a control word apart from the letter after it, and a function or root from the factor before it."""
    parts: list[str] = []
    before: Box | None = None
    for item in items:
        text = latex_of(item)
        if not text:
            continue
        spaced = before is not None and not (isinstance(before, Glyph) and before.kind in {"operator", "function"})
        named = r"\mathrm{" in text[:8] or (bool(parts) and r"\mathrm{" in parts[-1])
        if spaced and (text.startswith(_WORDS) or named):
            parts.append(r"\,")
        elif parts and _ends_in_control_word(parts[-1]) and text[:1].isalnum():
            parts.append(" ")
        parts.append(text)
        before = item
    return parts


def _ends_in_control_word(text: str) -> bool:
    tail = text.rpartition("\\")[2]
    return "\\" in text and tail.isalpha()


def _grid(grid: Grid) -> str:
    body = r" \\ ".join(" & ".join(latex_of(cell) for cell in cells) for cells in grid.rows)
    if grid.left == "(":
        return rf"\begin{{pmatrix}} {body} \end{{pmatrix}}"
    if grid.left == "{":
        return rf"\begin{{cases}} {body} \end{{cases}}"
    if grid.align == "l":  # aligned begins with a column that is flush right
        body = r" \\ ".join("& " + latex_of(cells[0]) for cells in grid.rows)
    return rf"\begin{{aligned}} {body} \end{{aligned}}"


def _definite(box: Definite) -> str:
    lower = f"_{{{latex_of(box.lower)}}}" if box.lower else ""
    upper = f"^{{{latex_of(box.upper)}}}" if box.upper else ""
    tail = rf"\,\mathrm{{d}}{latex_of(box.variable)}" if box.variable else ""
    return f"{LATEX_SIGNS[box.sign]}{lower}{upper} {latex_of(box.body)}{tail}"


def escape(text: str) -> str:
    """Escape prose for LaTeX."""
    special = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    special |= {sign: f"\\{sign}" for sign in "&%$#_{}"}
    return "".join(special.get(letter, letter) for letter in text)
