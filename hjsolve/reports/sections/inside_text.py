"""Formulas written plainly inside a sentence, ``R = d*sinh(u)*cos(w)`` or ``sqrt(2g/r)``, found and set as mathematics.

The catalog's remarks and the symbolic half's reasons are plain text. What is a formula is decided by its shape: a
power, a product, a call of a known function, or a quotient of names that the system declares. Anything else is prose.
A formula is set as it is written, term by term: nothing is evaluated or reordered.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from hjsolve.errors import required
from hjsolve.formulas.checked_arithmetic import FUNCTIONS
from hjsolve.reports.document import Mathematics
from hjsolve.reports.formulas.from_sympy import APPLY, MINUS, TIMES, on_a_line
from hjsolve.reports.formulas.layout import Box, Fence, Fraction, Glyph, RadicalBox, RowBox, Script, row
from hjsolve.reports.formulas.names import FUNCTION_NAMES, GREEK, name_box

_TOKEN = re.compile(
    r" *(?:(?P<number>\d+(?:\.\d+)?)|(?P<name>[A-Za-z]\w*)|(?P<operator>\*\*|->|-\+|\+-|[-+*/^=(),<>≠]))"
)
_STEM = re.compile(r"([A-Za-z]+?)_?\d*")
_RELATIONS = {"=", "<", ">", "≠"}
_SIGNS = {"+": "+", "-": MINUS, "-+": "∓", "+-": "±"}


def formulas(text: str, names: Collection[str]) -> Iterator[str | Mathematics]:
    """Split a sentence into words and formulas.

    Returns:
        Its pieces in order; empty words are left out.
    """
    start = place = 0
    while place < len(text):
        found = _Reader(text, names).formula(place) if _may_begin(text, place) else None
        if found is None:
            place += 1
            continue
        if text[start:place]:
            yield text[start:place]
        yield Mathematics(found.box)
        start = place = found.end
    if text[start:]:
        yield text[start:]


def _may_begin(text: str, place: int) -> bool:
    """Whether a formula may begin here: not inside a word or a number, nor after an operator that belongs to it."""
    before = text[place - 1] if place else " "
    return (text[place].isalnum() or text[place] in "(-") and not re.match(r"[\w.*^/)]", before)


@dataclass(frozen=True)
class _Found:
    """A piece of a formula and the place after it."""

    box: Box
    end: int


@dataclass(frozen=True)
class _Reader:
    """Reads sums of products of powers, from left to right, as far as they go."""

    text: str
    names: Collection[str]

    def formula(self, place: int) -> _Found | None:
        """Return the longest formula from a place on, sides of an equation included.

        None where none is worth setting.
        """
        found = self._sum(place, inner=False)
        while found is not None and (token := self._token(found.end)) and token["operator"] in _RELATIONS:
            side = self._sum(token.end(), inner=False)
            if side is None:
                break
            found = _Found(row(found.box, Glyph(token["operator"], "operator"), side.box), side.end)
        if found is None or re.match(r"[\w(^*/]", self.text[found.end : found.end + 1]):
            return None
        return found if self._telling(place, found.end) else None

    def _telling(self, start: int, end: int) -> bool:
        tokens = list(_TOKEN.finditer(self.text, start, end))
        operators, words = {m["operator"] for m in tokens}, [m["name"] for m in tokens if m["name"]]
        called = any(word in FUNCTIONS or word == "dot" for word in words)
        declared = all(word in self.names or word in GREEK or word in FUNCTIONS for word in words)
        return bool(called or operators & {"*", "**", "^"} or ("/" in operators and declared))

    def _token(self, place: int) -> re.Match[str] | None:
        return _TOKEN.match(self.text, place)

    def _sum(self, place: int, *, inner: bool) -> _Found | None:
        found = self._signed(place, inner=inner)
        while found is not None and (token := self._token(found.end)) and token["operator"] in _SIGNS:
            term = self._product(token.end(), inner=inner)
            if term is None:
                return found
            found = _Found(row(found.box, Glyph(_SIGNS[token["operator"]], "operator"), term.box), term.end)
        return found

    def _signed(self, place: int, *, inner: bool) -> _Found | None:
        token = self._token(place)
        if token is None or token["operator"] != "-":
            return self._product(place, inner=inner)
        term = self._product(token.end(), inner=inner)
        return term and _Found(row(Glyph(MINUS, "operator"), term.box), term.end)

    def _product(self, place: int, *, inner: bool) -> _Found | None:
        """Return factors with * and / between them; inside brackets a blank is a product as well."""
        found = self._power(place)
        while found is not None and (token := self._token(found.end)):
            if token["operator"] in {"*", "/"}:
                factor = self._power(token.end())
            elif inner and (token["name"] or token["operator"] == "(") and self.text[found.end] == " ":
                factor = self._power(found.end)
            else:
                return found
            if factor is None:
                return found
            shown = self._quotient(found.box, factor) if token["operator"] == "/" else None
            found = _Found(shown or _beside(found.box, factor.box), factor.end)
        return found

    def _quotient(self, above: Box, factor: _Found) -> Box:
        """Return a/b on one line, as books set it inside a sentence; a fraction where more factors follow."""
        token = self._token(factor.end)
        if isinstance(above, Fraction) or (token and token["operator"] in {"*", "/"}):
            return Fraction(_bare(above), _bare(factor.box))
        below = factor.box
        if isinstance(below, RowBox) and isinstance(below.items[0], Glyph) and below.items[0].kind == "number":
            below = Fence(below)  # P^2/2m
        return row(above, Glyph("/", "operator"), below)

    def _power(self, place: int) -> _Found | None:
        token = self._token(place)
        if token is None:
            return None
        if token["name"] and (token["name"] in FUNCTIONS or token["name"] == "dot"):
            return self._call(token)
        base = self._operand(token)
        return base and self._raised(base)

    def _raised(self, base: _Found) -> _Found | None:
        """Return a base with the exponent that follows it, if one does."""
        exponent = self._exponent(base.end)
        if exponent is None:
            return base
        inner = base.box
        if isinstance(inner, Script) and inner.sup is None:
            return _Found(Script(inner.base, inner.sub, exponent.box), exponent.end)
        return _Found(Script(inner, sup=exponent.box), exponent.end)

    def _exponent(self, place: int) -> _Found | None:
        token = self._token(place)
        if token is None or token["operator"] not in {"**", "^"}:
            return None
        token = self._token(token.end())
        if token is not None and token["operator"] == "-":
            found = self._power(token.end())
            return found and _Found(row(Glyph(MINUS, "operator"), found.box), found.end)
        found = self._operand(token) if token is not None else None
        return found and _Found(on_a_line(_bare(found.box)), found.end)

    def _operand(self, token: re.Match[str]) -> _Found | None:
        if token["operator"] == "(":
            inside = self._sum(token.end(), inner=True)
            closing = self._token(inside.end) if inside is not None else None
            if inside is None or closing is None or closing["operator"] != ")":
                return None
            return _Found(Fence(inside.box), closing.end())
        if token["number"]:
            number = Glyph(token["number"], "number")
            if not re.match(r"[A-Za-z]", self.text[token.end() : token.end() + 1]):
                return _Found(number, token.end())
            factor = self._power(token.end())  # 2g
            return factor and _Found(row(number, factor.box), factor.end)
        if not token["name"] or self.text[token.end() : token.end() + 1] == "(" or not self._known(token["name"]):
            return None
        return _Found(typeset_name(token["name"], self.names), token.end())

    def _call(self, token: re.Match[str]) -> _Found | None:
        name, opening = token["name"], self._token(token.end())
        if opening is None or opening["operator"] != "(":
            return None
        argument = self._operand(opening)
        if argument is None or not isinstance(argument.box, Fence):
            return None
        inside = argument.box.body
        if name == "sqrt":
            return self._raised(_Found(RadicalBox(inside), argument.end))
        if name == "dot":
            token_inside = required(self._token(opening.end()))
            return self._raised(_Found(name_box(f"dot({token_inside['name']})"), argument.end))
        head: Box = Glyph(FUNCTION_NAMES.get(name, name), "function")
        exponent, end = self._exponent(argument.end), argument.end
        if exponent is not None:
            head, end = Script(head, sup=exponent.box), exponent.end
        plain = isinstance(inside, Glyph | Script)
        return _Found(row(head, Glyph(APPLY, "operator"), inside) if plain else row(head, argument.box), end)

    def _known(self, name: str) -> bool:
        """Return whether a word is a name: declared, or a letter as formulas have it: x, dx, x1, gamma_12, p_theta."""
        if several(name, self.names):
            return True
        match = _STEM.fullmatch(name.removeprefix("p_"))
        stem = match[1] if match else ""
        declared = name in self.names or name.removeprefix("p_") in self.names
        return declared or stem in GREEK or len(stem) == 1 or (len(stem) == 2 and stem[0] == "d")


def several(name: str, names: Collection[str]) -> list[str]:
    """Return the coordinates that a letter has as indices, ``E_x_y``; none where that is not what the word is."""
    letter, *indices = name.split("_")
    return indices if len(letter) == 1 and indices and all(index in names for index in indices) else []


def typeset_name(name: str, names: Collection[str]) -> Box:
    """Set a name; E_x_y has two indices with a comma between them.

    Args:
        name: the word.
        names: of the coordinates.
    """
    indices = several(name, names)
    if len(indices) < 2:
        return Glyph("π") if name == "pi" else name_box(name)
    listed = [piece for index in indices for piece in (Glyph(",", "operator"), name_box(index))][1:]
    return Script(name_box(name[0]), row(*listed))


def _bare(box: Box) -> Box:
    """Return a numerator, denominator or exponent needs no brackets of its own."""
    return box.body if isinstance(box, Fence) else box


def _beside(left: Box, right: Box) -> Box:
    ends_in_number = isinstance(left, Glyph) and left.kind == "number"
    starts_with_number = isinstance(right, Glyph) and right.kind == "number"
    return row(left, Glyph(TIMES, "operator"), right) if ends_in_number and starts_with_number else row(left, right)
