"""Points expressed in polar, cylindrical or spherical coordinates, in numbers, with bounds on their errors.

To first order an error (δx, δy, δz) of the point moves ρ by (|x| δx + |y| δy)/ρ, φ by (|x| δy + |y| δx)/ρ², r by
Σ |xᵢ| δxᵢ/r and θ by (|z| δρ + ρ δz)/r². Where δ⊥ = hypot(δx, δy) is more than a part of ρ nothing is known of φ and of
the velocities that it turns; on the axis itself they are NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hjsolve.arithmetic.number_types import Mpf, Numbers, Reals
from hjsolve.coordinates.charts.curvilinear import (
    AZIMUTH,
    COLATITUDE,
    FROM_AXIS,
    FROM_CENTRE,
    HEIGHT,
    LATITUDE,
    CurvilinearMap,
)

LOST = 8
"""Where the error across the axis is more than its 8th part of the distance from it, nothing is known of the angle."""
ROUNDINGS = 8
_TURNED = (AZIMUTH, FROM_AXIS, COLATITUDE, LATITUDE)
"""Coordinates whose rates are not known on the axis."""


def told_curvilinear(outer: CurvilinearMap, found: Sequence[Numbers]) -> list[Numbers]:
    """Return q, q̇, p and the rest of points, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        found: rows of numbers: x, then q̇ and p of the user's coordinates, then anything.
    """
    n = len(outer.roles)
    x, rates, p = found[:n], list(found[n : 2 * n]), list(found[2 * n : 3 * n])
    if x[0].dtype == object:
        rows = [_in_many_digits(outer, point) for point in zip(*x, strict=True)]
        q = [np.array(column, dtype=object) for column in zip(*rows, strict=True)]
    else:
        q = _values(outer.roles, x)
    axis = np.array([not a and not b for a, b in zip(x[0], x[1], strict=True)], dtype=bool)
    for k, role in enumerate(outer.roles):
        if role == AZIMUTH:
            q[k] = np.where(axis, np.nan, q[k])
        if role in _TURNED:
            rates[k] = np.where(axis, np.nan, rates[k])
            p[k] = p[k] if role == AZIMUTH else np.where(axis, np.nan, p[k])
    return [*q, *rates, *p, *found[3 * n :]]


def _values(roles: Sequence[str], x: Sequence[Any]) -> list[Reals]:
    ρ = np.hypot(x[0], x[1])
    height = x[2] if len(x) == 3 else np.zeros_like(ρ)
    found = {
        AZIMUTH: np.arctan2(x[1], x[0]), FROM_AXIS: ρ, HEIGHT: height, FROM_CENTRE: np.hypot(ρ, height),
        COLATITUDE: np.arctan2(ρ, height), LATITUDE: np.arctan2(height, ρ),
    }  # fmt: skip
    return [found[role] for role in roles]


def _in_many_digits(outer: CurvilinearMap, x: Sequence[Mpf]) -> list[Mpf]:
    c = x[0].context
    ρ, height = c.hypot(x[0], x[1]), x[2] if len(x) == 3 else c.zero
    found = {
        AZIMUTH: lambda: c.atan2(x[1], x[0]), FROM_AXIS: lambda: ρ, HEIGHT: lambda: height,
        FROM_CENTRE: lambda: c.hypot(ρ, height), COLATITUDE: lambda: c.atan2(ρ, height),
        LATITUDE: lambda: c.atan2(height, ρ),
    }  # fmt: skip
    return [found[role]() for role in outer.roles]


def bounds_curvilinear(
    outer: CurvilinearMap, points: Sequence[Reals], bounds: Sequence[Reals], bits: int
) -> list[Reals]:
    """Return bounds on the errors of q, q̇, p and the rest.

    Args:
        outer: how points are tied to the user's coordinates.
        points: x.
        bounds: of x, q̇, p and the rest.
        bits: binary digits of the numbers.
    """
    n, unit = len(outer.roles), ROUNDINGS * 2.0**-bits
    x, δ = [np.abs(row) for row in points], bounds[:n]
    ρ, across = np.hypot(x[0], x[1]), np.hypot(δ[0], δ[1])
    z, δz = (x[2], δ[2]) if n == 3 else (np.zeros_like(ρ), np.zeros_like(ρ))
    r = np.hypot(ρ, z)
    turned = (z * across + ρ * δz) / r**2
    lost = ~(LOST * across < ρ) & ~np.isnan(points[0])
    moved = {
        AZIMUTH: np.where(lost, np.inf, (x[0] * δ[1] + x[1] * δ[0]) / ρ**2), FROM_AXIS: across, HEIGHT: δz,
        FROM_CENTRE: np.hypot(across, δz), COLATITUDE: turned, LATITUDE: turned,
    }  # fmt: skip
    values = _values(outer.roles, points)
    q = [moved[role] + unit * np.abs(value) for role, value in zip(outer.roles, values, strict=True)]
    rates, p = list(bounds[n : 2 * n]), list(bounds[2 * n : 3 * n])
    for k, role in enumerate(outer.roles):
        if role in _TURNED:
            rates[k] = np.where(lost, np.inf, rates[k])
            p[k] = p[k] if role == AZIMUTH else np.where(lost, np.inf, p[k])
    return [*q, *rates, *p, *bounds[3 * n :]]
