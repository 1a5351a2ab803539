"""The phases of a motion at given times: Jacobi's equations inverted, in doubles or in many digits.

``floats`` is t as a double array of shape (m,), where all times are finite floats, else None; ``exact`` holds rules
that give each t in any number of binary digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Counts, Elementwise, Mask, Mpf, Numbers, Reals
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.times import whole_numbers, within_doubles
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion
from hjsolve.time_law import open_motion, refine, torus
from hjsolve.time_law.elapsed_time import halves, relative, relative_exact

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion


@dataclass(frozen=True)
class Phases:
    """Phases of all separated coordinates at given times.

    Attributes:
        time: t − t₀ as two doubles, shape (m,).
        exact: t − t₀ in many digits, or None in double precision.
        χ, whole, errors: one array a coordinate, shape (m,).
        ended: True where the motion has ended before.
    """

    time: tuple[Reals, Reals]
    exact: list[Mpf] | None
    χ: Sequence[Numbers]
    whole: Sequence[Counts]
    errors: Sequence[Numbers]
    ended: Mask


def phases_at(motion: SeparatedMotion, floats: Reals | None, exact: Sequence[Callable[[int], Mpf]]) -> Phases:
    """Solve Jacobi's equations at the times t."""
    many = motion.digits > 15
    time, precise, bits = times_at(motion, floats, exact)
    # doubles first: Newton's method in many digits begins next to the phase and doubles its digits at each step
    χ, whole, errors, ended = solve_phases(motion, within_doubles(time))
    for cycles in whole:
        whole_numbers(cycles)
    # after the end of a motion phases are not asked for, but formulas run over whole arrays
    χ = [_where_it_goes_on(ended, x, c) for x, c in zip(χ, _coordinate_motions(motion), strict=True)]
    if many and precise:
        refined, errors_left = _refined_where(~ended, motion, χ, whole, precise, bits)
        return Phases(time, precise, refined, whole, errors_left, ended)
    return Phases(time, precise if many else None, χ, whole, errors, ended)


def times_at(
    motion: SeparatedMotion, floats: Reals | None, exact: Sequence[Callable[[int], Mpf]]
) -> tuple[tuple[Reals, Reals], list[Mpf], int]:
    """Return t − t₀ as two doubles, in many digits (empty where doubles are enough), and the bits of these."""
    start = to_bits(motion.t0)
    many = motion.digits > 15
    bits = bits_for(motion.digits, 96)
    if many:
        largest = max(
            (abs(float(x(64))) for x in exact),
            default=float(np.max(np.abs(floats), initial=0.0)) if floats is not None else 0.0,
        )
        # turns are taken off Ω (t − t₀): as many more bits as the turns have
        rate = max((abs(f.value) for f in motion.frequencies.values()), default=0.0)
        bits += max(0, int(np.log2(min(largest * float(rate), 1e300) + 1.0)))
    rules = exact if floats is None else [_rule(x) for x in floats] if many else []
    precise = relative_exact(rules, start, bits) if rules else []
    return relative(floats, start) if floats is not None else halves(precise), precise, bits


def solve_phases(
    motion: SeparatedMotion, time: tuple[Reals, Reals]
) -> tuple[list[Reals], list[Counts], list[Reals], Mask]:
    """Return phases, whole turns, error bounds and "has ended" at times relative to t₀ (two doubles, shape (m,)).

    Args:
        time: t − t₀ as two doubles, shape (m,).
    """
    never = np.zeros(time[0].shape, dtype=bool)
    if motion.torus is not None:
        # all coordinates bounded: quasi-periodic equations, reduced by whole turns; else at least one runs away or ends
        return *torus.torus_phases(motion.torus, time), never
    return ([], [], [], never) if motion.scheme is None else open_motion.open_phases(motion.scheme, time)


def _coordinate_motions(motion: SeparatedMotion) -> Sequence[CoordinateMotion]:
    return motion.equations.coordinate_motions if motion.equations is not None else ()


def _where_it_goes_on(ended: Mask, χ: Reals, coordinate_motion: CoordinateMotion) -> Reals:
    """Phases, and that of the start where the motion has ended: at an end itself momenta may be infinite."""
    return np.where(ended, float(coordinate_motion.start), χ) if ended.any() else χ


def _refined_where(
    going: Mask, motion: SeparatedMotion, χ: list[Reals], whole: list[Counts], precise: list[Mpf], bits: int
) -> tuple[Sequence[Numbers], Sequence[Numbers]]:
    """Return phases in many digits where the motion goes on; where it has ended there is nothing to refine."""
    # the usual case keeps its arrays; rows that have ended would only be masked out and put back
    if going.all():
        return _refined(motion, χ, whole, precise, bits)
    approximate = np.frompyfunc(multiprecision(bits).mpf, 1, 1)
    phases, errors = [approximate(x) for x in χ], [approximate(0 * x) for x in χ]
    if going.any():
        kept = [t for t, goes in zip(precise, going, strict=True) if goes]
        finer, bounds = _refined(motion, [x[going] for x in χ], [n[going] for n in whole], kept, bits)
        for k in range(len(χ)):
            phases[k][going], errors[k][going] = finer[k], bounds[k]
    return phases, errors


def _refined(
    motion: SeparatedMotion, χ: list[Reals], whole: list[Counts], precise: list[Mpf], bits: int
) -> tuple[Sequence[Numbers], Sequence[Numbers]]:
    if motion.torus is not None:
        return refine.on_torus(motion.torus, χ, whole, precise, bits)
    if motion.scheme is None:
        return χ, []
    # open equations are not periodic: the bounded coordinates among them need their turns back
    full: list[Reals] = [phase + 2 * np.pi * n for phase, n in zip(χ, whole, strict=True)]
    coordinate_motions = [c.covering(x) for c, x in zip(motion.scheme.coordinate_motions, full, strict=True)]
    found, errors = refine.unbounded(coordinate_motions, motion.scheme.equations, full, precise, bits)
    turn: Elementwise = 2 * multiprecision(bits).pi
    return [x - turn * n.astype(int) for x, n in zip(found, whole, strict=True)], errors


def coordinate_motions_of(motion: SeparatedMotion, phases: Phases) -> list[CoordinateMotion]:
    """Return the courses, reaching as far as the phases need.

    Returns:
        One course a separated coordinate, in their order.
    """
    if motion.equations is None:
        return []
    return [c.covering(x) for c, x in zip(motion.equations.coordinate_motions, phases.χ, strict=True)]


def _rule(x: float) -> Callable[[int], Mpf]:
    """Return a float as the exact number it is."""
    return lambda bits: multiprecision(bits).convert(float(x))
