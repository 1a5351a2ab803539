"""Turning points before barriers that the search outward stepped over.

The search (``kernels.outward_search``) goes by F, F′ and F″ at its last trial, which know nothing of a bump further on.
Nodes on a bump see F < 0 and refuse the motion. Then F is looked at between the start and what the search found, and
the first change of sign is the turning point. What is narrower than these trials stays refused.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.writer import MachineCode
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.arithmetic.root_finding import bracketed_roots
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset
from hjsolve.ensembles.engine.programs import sides

_TRIALS = np.linspace(0.0, 1.0, 65)
"""Where a barrier is looked for between the start and a turning point, as fractions of the distance."""


def before_barriers(one: CoordinateOfOrbits, places: Reals) -> tuple[Integers, Reals]:
    """Find turning points nearer than those found, where p² < 0 between.

    Args:
        one: the coordinate of n orbits.
        places: the turning points found, offsets in the views of the lower and of the upper half, shape (2, n).

    Returns:
        Which of the orbits have nearer ones, and both turning points of these.
    """
    places, moved = places.copy(), np.zeros(len(one.q), dtype=bool)
    everything = np.arange(len(one.q))
    for upper, view in enumerate(one.programs.views if len(one.q) else ()):
        start = offset(sides(one.coordinate)[upper], one.q)
        trials = start[:, None] + (places[upper] - start)[:, None] * _TRIALS
        with np.errstate(all="ignore"):
            seen, _ = _squares(one, view.slopes, trials.ravel(), np.repeat(everything, len(_TRIALS)))
            # not at the ends: start and turning point have F ≥ 0 but for rounding
            negative = seen.reshape(trials.shape)[:, 1:-1] < 0
            behind = np.flatnonzero(negative.any(axis=1))
            if not len(behind):
                continue
            # the first one from the start: what lies beyond it is another well
            first = np.argmax(negative[behind], axis=1) + 1
            bracket = trials[behind, first - 1], trials[behind, first]
            places[upper, behind] = _sign_change(one, view.slopes, bracket, behind)
        moved[behind] = True
    return np.flatnonzero(moved), places[:, moved]


def _sign_change(one: CoordinateOfOrbits, code: MachineCode, bracket: tuple[Reals, Reals], orbits: Integers) -> Reals:
    """Return where F of some of the orbits falls through zero, between an inner and an outer offset of each."""
    inner, width, n = bracket[0], bracket[1] - bracket[0], len(orbits)

    def rising(t: Reals) -> tuple[Reals, Reals]:  # −F at a fraction of the way out
        F, slope = _squares(one, code, inner + width * t, orbits)
        return -F, -width * slope

    t, _, _ = bracketed_roots(rising, np.full(n, 0.5), np.zeros(n), np.ones(n))
    return inner + width * t


def _squares(one: CoordinateOfOrbits, code: MachineCode, x: Reals, orbits: Integers) -> tuple[Reals, Reals]:
    """Return F and its slope at offsets of some of the orbits."""
    F, slope, *_ = run_rows(code, one.parameters, np.stack([x, *one.constants[:, orbits]]))
    return F, slope
