"""What pint and astropy have in common: a text is a unit, a quantity has a number in a unit, a number has a quantity.

Radians are pure numbers here: in astropy, where they are a unit, by its ``dimensionless_angles``.
"""

from __future__ import annotations

import importlib
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from tokenize import TokenError
from types import ModuleType
from typing import Any, Protocol, TypeAlias

from hjsolve.display.shown import Shown
from hjsolve.errors import FAULTS, InvalidInputError, MissingExtraError

Powers = Mapping[str, Fraction]
"""A unit: text of each factor → its exponent."""
Quantity: TypeAlias = Any
"""What a library calls a quantity, a unit, a number: neither is typed."""
Unit: TypeAlias = Any
Number: TypeAlias = Any
ROUNDING = 2.0**-49
"""How far, relatively, a number is from the true one once a library has converted it: its factors are doubles."""
_FAULTS_OF_PINT = (*FAULTS, TokenError)
_ROOTS = ("pint", "astropy")


class UnitLibrary(Hashable, Protocol):
    """What is asked of a library."""

    @property
    def name(self) -> str:
        """``pint`` or ``astropy``."""

    def unit(self, powers: Powers) -> Unit:
        """Return the unit that is a product of powers.

        Args:
            powers: text → exponent.

        Raises:
            InvalidInputError: a text that is not a unit of this library.
        """

    def number(self, quantity: Quantity, unit: Unit) -> Number:
        """Return the number of a quantity in a unit, or None where it has another dimension.

        Args:
            quantity: of this library; unchanged where it has the unit.
            unit: of this library.
        """

    def quantity(self, number: Number, unit: Unit) -> Quantity:
        """Return the quantity of a number.

        Args:
            number: a number, or an array of them.
            unit: of this library.
        """


@dataclass(frozen=True, repr=False)
class Astropy(Shown):
    """astropy.units; its quantities are doubles."""

    name: str = "astropy"

    def unit(self, powers: Powers) -> Unit:
        """Return the unit that is a product of powers."""
        units = importlib.import_module("astropy.units")
        found = units.dimensionless_unscaled
        for text, power in powers.items():
            try:
                found *= units.Unit(text) ** power
            except (ValueError, TypeError):
                raise _unknown(text, "astropy") from None
        return found

    def number(self, quantity: Quantity, unit: Unit) -> Number:
        """Return the number of a quantity in a unit, or None where it has another dimension."""
        units = importlib.import_module("astropy.units")
        if quantity.unit == unit:
            return quantity.value
        try:
            return quantity.to_value(unit, equivalencies=units.dimensionless_angles())
        except units.UnitConversionError:
            return None

    def quantity(self, number: Number, unit: Unit) -> Quantity:
        """Return the quantity of a number."""
        many = getattr(number, "dtype", None) is not None
        return importlib.import_module("astropy.units").Quantity(number if many else float(number), unit, dtype=float)


@dataclass(frozen=True, repr=False)
class Pint(Shown):
    """A registry of pint; its quantities may hold any number.

    Attributes:
        registry: a ``pint.UnitRegistry``; quantities of two registries do not mix.
    """

    registry: Unit = field(repr=False)
    name: str = "pint"

    def __deepcopy__(self, memo: object) -> Pint:
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return _pint_of_this_process, ()  # a registry is not data; pint's own quantities come back in this one, too

    def unit(self, powers: Powers) -> Unit:
        """Return the unit that is a product of powers."""
        found = self.registry.Unit("dimensionless")
        for text, power in powers.items():
            try:
                factor = self.registry.parse_units(text)
            except _FAULTS_OF_PINT as error:
                raise _unknown(text, "pint") from error
            found *= factor ** (int(power) if power.denominator == 1 else float(power))
        return found

    def number(self, quantity: Quantity, unit: Unit) -> Number:
        """Return the number of a quantity in a unit, or None where it has another dimension."""
        if quantity.units == unit:
            return quantity.magnitude
        if not quantity.is_compatible_with(unit):
            return None
        return quantity.m_as(unit)

    def quantity(self, number: Number, unit: Unit) -> Quantity:
        """Return the quantity of a number."""
        return self.registry.Quantity(number, unit)


def _pint_of_this_process() -> Pint:
    return Pint(_imported("pint").get_application_registry())


def _unknown(text: str, library: str) -> InvalidInputError:
    return InvalidInputError(f'units: "{text}" is not a unit of {library}')


def _root(value: object) -> str:
    """Return the library that the class of a value comes from."""
    roots = [base.__module__.partition(".")[0] for base in type(value).__mro__]
    return next((root for root in roots if root in _ROOTS), "")


def library_of(value: object) -> UnitLibrary | None:
    """Return the library that a quantity or a unit belongs to; None for what is neither."""
    found: UnitLibrary | None = None
    match _root(value):
        case "astropy" if hasattr(value, "unit") or hasattr(value, "physical_type"):
            found = Astropy()
        case "pint" if hasattr(value, "_REGISTRY"):
            found = Pint(value._REGISTRY)
    return found


def library(wanted: object) -> UnitLibrary:
    """Return the library that a caller means.

    Args:
        wanted: ``"astropy"`` or the module ``astropy.units``; ``"pint"``, the module or a registry; or any unit or
            quantity of one of them.

    Raises:
        InvalidInputError: something else.
        MissingExtraError: it is not installed (extra ``units``).
    """
    name = wanted.__name__.partition(".")[0] if isinstance(wanted, ModuleType) else wanted
    if name == "astropy":
        _imported("astropy")
        return Astropy()
    if name == "pint":
        return _pint_of_this_process()
    if _root(wanted) == "pint" and hasattr(wanted, "parse_units"):
        return Pint(wanted)
    found = library_of(wanted)
    if found is None:
        raise InvalidInputError('units: write "astropy", "pint", or a registry of pint')
    return found


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise MissingExtraError(
            f'units: {name} is not installed; pip install {name}, or "hjsolve[units]" for pint and astropy'
        ) from None
