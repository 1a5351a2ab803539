"""The verdicts that a system does not separate, and that it is not known."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.display.shown import Shown, listed_names
from hjsolve.mechanics.energy_shell import ReductionStep, Shell
from hjsolve.mechanics.system import System
from hjsolve.separation.zero_test.interval_evaluation import Witness

_LONGEST = 120
"""Letters of a formula in a sentence."""


@dataclass(frozen=True, repr=False)
class Obstruction(Shown):
    """The system does not separate in the coordinates given; proved at a witness.

    It is a statement about these coordinates: the system may separate in others, or be integrable without separating.

    Attributes:
        system: the system.
        shell: its energy shell, or None where there is none.
        pair: names of the two coordinates that cannot be separated from each other.
        part: ``metric``, ``potential``, ``gyroscopic``, or ``time`` where H holds the time.
        residual: the expression that would have to vanish identically.
        witness: a rational point where it is enclosed away from zero.
        advice: what to try.
        evidence: the argument, step by step.
        distance: how far from separable: the relative error with which the base-point construction rebuilds the
            metric (or the potential, where ``part`` says so) at sample points, parameters at their default values; 0
            would be separable. None where it could not be measured. It decided nothing.
        blocks: the finest partition of the essential coordinates into blocks that are proved to separate from each
            other; a single block when there is none, empty when it was not looked for.
        conformal: whether the shell is proved to separate at one energy, ``conformal_energy``, though not at every
            energy; None when it was not decided.
        conformal_energy: that energy, a function of parameters and ignorable momenta.

    Example:
        >>> verdict = separate("henon-heiles")
        >>> verdict.pair, verdict.residual, verdict.witness.point
        (('x', 'y'), 2*lambda_*x, {'lambda_': 1, 'x': 2/3})
    """

    system: System
    shell: Shell | None
    pair: tuple[str, str]
    part: str
    residual: sp.Expr
    witness: Witness
    advice: str
    evidence: tuple[ReductionStep, ...]
    distance: float | None = None
    blocks: tuple[tuple[str, ...], ...] = ()
    conformal: bool | None = None
    conformal_energy: sp.Expr | None = None

    def __str__(self) -> str:
        """Return the verdict in one sentence."""
        names, pair = listed_names(c.name for c in self.system.coordinates), dict.fromkeys(self.pair)
        who = f"{'couples' if len(pair) > 1 else 'is not of a separable form in'} {listed_names(pair)}"
        part = _PARTS.get(self.part, self.part)
        return f"Does not separate in {names}: the {part} {who}, since {_shown(self.residual)} is not zero everywhere."


@dataclass(frozen=True, repr=False)
class Undecided(Shown):
    """Neither proved to separate nor proved not to.

    Attributes:
        system: the system.
        shell: its energy shell, or None.
        pair: the pair of coordinates that could not be settled; empty when no pair was reached.
        part: ``metric``, ``potential``, ``gyroscopic`` or ``reduction``.
        residual: the expression whose vanishing could not be decided.
        point: where ``value`` was taken.
        value: the residual there to 40 digits, or None.
        advice: what to try.
        evidence: the argument so far.
    """

    system: System
    shell: Shell | None
    pair: tuple[str, ...]
    part: str
    residual: sp.Expr
    point: dict[str, sp.Rational]
    value: mpmath.mpf | None
    advice: str
    evidence: tuple[ReductionStep, ...]

    def __str__(self) -> str:
        """Return the verdict in one sentence."""
        names = listed_names(c.name for c in self.system.coordinates)
        return f"Not decided in {names}: {_shown(self.residual)} was proved neither to vanish everywhere nor not to."


_PARTS = {"metric": "kinetic energy", "gyroscopic": "gyroscopic term", "time": "explicit time"}


def _shown(residual: sp.Expr) -> str:
    text = str(residual)
    return text if len(text) <= _LONGEST else "the residual (a long expression)"
