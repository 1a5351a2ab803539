"""What is worked out once for all regimes of a solution: the curves of its momenta, and the pieces found so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve, W, momentum_curves
from hjsolve.closed_form.involutions import why_no_curve, why_no_form
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.verification import DIGITS
from hjsolve.closed_form.why_not import WhyNot
from hjsolve.solution.quadratures import Solution

SpecialCase = Mapping[sp.Symbol, sp.Expr]
"""Constant of the motion → what it is where it is special."""


@dataclass
class FormContext:
    """What is shared by the regimes of one solution.

    Attributes:
        solution: what is solved.
        curves: separated coordinate → its curves, for general constants.
        numerators: separated coordinate → W or constant → N(q), none zero.
        pieces: pieces found so far, by coordinate and special case.
        digits: to which forms are compared with the quadratures.
    """

    solution: Solution
    curves: dict[str, list[MomentumCurve]]
    numerators: dict[str, dict[sp.Symbol, sp.Expr]]
    pieces: dict[tuple[str, tuple[object, ...]], list[CoordinateIntegrals]]
    digits: int

    def why_no_integral(self, name: str) -> WhyNot:
        """Return why a coordinate has no integral in closed form: of its curves, or why it has none.

        Args:
            name: of a separated coordinate.
        """
        if own := self.curves[name]:
            return why_no_form(own)
        numerators = [N for key, N in self.numerators[name].items() if key != W]
        return why_no_curve(self.solution.momentum_squared[name], numerators, self.solution.system.coordinate(name))

    @property
    def constants(self) -> list[sp.Symbol]:
        """E, the separation constants, the ignorable momenta."""
        return [c.symbol for c in self.solution.constants.values()]

    def at(self, special: SpecialCase) -> dict[str, list[MomentumCurve]]:
        """Return the curves where some constants are special.

        Args:
            special: constant → what it is.
        """
        if not special:
            return self.curves
        return {name: [c for curve in own if (c := curve.at(special)) is not None] for name, own in self.curves.items()}


def context_of(solution: Solution, digits: int = DIGITS) -> FormContext:
    """Find the curves of every separated coordinate.

    Args:
        solution: what is solved.
        digits: to which forms are to be compared with the quadratures.
    """
    own, numerators = dict[str, list[MomentumCurve]](), dict[str, dict[sp.Symbol, sp.Expr]]()
    taken = {s.name for s in solution.characteristic_function.free_symbols}
    for name, square in solution.momentum_squared.items():
        letter = "x" if "x" not in taken else "z"
        while letter in taken:
            letter += "_"
        own[name] = momentum_curves(square, solution.system.coordinate(name), sp.Symbol(letter, real=True))
        slopes = {c.symbol: sp.diff(square, c.symbol) / 2 for c in solution.constants.values()}
        numerators[name] = {W: square} | {c: slope for c, slope in slopes.items() if slope != 0}
    return FormContext(solution, own, numerators, {}, digits)
