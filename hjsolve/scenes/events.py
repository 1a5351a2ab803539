"""Events: what changes the momenta at an instant, exactly.

The coordinates do not change. An impulse adds Δpᵢ = Q̂ᵢ, or Δp = m(q) Δq̇ (Greenwood (3-24)–(3-29)); a wall at a
coordinate surface exerts an impulse along its own coordinate alone, such that q̇ᵢ becomes −e q̇ᵢ, e the restitution:
Δpᵢ = −(1 + e) q̇ᵢ/(m⁻¹)ᵢᵢ. An elastic one, e = 1, keeps the energy: ΔH = q̇ᵢ Δpᵢ + ½ (m⁻¹)ᵢᵢ Δpᵢ² = 0; with an
orthogonal T without linear terms it is pᵢ → −pᵢ. An impact is a constraint that appears at an instant: see
``hjsolve.extended.impacts``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.catalog.schema import nearest
from hjsolve.catalog.toml_file import Toml
from hjsolve.display.shown import Shown
from hjsolve.errors import CatalogError, InvalidInputError, required
from hjsolve.extended.impacts import ImpactForms, impulses, read_forms
from hjsolve.formulas.read import number, parse
from hjsolve.mechanics.system import System, inverse_mass_matrix, linear_terms, mass_matrix, momenta, velocities

Momenta = dict[str, sp.Expr]


@dataclass(frozen=True, repr=False)
class Event(Shown):
    """Something that happens at an instant.

    Attributes:
        kind: ``impulse``, ``wall`` or ``impact``.
        name: for display.
        time: when, exact; None where it happens at a place.
        coordinate, value: where; None for a given time.
        passage: of an impulse at a place, which crossing after the start: 0 is the first.
        momentum, velocity: the jumps of an impulse, by coordinate, exact.
        restitution: of a wall or an impact, the part of the speed against it that is left, exact, from 0 to 1.
        forms: of an impact, the constraints that appear.
        surface: of an impact, g(q) that is 0 where it happens; None for a time or a coordinate.
        lasts: of an impact, whether its constraints go on to hold.
    """

    kind: str
    name: str
    time: sp.Expr | None = None
    coordinate: str | None = None
    value: sp.Expr | None = None
    passage: int = 0
    momentum: Mapping[str, sp.Expr] | None = None
    velocity: Mapping[str, sp.Expr] | None = None
    restitution: sp.Expr = sp.S.One
    forms: ImpactForms | None = None
    surface: sp.Expr | None = None
    lasts: bool = False

    @property
    def elastic(self) -> bool:
        """Whether it is a wall that keeps the energy."""
        return self.kind == "wall" and bool(self.restitution == 1)

    def __str__(self) -> str:
        """Say what happens, and where or when."""
        place = f"t = {self.time}" if self.coordinate is None else f"{self.coordinate} = {self.value}"
        place = place if self.surface is None else f"{self.surface} = 0"
        return f"{self.name} at {place}"


@dataclass(frozen=True)
class Pending:
    """An event to come, and how many passages it still lets by."""

    event: Event
    left: int


def read_event(table: Toml, system: System, where: str) -> Event:
    """Read one table of ``events``, its shape checked already.

    Args:
        table: of the scene file.
        where: what the table is called in errors.

    Raises:
        CatalogError: a coordinate that does not exist, or a value outside its domain.
        ExpressionError: something that is not a number.
    """
    at, names = table["at"], [c.name for c in system.coordinates]
    for key, used in (("at.coordinate", [at["coordinate"]] if "coordinate" in at else []),
                      *((key, list(table.get(key, ()))) for key in ("momentum", "velocity"))):  # fmt: skip
        for name in used:
            if name not in names:
                raise CatalogError(f'{where}.{key}: no coordinate "{name}"{nearest(name, names)}')
    surface = parse(at["surface"], system.symbols, source=f"{where}.at.surface") if "surface" in at else None
    if surface is not None and not surface.free_symbols & {c.symbol for c in system.coordinates}:
        raise CatalogError(f"{where}.at.surface: holds no coordinate; write a formula that is 0 where it happens")
    event = Event(
        kind=table["kind"], name=table.get("name", table["kind"]),
        time=number(at["t"], source=f"{where}.at.t") if "t" in at else None,
        coordinate=at.get("coordinate"), passage=at.get("passage", 0),
        value=number(at["value"], source=f"{where}.at.value") if "value" in at else None,
        momentum=_jumps(table, "momentum", where), velocity=_jumps(table, "velocity", where),
        restitution=_restitution(table, where),
        forms=None if table["kind"] != "impact" else read_forms(
            system, table.get("constraints") or [f"{at['surface']} = 0"], table.get("restitution", 0),
            f"{where}.constraints",
        ),
        surface=surface, lasts=table.get("lasts", False),
    )  # fmt: skip
    if event.coordinate is not None and event.value is not None:
        domain = system.coordinate(event.coordinate).domain
        for bound, side in ((domain.lower, 1), (domain.upper, -1)):
            if bound is not None and bound.is_number and (side * (event.value - bound)).is_positive is not True:
                raise CatalogError(f"{where}.at.value: {event.value} is not inside the domain of {event.coordinate}")
    return event


def _restitution(table: Toml, where: str) -> sp.Expr:
    value = number(table.get("restitution", 1), source=f"{where}.restitution")
    if value.is_negative or (value - 1).is_positive:
        raise CatalogError(f"{where}.restitution: must be from 0 (nothing bounces back) to 1 (elastic), not {value}")
    return value


def once(events: Sequence[Event]) -> list[Event]:
    """Events at one instant, in order; of several walls at one place the first one counts, so none undoes another."""
    found: list[Event] = []
    for event in events:
        if event.kind != "wall" or all(e.kind != "wall" or e.coordinate != event.coordinate for e in found):
            found.append(event)
    return found


def _jumps(table: Toml, key: str, where: str) -> dict[str, sp.Expr] | None:
    if key not in table:
        return None
    return {name: number(value, source=f"{where}.{key}.{name}") for name, value in table[key].items()}


def changed(event: Event, system: System, values: Mapping[sp.Symbol, sp.Expr]) -> Momenta:
    """Give the momenta just after an event.

    Args:
        event: what happens.
        values: exact parameters, coordinates and momenta just before, by symbol.

    Returns:
        Coordinate → momentum, exact numbers.
    """
    names = [c.name for c in system.coordinates]
    before = {c.name: values[c.momentum] for c in system.coordinates}
    if event.kind == "wall":
        coordinate = required(event.coordinate)
        i, inverse = names.index(coordinate), inverse_mass_matrix(system)
        moving = sp.Matrix([c.momentum - a for c, a in zip(system.coordinates, linear_terms(system), strict=True)])
        against = sp.cancel(-(inverse.row(i) * moving)[0] / inverse[i, i])
        jump = (1 + event.restitution) * against.xreplace(dict(values))
        return before | {coordinate: sp.expand(before[coordinate] + jump)}
    if event.forms is not None:
        _, pushed = impulses(system, event.forms, values)
        return {name: sp.expand(p + pushed[i]) for i, (name, p) in enumerate(before.items())}
    if event.momentum is not None:
        jump = {name: sp.sympify(x).xreplace(dict(values)) for name, x in event.momentum.items()}
        return {name: sp.expand(p + jump.get(name, sp.S.Zero)) for name, p in before.items()}
    jumps = sp.Matrix([(event.velocity or {}).get(name, 0) for name in names])
    if system.relativity is not None:
        return _faster(event, system, values)
    change = mass_matrix(system).xreplace(dict(values)) * jumps
    return {name: sp.expand(before[name] + change[i]) for i, name in enumerate(names)}


def _faster(event: Event, system: System, values: Mapping[sp.Symbol, sp.Expr]) -> Momenta:
    """Return momenta after a jump of the velocities of a relativistic particle: those of the new velocities."""
    old = velocities(system)
    new = {c.velocity: old[c.name].xreplace(dict(values)) + (event.velocity or {}).get(c.name, 0)
           for c in system.coordinates}  # fmt: skip
    found = {name: formula.xreplace({**values, **new}) for name, formula in momenta(system).items()}
    if not all(p.is_finite and p.is_real for p in found.values()):
        raise InvalidInputError(f"{event}: after it the particle would be as fast as light; give momentum instead")
    return found
