"""Poincaré's surface of section of a system with two essential coordinates: where motions cross q_s = const upwards.

Hamilton's equations are integrated step by step, each step with an error below the tolerance; on the last step before
a crossing q_s takes the part of the time (Hénon, Physica D 5 (1982) 412), so that a single step ends on the section.
Every motion is followed twice, with tolerances a hundred times apart: up to where the two part their returns are those
of the motion to that difference. After that, where motions are chaotic, they are returns of motions next to it, at the
same energy: what of the energy is lost is measured at each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Reals
from hjsolve.lowering import lower
from hjsolve.mechanics.system import Coordinate, System, hamiltonian
from hjsolve.scenes.extrapolated_flow import ORDER, extrapolated

TOLERANCES = (1e-13, 1e-11)
"""Of a step, in parts of what each variable reaches."""
AGREEMENT = 1e-3
"""Of two runs, in parts of the section's size."""
_RETURNS, _MOTIONS = 100, (8, 5)
_MOST_STEPS, _FEW_RETURNS, _FEW_STEPS = 1600, 8, 500
_GRID, _WIDENINGS = 61, 8


@dataclass(frozen=True)
class PlaneMotion:
    """Hamilton's equations of the two coordinates that H contains.

    Attributes:
        coordinates: the two.
        energy: H as a function of the state (q₁, q₂, p₁, p₂), shape (4, …) ↦ (…).
        slopes: its equations, shape (4, …) ↦ (4, …).
        start: of the user's motion, shape (4,).
    """

    coordinates: tuple[Coordinate, Coordinate]
    energy: Callable[[Reals], Reals]
    slopes: Callable[[Reals], Reals]
    start: Reals


def plane_motion(system: System, values: dict[sp.Symbol, sp.Expr]) -> PlaneMotion | None:
    """Take out the coordinates that H does not contain.

    Args:
        system: any.
        values: symbol → exact number, of parameters, places and momenta.

    Returns:
        The equations; None where other than two coordinates are left.
    """
    H = hamiltonian(system)
    moving = [c for c in system.coordinates if H.has(c.symbol)]
    if len(moving) != 2:
        return None
    variables = [c.symbol for c in moving] + [c.momentum for c in moving]
    H = H.xreplace({s: v for s, v in values.items() if s not in variables})
    if H.free_symbols - set(variables):
        return None
    rates = [sp.diff(H, c.momentum) for c in moving] + [-sp.diff(H, c.symbol) for c in moving]
    start = np.array([float(sp.N(values[s], 20)) for s in variables])
    energy, slopes = _function([H], variables), _function(rates, variables)
    return PlaneMotion((moving[0], moving[1]), lambda state: np.asarray(energy(state)[0]), slopes, start)


def _function(formulas: list[sp.Expr], variables: list[sp.Symbol]) -> Callable[[Reals], Reals]:
    tape = lower(formulas, variables).bind(Float64(), [])

    def evaluate(state: Reals) -> Reals:
        values = tape.run(*state)
        result = np.empty((len(values), *state.shape[1:]))
        for k, value in enumerate(values):
            result[k] = value
        return result

    return evaluate


@dataclass(frozen=True)
class SurfaceOfSection:
    """Returns of some motions of one energy, the user's the first.

    Attributes:
        along, across: indices of the coordinate that is constant on the section, and of the one that is drawn.
        level: the value of the first.
        points: (q, p) of the other at each return, shape (2, motions, returns); NaN where one is missing.
        settled: how many returns of each motion two tolerances agree upon, to ``AGREEMENT``, shape (motions,).
        drift: the largest |H − E| at any return.
        energy: E.
        plane: q and p of a grid, and where on it motions of this energy cross, positive; for the edge of the section.
    """

    along: int
    across: int
    level: float
    points: Reals
    settled: NDArray[np.int64]
    drift: float
    energy: float
    plane: tuple[Reals, Reals, Reals]


def returns(
    plane: PlaneMotion, states: Reals, along: int, level: float, count: int, tolerance: Reals, steps: int = _MOST_STEPS
) -> Reals:
    """Follow motions from one crossing of the section to the next.

    Args:
        states: where the motions begin, shape (4, m).
        along: index of the coordinate that is constant on the section.
        level: its value there.
        count: of returns.
        tolerance: of each motion, shape (m,).
        steps: that are tried at most.

    Returns:
        The states at the returns, shape (4, m, count); NaN past a step that failed or the work allowed.
    """
    turn = 2 * np.pi if plane.coordinates[along].domain.kind == "angle" else np.inf
    many = states.shape[1]
    found, done = np.full((4, many, count), np.nan), np.zeros(many, dtype=np.int64)
    here, step, reach = states.copy(), np.full(many, 1e-3), np.maximum(np.abs(states), 1e-3)

    def by_place(state: Reals) -> Reals:
        rate = plane.slopes(state)
        return np.asarray(rate / rate[along])

    for _ in range(steps):
        k = np.flatnonzero((done < count) & (step > 1e-12))
        if not len(k):
            break
        with np.errstate(all="ignore"):
            after, error = extrapolated(plane.slopes, here[:, k], step[k])
            size = np.maximum(reach[:, k], np.abs(after))
            ratio = np.max(error / (tolerance[k] * size), axis=0)
            speed, speed_after = (plane.slopes(state)[along] for state in (here[:, k], after))
            nearest = turn * np.round((after[along] - level) / turn) if np.isfinite(turn) else 0.0
            low, high = here[along, k] - level - nearest, after[along] - level - nearest
            crossed, good = (low < 0) & (high >= 0), ratio <= 1
            turned = crossed & ((speed <= 0) | (speed_after <= 0))
            halved = good & (_hidden(low, high, speed, speed_after, step[k]) | turned)
            good &= ~halved
            landing = np.flatnonzero(good & crossed)
            if len(landing):
                on, off = extrapolated(by_place, after[:, landing], -high[landing])
                fits = np.max(off / (tolerance[k[landing]] * size[:, landing]), axis=0) <= 1
                halved[landing[~fits]], good[landing[~fits]] = True, False
                j = k[landing[fits]]
                found[:, j, done[j]] = on[:, fits]
                done[j] += 1
            grown = np.where(np.isfinite(ratio), np.clip(0.9 * ratio ** (-1 / (ORDER - 1)), 0.2, 2.0), 0.2)
        here[:, k[good]], reach[:, k[good]] = after[:, good], size[:, good]
        step[k] *= np.where(halved, 0.5, grown)
    return found


def _hidden(low: Reals, high: Reals, speed: Reals, speed_after: Reals, step: Reals) -> NDArray[np.bool_]:
    """Whether a step may have gone over the section and back: the tangents at its ends meet on the other side."""
    meeting = low + speed * (high - low - speed_after * step) / (speed - speed_after)
    over = (low < 0) & (high < 0) & (speed > 0) & (speed_after < 0) & (meeting > 0)
    under = (low >= 0) & (high >= 0) & (speed < 0) & (speed_after > 0) & (meeting < 0)
    return (over | under) & (step > 1e-9)


def path(plane: PlaneMotion, steps: int = 400) -> tuple[Reals, Reals]:
    """Follow the user's motion over some steps.

    Args:
        steps: how many are tried.

    Returns:
        The times reached, shape (n,), and the states there, shape (4, n).
    """
    here, step, time = plane.start[:, None], np.full(1, 1e-3), 0.0
    times, states = [0.0], [plane.start]
    for _ in range(steps):
        with np.errstate(all="ignore"):
            after, error = extrapolated(plane.slopes, here, step)
            ratio = float(np.max(error / (TOLERANCES[0] * np.maximum(np.abs(after), 1e-3))))
        if not np.isfinite(ratio) or ratio > 1:
            step = step * (max(0.2, 0.9 * ratio ** (-1 / (ORDER - 1))) if np.isfinite(ratio) else 0.2)
            continue
        time += float(step[0])
        here = after
        times.append(time)
        states.append(after[:, 0])
        step = step * min(2.0, 0.9 * max(ratio, 1e-9) ** (-1 / (ORDER - 1)))
    return np.array(times), np.array(states).T


def surface_of_section(plane: PlaneMotion) -> SurfaceOfSection | None:
    """Compute a surface of section at the energy of the user's motion.

    Returns:
        The section; None where the motion does not come back to one.
    """
    E, own = float(plane.energy(plane.start)), path(plane)[1]
    for along in (0, 1):
        level = _level(plane, along, own[along])
        one = plane.start[:, None]
        begin = returns(plane, one, along, level, _FEW_RETURNS, np.full(1, TOLERANCES[0]), _FEW_STEPS)[:, 0]
        if not np.isfinite(begin).all():
            continue
        grid = _grid(plane, along, level, E, begin)
        if grid is None:
            continue
        states = np.concatenate([begin[:, :1], _starts(plane, along, level, E, grid)], axis=1)
        many, tolerance = states.shape[1], np.repeat(TOLERANCES, states.shape[1])
        found = returns(plane, np.tile(states, 2), along, level, _RETURNS, tolerance)
        fine, coarse = found[:, :many], found[:, many:]
        with np.errstate(all="ignore"):
            drift = float(np.nanmax(np.abs(plane.energy(fine) - E)))
        box = np.array([np.ptp(grid[0]), np.ptp(grid[1])])[:, None, None]
        drawn = [1 - along, 3 - along]
        apart = np.max(np.abs(fine[drawn] - coarse[drawn]) / box, axis=0)
        settled = np.cumprod(apart <= AGREEMENT, axis=1).sum(axis=1)
        return SurfaceOfSection(along, 1 - along, level, fine[drawn], settled, drift, E, grid)
    return None


def _level(plane: PlaneMotion, along: int, q: Reals) -> float:
    """Where the section lies: at 0 where the motion, which passes the places q, does; else in the middle of these."""
    if plane.coordinates[along].domain.kind == "angle" or np.sum((q[:-1] < 0) & (q[1:] >= 0)) >= 3:
        return 0.0
    return float((np.min(q) + np.max(q)) / 2)


def _crossing(plane: PlaneMotion, along: int, level: float, E: float, q: Reals, p: Reals) -> tuple[Reals, Reals]:
    """Return the momentum with which motions of an energy cross upwards; they do where the discriminant is positive.

    H is quadratic in each momentum: its values at −1, 0, 1 tell the coefficients.
    """
    states = [np.empty((4, *q.shape)) for _ in range(3)]
    for value, state in zip((-1.0, 0.0, 1.0), states):
        state[along], state[1 - along], state[2 + along], state[3 - along] = level, q, value, p
    with np.errstate(all="ignore"):
        less, none, more = (plane.energy(state) for state in states)
        a, b = (more + less) / 2 - none, (more - less) / 2
        room = b**2 - 4 * a * (none - E)
        return (-b + np.sqrt(room)) / (2 * a), np.where(a > 0, room, np.nan)


def _grid(plane: PlaneMotion, along: int, level: float, E: float, seen: Reals) -> tuple[Reals, Reals, Reals] | None:
    """Return a grid of (q, p) that contains the part of the section the motion is in; None where that has no end."""
    drawn = seen[[1 - along, 3 - along]]
    angle = plane.coordinates[1 - along].domain.kind == "angle"
    if angle:
        drawn[0] = np.remainder(drawn[0] + np.pi, 2 * np.pi) - np.pi
    middle, half = drawn.mean(axis=1), np.maximum(np.ptp(drawn, axis=1), 1e-3 * (1 + np.abs(drawn).max(axis=1)))
    for _ in range(_WIDENINGS):
        if angle and half[0] + abs(middle[0]) >= np.pi:
            middle[0], half[0] = 0.0, np.pi
        q, p = (np.linspace(m - h, m + h, _GRID) for m, h in zip(middle, half))
        room = _crossing(plane, along, level, E, *np.meshgrid(q, p))[1]
        inside = _connected(room > 0, q, p, drawn[:, 0])
        round_ = angle and half[0] == np.pi
        sides = (not round_ and bool(inside[:, [0, -1]].any()), bool(inside[[0, -1]].any()))
        if not any(sides):
            rows, columns = np.nonzero(inside)
            if len(rows) > 4 and min(_GRID if round_ else np.ptp(columns), np.ptp(rows)) < 0.75 * _GRID:
                ends = [
                    (v[max(int(np.min(n)) - 1, 0)], v[min(int(np.max(n)) + 1, _GRID - 1)])
                    for v, n in ((q, columns), (p, rows))
                ]
                middle, half = np.mean(ends, axis=1), 0.55 * np.ptp(ends, axis=1)
                continue
            return q, p, np.where(_beside(_beside(inside)), room, np.nan)
        half = half * np.where(sides, 1.6, 1.0)
    return None


def _beside(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a region and its neighbours."""
    wide = np.pad(inside, 1)
    return wide[1:-1, 1:-1] | wide[:-2, 1:-1] | wide[2:, 1:-1] | wide[1:-1, :-2] | wide[1:-1, 2:]


def _connected(allowed: NDArray[np.bool_], q: Reals, p: Reals, place: Reals) -> NDArray[np.bool_]:
    """Return the part of a region that hangs together with a place."""
    part = np.zeros_like(allowed)
    part[int(np.argmin(np.abs(p - place[1]))), int(np.argmin(np.abs(q - place[0])))] = True
    while True:
        grown = part | _beside(part) & allowed
        if (grown == part).all():
            return part & allowed
        part = grown


def _starts(plane: PlaneMotion, along: int, level: float, E: float, grid: tuple[Reals, Reals, Reals]) -> Reals:
    """Begin motions on the two lines through the middle of the section, shape (4, m)."""
    q, p, room = grid
    inside = room > 0
    rows, columns = np.nonzero(inside)
    row, column = int(np.median(rows)), int(np.median(columns))
    across, up = np.flatnonzero(inside[row]), np.flatnonzero(inside[:, column])
    chosen = [(across[int(i)], row) for i in np.linspace(0, len(across) - 1, _MOTIONS[0] + 2)[1:-1]]
    chosen += [(column, up[int(i)]) for i in np.linspace(0, len(up) - 1, _MOTIONS[1] + 2)[1:-1]]
    a, b = (np.array(v) for v in zip(*chosen))
    states = np.empty((4, len(a)))
    states[along], states[1 - along], states[3 - along] = level, q[a], p[b]
    states[2 + along] = _crossing(plane, along, level, E, q[a], p[b])[0]
    return states
