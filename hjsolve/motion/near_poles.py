"""Velocities next to a pole of the coordinates, where a place rounded to doubles has lost what they depend on.

φ̇ = (p_φ − p_ψ cos θ)/(I sin² θ) at θ = 10⁻⁷: the distance from the pole, the difference of the momenta and their
cosines cancel. The distance of a coordinate from its nearer turning point is known with its relative accuracy, and the
turning point to any precision: their sum in two doubles is worked out in two doubles (``arithmetic/double_double``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, split
from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.number_types import Mask, N, Numbers, Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError
from hjsolve.arithmetic.running_error import WithErrorBound as Rounded
from hjsolve.arithmetic.tape import Arithmetic
from hjsolve.mechanics.system import velocities
from hjsolve.motion.formulas_at_places import bounded_at, tape_of
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.positions import known_along
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion

_LOST = 16 * UNIT
"""What the rounding of a place may do to a velocity, relative to it, before it is worked out in two doubles."""
_IN_TWO_DOUBLES = 2.0**-47
"""What operations in two doubles lose, in units of what they would lose in doubles (``arithmetic/double_double``)."""
Places = Mapping[str, Pair]


def badly_rounded(motion: SeparatedMotion, q: Mapping[str, Numbers], p: Mapping[str, Numbers]) -> Mask:
    """Return where some velocity in doubles is far from rounded well, because of the rounding of places and constants.

    Returns:
        Array of bools, shape (m,).
    """
    formulas = tuple(velocities(motion.solution.system).values())
    varies, fixed = known_along(motion, q, p)
    arrays, tape = list(varies.values()), tape_of(formulas, (*varies, *fixed))
    # what one rounding of each place does to a velocity; momenta are counted elsewhere
    errors = [UNIT * np.abs(x) if k < len(arrays) - len(p) else None for k, x in enumerate(arrays)]
    found = bounded_at(tape, arrays, errors, list(fixed.values()))
    return np.any([error > SECOND_ORDER * _LOST * np.abs(value) for value, error in found], axis=0)


def roundings(motion: SeparatedMotion, coordinate_motion: CoordinateMotion) -> bool:
    """Return whether a motion with one separated coordinate comes to places where its velocities are blurred."""
    system, name = motion.solution.system, motion.solution.coordinates[0]
    # places of half a turn show whether the motion comes next to a pole at all: it is nearest at a turning point
    χ = np.linspace(0, np.pi, 65) if coordinate_motion.cycle else np.linspace(-1, 1, 65)
    q, p = {}, {}
    q[name], p[name] = coordinate_motion.place(χ)
    for c in system.coordinates:
        if c.name != name:
            exact = (motion.initial.values[s] for s in (c.symbol, c.momentum))
            q[c.name], p[c.name] = (float(to_bits(value)(64)) + 0 * χ for value in exact)
    return bool(badly_rounded(motion, q, p).any())


def places(
    motion: SeparatedMotion, coordinate_motions: list[CoordinateMotion], χ: list[Reals]
) -> tuple[dict[str, Pair], dict[str, Numbers]]:
    """Separated coordinates in two doubles, and their shell momenta, at phases in doubles.

    Args:
        motion: the one looked at.
        χ: phases in doubles, one array a coordinate, shape (m,).
    """
    q, shell = {}, {}
    for name, coordinate_motion, phase in zip(motion.solution.coordinates, coordinate_motions, χ, strict=True):
        approximate, shell[name] = coordinate_motion.place(phase)
        # from the phase: q in doubles is what has lost the digits
        q[name] = coordinate_motion.place_in_two_doubles(phase, approximate.astype(float))
    return q, shell


def sharpened_velocities(
    motion: SeparatedMotion,
    coordinate_motions: list[CoordinateMotion],
    χ: list[Reals],
    q: Mapping[str, Numbers],
    v: Mapping[str, Numbers],
    where: Mask,
) -> dict[str, Numbers]:
    """Velocities, those of some times worked out in two doubles.

    Args:
        χ: their phases in doubles.
        q, v: coordinates and velocities in doubles, shape (m,).
        where: which of them to work out anew, shape (m,).
    """
    exact, shell = places(motion, coordinate_motions, [x[where] for x in χ])
    return velocities_from_pairs(motion, exact, shell, q, v, where)


def velocities_from_pairs(
    motion: SeparatedMotion,
    exact: Places,
    shell: Mapping[str, Numbers],
    q: Mapping[str, Numbers],
    v: Mapping[str, Numbers],
    where: Mask,
) -> dict[str, Numbers]:
    """As ``sharpened_velocities``, from separated coordinates in two doubles.

    Args:
        exact: its separated coordinates in two doubles, at the times chosen.
        shell: their shell momenta there.
        q, v: coordinates and velocities in doubles at all times, shape (m,).
        where: which of these times are chosen, shape (m,).
    """
    # ignorable coordinates do not occur in H, or only in the gauge of a shift: doubles serve
    rest = {name: values[where] for name, values in q.items() if name not in exact}
    chosen = {name: f for name, f in velocities(motion.solution.system).items() if name in v}
    result: dict[str, Numbers] = {name: values.copy() for name, values in v.items()}
    for name, values in zip(chosen, worked_out(motion, tuple(chosen.values()), exact, shell, rest), strict=True):
        result[name][where] = values
    return result


def worked_out(
    motion: SeparatedMotion,
    formulas: tuple[sp.Expr, ...],
    q: Places,
    shell: Mapping[str, Numbers],
    ignorable: Mapping[str, Numbers],
) -> list[Reals]:
    """Return formulas in coordinates and momenta in two doubles, rounded once.

    Args:
        formulas: what to work out.

    Returns:
        One array a formula, of the shape of the places.
    """
    pairs, p, shape = _in_two_doubles(motion, q, shell, ignorable)
    found = _run(motion, formulas, pairs, p, DoubleDouble(), _constant)
    return [np.broadcast_to(v.high, shape) for v in found]


def lost_in_two_doubles(
    motion: SeparatedMotion,
    formulas: tuple[sp.Expr, ...],
    q: Places,
    shell: Mapping[str, Numbers],
    ignorable: Mapping[str, Numbers],
) -> list[Reals]:
    """Bounds on what ``worked_out`` loses before its last rounding: terms may cancel to less than two doubles know.

    Places count as exact: what they leave open is the same in all terms, and counted by the slopes of the whole.

    Returns:
        One array a formula, of the shape of the places.
    """
    pairs, p, shape = _in_two_doubles(motion, q, shell, ignorable)
    # the rule counts roundings of 2⁻⁵³, as if of doubles; those of two doubles are so many times smaller
    places = {name: Rounded(x) for name, x in pairs.items()}
    momenta = {name: Rounded(x, _rounding(x)) for name, x in p.items()}
    found = _run(motion, formulas, places, momenta, RunningError(DoubleDouble()), _rounded_constant)
    none = Pair(0.0, 0.0)
    return [np.broadcast_to(np.abs((v.error or none).high) * _IN_TWO_DOUBLES, shape) for v in found]


def _rounding(x: Pair) -> Pair:
    return Pair(UNIT * np.abs(x.high), 0 * x.high)


def _in_two_doubles(
    motion: SeparatedMotion, q: Places, shell: Mapping[str, Numbers], ignorable: Mapping[str, Numbers]
) -> tuple[dict[str, Pair], dict[str, Pair], tuple[int, ...]]:
    """Coordinates and momenta, and the shape of the places."""
    solution = motion.solution
    pairs = {**q, **{name: Pair(x, 0 * x) for name, x in ignorable.items()}}
    some = next(iter(pairs.values())).high
    p: dict[str, Pair] = {}
    for c in solution.system.coordinates:
        if c.name in shell:
            # the shell momentum comes from p², which is known relatively; the shift is taken in two doubles
            p[c.name] = Pair(shell[c.name], 0 * shell[c.name])
            if solution.shift[c.name] != 0:
                moved = _run(motion, (solution.shift[c.name],), pairs, {}, DoubleDouble(), _constant)[0]
                p[c.name] = DoubleDouble().sub(p[c.name], moved)
        else:
            constant = _constant(motion.initial.values[c.momentum])
            p[c.name] = Pair(constant.high + 0 * some, constant.low + 0 * some)
    return pairs, p, some.shape


def _run(
    motion: SeparatedMotion,
    formulas: tuple[sp.Expr, ...],
    q: Mapping[str, N],
    p: Mapping[str, N],
    arithmetic: Arithmetic[N],
    constant: Callable[[sp.Expr], N],
) -> list[N]:
    """Return formulas in an arithmetic, their constants brought into it by a rule."""
    varies, fixed = known_along(motion, q, p)
    constants = [constant(value) for value in fixed.values()]
    with np.errstate(all="ignore"):
        return tape_of(formulas, (*varies, *fixed)).run(arithmetic, [*varies.values(), *constants])


def _rounded_constant(value: sp.Expr) -> Rounded[Pair]:
    exact = _constant(value)
    return Rounded(exact, _rounding(exact))


@lru_cache(maxsize=256)
def _constant(value: sp.Expr) -> Pair:
    return split(to_bits(value)(160))
