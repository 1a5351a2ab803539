"""A batch expressed in units: its columns as quantities of pint or astropy."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.measured import Measured
from hjsolve.ensembles.export import axis_names, with_words
from hjsolve.ensembles.layout import ERROR
from hjsolve.ensembles.orbit_columns import OrbitColumns
from hjsolve.motion.in_units import ROLES, NumbersInUnits, available, measures_of
from hjsolve.units.libraries import Number, library


@dataclass(frozen=True, repr=False)
class BatchInUnits(NumbersInUnits):
    """Results of many orbits with their units, each a ``Measured`` of arrays.

    Attributes:
        batch: whose numbers they are; computed.
        measures: the units of its system.
    """

    batch: OrbitColumns

    @property
    def _shown_names(self) -> list[str]:
        return available(self, self.batch.layout.want)

    @property
    def angles(self) -> dict[str, Measured]:
        """Angle variables by coordinate, in radians."""
        return self._quantity("angles")

    @property
    def turning_points(self) -> dict[str, tuple[Measured, Measured]]:
        """(lower, upper) by separated coordinate."""
        ends: Mapping[str, Number] = self.batch.turning_points
        errors = self.batch.error["turning_points"]
        return {
            name: (self._numbers(low, errors[name][0], name, "q"), self._numbers(high, errors[name][1], name, "q"))
            for name, (low, high) in ends.items()
        }

    @property
    def status(self) -> Number:
        """As of ``Batch``."""
        return self.batch.status

    def _pairs(self, quantity: str) -> dict[str, tuple[Number, Number]]:
        errors = self.batch.error[quantity]
        return {name: (x, errors[name]) for name, x in getattr(self.batch, quantity).items()}


def quantity_table(batch: OrbitColumns) -> Number:
    """Return the astropy ``QTable`` of a batch, one row an orbit.

    Args:
        batch: of numpy arrays.

    Raises:
        InvalidInputError: the units that the system declares do not fit T and V.
        MissingExtraError: astropy is not installed.
    """
    found = library("astropy")
    solution = batch.layout.solution
    measures = None if solution is None else measures_of(solution, "astropy")
    table = importlib.import_module("astropy.table").QTable(meta={"shape": list(batch.shape)})
    if len(batch.shape) > 1:
        for name, places in zip(axis_names(batch.shape), np.indices(batch.shape)):
            table[name] = places.reshape(-1)
    for name, column in with_words(batch).items():
        flat = np.asarray(column).reshape(-1)
        quantity, _, rest = name.removeprefix(ERROR).partition(".")
        if measures is not None and rest:
            coordinate = rest.rpartition(".")[0] if quantity == "turning_points" else rest
            flat = found.quantity(flat, measures.unit(coordinate, ROLES.get(quantity, "q")))
        table[name] = flat
    return table
