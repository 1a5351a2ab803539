"""An answer of the theorem as tools as one JSON object: formulas as text, numbers as text where they are exact."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TypeAlias

import sympy as sp

from hjsolve.arithmetic.propagation import short_bound
from hjsolve.mechanics.system import System

Json: TypeAlias = "str | float | list[Json] | dict[str, Json] | None"


def print_answer(answer: object) -> None:
    """Print an answer, or a table of answers.

    Args:
        answer: a value of ``hjsolve.theorem`` or ``hjsolve.extended.impacts``, or lists and tables of them.
    """
    json.dump(plain(answer), sys.stdout, ensure_ascii=False, indent=1, allow_nan=False)
    sys.stdout.write("\n")


def plain(value: object) -> Json:
    """Return a value as JSON holds it: the class of an answer is its ``kind``.

    Args:
        value: as in ``print_answer``.
    """
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    if isinstance(value, sp.MatrixBase):
        return [[str(x) for x in value.row(i)] for i in range(value.rows)]
    if isinstance(value, System):
        domains = {c.name: c.domain.written(c.name) for c in value.coordinates}
        return {"kinetic": str(value.kinetic), "potential": str(value.potential), "coordinates": plain(domains),
                "eliminated": plain(dict(value.eliminated))}  # fmt: skip
    if hasattr(value, "error") and hasattr(value, "value"):
        return {"value": plain(value.value), "error": float(short_bound(value.error))}
    if is_dataclass(value):
        return {"kind": type(value).__name__, **{f.name: plain(getattr(value, f.name)) for f in fields(value)}}
    return str(value)
