"""E and λ of isolated motions, and whether a motion with some E and λ is one of them."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.interval import Interval
from hjsolve.two_point.central.apsidal_arcs import ApsidalBoxes, constants_of
from hjsolve.two_point.central.proved_search import APSIDAL, AT_INNER, IsolatedMotion, RadialProblem

_PASSES = 6


def energy_and_momentum(problem: RadialProblem, chart: int, at: tuple[float, float]) -> tuple[float, float]:
    """Return E and λ of parameters.

    Args:
        problem: what is joined.
        chart: of the parameters.
        at: their values.
    """
    first, second = (Interval(np.array([[x]]), np.array([[x]])) for x in at)
    grid = problem.grids[0]
    if chart == APSIDAL:
        low, high = grid.r[[grid.inner, grid.outer]] ** 2
        E, λ2 = constants_of(problem.square, ApsidalBoxes(first, second, float(low), float(high)))
        return float(E), float(np.sqrt(max(λ2, 0.0)))
    node = grid.inner if chart == AT_INNER else grid.outer
    V = float(np.asarray(grid.at_nodes.V.low)[node])
    return V + at[0] ** 2 + (at[1] / grid.r[node]) ** 2, at[1]


def is_solved_by(problem: RadialProblem, motion: IsolatedMotion, E: float, λ: float) -> bool:
    """Whether a motion with these constants is the one that was isolated: its parameters are in its box.

    Args:
        problem: what is joined.
        motion: the box.
        E, λ: of the motion.
    """
    x = np.array(motion.at)
    for _ in range(_PASSES):
        here = np.array(energy_and_momentum(problem, motion.chart, (float(x[0]), float(x[1]))))
        steps = 1e-6 * np.maximum(x, 1e-3)
        columns = []
        for k in (0, 1):
            moved = x.copy()
            moved[k] += steps[k]
            columns.append(
                (np.array(energy_and_momentum(problem, motion.chart, (moved[0], moved[1]))) - here) / steps[k]
            )
        x = np.maximum(x + np.linalg.lstsq(np.array(columns).T, np.array([E, λ]) - here, rcond=None)[0], 0.0)
    tolerance = 1e-7 * (1 + np.abs(x))
    return bool(np.all((x >= np.array(motion.low) - tolerance) & (x <= np.array(motion.high) + tolerance)))
