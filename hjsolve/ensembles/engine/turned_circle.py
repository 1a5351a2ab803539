"""Nodes of rotations that are slow at two places.

Elliptic anomalies at twice the speed, θ = ½ R(2χ) ∓ ½π with R = 2 am − π, crowd at θ = ±π/2. A Möbius transformation of
the unit circle, tan(q/2) = m tan(θ/2), takes these to any two places, q = ±2 arctan m.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.number_types import Complexes, Reals


def moved_disks(E: Complexes, reach: Reals, m: Reals) -> tuple[Complexes, Reals]:
    """Return the places q of the middles of some disks, their real parts in (−π, π], and radii that hold the disks.

    With E = exp(iθ) the transformation is Z = exp(iq) = N/T, N = (1 + m) E + 1 − m, T = (1 − m) E + 1 + m, so that
    Z′ − Z = 4m (E′ − E)/(T T′); where Z′ is (1 + δ) Z, the places are |log(1 + δ)| ≤ −log(1 − |δ|) apart.

    Args:
        E: exp(iθ) at the middles, shape (disks,).
        reach: bounds on |E′ − E|, the same shape.
        m: of the transformations, shape (n, 1).

    Returns:
        Shape (n, disks); radii are infinite where q = ∞ may lie in the disk.
    """
    # |N|² and |T|² written out: sums of squares, no complex division
    a, b, square, x, y = 1 + m, 1 - m, E.real**2 + E.imag**2, E.real, E.imag
    N, T = a * a * square + 2 * a * b * x + b * b, b * b * square + 2 * a * b * x + a * a
    # the least |T′| over the disk of E′
    nearest = np.sqrt(T) - np.abs(b) * reach
    with np.errstate(all="ignore"):
        δ = np.where(nearest > 0, 4 * m * reach / (np.sqrt(N) * nearest), 1.0)
        places = np.empty(δ.shape, dtype=complex)
        places.real = np.arctan2(4 * m * y, a * b * (square + 1) + (a * a + b * b) * x)
        # q = −i log Z: its imaginary part is −log|Z|
        places.imag = 0.5 * np.log(T / N)
        return places, np.where(δ < 1, -np.log1p(-np.minimum(δ, 0.999)), np.inf)


def reach(m: Reals) -> Reals:
    """Return how far from the real line q is first infinite: Im θ = 2 artanh(min(m, 1/m))."""
    with np.errstate(divide="ignore"):
        return np.asarray(2 * np.arctanh(np.minimum(m, 1 / m)))
