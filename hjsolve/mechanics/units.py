"""The units of what stands in T and V: some are declared, the others follow, for T and V must have one dimension.

Every unit is a product of powers of those declared. T and V give linear equations for the exponents: the terms of a
sum have one dimension, T that of V, and a pure number none, nor what a function like sin is taken of. (An argument of
a logarithm may have one: another unit adds a constant to V.) So Kepler's m in kg, r in m, t in s gives k in kg m³/s².
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter, time_letter, unknown_names
from hjsolve.mechanics.relativity import Relativity
from hjsolve.units.libraries import Powers, library_of

Units = tuple[tuple[str, str], ...]
Exponents = Mapping[str, Fraction]
"""Name → exponent; of the names declared, or of all of them."""
PURE = ("", "1", "rad", "radian")
"""Units that are none."""
ENERGY = "energy of T and V"
_NONE: Exponents = {}


def time_of(coordinates: Iterable[Coordinate], parameters: Iterable[Parameter]) -> str:
    """Return what the time is called."""
    places = list(coordinates)
    momenta = [c.momentum.name for c in places]
    return time_letter([*(c.name for c in places), *(p.name for p in parameters), *momenta])


def read_units(given: object, coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]) -> Units:
    """Read the units that were declared, those of the parameters among them.

    Args:
        given: name → text or unit of pint or astropy; None for none.

    Returns:
        Name and text, in the order of the coordinates, the time, the parameters.

    Raises:
        InvalidSystemError: a name that is neither, no text, or two units for one parameter.
    """
    table = arguments.table({} if given is None else given, "units", '{"r": "kpc", "t": "Myr"}')
    names = [*(c.name for c in coordinates), time_of(coordinates, parameters), *(p.name for p in parameters)]
    found: dict[str, str] = {}
    for name, unit in table.items():
        if name not in names:
            raise unknown_names(name, names, "coordinate, parameter or time")
        if not isinstance(unit, str) and library_of(unit) is None:
            raise InvalidSystemError(f'units: {name}: a text such as "kpc" is needed, not {arguments.described(unit)}')
        found[name] = str(unit).strip()
    for p in parameters:
        if p.unit and found.setdefault(p.name, p.unit) != p.unit:
            raise InvalidSystemError(f"units: {p.name} is in {p.unit} by its parameter and in {found[p.name]} here")
    return tuple((name, found[name]) for name in names if name in found)


class Posed(Hashable, Protocol):
    """What is looked at of a ``System``."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Its coordinates."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters."""

    @property
    def kinetic(self) -> sp.Expr:
        """T."""

    @property
    def potential(self) -> sp.Expr:
        """V."""

    @property
    def relativity(self) -> Relativity | None:
        """Of a relativistic particle."""

    @property
    def declared_units(self) -> Units:
        """Name and text."""

    @property
    def defaults(self) -> dict[sp.Symbol, sp.Expr]:
        """Exact default values by symbol."""


# ------------------------------------------------------------------------------------------------ equations
def _plus(one: Exponents, other: Exponents, times: Fraction | int = 1) -> dict[str, Fraction]:
    total = {name: one.get(name, Fraction(0)) + times * other.get(name, Fraction(0)) for name in {**one, **other}}
    return {name: power for name, power in total.items() if power}


class _Reader:
    """Exponents of expressions; the equations they need are collected."""

    def __init__(self, known: Mapping[sp.Symbol, Exponents], values: Mapping[sp.Symbol, sp.Expr]):
        self.known, self.values = known, values
        self.equations: list[Exponents] = []

    def read(self, expression: sp.Expr) -> Exponents:
        """Return the exponents of an expression."""
        if isinstance(expression, sp.Symbol):
            return self.known.get(expression, {str(expression): Fraction(1)})
        if isinstance(expression, sp.Add):
            return self.same(expression.args)
        if isinstance(expression, sp.Mul):
            product: Exponents = _NONE
            for factor in expression.args:
                product = _plus(product, self.read(factor))
            return product
        if isinstance(expression, sp.Pow):
            return self._power(*expression.args)
        if isinstance(expression, sp.core.function.AppliedUndef):
            return {str(expression): Fraction(1)}
        for argument in expression.args:
            exponents = self.read(argument)
            if not isinstance(expression, sp.log):
                self.equations.append(exponents)
        return _NONE

    def same(self, expressions: Iterable[sp.Expr]) -> Exponents:
        """Return the exponents that several expressions have in common; zero has any."""
        first, *others = [self.read(e) for e in expressions if e != 0] or [_NONE]
        self.equations += [_plus(first, other, -1) for other in others]
        return first

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> Exponents:
        inside, number = self.read(base), exponent.subs(self.values)
        if exponent.free_symbols:
            self.equations.append(self.read(exponent))
        if number.is_Rational:
            return {name: power * Fraction(int(number.p), int(number.q)) for name, power in inside.items()}
        self.equations.append(inside)
        return _NONE


def _reader(system: Posed) -> tuple[_Reader, Exponents]:
    """Return what T and V ask of the exponents of coordinates, parameters and time; and the exponents of the energy."""
    time, energy = {time_of(system.coordinates, system.parameters): Fraction(1)}, {ENERGY: Fraction(1)}
    known: dict[sp.Symbol, Exponents] = {}
    for c in system.coordinates:
        place = _NONE if c.domain.kind == "angle" else {c.name: Fraction(1)}
        known |= {c.symbol: place, c.velocity: _plus(place, time, -1)}
        known[c.momentum] = _plus(_plus(energy, time), place, -1)
    reader = _Reader(known, system.defaults)
    for part in (system.kinetic, system.potential):
        if part != 0:
            reader.equations.append(_plus(reader.read(part), energy, -1))
    if system.relativity is not None:
        rest = {system.relativity.mass.name: Fraction(1), system.relativity.light.name: Fraction(2)}
        reader.equations.append(_plus(rest, energy, -1))
    for c in system.coordinates:
        for end in (c.domain.lower, c.domain.upper):
            if end is not None and end.free_symbols:
                reader.same((c.symbol, end))
    return reader, energy


@dataclass(frozen=True, repr=False)
class UnitTable(Shown):
    """The units of a system.

    Attributes:
        declared: name → text.
        derived: name → exponents of the declared names, for those that follow.
        relations: exponents of declared names whose product must be 1.
        free: names whose units would have to be declared for all others to follow.
    """

    declared: Mapping[str, str]
    derived: Mapping[str, Exponents]
    relations: tuple[Exponents, ...]
    free: tuple[str, ...]

    def powers(self, exponents: Exponents) -> Powers | None:
        """Return the unit of a product of names, as factors; None where that of a name does not follow."""
        total: Exponents = _NONE
        for name, power in exponents.items():
            if name not in self.derived:
                return None
            total = _plus(total, self.derived[name], power)
        texts: dict[str, Fraction] = {}
        for name, power in total.items():
            if self.declared[name] not in PURE:
                texts = _plus(texts, {self.declared[name]: power})
        return texts

    def undetermined(self, exponents: Exponents) -> str:
        """Return the first name of a product whose unit does not follow."""
        return next((name for name in self.free if name != ENERGY), next(iter(exponents)))


def _solved(equations: Sequence[Exponents], names: Sequence[str], declared: Mapping[str, str]) -> UnitTable:
    """Gauß's elimination: what is not declared first, then parameters; coordinates and time are kept to the last."""
    others = [name for name in names if name not in declared]
    columns = others + [name for name in reversed(names) if name in declared]
    rows = [[sp.Rational(e.get(name, 0)) for name in columns] for e in equations if e]
    reduced, pivots = sp.Matrix(rows).rref() if rows else (sp.zeros(0, len(columns)), ())
    derived: dict[str, Exponents] = {name: {name: Fraction(1)} for name in declared}
    relations = []
    for row, pivot in enumerate(pivots):
        held = {columns[k]: -_fraction(reduced[row, k]) for k in range(pivot + 1, len(columns)) if reduced[row, k]}
        if pivot >= len(others):
            relation = _plus({columns[pivot]: Fraction(1)}, held, -1)
            whole = math.lcm(*(power.denominator for power in relation.values()))
            relations.append({name: power * whole for name, power in relation.items()})
        elif all(name in declared for name in held):
            derived[columns[pivot]] = held
    free = tuple(name for k, name in enumerate(others) if k not in pivots)
    return UnitTable(dict(declared), derived, tuple(relations), free)


def _fraction(number: sp.Rational) -> Fraction:
    return Fraction(int(number.p), int(number.q))


@lru_cache(maxsize=256)
def unit_table(system: Posed, alike: tuple[tuple[sp.Expr, sp.Expr], ...] = (), also: Posed | None = None) -> UnitTable:
    """Work out the units of a system.

    Args:
        system: with the declared units.
        alike: pairs of expressions of one dimension: the constants of a solution, the chart it is solved in.
        also: the system in the coordinates of that chart.
    """
    reader, _ = _reader(system)
    if also is not None:
        other, _ = _reader(also)
        reader.known = {**other.known, **reader.known}
        reader.equations += other.equations
    for pair in alike:
        reader.same(pair)
    names = dict.fromkeys([ENERGY, *(c.name for c in system.coordinates if c.domain.kind != "angle")])
    names |= dict.fromkeys([time_of(system.coordinates, system.parameters), *(p.name for p in system.parameters)])
    names |= dict.fromkeys(name for e in reader.equations for name in sorted(e))
    declared = {name: text for name, text in system.declared_units if name in names}
    return _solved(reader.equations, list(names), declared)


def check_units(system: Posed) -> None:
    """Refuse declared units that T and V cannot have, as far as that is seen without knowing what a unit is.

    Raises:
        InvalidSystemError: an angle that is not in radians, or something that must be a pure number and has a unit.
    """
    for name, text in system.declared_units:
        if name in {c.name for c in system.coordinates if c.domain.kind == "angle"} and text not in PURE:
            raise InvalidSystemError(f'units: {name} is an angle, in T and V in radians; write "rad", not "{text}"')
    table = unit_table(system)
    for relation in table.relations:
        named = [name for name in relation if table.declared[name] not in PURE]
        if len(named) == 1:
            raise InvalidSystemError(
                f"units: {named[0]} is in {table.declared[named[0]]}, but with the other units T and V need a pure "
                "number there: name the constants of T and V, 1 or 1/2 among them, that have a unit as parameters"
            )


def names_and_units(system: Posed) -> dict[str, str]:
    """Return the units of coordinates, time and parameters, those that follow included: name → text.

    Args:
        system: with the declared units.
    """
    declared, table = dict(system.declared_units), unit_table(system)
    if not declared:
        return {}
    found = dict.fromkeys([c.name for c in system.coordinates if c.domain.kind == "angle"], "rad")
    time = time_of(system.coordinates, system.parameters)
    for name in [*(c.name for c in system.coordinates), time, *(p.name for p in system.parameters)]:
        powers = table.powers({name: Fraction(1)})
        if name not in found and powers is not None:
            found[name] = written(powers)
    return {**found, **declared}


def written(powers: Powers) -> str:
    """Return a unit as text that both libraries read: ``kg*m^2/s^2``.

    Args:
        powers: text of a factor → exponent.
    """

    def factor(text: str, power: Fraction) -> str:
        base = text if text.isidentifier() else f"({text})"
        return base if power == 1 else f"{base}^{power}" if power.denominator == 1 else f"{base}^({power})"

    above = [factor(text, power) for text, power in powers.items() if power > 0]
    below = [factor(text, -power) for text, power in powers.items() if power < 0]
    divisor = f"({'*'.join(below)})" if len(below) > 1 else "".join(below)
    return "/".join(part for part in ("*".join(above) or "1", divisor) if part)
