"""What an argument must be: wrong kinds are refused when a call is made, in the same words everywhere.

Values are checked where they are read (``formulas.read.number``, ``catalog.schema``); here is only what would otherwise
end as an ``AttributeError`` or ``TypeError`` from deep inside.

Here ``value`` is what came, and ``source`` what it is called in errors.
"""

from __future__ import annotations

import functools
import inspect
import math
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, ParamSpec, TypeVar

from hjsolve.errors import InvalidInputError

MOST_DIGITS = 2000


_P = ParamSpec("_P")
_R = TypeVar("_R")


def by_name(example: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Let a method take its arguments by name only, and say so in one of our errors where they come otherwise.

    The signature that ``help`` shows stays that of the method.

    Args:
        example: a call to write instead.

    Returns:
        The decorator; what it makes raises ``InvalidInputError`` for arguments by position, unknown or missing names.
    """

    def decorate(method: Callable[_P, _R]) -> Callable[_P, _R]:
        known = dict(list(inspect.signature(method).parameters.items())[1:])
        with_names = with_known_names(example)(method)

        @functools.wraps(method)
        def checked(*positional: _P.args, **named: _P.kwargs) -> _R:
            if len(positional) > 1:
                raise InvalidInputError(f"{method.__name__}: arguments go by name; write {example}")
            needed = (name for name, argument in known.items() if argument.default is argument.empty)
            missing = next((name for name in needed if name not in named), None)
            if missing is not None and named.keys() <= known.keys():
                raise InvalidInputError(f"{method.__name__}: no {missing}={{…}}; write {example}")
            return with_names(*positional, **named)

        return checked

    return decorate


def with_known_names(example: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Let a function refuse argument names that it does not have, and the lack of one that it needs, in our own words.

    Args:
        example: a call to write instead.

    Returns:
        The decorator; what it makes raises ``InvalidInputError`` where Python would raise ``TypeError``.
    """

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        signature = inspect.signature(function)
        known = [name for name in signature.parameters if name != "self"]

        @functools.wraps(function)
        def checked(*positional: _P.args, **named: _P.kwargs) -> _R:
            try:
                signature.bind(*positional, **named)
            except TypeError as error:
                other = next((name for name in named if name not in known), None)
                fault = f"{error}" if other is None else f'no argument "{other}"; known are {", ".join(known)}'
                raise InvalidInputError(f"{example.partition('(')[0]}: {fault}; write {example}") from None
            return function(*positional, **named)

        return checked

    return decorate


def refuse_other(value: object, kinds: type | tuple[type, ...], source: str, needed: str) -> None:
    """Raise unless a value is of these kinds.

    Args:
        kinds: what it may be.
        source: the name of the argument, or of the function where it has only one.
        needed: what is needed, with what to write, e.g. "a System is needed, e.g. from catalog.load".

    Raises:
        InvalidInputError: it is something else.
    """
    if not isinstance(value, kinds):
        raise InvalidInputError(f"{source}: {needed}, not {described(value)}")


def refuse_unused(given: Mapping[str, bool], reason: str) -> None:
    """Raise for what was given and would not be used.

    Args:
        given: name of an argument or option → whether it was given.
        reason: why it is not used, for the message.

    Raises:
        InvalidInputError: one was given.
    """
    for name, is_given in given.items():
        if is_given:
            raise InvalidInputError(f"{name}: is not used, because {reason}; leave it out")


def table(value: object, source: str, example: str = '{"r": 1}') -> Mapping[str, Any]:
    """Return a table name → value, None counting as empty; Greek letters in names are spelled.

    Args:
        example: what could be written instead, for the message.

    Raises:
        InvalidInputError: it is not a mapping.
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InvalidInputError(f"{source}: a table name → value is needed, such as {example}, not {described(value)}")
    if all(not isinstance(name, str) or name.isascii() for name in value):
        return value
    return {ascii_name(name): item for name, item in value.items()}


def one_for_each(value: object, source: str, names: Sequence[str], example: str) -> Mapping[str, Any]:
    """Return a table that has a formula for each of some names, and for nothing else.

    Args:
        names: of coordinates.
        example: what could be written instead, for the message.

    Raises:
        InvalidInputError: it is not a mapping, or its names are others.
    """
    found = table(value, source, example)
    if set(found) != set(names):
        raise InvalidInputError(f"{source}: a formula of each of {', '.join(names)} is needed, and of nothing else")
    return found


def ascii_name(name: Any) -> Any:
    """Return a name with its Greek letters spelled: ``θ1`` is theta1, ``p_φ`` is p_phi, ``λ`` is lam, ``Ω`` is Omega.

    Letters that have no such name are left as they are, and so is what is not text.
    """
    if not isinstance(name, str) or name.isascii():
        return name
    return "".join(map(_spelled_letter, unicodedata.normalize("NFKC", name)))


def _spelled_letter(letter: str) -> str:
    match = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER ([A-Z]+)", unicodedata.name(letter, ""))
    if match is None:
        return letter
    name = {"LAMDA": "lam"}.get(match[2], match[2].lower())
    return name if match[1] == "SMALL" else {"lam": "Lambda"}.get(name, name.capitalize())


def words(value: object, source: str, example: str) -> frozenset[str]:
    """One word or several.

    Args:
        example: what could be written instead, for the message.

    Raises:
        InvalidInputError: neither a text nor a list of texts.
    """
    if isinstance(value, str):
        return frozenset({value})
    found: list[object] = list(value) if isinstance(value, Iterable) else [value]
    texts = [word for word in found if isinstance(word, str)]
    if len(texts) < len(found):
        raise InvalidInputError(f"{source}: words are needed, such as {example}, not {described(value)}")
    return frozenset(texts)


def whole(value: object, source: str, lowest: int | None = None, highest: int | None = None) -> int:
    """Return a whole number; ``True`` is none.

    Args:
        lowest, highest: bounds, both allowed; None for no bound.

    Raises:
        InvalidInputError: not whole, or out of bounds.
    """
    if type(value) is int and (lowest is None or lowest <= value) and (highest is None or value <= highest):
        return value
    bounds = "" if lowest is None else f" from {lowest} on" if highest is None else f" from {lowest} to {highest}"
    raise InvalidInputError(f"{source}: a whole number{bounds} is needed, not {described(value)}")


def digits(value: object) -> int:
    """Return how many digits are asked.

    Raises:
        InvalidInputError: not a whole number from 1 to ``MOST_DIGITS``.
    """
    return whole(value, "digits", 1, MOST_DIGITS)


def seconds(value: object, source: str) -> float:
    """Return a number of seconds, from 0 on; ``math.inf`` is one.

    Raises:
        InvalidInputError: no number, negative, or NaN.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not value >= 0:  # type: ignore[operator]
        raise InvalidInputError(f"{source}: a number of seconds, from 0 on, is needed, not {described(value)}")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def described(value: object) -> str:
    """Return a value as a message shows it: itself where that is short, else its kind."""
    plain, shown = isinstance(value, (str, bytes, int, float, complex, type(None))), repr(value)
    return shown if plain and len(shown) < 40 else f"a value of type {type(value).__name__}"
