"""A motion expressed in units: its numbers as quantities of pint or astropy, each with its error."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.measured import Measured, measured_in
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.quantities_given import Measures, measures
from hjsolve.solution.quadratures import Solution
from hjsolve.units.libraries import Number, Quantity, library, library_of

if TYPE_CHECKING:
    from hjsolve.motion.motion import Motion

_PLACE = "place of "
ROLES = {
    "constants": "constant", "actions": "action", "frequencies": "frequency", "periods": "period", "angles": "angle",
    "boundary_times": "time",
}  # fmt: skip
"""Quantity → what its units are those of."""
_QUANTITIES = ("turning_points", "constants", "actions", "frequencies", "periods", "boundary_times")


def available(value: object, names: Iterable[str]) -> list[str]:
    """Return the names of quantities that a value has, and whose units follow from those declared."""

    def is_available(name: str) -> bool:
        try:
            return bool(getattr(value, name))
        except InvalidInputError:
            return False

    return list(filter(is_available, names))


def measures_of(solution: Solution, wanted: object) -> Measures:
    """Return the units of everything that is told of a solution.

    Args:
        solution: of a system that declares units.
        wanted: the library, as of ``units.libraries.library``.

    Raises:
        InvalidInputError: no library, or no units that fit T and V.
        MissingExtraError: the library is not installed.
    """
    chart = solution.chart
    system = solution.system_as_given
    alike = [(constant.symbol, constant.expression) for constant in solution.constants.values()]
    alike += [(sp.Symbol(_PLACE + axis), formula) for axis, formula in system.place.items()]
    if chart is not None:
        alike += [(system.coordinate(name).symbol, formula) for name, formula in chart.transformation.items()]
    return measures(system, library(wanted), tuple(alike), None if chart is None else chart.system)


@dataclass(frozen=True, repr=False)
class NumbersInUnits(Shown):
    """Results by quantity and name, each a ``Measured``.

    Attributes:
        measures: their units.
    """

    measures: Measures = field(kw_only=True)

    @property
    def constants(self) -> dict[str, Measured]:
        """Constants of the motion by name."""
        return self._quantity("constants")

    @property
    def actions(self) -> dict[str, Measured]:
        """J by coordinate."""
        return self._quantity("actions")

    @property
    def frequencies(self) -> dict[str, Measured]:
        """Ω by coordinate, radians per unit time."""
        return self._quantity("frequencies")

    @property
    def periods(self) -> dict[str, Measured]:
        """2π/abs(Ω) by coordinate."""
        return self._quantity("periods")

    def _pairs(self, quantity: str) -> dict[str, tuple[Number, Number]]:
        """Name → value and error."""
        raise NotImplementedError

    def _quantity(self, quantity: str) -> dict[str, Measured]:
        return {name: self._numbers(*pair, name, ROLES[quantity]) for name, pair in self._pairs(quantity).items()}

    def _numbers(self, value: Number, error: Number, name: str, role: str) -> Measured:
        return measured_in(value, error, self.measures.unit(name, role), self.measures.library)


@dataclass(frozen=True, repr=False, eq=False)
class StateInUnits(ByValue, Shown):
    """A state, every number a ``Measured``.

    Attributes:
        t: the times asked.
        q, p, velocity: coordinate → value and error.
        place: axis → value and error, where it is known.
        status: as of ``State``.
    """

    t: Quantity
    q: Mapping[str, Measured]
    p: Mapping[str, Measured]
    velocity: Mapping[str, Measured]
    place: Mapping[str, Measured]
    status: object


@dataclass(frozen=True, repr=False)
class MotionInUnits(NumbersInUnits):
    """Results of a motion with their units, each a ``Measured``: value and error are quantities.

    Attributes:
        motion: whose numbers they are.
        measures: its units.
    """

    motion: Motion

    @property
    def _shown_names(self) -> list[str]:
        return available(self, _QUANTITIES)

    @property
    def boundary_times(self) -> dict[str, Measured]:
        """Coordinate → time at which it reaches an end of its domain."""
        return self._quantity("boundary_times")

    @property
    def turning_points(self) -> dict[str, tuple[Measured | None, Measured | None]]:
        """Coordinate → (lower, upper)."""
        return {
            name: (self._end(name, ends[0]), self._end(name, ends[1]))
            for name, ends in self.motion.turning_points.items()
        }

    def at(self, t: object) -> StateInUnits:
        """Return the state at a time or times.

        Args:
            t: a quantity of time, or a number in the unit of time of the system; or an array of them.

        Raises:
            InvalidInputError: no time.
        """
        own = t if library_of(t) is None else self.measures.number(t, "t", "time", "t")
        state = self.motion.at(own)
        errors, place = state.error, state.place if state.placing else {}
        return StateInUnits(
            self.measures.library.quantity(own, self.measures.unit("t", "time")), self._group("q", state.q, errors.q),
            self._group("p", state.p, errors.p), self._group("velocity", state.velocity, errors.velocity),
            {axis: self._numbers(x, errors.place[axis], _PLACE + axis, "place") for axis, x in place.items()},
            state.status,
        )  # fmt: skip

    def _group(self, role: str, values: Mapping[str, Number], errors: Mapping[str, Number]) -> dict[str, Measured]:
        return {name: self._numbers(x, errors[name], name, role) for name, x in values.items()}

    def _end(self, name: str, end: Estimate | None) -> Measured | None:
        return None if end is None else self._numbers(end.value, end.error, name, "q")

    def _pairs(self, quantity: str) -> dict[str, tuple[Number, Number]]:
        return {name: (x.value, x.error) for name, x in getattr(self.motion, quantity).items()}
