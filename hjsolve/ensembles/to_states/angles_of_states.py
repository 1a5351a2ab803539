"""Angles of n states on tori by the engine, and how they change with the phases of the coordinates.

θₖ = Σⱼ (∂J/∂c)⁻¹ₖⱼ Σᵢ Gᵢⱼ (Goldstein, 3rd ed., §10.6), Gᵢⱼ = ∫ kᵢⱼ/pᵢ dqᵢ, and with the phases φ of ``places_on_tori``

    ∂θₖ/∂φᵢ = Σⱼ (∂J/∂c)⁻¹ₖⱼ kᵢⱼ/pᵢ dqᵢ/dφᵢ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.actions_and_angles import combine_integrals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, place
from hjsolve.ensembles.engine.kernels.types import Modes, Sums, no_sums
from hjsolve.ensembles.engine.librating import Kept
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.places_on_tori import Frames, Placed
from hjsolve.ensembles.to_states.short_arcs import Integrals
from hjsolve.ensembles.to_states.tori import APPROXIMATE, EXACT, AngleTask, Tori, coordinate_at

_KEPT = Kept(np.inf, 5e-13)
"""Relative errors of ∂J/∂c up to which p² in doubles does for angles; J is not looked at."""
_MARGIN = 1e-6
"""By what part of its width a place may lie beyond a turning point: the maximum of p² of a narrow motion is rounded."""
_TIMED = Modes(chords=False, kernels=True, oscillations=True, shifts=False)


class AnglesFound(NamedTuple):
    """Angles of n states.

    Attributes:
        separated, errors: θ of the separated coordinates in the sense of their rotation, and bounds; (separated, n).
        ignorable, ignorable_errors: of the ignorable ones that are angles, where these are at 0; (angles, n).
        inverse: (∂J/∂c)⁻¹, shape (n, separated, separated).
        integrals: of the engine, ∂J/∂c and the running ones.
        good: which are known.
    """

    separated: Reals
    errors: Reals
    ignorable: Reals
    ignorable_errors: Reals
    inverse: Reals
    integrals: Integrals
    good: Mask

    def take(self, index: Integers) -> AnglesFound:
        """Return those of some states."""
        integrals = Integrals._make(x[..., index] for x in self.integrals)
        return AnglesFound(
            self.separated[:, index], self.errors[:, index], self.ignorable[:, index], self.ignorable_errors[:, index],
            self.inverse[index], integrals, self.good[index],
        )  # fmt: skip

    def put(self, index: Integers, other: AnglesFound, which: Mask) -> None:
        """Write some of others into these.

        Args:
            index: their places here.
            other: the others.
            which: which of them.
        """
        for mine, theirs in zip(self._flat(), other._flat(), strict=True):
            mine[..., index] = theirs[..., which]

    def _flat(self) -> tuple[Reals | Mask, ...]:
        """Return views of all arrays whose last axis is that of the orbits."""
        separated, errors, ignorable, ignorable_errors, inverse, integrals, good = self
        return separated, errors, ignorable, ignorable_errors, inverse.transpose(1, 2, 0), *integrals, good


def angles_at(task: AngleTask, tori: Tori, frames: Frames, at: Placed, how: int) -> AnglesFound:
    """Return the angles of states on tori, by the engine.

    Args:
        frames: between what they move.
        how: ``APPROXIMATE``, ``DOUBLES`` or ``EXACT``.
    """
    model, (size, n) = task.model, at.q.shape
    modes = _TIMED._replace(approximate=how == APPROXIMATE)
    sums, good = [], np.ones(n, dtype=bool)
    for k in range(size):
        one = coordinate_at(*task, tori._replace(q=at.q), k, at.P[k], at.rest[k])
        total = no_sums(len(model.constants), n)
        moving = np.flatnonzero(~frames.resting[k])
        if len(moving):
            some = one.take(moving)
            part, seen, _ = integrated(some, modes, exact=how == EXACT, places=False, kept=_KEPT)
            total.put(moving, part)
            good[moving] &= _around(some, seen.offsets, tori.q[k, moving])
        still = np.flatnonzero(frames.resting[k])
        if len(still):
            total.put(still, _resting_sums(one.take(still), at.rates[k][:, still]))
        good &= total.good
        sums.append(total)
    q = np.zeros((len(model.names), n))
    for k, coordinate in enumerate(model.separated):
        q[coordinate.index] = at.q[k]
    torus = combine_integrals(model, sums, frames.directions, q, angles=True)
    means = np.stack([s.means for s in sums])
    with np.errstate(all="ignore"):
        inverse = np.full((n, size, size), np.nan)
        matrix = means[:, :size].transpose(2, 1, 0)
        fine = (
            good & np.isfinite(matrix).all(axis=(1, 2)) & (np.linalg.det(np.where(np.isfinite(matrix), matrix, 0)) != 0)
        )
        inverse[fine] = np.linalg.inv(matrix[fine])
    rows = [torus.angles[c.name] for c in model.separated]
    others = [torus.angles[name] for name in model.angles]
    empty = np.zeros((0, n))
    separated = np.stack([row[0] for row in rows]) * frames.directions
    good = fine & np.isfinite(separated).all(axis=0)
    return AnglesFound(
        separated, np.stack([row[1] for row in rows]), np.stack([x for x, _ in others]) if others else empty,
        np.stack([e for _, e in others]) if others else empty, inverse, _integrals(sums), good,
    )  # fmt: skip


def _around(one: CoordinateOfOrbits, ends: Reals, places: Reals) -> Mask:
    """Return whether places lie between the turning points of states, as far as these are known: in the same well.

    Args:
        ends: offsets of the turning points, shape (2, n); NaN where a coordinate goes round, or they are not known.
    """
    low, high = (place(formula, x) for formula, x in zip(sides(one.coordinate), ends, strict=True))
    with np.errstate(invalid="ignore"):
        margin = _MARGIN * (high - low)
        return np.asarray(~((places < low - margin) | (places > high + margin)))


def _integrals(sums: list[Sums]) -> Integrals:
    """∂J/∂c, and G = phase times that plus the oscillations."""
    means, errors, oscillations, roundings, speeds = (
        np.stack([getattr(s, part) for s in sums])
        for part in ("means", "mean_errors", "oscillations", "oscillation_errors", "speeds")
    )
    phases, phase_errors = (np.stack([getattr(s, part) for s in sums])[:, None] for part in ("phase", "phase_error"))
    running_errors = errors * np.abs(phases) + roundings + np.abs(speeds) * phase_errors
    return Integrals(means, errors, means * phases + oscillations, running_errors)


def _resting_sums(one: CoordinateOfOrbits, rates: Reals) -> Sums:
    sums = no_sums(len(one.constants), len(one.q))
    sums.means[:] = sums.speeds[:] = rates
    sums.mean_errors[:] = 8 * EPS * np.abs(rates)
    for zero in ("action", "action_error", "oscillations", "oscillation_errors", "phase", "phase_error"):
        getattr(sums, zero)[...] = 0.0
    sums.good[:] = np.isfinite(rates).all(axis=0)
    return sums


def matrix_of(found: AnglesFound, at: Placed) -> Reals:
    """Return ∂θ/∂φ, shape (n, separated, separated).

    Args:
        found: angles of states.
    """
    size = at.q.shape[0]
    rates = at.rates[:, :size].transpose(2, 1, 0)  # (n, constant, coordinate)
    return found.inverse @ rates


def ignorable_slopes(model: Model, found: AnglesFound, at: Placed) -> Reals:
    """Return how the ignorable angles at fixed ignorable coordinates change with the phases, (angles, separated, n).

    These are the rates of their own kernels less the mean growth along θ.

    Args:
        found: angles of states.
    """
    matrix = matrix_of(found, at)
    rows = [
        at.rates[:, j] - np.einsum("kn,nki->in", found.integrals.means[:, j], matrix)
        for j in (model.ignorable[name] for name in model.angles)
    ]
    return np.stack(rows) if rows else np.zeros((0, *at.q.shape))
