"""One motion of a family: its constants to many digits, and a place where it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.motion.motion import Motion
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.resonances.families import OneParameterFamily, Wells, place_in
from hjsolve.solution.quadratures import Solution

_SPARE = 192
"""Bits of constants beyond the digits asked: next to a separatrix or a circle Ω depends on the last of them."""


@dataclass(frozen=True)
class Member:
    """A motion of a family.

    Attributes:
        solution: what is solved.
        parameters: name → exact number, where it differs from the default.
        curves: p² of the separated coordinates, in doubles.
        wells: where the coordinates of it, or of a neighbour, move.
        constants: of the motion, to many digits.
    """

    solution: Solution
    parameters: Mapping[str, sp.Expr]
    curves: Sequence[RadicandCurve]
    wells: Wells
    constants: Mapping[str, Mpf]

    def motion(self, digits: int, want: Iterable[str] | None = None, *, certified: bool = False) -> Motion:
        """Start the motion where p² of every coordinate is greatest.

        Args:
            digits: asked.
            want: what is integrated; None for all.
            certified: whether its numbers are proved.

        Raises:
            HJSolveError: as of ``Solution.motion``.
        """
        κ = np.array([float(x) for x in self.constants.values()])
        q: dict[str, object] = {c.name: 0 for c in self.solution.system.coordinates}
        for curve, well in zip(self.curves, self.wells, strict=True):
            q[curve.name] = place_in(curve, κ, well)
        return self.solution.motion(
            q=q, constants=dict(self.constants), signs=dict.fromkeys(self.solution.coordinates, 1),
            parameters=dict(self.parameters), digits=digits, certified=certified,
            want=None if want is None else list(want),
        )  # fmt: skip


def member_of(family: OneParameterFamily, curves: Sequence[RadicandCurve], wells: Wells, u: Mpf) -> Member:
    """Return the motion of a family for a value of the unknown.

    Args:
        family: with one unknown.
        curves: p² of the separated coordinates, in doubles.
        wells: where the coordinates of a neighbour move.
        u: the unknown.
    """
    constants = family.constants(u, u.context.prec + _SPARE)
    return Member(family.solution, family.parameters, curves, wells, constants)
