"""change_coordinates(): the same system in coordinates that a user types, q = f(Q)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.algebra.nonzero import strict_sign
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.algebra.signs import Bounds
from hjsolve.errors import InvalidInputError, InvalidSystemError
from hjsolve.formulas.read import formula_of
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter, read_coordinates
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.kinetic_energy import velocity_coefficients
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System
from hjsolve.precision import one_at_a_time
from hjsolve.separation.zero_test.interval_evaluation import Region, find_witness
from hjsolve.separation.zero_test.zero_test import Zero, is_zero

_EXAMPLE = '{"x": "r*cos(phi)", "y": "r*sin(phi)"}'
SECONDS = 5.0
_TIME = sp.Symbol("t", real=True)


@arguments.with_known_names(
    'change_coordinates(system, {"x": "r*cos(phi)", "y": "r*sin(phi)"}, coordinates={"r": "0 < r", "phi": "angle"})'
)
@one_at_a_time
def change_coordinates(
    system: System | str | Path, place: Mapping[str, object], *, coordinates: Mapping[str, str]
) -> System:
    """Write a system in other coordinates, q = f(Q).

    T and V are transformed exactly: q̇ = ∂f/∂Q Q̇. The map must be regular, det(∂f/∂Q) ≠ 0 on the whole domain of Q, and
    stay in the domain of q. Both are proved, or the change is refused. It need not be one to one (polar angles are
    not).

    Args:
        system: the system, or the id or file of a catalog entry.
        place: every old coordinate → its formula in the new ones and in parameters, as text or sympy expression.
        coordinates: the new coordinates, name → domain, as for ``System``; as many as the old ones.

    Returns:
        The system in the new coordinates, with the same parameters.

    Raises:
        InvalidInputError: a coordinate without a formula, or another number of new ones.
        InvalidSystemError: the Jacobian vanishes or is not proved to keep its sign, or an old coordinate is not proved
            to stay in its domain; the message says where.
        ExpressionError: a formula cannot be read.

    Example:
        >>> V = "k/2*(x**2 + y**2)"
        >>> flat = System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", V, {"m": 1, "k": 1})
        >>> polar = {"r": "0 < r", "phi": "angle"}
        >>> polar_form = change_coordinates(flat, {"x": "r*cos(phi)", "y": "r*sin(phi)"}, coordinates=polar)
        >>> polar_form.kinetic, polar_form.potential
        (dot(phi)**2*m*r**2/2 + dot(r)**2*m/2, k*r**2/2)

    References:
        Greenwood, Classical Dynamics (1977), (2-5)–(2-10).
    """
    system = system_of(system, "change_coordinates")
    if system.kinks or system.relativity is not None:
        raise InvalidInputError("change_coordinates: kinks of V and relativistic particles are not transformed")
    table = arguments.one_for_each(place, "place", [c.name for c in system.coordinates], _EXAMPLE)
    new = read_coordinates(coordinates, system.parameters)
    if len(new) != len(system.coordinates):
        raise InvalidInputError(f"coordinates: {len(system.coordinates)} new ones are needed, {len(new)} are given")
    letters = {c.name: c.symbol for c in new} | {p.name: p.symbol for p in system.parameters}
    formulas = [formula_of(table[c.name], letters, source=f"place.{c.name}") for c in system.coordinates]
    bounds = {c.symbol: _ends(c) for c in new}
    _check_domain(system, formulas, bounds)
    _check_regular(system, new, formulas, bounds)
    return transformed(system, new, formulas, bounds, coordinates)


def _ends(c: Coordinate) -> Bounds:
    return (None, None) if c.domain.kind == "angle" else (c.domain.lower, c.domain.upper)


def _check_domain(system: System, formulas: list[sp.Expr], bounds: Mapping[sp.Symbol, Bounds]) -> None:
    for (q, ends), f in zip(domain_bounds(system.coordinates).items(), formulas, strict=True):
        if not stays_inside(f, ends, bounds):
            raise InvalidSystemError(
                f"place.{q.name}: {f} was not proved to stay in the domain of {q.name}; narrow the domains of the new "
                "coordinates"
            )


def stays_inside(f: sp.Expr, ends: Bounds, bounds: Mapping[sp.Symbol, Bounds]) -> bool:
    """Return whether a formula is proved to stay in an open interval.

    Args:
        ends: of the interval; None is infinite.
        bounds: open interval of each coordinate in the formula.
    """
    lower, upper = ends
    gaps = ([] if lower is None else [f - lower]) + ([] if upper is None else [upper - f])
    return all(strict_sign(short_form(gap, bounds), bounds) == 1 for gap in gaps)


def _check_regular(
    system: System, new: tuple[Coordinate, ...], formulas: list[sp.Expr], bounds: Mapping[sp.Symbol, Bounds]
) -> None:
    """Prove that the Jacobian keeps its sign."""
    determinant = sp.Matrix(formulas).jacobian([c.symbol for c in new]).det(method="berkowitz")
    forms = [short_form(determinant, bounds), sp.factor(determinant), sp.trigsimp(determinant)]
    if any(strict_sign(form, bounds) for form in forms):
        return
    region = Region(bounds, system.defaults)
    if isinstance(is_zero(determinant, region, budget=SECONDS), Zero):
        raise InvalidSystemError("place: the Jacobian |dq/dQ| vanishes everywhere; the new coordinates are dependent")
    seen = [find_witness(sp.sqrt(sign * forms[0]), region) for sign in (1, -1)]  # a root has values on one side only
    if None not in seen:
        raise InvalidSystemError(
            f"place: the Jacobian |dq/dQ| = {forms[0]} changes its sign, so that the map is not regular; narrow the "
            "domains of the new coordinates"
        )
    raise InvalidSystemError(
        f"place: the Jacobian |dq/dQ| = {forms[0]} was not proved to differ from zero; narrow the domains of the new "
        "coordinates"
    )


def transformed(
    system: System, new: tuple[Coordinate, ...], formulas: list[sp.Expr], bounds: Mapping[sp.Symbol, Bounds],
    domains: Mapping[str, str], constants: Iterable[Parameter] = (),
) -> System:  # fmt: skip
    """Return the system with q = f(Q) put into T and V; there may be fewer Q than q.

    Args:
        system: in the coordinates q.
        new: the coordinates Q.
        formulas: f, one for each q; where they hold the time, so do T and V.
        bounds: open interval of each Q.
        domains: of Q, as ``System`` takes them.
        constants: parameters that f holds and the system does not.
    """
    speeds = [c.velocity for c in new]
    old = dict(zip([c.symbol for c in system.coordinates], formulas, strict=True))
    rates = {
        c.velocity: sp.diff(f, _TIME) + sp.Add(*(sp.diff(f, Q.symbol) * Q.velocity for Q in new))
        for c, f in zip(system.coordinates, formulas, strict=True)
    }
    T = sp.expand(system.kinetic.xreplace({**old, **rates}))
    kinetic = sp.S.Zero
    for key, coefficient in velocity_coefficients(T, speeds).items():
        kinetic += short_form(coefficient, bounds) * sp.Mul(*(speeds[k] for k in key))
    place = {axis: formula.xreplace(old) for axis, formula in system.place.items()}
    potential = short_form(system.potential.xreplace(old), bounds)
    if _TIME not in kinetic.free_symbols | potential.free_symbols and any(f.has(_TIME) for f in place.values()):
        place = {}  # where a system without the time is in space may not hold it
    kept = {*domains, *(p.name for p in system.parameters), "t"}
    units = {name: unit for name, unit in system.declared_units if name in kept}
    return System(
        domains, kinetic, potential, {p.name: p for p in (*system.parameters, *constants)},
        signature=system.signature, title=system.title, place=place or None, functions=system.functions, units=units,
    )  # fmt: skip


def short_form(x: sp.Expr, bounds: Mapping[sp.Symbol, Bounds]) -> sp.Expr:
    """Return the shortest exact form; the expression itself where that takes too long.

    Args:
        bounds: open interval of each coordinate.
    """
    try:
        reader = Reader([x], dict(bounds), Budget.processor_seconds(SECONDS))
        return shortest_form(reader, reader.element(x))
    except (WorkLimitError, ZeroDivisionError):
        return x
