"""Tori from frequencies or from a ratio of them: what ``Solution.torus`` does.

With one unknown the family is looked through (``scan.py``), and every change of sign of the equation is followed to a
motion with more digits than are asked. With several, Newton's method begins at motions all over phase space
(``several_unknowns.py``). A ratio is that of |Ω|: oscillations or turns of one coordinate to those of another.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import ceil, floor

import numpy as np

from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.errors import HJSolveError, InvalidInputError, NotConvergedError
from hjsolve.motion.motion import Motion
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.resonances.equations import Equation
from hjsolve.resonances.families import OneParameterFamily
from hjsolve.resonances.members import member_of
from hjsolve.resonances.question import TorusQuestion, in_words
from hjsolve.resonances.scan import Bracket, Scan, scanned
from hjsolve.resonances.several_unknowns import tori_by_newton

_GREATEST, _MANY = 12, 6
"""Largest denominator that is looked at, and how many ratios are given."""

_AT_AN_END = 1e-9
"""Relative distance from an end of the range below which a ratio is not given: it is only approached."""

_SPARE = 5
"""Decimal digits that motions have beyond those asked while a root is looked for."""
_WIDENINGS = 10
"""Times that the bracket of a proof is made wider, tenfold each."""
_GRID = 97
"""Values of the unknown that are looked at between the bounds that are given."""


def tori(asked: TorusQuestion) -> Motion | tuple[Motion, ...]:
    """Return the motions that are asked for: one, or several in the order of their unknowns.

    Raises:
        InvalidInputError: none was found, with what was looked at; or all motions of a family meet the equations.
        NotConvergedError: a root is not proved.
    """
    found = _along_a_family(asked) if len(asked.unknown) == 1 else tori_by_newton(asked)
    return found[0] if len(found) == 1 else tuple(found)


def _along_a_family(asked: TorusQuestion) -> list[Motion]:
    (unknown,), (equation,), curves = asked.unknown, asked.equations, asked.curves
    family = asked.family
    grid = family.grid(curves)
    if unknown in asked.between:
        low, high = asked.between[unknown]
        inside = grid[(grid > low) & (grid < high)]
        grid = np.unique(np.concatenate([np.linspace(low, high, _GRID), inside]))
    seen = scanned(family, curves, equation, grid, asked.kinds)
    refined = [refined_in(asked, family, curves, bracket) for bracket in seen.brackets]
    found = [motion for motion in refined if motion is not None]
    if not found:
        raise InvalidInputError(_none(asked, unknown, seen))
    return found


def refined_in(
    asked: TorusQuestion, family: OneParameterFamily, curves: list[RadicandCurve], bracket: Bracket
) -> Motion | None:  # fmt: skip
    """Return the motion in a bracket; None where the change of sign is a jump.

    Args:
        family: with one unknown.
        curves: p² of the separated coordinates.
        bracket: where the equation changes its sign.

    Raises:
        NotConvergedError: the root is not proved.
    """
    (equation,), digits = asked.equations, asked.digits + _SPARE
    bits = bits_for(digits, 64)
    context = multiprecision(bits)
    members: dict[Mpf, tuple[Mpf, float, float]] = {}

    def value(u: Mpf) -> Mpf:
        motion = member_of(family, curves, bracket.wells, u).motion(digits, ("frequencies",))
        if not equation.weights.keys() <= motion.frequencies.keys():
            raise NotConvergedError(f"{family.unknown} = {float(u):.12g} belongs to no torus")
        members[u] = equation.exactly(motion.frequencies, bits)
        return members[u][0]

    def within(u: Mpf, f: Mpf) -> bool:
        return abs(f) <= 2 * members[u][1]

    ends = context.mpf(bracket.low), context.mpf(bracket.high)
    try:
        at_ends = value(ends[0]), value(ends[1])
        if at_ends[0] * at_ends[1] > 0:
            return None
        root = interpolated_root(value, ends, at_ends, within)
    except HJSolveError:
        return None
    residual, _, size = members[root]
    if abs(residual) > 1e3 * 10.0**-digits * size:
        return None
    member = replace(member_of(family, curves, bracket.wells, root), solution=asked.users)
    if not asked.certified:
        return member.motion(asked.digits)
    _prove(asked, (family, curves, bracket), equation, root)
    return member.motion(asked.digits, certified=True)


def _prove(
    asked: TorusQuestion, where: tuple[OneParameterFamily, list[RadicandCurve], Bracket], equation: Equation, root: Mpf
) -> None:  # fmt: skip
    """Prove a root between two certified motions: the equation has opposite signs there, and Ω is continuous."""
    family, curves, bracket = where
    bits = bits_for(asked.digits, 128)
    context = multiprecision(bits)
    low, high = context.mpf(bracket.low), context.mpf(bracket.high)
    for k in range(_WIDENINGS):
        width = context.mpf(10) ** (k + 1 - asked.digits) * max(abs(root), high - low)
        signs = []
        for u in (max(root - width, low), min(root + width, high)):
            motion = member_of(family, curves, bracket.wells, u).motion(asked.digits, ("frequencies",), certified=True)
            f, error, _ = equation.exactly(motion.frequencies, bits)
            signs.append(0 if abs(f) <= error else 1 if f > 0 else -1)
        if signs[0] * signs[1] < 0:
            return
    raise NotConvergedError(f"torus: {asked.words} could not be proved near {family.unknown} = {float(root):.12g}")


def _none(asked: TorusQuestion, unknown: str, seen: Scan) -> str:
    held = ", ".join(f"{n} = {in_words(v)}" for n, v in {**asked.held, **asked.parameters}.items())
    where = f" with {held}" if held else ""
    if seen.degenerate:
        return (
            f"torus: every motion{where} has {asked.words}, whatever {unknown} is; ask for another ratio or frequency"
        )
    if not np.isfinite(seen.first):
        return f"torus: no bounded motion was found{where}; between={{…}} says where {unknown} is looked for"
    told = _ranges(asked, seen.rates)
    return (
        f"torus: no motion with {asked.words} was found{where}, for {unknown} from {seen.first:.9g} to "
        f"{seen.last:.9g}: there {told}"
    )


def _ranges(asked: TorusQuestion, rates: Mapping[str, Reals]) -> str:
    parts = []
    for equation in asked.equations:
        names = list(equation.weights)
        if len(names) == 1:
            rate = np.abs(rates[names[0]])
            parts.append(f"Ω_{names[0]} goes from {np.min(rate):.9g} to {np.max(rate):.9g}")
            continue
        quotient = np.abs(rates[names[0]] / rates[names[1]])
        low, high = float(np.min(quotient)), float(np.max(quotient))
        near = simplest_ratios(low, high)
        simple = f"; simple ratios there are {', '.join(near)}" if near else ""
        parts.append(f"Ω_{names[0]}/Ω_{names[1]} goes from {low:.9g} to {high:.9g}{simple}")
    return " and ".join(parts)


def simplest_ratios(low: float, high: float) -> list[str]:
    """Return ratios between two numbers, those of the smallest whole numbers first, such as "3:2".

    Args:
        low, high: the ends, positive. A ratio at an end, as 2:1 of orbits through the centre, is only approached.
    """
    low, high = low * (1 + _AT_AN_END), high * (1 - _AT_AN_END)
    found: list[Fraction] = []
    for n in range(1, _GREATEST + 1):
        first = ceil(low * n)
        found += [Fraction(m, n) for m in range(first, min(floor(high * n), first + _MANY) + 1) if m > 0]
    simple = sorted(dict.fromkeys(found), key=lambda r: (r.numerator + r.denominator, r))
    return [f"{r.numerator}:{r.denominator}" for r in simple[:_MANY]]
