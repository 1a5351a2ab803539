"""Velocities in an ensemble: momenta rounded from 32 digits, and what the rounding adds to the errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.ensembles import engine
from hjsolve.ensembles.status import UNDECIDED, Status
from hjsolve.ensembles.task import TaskContext

Arrays = Mapping[str, Any]


def momenta_of(tools: TaskContext, q: Arrays, velocity: Arrays) -> tuple[dict[str, Any], dict[str, Any]]:
    """Momenta in doubles from velocities, and which of them are rounded.

    Args:
        tools: of the ensemble.
        q, velocity: coordinate → array of shape (n,).

    Returns:
        Coordinate → p, and coordinate → bool array, only of those with a rounded one.
    """
    names = [c.name for c in tools.solution.system.coordinates]
    arrays = [Pair(np.asarray(group[name], float), 0.0) for group in (q, velocity) for name in names]
    with np.errstate(all="ignore"):
        pairs = tools.momenta.run(DoubleDouble(), [*arrays, *tools.numbers])
    shape = np.shape(q[names[0]])
    p, rest = ({n: np.broadcast_to(pair[k], shape) for n, pair in zip(names, pairs, strict=True)} for k in (0, 1))
    return p, {name: low != 0 for name, low in rest.items() if np.any(low != 0)}


def run_from_velocities(tools: TaskContext, q: Arrays, velocity: Arrays) -> engine.Columns:
    """Run the vectorised engine on the momenta that velocities give, their rounding counted.

    Every momentum that was rounded is moved to the next double, both ways; what that does to a number is added to its
    error. An orbit that leaves ``OK`` on the way is for the engine of single motions.

    Args:
        tools: of the ensemble.
        q, velocity: coordinate → array of shape (n,).

    Returns:
        Columns as ``Engine.run`` gives them.
    """
    p, inexact = momenta_of(tools, q, velocity)
    columns = tools.engine.run(q, p)
    error, status = {name: np.array(array) for name, array in columns.error.items()}, np.array(columns.status)
    for name, rounded in inexact.items():
        step = np.where(rounded, np.spacing(np.abs(p[name])), 0.0)
        moved = [tools.engine.run(q, {**p, name: p[name] + side * step}) for side in (-1, 1)]
        for other in moved:
            lost = (status == Status.OK) & (other.status != Status.OK)
            status[lost] = UNDECIDED
        for column in tools.layout.values():
            change = np.fmax(*(_distance(column, columns, other) for other in moved))
            error[column] += np.where(step > 0, np.nan_to_num(change), 0.0)
    return replace(columns, error=error, status=status)


def _distance(column: str, one: engine.Columns, other: engine.Columns) -> Any:
    with np.errstate(invalid="ignore"):
        far = np.abs(value_of(one, column) - value_of(other, column))
        return np.minimum(far, np.abs(2 * np.pi - far)) if column.startswith("angles.") else far


def value_of(columns: engine.Columns, name: str) -> Any:
    """A column of values by its flat name.

    Args:
        columns: of the engine.
        name: quantity, a dot, and the coordinate or constant, such as ``actions.r``.
    """
    quantity, _, key = name.partition(".")
    return columns.group(quantity)[key]
