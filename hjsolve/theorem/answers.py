"""The answers of the tools that are not specific to one of them: a proof, or what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.display.shown import Shown, cut
from hjsolve.separation.zero_test.interval_evaluation import Witness

_LONGEST = 120


@dataclass(frozen=True, repr=False)
class Proof(Shown):
    """A statement that was proved exactly. It is true as a condition.

    Attributes:
        statement: what was proved, in symbols.
        expression: what the statement is about.
    """

    statement: str
    expression: sp.Expr

    def __str__(self) -> str:
        """Return the statement."""
        return f"Proved: {self.statement}."


@dataclass(frozen=True, repr=False)
class Flaw(Shown):
    """What is wrong with a formula, proved. It is false as a condition.

    Attributes:
        part: ``equation``, ``determinant``, ``constants``, ``integral``, ``brackets`` or ``valence``.
        statement: what fails, in words.
        residual: the expression that ought to vanish; of a ``determinant`` that vanishes, 0.
        witness: a rational point where the residual is enclosed away from zero; None where the fault is that
            something vanishes, or that a constant is missing.
    """

    part: str
    statement: str
    residual: sp.Expr
    witness: Witness | None = None

    def __bool__(self) -> bool:
        """Return False, so that ``if hjsolve.is_integral(…)`` reads as it is meant."""
        return False

    def __str__(self) -> str:
        """Return what fails, with the point that shows it."""
        if self.witness is None:
            return f"{self.statement}."
        place = ", ".join(f"{name} = {value}" for name, value in self.witness.point.items())
        value = f"{float((self.witness.lower + self.witness.upper) / 2):.6g}"
        where = f"at {place} " if place else ""
        return f"{self.statement}: {cut(str(self.residual), _LONGEST)} is not zero; {where}its value is {value}."
