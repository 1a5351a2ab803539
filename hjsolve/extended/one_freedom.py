"""H(q, p) of one degree of freedom that is not T + V, as formulas; how it is solved is in ``linear_hamiltonian.py``."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.mechanics.system import Coordinate, Parameter

ENERGY = sp.Symbol("E", real=True)
TIME = sp.Symbol("t", real=True)


@dataclass(frozen=True, repr=False)
class LinearInMomentum(Shown):
    """H = a(q) p + b(q), solved.

    Attributes:
        coordinate: q.
        hamiltonian: H.
        rate: a(q), which is dq/dt.
        rest: b(q).
        parameters: with their default values.
        title, id: for display.
    """

    coordinate: Coordinate
    hamiltonian: sp.Expr
    rate: sp.Expr
    rest: sp.Expr
    parameters: tuple[Parameter, ...] = ()
    title: str = ""
    id: str = ""

    @property
    def coordinates(self) -> tuple[Coordinate]:
        """The one coordinate, as a ``System`` has them."""
        return (self.coordinate,)

    @property
    def momentum(self) -> sp.Expr:
        """p(q; E) = (E − b)/a."""
        return (ENERGY - self.rest) / self.rate

    @property
    def characteristic_function(self) -> sp.Expr:
        """W(q; E) = ∫ p dq, by quadrature."""
        return sp.expand(sp.integrate(sp.expand(self.momentum), self.coordinate.symbol))

    @property
    def principal_function(self) -> sp.Expr:
        """S(q, t; E) = W − E t."""
        return self.characteristic_function - ENERGY * TIME

    @property
    def time_law(self) -> sp.Expr:
        """∂W/∂E = t − β as a function of q: the integral of dq/a, without a constant of integration."""
        return sp.integrate(1 / self.rate, self.coordinate.symbol)


@dataclass(frozen=True, repr=False)
class NonlinearInMomentum(Shown):
    """H(q, p) of one degree of freedom that is not a polynomial of first or second degree in p.

    Attributes:
        coordinate: q.
        hamiltonian: H.
        parameters: with their default values.
        title, id: for display.
    """

    coordinate: Coordinate
    hamiltonian: sp.Expr
    parameters: tuple[Parameter, ...] = ()
    title: str = ""
    id: str = ""

    @property
    def coordinates(self) -> tuple[Coordinate]:
        """The one coordinate, as a ``System`` has them."""
        return (self.coordinate,)

    @property
    def velocity(self) -> sp.Expr:
        """dq/dt = ∂H/∂p, in q and p."""
        return sp.diff(self.hamiltonian, self.coordinate.momentum)

    @property
    def force(self) -> sp.Expr:
        """dp/dt = −∂H/∂q, in q and p."""
        return -sp.diff(self.hamiltonian, self.coordinate.symbol)
