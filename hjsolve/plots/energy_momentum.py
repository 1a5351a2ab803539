"""An energy–momentum map on axes of matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hjsolve.energy_momentum.energy_momentum_map import EnergyMomentumMap
from hjsolve.errors import InvalidInputError
from hjsolve.plots import style
from hjsolve.reports.drawings.contours import spread_levels
from hjsolve.reports.drawings.energy_momentum_figure import MapGrid, action_values, in_line, map_grid, visible
from hjsolve.reports.formulas.names import name_box

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import ListedColormap

_FILLS = ("#e4ebf2", "#f7e6e2", "#e9e9ea", "#c6d5e3", "#eec5bc", "#cfd0d2")
_LINES: dict[str, style.Style] = {
    "relative equilibrium": style.CURVE, "separatrix": style.EDGE, "edge of escape": style.ENERGY,
    "end of the domain": {"color": style.RULE, "linewidth": 1.0, "zorder": 1},
}  # fmt: skip
_LEVELS = 9


def plotted_map(found: EnergyMomentumMap, ax: Axes | None) -> Axes:
    """Draw a map: regions filled, with their names in a legend, critical curves, equal actions, the motion.

    Args:
        ax: matplotlib's axes; None for new ones.

    Returns:
        The axes.

    Raises:
        InvalidInputError: axes that are none.
        MissingExtraError: matplotlib is not installed.
    """
    if ax is not None and not hasattr(ax, "plot"):
        raise InvalidInputError(f"plot: ax must be axes of matplotlib, not {type(ax).__name__}")
    with style.drawing() as pyplot:
        ax = pyplot.figure().add_subplot() if ax is None else ax
        grid = map_grid(found)
        if grid is not None:
            _regions(ax, grid)
            x, y, values = action_values(found)
            for J in values.values():
                if levels := spread_levels(J, _LEVELS):
                    ax.contour(x, y, np.ma.masked_invalid(J), levels=levels, colors=style.BLUE, linewidths=0.6)
        for curve in found.curves:
            ax.plot(*visible(found, grid, curve), **_LINES[curve.kind])
        for value in found.isolated:
            ax.plot([value.x], [value.y], **style.RING)
        if found.point is not None:
            ax.plot(*([v] for v in found.point), **style.DOT)
        ax.set_xlim(*found.window[0])
        ax.set_ylim(*found.window[1])
        ax.set_xlabel(style.mathematics(name_box(found.x)))
        ax.set_ylabel(style.mathematics(name_box(found.y)))
    return ax


def _regions(ax: Axes, grid: MapGrid) -> None:
    for k, region in enumerate(grid.regions):
        column, row = (int(np.argmin(np.abs(v - p))) for v, p in zip((grid.x, grid.y), region.example))
        mask = np.where(grid.numbers == grid.numbers[row, column], 1.0, np.nan)
        ax.pcolormesh(grid.x, grid.y, np.ma.masked_invalid(mask), cmap=_one_colour(_FILLS[k]), zorder=0)
        ax.fill([], [], facecolor=_FILLS[k], edgecolor=style.INK, linewidth=0.6, label=in_line(region))
    ax.legend(loc="best", fontsize=8, frameon=True, framealpha=0.85, edgecolor="none")


def _one_colour(colour: str) -> ListedColormap:
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour])
