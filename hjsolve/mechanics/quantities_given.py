"""Quantities that a user gives become numbers in the units of the system: the door where pint and astropy end.

A number without a unit is taken to be in the units of the system; one that has the unit keeps every digit, and any
other is multiplied by the library's factor, a double.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TypeVar

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.units import ENERGY, Exponents, Posed, UnitTable, names_and_units, time_of, unit_table
from hjsolve.units.libraries import Number, Quantity, Unit, UnitLibrary, library_of

_EXACT = 2.0**-46
_ONE = Fraction(1)
_COLUMNS = {("q", "R"): "x", ("velocity", "vR"): "x", ("velocity", "vT"): "y", ("velocity", "vz"): "z"}
"""Columns of stars about the axis z → the coordinate that has their unit."""
Given = TypeVar("Given")
Alike = tuple[tuple[sp.Expr, sp.Expr], ...]


@dataclass(frozen=True, repr=False)
class Measures(Shown):
    """The units of one system in one library.

    Attributes:
        system: whose they are.
        library: pint or astropy.
        table: what follows from T and V.
        coordinates: names of coordinates, the user's and those of a chart → whether it is an angle.
    """

    system: Posed
    library: UnitLibrary
    table: UnitTable
    coordinates: Mapping[str, bool]

    @property
    def _shown_names(self) -> list[str]:
        return ["system", "units"]

    @property
    def units(self) -> dict[str, str]:
        """The units of coordinates, time and parameters."""
        return names_and_units(self.system)

    def exponents(self, name: str, role: str) -> Exponents:
        """Return what a number is made of.

        Args:
            name: of a coordinate, parameter or constant, or of the time.
            role: ``q``, ``velocity``, ``p``, ``constant``, ``action``, ``frequency``, ``period``, ``time``, ``angle``,
                or anything else for the name itself.
        """
        time = time_of(self.system.coordinates, self.system.parameters)
        if role == "constant" and name.removeprefix("p_") in self.coordinates and name.startswith("p_"):
            role, name = "p", name.removeprefix("p_")
        own: dict[str, Fraction] = {} if self.coordinates.get(name, False) else {name: _ONE}
        return {
            "velocity": own | {time: -_ONE}, "p": {ENERGY: _ONE, time: _ONE} | dict.fromkeys(own, -_ONE),
            "action": {ENERGY: _ONE, time: _ONE}, "frequency": {time: -_ONE}, "period": {time: _ONE},
            "time": {time: _ONE}, "angle": {},
        }.get(role, own)  # fmt: skip

    def unit(self, name: str, role: str) -> Unit:
        """Return the unit of a number.

        Args:
            name, role: as of ``exponents``.

        Raises:
            InvalidInputError: it does not follow from those declared, or is not a unit of the library.
        """
        powers = self.table.powers(self.exponents(name, role))
        if powers is None:
            known = ", ".join(self.table.declared) or "none"
            free = self.table.undetermined(self.exponents(name, role))
            raise InvalidInputError(
                f"units: that of {name} ({role}) does not follow from those of {known}; "
                f'declare more: units={{"{free}": …}}'
            )
        turns = role in {"frequency", "angle"} or (self.coordinates.get(name, False) and role in {"q", "velocity"})
        return self.library.unit({**({"rad": _ONE} if turns else {}), **powers})

    def number(self, quantity: Quantity, name: str, role: str, source: str) -> Number:
        """Return the number of a quantity, in the units of the system.

        Args:
            quantity: of the library.
            name, role: as of ``exponents``.
            source: what it is called in errors.

        Raises:
            InvalidInputError: it has another dimension.
        """
        unit = self.unit(name, role)
        number = self.library.number(quantity, unit)
        if number is None:
            theirs = getattr(quantity, "unit", None) or getattr(quantity, "units", None)
            raise InvalidInputError(f"{source}: is in {theirs}; a quantity in {unit} or the like is needed")
        return number


def measures(system: Posed, library: UnitLibrary, alike: Alike = (), also: Posed | None = None) -> Measures:
    """Return the units of a system in a library, once it is sure that they fit together.

    Args:
        system: whose units are declared.
        library: pint or astropy.
        alike, also: as of ``unit_table``.

    Raises:
        InvalidInputError: no units are declared, or T and V cannot have them all.
    """
    if not system.declared_units:
        raise InvalidInputError(
            f"a quantity of {library.name} needs the units of the system, and it declares none; "
            'write System(…, units={"r": "kpc", "t": "Myr"}), or give the number'
        )
    return _fitting(system, library, alike, also)


@lru_cache(maxsize=64)
def _fitting(system: Posed, library: UnitLibrary, alike: Alike, also: Posed | None) -> Measures:
    table = unit_table(system, alike, also)
    for relation in table.relations:
        unit = library.unit(table.powers(relation) or {})
        ratio = library.number(library.quantity(1.0, unit), library.unit({}))
        if ratio is None or abs(ratio - 1) > _EXACT:
            names = ", ".join(f"{name} in {table.declared[name]}" for name in relation)
            raise InvalidInputError(
                f"units: {names} do not fit together: with T and V a pure 1 would be "
                f"{f'{ratio:.6g}' if ratio is not None else f'1 {unit}'}; choose one of these units so that it is 1"
            )
    coordinates = (*(also.coordinates if also else ()), *system.coordinates)
    return Measures(system, library, table, {c.name: c.domain.kind == "angle" for c in coordinates})


def without_quantities(parameters: Given) -> tuple[Given | dict[str, object], dict[str, object]]:
    """Part what was given into numbers, None in place of quantities, and quantities.

    Args:
        parameters: as the user wrote them.
    """
    if not isinstance(parameters, Mapping):
        return parameters, {}
    quantities = {name: value for name, value in parameters.items() if library_of(value) is not None}
    return {name: None if name in quantities else value for name, value in parameters.items()}, quantities


def in_units(system: Posed, given: Given, group: str, alike: Alike = ()) -> Given | dict[str, object]:
    """Turn the quantities among what was given into numbers in the units of the system.

    Args:
        system: whose units are declared.
        given: name → number or quantity; anything else is returned as it is.
        group: ``q``, ``velocity``, ``p``, ``parameters`` or ``constants``.
        alike: as of ``unit_table``.

    Raises:
        InvalidInputError: a quantity where no units are declared, or of another dimension.
    """
    if not isinstance(given, Mapping) or not any(_held(value) for value in given.values()):
        return given
    named = {key: _COLUMNS.get((group, str(key)), str(key)) for key in given}
    return {key: _plain(system, value, named[key], group, alike) for key, value in given.items()}


def _held(value: object) -> bool:
    """Return whether it is a quantity, or a list with one."""
    return library_of(value) is not None or (isinstance(value, (list, tuple)) and any(map(_held, value)))


def _plain(system: Posed, value: object, name: str, group: str, alike: Alike) -> object:
    if isinstance(value, (list, tuple)):
        return [_plain(system, item, name, group, alike) for item in value] if _held(value) else value
    library = library_of(value)
    if library is None:
        return value
    source = f"{group}[{name}]"
    declared = {
        "parameters": {p.name for p in system.parameters}, "constants": {str(symbol) for symbol, _ in alike},
    }.get(group, {c.name for c in system.coordinates})  # fmt: skip
    if name not in declared:
        return value  # refused by name later on
    try:
        role = "constant" if group == "constants" else group
        return measures(system, library, alike).number(value, name, role, source)
    except InvalidInputError as error:
        raise InvalidInputError(str(error) if str(error).startswith(source) else f"{source}: {error}") from None
