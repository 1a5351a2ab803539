"""A motion made from exact initial data: located, integrated, its numbers rounded; or proved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import sympy as sp

from hjsolve.arithmetic.floats import bits_for
from hjsolve.motion import quantities
from hjsolve.motion.initial_data import Initial, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, checked, coordinate_start, separated_motion
from hjsolve.one_coordinate.classify import Located, locate
from hjsolve.solution.quadratures import Solution


def started(
    solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str], *, certified: bool = False
) -> Motion:
    """Start a motion from data that were read before.

    Args:
        parts: what is integrated, from ``parts_of``.
        certified: as in ``start``.

    Raises:
        ForbiddenMotionError: no real motion has these constants.
        NotConvergedError: a turning point or an integral did not converge to the digits asked.
    """
    make = _certified if certified else _move
    return make(solution, initial, t0, max(digits, FLOAT_DIGITS), parts)


def _move(solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str]) -> Motion:
    return motion_of(separated_motion(solution, initial, t0, digits, parts))


def motion_of(found: SeparatedMotion) -> Motion:
    """Round the results of a motion taken apart.

    Args:
        found: with the integrals of its ``parts``.
    """
    solution, initial, digits, parts = found.solution, found.initial, found.digits, found.parts
    bits = bits_for(digits, 128)
    motion = Motion(
        found, _kinds(solution, found.located), found.turning_points,
        {name: quantities.rounded(to_bits(value)(bits), digits) for name, value in initial.constants.items()},
        quantities.actions(solution, initial, found.located, digits) if "action" in parts else {}, found.frequencies,
        {name: quantities.period(f) for name, f in found.frequencies.items() if f.value}, {},
    )  # fmt: skip
    if "boundary" not in motion.kinds.values() or "time" not in parts:
        return motion
    from hjsolve.motion.crossings import boundary_times

    return replace(motion, boundary_times=boundary_times(found))


def _certified(solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str]) -> Motion:
    """Make a motion of proved numbers; states come from a motion at full digits, when asked.

    The proof needs kinds and guesses, in few digits and without an integral.
    """
    from hjsolve.motion.certified import enclosed_numbers, lines, proved_libration, work_bits

    begins = {
        name: replace(coordinate_start(solution, initial, name), parts=frozenset[str]())
        for name in solution.coordinates
    }
    radicands = {name: begin.radicand for name, begin in begins.items()}
    known = lines(radicands, initial, solution, work_bits(digits))
    located = {
        name: proved_libration(begin, initial, solution, known[name]) or locate(checked(begin), FLOAT_DIGITS)
        for name, begin in begins.items()
    }
    taken_apart = SeparatedMotion(solution, initial, t0, digits, parts, located, None, {}, {})
    proved = enclosed_numbers(taken_apart, digits, known)
    return Motion(
        taken_apart, _kinds(solution, located), proved.turning_points, proved.constants, proved.actions,
        proved.frequencies, proved.periods, {}, states=_States(solution, initial, t0, digits, parts),
    )  # fmt: skip


class _States:
    """What the states of a certified motion are read from, made when it is first asked for."""

    def __init__(self, *arguments: Any):
        self.arguments = arguments
        self.motion: SeparatedMotion | None = None

    def __call__(self) -> SeparatedMotion:
        if self.motion is None:
            self.motion = separated_motion(*self.arguments)
        return self.motion

    def __reduce__(self) -> tuple[Any, ...]:
        return _States, self.arguments


def _kinds(solution: Solution, located: Mapping[str, Located]) -> dict[str, str]:
    return {
        c.name: str(located[c.name].course.kind) if c.name in located else "ignorable"
        for c in solution.system.coordinates
    }
