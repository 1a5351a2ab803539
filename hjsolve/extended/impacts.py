"""Impacts: constraints that appear at an instant, by impulses that nobody gives (Greenwood §3-2).

A constraint a(q)·q̇ = v, smooth, exerts an impulse along a alone: Δp = aᵀλ, Δq̇ = M⁻¹aᵀλ (3-42). With u = a q̇ − v the
speed against it, and the coefficient of restitution e, u becomes −e u, so that

    λ = −(1 + e) (a M⁻¹ aᵀ)⁻¹ (a q̇ − v),   ΔT = ½ λᵀa (q̇ + q̇′)   (work of the impulses by the mean velocity).

Several constraints act together: the normal of a floor alone is sliding; normal and tangent are sticking. A constraint
at rest, v = 0, with e = 0 takes the energy ½ uᵀ(a M⁻¹ aᵀ)⁻¹u of the motion against it (3-60); one that starts to move
gives energy (3-63). All of it is exact algebra in the numbers given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, InvalidSystemError
from hjsolve.extended.system_under_constraints import Exact, constrained, initial_data_in
from hjsolve.formulas.read import number, parse
from hjsolve.mechanics.kinetic_energy import degree, velocity_coefficients
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, inverse_mass_matrix, mass_matrix, momenta, velocities
from hjsolve.motion.initial_data import clean, complete_numbers, one_of_velocity_and_p, parameter_values
from hjsolve.precision import one_at_a_time

_EXAMPLE = 'impact(system, q={"y": 1}, velocity={"y": -2}, constraints=["dot(y) = 0"])'


@dataclass(frozen=True)
class ImpactForms:
    """Constraints a(q)·q̇ = v that act together.

    Attributes:
        texts: as they were written.
        levels: by constraint g(q), where it was written as g(q) = 0, a = ∂g/∂q; else None.
        rows: a, by constraint the coefficient of each velocity.
        speeds: v, by constraint.
        restitution: e, by constraint.
    """

    texts: tuple[str, ...]
    rows: tuple[tuple[sp.Expr, ...], ...]
    speeds: tuple[sp.Expr, ...]
    restitution: tuple[sp.Expr, ...]
    levels: tuple[sp.Expr | None, ...] = ()


@dataclass(frozen=True, repr=False)
class Impact(Shown):
    """What an impact does, exactly; names are those of the coordinates.

    Attributes:
        system: before and after.
        q: where it happens.
        velocity_before, velocity: q̇ just before and just after.
        p_before, p: the momenta.
        multipliers: λ, by constraint in order: the constraint impulses.
        impulse: Q̂ = aᵀλ, the generalized impulse on each coordinate.
        kinetic_before, kinetic: ½ q̇ᵀMq̇ before and after.
        forms: the constraints.
        values: of the parameters.
    """

    system: System
    q: Mapping[str, sp.Expr]
    velocity_before: Mapping[str, sp.Expr]
    velocity: Mapping[str, sp.Expr]
    p_before: Mapping[str, sp.Expr]
    p: Mapping[str, sp.Expr]
    multipliers: tuple[sp.Expr, ...]
    impulse: Mapping[str, sp.Expr]
    kinetic_before: sp.Expr
    kinetic: sp.Expr
    forms: ImpactForms
    values: Mapping[sp.Symbol, sp.Expr]

    @property
    def energy_lost(self) -> sp.Expr:
        """What the kinetic energy loses; negative where a constraint that moves gives energy (3-63)."""
        return sp.simplify(self.kinetic_before - self.kinetic)

    @property
    def budget(self) -> dict[str, sp.Expr]:
        """What has to vanish: Δp − Q̂ of each coordinate, and ``energy``, ΔT − Σ Q̂ (q̇ + q̇′)/2. Proved to be 0."""
        found = {n: sp.simplify(self.p[n] - self.p_before[n] - self.impulse[n]) for n in self.q}
        work = sp.Add(*(self.impulse[n] * (self.velocity[n] + self.velocity_before[n]) / 2 for n in self.q))
        return found | {"energy": sp.simplify(self.kinetic - self.kinetic_before - work)}

    def next_arc(self) -> tuple[System, dict[str, dict[str, sp.Expr]]]:
        """Return the system in which the constraints last, fewer coordinates, and its initial data.

        Where a constraint moves, the system may hold the time; it passes 0 at the impact.

        Returns:
            The system and ``q``, ``velocity``, ``parameters`` for ``Solution.motion``.

        Raises:
            InvalidSystemError: a constraint that bounces or is not integrable does not last so.
        """
        if any(e != 0 for e in self.forms.restitution):
            raise InvalidSystemError("next_arc: the constraints must keep what meets them, restitution 0")
        change = constrained(self.system, self.forms.texts)
        here = {change.time: sp.S.Zero} | dict(self.values)
        here |= {c.symbol: self.q[c.name] for c in self.system.coordinates}
        here |= {c.momentum: self.p[c.name] for c in self.system.coordinates}
        return change.system, initial_data_in(change, here, Exact())


@arguments.with_known_names(_EXAMPLE)
@one_at_a_time
def impact(
    system: System | str | Path, *, q: Mapping[str, object], velocity: Mapping[str, object] | None = None,
    p: Mapping[str, object] | None = None, constraints: Sequence[str], restitution: object = 0,
    parameters: Mapping[str, object] | None = None,
) -> Impact:  # fmt: skip
    """Compute what a constraint that appears at an instant does to the velocities.

    Args:
        system: in coordinates without the constraint; or the id or file of a catalog entry.
        q: the place, every coordinate.
        velocity: just before, every coordinate; or
        p: the momenta just before.
        constraints: equations linear in the velocities that hold just after, such as ``dot(y) - l*cos(theta)*dot(theta)
            = 0``; with ``dot(x) = v0`` the constraint moves. Or an equation of the coordinates that holds at the place,
            ``x**2 + y**2 = l**2`` of a string that becomes taut. The normal of a smooth floor alone is sliding, normal
            and tangent are sticking.
        restitution: e from 0 (nothing bounces back) to 1 (elastic): the part of the speed against a constraint that is
            left, turned round; one number, or a sequence with one for each constraint.
        parameters: values that differ from the defaults.

    Returns:
        ``Impact``: velocities, momenta, constraint impulses and energies, exact.

    Raises:
        InvalidInputError: a constraint that is not linear in the velocities, constraints that depend on each other, a
            coefficient of restitution out of range, or a relativistic particle.
        MissingValueError: a coordinate or a parameter without a value.

    Example:
        >>> import hjsolve
        >>> rod = hjsolve.System({"y": "line", "theta": "angle"}, "m/2*dot(y)**2 + m*l**2/24*dot(theta)**2", "m*g*y",
        ...                      {"m": 1, "l": 2, "g": 1})
        >>> floor = "dot(y) - l/2*cos(theta)*dot(theta) = 0"
        >>> hit = hjsolve.impact(rod, q={"y": 0, "theta": 0}, velocity={"y": -1, "theta": 0}, constraints=[floor])
        >>> hit.velocity["y"], hit.energy_lost
        (-3/4, 1/8)

    References:
        Greenwood, Classical Dynamics (1977), (3-24)–(3-29), (3-42)–(3-44), (3-60), (3-63), Ex 3-1, 3-2, P3-3 … 3-5.
    """
    system = system_of(system, "impact")
    values = parameter_values(system, parameters or {})
    what, given = one_of_velocity_and_p(velocity, p)
    places = complete_numbers(system.coordinates, arguments.table(q, "q", _EXAMPLE), "q")
    rates = complete_numbers(system.coordinates, given, what)
    at = dict(values) | {c.symbol: places[c.name] for c in system.coordinates}
    if what == "velocity":
        at |= {c.velocity: rates[c.name] for c in system.coordinates}
        rates = {name: clean(formula.subs(at)) for name, formula in momenta(system).items()}
    at |= {c.momentum: rates[c.name] for c in system.coordinates}
    forms = read_forms(system, constraints, restitution, "constraints")
    for number_of, g in enumerate(forms.levels, start=1):
        if g is not None and clean(g.xreplace(at)) != 0:
            raise InvalidInputError(f"constraints[{number_of}]: not satisfied here; give the coordinates at the impact")
    λ, change = impulses(system, forms, at)
    before = {name: clean(formula.subs(at)) for name, formula in velocities(system).items()}
    faster = sp.simplify(inverse_mass_matrix(system).subs(at)) * sp.Matrix(change)
    after = {c.name: clean(before[c.name] + faster[i]) for i, c in enumerate(system.coordinates)}
    M = mass_matrix(system).subs(at)

    def energy(speed: Mapping[str, sp.Expr]) -> sp.Expr:
        v = sp.Matrix([speed[c.name] for c in system.coordinates])
        return clean((v.T * M * v)[0] / 2)

    pushed = {c.name: change[i] for i, c in enumerate(system.coordinates)}
    return Impact(
        system, places, before, after, rates, {n: clean(rates[n] + pushed[n]) for n in rates}, tuple(λ), pushed,
        energy(before), energy(after), forms, values,
    )  # fmt: skip


def read_forms(system: System, constraints: object, restitution: object, source: str) -> ImpactForms:
    """Read constraints on velocities.

    Args:
        system: whose velocities they hold.
        constraints: texts.
        restitution: one number, or one for each.
        source: what they are called in errors.

    Raises:
        InvalidInputError: see ``impact``.
        ExpressionError: a formula cannot be read.
    """
    if system.relativity is not None:
        raise InvalidInputError(f"{source}: impacts of relativistic particles are not treated")
    given_texts = (constraints,) if isinstance(constraints, str) else constraints
    texts = tuple(given_texts) if isinstance(given_texts, (list, tuple)) else ()
    if not texts or not all(isinstance(x, str) for x in texts):
        raise InvalidInputError(f'{source}: equations as texts are needed, such as ["dot(y) = 0"]')
    speeds = [c.velocity for c in system.coordinates]
    rows, right, levels = [], [], list[sp.Expr | None]()
    for place, text in enumerate(texts, start=1):
        sides = text.split("=")
        known = {c.name: c.velocity for c in system.coordinates}
        read = [parse(x, system.symbols, velocities=known, source=f"{source}[{place}]") for x in sides[:2]]
        form = read[0] - (read[1] if len(read) == 2 else 0)
        levels.append(form if degree(form, frozenset(speeds)) == 0 else None)
        if levels[-1] is not None:
            form = sp.Add(*(sp.diff(form, c.symbol) * c.velocity for c in system.coordinates))
        if len(sides) > 2 or degree(form, frozenset(speeds)) != 1:
            needed = "an equation of the coordinates, or linear in the velocities, is needed"
            raise InvalidInputError(f"{source}[{place}]: {needed}, not {text[:60]}")
        found = velocity_coefficients(sp.expand(form), speeds)
        rows.append(tuple(found.get((i,), sp.S.Zero) for i in range(len(speeds))))
        right.append(-found.get((), sp.S.Zero))
    given = tuple(restitution) if isinstance(restitution, (list, tuple)) else (restitution,) * len(texts)
    if len(given) != len(texts):
        raise InvalidInputError(f"{source}: {len(texts)} constraints and {len(given)} coefficients of restitution")
    e = tuple(number(x, source="restitution") for x in given)
    if any(x.is_negative or (x - 1).is_positive for x in e):
        raise InvalidInputError("restitution: must be from 0 (nothing bounces back) to 1 (elastic)")
    return ImpactForms(texts, tuple(rows), tuple(right), e, tuple(levels))


def impulses(
    system: System, forms: ImpactForms, at: Mapping[sp.Symbol, sp.Expr]
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Return λ by constraint and aᵀλ by coordinate.

    Args:
        system: whose masses count.
        forms: the constraints.
        at: exact parameters, coordinates and momenta just before, by symbol.

    Raises:
        InvalidInputError: the constraints are not independent here.
    """
    a = sp.Matrix(forms.rows).subs(at)
    moving = sp.Matrix([formula.subs(at) for formula in velocities(system).values()])
    against = a * moving - sp.Matrix(forms.speeds).subs(at)
    matrix = (a * inverse_mass_matrix(system).subs(at) * a.T).applyfunc(sp.simplify)
    if sp.simplify(matrix.det()) == 0:
        raise InvalidInputError("constraints: they are dependent at this position; leave one out")
    bounced = sp.Matrix([(1 + e) * u for e, u in zip(forms.restitution, against, strict=True)])
    λ = [clean(sp.simplify(-x)) for x in matrix.LUsolve(bounced)]
    return λ, [clean(x) for x in a.T * sp.Matrix(λ)]
