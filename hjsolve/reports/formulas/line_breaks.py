"""Formulas too long for a line are broken before their signs, never inside a fraction, a root or a bracket."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Box, Glyph, Grid, RowBox, row, width

LINE, NARROW = 60.0, 34.0
"""Letters that fit on a line of a page, and of a narrow screen."""
_BREAKS = frozenset({"+", "−", "="})
_EMPTY = Glyph("", "text")
_NOTHING = Glyph("", "identifier")
"""Stands before the sign that a line begins with, so that the sign is that of a sum."""


def display(expression: sp.Basic, line: float = LINE) -> Box:
    """Lay out a displayed formula, on several lines where it is too long for one.

    Args:
        line: letters that fit on a line.

    Returns:
        The box; a borderless grid where the formula takes several lines.
    """
    return broken(box(expression), line)


def broken(whole: Box, line: float = LINE) -> Box:
    """Break a formula before its signs where it is too long.

    Args:
        whole: the formula on one line.
        line: letters that fit on a line.

    Returns:
        The same box where it fits or has nothing to break at; else a grid without fences, a line a row. The lines of an
        equation with a short left side stand under its right side.
    """
    if not isinstance(whole, RowBox) or width(whole) <= line:
        return whole
    parts = _split(whole.items, lambda item: isinstance(item, Glyph) and item.kind == "text" and item.text[:1] == ",")
    if len(parts) > 1:
        rows = [grown for part in parts for grown in _rows(broken(row(*part), line))]
        joined = (row(*(cell for cell in cells if cell != _EMPTY)) for cells in rows)
        return Grid(tuple((one,) for one in joined), "", "", "l")
    left, right = _sides(whole.items, line)
    lines = _filled(_terms(right), line - sum(map(width, left)))
    if len(lines) < 2:
        return whole
    if not left:
        return Grid(tuple((row(*terms),) for terms in lines), "", "", "l")
    head = row(*left)
    return Grid(tuple((_EMPTY if i else head, row(*terms)) for i, terms in enumerate(lines)), "", "", "rl")


def narrowed(shown: Box, line: float = NARROW) -> Box:
    """Break a formula anew for shorter lines.

    Args:
        shown: a formula that ``broken`` has seen.
        line: letters that fit on a line.

    Returns:
        The box; lines that have nothing to break at stay as long as they are.
    """
    if not isinstance(shown, Grid) or shown.left or shown.right:
        return broken(shown, line)
    lines = [row(*(cell for cell in cells if cell != _EMPTY)) for cells in shown.rows]
    if shown.align == "rl":
        items = [item for one in lines for item in (one.items if isinstance(one, RowBox) else (one,))]
        return broken(row(*(item for item in items if item != _NOTHING)), line)
    grown = (cells for one in lines for cells in _rows(broken(one, line)))
    return Grid(tuple((row(*(cell for cell in cells if cell != _EMPTY)),) for cells in grown), "", "", "l")


def _rows(shown: Box) -> tuple[tuple[Box, ...], ...]:
    return shown.rows if isinstance(shown, Grid) and not shown.left and not shown.right else ((shown,),)


def _sides(items: tuple[Box, ...], line: float) -> tuple[tuple[Box, ...], tuple[Box, ...]]:
    """Return the left side with its sign of equality, and the right side.

    The left one is empty where it is long itself.
    """
    equals = next((i for i, item in enumerate(items) if item == Glyph("=", "operator")), None)
    if equals is None or sum(map(width, items[: equals + 1])) > line / 3:
        return (), items
    return items[: equals + 1], items[equals + 1 :]


def _terms(items: tuple[Box, ...]) -> list[list[Box]]:
    """Return the items from each sign up to the next; a sign that another operator precedes belongs to its term."""
    terms: list[list[Box]] = [[]]
    for place, item in enumerate(items):
        before = items[place - 1] if place else None
        joined = before is None or (isinstance(before, Glyph) and before.kind == "operator")
        if isinstance(item, Glyph) and item.kind == "operator" and item.text in _BREAKS and not joined:
            terms.append([])
        terms[-1].append(item)
    return terms


def _filled(terms: list[list[Box]], line: float) -> list[list[Box]]:
    lines: list[list[Box]] = [[]]
    for term in terms:
        if lines[-1] and sum(map(width, lines[-1])) + sum(map(width, term)) > line:
            lines.append([_NOTHING])
        lines[-1] += term
    return lines


def _split(items: tuple[Box, ...], ends: Callable[[Box], bool]) -> list[list[Box]]:
    parts: list[list[Box]] = [[]]
    for item in items:
        if ends(item):
            parts[-1].append(Glyph(",", "operator"))
            parts.append([])
        else:
            parts[-1].append(item)
    return [part for part in parts if part]
