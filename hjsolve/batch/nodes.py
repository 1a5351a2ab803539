"""Tables of nodes: places of equally spaced anomalies, made once for a number of nodes and a modulus.

The anomalies are those of ``numeric/anomaly.py``, over w = sn²(u | k²). Where a zero or pole of p² lies does not enter
an integral, only its rate of convergence; so k′² is taken from the powers of 4, and the tables serve all orbits.

When k′² is small, u grows like the logarithm of the distance from an end that has a pole next to it, and all else that
p² does happens within a small part of the period. So the nodes are drawn together there:

    u = K/π (χ + γ₁ sin χ + ½ γ₂ sin 2χ)

keeps the symmetries of χ = 0 and π, with γ such that du/dχ is least at χ = 0, π/4, π/2, 3π/4 or π (``WARPS``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hjsolve.numeric.arithmetic import Float64
from hjsolve.numeric.elliptic import jacobi, quarter_period

COUNTS = (12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384)
"""Numbers of nodes in use, over half a period (librations) or over a period (rotations, twice as many)."""

MOST = 44
"""Least k′² in use: 4^−MOST."""

WARPS = ((0.0, 0.0), (-0.7, 0.0), (-0.495, 0.175), (0.0, 0.7), (0.495, 0.175), (0.7, 0.0), (0.0, 0.0), (0.0, 0.7))
"""γ₁, γ₂: none, then crowded at χ = 0, π/4, π/2, 3π/4, π; none and crowded at π/2 once more for even motions."""

EVEN = 6
"""From here on the motion is even about its middle: half of the half period serves, series go in 2χ."""


@dataclass(frozen=True, eq=False)
class Nodes:
    """Arrays of shape (count,) at χ = (j + ½) π/count, or 2π for a rotation.

    Attributes:
        χ: anomalies.
        low, high: sn² and cn²; for a rotation the angle 2 am − π and dn.
        fold: 2 for an even motion, the series being in 2χ; else 1.
        complement, quarter: k′² and K. pace: π/K du/dχ. warp: γ₁, γ₂.
        cosines, sines: cos kχ and sin kχ, shape (terms, count), k = 1, 2, …
        last: rows of the series that tell whether the nodes suffice; middle: rows half way.
    """

    χ: Any
    low: Any
    high: Any
    fold: int
    complement: float
    quarter: float
    pace: Any
    warp: tuple[float, float]
    cosines: Any
    sines: Any
    last: slice
    middle: slice


@cache
def libration(count: int, level: int, warp: int = 0) -> Nodes:
    """Return the nodes of half a period between turning points; k′² = 4^−level."""
    fold = 2 if warp >= EVEN else 1
    χ = (np.arange(count) + 0.5) * np.pi / (fold * count)
    γ, δ = WARPS[warp]
    complement, quarter, sn, cn, _ = _functions(χ + γ * np.sin(χ) + 0.5 * δ * np.sin(2 * χ), level)
    pace = 1 + γ * np.cos(χ) + δ * np.cos(2 * χ)
    terms = np.arange(1, count)[:, None]
    exact = (terms * (2 * np.arange(count) + 1)) % (4 * count)
    angle = exact * (np.pi / (2 * count))
    return Nodes(
        χ, sn**2, cn**2, fold, complement, quarter, pace, WARPS[warp], np.cos(angle), np.sin(angle), slice(-5, None),
        slice(count // 2 - 4, count // 2 + 1),
    )  # fmt: skip


@cache
def rotation(count: int, level: int) -> Nodes:
    """Return the nodes of a whole turn; k′² = 4^−level."""
    χ = (np.arange(count) + 0.5) * 2 * np.pi / count
    complement, quarter, sn, cn, dn = _functions(χ, level)
    terms = np.arange(1, count // 2)[:, None]
    exact = (terms * (2 * np.arange(count) + 1)) % (2 * count)
    angle = exact * (np.pi / count)
    amplitude = np.mod(np.arctan2(sn, cn), 2 * np.pi)
    half = count // 2
    return Nodes(
        χ, 2 * amplitude - np.pi, dn, 1, complement, quarter, 1.0, WARPS[0], np.cos(angle), np.sin(angle),
        slice(-3, None), slice(half // 2 - 2, half // 2 + 1),
    )  # fmt: skip


def _functions(χ: Any, level: int) -> tuple[float, float, Any, Any, Any]:
    if level == 0:
        return 1.0, np.pi / 2, np.sin(χ / 2), np.cos(χ / 2), np.ones_like(χ)
    arithmetic = Float64()
    complement = 4.0**-level
    quarter = float(quarter_period(complement, arithmetic))
    return complement, quarter, *jacobi(χ * (quarter / np.pi), complement, quarter, arithmetic)


def next_count(needed: float) -> int:
    """Return the least number of nodes in use that is enough, 0 where none is."""
    return next((count for count in COUNTS if count >= needed), 0)
