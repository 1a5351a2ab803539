"""Points in the user's coordinates, polar, cylindrical, spherical or on a sphere, with bounds on their errors.

To first order an error (δx, δy, δz) of the point moves ρ by hypot(δx, δy) = δ⊥ at most, φ by (|x| δy + |y| δx)/ρ², r by
hypot(δ⊥, δz) at most and θ by (|z| δ⊥ + ρ δz)/r². Where δ⊥ is more than a part of ρ nothing is known of φ and of the
velocities that it turns; on the axis itself they are NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from hjsolve.arithmetic.number_types import Mask, Numbers, Reals
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.charts.outer_map import (
    AZIMUTH,
    COLATITUDE,
    FROM_AXIS,
    FROM_CENTRE,
    HEIGHT,
    LATITUDE,
    OuterMap,
    SphereMap,
)

Row = TypeVar("Row", Numbers, Reals)
_LOST = 8
"""Where the error across the axis is more than its 8th part of the distance from it, nothing is known of the angle."""
_ROUNDINGS = 8  # of squares, sums, a root and a quotient behind each coordinate
_TURNED = (AZIMUTH, FROM_AXIS, COLATITUDE, LATITUDE)
"""Coordinates whose rates are not known on the axis."""
_hypot = np.frompyfunc(lambda a, b: a.context.hypot(a, b), 2, 1)
_atan2 = np.frompyfunc(lambda a, b: b.context.atan2(a, b), 2, 1)
"""Of two arrays of ``mpf``."""


def in_users_coordinates(outer: OuterMap, found: Sequence[Numbers]) -> list[Numbers]:
    """Return q, q̇, p and the rest of points, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        found: rows of numbers: x, then q̇ and p of the user's coordinates, then anything.
    """
    if not isinstance(outer, CurvilinearMap | SphereMap):
        return list(found)
    x, rest = found[: len(outer.place)], found[len(outer.place) :]
    q = _values(outer, x)
    axis = np.array([not a and not b for a, b in zip(x[0], x[1], strict=True)], dtype=bool)
    q = [np.where(axis, np.nan, row) if role == AZIMUTH else row for role, row in zip(outer.roles, q, strict=True)]
    return [*q, *_unknown(outer, rest, axis, np.nan)]


def _values(outer: CurvilinearMap | SphereMap, x: Sequence[Numbers]) -> list[Numbers]:
    hypot, atan2 = (_hypot, _atan2) if x[0].dtype == object else (np.hypot, np.arctan2)
    ρ = hypot(x[0], x[1])
    height = outer.sense * x[2] if len(x) == 3 else 0 * ρ
    found = {
        AZIMUTH: lambda: atan2(x[1], x[0]), FROM_AXIS: lambda: ρ, HEIGHT: lambda: height,
        FROM_CENTRE: lambda: hypot(ρ, height), COLATITUDE: lambda: atan2(ρ, height), LATITUDE: lambda: atan2(height, ρ),
    }  # fmt: skip
    return [found[role]() for role in outer.roles]


def _unknown(outer: CurvilinearMap | SphereMap, rows: Sequence[Row], where: Mask, instead: float) -> list[Row]:
    """Rows of q̇, p and the rest, with something else where the rates of what turns about the axis are not known."""
    n, result = len(outer.roles), list(rows)
    for k, role in enumerate(outer.roles):
        if role in _TURNED:
            result[k] = np.where(where, instead, rows[k])
        if role in _TURNED and role != AZIMUTH:
            result[n + k] = np.where(where, instead, rows[n + k])
    return result


def bounds_in_users_coordinates(
    outer: OuterMap, points: Sequence[Reals], bounds: Sequence[Reals], bits: int
) -> list[Reals]:
    """Return bounds on the errors of q, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        points: x.
        bounds: of x, q̇, p and the rest.
        bits: binary digits of the numbers.
    """
    if not isinstance(outer, CurvilinearMap | SphereMap):
        return list(bounds)
    x, δ, unit = [np.abs(row) for row in points], bounds[: len(points)], _ROUNDINGS * 2.0**-bits
    ρ, across = np.hypot(x[0], x[1]), np.hypot(δ[0], δ[1])
    z, δz = (x[2], δ[2]) if len(points) == 3 else (np.zeros_like(ρ), np.zeros_like(ρ))
    turned = (z * across + ρ * δz) / np.hypot(ρ, z) ** 2
    lost = ~(_LOST * across < ρ) & ~np.isnan(points[0])
    moved = {
        AZIMUTH: np.where(lost, np.inf, (x[0] * δ[1] + x[1] * δ[0]) / ρ**2), FROM_AXIS: across, HEIGHT: δz,
        FROM_CENTRE: np.hypot(across, δz), COLATITUDE: turned, LATITUDE: turned,
    }  # fmt: skip
    values = _values(outer, points)
    q = [moved[role] + unit * np.abs(value) for role, value in zip(outer.roles, values, strict=True)]
    return [*q, *_unknown(outer, bounds[len(points) :], lost, np.inf)]
