"""Starts of orbits in the separated coordinates, from places and momenta (or velocities) in the user's.

The engine takes places as exact. So the place û is a double next to the true one, u, and the momenta given are those
that *the same orbit* has at û: on its torus p_k is a function of u_k alone, and p̂_k² = p_k² + F_k(û_k) − F_k(u_k). What
is not known of û becomes an error of p̂, |F′| δu/2|p|, and of the phase. Where that is too much (a start next to a
turning point), û is moved a little into the motion, and p̂² = F(û) is computed to 32 digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.charted.chart_map import ChartMap
from hjsolve.ensembles.charted.momenta_to_32_digits import exact_point, exact_starts
from hjsolve.ensembles.charted.places_and_momenta import SeparatedStarts, carried
from hjsolve.ensembles.engine.columns import Columns, blank, put
from hjsolve.ensembles.engine.engine import Engine
from hjsolve.ensembles.engine.program_parts import FINER
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import UNDECIDED, Status
from hjsolve.errors import required

_ERROR_FACTOR = 2  # times first-order bounds, for the terms of second order
_PHASE, _PART = 2.0, 16.0
"""Times the bound on dχ/du, whose S is taken from one place; the part of the natural length of u that a motion is taken
to be as wide as at least."""
_LEAST, _LARGEST_ERROR = 2.0**-49 * np.pi, 1e-9
"""What the engine counts at least for a phase (``initial_phase``: 8 ε π), and the largest error of an angle let go."""
_NEAR, _FAR = 64.0, 2.0**16
"""A start is next to a turning point where p² is less than so many times what δu does to it; then it is moved by so
many δu."""


def _none() -> Reals:
    return np.empty((0, 0))


@dataclass(frozen=True)
class ChartedStarts(Starts):
    """Starts of n orbits; ``velocity`` holds what the user gave, rows x then p or v.

    Attributes:
        chart: the map.
        off: bounds on what û is off from u, shape (coordinates, n).
        rates: bounds on dχ/du of the phases χ of the separated coordinates, shape (coordinates, n); else 0.
    """

    chart: ChartMap | None = None
    off: Reals = field(default_factory=_none)
    rates: Reals = field(default_factory=_none)

    def precise(self) -> Starts:
        """Return the same with momenta in two doubles."""
        return in_two_doubles(required(self.chart), self)


def charted_starts(chart: ChartMap, x: Reals, rates: Reals) -> ChartedStarts:
    """Carry places and momenta or velocities to the separated coordinates.

    Args:
        x, rates: in the user's coordinates, shape (coordinates, n).

    Returns:
        Starts with rows in the order of the system; NaN where the coordinates are singular or did not converge.
    """
    with np.errstate(all="ignore"):
        found = carried(chart, x, rates)
        moved, p = _moved(chart, found)
        # û was moved into the motion next to a turning point: the distance counts as an error of the place
        q, loss = found.q + moved, found.loss + np.abs(moved)
        spread, rates_of_phases = _ERROR_FACTOR * found.p_loss, np.zeros_like(q)
        for row, k in enumerate(_separated(chart)):
            slope, unitless = found.slope[row], chart.unitless[chart.order[k]]
            # δ(p²) = |F′| δu, and δp = δ(p²)/2|p|
            shift = np.abs(slope) * loss[k]
            spread[k] += np.where(shift > 0, _ERROR_FACTOR * shift / (2 * np.abs(p[k])), 0.0)
            phase = _PHASE * _phase_rate(unitless, q[k], p[k], slope, found.bend[row])
            rates_of_phases[k] = np.where(p[k] == 0, 0.0, phase)
    fine = np.isfinite(q).all(axis=0) & np.isfinite(p).all(axis=0)
    q, p = np.where(fine, q, np.nan), np.where(fine, p, np.nan)
    return ChartedStarts(
        q, p, spread, np.zeros_like(p), spread, np.concatenate([x, rates]), chart=chart, off=loss,
        rates=rates_of_phases,
    )  # fmt: skip


def run_charted(engine: Engine, chart: ChartMap, q: Mapping[str, Reals], rates: Mapping[str, Reals]) -> Columns:
    """Compute what is wanted for many orbits given in the user's coordinates.

    Args:
        engine: of the separated system.
        chart: the map to it.
        q, rates: the user's coordinate → places, and momenta or velocities, in the order of the system.

    Returns:
        Columns of shape (n,); orbits that the map is singular for, or loses too much of, are not ``OK``.
    """
    given = (np.stack(list(group.values())) for group in (q, rates))
    starts = charted_starts(chart, *given)
    known = np.flatnonzero(np.isfinite(starts.q).all(axis=0) & np.isfinite(starts.uncertainty).all(axis=0))
    columns = blank(engine.names, starts.q.shape[1])
    if not len(known):
        return columns
    part = engine.run_starts(starts.take(known))
    if "angles" in engine.want:
        _shake(chart, engine, part, starts.take(known), starts.off[:, known], starts.rates[:, known])
    put(columns, known, part)
    return columns


def _shake(chart: ChartMap, engine: Engine, columns: Columns, starts: Starts, off: Reals, rates: Reals) -> None:
    """Add to the errors of the angles what û is off; where that is too much, û − u is worked out with 32 digits first.

    The engine counts an error of ``_LEAST`` at least for every phase, so an error of an angle is at least ``_LEAST``
    times the sum of its slopes by the phases. An ignorable angle moves with its coordinate besides.
    """
    errors = np.stack([columns.error[f"angles.{name}"] for name in engine.names["angles"]])
    with np.errstate(invalid="ignore"):
        shaken = np.sum(off * rates, axis=0)
        # only where first-order bounds make too much of it û − u is worked out in two doubles
        doubtful = (errors * (1 + shaken / _LEAST)).max(axis=0) > _LARGEST_ERROR
        again = np.flatnonzero(doubtful & (columns.status == Status.OK))
        if len(again):
            q, given, n = starts.q[:, again], required(starts.velocity)[:, again], len(off)
            exact = exact_point(chart, q, given[:n], given[n:])
            near = np.stack([np.abs((u.high - row) + u.low) for u, row in zip(exact, q, strict=True)])
            shaken[again] = np.sum(near * rates[:, again], axis=0)
        errors *= 1 + shaken / _LEAST
        for name, error in zip(engine.names["angles"], errors, strict=True):
            moved = off[chart.model.names.index(name)] if name in chart.model.angles else 0.0
            columns.error[f"angles.{name}"][:] = error + moved
        columns.status[(columns.status == Status.OK) & ~(errors.max(axis=0) <= _LARGEST_ERROR)] = UNDECIDED


def _separated(chart: ChartMap) -> list[int]:
    return [c.index for c in chart.model.separated]


def _moved(chart: ChartMap, found: SeparatedStarts) -> tuple[Reals, Reals]:
    """Return how far û is moved into the motion, and the momenta there."""
    moved, p = np.zeros_like(found.q), found.p.copy()
    for row, k in enumerate(_separated(chart)):
        slope, step = found.slope[row], np.maximum(found.loss[k], np.spacing(np.abs(found.q[k])))
        resting = (p[k] == 0) & (found.p_loss[k] == 0) & (slope == 0)
        # p² is hardly more than what δu does to it: û goes on into the motion, and p̂² = p² + F′ (û − u)
        near = (p[k] ** 2 < _NEAR * np.abs(slope) * step) & ~resting
        moved[k] = np.where(near, _FAR * np.sign(slope) * step, 0.0)
        p[k] = np.where(near, np.where(p[k] < 0, -1.0, 1.0) * np.sqrt(p[k] ** 2 + slope * moved[k]), p[k])
    return moved, p


def _phase_rate(unitless: bool, u: Reals, p: Reals, slope: Reals, bend: Reals) -> Reals:
    """Return a bound on dχ/du of the phase χ of a coordinate, but for ``_PHASE``.

    It is √S/|p| with p² = (u − a)(b − u) S, where S is about |F″|/2; where that is small, F′ over the width b − a,
    which is larger than p²/F′ and taken to be no less than a part of the natural length of u. It is 1 for a rotation.
    """
    size, length = np.abs(p), (1.0 if unitless else np.abs(u)) / _PART
    middle, end = np.sqrt(np.abs(bend) / 2) / size, np.abs(slope) / (2 * size**2)
    end = np.where(slope != 0, np.minimum(end, np.sqrt(np.abs(slope) / length) / size), 0.0)
    return middle + end + (1.0 if unitless else 0.0)


def in_two_doubles(chart: ChartMap, starts: Starts) -> Starts:
    """Return starts with momenta at û to 32 digits, the constants being those of the exact initial data."""
    velocity = required(starts.velocity)
    q, n = starts.q, len(starts.q)
    with np.errstate(all="ignore"):
        exact = exact_starts(chart, q, velocity[:n], velocity[n:])
        high, low, lost = exact.high.copy(), exact.low.copy(), exact.lost
        spread = _ERROR_FACTOR * lost
        for row, k in enumerate(_separated(chart)):
            still = (high[k] == 0) & (low[k] == 0) & (lost[k] == 0) & (starts.p[k] == 0)
            sign = np.where(high[k] < 0, -1.0, 1.0)
            root = exact.roots[row]
            spread[k] = np.where(still, 0.0, _ERROR_FACTOR * exact.uncertainties[row] / (2 * root))
            high[k], low[k] = np.where(still, 0.0, sign * root), np.where(still, 0.0, sign * exact.roots_low[row])
        uncertainty = np.abs(low) + FINER * spread
        known = np.isfinite(uncertainty) & np.isfinite(high) & np.isfinite(low)
        uncertainty, spread = np.where(known, uncertainty, np.inf), np.where(known, spread, np.inf)
        high, low = np.where(known, high, starts.p), np.where(known, low, 0.0)
    return replace(starts, p=high, low=low, spread=spread, uncertainty=uncertainty)
