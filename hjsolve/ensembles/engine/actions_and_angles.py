"""From the integrals of each coordinate to actions, frequencies and angles, with their errors.

Jᵢ is a function of the constants; ∂Jᵢ/∂cⱼ = (1/2π) ∮ ½ (∂Pᵢ²/∂cⱼ) dqᵢ/Pᵢ are the means of the kernels. From
dE = Σ Ωᵢ dJᵢ: Σᵢ Ωᵢ ∂Jᵢ/∂cⱼ = δⱼ₁ over the separation constants, and −Σᵢ Ωᵢ ∂Jᵢ/∂c for an ignorable momentum c. The
angles are those of ``time_law/torus``: θₖ = Σⱼ (∂J/∂c)⁻¹ₖⱼ Σᵢ Gᵢⱼ(χᵢ) with G the running integrals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.arithmetic.reproducible_products import stacked
from hjsolve.ensembles.engine.kernels.types import Sums
from hjsolve.ensembles.engine.lowered_solution import Model


@dataclass(frozen=True)
class TorusNumbers:
    """Numbers of n orbits; coordinate → array (n,), and its error bound."""

    frequencies: dict[str, tuple[Reals, Reals]]
    angles: dict[str, tuple[Reals, Reals]]


def combine_integrals(model: Model, sums: list[Sums], directions: Reals, q: Reals, *, angles: bool) -> TorusNumbers:
    """Combine the integrals.

    With M the matrix ∂Jᵢ/∂cⱼ, δM⁻¹ = −M⁻¹ δM M⁻¹ to first order. It is multiplied out as far as signs are known, before
    sizes are taken: M⁻¹ times a column of ``means`` or ``speeds`` is of order one, however large M⁻¹ is.

    Args:
        sums: one a separated coordinate.
        directions: +1, or −1 for a rotation the other way; shape (separated, n).
        q: all coordinates, shape (coordinates, n).
        angles: True when they are wanted.
    """
    size = len(sums)
    means = np.stack([s.means for s in sums])
    uncertainties = np.stack([s.mean_errors for s in sums])
    with np.errstate(all="ignore"):
        matrix, rounding = (x[:, :size].transpose(2, 1, 0) for x in (means, uncertainties))  # (n, constant, coordinate)
        inverse = _inverse(matrix)
        # the inverse in doubles is that of a matrix whose elements are off by as much (Higham 2002, ch. 14)
        rounding = rounding + 4 * size * EPS * np.abs(matrix)
        # Σᵢ Ωᵢ ∂Jᵢ/∂cⱼ = δⱼ₁: the column that belongs to the energy
        rates = inverse[:, :, 0].T
        shaken = _applied(rounding, np.abs(rates))
        # |M⁻¹| |δM| |Ω|: the first order of δΩ = −M⁻¹ δM Ω
        rate_errors = _applied(np.abs(inverse), shaken) + 2 * EPS * np.abs(rates)
        frequencies = {c.name: (directions[k] * rates[k], rate_errors[k]) for k, c in enumerate(model.separated)}
        for name in model.angles:
            j = model.ignorable[name]
            value = -np.sum(rates * means[:, j], axis=0)
            # (∂J/∂c) M⁻¹ multiplied out before sizes are taken: both factors are large next to a separatrix, the
            # product is not
            error = np.sum(np.abs(_applied(inverse.transpose(0, 2, 1), means[:, j])) * shaken, axis=0)
            error = error + np.sum(np.abs(rates) * uncertainties[:, j], axis=0)
            frequencies[name] = value, error + 8 * EPS * np.sum(np.abs(rates * means[:, j]), axis=0)
        found = _angles(model, sums, directions, q, inverse, rounding) if angles else {}
    ordered = {name: frequencies[name] for name in model.names if name in frequencies}
    return TorusNumbers(ordered, found)


def _applied(matrices: Reals, vectors: Reals) -> Reals:
    """Matrices (n, i, j) times vectors (j, n)."""
    return stacked(matrices, vectors.T[..., None])[..., 0].T


def _inverse(matrix: Reals) -> Reals:
    """Inverses of a stack of small matrices; NaN where there is none."""
    n = matrix.shape[1]
    if n == 1:
        return 1 / matrix
    if n == 2:
        a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
        det = a * d - b * c
        # Cramer's rule: results do not depend on a library, nor on how many orbits come together
        return np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=1) / det[:, None, None]
    bad: Mask = ~np.all(np.isfinite(matrix), axis=(1, 2))
    safe = np.where(bad[:, None, None], np.eye(n), matrix)
    try:
        inverse = np.linalg.inv(safe)
    except np.linalg.LinAlgError:
        inverse = np.stack([_one_inverse(m) for m in safe])
    inverse[bad] = np.nan
    return inverse


def _one_inverse(matrix: Reals) -> Reals:
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full_like(matrix, np.nan)


def _angles(
    model: Model, sums: list[Sums], directions: Reals, q: Reals, inverse: Reals, rounding: Reals
) -> dict[str, tuple[Reals, Reals]]:
    """θ = χ + M⁻¹ (oscillations); moving a phase moves G by ``speeds``, and an error of M⁻¹ acts on θ − χ only."""
    size = len(sums)
    means, oscillations, roundings, speeds = (
        np.stack([getattr(s, part) for s in sums]) for part in ("means", "oscillations", "oscillation_errors", "speeds")
    )
    phases, phase_errors = np.stack([s.phase for s in sums]), np.stack([s.phase_error for s in sums])
    θ = _applied(inverse, oscillations[:, :size].sum(axis=0))
    shaken = _applied(rounding, np.abs(θ)) + roundings[:, :size].sum(axis=0)
    # an error of a phase moves all angles
    moved = [_applied(inverse, speeds[i, :size]) for i in range(size)]  # ∂θ/∂χᵢ
    error = _applied(np.abs(inverse), shaken) + 4 * EPS * (np.pi + np.abs(phases) + np.abs(θ))
    error = error + sum(np.abs(moved[i]) * phase_errors[i] for i in range(size))
    found = {c.name: _principal(directions[k] * (phases[k] + θ[k]), error[k]) for k, c in enumerate(model.separated)}
    for name in model.angles:
        j = model.ignorable[name]
        value = oscillations[:, j].sum(axis=0) - np.sum(means[:, j] * θ, axis=0)
        spread = np.sum(np.abs(_applied(inverse.transpose(0, 2, 1), means[:, j])) * shaken, axis=0)
        spread = (
            spread
            + roundings[:, j].sum(axis=0)
            + np.sum(np.stack([s.mean_errors[j] for s in sums]) * np.abs(θ), axis=0)
        )
        for i in range(size):
            slope = speeds[i, j] - np.sum(means[:, j] * moved[i], axis=0)
            spread = spread + np.abs(slope) * phase_errors[i]
        place = q[model.names.index(name)]
        size_ = np.abs(place) + np.pi + np.abs(oscillations[:, j]).sum(axis=0) + np.sum(np.abs(means[:, j] * θ), axis=0)
        found[name] = _principal(place + value, spread + 4 * EPS * size_)
    return {name: found[name] for name in model.names if name in found}


def _principal(angle: Reals, error: Reals) -> tuple[Reals, Reals]:
    """Reduce to (−π, π]."""
    turns = np.rint(angle / (2 * np.pi))
    reduced = angle - 2 * np.pi * turns
    return np.where(reduced <= -np.pi, np.pi, reduced), error + EPS * np.abs(turns) * 2 * np.pi
