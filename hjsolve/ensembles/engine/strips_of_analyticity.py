"""How far a strip about the nodes reaches in the coordinate.

Where a function of q is analytic in the strip |Im χ| ≤ a of the anomaly and at most M there, its coefficients fall like
2M exp(−ak); a mean over N nodes misses those from 2N on. So a is chosen such that exp(−2aN) is nothing in doubles. (The
running integrals miss those from N on; the last coefficients before N, which are seen, tell how large these are.) The
strip is cut into rectangles; in q each lies in a disk about the place of its middle, whose radius is found on the edge
of the rectangle, because the map from χ to q is analytic in it.

``coarse`` is whether by fewer and larger disks, where anomalies are stretched; ``symmetry`` is 2 for an even motion,
else 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from hjsolve.arithmetic.elliptic import jacobi_complex, quarter_period
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Complexes, Mask, Reals
from hjsolve.ensembles.engine.kernels.crowding import CLUSTERINGS, EVEN
from hjsolve.ensembles.engine.nodes import Nodes

EXPONENT = 36.0
"""exp(−36) = 2.3e-16: what is missed of a function is at most 2 M exp(−36), M being ``clearance.GROWTH`` times what the
function is on the real axis at the very most, and then only if it is as large all along the strip."""

_PLAIN, _STRETCHED, _COARSE = (2, 2), (4, 4), (2, 3)
"""Rectangles above each other, and in a row for eight nodes; coarse covers of stretched strips have fewer."""
_LEAST = 4
"""Rectangles of half a row at least: the strip of few nodes is about as high as it is long. 2 and 8 change last bits of
20 000 orbits, and no status."""
_CORNER_MARGIN = 1.05
"""Only the corners of a rectangle are looked at: they are farthest away, or nearly."""
_LARGEST, _TALLEST = 1.5, 1.9
"""Radii of rectangles in u that are too large; heights, over K′, up to which sn is worked out."""
_SLOPES = ((1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
_INSIDE = 0.98
"""Of the height K′ at which dn and the like have their poles: as far as a strip may go. 0.96 and 0.99 give the same
bits."""
_CORNERS = [(x, y) for x in (-1, 1) for y in (-1, 1)]


@dataclass(frozen=True, eq=False)
class CoveredStrip:
    """Rectangles that cover a strip over half a period between turning points, from left to right; arrays (count,).

    A place is x = n/T with T = n + (1 + ρ_d) m, where (n, m) is (sn², cn²), (1, cn²/sn²) or (sn²/cn², 1): one of these
    functions f is small on the rectangle and changes by Δ along it. Then T changes by (slope ρ_d + more) Δ, and
    x′ − x is ±(1 + ρ_d) Δ/(T T′).

    Attributes:
        above, below: n and m at the middles, complex.
        reach: a bound on |Δ|; infinite where the rectangle is too large, or too far away, for any of this.
        slope, more: see there.
    """

    above: Complexes
    below: Complexes
    reach: Reals
    slope: Reals
    more: Reals


@dataclass(frozen=True, eq=False)
class CoveredTurn:
    """Rectangles that cover a strip over a whole turn of rotations, from left to right; arrays (count,).

    Attributes:
        angle: 2 am − π at the middles, complex; where there are two slow places exp(iθ) of ``turned_circle``.
        reach: bounds on how far that is at the corners from the middle.
        inside: True where am has no singularity in the strip.
    """

    angle: Complexes
    reach: Reals
    inside: bool


def half_width(count: int, symmetry: int) -> float:
    """Return a for N nodes over half a period (over a quarter: symmetry 2).

    Args:
        count: N.
    """
    # 2aN = 36, the exponent of a rounding
    return EXPONENT / (2 * symmetry * count)


@cache
def across(count: int, node_map: tuple[float, float], symmetry: int) -> float:
    """Return the radius of a disk about the middle of the motion that holds the strip, in units of (b − a)/2.

    For plain anomalies: q = m − h cos φ, φ = χ + γ sin χ + ½ δ sin 2χ; the image of |Im φ| ≤ y is an ellipse.

    Args:
        count: number of nodes.
        node_map: γ and δ, the crowding of the nodes.
    """
    a = half_width(count, symmetry)
    γ, δ = node_map
    return float(np.cosh(min(a + abs(γ) * np.sinh(a) + 0.5 * abs(δ) * np.sinh(2 * a), 700.0)))


@cache
def covered_strip(table: Nodes) -> CoveredStrip:
    """Return the strip over which functions are to be known for a table of nodes between turning points.

    Of the three functions f that one is taken whose disks are smallest for typical motions with these nodes.
    """
    # the upper half of the strip over half a period: the rest is its mirror image
    a, length = half_width(len(table.χ), table.symmetry), np.pi / table.symmetry
    middles, corners = _rectangles(table, a, length, _shape(table, coarse=False))
    with np.errstate(all="ignore"):
        # at the corners a function that is analytic in the rectangle is farthest from its middle, or nearly
        (w, c), (near_w, near_c) = squares(middles, table), squares(corners, table)
        # three charts of the sphere of (sn² : cn²): each is small where another has its pole
        f = np.stack([w, c / w, w / c])
        apart = np.stack([near_w, near_c / near_w, near_w / near_c]) - f[:, :, None]
        reach = np.where(
            _without_poles(w, c, middles, corners, table), _CORNER_MARGIN * np.abs(apart).max(axis=2), np.inf
        )
    one = np.ones(len(w))
    charts = [
        CoveredStrip(n, m, r, slope * one, more * one)
        for n, m, r, (slope, more) in zip((w, one, f[2]), (c, f[1], one), reach, _SLOPES, strict=True)
    ]
    # the chart with the smallest disk, rectangle by rectangle
    best = np.argmin([disks(chart, _typical(table))[2] for chart in charts], axis=0)
    rows = (np.stack([getattr(chart, name) for chart in charts]) for name in CoveredStrip.__dataclass_fields__)
    return CoveredStrip(*(row[best, np.arange(len(w))] for row in rows))


def _without_poles(w: Complexes, c: Complexes, middles: Complexes, corners: Complexes, table: Nodes) -> Mask:
    """Tell in which rectangles sn², cn²/sn² and sn²/cn² have no poles, shape (3, count).

    About a zero or a pole of sn or cn these functions, or their reciprocals, are at most tan² |u|, times k′² for cn:
    their series is majorized by that of the tangent, because f′² = (1 ± f²)(1 ± m f²) with m ≤ 1 for sn and sd.
    """
    if table.complement == 1.0:
        return np.stack([np.full(len(w), known) for known in (True, False, False)])
    scale, other = table.quarter / np.pi, quarter_period(1 - table.complement, Float64())
    u, edges = scale * _goal(middles, table), scale * _goal(corners, table)
    radius = _CORNER_MARGIN * np.abs(edges - u[:, None]).max(axis=1)
    far = (radius > _LARGEST) | (np.abs(edges.imag).max(axis=1) > _TALLEST * other)
    tangent = np.where(far, np.inf, np.tan(np.minimum(radius, _LARGEST)) ** 2)
    return np.stack([tangent * np.abs(w) < 1, np.abs(w) > tangent, np.abs(c) > table.complement * tangent])


def _typical(table: Nodes) -> float:
    """ρ_d of motions that these nodes are made for."""
    place = CLUSTERINGS.index(table.node_map)
    fraction = (place - 1) / 4 if 1 <= place < EVEN else 0.5
    return float(table.complement**-fraction - 1)


def disks(over: CoveredStrip, d: Reals | float) -> tuple[Complexes, Complexes, Reals]:
    """Return disks that hold the rectangles: (q − a)/W and (b − q)/W of the centres, and the radii over W.

    Args:
        over: the rectangles.
        d: ρ_d, of a shape that broadcasts with them.

    Returns:
        Complex places, and radii, infinite where a rectangle may hold q = ∞.
    """
    with np.errstate(all="ignore"):
        above, below = over.above, (1 + d) * over.below
        re, im = above.real + below.real, above.imag + below.imag
        size = np.sqrt(re * re + im * im)
        # the least |T′|: where it is not positive the rectangle may hold q = ∞
        nearest = size - (over.slope * d + over.more) * over.reach
        radii = np.where(nearest > 0, (1 + d) * over.reach / (size * nearest), np.inf)
        inverse = np.empty(size.shape, dtype=complex)
        inverse.real, inverse.imag = re / size**2, -im / size**2
        return above * inverse, below * inverse, radii


@cache
def barrier_top_disks(table: Nodes) -> tuple[Complexes, Complexes, Reals]:
    """Return disks that hold the rectangles of ``nodes_about_barrier_tops`` half way, as ``disks`` does.

    Args:
        table: of ``barrier_top_nodes``.
    """
    a = half_width(len(table.χ), 1)
    middles, corners = _rectangles(table, a, np.pi, _STRETCHED)
    low, high = _halves(middles, table)
    near, far = _halves(corners, table)
    # the smaller one of both keeps the digits of small disks
    # differences of the smaller of X and 1 − X: the larger one has lost what the small disk is about
    apart = np.where(low.real[:, None] < 0.5, near - low[:, None], far - high[:, None])
    inside = 2 * a * table.quarter / np.pi < _INSIDE * quarter_period(1 - table.complement, Float64())
    return low, high, _CORNER_MARGIN * np.abs(apart).max(axis=1) if inside else np.full(len(low), np.inf)


def _halves(χ: Complexes, table: Nodes) -> tuple[Complexes, Complexes]:
    """(1 − cn)/2 and (1 + cn)/2 of 2K χ/π at complex anomalies."""
    sn, cn, _ = _sines(2 * χ, table)
    right = cn.real < 0
    larger = 0.5 * (1 + np.where(right, -cn, cn))
    smaller = 0.25 * sn * sn / larger
    return np.where(right, larger, smaller), np.where(right, smaller, larger)


@cache
def covered_turn(table: Nodes, *, coarse: bool = False) -> CoveredTurn:
    """Return the strip over which functions are to be known for a table of nodes of rotations."""
    a = half_width(len(table.χ) // 2, table.symmetry)
    middles, corners = _rectangles(table, a, 2 * np.pi, _shape(table, coarse=coarse))
    place = _turns if table.slow == 1 else _half_turns
    angle, edges = place(middles, table), place(corners, table)
    other = np.inf if table.complement == 1.0 else quarter_period(1 - table.complement, Float64())
    inside = table.slow * a * table.quarter / np.pi < _INSIDE * other
    return CoveredTurn(angle, _CORNER_MARGIN * np.abs(edges - angle[:, None]).max(axis=1), bool(inside))


def _shape(table: Nodes, *, coarse: bool) -> tuple[int, int]:
    return _PLAIN if table.complement == 1.0 else _COARSE if coarse else _STRETCHED


def _rectangles(table: Nodes, a: float, length: float, shape: tuple[int, int]) -> tuple[Complexes, Complexes]:
    """Middles and corners of rectangles, shapes (count,) and (count, 4)."""
    rows, columns = shape
    count = 2 * max(_LEAST, len(table.χ) * columns // 16)
    δ, ε = 0.5 * length / count, 0.5 * a / rows
    middles = (np.arange(1, 2 * count, 2)[:, None] * δ + 1j * ε * np.arange(1, 2 * rows, 2)).ravel()
    return middles, middles[:, None] + np.array([x * δ + y * 1j * ε for x, y in _CORNERS])


def _goal(χ: Complexes, table: Nodes) -> Complexes:
    """Return the anomaly before nodes were crowded."""
    γ, δ = table.node_map
    return χ + γ * np.sin(χ) + 0.5 * δ * np.sin(2 * χ)


def squares(χ: Complexes, table: Nodes) -> tuple[Complexes, Complexes]:
    """Return sn² and cn² at complex anomalies, in doubles.

    Args:
        χ: anomalies of nodes as they are crowded, any shape.
    """
    sn, cn, _ = _sines(χ, table)
    return sn * sn, cn * cn


def _sines(χ: Complexes, table: Nodes) -> tuple[Complexes, Complexes, Complexes]:
    u = _goal(χ, table) * (table.quarter / np.pi) if table.complement < 1 else 0.5 * _goal(χ, table)
    return jacobi_complex(u, table.complement, table.quarter)


def _turns(χ: Complexes, table: Nodes) -> Complexes:
    """2 am − π at complex anomalies, to be continued from middle to edge."""
    sn, cn, _ = _sines(χ, table)
    return np.asarray(-2j * np.log(cn + 1j * sn) - np.pi)


def _half_turns(χ: Complexes, table: Nodes) -> Complexes:
    """exp(iθ) at complex anomalies, θ = am or am − π at twice the speed; one function all along."""
    right = np.real(χ) > np.pi
    sn, cn, _ = _sines(2 * χ - np.where(right, 2 * np.pi, 0.0), replace(table, slow=1))
    return np.where(right, 1, -1) * (cn + 1j * sn)
