"""Stars in cylindrical coordinates, for a solution in x, y, z: each is turned about the axis to y = 0.

There x = R, y = 0, ẋ = v_R, ẏ = v_T and ż = v_z are the doubles that were given, and nothing is rounded. Where V is
symmetric about the axis only the angle of the azimuth is another one, by the azimuth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Reals
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.charts.outer_map import AZIMUTH, FROM_AXIS, HEIGHT, flat_map
from hjsolve.errors import of_kind, required
from hjsolve.motion.velocity_frame import ORTHONORMAL
from hjsolve.separation import Zero, is_zero
from hjsolve.solution.quadratures import Solution

_ROUNDING = 2.0**-50
"""Of an angle that is added to another, and brought back by whole turns: four roundings, of 2⁻⁵³ of π or the azimuth,
are below 2⁻⁵⁰ of 1 + the azimuth."""


@dataclass(frozen=True)
class AboutAxis:
    """The user's names of R, φ and z, and of x, y, z.

    Attributes:
        radius, azimuth, height: of the system as given.
        axes: of the same in space.
        turned: the separated coordinate whose angle the azimuth is added to; None where there is none.
    """

    radius: str
    azimuth: str
    height: str
    axes: tuple[str, ...]
    turned: str | None

    def in_space(
        self, q: Mapping[str, Reals], velocity: Mapping[str, Reals]
    ) -> tuple[dict[str, Reals], dict[str, Reals]]:
        """Return places and velocities in x, y, z, of the stars turned to y = 0.

        Args:
            q: coordinate → places.
            velocity: coordinate → velocities along its unit vector.
        """
        x, y, z = self.axes
        return (
            {x: q[self.radius], y: np.zeros_like(q[self.radius]), z: q[self.height]},
            {x: velocity[self.radius], y: velocity[self.azimuth], z: velocity[self.height]},
        )

    def turn_back(self, angle: Reals, error: Reals, azimuth: Reals) -> None:
        """Add the azimuth to an angle, in place, between −π and π.

        Args:
            angle: of the turned stars.
            azimuth: as it was given.
        """
        angle += azimuth
        angle -= 2 * np.pi * np.round(angle / (2 * np.pi))
        error += _ROUNDING * (1 + np.abs(azimuth))


def about_axis(solution: Solution, frame: str) -> AboutAxis | None:
    """Return how stars are turned; None where starts are in the coordinates of the map as they are.

    Args:
        solution: in coordinates that were found.
        frame: of the velocities.
    """
    outer = None if solution.chart is None else solution.chart.outer
    if solution.chart is None or not isinstance(outer, CurvilinearMap):
        return None
    names = dict(zip(outer.roles, (c.name for c in solution.chart.original.coordinates), strict=True))
    if set(names) != {FROM_AXIS, AZIMUTH, HEIGHT} or frame != ORTHONORMAL:
        return None
    x, y = (c.symbol for c in outer.space.coordinates[:2])
    V = outer.space.potential
    if not isinstance(is_zero(x * sp.diff(V, y) - y * sp.diff(V, x)), Zero):
        return None
    own = solution.chart.coordinates[-1]
    standing = solution.chart.frame == sp.eye(3) and solution.chart.origin[0] == 0 == solution.chart.origin[1]
    turns = standing and solution.system.coordinate(own).domain.kind == "angle"
    axes = tuple(c.name for c in outer.space.coordinates)
    return AboutAxis(names[FROM_AXIS], names[AZIMUTH], names[HEIGHT], axes, own if turns else None)


def solved_in_space(solution: Solution) -> Solution:
    """Return a solution whose chart is tied to x, y, z.

    Args:
        solution: of a system in cylindrical coordinates, solved in others.
    """
    chart = required(solution.chart)
    outer = of_kind(chart.outer, CurvilinearMap)
    return replace(solution, chart=replace(chart, original=outer.space, outer=flat_map(outer.space)))
