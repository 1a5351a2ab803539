"""The values that ``find_coordinates`` gives back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.coordinates.webs.web import Geometry, Vector, Web
from hjsolve.display.shown import Shown

if TYPE_CHECKING:
    from hjsolve.mechanics.system import System

__all__ = ["Geometry", "ParameterValues", "SeparableCoordinates", "Vector", "Web"]


@dataclass(frozen=True, repr=False)
class ParameterValues(Shown):
    """Values of parameters at which more quadratic integrals exist.

    Attributes:
        conditions: parameter name → value or expression in the other parameters.
        kernel_dimension: dimension of the kernel there.
    """

    conditions: Mapping[str, sp.Expr]
    kernel_dimension: int


@dataclass(frozen=True, repr=False)
class SeparableCoordinates(Shown):
    """All orthogonal separable coordinate systems of a natural system in the plane, in space or on a sphere.

    Attributes:
        system: the system asked about.
        kernel_dimension: number of independent Killing tensors K with d(K·dV) = 0, the metric included; the number of
            quadratic integrals, energy included.
        concircular_dimension: number of independent concircular tensors L whose K = (tr L) g − L is in the kernel.
        killing_tensors: a basis of the kernel, matrices of polynomials in the coordinates of equal mass (on a sphere:
            those of space, quadratic in x × p).
        webs: the separable webs; a family is given by a representative.
        special: parameter values at which there are more.
        complete: whether the dimensions were confirmed by an independent count.
        advice: the result in words.
        seconds: time spent.
        undecided: what was not decided within the budget, a sentence; empty where all was. Where the kernel itself was
            not found, its dimensions are 0.
    """

    system: System
    kernel_dimension: int
    concircular_dimension: int
    killing_tensors: tuple[sp.ImmutableMatrix, ...]
    webs: tuple[Web, ...]
    special: tuple[ParameterValues, ...]
    complete: bool
    advice: str
    seconds: float
    undecided: str = ""

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of the webs found, each once, in the order found."""
        return tuple(dict.fromkeys(web.kind for web in self.webs))
