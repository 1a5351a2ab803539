"""Equality of values that hold arrays: ``==`` of a dataclass would ask an array for one truth value."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any


class ByValue:
    """A dataclass (``eq=False``) that equals another of its class with equal fields; NaN equals NaN."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        names = [field.name for field in dataclasses.fields(self) if field.compare]  # type: ignore[arg-type]
        return all(same(getattr(self, name), getattr(other, name)) for name in names)

    __hash__ = None  # type: ignore[assignment]


def same(one: Any, other: Any) -> bool:
    """Tell whether two values are equal, arrays of any library and containers of them included.

    Args:
        one, other: numbers, arrays, mappings, tuples and lists, or values with an ``==`` that gives one truth value.
    """
    if one is other:
        return True
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(value, other[key]) for key, value in one.items())
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if getattr(one, "shape", ()) != getattr(other, "shape", ()):
        return False
    equal, neither = one == other, (one != one, other != other)  # NaN alone differs from itself
    if not hasattr(equal, "all"):
        return bool(equal) or all(neither)
    return bool((equal | (neither[0] & neither[1])).all())
