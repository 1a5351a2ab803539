"""The anomaly of the start. Next to a turning point it is read off the momentum: q₀ − a = P₀²/((b − q₀) S)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.turned_circle import half_turns, moved_back

if TYPE_CHECKING:
    from hjsolve.ensembles.engine.nodes import Nodes
    from hjsolve.ensembles.engine.orbit_regions import OrbitRegions

_CLOSE = 0.05


@dataclass(frozen=True)
class EndNodes:
    """The nodes next to the turning points; arrays (n,).

    Attributes:
        low, high: offsets (q − a)/W of the first node and (b − q)/W of the last one.
        low_uncertainty, high_uncertainty: bounds on the relative error of F there.
    """

    low: Reals
    high: Reals
    low_uncertainty: Reals
    high_uncertainty: Reals


def phase_of_libration(region: OrbitRegions, table: Nodes, ratio: Reals, ends: EndNodes) -> tuple[Reals, Reals]:
    """Return χ₀ in (−π, π] and a bound on its error.

    The place x = (q₀ − a)/W moves with the turning points: an error δF of p² shifts a by δF/F′ = W x δF/F, taken at the
    first node. Next to an end x is found from the momentum, and its relative error is that of F/(xy) there.

    Args:
        region: of n orbits.
        table: nodes.
        ratio: r = stretch/√S at the nodes, shape (n, nodes).
        ends: see there.
    """
    x, y = region.left / region.width, region.right / region.width
    d, c = (region.near_lower, region.near_upper) if table.complement < 1 else (0.0 * x, 0.0 * x)
    lower, upper = ends.low * ends.low_uncertainty, ends.high * ends.high_uncertainty
    δ = y * lower + x * upper
    close = np.minimum(x * (1 + d), y * (1 + c)) < _CLOSE  # beyond, a pole makes p² flat: it tells no place
    if close.any():
        x, y = x.copy(), y.copy()
        part = np.flatnonzero(close)
        for _ in range(3):
            x[part], y[part] = _from_momentum(region, table, ratio, part, x[part], y[part])
        near = np.minimum(x * ends.low_uncertainty, lower) + x * (lower + upper)
        far = np.minimum(y * ends.high_uncertainty, upper) + y * (lower + upper)
        δ = np.where(close, np.where(x < y, near, far), δ)
    χ = _place(x, y, d, table)
    small, large = np.minimum(x, y), np.maximum(x, y)
    root = np.sqrt(np.maximum(_stretch(table, χ, x, y, d, c) * large, 1e-300))
    uncertainty = (np.where(small > 0, δ / np.sqrt(np.maximum(small, 1e-300)), 0.0) + 4 * EPS * np.sqrt(small)) / root
    return np.where(region.momentum < 0, -χ, χ), 2 * uncertainty + 8 * EPS * np.pi


def _stretch(table: Nodes, χ: Reals, x: Reals, y: Reals, d: Reals, c: Reals) -> Reals:
    """(dq/dχ)²/(W² x y)."""
    derivative = 1 + table.node_map[0] * np.cos(χ) + table.node_map[1] * np.cos(2 * χ)
    return (2 * table.quarter / np.pi * derivative) ** 2 * table.complement * (1 + c * y) * (1 + d * x)


def _from_momentum(
    region: OrbitRegions, table: Nodes, ratio: Reals, part: Integers, x: Reals, y: Reals
) -> tuple[Reals, Reals]:
    """Return x = (q₀ − a)/W and y = 1 − x near an end, from P₀² = W² x y S(q₀)."""
    W, P = region.width[part], region.momentum[part]
    d, c = (region.near_lower[part], region.near_upper[part]) if table.complement < 1 else (0.0 * x, 0.0 * x)
    χ = _place(x, y, d, table)
    terms = np.arange(1, len(table.cosines) + 1)
    weights = (1 + 2 * table.cosine_sums(np.cos(table.symmetry * terms * χ[:, None]))) / len(table.χ)
    r = np.einsum("nj,nj->n", ratio[part], weights)
    small = (P * r / W) ** 2 / _stretch(table, χ, x, y, d, c) / np.maximum(x, y)
    lower = x < y
    return np.where(lower, small, 1 - small), np.where(lower, 1 - small, small)


def phase_of_rotation(region: OrbitRegions, table: Nodes) -> tuple[Reals, Reals]:
    """Return χ₀ in (−π, π] of a rotation and a bound on its error; the slow place is χ = π.

    Args:
        region: of n rotations.
        table: nodes that the anomaly is read from.
    """
    left = np.sign(region.momentum) * region.left
    left = left - 2 * np.pi * np.rint(left / (2 * np.pi))
    bound = 16 * EPS * np.pi**2 / (2 * table.quarter * table.high.min())
    if table.slow == 2:
        m = region.near_lower
        left, whole = half_turns(moved_back(left, m))
        bound = 2 * bound * np.maximum(m, 1 / m)
    χ = _anomaly(np.where(left > 0, -1, 1) * np.cos(left / 2), np.abs(np.sin(left / 2)), table)
    if table.slow == 2:
        χ = 0.5 * (χ + whole + np.where(left > 0, 2 * np.pi, 0.0))
        χ = χ - np.where(χ > np.pi, 2 * np.pi, 0.0)
    return χ, bound + 0.0 * left


def _place(x: Reals, y: Reals, d: Reals, table: Nodes) -> Reals:
    """χ of x = (q − a)/W; sn and cn each keep their relative accuracy."""
    sine, cosine = np.sqrt(np.maximum(x * (1 + d), 0)), np.sqrt(np.maximum(y, 0))
    size = np.sqrt(sine * sine + cosine * cosine)
    return _anomaly(sine / size, cosine / size, table)


def _anomaly(s: Reals, c: Reals, table: Nodes) -> Reals:
    """χ = π F(φ | k²)/K from s = sin φ and c = cos φ ≥ 0: F = sin φ R_F(cos²φ, 1 − k² sin²φ, 1) (DLMF 19.25.5)."""
    if table.complement == 1.0:
        goal = 2 * np.arctan2(s, c)
        return goal if table.node_map == (0.0, 0.0) else _unwarped(goal, *table.node_map)
    x, y, z = c * c, c * c + table.complement * s * s, 1.0 + 0.0 * s
    x = np.maximum(x, 1e-300)
    done = np.zeros(np.shape(s), dtype=bool)
    for _ in range(64):
        λ = np.sqrt(x * y) + np.sqrt(y * z) + np.sqrt(z * x)
        # an orbit stops where it has converged, not where the last of its company has
        x, y, z = (np.where(done, old, (old + λ) / 4) for old in (x, y, z))
        A = (x + y + z) / 3
        X, Y = 1 - x / A, 1 - y / A
        done = done | (np.maximum(np.abs(X), np.abs(Y)) < 2e-3)
        if np.all(done):
            break
    Z = -X - Y
    e2, e3 = X * Y - Z * Z, X * Y * Z
    R = (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / np.sqrt(A)
    goal = np.pi * s * R / table.quarter
    return goal if table.node_map == (0.0, 0.0) else _unwarped(goal, *table.node_map)


def _unwarped(goal: Reals, γ: float, δ: float) -> Reals:
    """Solve χ + γ sin χ + ½ δ sin 2χ = goal, 0 ≤ goal ≤ π, by Newton's method inside a bracket."""
    low, high = np.zeros_like(goal), np.full_like(goal, np.pi)
    χ, done = goal.copy(), np.zeros(goal.shape, dtype=bool)
    for _ in range(60):
        f = χ + γ * np.sin(χ) + 0.5 * δ * np.sin(2 * χ) - goal
        low, high = np.where(f <= 0, χ, low), np.where(f >= 0, χ, high)
        new = χ - f / (1 + γ * np.cos(χ) + δ * np.cos(2 * χ))
        new = np.where((new >= low) & (new <= high), new, (low + high) / 2)
        new, done = np.where(done, χ, new), done | (np.abs(new - χ) <= 4 * EPS * np.abs(new))
        χ = new
        if np.all(done):
            break
    return χ
