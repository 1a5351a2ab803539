"""Colours and lines of the plots, those of the reports; matplotlib is asked for here."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from hjsolve.errors import MissingExtraError
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.formulas.layout import Box

INK, SOFT, RULE, BLUE, RED = "#22262b", "#666b72", "#d9d5cc", "#2f5f8f", "#b8402a"
Style = dict[str, Any]
"""Keywords of a line or a patch of matplotlib."""
MOTION: Style = {"color": RED, "linewidth": 2.0, "solid_joinstyle": "round", "solid_capstyle": "round", "zorder": 4}
FAINT: Style = {**MOTION, "linewidth": 1.0, "alpha": 0.35, "zorder": 3}
LEVEL: Style = {"color": BLUE, "linewidth": 1.0, "solid_capstyle": "round", "zorder": 2}
EDGE: Style = {"color": BLUE, "linewidth": 1.1, "linestyle": (0, (5, 4)), "zorder": 2}
CURVE: Style = {"color": INK, "linewidth": 1.6, "zorder": 3}
ENERGY: Style = {"color": SOFT, "linewidth": 1.0, "linestyle": (0, (2, 3)), "zorder": 2}
AREA: Style = {"color": RED, "alpha": 0.11, "linewidth": 0}
DOT: Style = {
    "color": RED, "marker": "o", "markersize": 6, "markeredgecolor": "white", "linestyle": "none", "zorder": 6,
}  # fmt: skip
RING: Style = {**DOT, "color": "white", "markeredgecolor": RED, "markeredgewidth": 1.6}
GRID: Style = {"color": RULE, "linewidth": 0.5, "rstride": 8, "cstride": 4, "zorder": 1}
CENTRE: Style = {"color": INK, "marker": "o", "markersize": 5, "linestyle": "none", "zorder": 5}

_SETTINGS: dict[Any, object] = {
    "axes.edgecolor": INK, "axes.labelcolor": INK, "axes.spines.top": False, "axes.spines.right": False,
    "axes.linewidth": 0.8, "axes.labelsize": 12, "xtick.color": SOFT, "ytick.color": SOFT, "xtick.labelsize": 9.5,
    "ytick.labelsize": 9.5, "font.family": "sans-serif", "mathtext.fontset": "stix",
    "figure.constrained_layout.use": True, "figure.figsize": (5.2, 4.0),
}  # fmt: skip


@contextmanager
def drawing() -> Iterator[ModuleType]:
    """Give ``matplotlib.pyplot``, with our settings for what is made inside.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        import matplotlib as mpl
        from matplotlib import pyplot as plt
    except ImportError as missing:
        raise MissingExtraError('plots need matplotlib: pip install "hjsolve[report]"') from missing
    with mpl.rc_context(_SETTINGS):
        yield plt


def mathematics(box: Box) -> str:
    """Write a name or formula for a label.

    Args:
        box: laid out as in the reports.
    """
    return f"${latex_of(box)}$"
