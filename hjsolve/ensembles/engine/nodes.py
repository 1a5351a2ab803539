"""Tables of nodes: places of equally spaced anomalies, made once for a number of nodes and a modulus.

The anomalies are those of ``one_coordinate/anomaly.py``, over w = sn²(u | k²). Where a zero or pole of p² lies does not
enter an integral, only its rate of convergence; so k′² is taken from the powers of 4, and the tables serve all orbits.

When k′² is small, u grows like the logarithm of the distance from an end that has a pole next to it, and all else that
p² does happens within a small part of the period. So the nodes are drawn together there:

    u = K/π (χ + γ₁ sin χ + ½ γ₂ sin 2χ)

keeps the symmetries of χ = 0 and π, with γ such that du/dχ is least at χ = 0, π/4, π/2, 3π/4 or π (``CLUSTERINGS``).

A ``level`` is l in k′² = 4^−l, ``count`` the nodes in half a period, ``node_map`` the place in the table of crowdings;
phases χ are in two doubles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.elliptic import descended, means
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.ensembles.engine.kernels.crowding import CLUSTERINGS, EVEN

MOST_LEVEL = 44
"""Largest n of k′² = 4⁻ⁿ, k′ = 6e-14: nearer zeros of p² than that part of the motion converge more slowly."""

_HALF_OF_THE_DIGITS = 1e-17
"""Means of pairs as near as this, relatively, agree to 32 digits after one step more: their distance is squared."""


@dataclass(frozen=True, eq=False)
class Nodes:
    """Arrays of shape (count,) at χ = (j + ½) π/count, or 2π for a rotation.

    Attributes:
        χ: anomalies.
        symmetry: 2 for an even motion, the series being in 2χ; else 1.
        complement, quarter: k′² and K.
        node_map: γ₁, γ₂.
        functions: makes ``low``, ``high`` and ``derivative``; a strip about the nodes needs none of them.
        slow: how many slow places of a rotation there are, 1 or 2; see ``turned_circle``.
    """

    χ: Reals
    symmetry: int
    complement: float
    quarter: float
    node_map: tuple[float, float]
    functions: Callable[[], tuple[Reals, Reals, Reals]]
    slow: int = 1

    @cached_property
    def _made(self) -> tuple[Reals, Reals, Reals]:
        return self.functions()

    @property
    def low(self) -> Reals:
        """sn²; for a rotation the angle 2 am − π."""
        return self._made[0]

    @property
    def high(self) -> Reals:
        """cn²; for a rotation dn."""
        return self._made[1]

    @property
    def derivative(self) -> Reals:
        """π/K du/dχ."""
        return self._made[2]


@cache
def libration_nodes(count: int, level: int, node_map: int = 0) -> Nodes:
    """Return the nodes of half a period between turning points; k′² = 4^−level.

    Args:
        level: l in k′² = 4^−l; 0 for the circular functions.
    """
    # an even motion repeats itself after half of the half period: series go in 2χ
    symmetry = 2 if node_map >= EVEN else 1
    χ = equal_anomalies(count, symmetry * count)
    quarter = float(_moduli(level)[1].high)
    # worked out when first asked for: most orbits need a few of the tables
    functions = partial(_functions_at, χ, level, node_map)
    return Nodes(χ.high, symmetry, 4.0**-level, quarter, CLUSTERINGS[node_map], functions)


def _functions_at(χ: Pair, level: int, node_map: int) -> tuple[Reals, Reals, Reals]:
    return libration_places(χ, level, node_map)[2:]


def series(count: int) -> Reals:
    """Return cos kχ, 0 < k < count, at the nodes of half a period, shape (count − 1, count)."""
    # the angle as a whole number of parts, reduced before it is multiplied by π: no cosine of a large argument
    exact = (np.arange(1, count)[:, None] * (2 * np.arange(count) + 1)) % (4 * count)
    found: Reals = np.cos(exact * (np.pi / (2 * count)))
    return found


def libration_places(χ: Pair, level: int, node_map: int) -> tuple[float, float, Reals, Reals, Reals]:
    """Return k′² and K, and ``low``, ``high``, ``derivative`` of ``libration_nodes`` at some anomalies."""
    D = DoubleDouble()
    γ, δ = (Pair(c, 0.0) for c in CLUSTERINGS[node_map])
    turned, twice = D.unary("sin", χ), D.unary("sin", _twice(χ))
    # the anomaly of the crowded χ, in two doubles: sn² next to 0 and next to 1 has all its digits
    goal = D.add(χ, D.add(D.mul(γ, turned), D.mul(Pair(0.5 * δ.high, 0.0), twice)))
    complement, quarter, sn, cn, _ = _functions(goal, level)
    derivative = D.add(D.mul(γ, D.unary("cos", χ)), D.mul(δ, D.unary("cos", _twice(χ))))
    return complement, quarter, D.mul(sn, sn).high, D.mul(cn, cn).high, D.add(Pair(1.0, 0.0), derivative).high


@cache
def barrier_top_nodes(count: int, level: int) -> Nodes:
    """Return the nodes of half a period that crowd about a crest half way; k′² = 4^−level."""
    χ, quarter = equal_anomalies(count, count), float(_moduli(level)[1].high)
    return Nodes(χ.high, 1, 4.0**-level, quarter, CLUSTERINGS[0], lambda: barrier_top_places(χ, level)[2:])


def barrier_top_places(χ: Pair, level: int) -> tuple[float, float, Reals, Reals, Reals]:
    """Return k′² and K, X = (1 − cn)/2, 1 − X, dX/dχ with cn of 2K χ/π: nodes of ``nodes_about_barrier_tops``."""
    D, half = DoubleDouble(), Pair(0.5, 0.0)
    complement, quarter, sn, cn, dn = _functions(_twice(χ), level)
    below = cn.high < 0
    larger = D.mul(half, D.add(Pair(1.0, 0.0), _where(below, Pair(-cn.high, -cn.low), cn)))
    # (1 − cn)/2 = sn²/(4 (1 + cn)/2): no difference where cn is near 1
    smaller = D.div(D.mul(Pair(0.25, 0.0), D.mul(sn, sn)), larger)
    root = D.mul(D.div(_moduli(level)[1], D.pi()), D.mul(sn, dn))
    return complement, quarter, _where(below, larger, smaller).high, _where(below, smaller, larger).high, root.high


@cache
def rotation_nodes(count: int, level: int, slow: int = 1) -> Nodes:
    """Return the nodes of a whole turn; k′² = 4^−level.

    Args:
        count: nodes in a whole turn, a multiple of four.
        slow: how many slow places there are, 1 or 2; with two of them ``low`` is θ of ``turned_circle``.
    """
    χ, quarter = equal_anomalies(count, count // 2), float(_moduli(level)[1].high)
    return Nodes(χ.high, 1, 4.0**-level, quarter, CLUSTERINGS[0], partial(_turn, count, level, slow), slow)


def _turn(count: int, level: int, slow: int) -> tuple[Reals, Reals, Reals]:
    """2 am − π and dn over a whole turn, and 1."""
    *_, sn, cn, dn = _functions(equal_anomalies(count // slow, count // 2 // slow), level)
    # 2 am − π from (−cos am, sin am): the slow place is the angle 0, where it keeps relative digits
    angle = 2 * np.arctan2(-cn.high, sn.high)
    low = angle if slow == 1 else np.concatenate([0.5 * (angle + side * np.pi) for side in (-1, 1)])
    return low, np.tile(dn.high, slow), np.ones(count)


def _twice(x: Pair) -> Pair:
    return Pair(2 * x.high, 2 * x.low)


def equal_anomalies(count: int, parts: int) -> Pair:
    """(j + ½) π/parts, j < count."""
    D = DoubleDouble()
    return D.div(D.mul(Pair(np.arange(count) + 0.5, 0.0), D.pi()), Pair(float(parts), 0.0))


@cache
def _moduli(level: int) -> tuple[tuple[tuple[Pair, Pair], ...], Pair]:
    """Return the arithmetic–geometric means of 1 and k′ = 2^−level, and K; none where k′ is 1."""
    D = DoubleDouble()
    if level == 0:
        return (), Pair(np.pi / 2, 0.0)
    pairs = means(
        (Pair(1.0, 0.0), Pair(2.0**-level, 0.0)), lambda a, b: abs(D.sub(a, b).high) <= _HALF_OF_THE_DIGITS * a.high, D
    )
    return tuple(pairs), D.div(D.pi(), _twice(pairs[-1][0]))


def _functions(χ: Pair, level: int) -> tuple[float, float, Pair, Pair, Pair]:
    """k′², K, and sn, cn, dn of χ K/π for 0 < χ < 2π, each right to its last bit: no claim counts their errors."""
    D, one = DoubleDouble(), Pair(1.0 + 0.0 * χ.high, 0.0 * χ.high)
    pairs, quarter = _moduli(level)
    if level == 0:
        half = Pair(0.5 * χ.high, 0.5 * χ.low)
        return 1.0, np.pi / 2, D.unary("sin", half), D.unary("cos", half), one
    turn = D.pi()
    reduced, mirrored = χ.high > np.pi, D.sub(_twice(turn), χ)
    χ = _where(reduced, mirrored, χ)
    # beyond ½K by sn(K − u) = cd u and so on (DLMF 22.4(iii)): arguments stay below ½K
    far = χ.high > np.pi / 2
    sn, cn, dn = descended(D.mul(_where(far, D.sub(turn, χ), χ), D.div(quarter, turn)), [*pairs], D)
    k = 2.0**-level
    sn, cn, dn = (
        _where(far, D.div(cn, dn), sn),
        _where(far, D.div(Pair(k * sn.high, k * sn.low), dn), cn),
        _where(far, D.div(Pair(k, 0.0), dn), dn),
    )
    sign = np.where(reduced, -1.0, 1.0)
    return 4.0**-level, float(quarter.high), sn, Pair(sign * cn.high, sign * cn.low), dn


def _where(chosen: Mask, x: Pair, y: Pair) -> Pair:
    return Pair(np.where(chosen, x.high, y.high), np.where(chosen, x.low, y.low))


@cache
def shifts(count: int, symmetry: int) -> tuple[Reals, Reals]:
    """Return what a shift δF of p² does to the mean of k r, in terms of g = k r δF sin²χ/F.

    The change is the finite part −½ ∫ g/sin²χ dχ/π = −½ ∫ g′ cot χ dχ/π, at most ½ Σ |Δg| cot χ/π from node to node,
    the first step half as much again because g′ vanishes at a turning point. The bound is twice that, for safety.

    Args:
        count: number of nodes.
        symmetry: 2 for an even motion, else 1.

    Returns:
        sin²χ at the nodes, shape (count,); |cot χ| symmetry/π half way between, shape (count − 1,).
    """
    χ = (np.arange(count) + 0.5) * np.pi / (symmetry * count)
    # half way between two nodes
    slopes = np.abs(1 / np.tan(χ[1:] - χ[0])) * symmetry / np.pi
    slopes[0] *= 1.5
    if symmetry == 1:
        slopes[-1] *= 1.5
    return np.sin(χ) ** 2, slopes
