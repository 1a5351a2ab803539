"""The two deepest or narrowest valleys of F over a turn: where motions that go round are slow.

F > 0 is looked at on a grid; its least value there, and the bottom of the narrowest other valley, are where Newton's
method on F′ begins. Next to a minimum F ≈ F₀ + ½ F″ (q − q₀)²: its zeros lie √(2F₀/F″) from the real line.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.compiling import helper, kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Reals

POINTS = 32
"""Of the grid, which only proposes: the least value shows that F > 0 between its points, and the nodes of the integrals
prove it. Half and twice as many change no status."""
_SPACING = 2 * math.pi / POINTS
_FARTHEST_STEP = 0.2
"""Of Newton's method, radians: about the spacing of the grid it begins on. Farther away another point is nearer."""
_NEWTON_STEPS = 8
_AWAY = 3
"""Points of the grid from the slow place on at which another one may be."""
_EQUAL = 1e-9
"""Over the greatest F: of equal minima the first counts, whatever rounding says of their order."""


class Valleys(NamedTuple):
    """Two minima of F of n orbits, arrays (n,).

    Attributes:
        place, other: where they are; the first is NaN where F ≤ 0 on the grid, the second where there is none.
        gap, far: distances √(2F/F″) of zeros from the real line; NaN for none near.
        least, lowest: F there.
        greatest: F on the grid.
    """

    place: Reals
    other: Reals
    gap: Reals
    far: Reals
    least: Reals
    lowest: Reals
    greatest: Reals


class ValleyScratch(NamedTuple):
    """Room for a block of orbits.

    Attributes:
        values: F on the grid, shape (``POINTS``, lanes).
        rows: shape (2, lanes).
    """

    values: Reals
    rows: Reals


@kernel
def valleys_of_turns(
    bend: MachineProgram, constants: Reals, grid: Reals, found: Valleys, work: ValleyScratch
) -> None:  # fmt: skip
    """Find the valleys of F along a turn.

    Args:
        bend: q, constants ↦ F, F′, F″.
        constants: shape (constants, n).
        grid: ``POINTS`` angles, equally spaced over a turn.
        found: filled.
        work: scratch.
    """
    registers, n = bend.registers, constants.shape[1]
    lanes, place, values, greatest = registers.shape[1], registers[0], work.values, work.rows[0]
    for begin in range(0, n, lanes):
        count = min(lanes, n - begin)
        used = (count + 7) // 8 * 8
        for k in range(constants.shape[0]):
            row = registers[1 + k]
            for j in range(used):  # the last orbit again: lanes that nobody reads
                row[j] = constants[k, begin + min(j, count - 1)]
        for i in range(grid.shape[0]):
            for j in range(used):
                place[j] = grid[i]
            run(bend, used)
            F = registers[bend.outputs[0]]
            for j in range(count):
                values[i, j] = F[j]
        for j in range(count):
            positive, bottom, top = True, np.inf, 0.0
            for i in range(grid.shape[0]):
                positive = positive and values[i, j] > 0.0  # nan is not
                bottom, top = min(bottom, values[i, j]), max(top, values[i, j])
            first = 0
            while positive and values[first, j] > bottom + _EQUAL * top:
                first += 1
            greatest[j], place[j] = top, grid[first] if positive else np.nan
        _refined(bend, count, found.place[begin:], found.gap[begin:], found.least[begin:], work.rows[1])
        for j in range(count):
            found.greatest[begin + j] = greatest[j]
            second = _second(values[:, j], grid, found.place[begin + j])
            place[j] = grid[second] if second >= 0 else np.nan
        _refined(bend, count, found.other[begin:], found.far[begin:], found.lowest[begin:], work.rows[1])


@helper
def _refined(bend: MachineProgram, count: int, place: Reals, gap: Reals, least: Reals, fine: Reals) -> None:
    """Move the places in the first register to where F is least, and write down what is there."""
    registers, (value, slope, second) = bend.registers, bend.outputs
    x, F, F1, F2 = registers[0], registers[value], registers[slope], registers[second]
    used = (count + 7) // 8 * 8
    for j in range(used):
        fine[j] = 1.0
    for _ in range(_NEWTON_STEPS):
        run(bend, used)
        moving = False
        for j in range(count):
            step = F1[j] / F2[j]
            if not (F2[j] > 0.0 and abs(step) < _FARTHEST_STEP):
                fine[j] = 0.0
            if fine[j] > 0.0:
                moving = moving or x[j] - step != x[j]
                x[j] = x[j] - step
        if not moving:
            break
    run(bend, used)
    for j in range(count):
        distance = np.sqrt(2 * F[j] / F2[j])
        place[j], least[j] = x[j], F[j]
        gap[j] = distance if fine[j] > 0.0 and distance < np.inf else np.nan


@helper
def _second(values: Reals, grid: Reals, slow: float) -> int:
    """Return the point of the grid at the bottom of the narrowest valley away from the slow place; −1 for none."""
    points, best, narrowest = grid.shape[0], -1, np.inf
    if np.isnan(slow):
        return best
    for i in range(points):
        before, own, after = values[i - 1], values[i], values[i + 1 if i + 1 < points else 0]
        bend = before - 2 * own + after
        if own <= before and own <= after and bend > 0.0:
            away = (grid[i] - slow + math.pi) % (2 * math.pi) - math.pi
            # F at the bottom of the parabola through three points, over its second difference: the distance of its
            # zeros, squared
            gap = own / bend - 0.125 * ((after - before) / bend) ** 2
            if abs(away) > _AWAY * _SPACING and gap < narrowest:
                best, narrowest = i, gap
    return best
