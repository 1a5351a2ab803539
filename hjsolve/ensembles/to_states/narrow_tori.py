"""Librations about a maximum of p² that are so narrow that constants in two doubles do not know their height.

Next to its maximum p² is the small difference h = max F(q; c) of large terms, and J = h/(2 √(−½F″)) + O(h²): of a
motion with J below 1e-17 of the other actions, c to 32 digits leaves J no more than 14. But nothing else depends on
the digits that c lacks. So h is an unknown of its own: the harmonic libration gives it, the integral J(h) of the engine
corrects it, and the motion is seen from its maximum, F(q₀ + x) = P₀² + x (F′₀ + x F[q₀, q₀, q₀ + x]), as in
``engine.programs_of_small_motions``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair, two_sum
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset_in_pairs
from hjsolve.ensembles.engine.librating import seen_from_start
from hjsolve.ensembles.engine.lowered_solution import Separated
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.engine.programs_of_small_motions import SMALL_KNOWN, has_slopes
from hjsolve.ensembles.to_states.tori import ALONE, AngleTask, Tori, coordinate_at, summits

_UNKNOWN = 1e-22
"""What 32 digits of the constants leave open of J, over J, above which a motion is seen from its maximum: below 1e-8
of the other actions. There p² in two doubles next to the turning points has its last digits in doubt."""
_FOUND, _CLAIMED = 1e-14, 1e-10
"""What J is off by, relatively, where h is found, and the largest error that the engine may claim of it."""
_START, _SLOPE, _UNCERTAIN, _WIDTH = 0, 2, 3, 4
"""Rows of what programs of small motions know: q₀, F′₀, a bound on second differences, W; the second is P₀²."""
_ROUNDED = 16 * EPS
"""Roundings of p² seen from a turning point."""
ROWS = SMALL_KNOWN + 2
"""Of a narrow libration: what programs know, and both turning points as offsets from q₀."""


class Narrow(NamedTuple):
    """Narrow librations among n tori.

    Attributes:
        rows: what is known of them, shape (separated, ``ROWS``, n); NaN of all other motions.
        errors: what J may be off by; shape (separated, n).
    """

    rows: Reals
    errors: Reals


def narrow_librations(task: AngleTask, tori: Tori, J: Reals, unknown: Reals, among: Mask) -> Narrow:
    """Find the narrow librations that have given actions.

    Args:
        tori: n of them, with places next to the maxima of p².
        J: actions, shape (separated, n).
        unknown: what the digits of the constants leave open of J, the same shape.
        among: which motions librate, the same shape.
    """
    size, n = J.shape
    found = Narrow(np.full((size, ROWS, n), np.nan), np.full((size, n), np.nan))
    for k, coordinate in enumerate(task.model.separated):
        some = np.flatnonzero(among[k] & (unknown[k] > _UNKNOWN * J[k]) & (J[k] > 0))
        if not len(some) or not has_slopes(coordinate.plain):
            continue
        rows, error = _about_maximum(coordinate_at(*task, tori.take(some), k), J[k, some])
        fine = np.isfinite(error)
        found.rows[k][:, some[fine]], found.errors[k, some[fine]] = rows[:, fine], error[fine]
    return found


def _about_maximum(one: CoordinateOfOrbits, J: Reals) -> tuple[Reals, Reals]:
    """Return rows of ``Narrow`` of one coordinate, and errors of J."""
    q, bend = summits(one, one.q)
    (slope,) = run_rows(one.programs.small.slope, one.parameters, np.stack([q, *one.constants, *one.low]))
    with np.errstate(all="ignore"):
        root = np.sqrt(-0.5 * bend)
        # q is a double, and h of the maximum next to it: F′² there is what is missing
        square = 2 * root * J - 0.25 * (slope / root) ** 2
        for _ in range(2):
            sums, known, ends = seen_from_start(replace(one, q=q, P=np.sqrt(square), rest=None), ALONE)
            rows = np.concatenate([known[-SMALL_KNOWN:], ends])
            square = square + 2 * root * (J - sums.action)
        off = np.abs(J - sums.action)
        fine = sums.good & (off <= _FOUND * J) & (sums.action_error <= _CLAIMED * J) & np.isfinite(rows).all(axis=0)
    return rows, np.where(fine, sums.action_error + off, np.nan)


def narrow_ones(rows: Reals) -> Mask:
    """Tell which motions are narrow librations, from rows of ``Narrow``."""
    return np.asarray(np.isfinite(rows[:, _WIDTH]))


def turning_points(coordinate: Separated, rows: Reals) -> tuple[Reals, Reals]:
    """Return turning points as ``Frames`` have them, and widths.

    Args:
        rows: of one coordinate, shape (``ROWS``, n).
    """
    D, bases = DoubleDouble(), []
    for formula, x in zip(sides(coordinate), rows[SMALL_KNOWN:], strict=True):
        end = D.add(offset_in_pairs(formula, rows[_START]), Pair(formula.sign * x, 0.0 * x))
        bases += [end.high, end.low]
    return np.stack(bases), rows[_WIDTH]


def narrow_at(
    one: CoordinateOfOrbits, rows: Reals, sine: Reals, cosine: Reals, linear: float
) -> tuple[Pair, tuple[Reals, Reals, Reals, Reals]]:
    """Return places with p², ∂p²/∂q, what is not known of p², and the kernels over p.

    Args:
        rows: of ``Narrow``, shape (``ROWS``, n).
        sine, cosine: of φ/2.
        linear: distance from a turning point, over W, below which p² is linear.
    """
    known, ends, W, programs = rows[:SMALL_KNOWN], rows[SMALL_KNOWN:], rows[_WIDTH], one.programs.small
    lower = np.abs(sine) <= np.abs(cosine)
    b, d = np.where(lower, *ends), W * np.where(lower, sine**2, -(cosine**2))
    seen, none = np.copysign(np.fmax(np.abs(d), linear * W), d), 0.0 * d
    given = np.stack([seen, b + seen, none + 1.0, b, *one.constants, *known])
    _, r, F, *weights = run_rows(programs.fill, one.parameters, given)
    square = np.where(seen == d, F, F * (d / seen))
    bend = run_rows(programs.bounds, one.parameters, np.stack([known[_START], *one.constants, *one.uncertainty]))[0]
    # F = d (d t₁ − W t₂), t second differences, and half of W at least is left of W − d
    noise = (_ROUNDED + 3 * known[_UNCERTAIN] / np.abs(bend)) * square
    place = two_sum(known[_START], b + d)
    return place, (square, known[_SLOPE] + 2 * bend * (b + d), noise, np.stack(weights) / r)
