"""The shape of a catalog entry: which keys a table may have, of what type, and one line for every fault.

The schema is data; catalog/README.md says in words what every key means. Nothing here knows mechanics.
"""

from __future__ import annotations

import difflib
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal

from hjsolve.display.first_lines import MOST_LINES
from hjsolve.display.visible_text import hidden_character

VERDICTS = ("liouville", "staeckel", "reduced", "linear", "refused")
PARTS = ("metric", "potential", "gyroscopic")
KINDS = ("libration", "rotation", "escape", "equilibrium", "asymptotic", "boundary", "ignorable")
ASSUMPTIONS = ("real", "positive", "negative", "nonnegative", "nonzero", "integer")
QUANTITY = re.compile(
    r"(?:(?P<cycle>period|action|frequency|q|p|velocity|boundary_time)\.(?P<coordinate>\w+)"
    r"|turning_point\.(?P<turning>\w+)\.(?:lower|upper)|constant\.(?P<constant>\w+))"
)
_WORDS = {
    "text": "a text", "texts": "a list of texts", "number": "a number, best as a text such as \"1.2\"",
    "numbers": "a table of numbers", "formulas": "a table of texts", "matrix": "a list of rows of texts",
    "flag": "true or false", "table": "a table", "tables": "a list of tables", "named": "a table of tables",
}  # fmt: skip

_EXAMPLES = {
    "coordinates": '[{name = "r", domain = "0 < r"}]', "parameters": '[{name = "k", value = 1}]', "name": '"r"',
    "domain": '"0 < r"', "kinetic": '"m*dot(x)**2/2"', "potential": '"k*x**2/2"', "id": '"my-oscillator"',
    "title": '"My oscillator"', "q": '{r = "1.2"}', "velocity": '{r = 0}', "p": '{r = 0}',
    "place": '{x = "r*cos(phi)"}', "units": '{r = "m"}', "functions": '["v(r)"]',
}  # fmt: skip
"""What may be written for a key, for messages."""


@dataclass(frozen=True)
class Key:
    """What one key holds: a type word of ``_WORDS``, whether it must be there, its own keys, the values allowed."""

    type: str
    required: bool = False
    keys: Mapping[str, Key] = field(default_factory=dict)
    choices: tuple[str, ...] = ()


_TEXT, _NUMBERS, _FORMULAS = Key("text"), Key("numbers"), Key("formulas")
_COORDINATE = {"name": Key("text", True), "domain": Key("text", True), "unit": _TEXT, "meaning": _TEXT}
_PARAMETER = {
    "name": Key("text", True), "value": Key("number"), "assume": Key("text", choices=ASSUMPTIONS), "unit": _TEXT,
    "meaning": _TEXT,
}  # fmt: skip
_MOTION = {
    "summary": _TEXT, "q": Key("numbers", True), "velocity": _NUMBERS, "p": _NUMBERS, "parameters": _NUMBERS,
    "kinds": _FORMULAS,
}  # fmt: skip
_EFFECT = {
    "summary": Key("text", True), "kinetic": _TEXT, "potential": _TEXT, "parameters": Key("tables", keys=_PARAMETER),
    "force": _FORMULAS, "verdict": Key("text", choices=VERDICTS), "cite": Key("texts"),
}  # fmt: skip
_LIOUVILLE = Key("table", keys={name: Key("formulas", True) for name in ("f", "R", "v")})
_STAECKEL = Key("table", keys={"matrix": Key("matrix", True), "column": Key("texts", True)})
_EXPECT = {
    "verdict": Key("text", True, choices=VERDICTS), "ignorable": Key("texts"), "pair": Key("texts"),
    "part": Key("text", choices=PARTS), "liouville": _LIOUVILLE, "staeckel": _STAECKEL,
    "reduced": Key("table", keys={"liouville": _LIOUVILLE, "staeckel": _STAECKEL}),
}  # fmt: skip
_REFERENCE = {
    "quantity": Key("text", True), "at": Key("numbers", True), "value": Key("text", True), "how": Key("text", True),
    "cite": Key("texts"),
}  # fmt: skip
_CLOSED = {"kinds": _FORMULAS, "formulas": Key("formulas", True), "modulus": _TEXT, "how": _TEXT, "cite": Key("texts")}
_FRAME = {
    "coordinates": Key("tables", True, keys=_COORDINATE), "kinetic": Key("text", True), "potential": _TEXT,
    "place": Key("formulas"), "gauge": _TEXT,
}  # fmt: skip
_RELATIVITY = {"mass": Key("text", True), "light": Key("text", True)}
_CONSTRAINT = {
    "form": Key("text", True), "coordinates": Key("texts"), "integral": _TEXT, "constant": Key("number"), "name": _TEXT,
}  # fmt: skip
SYSTEM = {
    "id": _TEXT, "title": _TEXT, "coordinates": Key("tables", True, keys=_COORDINATE),
    "parameters": Key("tables", keys=_PARAMETER), "kinetic": Key("text", True), "potential": _TEXT,
    "signature": Key("text", choices=("definite", "indefinite")), "relativity": Key("table", keys=_RELATIVITY),
    "hamiltonian": _TEXT, "functions": Key("texts"), "place": Key("formulas"), "units": Key("formulas"),
    "constraint": Key("tables", keys=_CONSTRAINT),
}  # fmt: skip
"""The keys of an inline ``[system]`` table."""
ENTRY = SYSTEM | {
    "id": Key("text", True), "title": Key("text", True), "summary": _TEXT, "cite": Key("texts"), "book": Key("texts"),
    "reason": _TEXT, "instead": _TEXT, "initial": Key("table", keys=_MOTION), "motions": Key("named", keys=_MOTION),
    "effects": Key("named", keys=_EFFECT), "expect": Key("table", keys=_EXPECT),
    "reference": Key("tables", keys=_REFERENCE), "closed": Key("tables", keys=_CLOSED),
    "frame": Key("table", keys=_FRAME),
}  # fmt: skip
"""The keys of a catalog file."""


_MOST_WORDS, _FEW_WORDS = 40, 8


def nearest(word: str, known: object) -> str:
    """Return the hint `; did you mean "x"?`, or the words known, or nothing.

    Args:
        word: what the user wrote.
        known: the words that would have been right; any other object gives no hint.
    """
    words = [str(w) for w in known] if isinstance(known, (Mapping, tuple, list, frozenset)) else []
    close = difflib.get_close_matches(word, words, n=1, cutoff=0.6)
    if close:
        return f'; did you mean "{close[0]}"?'
    if len(words) > _MOST_WORDS:
        return f"; known are {', '.join(words[:_FEW_WORDS])} and {len(words) - _FEW_WORDS} more"
    return f"; known are {', '.join(words)}" if words else ""


def optional(keys: Mapping[str, Key], *names: str) -> dict[str, Key]:
    """Return the same keys, with these no longer required.

    Args:
        keys: the schema of a table.
        *names: of the keys that may be left out.
    """
    return {name: replace(key, required=False) if name in names else key for name, key in keys.items()}


def faults(table: object, keys: Mapping[str, Key], where: str = "") -> Iterator[str]:
    """List where a table does not follow its schema, one line each, ``key: what is wrong``.

    Args:
        table: as it was read.
        keys: its schema.
        where: place of the table in its file, put before each key.
    """
    if not isinstance(table, Mapping):
        yield f"{where or 'the file'}: must be a table, not {_shown(table)}"
        return
    prefix, others = f"{where}." if where else "", 0
    for name, value in table.items():
        if name in keys:
            yield from _value_faults(value, keys[name], f"{prefix}{name}")
        else:
            others += 1
            hint = nearest(str(name), keys) if others <= MOST_LINES else ""  # more are not shown
            yield f"{prefix}{name}: unknown key{hint}"
    for name, key in keys.items():
        if key.required and name not in table:
            yield f"{prefix}{name}: missing; it must be {_WORDS[key.type]}{_example(name)}"


def _value_faults(value: object, key: Key, where: str) -> Iterator[str]:
    if not _fits(value, key.type):
        yield f"{where}: must be {_WORDS[key.type]}, not {_shown(value)}{_example(where)}"
    elif hidden := _hidden(value):
        yield f"{where}: the character {hidden} in it cannot be displayed; leave it out"
    elif key.choices and value not in key.choices:
        yield f'{where}: "{value}" is not known{nearest(str(value), key.choices)}'
    elif key.type == "table":
        yield from faults(value, key.keys, where)
    elif key.type == "tables" and isinstance(value, list):
        for place, item in enumerate(value, start=1):
            yield from faults(item, key.keys, f"{where}[{place}]")
    elif key.type == "named" and isinstance(value, Mapping):
        for name, item in value.items():
            yield from faults(item, key.keys, f"{where}.{name}")


def _example(where: str) -> str:
    name = where.rpartition(".")[2]
    return f"; write {name} = {_EXAMPLES[name]}" if name in _EXAMPLES else ""


def _hidden(value: object) -> str:
    """Return the first control or bidirectional character of a text, or of a list, table or matrix of texts."""
    if isinstance(value, str):
        return hidden_character(value)
    if isinstance(value, Mapping):
        found = (_hidden(part) for pair in value.items() for part in pair if not isinstance(part, Mapping))
        return next(filter(None, found), "")
    return next(filter(None, map(_hidden, value)), "") if isinstance(value, list) else ""


def _fits(value: object, kind: str) -> bool:
    match kind:
        case "text":
            return isinstance(value, str)
        case "number":
            return _is_number(value)
        case "flag":
            return isinstance(value, bool)
        case "texts":
            return isinstance(value, list) and all(isinstance(item, str) for item in value)
        case "matrix":
            return isinstance(value, list) and all(_fits(row, "texts") for row in value)
        case "tables":
            return isinstance(value, list) and all(isinstance(item, Mapping) for item in value)
        case "numbers":
            return isinstance(value, Mapping) and all(_is_number(item) for item in value.values())
        case "formulas":
            return isinstance(value, Mapping) and all(isinstance(item, str) for item in value.values())
        case _:
            return isinstance(value, Mapping)


def _is_number(value: object) -> bool:
    return isinstance(value, (str, int, float, Decimal)) and not isinstance(value, bool)


def _shown(value: object) -> str:
    words = {bool: "true or false", dict: "a table", list: "a list", str: "a text", int: "an integer"}
    text = " ".join(str(value).split())
    return f"{words.get(type(value), type(value).__name__)} ({text[:40]})"


def unknown(given: Iterable[str], known: Iterable[str], where: str, what: str) -> Iterator[str]:
    """Yield a fault for every word that is not among those known.

    Args:
        given: the words found.
        known: those that are right.
        where: place in the file, for the message.
        what: what the words name, for the message.
    """
    words = list(known)
    others = (word for word in given if word not in words)
    for count, word in enumerate(others):
        yield f'{where}: no {what} "{word}"{nearest(word, words) if count < MOST_LINES else ""}'


def repeated(tables: list[Mapping[str, object]], where: str) -> Iterator[str]:
    """Yield a fault for every name that stands in more than one table.

    Args:
        tables: each with a ``name``.
        where: place in the file, for the message.
    """
    counts = Counter(table["name"] for table in tables)
    yield from (f'{where}: "{name}" is declared twice' for name, count in counts.items() if count > 1)
