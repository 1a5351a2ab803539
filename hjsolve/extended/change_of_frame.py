"""Declared frames and gauges: a system with explicit time that becomes autonomous, by a change that is verified.

    q = f(Q, t),     L(f, ḟ, t) = L′(Q, Q̇) + dΛ(Q, t)/dt

L′ holds no time, so Hamilton–Jacobi separates it as usual; the difference dΛ/dt changes no equation of motion
(Greenwood Ex 6-5, 6-9, P6-13: a generating function F₂ in general). Momenta go back as pᵢ = ∂L/∂q̇ᵢ, and
P = (∂f/∂Q)ᵀ p − ∂Λ/∂Q. The identity above is decided exactly when the frame is made; nothing is taken on trust.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import System, hamiltonian, momenta
from hjsolve.separation.zero_test.zero_test import Zero, is_zero
from hjsolve.solution.quadratures import Solution, solve

TIME = "t"
C = TypeVar("C", bound="ChangeOfFrame")
"""What is checked, given back as it came."""


@dataclass(frozen=True, repr=False)
class ChangeOfFrame(Shown):
    """A system with explicit time and the autonomous one it becomes.

    Attributes:
        system: the autonomous system, in Q.
        original: the system as posed, in q; the time is one of its parameters.
        place: coordinate q → f(Q, t).
        gauge: Λ(Q, t).
        time: the symbol of the time.
    """

    system: System
    original: System
    place: Mapping[str, sp.Expr]
    gauge: sp.Expr
    time: sp.Symbol

    @property
    def velocity(self) -> dict[str, sp.Expr]:
        """q̇ = ∂f/∂Q Q̇ + ∂f/∂t by coordinate q."""
        return {name: self.total_derivative(f) for name, f in self.place.items()}

    def total_derivative(self, f: sp.Expr) -> sp.Expr:
        """d/dt of a function of Q and t along the motion."""
        return sp.diff(f, self.time) + sp.Add(*(sp.diff(f, c.symbol) * c.velocity for c in self.system.coordinates))

    def residual(self) -> sp.Expr:
        """L(f, ḟ, t) − L′ − dΛ/dt, which has to vanish."""
        speeds = self.velocity
        at = {c.symbol: self.place[c.name] for c in self.original.coordinates}
        at |= {c.velocity: speeds[c.name] for c in self.original.coordinates}
        L = (self.original.kinetic - self.original.potential).xreplace(at)
        return sp.expand(L - self.system.kinetic + self.system.potential - self.total_derivative(self.gauge))

    def inverse(self) -> dict[sp.Symbol, sp.Expr]:
        """Q(q, t); f is affine in Q."""
        unknown = [c.symbol for c in self.system.coordinates]
        equations = [c.symbol - self.place[c.name] for c in self.original.coordinates]
        return dict(zip(unknown, sp.Matrix(sp.linsolve(equations, unknown).args[0]), strict=True))

    def new_momenta(self) -> dict[sp.Symbol, sp.Expr]:
        """P = (∂f/∂Q)ᵀ p − ∂Λ/∂Q, in p, Q and t."""
        old = [(c.momentum, self.place[c.name]) for c in self.original.coordinates]
        return {
            c.momentum: sp.Add(*(p * sp.diff(f, c.symbol) for p, f in old), -sp.diff(self.gauge, c.symbol))
            for c in self.system.coordinates
        }

    def constants(self, solution: Solution) -> dict[str, sp.Expr]:
        """Return the constants of the motion as functions of the q, p and t of the original system.

        Args:
            solution: of the autonomous system.
        """
        at, back = self.new_momenta(), self.inverse()
        return {
            name: constant.expression.subs(at, simultaneous=True).subs(back, simultaneous=True)
            for name, constant in solution.constants.items()
        }

    def principal_function(self, solution: Solution) -> sp.Expr:
        """S(q, t) = W(Q(q, t)) − E t + Λ(Q(q, t), t), which solves ∂S/∂t + H(q, ∂S/∂q, t) = 0.

        With L = L′ + dΛ/dt the momenta are p = ∂(S′ + Λ)/∂q, S′ = W − E t of the autonomous system (5-65).

        Args:
            solution: of the autonomous system, with W(Q).
        """
        energy = solution.separation.shell.energy if solution.coordinates else solution.separation.shell.potential
        S = solution.characteristic_function - energy * self.time + self.gauge
        back = {symbol: sp.simplify(formula) for symbol, formula in self.inverse().items()}
        return S.subs(back, simultaneous=True)

    def solve(self) -> Solution:
        """Solve the autonomous system by quadratures; NotSeparableError as ``hjsolve.solve``."""
        return solve(self.system)


def verified(frame: C) -> C:
    """Give the frame back if it is what it claims.

    Raises:
        InvalidSystemError: the map is not affine in Q, not invertible, or the identity fails; the residual is shown.
    """
    unknown = [c.symbol for c in frame.system.coordinates]
    matrix = sp.Matrix([[sp.diff(frame.place[c.name], Q) for Q in unknown] for c in frame.original.coordinates])
    if matrix.free_symbols & set(unknown):
        raise InvalidSystemError("frame: the map must be affine in the new coordinates")
    if matrix.rows != matrix.cols or isinstance(is_zero(matrix.det()), Zero):
        raise InvalidSystemError("frame: the map is not invertible")
    if isinstance(is_zero(frame.residual()), Zero):
        return frame
    raise InvalidSystemError(
        f"frame: L - L' - dΛ/dt is {frame.residual()}, not zero: the map and the gauge do not lead to this system"
    )


def drift(frame: ChangeOfFrame, expression: sp.Expr) -> sp.Expr:
    """∂f/∂t + (f, H) of a function f(q, p, t) of the original system (6-235): zero for a constant of the motion.

    Args:
        frame: with the original system.
        expression: f(q, p, t).
    """
    H, total = hamiltonian(frame.original), sp.diff(expression, frame.time)
    for c in frame.original.coordinates:
        total += sp.diff(expression, c.symbol) * sp.diff(H, c.momentum)
        total -= sp.diff(expression, c.momentum) * sp.diff(H, c.symbol)
    return total


def carried_initial_data(
    frame: ChangeOfFrame, values: Mapping[sp.Symbol, sp.Expr], q: Mapping[str, object],
    velocity: Mapping[str, object] | None, p: Mapping[str, object] | None,
) -> dict[str, Any]:  # fmt: skip
    """Bring initial data over to the autonomous system, exactly: ``{"q": …, "p": …}``.

    Args:
        frame: of both systems.
        values: parameters and the time, exact.
        q: original positions.
        velocity: original velocities, or
        p: original momenta.

    Raises:
        InvalidInputError: velocity and p both or neither, or a name that is not an original coordinate.
        MissingValueError: a coordinate without a value.
    """
    from hjsolve.motion.initial_data import complete_numbers, one_of_velocity_and_p  # numpy: not to check a system

    old = frame.original.coordinates
    what, given = one_of_velocity_and_p(velocity, p)
    places, rates = complete_numbers(old, q, "q"), complete_numbers(old, given, what)
    at = dict(values) | {c.symbol: places[c.name] for c in old}
    if what == "velocity":
        speeds = {c.velocity: rates[c.name] for c in old}
        at |= {c.momentum: momenta(frame.original)[c.name].xreplace({**at, **speeds}) for c in old}
    else:
        at |= {c.momentum: rates[c.name] for c in old}
    new = {symbol: formula.subs(at) for symbol, formula in frame.inverse().items()}
    P = {symbol: formula.subs({**at, **new}) for symbol, formula in frame.new_momenta().items()}
    return {
        "q": {c.name: sp.expand(new[c.symbol]) for c in frame.system.coordinates},
        "p": {c.name: sp.expand(P[c.momentum]) for c in frame.system.coordinates},
    }
