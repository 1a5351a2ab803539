"""Plots: a motion on axes of matplotlib, and moving (extra report).

In: motions, solutions and batches. Out: matplotlib's axes and animations, drawn with what the reports draw, in their
colours.
Read ``draw.py`` first; ``style.py`` has the colours, ``animation.py`` the moving point.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hjsolve.plots.animation import animated as animated
    from hjsolve.plots.batch import plotted_batch as plotted_batch
    from hjsolve.plots.draw import plotted as plotted
    from hjsolve.plots.draw import plotted_solution as plotted_solution
    from hjsolve.plots.energy_momentum import plotted_map as plotted_map
    from hjsolve.plots.ladder import plotted_levels as plotted_levels
    from hjsolve.plots.wavefronts import plotted_wavefronts as plotted_wavefronts

_HOMES = {
    "animated": "animation", "plotted": "draw", "plotted_batch": "batch", "plotted_levels": "ladder",
    "plotted_map": "energy_momentum",
    "plotted_solution": "draw", "plotted_wavefronts": "wavefronts",
}  # fmt: skip
__all__ = [
    "animated",
    "plotted",
    "plotted_batch",
    "plotted_levels",
    "plotted_map",
    "plotted_solution",
    "plotted_wavefronts",
]


def __getattr__(name: str) -> Any:
    """Import what draws when it is first used (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'hjsolve.plots' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
