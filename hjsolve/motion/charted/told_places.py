"""Points expressed in the user's coordinates, in numbers, with bounds on their errors.

On a sphere an error (δX, δY, δZ) of the point turns u by (|Z| δ⊥ + ρ δZ)/(ρ² + Z²) and φ by (|X| δY + |Y| δX)/ρ², with
δ⊥ = hypot(δX, δY), to first order: u is known at a pole, φ is not. Where δ⊥ is more than a part of ρ nothing is known
of φ and of the velocities along the two coordinates; at the pole itself they are NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from hjsolve.arithmetic.number_types import Mpf, Numbers, Reals
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.charts.outer_map import OuterMap, SphereMap
from hjsolve.motion.charted.curvilinear_points import LOST, ROUNDINGS, bounds_curvilinear, told_curvilinear

Row = TypeVar("Row", Numbers, Reals)


def told(outer: OuterMap, found: Sequence[Numbers]) -> list[Numbers]:
    """Return q, q̇, p and the rest of points, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        found: rows of numbers: x, then q̇ and p of the user's coordinates, then anything.
    """
    if isinstance(outer, CurvilinearMap):
        return told_curvilinear(outer, found)
    if not isinstance(outer, SphereMap):
        return list(found)
    X, Y, Z = found[:3]
    if X.dtype == object:
        rows = [_in_many_digits(outer, *point) for point in zip(X, Y, Z, strict=True)]
        q = [np.array(column, dtype=object) for column in zip(*rows, strict=True)]
    else:
        ρ, height = np.hypot(X, Y), outer.sense * Z
        u = np.arctan2(height, ρ) if outer.latitude else np.arctan2(ρ, height)
        q = [u, np.arctan2(Y, X)]
    pole = np.array([not x and not y for x, y in zip(X, Y, strict=True)], dtype=bool)
    q[1] = np.where(pole, np.nan, q[1])
    rates = [np.where(pole, np.nan, row) for row in found[3:5]]
    p = list(found[5:7])
    p[outer.meridian] = np.where(pole, np.nan, p[outer.meridian])
    return [*_ordered(outer, q), *rates, *p, *found[7:]]


def _in_many_digits(outer: SphereMap, X: Mpf, Y: Mpf, Z: Mpf) -> list[Mpf]:
    context = X.context
    ρ, height = context.hypot(X, Y), outer.sense * Z
    return [context.atan2(height, ρ) if outer.latitude else context.atan2(ρ, height), context.atan2(Y, X)]


def bounds_told(outer: OuterMap, points: Sequence[Reals], bounds: Sequence[Reals], bits: int) -> list[Reals]:
    """Return bounds on the errors of q, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        points: x.
        bounds: of x, q̇, p and the rest.
        bits: binary digits of the numbers.
    """
    if isinstance(outer, CurvilinearMap):
        return bounds_curvilinear(outer, points, bounds, bits)
    if not isinstance(outer, SphereMap):
        return list(bounds)
    X, Y, Z = points
    ρ, across = np.hypot(X, Y), np.hypot(bounds[0], bounds[1])
    unit = ROUNDINGS * 2.0**-bits
    height = outer.sense * Z
    u = np.arctan2(height, ρ) if outer.latitude else np.arctan2(ρ, height)
    δu = (np.abs(Z) * across + ρ * bounds[2]) / (ρ**2 + Z**2) + unit * np.abs(u)
    δφ = (np.abs(X) * bounds[1] + np.abs(Y) * bounds[0]) / ρ**2 + unit * np.abs(np.arctan2(Y, X))
    lost, ended = ~(LOST * across < ρ), np.isnan(X)
    lost &= ~ended
    rates = [np.where(lost, np.inf, row) for row in bounds[3:5]]
    p = list(bounds[5:7])
    p[outer.meridian] = np.where(lost, np.inf, p[outer.meridian])
    return [*_ordered(outer, [δu, np.where(lost, np.inf, δφ)]), *rates, *p, *bounds[7:]]


def _ordered(outer: SphereMap, pair: list[Row]) -> list[Row]:
    """Along the meridian and about the axis, in the user's order."""
    return pair if outer.meridian == 0 else pair[::-1]
