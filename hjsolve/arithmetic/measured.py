"""A number with its error and a unit: quantities of pint or astropy, as many of both."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from hjsolve.arguments import refuse_other
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.display.shown import brief
from hjsolve.errors import InvalidInputError
from hjsolve.units.libraries import ROUNDING, Number, Quantity, Unit, UnitLibrary, library, library_of


@dataclass(frozen=True, eq=False, repr=False)
class Measured:
    """A value and a bound on its error, both quantities of the same unit; arrays of one shape, or single ones.

    Attributes:
        value: a quantity of pint or astropy.
        error: absolute error, a quantity of the same unit.

    Example:
        >>> from astropy import units as u
        >>> period = Measured.of(Estimate(6.25, 0.5), u.Myr)
        >>> period.to(u.Gyr).value, period.to("Gyr").estimate().value
        (<Quantity 0.00625 Gyr>, 0.00625)
    """

    value: Quantity
    error: Quantity

    @classmethod
    def of(cls, estimate: Estimate | EstimateArray, unit: Unit) -> Measured:
        """Give an estimate a unit.

        Args:
            estimate: a number with its error, or an array of them.
            unit: of pint or astropy.

        Raises:
            InvalidInputError: no estimate, or no unit of theirs.
        """
        refuse_other(estimate, (Estimate, EstimateArray), "Measured.of", "an Estimate is needed")
        return measured_in(estimate.value, estimate.error, unit, library(unit))

    @property
    def unit(self) -> Unit:
        """The unit of both."""
        return getattr(self.value, "unit", None) or self.value.units

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, key: Number) -> Measured:
        return Measured(self.value[key], self.error[key])

    def to(self, unit: Unit) -> Measured:
        """Return the same in another unit; the rounding of the library's factor is added to the error.

        Args:
            unit: of the library, or its name.

        Raises:
            InvalidInputError: no unit of this dimension.
        """
        theirs = self._library
        target = theirs.unit({unit: Fraction(1)}) if isinstance(unit, str) else unit
        value, error = theirs.number(self.value, target), theirs.number(self.error, target)
        if value is None:
            raise InvalidInputError(f"to: {self.unit} cannot be converted to {target}")
        if target != self.unit:
            error = error * (1 + 2 * ROUNDING) + ROUNDING * abs(value)
        return Measured(theirs.quantity(value, target), theirs.quantity(error, target))

    def estimate(self, unit: Unit = None) -> Estimate | EstimateArray:
        """Return the number and its error alone.

        Args:
            unit: in which they are counted; None for that of the value.

        Raises:
            InvalidInputError: no unit of this dimension.
        """
        here, theirs = self if unit is None else self.to(unit), self._library
        value, error = theirs.number(here.value, here.unit), theirs.number(here.error, here.unit)
        return EstimateArray(value, error) if getattr(value, "shape", ()) else Estimate(_plain(value), _plain(error))

    @property
    def _library(self) -> UnitLibrary:
        theirs = library_of(self.value)
        if theirs is None:
            raise InvalidInputError("Measured: quantities of pint or astropy are needed")
        return theirs

    def __str__(self) -> str:
        number = self.estimate()
        return f"{brief(number if isinstance(number, Estimate) else number.value, 60)} {self.unit}"

    def __repr__(self) -> str:
        return f"Measured({self})"

    def _repr_latex_(self) -> str | None:
        """Return what a notebook shows of a single number."""
        number = self.estimate()
        return f"${number:L}$ {self.unit}" if isinstance(number, Estimate) else None


def _plain(number: Number) -> Number:
    return number.item() if hasattr(number, "item") else number


def measured_in(value: Number, error: Number, unit: Unit, theirs: UnitLibrary) -> Measured:
    """Give numbers a unit.

    Args:
        value, error: numbers, or arrays of one shape.
        unit, theirs: what they are counted in, and its library.
    """
    if theirs.name == "astropy" and not _doubles(value):  # it keeps doubles alone: what they lose is added
        near = value.astype(float) if hasattr(value, "astype") else float(value)
        error = (error + abs(value - near)) * (1 + ROUNDING)
        value = near
        error = error.astype(float) if hasattr(error, "astype") else float(error)
    return Measured(theirs.quantity(value, unit), theirs.quantity(error, unit))


def _doubles(value: Number) -> bool:
    return isinstance(value, (int, float)) or getattr(getattr(value, "dtype", None), "kind", "") == "f"
