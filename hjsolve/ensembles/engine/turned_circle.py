"""Nodes of rotations that are slow at two places.

Elliptic anomalies at twice the speed, θ = ½ R(2χ) ∓ ½π with R = 2 am − π, crowd at θ = ±π/2. A Möbius transformation of
the unit circle, tan(q/2) = m tan(θ/2), takes these to any two places, q = ±2 arctan m.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Complexes, Reals


def moved(θ: Reals, m: Reals) -> tuple[Reals, Reals]:
    """Return q in (−π, π] and dq/dθ.

    Args:
        θ: angles in (−π, π].
        m: of the transformation, positive; of a shape that broadcasts.
    """
    s, c = np.sin(0.5 * θ), np.cos(0.5 * θ)
    return 2 * np.arctan2(m * s, c), m / (c * c + (m * s) ** 2)


def moved_back(q: Reals, m: Reals) -> Reals:
    """Return θ in (−π, π].

    Args:
        q: angles in (−π, π].
        m: of the transformation.
    """
    return 2 * np.arctan2(np.sin(0.5 * q), m * np.cos(0.5 * q))


def moved_disks(middles: Complexes, edges: Complexes, m: Reals) -> tuple[Complexes, Reals]:
    """Return the places of the middles of some disks, their real parts in (−π, π], and radii that hold their edges.

    On the unit circle, E = exp(iθ), the transformation is Z = ((1 + m) E + 1 − m)/((1 − m) E + 1 + m); where Z of an
    edge is (1 + δ) times that of the middle, the two are |log(1 + δ)| ≤ −log(1 − |δ|) apart.

    Args:
        middles: θ, shape (disks,).
        edges: θ, shape (disks, points).
        m: of the transformations, shape (n, 1).
    """

    def turned(θ: Complexes) -> Complexes:
        E = np.exp(1j * θ)
        return np.asarray(((1 + m) * E + (1 - m)) / ((1 - m) * E + (1 + m)))

    middle = turned(middles)
    farthest = np.zeros(middle.shape)
    for edge in edges.T:
        np.maximum(farthest, np.abs(turned(edge) / middle - 1), out=farthest)
    return -1j * np.log(middle), np.where(farthest < 1, -np.log1p(-np.minimum(farthest, 0.999)), np.inf)


def reach(m: Reals) -> Reals:
    """Return how far from the real line q is first infinite: Im θ = 2 artanh(min(m, 1/m)).

    Args:
        m: of the transformation.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(2 * np.arctanh(np.minimum(m, 1 / m)))


def half_turns(θ: Reals) -> tuple[Reals, Reals]:
    """Return R = 2θ ± π of either half, and by how much the anomaly of R is to be increased before it is halved.

    Args:
        θ: angles in (−π, π].
    """
    right = θ > 0
    return 2 * θ + np.where(right, -np.pi, np.pi), np.where(right, 2 * np.pi, 0.0)
