"""A motion made ready to be differentiated: more digits than are asked, and every integral with its derivatives."""

from __future__ import annotations

from functools import lru_cache

import sympy as sp
from sympy.functions.elementary.trigonometric import TrigonometricFunction

from hjsolve.arithmetic.floats import bits_for
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.derivatives.along_branch import open_variations
from hjsolve.motion.derivatives.along_cycle import cycle_variations
from hjsolve.motion.derivatives.at_rest import rest_variations
from hjsolve.motion.derivatives.canonical import ConstantsToState, CoordinateVariations, canonical_map
from hjsolve.motion.derivatives.formulas import VariedSymbols, formulas_of, variables_of
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.separated import SeparatedMotion, separated_motion
from hjsolve.one_coordinate.coordinate_motion import PARTS, AtRest, Periodic, Unbounded

MORE = 12
"""Digits beyond those asked: what second derivatives and conditioning may lose without being seen."""


@lru_cache(maxsize=16)
def finer(motion: Motion, more: int = MORE) -> SeparatedMotion:
    """Return the motion in more digits than it was asked for.

    Args:
        more: digits beyond those of the motion.
    """
    digits = motion.digits + more
    # constants found from actions are numbers of as many digits as were asked: they are found again, finer
    if motion.given.get("actions") is not None and motion.again is not None:
        return motion.again(digits, {}).separated
    own = motion.separated
    return separated_motion(own.solution, own.initial, own.t0, digits, PARTS)


@lru_cache(maxsize=16)
def prepared(motion: Motion, parameters: bool, more: int = MORE) -> ConstantsToState | None:
    """Return the derivatives of all integrals of a motion; None where every coordinate is ignorable.

    Args:
        parameters: whether these are varied beside the constants.
        more: digits beyond those of the motion.

    Raises:
        InvalidInputError: p² has kinks, or a coordinate rests where the motion next to it is not linear.
        NotConvergedError: an integral did not converge to the digits asked.
    """
    refuse_kinks(motion.solution.system.kinks, "derivatives")
    source = finer(motion, more)
    # all p are constant, and q̇ = ∂H/∂p with them: nothing is integrated
    if not source.solution.coordinates:
        return None
    variables = variables_of(source.solution, parameters=parameters)
    parts = [_varied(source, name, variables) for name in source.solution.coordinates]
    return canonical_map(source, variables, parts)


def _varied(source: SeparatedMotion, name: str, variables: VariedSymbols) -> CoordinateVariations:
    formulas = formulas_of(source.solution, source.initial, name, variables)
    match source.located[name].coordinate_motion:
        case Periodic() as coordinate_motion:
            return cycle_variations(
                coordinate_motion, formulas, _stretched(source, name, variables, coordinate_motion), source.digits
            )
        case AtRest() as coordinate_motion:
            return rest_variations(coordinate_motion, formulas, source.digits)
        case Unbounded() as coordinate_motion:
            return open_variations(coordinate_motion, formulas, source.digits)
        case _:
            raise InvalidInputError(f"derivatives: not for {name}, along which p² has kinks")


def _stretched(
    source: SeparatedMotion, name: str, variables: VariedSymbols, coordinate_motion: Periodic
) -> list[Mpf | int]:
    """How the length of a turn changes along a line, (ln L)_b = −(ln a)_b for waves of a·q.

    Raises:
        InvalidInputError: with other parameters p² does not repeat itself.
    """
    # an angle has its 2π: only the turn of a rotation along a line has a length that parameters change
    if not coordinate_motion.rotates or source.solution.system.coordinate(name).domain.kind == "angle":
        return [0] * variables.count
    q = source.solution.system.coordinate(name).symbol
    F = source.solution.momentum_squared[name]
    rates = [sp.diff(w.args[0], q) for w in F.atoms(TrigonometricFunction) if w.has(q)]
    # a common period exists next to these parameters only if the ratio of wave numbers does not depend on them
    if any(not sp.cancel(rate / rates[0]).is_Rational for rate in rates):
        raise InvalidInputError(
            f"derivatives: the waves along {name} are commensurate for these values of the parameters only"
        )
    slopes = [-sp.diff(sp.log(rates[0]), b).subs(source.initial.values) for b in variables.symbols]
    return [to_bits(slope)(bits_for(source.digits, 128)) for slope in slopes]
