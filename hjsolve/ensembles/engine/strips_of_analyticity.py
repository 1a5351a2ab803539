"""How far a strip about the nodes reaches in the coordinate.

Where a function of q is analytic in the strip |Im χ| ≤ a of the anomaly and at most M there, its coefficients fall like
2M exp(−ak); a mean over N nodes misses those from 2N on. So a is chosen such that exp(−2aN) is nothing in doubles. (The
running integrals miss those from N on; the last coefficients before N, which are seen, tell how large these are.) The
strip is cut into rectangles; in q each lies in a disk about the place of its middle, whose radius is found on the edge
of the rectangle, because the map from χ to q is analytic in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from hjsolve.arithmetic.elliptic import quarter_period
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Complexes, Reals
from hjsolve.ensembles.engine.nodes import Nodes
from hjsolve.one_coordinate.complex_anomaly import jacobi_complex

EXPONENT = 36.0
"""exp(−36) = 2.3e-16: what is missed of a function is at most 2 M exp(−36), M being ``clearance.GROWTH`` times what the
function is on the real axis at the very most, and then only if it is as large all along the strip."""

_ROWS, _STRETCHED_ROWS = 2, 4
"""Rectangles above each other; four times as many nodes as rectangles in a row, or twice as many."""
_LEAST = 4
SAFETY = 1.05
"""Only the corners of a rectangle are looked at: they are farthest away, or nearly."""
_INSIDE = 0.98
_CORNERS = [(x, y) for x in (-1, 1) for y in (-1, 1)]


@dataclass(frozen=True, eq=False)
class CoveredStrip:
    """Rectangles that cover a strip over half a period (a whole turn for rotations), from left to right; (count,).

    Attributes:
        low, high: sn² and cn² at the middles, complex; for rotations the angle 2 am − π and nothing of use.
        near_low, near_high: the same at the corners, shape (count, 4).
        spread: radius of the disks, in units of b − a where neither ρ_d nor ρ_c is used; in q for rotations.
        tip: cn² at χ = π + ia, where q first becomes infinite if it does; for two slow places |Im θ| there.
        inside: True where sn and cn have no poles in the strip.
    """

    low: Complexes
    high: Complexes
    near_low: Complexes
    near_high: Complexes
    spread: Reals
    tip: float
    inside: bool


def half_width(count: int, symmetry: int) -> float:
    """Return a for N nodes over half a period (over a quarter: symmetry 2).

    Args:
        count: N.
        symmetry: 2 for an even motion, else 1.
    """
    return EXPONENT / (2 * symmetry * count)


@cache
def across(count: int, node_map: tuple[float, float], symmetry: int) -> float:
    """Return the radius of a disk about the middle of the motion that holds the strip, in units of (b − a)/2.

    For plain anomalies: q = m − h cos φ, φ = χ + γ sin χ + ½ δ sin 2χ; the image of |Im φ| ≤ y is an ellipse.

    Args:
        count: number of nodes.
        node_map: γ and δ, the crowding of the nodes.
        symmetry: 2 for an even motion, else 1.
    """
    a = half_width(count, symmetry)
    γ, δ = node_map
    return float(np.cosh(min(a + abs(γ) * np.sinh(a) + 0.5 * abs(δ) * np.sinh(2 * a), 700.0)))


@cache
def covered_strip(table: Nodes, turning: bool) -> CoveredStrip:
    """Return the strip over which functions are to be known for a table of nodes.

    Args:
        table: of nodes.
        turning: True between two turning points, False for a rotation.
    """
    nodes = len(table.χ) if turning else len(table.χ) // 2
    a, length = half_width(nodes, table.symmetry), np.pi / table.symmetry if turning else 2 * np.pi
    rows = _ROWS if table.complement == 1.0 else _STRETCHED_ROWS
    count = 2 * max(_LEAST, len(table.χ) * rows // 16)
    δ, ε = 0.5 * length / count, 0.5 * a / rows
    middles = (np.arange(1, 2 * count, 2)[:, None] * δ + 1j * ε * np.arange(1, 2 * rows, 2)).ravel()
    edge = [x * δ + y * 1j * ε for x, y in _CORNERS]
    low, high = _places(middles, table, turning)
    near_low, near_high = _places(middles[:, None] + np.array(edge), table, turning)
    apart = near_low - low[:, None]
    if table.slow == 2:  # up to whole turns
        apart -= 2 * np.pi * np.rint(apart.real / (2 * np.pi))
    spread = SAFETY * np.abs(apart).max(axis=1)
    tip = _goal(np.array([np.pi + 1j * a]), table)
    other = np.inf if table.complement == 1.0 else quarter_period(1 - table.complement, Float64())
    inside = table.slow * abs(tip[0].imag) * table.quarter / np.pi < _INSIDE * other
    if table.slow == 2:
        height = float(abs(_places(tip, table, False)[0][0].imag))
        return CoveredStrip(low, high, near_low, near_high, spread, height, bool(inside))
    end = float(np.real(_places(np.array([np.pi + 1j * a]), table, True)[1][0])) if inside else -np.inf
    return CoveredStrip(low, high, near_low, near_high, spread, end, bool(inside))


def _goal(χ: Complexes, table: Nodes) -> Complexes:
    """The anomaly before nodes were crowded."""
    γ, δ = table.node_map
    return χ + γ * np.sin(χ) + 0.5 * δ * np.sin(2 * χ)


def _places(χ: Complexes, table: Nodes, turning: bool) -> tuple[Complexes, Complexes]:
    """sn² and cn² at complex anomalies; for rotations 2 am − π, to be continued from middle to edge, and cn²."""
    if table.slow == 2:
        side = np.where(np.real(χ) > np.pi, 1, -1)
        angle, high = _places(2 * χ - (1 + side) * np.pi, replace(table, slow=1), turning)
        return 0.5 * (angle + side * np.pi), high
    u = _goal(χ, table) * (table.quarter / np.pi) if table.complement < 1 else 0.5 * _goal(χ, table)
    sn, cn, _ = jacobi_complex(u, table.complement, table.quarter)
    if turning:
        return sn * sn, cn * cn
    return -2j * np.log(cn + 1j * sn) - np.pi, cn * cn
