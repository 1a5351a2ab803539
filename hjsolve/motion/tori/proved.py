"""A torus proved from its actions: the constants by an interval Newton step, the rest from the box that holds them.

With α₀ the constants of Newton's method, J(α₀) enclosed by quadrature with a proved error and K ∋ ∂J/∂α enclosed on a
box about α₀,

    N = α₀ + K⁻¹ (J − J(α₀))

holds every α of the box that has the actions J, by the mean value theorem. Where N lies inside the box and K has no
singular matrix there is exactly one (Moore, Kearfott and Cloud, Introduction to Interval Analysis, SIAM 2009, theorem
8.4). K consists of the mean growths of Jacobi's integrals; turning points and frequencies over the box come with it.
p² is taken as its formula in α: the programs of a motion may hold numbers of its own constants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from hjsolve.arithmetic.ball import flint, from_mpf, require_flint, working
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.certified.ball_radicand import BallMomentumSquared
from hjsolve.certified.integrands import CycleIntegrand
from hjsolve.certified.strip_bound import certified_means
from hjsolve.errors import InternalError, NotConvergedError, required
from hjsolve.motion.certified import Enclosed, cycle_of, exact_ball, refuse_unfit, rounded, work_bits
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.tori.polish import Goal
from hjsolve.motion.tori.radicand_curve import RadicandCurve

_KEPT = 40
"""Bits of J(α₀) beyond those of the result: what the narrowness of the motion and of K⁻¹ cost."""
_ROUNDING = 30
"""Bits of the working precision beyond those of J(α₀)."""
_ATTEMPTS = 4
"""How often the precision is doubled."""
_NEWTON_STEPS = 3
"""Most of the steps to the middle of the box, with ∂J/∂α as it was computed; each squares what is open."""
_WIDER = 2
"""The box over the step that leads to its middle."""


@dataclass(frozen=True)
class _Box:
    """Constants in balls, and where α is among them."""

    constants: list[flint.arb]
    unknown: list[int]


def proved_torus(
    motion: SeparatedMotion, goal: Goal, given: Mapping[str, sp.Expr], curves: Sequence[RadicandCurve], digits: int
) -> Enclosed:
    """Prove that there is one torus with the actions asked next to one that was computed, and enclose its numbers.

    Args:
        motion: a motion on the torus, computed without proof.
        goal: the actions as Newton's method takes them.
        given: coordinate → J as the motion has it, exact.
        curves: p² of the separated coordinates, as formulas in all constants.

    Raises:
        InvalidInputError: a coordinate neither librates nor rotates; that is not certified yet.
        MissingExtraError: python-flint is not installed.
        NotConvergedError: the step does not lead into the box, or an enclosure stayed wider than asked.
    """
    require_flint()
    refuse_unfit(motion)
    names = list(motion.solution.constants)
    unknown = [j for j, name in enumerate(names) if name not in goal.constants]
    kept = bits_for(digits, 12) + _KEPT
    for attempt in range(_ATTEMPTS):
        with working(max(work_bits(digits), kept + _ROUNDING) << attempt):
            known = [exact_ball(motion.initial.constants[name]) for name in names]
            # ignorable momenta stay balls: they are given, not sought
            centre = _Box([x.mid() if j in unknown else x for j, x in enumerate(known)], unknown)
            try:
                step = _step(motion, goal, curves, (centre, kept << attempt, digits))
                actions = {name: exact_ball(J) for name, J in given.items()}
                constants = dict(zip(names, step.constants, strict=True))
                return rounded(motion, digits, step.cycles, (constants, actions, step.growths))
            except NotConvergedError:
                if attempt == _ATTEMPTS - 1:
                    raise
    raise InternalError("the last attempt to prove a torus neither returned nor raised")


@dataclass(frozen=True)
class _Step:
    """What an interval Newton step leaves: constants, and cycles and growths over the box."""

    constants: list[flint.arb]
    cycles: dict[str, CycleIntegrand]
    growths: dict[str, list[flint.arb]]


def _step(
    motion: SeparatedMotion, goal: Goal, curves: Sequence[RadicandCurve], about: tuple[_Box, int, int]
) -> _Step:  # fmt: skip
    """Take the step from the middle of a box that it chooses itself.

    Raises:
        NotConvergedError: it does not lead into the box.
    """
    centre, kept, digits = about
    n, unknown = len(curves), centre.unknown
    coordinate_motions = [required(motion.located[curve.name].coordinate_motion.cycle) for curve in curves]
    context = multiprecision(kept)
    near = flint.arb_mat(
        [
            [from_mpf(context.convert(coordinate_motion.growth(j))) for j in unknown]
            for coordinate_motion in coordinate_motions
        ]
    )
    try:
        inverse = near.inv()
        middle, lost = _middle(motion, goal, curves, (centre, kept, inverse))
        # |K⁻¹| |J − J(α₀)| is the step to be expected; the box is twice as wide, so that the step ends well inside
        reach = [
            sum((_WIDER * abs(inverse[k, i]).upper() * lost[i].abs_upper() for i in range(n)), flint.arb(0)).upper()
            for k in range(n)
        ]
        box = list(middle)
        for k, j in enumerate(unknown):
            box[j] = flint.arb(middle[j], reach[k])
        cycles = _cycles(motion, curves, box)
        found = {
            name: dict(zip(c.wanted, certified_means(c, bits_for(digits, 12)), strict=True))
            for name, c in cycles.items()
        }  # fmt: skip
        # p² without αⱼ: the derivative is 0 exactly, and is not integrated
        growths = {name: [row.get(j, flint.arb(0)) for j in range(len(box))] for name, row in found.items()}
        K = flint.arb_mat([[growths[curve.name][j] for j in unknown] for curve in curves])
        move = K.solve(flint.arb_mat([[x] for x in lost]))
    except ZeroDivisionError as error:  # a singular matrix cannot be excluded
        raise NotConvergedError("actions: the torus could not be proved; its ∂J/∂α may be singular") from error
    # strictly inside: theorem 8.4 needs the interior of the box for existence and uniqueness
    if not all(abs(move[k, 0]) < reach[k] for k in range(n)):
        raise NotConvergedError("actions: the torus could not be proved; Newton's step leads out of its box")
    constants = list(middle)
    for k, j in enumerate(unknown):
        constants[j] = constants[j] + move[k, 0]
    return _Step(constants, cycles, growths)


def _middle(
    motion: SeparatedMotion, goal: Goal, curves: Sequence[RadicandCurve], about: tuple[_Box, int, flint.arb_mat]
) -> tuple[list[flint.arb], list[flint.arb]]:
    """Return constants whose actions are next to those asked, and J − J(α) there: Newton's steps with one matrix."""
    centre, kept, inverse = about
    at = list(centre.constants)
    for step in range(_NEWTON_STEPS):
        cycles = _cycles(motion, curves, at).values()
        # J − J(α₀) keeps only the bits in which they differ: J(α₀) has _KEPT bits more than the result
        lost = [
            exact_ball(J) - certified_means(replace(cycle, wanted=(-1,)), kept)[0]
            for J, cycle in zip(goal.actions, cycles, strict=True)
        ]
        if step == _NEWTON_STEPS - 1 or all(x.contains(0) for x in lost):
            break
        for k, j in enumerate(centre.unknown):
            move = sum((inverse[k, i] * x for i, x in enumerate(lost)), flint.arb(0))
            at[j] = (at[j] + move).mid()
    return at, lost


def _cycles(
    motion: SeparatedMotion, curves: Sequence[RadicandCurve], constants: Sequence[flint.arb]
) -> dict[str, CycleIntegrand]:
    """Prove the turning points of all coordinates for constants in balls; integrands are the mean growths alone."""
    result = {}
    for curve in curves:
        coordinate_motion = required(motion.located[curve.name].coordinate_motion.cycle)
        # the formula in all constants: for a box no number of this one motion may stand in it
        radicand = replace(coordinate_motion.radicand, squared=curve.squared, kernels=curve.kernels)
        inputs = [*constants, *(exact_ball(x) for x in curve.parameters)]
        cycle = cycle_of(motion, curve.name, BallMomentumSquared(radicand, inputs, flint.ctx.prec))
        result[curve.name] = replace(cycle, wanted=tuple(j for j in cycle.wanted if j >= 0))
    return result
