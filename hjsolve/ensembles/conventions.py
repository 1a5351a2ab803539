"""Actions and angles of axially symmetric systems as galpy counts them.

    here                                              galpy
    angles in (−π, π]                                 in [0, 2π)
    vertical angle 0 at the lower turning point       0 where the orbit crosses the plane z = 0 upward
    L_z = 0 exactly: the radial coordinate goes       J_r, Ω_r, θ_r are those of L_z → 0: half the action, twice
    through the axis, from −R to R and back           the frequency, θ_r = 2θ − π
    L_z = 0 exactly: an orbit through the poles       J_z ≥ 0, Ω_z ≥ 0
    has the sign of its turning in J and Ω

(docs/conventions.md; compared with galpy 1.12 by numbers.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.coordinates.charts.curvilinear import curvilinear_map
from hjsolve.coordinates.charts.outer_map import AZIMUTH, COLATITUDE, FROM_AXIS, FROM_CENTRE, HEIGHT, LATITUDE
from hjsolve.errors import InvalidInputError, InvalidSystemError
from hjsolve.solution.quadratures import Solution

PROGRAMS = ("galpy", "agama")
"""They count alike."""
_ROUNDING = 2.0**-49
"""Over π, of an angle that is shifted by a multiple of π and reduced: two roundings of at most 2π · 2⁻⁵³ are 2⁻⁵¹ of
π."""
_CHARTS = ("spherical", "prolate spheroidal", "oblate spheroidal")


@dataclass(frozen=True)
class AxialRoles:
    """Which coordinates of an axially symmetric system are the radial, the vertical and the azimuthal one.

    Attributes:
        radial, vertical, azimuth: names of separated coordinates.
        downward: 1 where z falls as the vertical coordinate grows (an angle from the pole), −1 where it grows.
    """

    radial: str
    vertical: str
    azimuth: str
    downward: int


def axial_roles(solution: Solution) -> AxialRoles | None:
    """Return the roles of the coordinates; None where the system is not known to be symmetric about the z axis."""
    chart = solution.chart
    if chart is None:
        return _roles_as_given(solution)
    if chart.kind not in _CHARTS or chart.frame[:, 2] != sp.Matrix([0, 0, chart.frame[2, 2]]):
        return None
    if not chart.frame[2, 2].is_positive:
        return None
    radial, vertical, azimuth = chart.coordinates
    falls = chart.place[2].has(sp.cos(chart.symbols[1]))
    return AxialRoles(radial, vertical, azimuth, 1 if falls else -1)


def _roles_as_given(solution: Solution) -> AxialRoles | None:
    system = solution.system
    try:
        curved = curvilinear_map(system) if len(system.coordinates) == 3 else None
    except InvalidSystemError:
        return None
    if curved is None:
        return None
    names = dict(zip(curved.roles, (c.name for c in system.coordinates), strict=True))
    if FROM_AXIS in names:
        return AxialRoles(names[FROM_AXIS], names[HEIGHT], names[AZIMUTH], -1)
    colatitude = COLATITUDE in names
    vertical = names[COLATITUDE] if colatitude else names[LATITUDE]
    return AxialRoles(names[FROM_CENTRE], vertical, names[AZIMUTH], 1 if colatitude else -1)


def in_conventions_of(program: object, columns: dict[str, Any], roles: AxialRoles | None) -> dict[str, Any]:
    """Return the columns of a batch as another program counts its actions and angles.

    Args:
        program: ``galpy`` or ``agama``.
        columns: of the batch; arrays of numpy.

    Raises:
        InvalidInputError: another program, coordinates whose roles are not known, or orbits with L_z = 0 of which it
            is not known how their coordinates go through the axis.
    """
    if program not in PROGRAMS:
        raise InvalidInputError(f'in_conventions: "galpy" and "agama" are known, not {program!r}')
    if roles is None:
        raise InvalidInputError(
            "in_conventions: it is not known which coordinates are the radial and the vertical one; solve the system "
            'in x, y, z, or in cylindrical or spherical coordinates, with coordinates="find"'
        )
    result = {name: np.array(column) for name, column in columns.items()}
    _radial(result, roles)
    _vertical(result, roles)
    for name in (roles.radial, roles.vertical, roles.azimuth):
        if (column := f"angles.{name}") in result:
            result[column] %= 2 * np.pi
            result[f"error.{column}"] += _ROUNDING * np.pi
    return result


def _at_no_spin(columns: dict[str, Any], roles: AxialRoles) -> Any:
    """Return orbits with L_z = 0 exactly: they have no azimuthal action."""
    name = next((n for n in (f"actions.{roles.azimuth}", f"frequencies.{roles.azimuth}") if n in columns), None)
    if name is None:
        raise InvalidInputError('in_conventions: orbits with L_z = 0 count otherwise; add "actions" to want')
    return np.isnan(columns[name]) & (columns["status"] == 0)


def _radial(columns: dict[str, Any], roles: AxialRoles) -> None:
    none = _at_no_spin(columns, roles)
    if not none.any():
        return
    if f"turning_points.{roles.radial}.lower" not in columns or f"actions.{roles.vertical}" not in columns:
        raise InvalidInputError(
            'in_conventions: some orbits have L_z = 0; add "actions" and "turning_points" to want, which tell whether '
            "they go through the axis"
        )
    through = none & (columns[f"turning_points.{roles.radial}.lower"] < 0)
    for quantity, factor in (("actions", 0.5), ("periods", 0.5), ("frequencies", 2.0), ("angles", 2.0)):
        for prefix in ("", "error."):
            if (name := f"{prefix}{quantity}.{roles.radial}") in columns:
                columns[name][through] *= factor
    if (name := f"angles.{roles.radial}") in columns:
        columns[name][through] -= np.pi


def _vertical(columns: dict[str, Any], roles: AxialRoles) -> None:
    if f"actions.{roles.vertical}" in columns:
        backward = columns[f"actions.{roles.vertical}"] < 0
        for quantity in ("actions", "frequencies", "angles"):
            if (name := f"{quantity}.{roles.vertical}") in columns:
                columns[name][backward] *= -1
    if (name := f"angles.{roles.vertical}") in columns:
        columns[name] += roles.downward * np.pi / 2
