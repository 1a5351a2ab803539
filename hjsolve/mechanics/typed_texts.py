"""What somebody typed on a command line or a page: ``r: 0 < r``, ``m = 1``, ``k=2:positive``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from hjsolve.arguments import ascii_name
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.coordinates_and_parameters import Parameter, parameter

_NAME = re.compile(r"\s*(\w+)\s*")
_NEXT_VALUE = re.compile(r"(?:,\s*|\s+)(?=[^\W\d]\w*\s*=)")
"""The comma or the blanks between two values: a name and an equals sign stand behind it."""


def typed_coordinates(texts: Iterable[str], where: str) -> dict[str, str]:
    """Read coordinates, each a name, a colon and a domain.

    Args:
        texts: such as ``x: line`` or ``r: 0 < r``.
        where: what they were typed into, for messages.

    Returns:
        Name → domain, as ``System`` takes it.

    Raises:
        InvalidInputError: one cannot be read, or a name comes twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, colon, domain = text.partition(":")
        if not colon or not name.strip() or not domain.strip():
            raise InvalidInputError(
                f'{where} "{text}": write a name, a colon and a domain, e.g. "x: line" or "r: 0 < r"'
            )
        _once(found, name.strip(), where)
        found[ascii_name(name.strip())] = domain.strip()
    return found


def typed_parameters(texts: Iterable[str], where: str) -> dict[str, Parameter]:
    """Read parameters, each ``NAME``, ``NAME=VALUE``, ``NAME:ASSUMPTION`` or ``NAME=VALUE:ASSUMPTION``.

    Args:
        texts: as typed.
        where: what they were typed into, for messages.

    Returns:
        Name → parameter.

    Raises:
        InvalidInputError: one cannot be read, or a name comes twice.
    """
    found: dict[str, Parameter] = {}
    for text in texts:
        declared, colon, assume = text.partition(":")
        name, equals, value = declared.partition("=")
        if not _NAME.fullmatch(name) or (equals and not value.strip()) or (colon and not assume.strip()):
            raise InvalidInputError(
                f'{where} "{text}": write a name, a value and an assumption as wanted, e.g. m, m=1 or m=1:positive'
            )
        _once(found, name.strip(), where)
        plain = ascii_name(name.strip())
        found[plain] = parameter(plain, value.strip() if equals else None, assume=assume.strip() or "real")
    return found


def typed_values(texts: Iterable[str], where: str) -> dict[str, str]:
    """Read values, each a name, an equals sign and a number.

    Args:
        texts: such as ``r=1``, ``theta = pi/2`` or ``r=1, theta=pi/2``.
        where: what they were typed into, for messages.

    Returns:
        Name → text of the value.

    Raises:
        InvalidInputError: one cannot be read, or a name comes twice.
    """
    found: dict[str, str] = {}
    for text in (part for written in texts for part in _NEXT_VALUE.split(written)):
        name, equals, value = text.partition("=")
        if not equals or not _NAME.fullmatch(name) or not value.strip():
            raise InvalidInputError(f'{where} "{text}": write a name, an equals sign and a value, e.g. {where} r=1')
        _once(found, name.strip(), where)
        found[ascii_name(name.strip())] = value.strip()
    return found


def _once(found: Mapping[str, object], name: str, where: str) -> None:
    if ascii_name(name) in found:
        raise InvalidInputError(f'{where}: "{name}" is given twice')
