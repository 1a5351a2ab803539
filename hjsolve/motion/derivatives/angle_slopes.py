r"""Derivatives of the angle variables at t₀: θ_k = Σ_j B_j ∂α_j/∂J_k, the Legendre partner of J in W.

B_j = Σ_i [G_j(χ_i) − G_j(χ_i⁰)] + q_j is what Jacobi's equation of α_j comes to, counted from the phases χ⁰ of angle
zero: the lower turning point of a libration, the place opposite to the highest barrier of a rotation, which moves with
the variables like the barrier, q_b = −F_qb/F_qq there. So dθ_k = Σ_j (dB_j ∂α_j/∂J_k + B_j d(∂α_j/∂J_k)).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.motion.angles_along import phase_of_zero
from hjsolve.motion.derivatives.along_cycle import CycleVariations
from hjsolve.motion.derivatives.at_rest import RestVariations
from hjsolve.motion.derivatives.bounded import Bounded, converted, stacked, zeros
from hjsolve.motion.derivatives.canonical import ConstantsToState, outer
from hjsolve.motion.derivatives.integrals import MeanMatrix
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.one_coordinate.anomaly import TwoBarrierAnomaly


def angles_by(map_: ConstantsToState, means: MeanMatrix) -> dict[str, Bounded]:
    """Return the derivatives of the angles at t₀ by (B, x, a, y) and the parameters, coordinate → one row."""
    solution, n, nf = map_.source.solution, map_.freedoms, len(map_.free)
    columns = 2 * n + len(map_.variables.parameters)
    Z = map_.variations(columns)
    B, dB = _laws(map_, Z)
    others = [c.name for c in solution.system.coordinates if c.name not in solution.coordinates]
    result = {}
    for k, name in enumerate([*solution.coordinates, *others]):
        part = map_.parts[k] if k < len(map_.parts) else None
        if isinstance(part, RestVariations):
            continue
        # θₖ = Σⱼ (∂J/∂c)⁻¹ⱼₖ Bⱼ (Greenwood (5-83)): both factors vary
        weights = means.inverse[:, k]
        row = weights @ dB
        for f in range(nf):
            row.value[f] = row.value[f] + weights.value[map_.free[f]]
            row.error[f] += weights.error[map_.free[f]]
        # the inverse varies by −G⁻¹ G_b G⁻¹, worked out in ``inverse_by``
        slopes = stacked([means.inverse_by(b)[:, k] for b in range(map_.variables.count)], 1)
        row = row + (B @ slopes) @ Z
        # angles grow with the time, whichever way the coordinate goes
        backward = isinstance(part, CycleVariations) and part.coordinate_motion.direction < 0
        result[name] = -row if backward else row
    return result


def differentiable_angles(map_: ConstantsToState) -> bool:
    """Whether the places from which angles are counted have derivatives: not those of two barriers."""
    return not any(
        isinstance(part, CycleVariations)
        and isinstance(
            getattr(part.coordinate_motion.anomaly, "inner", part.coordinate_motion.anomaly), TwoBarrierAnomaly
        )
        for part in map_.parts
    )


def _laws(map_: ConstantsToState, Z: Bounded) -> tuple[Bounded, Bounded]:
    """B_j, and what the places of angle zero add to its differential, by all columns."""
    c, solution, n = map_.context, map_.source.solution, len(map_.variables.constants)
    B, dB = zeros((n,), c), zeros((n, Z.value.shape[1]), c)
    for part in map_.parts:
        if isinstance(part, RestVariations):
            continue
        coordinate_motion: Any = part.coordinate_motion
        start: NDArray[np.object_] = np.array([c.convert(coordinate_motion.start)], dtype=object)
        begin: NDArray[np.object_] = np.array([c.convert(phase_of_zero(coordinate_motion, c, c.prec))], dtype=object)
        none = np.zeros(1, dtype=int)
        waves, offset = part.waves, np.array([0.0])  # type: ignore[union-attr]
        _, here = waves.at(start, start)
        _, there = waves.at(begin, begin)
        B = B + here[:n, 0] - there[:n, 0]
        # angle zero of a libration is at a turning point, whose motion adds nothing as p = 0; that of a rotation adds
        if part.coordinate_motion.rotates:
            slopes = part.slopes(begin, none, offset)
            moved = _zero_by(part, begin) @ Z - slopes.q_by[:, 0] @ Z
            phase = Bounded(
                np.array([x / slopes.q.value[0] for x in moved.value], dtype=object),
                moved.error / abs(float(slopes.q.value[0])),
            )
            dB = dB - slopes.integrals[:, :, 0] @ Z - outer(slopes.rates[:, 0], phase)
    for q in solution.system.coordinates:
        if q.name not in solution.coordinates:
            j = map_.variables.constants.index(q.momentum.name)
            B.value[j] = B.value[j] + to_bits(map_.source.initial.values[q.symbol])(c.prec)
    return B, dB


def _zero_by(part: Any, begin: NDArray[np.object_]) -> Bounded:
    """How the place of angle zero moves: with the barrier opposite to it, or not at all."""
    c = part.context
    place = c.convert(part.coordinate_motion.place(converted(begin, c))[0][0])
    barrier = place - c.pi * part.coordinate_motion.radian
    at = part.rule.at(barrier)
    moves: list[Mpf] = [c.mpf(0)] * len(part.scale)
    # F_q = 0 there: a barrier, whose place moves by −F_qb/F_qq; else the angle is counted from a fixed place
    if abs(at.slope) <= abs(at.bend) * c.ldexp(1, -c.prec // 4):
        moves = [-by / at.bend for by in at.slope_by]
    half = c.pi * part.coordinate_motion.radian
    return Bounded.exact(np.array([m + s * half for m, s in zip(moves, part.scale, strict=True)], dtype=object))
