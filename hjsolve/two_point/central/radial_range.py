"""Bounds within which all motions of a question about a centre of force lie: of energy, distance and pericentre.

With B = 2(E − V) − rV′ ≥ 2E − M on 0 < r ≤ r_high, f = r²(E − V) rises there, and a path without the arc beyond r_high
takes no longer than 2 ∫ (2/B) dσ ≤ (4/(2E − M)) r_high √(E − V(r_high)) in units of √(m/2), which falls with E from
E ≥ 2V(r_high) − M/2 on: above some energy it is too fast. Below it, a mass that comes back to r_high in time does not
go farther than its greatest speed allows.
"""

from __future__ import annotations

import numpy as np
import sympy as sp

from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.sign_at_infinity import sign_beyond
from hjsolve.lowering import lower
from hjsolve.two_point.central.apsidal_arcs import SquarePotential
from hjsolve.two_point.central.proved_search import RadialProblem
from hjsolve.two_point.central.radial_grid import CentralCell, RadialGrid, RadialPotential, cells_about, innermost
from hjsolve.two_point.one_freedom.line_branches import branches

_RATIOS = (1.06, 1.02, 1.005)
_DOUBLINGS = 60
_LEAST = 0.03
"""λ below which only the parameters of ``radial_arcs`` serve, in units of that of a circular orbit."""


def radial_problem(
    r: sp.Symbol, V: sp.Expr, distances: tuple[float, float], time: float, angles: Reals, turns: int
) -> RadialProblem | None:
    """Bound what is asked; None where no bounds are found.

    Args:
        r: the distance.
        V: the potential.
        distances: of q0 and of q1.
        time: T/√(m/2).
        angles: that may be swept.
        turns: the greatest number of whole turns.
    """
    potential = RadialPotential(r, V)
    low, high = min(distances), max(distances)
    begin = innermost(low)
    centre = potential.at_centre(begin)
    near = cells_about(potential, (low, high), 2 * high, _RATIOS[1], centre)
    top = _top(potential, near, time)
    if top is None:
        return None
    far = _farthest(potential, high, top, time)
    if far is None:
        return None
    settled = potential.never_turned_beyond(high, top)
    highest = top
    if not settled:
        late = _late(potential, high, far, time)
        if late is not None:
            settled, far = True, late
            highest = max(top, _highest(potential, high, far))
    if not _rises_from_centre(potential, centre, begin, highest):
        return None
    grids = tuple(cells_about(potential, (low, high), far, ratio, centre) for ratio in _RATIOS)
    steep = float(np.asarray(near.at_nodes.first.low)[near.inner])
    V_low = float(np.asarray(near.at_nodes.V.low)[near.inner])
    circular = low * np.sqrt(steep / 2) if steep > 0 else low * np.sqrt(max(top - V_low, 0.0)) / 4
    least = _LEAST * circular
    nearest = _nearest(grids[1], highest, least)
    passages = 2 * (turns + 1)
    return RadialProblem(
        potential=potential, grids=grids, square=SquarePotential(r, V), nearest=nearest, least=least, time=time,
        angles=angles, branches=tuple(branches(int(np.sign(distances[1] - distances[0])), passages)), beyond=passages,
        top=top, highest=highest, settled=settled,
    )  # fmt: skip


def _rises_from_centre(potential: RadialPotential, centre: CentralCell | None, distance: float, highest: float) -> bool:
    """Whether f rises from the centre to the first node at the highest energy, or V exceeds it there."""
    if centre is None:
        return potential.is_above(highest, distance)
    energy = Interval(np.array(highest), np.array(highest))
    return bool(centre.ratio(energy).high < 1) and bool(centre.slowest(energy) > 0)


def _top(potential: RadialPotential, grid: RadialGrid, time: float) -> float | None:
    """Return an energy from which on paths without the outer arc are too fast."""
    cells = grid.over_cells
    inside = slice(1, grid.outer)
    M = float(np.max(2 * np.asarray(cells.V.high)[inside] + np.asarray(cells.first.high)[inside]))
    at_centre = _centre_bound(potential, grid.centre, float(grid.r[1]))
    if at_centre is None or not np.isfinite(M):
        return None
    M = max(M, at_centre)
    V = float(np.asarray(grid.at_nodes.V.low)[grid.outer])
    V_high = float(max(np.asarray(grid.at_nodes.V.high)[k] for k in (grid.inner, grid.outer)))
    step = max(abs(V_high), (grid.r[grid.outer] / time) ** 2) * 0.05
    for _ in range(_DOUBLINGS):
        E = max(V_high, M / 2, 2 * V_high - M / 2) + step
        if 4 / (2 * E - M) * grid.r[grid.outer] * np.sqrt(E - V) * (1 + 1e-12) < time:
            return float(E)
        step *= 1.3
    return None


def _centre_bound(potential: RadialPotential, centre: CentralCell | None, distance: float) -> float | None:
    """Bound 2V + r V′ between the centre and the first node from above."""
    if centre is None:
        return 0.0 if potential.virial_is_negative(distance) else None
    if not centre.singular:
        return 2 * centre.highest + centre.steepness[1]
    return (2 - centre.steepness[1]) * centre.highest if centre.steepness[1] < 2 else None


def _farthest(potential: RadialPotential, high: float, top: float, time: float) -> float | None:
    """Return a distance from which a mass below the top cannot come back to the outer place in time."""
    far = 2 * high
    for _ in range(_DOUBLINGS):
        nodes = np.geomspace(high, far, 4000)
        least = float(np.min(potential.over(nodes[:-1], nodes[1:]).V.low))
        # dr/dt ≤ √(E − V) in these units of time
        needed = high + time / 2 * np.sqrt(max(top - least, 0.0)) * (1 + 1e-9)
        if needed <= far:
            return float(far)
        far = needed * 1.05
    return None


def _late(potential: RadialPotential, high: float, far: float, time: float) -> float | None:
    """Return a distance such that what turns beyond it comes back too late, whatever its energy; None if none is found.

    With apocentre a, λ² ≤ u_h (E − V_h) gives E ≤ P[u_h, a], so the way there and back takes at least
    2(r − r_h)/√(P[u_h, r²] − V_least), V_least being the least V beyond r_h.
    """
    r, V = potential.r, potential.V
    h = sp.Rational(high)
    V_h = sp.Rational(float(potential.over(np.array([high]), np.array([high])).V.low[0]))
    for k in range(12):
        start = max(far, 4.0) * 2.0**k
        nodes = np.geomspace(high, start, 4000)
        least = sp.Rational(float(np.min(potential.over(nodes[:-1], nodes[1:]).V.low)))
        gap = r**2 - h**2
        late = 4 * (r - h) ** 2 * gap - sp.Rational(time) ** 2 * (r**2 * V - h**2 * V_h - least * gap)
        rising = lower([sp.expand(potential.formulas[1])], [r])
        if sign_beyond(rising, [], 1, start) > 0 and sign_beyond(lower([sp.expand(late)], [r]), [], 1, start) > 0:
            return start
    return None


def _highest(potential: RadialPotential, high: float, far: float) -> float:
    """Return an energy that no motion with an apocentre between two distances exceeds: E ≤ P[u_h, a] ≤ max P′."""
    nodes = np.geomspace(high, far, 4000)
    cells = potential.over(nodes[:-1], nodes[1:])
    return float(np.max(np.asarray(cells.V.high) + np.asarray(cells.first.high) / 2)) * (1 + 1e-12) + 1e-12


def _nearest(grid: RadialGrid, top: float, least: float) -> float:
    """Return r² below which a motion with more than the least λ has no pericentre: f < λ² in all cells within."""
    V = np.asarray(grid.over_cells.V.low).copy()
    V[0] = np.asarray(grid.at_nodes.V.low)[1]  # f rises from the centre, or V exceeds the top there
    inside = grid.r[1:] ** 2 * (top - V) < least**2
    return float(grid.r[int(np.argmin(inside))] ** 2)
