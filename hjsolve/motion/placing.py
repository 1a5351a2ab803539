"""Where states are in space: x, y, z of ``System.place`` with the errors of the coordinates carried along."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import AtTimes, Numbers
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import System
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.positions import tape_of
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
        arrays = [np.ravel(np.asarray(state.q[name])) for name, _ in self.coordinates]
        shape = np.shape(state.status)
        return {axis: shaped(x, shape) for axis, x in zip(self.axes, self._run(arrays), strict=True)}

    def bounds(self, state: State, errors: Errors) -> dict[str, AtTimes]:
        """Return axis → bound on the error, shaped like the times."""
        arrays = [np.ravel(np.asarray(state.q[name])) for name, _ in self.coordinates]
        uncertainties = [np.ravel(np.asarray(errors.q[name], dtype=float)) for name, _ in self.coordinates]
        bits = _bits(arrays)
        inputs = [WithErrorBound(x.astype(float), e) for x, e in zip(arrays, uncertainties, strict=True)]
        for _, value in self.parameters:
            x = np.asarray(float(to_bits(value)(64)))
            inputs.append(WithErrorBound(x, 2.0**-bits * np.abs(x)))
        with np.errstate(all="ignore"):
            found = self._tape().run(RunningError(Float64(), bits=bits), inputs)
            size = arrays[0].shape
            parts = [np.broadcast_to(0.0 if x.error is None else SECOND_ORDER * x.error, size) for x in found]
        return {a: shaped(x, np.shape(state.status)) for a, x in zip(self.axes, parts, strict=True)}

    def _tape(self) -> Tape:
        return tape_of(self.formulas, (*(s for _, s in self.coordinates), *(s for s, _ in self.parameters)))

    def _run(self, arrays: list[Numbers]) -> list[Numbers]:
        tape, size = self._tape(), arrays[0].shape
        if arrays[0].dtype != object:
            numbers = [float(to_bits(value)(64)) for _, value in self.parameters]
            with np.errstate(all="ignore"):
                found = tape.run(Float64(), [*(x.astype(float) for x in arrays), *numbers])
                return [np.broadcast_to(x, size) + 0.0 * arrays[0].astype(float) for x in found]
        field = Multi(_bits(arrays))
        exact = [to_bits(value)(field.bits) for _, value in self.parameters]
        rows = []
        for row in zip(*arrays, strict=True):
            inputs = [field.convert(x) for x in row]
            ended = any(x != x for x in inputs)
            rows.append([field.context.nan] * len(self.axes) if ended else tape.run(field, [*inputs, *exact]))
        return [np.array(column, dtype=object) for column in zip(*rows, strict=True)]


def _bits(arrays: list[Numbers]) -> int:
    if arrays[0].dtype != object:
        return 53
    return max((x.context.prec for x in arrays[0] if hasattr(x, "context")), default=128)


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
