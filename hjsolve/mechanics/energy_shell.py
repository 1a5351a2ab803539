"""Reduction to the energy shell: one quadratic form in the momenta that are left, and one potential.

Every system of this project is, after its ignorable coordinates are replaced by their constant momenta c,

    ½ Σₐ gᵃᵃ(q) Pₐ²  +  V_eff(q; c)  =  E,        Pₐ = pₐ + Aₐ(q; c),

over the essential coordinates only (Greenwood 1977, §2-3, §4-3, (5-74)–(5-81)). Ignorable coordinates may be coupled
to the rest (the top): eliminating them (``ignorable_coordinates``) leaves a centrifugal potential and linear terms A;
where T is indefinite the momenta of null coordinates may be left to first degree, gⁿpₙ in place of ½gᵃᵃPₐ². T₀ is
folded, V′ = V − T₀ (2-152). Linear terms are shifted away when A = dχ; when they are not closed they are gyroscopic and
the system is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.algebra.element_jets import at_random_points
from hjsolve.algebra.field import Element
from hjsolve.algebra.integration import closed_form_potential
from hjsolve.algebra.poly import Budget
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.algebra.several_variables import is_one_constant
from hjsolve.algebra.signs import Bounds
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.coordinates_and_parameters import time_letter
from hjsolve.mechanics.ignorable_coordinates import Eliminated, eliminate
from hjsolve.mechanics.kinetic_energy import mass_as_written
from hjsolve.mechanics.system import Coordinate, System, kinetic_rest, linear_terms

_SECONDS = 5.0
"""Of the budget, for the proof that a function whose derivative vanishes is one constant."""


@dataclass(frozen=True, repr=False)
class ReductionStep(Shown):
    """One step of an argument.

    Attributes:
        title: a few words.
        explanation: what was done and why, for a physicist.
        formula: the result of the step, or None.
    """

    title: str
    explanation: str
    formula: sp.Basic | None = None


@dataclass(frozen=True, repr=False)
class Shell(Shown):
    """The energy shell of a system; see the module's text.

    Attributes:
        system: the system it was made from.
        coordinates: the essential coordinates, in the user's order.
        ignorable: the coordinates that H does not hold; their momentum symbols are the constants c.
        inverse_metric: gᵃᵃ(q), one per essential coordinate; for a null coordinate the coefficient of its momentum.
        potential: V_eff(q; c), energy not subtracted.
        energy: the symbol of the energy.
        shift: Aₐ(q; c), one per essential coordinate; zero where H has no linear terms.
        shift_potential: χ with ∂χ/∂qₐ = Aₐ.
        steps: the reduction in words and formulas.
        null: names of essential coordinates whose momentum enters H linearly, not squared (T indefinite, gᵃᵃ = 0).
    """

    system: System
    coordinates: tuple[Coordinate, ...]
    ignorable: tuple[Coordinate, ...]
    inverse_metric: tuple[sp.Expr, ...]
    potential: sp.Expr
    energy: sp.Symbol
    shift: tuple[sp.Expr, ...]
    shift_potential: sp.Expr
    steps: tuple[ReductionStep, ...]
    null: tuple[str, ...] = ()

    @property
    def momentum_terms(self) -> tuple[sp.Expr, ...]:
        """Xₐ(p) with H = Σ gᵃXₐ + V_eff: ½(pₐ + Aₐ)², or pₐ itself for a null coordinate."""
        pairs = zip(self.coordinates, self.shift, strict=True)
        return tuple(c.momentum if c.name in self.null else (c.momentum + a) ** 2 / 2 for c, a in pairs)


@dataclass(frozen=True)
class Irreducible:
    """No shell exists in these coordinates.

    Attributes:
        reason: ``metric`` (the essential coordinates are coupled in T) or ``gyroscopic`` (linear terms that are no
        gradient). pair: names of the two coordinates.
        residual: the mass-matrix entry, or the curl ∂ᵢAⱼ − ∂ⱼAᵢ, that would have to vanish.
        steps: what had been done before.
        essential: the coordinates that H holds.
        ignorable: the others.
    """

    reason: str
    pair: tuple[str, str]
    residual: sp.Expr
    steps: tuple[ReductionStep, ...]
    essential: tuple[Coordinate, ...] = ()
    ignorable: tuple[Coordinate, ...] = ()


@dataclass(frozen=True)
class _Lagrangian:
    """T₂, T₁, T₀ and V as matrices of sympy expressions, without hidden ignorable coordinates."""

    mass: sp.Matrix
    linear: tuple[sp.Expr, ...]
    rest: sp.Expr
    potential: sp.Expr

    def parts(self) -> list[sp.Expr]:
        return [*self.mass, *self.linear, self.rest, self.potential]

    def couples(self, i: int) -> bool:
        """Return whether T ties the velocity of coordinate i to another one, or holds it linearly."""
        return bool(self.linear[i]) or any(x != 0 for j, x in enumerate(self.mass.row(i)) if j != i)

    def subs(self, symbol: sp.Symbol, value: sp.Expr) -> _Lagrangian:
        linear = tuple(x.subs(symbol, value) for x in self.linear)
        return _Lagrangian(
            self.mass.subs(symbol, value), linear, self.rest.subs(symbol, value), self.potential.subs(symbol, value)
        )


def domain_bounds(coordinates: Iterable[Coordinate]) -> dict[sp.Symbol, Bounds]:
    """Open interval of each coordinate; angles and lines have no ends.

    Returns:
        Symbol of the coordinate → (lower, upper) end.
    """
    return {
        c.symbol: (None, None) if c.domain.kind == "angle" else (c.domain.lower, c.domain.upper) for c in coordinates
    }


def energy_symbol(system: System) -> sp.Symbol:
    """Return the symbol E, or another letter where the user has taken E.

    Args:
        system: whose names are taken.
    """
    taken = set(system.symbols)
    return sp.Symbol(next(name for name in ("E", "h", "energy", "E_total") if name not in taken), real=True)


def time_name(system: System) -> str:
    """Return what the parameter of a motion is called: t, or another letter where the system has a coordinate t.

    Args:
        system: whose names are taken.
    """
    if system.time is not None:
        return system.time.name
    return time_letter([*system.symbols, *(c.momentum.name for c in system.coordinates)])


def reduce(system: System, budget: Budget | None = None) -> Shell | Irreducible:
    """Reduce a system to its energy shell.

    Args:
        system: any holonomic system with T = T₂ + T₁ + T₀ and V(q).
        budget: work allowed to exact arithmetic; 20 s by default.

    Returns:
        The ``Shell``, or ``Irreducible`` with the pair of coordinates that are coupled.

    Raises:
        WorkLimitError: exact arithmetic needs more than the budget, or T or V is outside its reach.
        InvalidSystemError: T or V divides by an expression that is identically zero.
    """
    budget = budget or Budget.processor_seconds(20.0)
    lagrangian = _Lagrangian(_mass(system), tuple(linear_terms(system)), kinetic_rest(system), system.potential)
    reader = Reader(lagrangian.parts(), domain_bounds(system.coordinates), budget)
    _refuse_divisions_by_zero(lagrangian, reader)
    ignorable, lagrangian = _find_ignorable(system, lagrangian, reader)
    essential = [i for i, c in enumerate(system.coordinates) if c not in ignorable]
    passive = [i for i, c in enumerate(system.coordinates) if c in ignorable]
    eliminated = _eliminate(system, lagrangian, reader, essential, passive)
    coordinates = tuple(system.coordinates[i] for i in essential)
    steps = _reduction_steps(system, ignorable, lagrangian, eliminated, reader)
    if eliminated.coupled is not None:
        i, j, entry = eliminated.coupled
        pair = coordinates[i].name, coordinates[j].name
        return Irreducible("metric", pair, shortest_form(reader, entry), steps, coordinates, ignorable)
    if (curl := _curl(coordinates, eliminated.shift, reader)) is not None:
        i, j, residual = curl
        pair = coordinates[i].name, coordinates[j].name
        return Irreducible("gyroscopic", pair, residual, steps, coordinates, ignorable)
    return _shell(system, coordinates, ignorable, lagrangian, eliminated, reader, steps)


def _shell(
    system: System,
    coordinates: tuple[Coordinate, ...],
    ignorable: tuple[Coordinate, ...],
    lagrangian: _Lagrangian,
    eliminated: Eliminated,
    reader: Reader,
    steps: tuple[ReductionStep, ...],
) -> Shell:
    metric = tuple(shortest_form(reader, g) for g in eliminated.metric)
    centrifugal = [shortest_form(reader, x) for x in eliminated.centrifugal]
    potential = sp.Add(lagrangian.potential, -lagrangian.rest, *centrifugal)
    shift = tuple(shortest_form(reader, x) for x in eliminated.shift)
    χ = closed_form_potential(reader, [c.symbol for c in coordinates], eliminated.shift)
    energy = energy_symbol(system)
    if any(shift):
        steps += (_shift_step(coordinates, χ),)
    null = tuple(coordinates[a].name for a in eliminated.null)
    if null:
        steps += (_null_step(null),)
    steps += (_shell_step(coordinates, metric, potential, energy, null, shifted=any(shift)),)
    return Shell(system, coordinates, ignorable, metric, potential, energy, shift, χ, steps, null)


def _refuse_divisions_by_zero(lagrangian: _Lagrangian, reader: Reader) -> None:
    """Refuse T or V with a denominator that is zero everywhere, however it is written."""
    try:
        for part in lagrangian.parts():
            reader.element(part)
    except ZeroDivisionError:
        raise InvalidSystemError(
            "T or V divides by an expression that is zero everywhere on the domain; correct the denominator"
        ) from None


def _shell_step(
    coordinates: tuple[Coordinate, ...], metric: tuple[sp.Expr, ...], potential: sp.Expr, energy: sp.Symbol,
    null: tuple[str, ...], *, shifted: bool,
) -> ReductionStep:  # fmt: skip
    """Return the shell in a formula; P in place of p where terms linear in the momenta were shifted away."""
    momenta = [sp.Symbol(f"P_{c.name}") if shifted else c.momentum for c in coordinates]
    powers = (p if c.name in null else p**2 / 2 for c, p in zip(coordinates, momenta))
    shell = sp.Add(*(g * power for g, power in zip(metric, powers)), potential)
    text = "On the shell, half the inverse metric times the squared momenta plus the effective potential is the energy."
    if shifted:
        text += " The momenta in it are P = p + gradient, as above."
    if not coordinates:
        text = "No coordinate is left: the effective potential is the energy, a function of the constant momenta."
    return ReductionStep("Energy shell", text, sp.Eq(shell, energy, evaluate=False))


def _mass(system: System) -> sp.Matrix:
    """Return the mass matrix as it falls out of T; the field brings it to normal form."""
    return sp.Matrix(mass_as_written(system.kinetic, [c.velocity for c in system.coordinates]))


def _find_ignorable(
    system: System, lagrangian: _Lagrangian, reader: Reader
) -> tuple[tuple[Coordinate, ...], _Lagrangian]:
    """Coordinates that T and V do not hold, also where they seem to (cos²φ + sin²φ); those are set to a number.

    One whose domain ends is kept among the others where nothing couples it to them: its motion ends there.

    Slopes that do not vanish at a point modulo a prime are no zero functions; the others are proved to be.
    """
    symbols = [c.symbol for c in system.coordinates]
    elements = [reader.element(x) for x in lagrangian.parts() if not x.free_symbols.isdisjoint(symbols)]
    places = at_random_points(reader, symbols, elements, points=1) or []
    found, kinked = [], {kink.coordinate for kink in system.kinks}
    for i, c in enumerate(system.coordinates):
        if c.name in kinked:
            continue
        if any(jet.slopes[i] for _, jets in places for jet in jets):
            continue
        if any(not reader.field.total(reader.diff_terms(x, c.symbol)).is_zero for x in elements):
            continue
        own = reader.field.budget.part(_SECONDS, reader.field.budget.terms)
        holding = [x for x in lagrangian.parts() if c.symbol in x.free_symbols]
        if not all(is_one_constant(reader, x, c.symbol, _inside(c), own) for x in holding):
            continue
        if holding:
            lagrangian = lagrangian.subs(c.symbol, _inside(c))
        if c.domain.kind != "interval" or lagrangian.couples(i):
            found.append(c)
    return tuple(found), lagrangian


def _inside(c: Coordinate) -> sp.Expr:
    """Return a simple value inside a coordinate's domain."""
    lower, upper = (None, None) if c.domain.kind == "angle" else (c.domain.lower, c.domain.upper)
    if lower is not None and upper is not None:
        return (lower + upper) / 2
    if lower is not None:
        return lower + 1
    return sp.S.Zero if upper is None else upper - 1


def _eliminate(
    system: System, lagrangian: _Lagrangian, reader: Reader, essential: Sequence[int], passive: Sequence[int]
) -> Eliminated:
    """Return the ignorable coordinates eliminated, with r = (c − a) for them and (−a) for the others."""
    n = range(len(system.coordinates))
    mass = [[reader.element(lagrangian.mass[i, j]) for j in n] for i in n]
    r = [-reader.element(a) for a in lagrangian.linear]
    for i in passive:
        r[i] = r[i] + reader.element(system.coordinates[i].momentum)
    return eliminate(reader, mass, r, essential, passive, [system.coordinates[i].symbol for i in essential])


def _curl(coordinates: tuple[Coordinate, ...], shift: list[Element], reader: Reader) -> tuple[int, int, sp.Expr] | None:
    """Return the first ∂ᵢAⱼ − ∂ⱼAᵢ that is not zero (Greenwood (2-40))."""
    for j in range(len(coordinates)):
        for i in range(j):
            curl = reader.diff(shift[j], coordinates[i].symbol) - reader.diff(shift[i], coordinates[j].symbol)
            if not curl.is_zero:
                return i, j, shortest_form(reader, curl)
    return None


def _reduction_steps(
    system: System, ignorable: tuple[Coordinate, ...], lagrangian: _Lagrangian, eliminated: Eliminated, reader: Reader
) -> tuple[ReductionStep, ...]:
    steps = []
    if ignorable:
        names = ", ".join(c.name for c in ignorable)
        constants = ", ".join(str(c.momentum) for c in ignorable)
        coupled = any(not x.is_zero for x in eliminated.shift) and not any(lagrangian.linear)
        text = (
            f"T and V do not contain {names}, so {constants} {'stays' if len(ignorable) == 1 else 'stay'} constant and "
            f"W is linear in {names}. Eliminating the velocities adds the centrifugal potential shown"
            + (", and terms linear in the momenta left." if coupled else ".")
        )
        steps.append(
            ReductionStep(
                "Ignorable coordinates", text, sp.Add(*(shortest_form(reader, x) for x in eliminated.centrifugal))
            )
        )
    if lagrangian.rest != 0:
        text = "The part of T without velocities acts as a potential: V' = V - T0."
        steps.append(ReductionStep("Velocity-free part of T", text, lagrangian.potential - lagrangian.rest))
    if not steps:
        names = ", ".join(c.name for c in system.coordinates)
        each = "" if len(system.coordinates) == 1 else "each of "
        text = f"No coordinate is ignorable: {each}{names} occurs in T or V, or may reach an end of its domain."
        steps.append(ReductionStep("Ignorable coordinates", text, None))
    return tuple(steps)


def _shift_step(coordinates: tuple[Coordinate, ...], χ: sp.Expr) -> ReductionStep:
    text = (
        "H has terms linear in the momenta left; together they are the gradient of the function shown, so they are "
        "removed by "
        "completing the square: P = p + gradient, and W loses that function."
    )
    if len(coordinates) == 1:
        text = "With one essential coordinate linear terms are always a gradient. " + text
    return ReductionStep("Linear terms", text, χ)


def _null_step(null: tuple[str, ...]) -> ReductionStep:
    text = (
        f"T is indefinite and the ignorable coordinates left over are light-like: H contains the momentum of "
        f"{', '.join(null)} to first degree, with the coefficient shown in the energy shell, so that no root is taken."
    )
    return ReductionStep("Null coordinates", text)
