"""Where states are in space: x, y, z of ``System.place`` with the errors of the coordinates carried along."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import AtTimes, Numbers
from hjsolve.arithmetic.tape import Tape
from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import System
from hjsolve.motion.formulas_at_places import bits_in, bounded_at, tape_of, values_at
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State


@dataclass(frozen=True, repr=False)
class PlaceFormulas(Shown):
    """Formulas of a place, and the numbers in them.

    Attributes:
        axes: x, y, z, those there are.
        formulas: one each.
        coordinates: names and symbols.
        parameters: symbols and exact numbers.
    """

    axes: tuple[str, ...]
    formulas: tuple[sp.Expr, ...]
    coordinates: tuple[tuple[str, sp.Symbol], ...]
    parameters: tuple[tuple[sp.Symbol, sp.Expr], ...]

    def values(self, state: State) -> dict[str, AtTimes]:
        """Return axis → value, shaped like the times."""
        arrays = self._arrays(state.q)
        found = values_at(self._tape(), arrays, [value for _, value in self.parameters])
        # a motion that has ended is at no place, whether that depends on its coordinates or not
        ended = np.where(arrays[0] == arrays[0], 0.0, np.nan)
        return {axis: shaped(x + ended, np.shape(state.status)) for axis, x in zip(self.axes, found, strict=True)}

    def bounds(self, state: State, errors: Errors) -> dict[str, AtTimes]:
        """Return axis → bound on the error, shaped like the times."""
        arrays, uncertainties = self._arrays(state.q), [x.astype(float) for x in self._arrays(errors.q)]
        fixed = [value for _, value in self.parameters]
        found = bounded_at(self._tape(), arrays, uncertainties, fixed, bits_in(arrays[0]))
        return {a: shaped(error, np.shape(state.status)) for a, (_, error) in zip(self.axes, found, strict=True)}

    def _arrays(self, group: Mapping[str, AtTimes]) -> list[Numbers]:
        rows = (np.ravel(np.asarray(group[name])) for name, _ in self.coordinates)
        return [x if x.dtype == object else x.astype(float) for x in rows]

    def _tape(self) -> Tape:
        return tape_of(self.formulas, (*(s for _, s in self.coordinates), *(s for s, _ in self.parameters)))


def with_place(system: System, values: Mapping[sp.Symbol, sp.Expr], state: State) -> State:
    """Return a state that knows where it is, if its system says so.

    Args:
        system: in whose coordinates the state is.
        values: parameter → exact number, among others.
        state: of a motion.
    """
    place = system.place
    if not place:
        return state
    fixed = tuple((p.symbol, values[p.symbol]) for p in system.parameters if p.symbol in values)
    own = tuple((c.name, c.symbol) for c in system.coordinates)
    return replace(state, placing=PlaceFormulas(tuple(place), tuple(place.values()), own, fixed))
