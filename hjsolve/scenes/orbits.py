"""The orbit equation of a scene: one coordinate at given places of another, without the time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.number_types import Numbers
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.scenes.question import OrbitAsked

_PLACES = 33


@dataclass(frozen=True, eq=False, repr=False)
class OrbitTable(Shown):
    """An orbit equation as numbers, of the whole orbit that an arc is part of.

    Attributes:
        of, along: the coordinates.
        places: of ``along``, shape (m,).
        values: of ``of`` at its first passage of each place, shape (m,).
    """

    of: str
    along: str
    places: Numbers
    values: Numbers


def orbit_table(asked: OrbitAsked | None, motion: Motion) -> OrbitTable:
    """Work out the orbit equation.

    Args:
        asked: which; None for the first separated coordinate that turns or goes round, and the first other one.
        motion: with all that ``orbit`` needs.

    Raises:
        InvalidInputError: nothing was asked and the motion offers no such pair.
        OutsideMotionError: a place that the motion never reaches.
    """
    if asked is None:
        asked = _chosen(motion)
    places = list(asked.values) or _places(motion, asked.along)
    return OrbitTable(asked.of, asked.along, np.array(places), motion.orbit(asked.of, along=asked.along, values=places))


def _chosen(motion: Motion) -> OrbitAsked:
    names = [c.name for c in motion.solution.system.coordinates]
    along = next((n for n in motion.separated.located if motion.kinds[n] in ("libration", "rotation")), None)
    of = next((n for n in names if n != along), None)
    if along is None or of is None:
        raise InvalidInputError(
            'orbit: say which, e.g. [orbit] of = "theta", along = "r", values = [1, 2]; no coordinate here comes back'
        )
    return OrbitAsked(of, along)


def _places(motion: Motion, along: str) -> list[float]:
    """Return places inside the region, closer together towards its ends."""
    angles = np.pi * (np.arange(_PLACES) + 0.5) / _PLACES
    if motion.kinds[along] == "rotation":
        start = float(to_bits(motion.initial.values[motion.solution.system.coordinate(along).symbol])(64))
        direction = 1 if float(motion.frequencies[along].value) > 0 else -1
        return [float(x) for x in start + direction * 2 * angles]
    ends = motion.turning_points.get(along)
    if ends is None or ends[0] is None or ends[1] is None:
        raise InvalidInputError(f"orbit: {along} does not turn on both sides; give orbit.values")
    low, high = float(ends[0].value), float(ends[1].value)
    return [float(x) for x in (low + high) / 2 - (high - low) / 2 * np.cos(angles)]
