"""Short formulas in a sentence, such as ``dq/dt = ∂H/∂p``, found by their signs and set as formulas.

Sentences of reports hold letters and signs of Unicode, which every format shows. A page sets them like the formulas
around them: letters in italics, indices and powers as such. What is a formula is decided by its shape alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

from hjsolve.reports.formulas.layout import Box, Dotted, Fence, Glyph, Script, row
from hjsolve.reports.formulas.names import LOWERED, RAISED

_RAISED = {RAISED[letter]: letter for letter in "0123456789nTh"}
_LOWERED = {LOWERED[letter]: letter for letter in "0123456789ijk"}
_FUNCTIONS = "arcsin|arccos|arctan|sin|cos|tan|sgn|exp|ln|log|sn|cn|dn|am"
_TOKEN = re.compile(
    rf"(?P<function>{_FUNCTIONS})(?![A-Za-z])"
    r"|(?P<letter>d[A-Za-z](?![A-Za-z])|[A-Za-z](?![A-Za-z])|[α-ωΑ-Ω](?![α-ωΑ-Ω]))(?P<dot>\u0307?)(?P<prime>[′]*)"
    rf"(?P<sub>[{''.join(_LOWERED)}]*)(?P<sup>[{''.join(_RAISED)}]*)"
    r"|(?P<number>\d+(?:\.\d+)?|[½∞])"
    r"|(?P<sign>[=<>≤≥≠→±+−/·∂∑∮∫])|(?P<bracket>[(),])|(?P<blank> )"
)
_RELATIONS = "=<>≤≥≠→∂∑∮∫"
_ALONE = set("TVWHESJLKFRPQΠΛΩqptkh") | {chr(code) for code in range(ord("α"), ord("ω") + 1)}
_ARTICLES = {"a", "A", "I"}


def formulas_in_words(text: str) -> Iterator[str | Box]:
    """Split a sentence into words and the formulas in it.

    Args:
        text: plain text, as one reads it.

    Returns:
        Its pieces in order: words as they are, formulas as boxes.
    """
    start = place = 0
    while place < len(text):
        inside = re.search(r"[\w.'’/·-]$|\w\($", text[max(0, place - 2) : place])
        tokens = [] if inside else _run(text, place)
        if not tokens or not _meant(text, tokens):
            place += 1 if not text[place].isalnum() else len(re.match(r"\w+", text[place:])[0])  # type: ignore[index]
            continue
        if text[start : tokens[0].start()]:
            yield text[start : tokens[0].start()]
        yield _boxed(tokens)
        start = place = tokens[-1].end()
    if text[start:]:
        yield text[start:]


def _run(text: str, place: int) -> list[re.Match[str]]:
    """Return the longest run of letters, numbers and signs from a place on that reads as one formula."""
    tokens: list[re.Match[str]] = []
    depth, last = 0, 0
    while token := _TOKEN.match(text, place):
        blank_before = bool(tokens) and bool(tokens[-1]["blank"])
        operand = token["letter"] or token["number"] or token["function"]
        after_operand = len(tokens) > 1 and bool(tokens[-2]["letter"] or tokens[-2]["number"] or tokens[-2][0] == ")")
        related = any(t["sign"] for t in tokens)
        if not tokens and (
            token["blank"] or token["sign"] in {"=", "/", "+", "→", "<", ">"} or token["bracket"] in {")", ","}
        ):
            break
        if blank_before and operand and after_operand and (tokens[-2]["number"] or not (related and token["letter"])):
            break  # two words next to each other, or a number and its unit
        if (token["bracket"] == "," and depth == 0) or (token["bracket"] == ")" and depth == 0):
            break
        if tokens and token["bracket"] == "(" and blank_before and not related:
            break  # a remark in brackets
        depth += {"(": 1, ")": -1}.get(token["bracket"] or "", 0)
        tokens.append(token)
        place = token.end()
        if depth == 0 and (operand or token["bracket"] == ")"):
            last = len(tokens)
    return tokens[:last]


def _meant(text: str, tokens: list[re.Match[str]]) -> bool:
    """Whether a run is a formula rather than a letter of the language, a unit, or a name with initials."""
    before, after = text[: tokens[0].start()], text[tokens[-1].end() :]
    letters = [t for t in tokens if t["letter"]]
    if (
        not letters
        or re.match(r"[\w'’*^_\[\u0300-\u036f]|\(|-\w|/|\.\w|\. [A-Z]", after)
        or re.search(r"(?:\d|[A-Z]\.) $", before)
    ):
        return False
    if len(tokens) == 1:
        one = tokens[0]
        marked = one["sub"] or one["sup"] or one["dot"]
        return bool(marked) or one["letter"] in _ALONE
    if letters[0]["letter"] in _ARTICLES and letters[0] is tokens[0] and tokens[1]["blank"] and not tokens[2]["sign"]:
        return False
    called = any(t["letter"] and u["bracket"] == "(" for t, u in pairwise(tokens))
    return called or any(t["sign"] and t["sign"] in _RELATIONS for t in tokens) or any(t["function"] for t in tokens)


def _boxed(tokens: list[re.Match[str]]) -> Box:
    """Put a run together, what stands in brackets inside a fence."""
    levels: list[list[Box]] = [[]]
    for token in tokens:
        match token["bracket"]:
            case "(":
                levels.append([])
            case ")":
                inside = levels.pop()
                levels[-1].append(Fence(row(*inside)))
            case ",":
                levels[-1].append(Glyph(",", "operator"))
            case _:
                levels[-1] += _boxes_of(token)
    return row(*levels[0])


def _boxes_of(token: re.Match[str]) -> list[Box]:
    if token["blank"]:
        return []
    if token["function"]:
        return [Glyph(token["function"], "function"), Glyph("\u2061", "operator")]
    if token["number"]:
        return [Glyph(token["number"], "number")]
    if token["sign"]:
        return [Glyph(token["sign"], "differential" if token["sign"] == "∂" else "operator")]
    letter = token["letter"]
    head: list[Box] = [Glyph("d", "differential")] if len(letter) == 2 else []
    base: Box = Glyph(letter[-1] + token["prime"])
    if token["dot"]:
        base = Dotted(base)
    if token["sub"] or token["sup"]:
        base = Script(base, _script(token["sub"], _LOWERED), _script(token["sup"], _RAISED))
    return [*head, base]


def _script(marks: str, letters: dict[str, str]) -> Box | None:
    plain = "".join(letters[mark] for mark in marks)
    return Glyph(plain, "number" if plain.isdigit() else "identifier") if plain else None
