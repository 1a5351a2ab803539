"""A motion that moves: its path, and the place it has reached, at equal steps of time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hjsolve.arguments import refuse_other
from hjsolve.arithmetic.number_types import Reals
from hjsolve.errors import InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.plots import style
from hjsolve.plots.draw import plotted
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.drawings.cartesian_picture import embedding, path_of

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_MOST_FRAMES = 5000


def animated(motion: Motion, seconds: float, frames: int, ax: Axes | None) -> FuncAnimation:
    """Move a point along the orbit of a motion; of one coordinate, along its curve in the phase plane.

    Args:
        seconds: how long it takes to show.
        frames: pictures, at equal steps of the motion's own time.
        ax: matplotlib's axes; None for new ones.

    Returns:
        matplotlib's ``FuncAnimation``: keep it, show it with ``to_jshtml()``, or ``save("orbit.gif")``.

    Raises:
        InvalidInputError: a length or a number of pictures that makes no sense.
        MissingExtraError: matplotlib is not installed.
    """
    refuse_other(frames, int, "frames", "a whole number is needed, such as 240")
    if not (seconds > 0 and 2 <= frames <= _MOST_FRAMES):
        raise InvalidInputError(f"animate: seconds > 0 and 2 to {_MOST_FRAMES} frames, not {seconds} and {frames}")
    motion = motion.as_solved
    with style.drawing():
        from matplotlib.animation import FuncAnimation

        flat = embedding(motion.solution.system).shape == "line"
        axes = plotted(motion, "phase" if flat else "orbit", None, ax)
        path = _places(motion, frames, flat, solid=hasattr(axes, "get_zlim"))
        point: Any  # in three dimensions a class without types
        (point,) = axes.plot(*([float(x[0])] for x in path), **style.DOT)

        def show(k: int) -> tuple[Line2D]:
            point.set_data([path[0][k]], [path[1][k]])
            if len(path) == 3:
                point.set_3d_properties([path[2][k]])
            return (point,)

        figure: Any = axes.figure  # or a part of one
        return FuncAnimation(figure, show, frames=frames, interval=1000 * seconds / frames, blit=False)


def _places(motion: Motion, frames: int, flat: bool, *, solid: bool) -> tuple[Reals, ...]:
    """Return where the point is in each picture."""
    start, stop, closed = orbit_paths.span(motion)
    if not closed:
        t, _ = orbit_paths.times(motion)
        stop = float(t[orbit_paths.few_cycles(motion, t)][-1])
    state = motion.at(np.linspace(start, stop, frames, endpoint=not closed))
    if flat:
        name = motion.solution.system.coordinates[0].name
        return np.asarray(state.q[name], float), np.asarray(state.p[name], float)
    where = embedding(motion.solution.system)
    path = path_of(where, state)
    return path[: 3 if solid else 2]
