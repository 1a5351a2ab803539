"""Values worked out in a row, expressed in the shape of the times that were asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import overload

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import AtTimes, Integers, Numbers
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.motion.state import Errors, KnownErrors, State
from hjsolve.motion.times import exact_numbers

Shape = tuple[int, ...] | None
"""Of the times; empty or None for one time."""


@overload
def shaped(values: Numbers, shape: Shape) -> AtTimes: ...
@overload
def shaped(values: Integers, shape: Shape) -> int | Integers: ...
@overload
def shaped(values: NDArray[np.str_], shape: Shape) -> str | NDArray[np.str_]: ...
def shaped(values: Numbers | Integers | NDArray[np.str_], shape: Shape) -> object:
    """Return values in the shape of the times; a plain number or word for one time.

    Args:
        values: shape (m,).
        shape: of the times; empty or None for one time.
    """
    if shape:
        return values.reshape(shape)
    return values[0].item() if hasattr(values[0], "item") else values[0]


def by_coordinate(names: Sequence[str], columns: Iterable[Numbers], shape: Shape) -> Iterator[dict[str, AtTimes]]:
    """Return q, p and velocity by coordinate in the shape of the times.

    Args:
        names: of the coordinates.
        columns: q of all of them, then p, then velocity, each of shape (m,).
        shape: of the times; empty or None for one time.
    """
    found = [shaped(column, shape) for column in columns]
    return (dict(zip(names, found[k * len(names) :], strict=False)) for k in range(3))


def gathered(column: Sequence[object], shape: tuple[int, ...]) -> object:
    """Return numbers or words that were worked out one by one in the shape of the times; one alone for one time.

    Args:
        column: one a time, in order; plain ones make an array of their own type, others one of objects.
        shape: of the times; empty for one time.
    """
    if not shape:
        return column[0]
    plain = all(isinstance(x, (float, int, str)) for x in column)
    return np.array(column, dtype=None if plain else object).reshape(shape)


def state_of_one(coordinate: Coordinate, t: object, rule: Callable[[sp.Expr], Sequence[object]]) -> State:
    """Return the state of a motion of one coordinate, worked out time by time.

    Args:
        coordinate: the one that moves.
        t: a time or an array of times.
        rule: exact time → q, p, dq/dt, bounds on their errors, status and whole turns.
    """
    shape, times = exact_numbers(t, "t")
    columns = list(zip(*map(rule, times), strict=True)) or [()] * 8
    *groups, status, turns = (gathered(column, shape) for column in columns)
    q, p, v, *errors = ({coordinate.name: group} for group in groups)
    counts = {coordinate.name: turns} if coordinate.domain.kind == "angle" else {}
    return State(t, q, p, v, counts, status, KnownErrors(Errors(*errors)))
