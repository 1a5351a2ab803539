"""The verdict that a system separates, with its constants and its forms."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.display.shown import Shown, listed_names
from hjsolve.mechanics.energy_shell import ReductionStep, Shell
from hjsolve.mechanics.system import System


@dataclass(frozen=True, repr=False)
class Liouville(Shown):
    """A system of Liouville form: T = Σ Rᵢpᵢ²/(2Σf), V = Σv/Σf (Greenwood (5-125), (5-126)).

    Attributes:
        coordinates: names, in order.
        f: fᵢ(qᵢ); their sum is positive.
        R: Rᵢ(qᵢ), positive.
        v: vᵢ(qᵢ).
    """

    coordinates: tuple[str, ...]
    f: tuple[sp.Expr, ...]
    R: tuple[sp.Expr, ...]
    v: tuple[sp.Expr, ...]


@dataclass(frozen=True, repr=False)
class Stackel(Shown):
    """A system of Stäckel form: cᵀΦ = (1, 0, …, 0), cᵀψ = V (Greenwood (5-139), (5-140)).

    Attributes:
        coordinates: names, in order.
        matrix: Φ; row i depends on coordinate i only. The separated momenta are Pᵢ² = 2(Σⱼ Φᵢⱼ αⱼ − ψᵢ) with α₁ = E;
            for a null coordinate (``Shell.null``) pᵢ = Σⱼ Φᵢⱼ αⱼ − ψᵢ.
        column: ψ; entry i depends on coordinate i only.
        inverse_metric: c, the coefficients of ½pᵢ² in H.
    """

    coordinates: tuple[str, ...]
    matrix: sp.ImmutableMatrix
    column: tuple[sp.Expr, ...]
    inverse_metric: tuple[sp.Expr, ...]


@dataclass(frozen=True, repr=False)
class Reduced(Shown):
    """The forms of the shell over the essential coordinates; None where it is not of that form."""

    liouville: Liouville | None
    stackel: Stackel | None


@dataclass(frozen=True, repr=False)
class Constant(Shown):
    """A constant of the motion.

    Attributes:
        name: ``E``, ``alpha_2`` …, or the name of an ignorable momentum.
        symbol: its symbol in Φ, ψ and W.
        expression: the constant as a function of coordinates and momenta.
        meaning: what it is, in a physicist's words.
    """

    name: str
    symbol: sp.Symbol
    expression: sp.Expr
    meaning: str


@dataclass(frozen=True, repr=False)
class Separation(Shown):
    """The system separates in the coordinates given.

    Attributes:
        system: the system.
        shell: its energy shell.
        ignorable: names of the ignorable coordinates.
        constants: constants of the motion by name: E, the separation constants, the ignorable momenta.
        liouville: the Liouville functions of the full system, or None.
        stackel: the Stäckel matrix of the full system, or None (T not diagonal, or terms linear in the velocities).
        reduced: the same for the shell over the essential coordinates.
        evidence: the argument, step by step.
        seconds: how long the decision took.

    Example:
        >>> separate("kepler-planar").stackel.matrix.tolist()
        [[m, -1/r**2], [0, 1]]
    """

    system: System
    shell: Shell
    ignorable: tuple[str, ...]
    constants: dict[str, Constant]
    liouville: Liouville | None
    stackel: Stackel | None
    reduced: Reduced
    evidence: tuple[ReductionStep, ...]
    seconds: float

    def __str__(self) -> str:
        """Return the verdict in one sentence."""
        form = "of Liouville form" if self.liouville else "of Stäckel form" if self.stackel else ""
        shell = "of Liouville form" if self.reduced.liouville else "of Stäckel form" if self.reduced.stackel else ""
        why = f"it is {form}" if form else f"its energy shell is {shell}" if shell else "no coordinate is essential"
        are = "is" if len(self.ignorable) == 1 else "are"
        free = f", and {listed_names(self.ignorable)} {are} ignorable" if self.ignorable else ""
        return f"Separates in {listed_names(c.name for c in self.system.coordinates)}: {why}{free}."
