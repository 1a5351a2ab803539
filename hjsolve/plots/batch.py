"""Many orbits on axes: one of their numbers against another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hjsolve.ensembles.batch import Batch
from hjsolve.errors import InvalidInputError
from hjsolve.plots import style
from hjsolve.reports.formulas.layout import Script
from hjsolve.reports.formulas.names import name_box

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from hjsolve.arithmetic.number_types import Reals

_LETTERS = {"actions": "J", "frequencies": "Omega", "periods": "T", "angles": "w"}
_VISIBLE = 300
"""An error is drawn where it is more than this part of an axis."""
_SINGLE = 2000
"""Up to so many orbits the points are large."""


def plotted_batch(batch: Batch, x: str | None, y: str | None, colour: str | None, ax: Axes | None) -> Axes:
    """Draw one column of a batch against another, a point an orbit.

    Args:
        batch: of orbits; a lazy one is computed.
        x, y: names of columns; None for the first two.
        colour: name of the column that gives the points their colour.
        ax: matplotlib's axes; None for new ones.

    Returns:
        The axes.

    Raises:
        InvalidInputError: names that are no columns of numbers, or axes that are none.
        MissingExtraError: matplotlib is not installed.
    """
    if ax is not None and not hasattr(ax, "plot"):
        raise InvalidInputError(f"plot: ax must be axes of matplotlib, not {type(ax).__name__}")
    batch = batch.compute()
    names = [n for n in batch.columns if not n.startswith("error.") and n not in ("status", "recomputed")]
    chosen = [name for name in names if name not in (x, y)]
    x = x if x is not None else chosen.pop(0) if chosen else None
    y = y if y is not None else chosen.pop(0) if chosen else None
    if x is None or y is None:
        raise InvalidInputError("plot: the batch has one column only; want more than one number of each orbit")
    for name in (x, y, *((colour,) if colour is not None else ())):
        if name not in names:
            raise InvalidInputError(f"plot: {name!r} is not a numeric column of this batch; it has {', '.join(names)}")
    values = [np.ravel(batch.columns[name]) for name in (x, y)]
    errors = [np.ravel(batch.columns[f"error.{name}"]) for name in (x, y)]
    there = np.atleast_1d(np.isfinite(values).all(axis=0))
    with style.drawing() as pyplot:
        ax = pyplot.subplots()[1] if ax is None else ax
        size = 14 if there.sum() <= _SINGLE else 2
        look: style.Style = {"color": style.BLUE}
        if colour is not None:
            look = {"c": np.ravel(batch.columns[colour])[there], "cmap": "viridis"}
        drawn = ax.scatter(values[0][there], values[1][there], s=size, linewidths=0, zorder=3, **look)
        if there.any():
            _error_bars(ax, [v[there] for v in values], [e[there] for e in errors])
        if colour is not None:
            ax.figure.colorbar(drawn, ax=ax, label=_label(colour))
        ax.set_xlabel(_label(x))
        ax.set_ylabel(_label(y))
        if missing := int((~there).sum()):
            ax.set_title(f"{missing} of {len(there)} orbits omitted (no values)", fontsize=9.5, color=style.SOFT)
    return ax


def _error_bars(ax: Axes, values: list[Reals], errors: list[Reals]) -> None:
    """Draw the errors that can be seen."""
    seen = np.any([e * _VISIBLE > np.ptp(v) for v, e in zip(values, errors)], axis=0) & np.isfinite(errors).all(axis=0)
    seen &= np.any([e > 0 for e in errors], axis=0)
    if seen.any() and np.ptp(values[0]) + np.ptp(values[1]) > 0:
        (x, y), (dx, dy) = ([v[seen] for v in group] for group in (values, errors))
        ax.errorbar(x, y, xerr=dx, yerr=dy, fmt="none", ecolor=style.SOFT, elinewidth=0.8, zorder=2)


def _label(column: str) -> str:
    quantity, name, *side = column.split(".")
    if quantity in _LETTERS:
        return style.mathematics(Script(name_box(_LETTERS[quantity]), name_box(name)))
    return " ".join([style.mathematics(name_box(name)), *side])
