"""H(q, p) of one degree of freedom that is not T + V, as formulas; how it is solved is in ``linear_hamiltonian.py``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Generic, NamedTuple, TypeVar

import sympy as sp

from hjsolve import arguments
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import Coordinate, Parameter

ENERGY = sp.Symbol("E", real=True)
TIME = sp.Symbol("t", real=True)
M = TypeVar("M")
"""What a motion is."""


class Beginning(NamedTuple):
    """Initial data: positions and momenta by name, values of parameters that differ, t0, relative digits wanted."""

    q: Mapping[str, object]
    p: Mapping[str, object]
    parameters: Mapping[str, object]
    t0: object
    digits: int


class StartedByMomenta(Generic[M]):
    """A Hamiltonian whose motions start from places and momenta, as velocities do not say what p is."""

    _reason: ClassVar[str] = "several p may have the same dq/dt here"

    @arguments.by_name('motion(q={"q": 1}, p={"q": 0})')
    def motion(
        self, *, q: Mapping[str, object], velocity: Mapping[str, object] | None = None,
        p: Mapping[str, object] | None = None, parameters: Mapping[str, object] | None = None,
        t0: object = 0, digits: int = 15,
    ) -> M:  # fmt: skip
        """Start a motion.

        Args:
            q: every coordinate → position at t0.
            velocity: refused: several p may have the same dq/dt.
            p: every coordinate → momentum at t0.
            parameters: values that differ from the defaults.
            t0: initial time.
            digits: relative digits wanted.

        Returns:
            The motion; ``motion.at(t)`` is the state.

        Raises:
            InvalidInputError: no momentum, or a place outside the domain.
            MissingValueError: a number is missing.
            NotSeparableError: a part of several coordinates does not separate.
            NotConvergedError: a motion that is not linear in p does not come back, or meets a place where branches
                p(q; E) cannot be told apart.
        """
        if velocity is not None or p is None:
            raise InvalidInputError(f"initial data: give p={{…}} of every coordinate; {self._reason}")
        return self._started(Beginning(q, p, parameters or {}, t0, digits))

    def _started(self, begin: Beginning) -> M:
        raise NotImplementedError


class OfOneCoordinate:
    """What has one coordinate."""

    coordinate: Coordinate

    @property
    def coordinates(self) -> tuple[Coordinate]:
        """The one coordinate, as a ``System`` has them."""
        return (self.coordinate,)


@dataclass(frozen=True, repr=False)
class LinearInMomentum(OfOneCoordinate, Shown):
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
class NonlinearInMomentum(OfOneCoordinate, Shown):
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
    def velocity(self) -> sp.Expr:
        """dq/dt = ∂H/∂p, in q and p."""
        return sp.diff(self.hamiltonian, self.coordinate.momentum)

    @property
    def force(self) -> sp.Expr:
        """dp/dt = −∂H/∂q, in q and p."""
        return -sp.diff(self.hamiltonian, self.coordinate.symbol)
