"""The time at which one of two coupled coordinates has a phase, without following the motion.

Jacobi's equation for the second constant, Σᵢ Gᵢ₂(χᵢ) = C₂, gives the other phase where one is known, and the equation
of the energy then gives the time (Greenwood (5-70), (5-71)).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Generic

import numpy as np

from hjsolve.arithmetic.floats import UNIT, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, X
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.errors import OutsideMotionError
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion

_TREND, _STEEP, _MOST_DOUBLINGS = 24, 5, 400
"""Doublings whose gains tell that an integral converges; fewer, where all 400 that there may be would not add what is
left: 2⁴⁰⁰ steps are phases of 1e120."""


def coupled_crossing_time(motion: SeparatedMotion, k: int, target: Mpf) -> tuple[Elementwise, Elementwise] | None:
    """Return the time from t₀ until one of two coupled coordinates has a phase, and a bound on its error.

    Args:
        k: index of the coordinate.
        target: its phase.

    Returns:
        None where this way is not open: other than two coordinates, or an integral that is not monotone.

    Raises:
        OutsideMotionError: the other coordinate ends, or runs away, before.
    """
    scheme = motion.scheme
    if scheme is None or len(scheme.coordinate_motions) != 2:
        return None
    own, other = scheme.coordinate_motions[k], scheme.coordinate_motions[1 - k]
    kind = object if motion.digits > 15 else float
    noise = 2.0**-50 if kind is float else multiprecision(64).mpf(10) ** (1 - motion.digits)
    convert = float if kind is float else multiprecision(bits_for(motion.digits, 64)).convert
    ends: list[Elementwise] = [convert(target), convert(own.start), convert(other.start)]
    phase, begin, start = ends
    here = _Values(own, kind, max(abs(phase), abs(begin)))
    # towards a fall integrals converge: where they still grow, the phase is not that of the place
    if _falling(own) and any(abs(here.rate(j, phase)) > noise * abs(here.integral(j, phase)) for j in (0, 1)):
        return None
    # Jacobi's second equation G₁ of one + G₁ of the other = const gives the other phase, the first one then the time
    goal = here.integral(1, begin) - here.integral(1, phase)
    found = _solved(other, kind, start, goal, 1 if phase >= begin else -1, noise)
    if found is None:
        return None
    there, χ = found
    parts = [here.integral(0, phase), here.integral(0, begin), there.integral(0, χ), there.integral(0, start)]
    second = [here.size(1, phase), here.size(1, begin), there.size(1, χ), there.size(1, start)]
    time = parts[0] - parts[1] + parts[2] - parts[3]
    sizes = [here.size(0, phase), here.size(0, begin), there.size(0, χ), there.size(0, start)]
    # at a turning point both rates vanish; their ratio has a limit, seen a little before
    inside = χ if there.rate(1, χ) else χ - (χ - start) * 2.0**-20
    # what is not known of the second equation moves the phase, and the time by the ratio of both rates
    slide = abs(there.rate(0, inside) / there.rate(1, inside)) * sum(second)
    return time, 4 * noise * (sum(sizes) + slide + abs(there.rate(0, χ)) * (1 + abs(χ)))


def _falling(coordinate_motion: CoordinateMotion) -> bool:
    return "fall" in (coordinate_motion.ends(1), coordinate_motion.ends(-1))


class _Values(Generic[X]):
    """Integrals of a course at single phases up to a largest one."""

    def __init__(self, coordinate_motion: CoordinateMotion, kind: type, largest: X):
        self.coordinate_motion, self.kind = coordinate_motion.with_reach(abs(float(largest))), kind

    def integral(self, j: int, χ: X) -> X:
        return np.ravel(self.coordinate_motion.integral(j, np.array([χ], dtype=self.kind)))[0]

    def size(self, j: int, χ: X) -> float:
        """Return what the rounding of an integral, and of its phase, refers to."""
        near: Numbers = np.array([χ], dtype=self.kind)
        return float(self.coordinate_motion.spacing(j, near)[0]) + abs(float(self.rate(j, χ)) * float(χ))

    def rate(self, j: int, χ: X) -> X:
        return np.ravel(self.coordinate_motion.rate(j, np.array([χ], dtype=self.kind)))[0]


def _solved(
    coordinate_motion: CoordinateMotion, kind: type, start: X, goal: X, side: int, noise: float | Mpf
) -> tuple[_Values[X], X] | None:
    """Return the phase at which the second integral has grown by ``goal``, on one side of the start.

    None if not monotone.
    """
    # steps are doubled until the gain is beyond the goal, or is seen never to come there
    reach, step, gains = abs(start) + 1, start * 0 + 1, [start * 0]
    while True:
        values = _Values(coordinate_motion, kind, reach + step)
        floor, ceiling = values.coordinate_motion.limits()
        last = start + side * step
        ended = not floor <= last <= ceiling
        last = last if not ended else (ceiling if side > 0 else floor) + 0 * start
        if not _monotone(values, start, last):
            return None
        gains.append(values.integral(1, last) - values.integral(1, start))
        if abs(gains[-1]) >= abs(goal):
            break
        if ended and abs(goal) - abs(gains[-1]) <= 4 * noise * (abs(goal) + abs(values.integral(1, start))):
            return values, last  # both come to their ends at once
        # gains that shrink to 0.7 of the one before at each doubling have 7/3 of the last one left: 8 is more than that
        recent = [abs(b - a) for a, b in itertools.pairwise(gains[-_TREND - 1 :])]
        left = abs(goal) - abs(gains[-1])
        never = len(gains) > _TREND and _fading(recent) and left > 8 * recent[-1]
        # or a fall so steep that all doublings there can be would not do
        never |= len(gains) > _STEEP and _fading(recent[-4:]) and left > _MOST_DOUBLINGS * recent[-1]
        if ended or len(gains) > _MOST_DOUBLINGS or never:
            raise OutsideMotionError("the place is not reached in any finite time")
        step = 2 * step
    if gains[-1] * goal < 0:
        return None
    first = values.integral(1, start)
    low, high = (start, last) if side > 0 else (last, start)

    def off(χ: X) -> X:
        return values.integral(1, χ) - first - goal

    # from values alone: the rate may be zero at an end
    χ = interpolated_root(off, (low, high), (off(low), off(high)), width=UNIT if kind is float else noise * 2.0**-16)
    return values, χ


def _fading(gains: Sequence[X]) -> bool:
    return all(b <= 0.7 * a for a, b in itertools.pairwise(gains))


def _monotone(values: _Values[X], first: X, last: X) -> bool:
    """Return True where the second integral is.

    At the end of a domain its rate may vanish, next to a pole be all rounding.
    """
    rates = [values.rate(1, first + (last - first) * k / 16) for k in range(16)]
    noise = values.coordinate_motion.rate_noise(1) if values.kind is float else 0.0
    return all(r > -noise for r in rates) or all(r < noise for r in rates)
