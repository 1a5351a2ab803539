"""Semiclassical levels on axes of matplotlib: a ladder for each set of kinds and of ignorable quantum numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hjsolve.errors import InvalidInputError
from hjsolve.plots import style
from hjsolve.semiclassical.level import Level, Levels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HALF = 0.35
"""Half the length of a rung, in columns."""


def plotted_levels(levels: Levels, ax: Axes | None) -> Axes:
    """Draw levels as a ladder.

    Args:
        levels: what is drawn.
        ax: matplotlib's axes; None for new ones.

    Returns:
        The axes; levels next to a separatrix are dashed.

    Raises:
        InvalidInputError: axes that are none.
        MissingExtraError: matplotlib is not installed.
    """
    if ax is not None and not hasattr(ax, "plot"):
        raise InvalidInputError(f"plot: ax must be axes of matplotlib, not {type(ax).__name__}")
    columns = sorted({_column(level) for level in levels})
    with style.drawing() as pyplot:
        ax = pyplot.figure().add_subplot() if ax is None else ax
        for level in levels:
            k, E = columns.index(_column(level)), float(level.energy.value)
            dashes = "--" if level.near_separatrix else "-"
            ax.plot([k - _HALF, k + _HALF], [E, E], **{**style.CURVE, "linestyle": dashes})
        ax.set_xticks(range(len(columns)), ["\n".join(column) for column in columns], fontsize=8)
        ax.set_ylabel("$E$")
    return ax


def _column(level: Level) -> tuple[str, ...]:
    """Return the words under the ladder of a level: numbers of ignorable angles, and kinds that are not librations."""
    words = []
    for name, kind in level.kinds.items():
        if kind == "ignorable":
            words.append(f"{name} {level.numbers[name]:+d}")
        elif kind == "rotation":
            words.append(f"{name} rotates {'+' if level.numbers[name] > 0 else '-'}")
    return tuple(words) or ("librates",)
