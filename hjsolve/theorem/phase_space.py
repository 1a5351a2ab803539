"""What the tools need of a system: H, the symbols of (q, p, t), where they live; and the zero test there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

import sympy as sp

from hjsolve.algebra.signs import Bounds
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.extended.linear_hamiltonian import HamiltonianInTime, SumOfHamiltonians
from hjsolve.extended.one_freedom import LinearInMomentum, NonlinearInMomentum
from hjsolve.mechanics.brackets import conjugate_pairs
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.energy_shell import domain_bounds, time_name
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System, hamiltonian, velocities
from hjsolve.separation import Undecided
from hjsolve.separation.zero_test.on_domain import vanishes
from hjsolve.separation.zero_test.zero_test import Answer, NonZero, Zero
from hjsolve.theorem.answers import Flaw

Subject = System | LinearInMomentum | NonlinearInMomentum | HamiltonianInTime | SumOfHamiltonians
BUDGET = 20.0
"""Seconds for each zero test."""


@dataclass(frozen=True, repr=False)
class Variables(Shown):
    """Canonical variables without a system.

    Attributes:
        coordinates: with their momenta.
    """

    coordinates: tuple[Coordinate, ...]


@dataclass(frozen=True)
class PhaseSpace:
    """The variables of a system and their Hamiltonian.

    Attributes:
        subject: what the user named, or variables without a system.
        hamiltonian: H(q, p).
        pairs: the symbols (q, p) of every coordinate.
        velocities: name of a coordinate → q̇(q, p).
        symbols: every name that a formula may hold, and its symbol; velocities excluded.
        parameters: symbols of the parameters.
        time: the symbol of the time.
        bounds: open interval of each coordinate.
        defaults: default values of parameters.
    """

    subject: Subject | Variables
    hamiltonian: sp.Expr
    pairs: tuple[tuple[sp.Symbol, sp.Symbol], ...]
    velocities: Mapping[str, sp.Expr]
    symbols: Mapping[str, sp.Symbol]
    parameters: tuple[sp.Symbol, ...]
    time: sp.Symbol
    bounds: Mapping[sp.Symbol, Bounds]
    defaults: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)

    def vanishes(self, residual: sp.Expr, budget: float) -> Answer:
        """Decide whether an expression vanishes identically.

        A parameter with a default counts with the sign of its default: sqrt(k*m)*sqrt(k/m) is k for a mass and a
        stiffness, and a witness with a negative mass would show nothing.

        Args:
            residual: in the symbols of the space and in constants.
            budget: seconds.
        """
        signed = {p: _with_sign(p, self.defaults.get(p)) for p in self.parameters}
        bounds = {q: (_put(low, signed), _put(high, signed)) for q, (low, high) in self.bounds.items()}
        defaults = {signed[p]: value for p, value in self.defaults.items()}
        return vanishes(residual.xreplace(signed), bounds, signed.values(), defaults, budget)

    def proved_zero(self, residual: sp.Expr, part: str, statement: str, budget: float) -> Flaw | Undecided | None:
        """Prove that an expression vanishes; None is the proof.

        An integral that is left in it counts as a letter: what vanishes for every value of it vanishes, and the
        opposite proves nothing.

        Args:
            residual: what ought to vanish.
            part: of ``Flaw`` and ``Undecided``.
            statement: what fails where it does not vanish.
            budget: seconds.
        """
        plain, integrals = without_integrals(residual)
        answer = self.vanishes(plain, budget)
        if isinstance(answer, Zero):
            return None
        if isinstance(answer, NonZero) and not integrals:
            return Flaw(part, statement, residual, answer.witness)
        return self.undecided(residual, part, answer)

    def undecided(self, residual: sp.Expr, part: str, answer: Answer) -> Undecided:
        """Return the verdict that nothing was proved.

        Args:
            residual: what was not decided.
            part: ``equation``, ``determinant`` ….
            answer: of the zero test.
        """
        point, value = getattr(answer, "point", {}), getattr(answer, "value", None)
        advice = (
            "an integral is left in the expression; write it in closed form, or as a function of one coordinate"
            if residual.has(sp.Integral)
            else "allow more seconds with budget=, or write the formula in a simpler form"
        )
        return Undecided(cast("System", self.subject), None, (), part, residual, point, value, advice, ())


def _put(end: sp.Expr | None, signed: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr | None:
    return None if end is None else end.xreplace(signed)


def _with_sign(parameter: sp.Symbol, value: sp.Expr | None) -> sp.Symbol:
    """Return a symbol of the same name that has the sign of the value."""
    if value is None or value.is_zero or parameter.is_nonnegative or parameter.is_nonpositive:
        return parameter
    sign = {"positive": True} if value.is_positive else {"negative": True}
    return sp.Symbol(parameter.name, real=True, integer=parameter.is_integer, **sign)


def without_integrals(expression: sp.Expr) -> tuple[sp.Expr, bool]:
    """Return the expression with a letter for every integral, and whether there was one."""
    letters: dict[sp.Basic, sp.Dummy] = {}

    def letter(node: sp.Basic) -> sp.Dummy:
        return letters.setdefault(node, sp.Dummy(f"integral_{len(letters)}", real=True))

    return expression.replace(lambda e: isinstance(e, sp.Integral), letter), bool(letters)


def phase_space_of(subject: object, verb: str) -> PhaseSpace:
    """Return the phase space of a system.

    Args:
        subject: a ``System``, what ``from_hamiltonian`` gave, or the id or file of a catalog entry.
        verb: the function that asks, for the message.

    Raises:
        InvalidInputError: none of these; or V has kinks, whose sides are different formulas.
    """
    if isinstance(subject, (LinearInMomentum, NonlinearInMomentum, HamiltonianInTime, SumOfHamiltonians)):
        return _of_hamiltonian(subject)
    system = system_of(subject, verb)
    if system.kinks:
        raise InvalidInputError(
            f"{verb}: V has kinks or jumps; give {system.kinks[0].coordinate} a domain on one side of them"
        )
    time = sp.Symbol(time_name(system), real=True)
    pairs = tuple(conjugate_pairs(system.coordinates))
    momenta = {p.name: p for _, p in pairs}
    return PhaseSpace(
        system, hamiltonian(system), pairs, velocities(system),
        {**momenta, time.name: time, **system.symbols}, tuple(p.symbol for p in system.parameters), time,
        domain_bounds(system.coordinates), system.defaults,
    )  # fmt: skip


def _of_hamiltonian(
    subject: LinearInMomentum | NonlinearInMomentum | HamiltonianInTime | SumOfHamiltonians,
) -> PhaseSpace:
    coordinates, H = subject.coordinates, subject.hamiltonian
    time = sp.Symbol("t", real=True)
    own = [s for c in coordinates for s in (c.symbol, c.momentum)]
    symbols = {s.name: s for s in (*own, time, *(p.symbol for p in subject.parameters))}
    defaults = {p.symbol: p.value for p in subject.parameters if p.value is not None}
    return PhaseSpace(
        subject, H, tuple(conjugate_pairs(coordinates)), {c.name: sp.diff(H, c.momentum) for c in coordinates},
        symbols, tuple(p.symbol for p in subject.parameters), time, domain_bounds(subject.coordinates), defaults,
    )  # fmt: skip
