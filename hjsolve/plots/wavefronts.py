"""Wavefronts, orbits and caustics on axes of matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hjsolve.errors import InvalidInputError
from hjsolve.plots import style
from hjsolve.rays.families import Wavefronts
from hjsolve.reports.drawings.wavefront_figure import one_sheet, plane_axes, points_shown
from hjsolve.reports.formulas.names import name_box

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_ORBITS = 16


def plotted_wavefronts(family: Wavefronts, ax: Axes | None) -> Axes:
    """Draw a family: lines of W, orbits, caustics.

    Args:
        family: from ``wavefronts``.
        ax: matplotlib's axes; None for new ones.

    Returns:
        The axes.

    Raises:
        InvalidInputError: the coordinates lie in no plane, or axes that are none.
        MissingExtraError: matplotlib is not installed.
    """
    if ax is not None and not hasattr(ax, "plot"):
        raise InvalidInputError(f"plot: ax must be axes of matplotlib, not {type(ax).__name__}")
    axes = plane_axes(family.motion.solution.system)
    if not axes:
        raise InvalidInputError('plot: these coordinates have no plane; declare it, System(…, place={"x": …, "y": …})')
    with style.drawing() as pyplot:
        ax = pyplot.figure().add_subplot() if ax is None else ax
        for front in family.fronts:
            x, y = points_shown(family, front)
            strong = one_sheet(family, front) if family.family == "constants" else np.ones(len(x), dtype=bool)
            ax.plot(x, y, **{**style.LEVEL, "alpha": 0.3})
            ax.plot(np.where(strong, x, np.nan), y, **style.LEVEL)
        step = -(-len(family.orbits) // _MOST_ORBITS)
        for orbit in family.orbits[step::step]:
            ax.plot(*points_shown(family, orbit), **style.FAINT)
        ax.plot(*points_shown(family, family.orbits[0]), **style.MOTION)
        for caustic in family.caustics:
            ax.plot(*points_shown(family, caustic), **style.CURVE)
        ax.set_xlabel(style.mathematics(name_box(axes[0])))
        ax.set_ylabel(style.mathematics(name_box(axes[1])))
        ax.set_aspect("equal")
        return ax
