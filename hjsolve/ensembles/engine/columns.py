"""What a batch gives back: one array a quantity, an error next to every number, a status for every orbit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.number_types import Codes, Mask, Reals, Which
from hjsolve.ensembles.engine.status import UNDECIDED

QUANTITIES = ("constants", "turning_points", "actions", "frequencies", "periods", "angles")
"""What may be wanted of a batch."""


@dataclass(frozen=True)
class Columns:
    """Arrays of shape (n,), NaN where the status is not ``OK``.

    Attributes:
        actions, frequencies, periods, angles: coordinate → values; angles in (−π, π].
        constants: name of a constant of the motion → values.
        turning_points: ``"r.lower"``, ``"r.upper"`` → positions; NaN for a rotation.
        error: ``"actions.r"``, ``"turning_points.r.lower"``, … → claimed absolute error.
        status: ``Status`` as uint8.
        unresolved: True where doubles did not know p² well enough somewhere, so that more digits would help.
    """

    actions: Mapping[str, Reals]
    frequencies: Mapping[str, Reals]
    periods: Mapping[str, Reals]
    angles: Mapping[str, Reals]
    constants: Mapping[str, Reals]
    turning_points: Mapping[str, Reals]
    error: Mapping[str, Reals]
    status: Codes
    unresolved: Mask

    def group(self, quantity: str) -> Mapping[str, Reals]:
        """Return the columns of one of ``QUANTITIES``.

        Returns:
            Coordinate or constant → array of shape (n,).
        """
        columns: Mapping[str, Reals] = getattr(self, quantity)
        return columns

    def take(self, index: Which) -> Columns:
        """Return some of the orbits.

        Args:
            index: of numpy, of which orbits.
        """
        groups = {q: {name: v[index] for name, v in self.group(q).items()} for q in QUANTITIES}
        error = {k: v[index] for k, v in self.error.items()}
        return Columns(**groups, error=error, status=self.status[index], unresolved=self.unresolved[index])


def blank(names: Mapping[str, tuple[str, ...]], count: int) -> Columns:
    """Return columns full of NaN, all orbits for the single-orbit engine.

    Args:
        names: quantity → names of its columns; quantities that are not wanted are absent.
        count: number of orbits.
    """
    groups = {q: {name: np.full(count, np.nan) for name in names.get(q, ())} for q in QUANTITIES}
    error = {f"{q}.{name}": np.full(count, np.nan) for q in names for name in names[q]}
    status = np.full(count, UNDECIDED, dtype=np.uint8)
    return Columns(**groups, error=error, status=status, unresolved=np.zeros(count, dtype=bool))


def put(columns: Columns, index: Which, part: Columns) -> None:
    """Write the columns of some orbits.

    Args:
        columns: where they are written.
        index: of numpy, of which orbits.
        part: what is written.
    """
    columns.status[index], columns.unresolved[index] = part.status, part.unresolved
    for key, error in part.error.items():
        quantity, name = key.split(".", 1)
        columns.error[key][index] = error
        columns.group(quantity)[name][index] = part.group(quantity)[name]
