"""The three verdicts and what they carry; every one is a frozen value with its evidence."""

from __future__ import annotations

from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.mechanics.energy_shell import ReductionStep, Shell
from hjsolve.mechanics.system import System
from hjsolve.separation.zero_test.interval_evaluation import Witness


@dataclass(frozen=True, repr=False)
class Liouville(Shown):
    """A system of Liouville's form: T = Σ Rᵢpᵢ²/(2Σf), V = Σv/Σf (Greenwood (5-125), (5-126)).

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
    """A system of Stäckel's form: cᵀΦ = (1, 0, …, 0), cᵀψ = V (Greenwood (5-139), (5-140)).

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
        liouville: Liouville's functions of the full system, or None.
        stackel: Stäckel's matrix of the full system, or None (T not diagonal, or terms linear in the velocities).
        reduced: the same for the shell over the essential coordinates.
        evidence: the argument, step by step.
        seconds: how long the decision took.
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


@dataclass(frozen=True, repr=False)
class Obstruction(Shown):
    """The system does not separate in the coordinates given; proved at a witness.

    It is a statement about these coordinates: the system may separate in others, or be integrable without separating.

    Attributes:
        system: the system.
        shell: its energy shell, or None where there is none.
        pair: names of the two coordinates that cannot be separated from each other.
        part: ``metric``, ``potential`` or ``gyroscopic``.
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


Verdict = Separation | Obstruction | Undecided
