"""Lagrange's equations with multipliers: constraint forces as functions of the state (Greenwood (2-48), (5-22)–(5-25)).

    d/dt ∂T/∂q̇ᵢ − ∂T/∂qᵢ + ∂V/∂qᵢ = Σⱼ λⱼ aⱼᵢ,    φⱼ = Σᵢ aⱼᵢ(q, t) q̇ᵢ + aⱼₜ(q, t) = 0

The left side is M q̈ + r(q, q̇, t), and φ̇ⱼ = Σ aⱼᵢ q̈ᵢ + bⱼ(q, q̇, t) vanishes too, so that

    λ = (a M⁻¹ aᵀ)⁻¹ (a M⁻¹ r − b),    q̈ = M⁻¹ (aᵀλ − r).

Nothing here asks whether the constraints are integrable. Where they were eliminated, q = f(Q, t), λ is a function of
Q and Q̇ as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.coordinates.typed_change import short_form
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError, required
from hjsolve.formulas.read import parse
from hjsolve.mechanics.coordinates_and_parameters import free_name
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.kinetic_energy import degree
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, inverse_mass_matrix, mass_matrix
from hjsolve.precision import one_at_a_time

TIME = sp.Symbol("t", real=True)
"""The time where a constraint holds it and the system does not."""


@dataclass(frozen=True, repr=False)
class ConstraintForces(Shown):
    """Lagrange's equations with multipliers, in the coordinates in which the constraints are written.

    Attributes:
        system: without the constraints.
        texts: the constraints as they were written.
        symbols: the symbol of each multiplier in ``equations``.
        rows: a, by constraint the coefficient of each velocity, ∂g/∂q of an equation g(q, t) = 0.
        equations: coordinate → d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q = Σ λ a, with ``ddot(q)`` for q̈.
        multipliers: λ by constraint, in coordinates, velocities and the time.
        forces: coordinate → Σ λ a, the generalized constraint force, likewise.
        accelerations: coordinate → q̈, likewise.
        reduced: λ by constraint in the coordinates and velocities that are left, where the constraints were eliminated.
    """

    system: System
    texts: tuple[str, ...]
    symbols: tuple[sp.Symbol, ...]
    rows: tuple[tuple[sp.Expr, ...], ...]
    equations: Mapping[str, sp.Eq]
    multipliers: tuple[sp.Expr, ...]
    forces: Mapping[str, sp.Expr]
    accelerations: Mapping[str, sp.Expr]
    reduced: tuple[sp.Expr, ...] = ()


@arguments.with_known_names('constraint_forces(system, ["x**2 + y**2 = 1"])')
@one_at_a_time
def constraint_forces(system: System | str | Path, constraints: Sequence[str] = ()) -> ConstraintForces:
    """Write Lagrange's equations with multipliers, and solve them for the constraint forces.

    Args:
        system: made with ``constraints``, whose forces are wanted; or, with the argument ``constraints``, a system
            without them. Or the id or file of a catalog entry.
        constraints: equations between coordinates, or linear in the velocities, as for ``System``. They need not be
            integrable, and may hold the time t.

    Returns:
        The equations, the multipliers λ, the forces Σ λ a and the accelerations. For equations between coordinates λ
        belongs to ∂g/∂q, g the left side less the right side.

    Raises:
        InvalidSystemError: there are no constraints, they are not independent, or one is not linear in the velocities.
        ExpressionError: a constraint cannot be read.

    Example:
        >>> import hjsolve
        >>> bead = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", "m*g*y", {"m": 1, "g": 1},
        ...                       constraints=["y = 3*x**2"])
        >>> constraint_forces(bead).reduced[0]
        m*(6*dot(x)**2 + g)/(36*x**2 + 1)

    References:
        Greenwood, Classical Dynamics (1977), (2-48), (5-22)–(5-25), P2-3, P2-9, P4-4.
    """
    system = system_of(system, "constraint_forces")
    given = (constraints,) if isinstance(constraints, str) else constraints
    if not isinstance(given, (list, tuple)):
        raise InvalidSystemError('constraints: texts are needed, such as ["x**2 + y**2 = 1"]')
    if given:
        return forces_of(
            system, given, [read_constraint(system, x, f"constraints[{n}]") for n, x in enumerate(given, 1)]
        )
    if system.unconstrained is None:
        raise InvalidSystemError('constraint_forces: give constraints, such as ["x**2 + y**2 = 1"]')
    free, texts = system.unconstrained, system.constraints
    found = forces_of(free, texts, [read_constraint(free, x, f"constraints[{n}]") for n, x in enumerate(texts, 1)])
    put, bounds = eliminated_state(system), domain_bounds(system.coordinates)
    return replace(found, reduced=tuple(short_form(λ.subs(put, simultaneous=True), bounds) for λ in found.multipliers))


def eliminated_state(system: System) -> dict[sp.Symbol, sp.Expr]:
    """Return coordinates and velocities of a system without constraints in those that are left.

    Args:
        system: made with constraints.
    """
    gone, clock = dict(system.eliminated), system.time or TIME
    put = dict[sp.Symbol, sp.Expr]()
    for c in required(system.unconstrained).coordinates:
        f = gone[c.name].subs(TIME, clock) if c.name in gone else system.symbols[c.name]
        moving = sp.Add(sp.diff(f, clock), *(sp.diff(f, Q.symbol) * Q.velocity for Q in system.coordinates))
        put |= {c.symbol: f, c.velocity: moving}
    return put


def read_constraint(system: System, text: object, source: str) -> sp.Expr:
    """Return the left side of a constraint less its right side.

    Args:
        system: whose coordinates and velocities it holds.
        text: an equation; the right side may be left out where it is 0.
        source: what it is called in errors.

    Raises:
        InvalidSystemError: it is not one equation.
        ExpressionError: it cannot be read.
    """
    if not isinstance(text, str) or text.count("=") > 1:
        raise InvalidSystemError(f'{source}: one equation as text is needed, such as "x**2 + y**2 = l**2"')
    speeds = {c.name: c.velocity for c in system.coordinates}
    sides = [parse(side, {"t": TIME, **system.symbols}, velocities=speeds, source=source) for side in text.split("=")]
    return sides[0] - (sides[1] if len(sides) == 2 else 0)


def forces_of(system: System, texts: Sequence[str], forms: Sequence[sp.Expr]) -> ConstraintForces:
    """Return the equations with multipliers.

    Args:
        system: without the constraints.
        texts: as they were written.
        forms: φ(q, q̇, t), linear in the velocities, or g(q, t).

    Raises:
        InvalidSystemError: a relativistic particle or kinks of V, or constraints that depend on each other.
    """
    if system.kinks or system.relativity is not None:
        raise InvalidSystemError("constraints: multipliers are not computed with kinks of V or relativity")
    clock = system.time or TIME
    places, speeds = [c.symbol for c in system.coordinates], [c.velocity for c in system.coordinates]
    rates = [sp.Symbol(f"ddot({c.name})", real=True) for c in system.coordinates]
    for n, φ in enumerate(forms, 1):
        if degree(sp.expand(φ), frozenset(speeds)) > 1:
            raise InvalidSystemError(f"constraints[{n}]: a constraint on velocities must be linear in them")
    moving = [φ if φ.has(*speeds) else _along(φ, places, speeds, clock) for φ in forms]
    a = sp.Matrix([[sp.diff(φ, v) for v in speeds] for φ in moving])
    b = sp.Matrix([_along(φ, places, speeds, clock) for φ in moving])
    T, V, M = system.kinetic, system.potential, mass_matrix(system)
    r = sp.Matrix([
        _along(sp.diff(T, v), places, speeds, clock) - sp.diff(T, q) + sp.diff(V, q)
        for q, v in zip(places, speeds, strict=True)
    ])  # fmt: skip
    inverse = inverse_mass_matrix(system)
    bounds = domain_bounds(system.coordinates)

    def short(x: sp.Expr) -> sp.Expr:
        return short_form(x, bounds)

    square = (a * inverse * a.T).applyfunc(short)
    if short(square.det()) == 0:
        raise InvalidSystemError("constraints: they are not independent; leave one out")
    λ = [short(x) for x in square.LUsolve(a * inverse * r - b)]
    taken = {s.name: s for s in (*system.symbols.values(), *speeds)}
    names = [sp.Symbol(free_name(f"lambda_{n}", taken), real=True) for n in range(1, len(forms) + 1)]
    left, right = M * sp.Matrix(rates) + r, a.T * sp.Matrix(names)
    push = [short(x) for x in a.T * sp.Matrix(λ)]
    faster = [short(x) for x in inverse * (sp.Matrix(push) - r)]
    by_name = [c.name for c in system.coordinates]
    return ConstraintForces(
        system, tuple(texts), tuple(names), tuple(map(tuple, a.tolist())),
        {n: sp.Eq(short(x), y, evaluate=False) for n, x, y in zip(by_name, left, right, strict=True)},
        tuple(λ), dict(zip(by_name, push, strict=True)), dict(zip(by_name, faster, strict=True)),
    )  # fmt: skip


def _along(f: sp.Expr, places: Sequence[sp.Symbol], speeds: Sequence[sp.Symbol], clock: sp.Symbol) -> sp.Expr:
    """Return df/dt without the terms of q̈."""
    return sp.Add(sp.diff(f, clock), *(sp.diff(f, q) * v for q, v in zip(places, speeds, strict=True)))
