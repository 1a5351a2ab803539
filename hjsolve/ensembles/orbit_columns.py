"""Columns of numbers of many orbits: what was computed, under its names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.layout import ERROR, RECOMPUTED, STATUS, Layout
from hjsolve.errors import InvalidInputError

WORDS = np.array([status.word for status in Status])


@dataclass(frozen=True, eq=False, repr=False)
class OrbitColumns:
    """Results of many orbits, by quantity and name; ``Batch`` says what is done with them.

    Attributes:
        columns: flat name → array: ``actions.r``, ``turning_points.r.lower``, … of what was wanted, ``error.actions.r``
            next to each, ``status`` (a ``Status`` as int8) and ``recomputed``.
        layout: which quantities and names there are.
        shape: of every array, that of the initial conditions.
    """

    columns: Mapping[str, Any]
    layout: Layout
    shape: tuple[int, ...]

    @property
    def actions(self) -> dict[str, Any]:
        """J = (1/2π) ∮ p dq by coordinate."""
        return self._quantity("actions")

    @property
    def frequencies(self) -> dict[str, Any]:
        """Ω = ∂H/∂J by coordinate, radians per unit time."""
        return self._quantity("frequencies")

    @property
    def periods(self) -> dict[str, Any]:
        """2π/abs(Ω) by coordinate; infinite where Ω is zero."""
        return self._quantity("periods")

    @property
    def angles(self) -> dict[str, Any]:
        """The angle variables of the initial states, in (−π, π], by coordinate."""
        return self._quantity("angles")

    @property
    def constants(self) -> dict[str, Any]:
        """The constants of the motion by name."""
        return self._quantity("constants")

    @property
    def turning_points(self) -> dict[str, tuple[Any, Any]]:
        """(lower, upper) by separated coordinate; NaN on a side that has none."""
        return self._quantity("turning_points")

    @property
    def q(self) -> dict[str, Any]:
        """The positions of states wanted, by coordinate."""
        return self._quantity("q")

    @property
    def p(self) -> dict[str, Any]:
        """The canonical momenta of states wanted, by coordinate."""
        return self._quantity("p")

    @property
    def error(self) -> dict[str, dict[str, Any]]:
        """Bounds on the absolute errors: quantity → name → array (or pair)."""
        return {quantity: self._quantity(quantity, ERROR) for quantity in self.layout.want}

    @property
    def status(self) -> Any:
        """A word for every orbit: ``ok`` or what became of it; ``Status`` says what each means."""
        codes = self.columns[STATUS]
        return codes.map_blocks(_words, dtype=WORDS.dtype) if self.lazy else _words(codes)

    @property
    def codes(self) -> Any:
        """The status as int8, a ``Status`` for every orbit."""
        return self.columns[STATUS]

    @property
    def recomputed(self) -> Any:
        """True where the single-orbit engine computed the orbit, because the vectorised one handed it back."""
        return self.columns[RECOMPUTED]

    @property
    def lazy(self) -> bool:
        """True while the columns are dask arrays."""
        return hasattr(self.columns[STATUS], "dask")

    def summary(self) -> dict[str, int]:
        """Return how many orbits have each status, and how many were ``recomputed``; computes a lazy batch's statuses.

        Returns:
            Word → number of orbits; words that no orbit has are left out, ``recomputed`` is always there.
        """
        status, recomputed = self.columns[STATUS], self.columns[RECOMPUTED]
        if self.lazy:
            from dask.base import compute

            status, recomputed = compute(status, recomputed)
        counts = np.bincount(np.ravel(status), minlength=len(Status))
        found = {s.word: int(counts[s]) for s in Status if counts[s]}
        return {**found, RECOMPUTED: int(np.count_nonzero(recomputed))}

    def _quantity(self, quantity: str, prefix: str = "") -> dict[str, Any]:
        if quantity not in self.layout.names:
            raise InvalidInputError(f'"{quantity}" was not computed; add it to want')
        sides: Callable[[str], Any]
        if quantity == "turning_points":
            sides = lambda n: (self.columns[f"{n}.lower"], self.columns[f"{n}.upper"])  # noqa: E731
        else:
            sides = lambda n: self.columns[n]  # noqa: E731
        return {name: sides(f"{prefix}{quantity}.{name}") for name in self.layout.names[quantity]}


def _words(codes: Any) -> Any:
    return WORDS[codes]
