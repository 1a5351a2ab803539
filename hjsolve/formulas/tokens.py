"""Text of a formula → tokens, and what to write instead where a character or a word is not one.

A formula is ASCII, but for Greek letters, which are read as their names: numbers, names,
``+ - * / **``, round brackets, commas and the prime of a velocity; ``^`` is read as ``**``. Everything else is refused
at its place with the spelling that would be accepted; nothing is guessed.
"""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from hjsolve.arguments import ascii_name
from hjsolve.errors import ExpressionError

MAX_CHARACTERS = 10_000
MAX_DIGITS = 1_000
_EXCERPT = 24

_TOKEN = re.compile(
    r"(?P<space>\s+)|(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_\u0370-\u03ff\u00b5][A-Za-z0-9_\u0370-\u03ff\u00b5]*)|(?P<operator>\*\*|[-+*/(),^'’′])|(?P<other>.)",
    re.DOTALL,
)

_DATE = re.compile(r"\s*[0-9]{4}-[01][0-9]-[0-3][0-9](\s*$|[T ][0-9]{2}:)")
"""A day, as in 2026-01-31, which is 1994 when it is read as a difference; or a moment of it."""

_SAME_OPERATOR = {"^": "**", "’": "'", "′": "'"}
_INSTEAD_OF_CHARACTER = {
    "=": "a formula has no equals sign; give one side of the equation alone",
    "[": "write round brackets ( )",
    "]": "write round brackets ( )",
    "{": "write round brackets ( )",
    "}": "write round brackets ( )",
    ".": "write * for a product",
    "|": "write abs(x) for an absolute value, sqrt(x**2 + y**2) for a length",
    "!": "write the factorial as a number",
    "%": "write a percentage as a number, 5% as 5/100",
    "\\": "write names without the backslash of TeX, theta for \\theta",
    ";": "one formula only",
    "√": "write sqrt(...)",
    "∞": "an infinite number is not accepted",
    "ħ": "write hbar",
    "ℏ": "write hbar",
    "∂": "write the derivative out",
    "∫": "write the integral out",
}
_INSTEAD_OF_CHARACTER |= dict.fromkeys("<>≤≥≠", "a formula has no comparison; bounds belong in a coordinate's domain")
_INSTEAD_OF_CHARACTER |= dict.fromkeys("−–—‐‑⁻", "write - (the ASCII minus)")
_INSTEAD_OF_CHARACTER |= dict.fromkeys("·×⋅∗∙•", "write * for a product")
_INSTEAD_OF_CHARACTER |= dict.fromkeys("÷∕⁄", "write / for a quotient")
_DOTS_AND_PRIMES = "`´\u0307\u0308"

_INSTEAD_OF_WORD = {
    "dot": "write dot(q) for the velocity of q",
    "ln": "write log",
    "arcsin": "write asin",
    "arccos": "write acos",
    "arctan": "write atan",
    "arcsinh": "write asinh",
    "arccosh": "write acosh",
    "arctanh": "write atanh",
    "tg": "write tan",
    "ctg": "write cot",
    "sh": "write sinh",
    "ch": "write cosh",
    "th": "write tanh",
    "log10": "write log(x)/log(10)",
    "log2": "write log(x)/log(2)",
    "pow": "write x**y",
    "abs": "absolute values have no derivative at zero; give each side its own domain and leave the bars out",
    "Abs": "absolute values have no derivative at zero; give each side its own domain and leave the bars out",
    "fabs": "absolute values have no derivative at zero; give each side its own domain and leave the bars out",
    "sign": "sign(x) jumps at zero; give each side its own domain",
    "sgn": "sgn(x) jumps at zero; give each side its own domain",
    "diff": "write dot(q) for a velocity",
    "Derivative": "write dot(q) for a velocity",
    "ddot": "accelerations do not occur in T and V",
    "e": "write exp(1) for the number e, exp(x) for e**x, or declare it",
    "E": "write exp(1) for the number e, exp(x) for e**x, or declare it",
    "i": "declare it as a parameter; there is no imaginary unit",
    "I": "declare it as a parameter; there is no imaginary unit",
    "j": "declare it as a parameter; there is no imaginary unit",
    "inf": "a number must be finite",
    "oo": "a number must be finite",
    "infinity": "a number must be finite",
    "nan": "a number must be finite",
    "max": "it has a crease where its arguments are equal; give each side its own domain",
    "min": "it has a crease where its arguments are equal; give each side its own domain",
    "Max": "it has a crease where its arguments are equal; give each side its own domain",
    "Min": "it has a crease where its arguments are equal; give each side its own domain",
    "Heaviside": "a step has no derivative; give each side its own domain",
    "heaviside": "a step has no derivative; give each side its own domain",
    "floor": "a step has no derivative; give each side its own domain",
    "ceil": "a step has no derivative; give each side its own domain",
    "Piecewise": "one formula for the whole domain; give each piece its own domain",
    "interp": "a table is not accepted; write a formula that was fitted to it",
    "t": "an explicit time is not accepted; T and V may depend on coordinates and velocities only. Where a moving "
    "frame or a gauge takes the time out, as for a force F(t) or a moving anchor, write that system and how it moves, "
    "[frame] in a file for hjsolve.frames.load",
    "Pi": "write pi",
    "PI": "write pi",
}
_INSTEAD_OF_WORD |= dict.fromkeys(
    ("erf", "erfc", "besselj", "besseli", "besselk", "hyp2f1"),
    "only elementary functions are accepted; write it by them, or approximate it",
)


class Token(NamedTuple):
    """One number, name, operator, or the end of the text, with its zero-based position."""

    kind: str
    text: str
    position: int


@dataclass(frozen=True)
class FormulaText:
    """A formula as it was given: what it is called and its text."""

    name: str
    text: str

    def error(self, message: str, position: int | None) -> ExpressionError:
        """Return the error to raise: ``potential, column 5: write ** for a power (in "m/2*r^2")``.

        Args:
            message: what to write instead.
            position: of the character at fault, from 0 on; None for the whole text.
        """
        place = "" if position is None else f", {self._place(position)}"
        excerpt = self._excerpt(position or 0)
        shown = f' (in "{excerpt}")' if excerpt else ""
        whole = f"{self.name}{place}: {message}{shown}"
        return ExpressionError(whole, source=self.name, text=excerpt, position=position)

    def _place(self, position: int) -> str:
        before = self.text[:position]
        line, column = before.count("\n") + 1, position - before.rfind("\n")
        return f"column {column}" if "\n" not in self.text.strip() else f"line {line}, column {column}"

    def _excerpt(self, position: int) -> str:
        start, stop = max(0, position - _EXCERPT), position + _EXCERPT
        piece = printable(self.text[start:stop])
        return ("…" if start > 0 else "") + piece + ("…" if stop < len(self.text) else "")


def printable(text: str) -> str:
    """Text on one line: white space as blanks, what cannot be printed as escapes.

    Args:
        text: any, also the user's.
    """
    shown = (" " if c.isspace() else c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return "".join(shown).strip()


def scan(source: FormulaText) -> list[Token]:
    """Split a formula into tokens; the last one is of kind ``end``.

    Args:
        source: the text, and what it is called in errors.

    Raises:
        ExpressionError: the text is empty, too long, holds a character or a number that is not accepted.
    """
    if len(source.text) > MAX_CHARACTERS:
        raise source.error(f"{len(source.text)} characters are too many; at most {MAX_CHARACTERS} are accepted", None)
    if _DATE.match(source.text):
        raise source.error("a date is not a number; write the time since t0 in the units of the system", None)
    tokens = []
    for match in _TOKEN.finditer(source.text):
        kind = str(match.lastgroup)
        if kind == "other":
            raise source.error(_instead_of_character(source.text, match.start()), match.start())
        if kind == "number":
            _check_number(match.group(), match.start(), source)
        if kind == "name" and not (word := ascii_name(match.group())).isascii():
            raise source.error(_instead_of_character(source.text, match.start()), match.start())
        if kind != "space":
            text = word if kind == "name" else _SAME_OPERATOR.get(match.group(), match.group())
            tokens.append(Token(kind, text, match.start()))
    if not tokens:
        raise source.error("the text is empty; write a formula such as m*x**2/2, or 0", None)
    return [*tokens, Token("end", "", len(source.text.rstrip()))]


def _check_number(text: str, position: int, source: FormulaText) -> None:
    digits, _, exponent = text.lower().partition("e")
    if len(digits) > MAX_DIGITS:
        raise source.error(f"a number of {len(digits)} digits is too long; at most {MAX_DIGITS} are accepted", position)
    if len(exponent) > 6 or abs(int(exponent or "0")) > MAX_DIGITS:
        raise source.error(f"the number is beyond 1e±{MAX_DIGITS}; choose other units", position)


def _instead_of_character(text: str, position: int) -> str:
    character = text[position]
    if character in _DOTS_AND_PRIMES:
        name = re.search(r"[A-Za-z_][A-Za-z0-9_]*$", text[:position])
        return f"write dot({name.group() if name else 'q'}) for a velocity"
    shown = f"{character!r}" if character.isprintable() else ascii(character)
    if character in _INSTEAD_OF_CHARACTER:
        return f"{shown} is not accepted; {_INSTEAD_OF_CHARACTER[character]}"
    index = "₀₁₂₃₄₅₆₇₈₉".find(character)
    if index >= 0:
        before = re.search(r"[A-Za-z_\u0370-\u03ff\u00b5][A-Za-z0-9_\u0370-\u03ff\u00b5]*$", text[:position])
        stem = before.group() if before else "x"
        return f"{shown} is not accepted; write the index as part of the name, {stem}{index}"
    return f"{shown} is not accepted; {_spelled(character)}"


def _spelled(character: str) -> str:
    """Return what to write for a Greek letter, a superscript, a letter with a dot; else that formulas are ASCII."""
    plain = unicodedata.normalize("NFKD", character)
    if plain[1:] in ("\u0307", "\u0308") and plain[:1].isascii():
        return f"write dot({plain[0]}) for a velocity"
    letter = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (\w+)", unicodedata.name(plain[:1], ""))
    if letter:
        name = {"LAMDA": "lam"}.get(letter[2], letter[2].lower())
        return f"write {name if letter[1] == 'SMALL' else name.capitalize()}"
    if plain.isascii() and plain.isdecimal():
        return f"write **{plain}"
    fraction = plain.replace("⁄", "/")
    if re.fullmatch(r"[0-9]+/[0-9]+", fraction):
        return f"write {fraction}"
    return "write formulas with plain ASCII letters, digits and + - * / ** ( )"


def nearest_name(word: str, known: Iterable[str]) -> str:
    """Return the known name that is spelled most like ``word``, or nothing.

    Args:
        word: what the user wrote.
        known: names that would have been right.
    """
    if len(word) > 40:
        return ""
    known = list(known)
    same = [name for name in known if name.lower() == word.lower()]
    return (same or difflib.get_close_matches(word, known, n=1, cutoff=0.6) or [""])[0]


def is_known_elsewhere(word: str) -> bool:
    """Return whether the word has a meaning of its own in other programs, so that nobody left it undetermined."""
    return word in _INSTEAD_OF_WORD


def instead_of_word(
    word: str, names: Iterable[str], velocities: Iterable[str], functions: Mapping[str, Callable[..., object]]
) -> str:
    """Return what to write for a word that is not declared.

    Args:
        word: what the user wrote.
        names: of coordinates and parameters.
        velocities: names of the coordinates whose velocities may be written.
        functions: those of the formula language.
    """
    names, velocities = list(names), list(velocities)
    shown = word if len(word) <= 40 else word[:40] + "…"
    velocity = coordinate_of_velocity(word, velocities, ("dot{}", "dot_{}", "d{}", "{}d", "{}_t", "v_{}"))
    if velocity:
        return f"{shown!r} is not declared; write dot({velocity}) for the velocity"
    if word in _INSTEAD_OF_WORD:
        return f"{shown!r} is not declared; {_INSTEAD_OF_WORD[word]}"
    product = _split(word, {*names, "pi"})
    if product:
        return f"{shown!r} is not declared; write {'*'.join(product)} for the product"
    for function in sorted(functions, key=len, reverse=True):
        if word.startswith(function) and word[len(function) :] in names:
            return f"{shown!r} is not declared; write {function}({word[len(function) :]})"
    momentum = word == "p" or (word.startswith("p_") and word[2:] in velocities)
    if velocities and momentum:
        velocity = f"dot({word[2:] or velocities[0]})"
        return f"{shown!r} is not declared; write T with {velocity}, or give H(q, p) to from_hamiltonian"
    near = nearest_name(word, [*names, *functions, "pi"])
    if near:
        return f"{shown!r} is not declared; did you mean {near}?"
    if not names:
        return f"{shown!r} is not declared; no names are declared here, write a number"
    declared = f"{', '.join(sorted(names)[:12])}{', …' if len(names) > 12 else ''}"
    cure = f'; declare a parameter, {{"{shown}": 1}} or --parameter {shown}=1' if velocities else ""
    return f"{shown!r} is not declared; declared are {declared}{cure}"


def coordinate_of_velocity(word: str, velocities: Iterable[str], spellings: Iterable[str] = ("{}dot", "{}_dot")) -> str:
    """Return the coordinate whose velocity a word spells, ``thetadot`` or ``theta_dot``; nothing where it spells none.

    Args:
        word: what the user wrote.
        velocities: names of the coordinates whose velocities may be written.
        spellings: of a velocity, with {} for the coordinate.
    """
    spelled = list(spellings)
    return next((name for name in velocities if word in {spelling.format(name) for spelling in spelled}), "")


def _split(word: str, names: set[str]) -> list[str]:
    """Write a word as a row of declared names, ``mgl`` as m, g, l; nothing where it is not one."""
    if not 2 <= len(word) <= 40:
        return []
    best: dict[int, list[str]] = {0: []}
    for stop in range(1, len(word) + 1):
        rows = [[*best[start], word[start:stop]] for start in best if word[start:stop] in names]
        if rows:
            best[stop] = min(rows, key=len)
    return best.get(len(word), [])
