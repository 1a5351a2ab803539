"""Write the turning points of small motions about a maximum of p², as offsets from the start.

F(q₀ + x) = P₀² + x (F′₀ + x F[q₀, q₀, q₀ + x]) is solved as a quadratic equation whose last coefficient hardly varies,
again and again, by secants (Traub, Iterative Methods, 1964, §8.1: Steffensen's acceleration of a fixed point).
"""

from __future__ import annotations

import math

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.compiling import helper, inlined, kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Reals

_FIXED = 40  # secant steps
_ALIKE = 2.0  # how much larger the uncertainty of ½F″ may be at the turning points; three times of it count
_FAR = 0.5  # part of the way to an end of the domain beyond which a motion is not small


@inlined
def _quadratic(square: float, outward: float, bend: float) -> float:
    """Return the positive zero of square + outward d + bend d², bend < 0."""
    # of the two formulas of a quadratic's zero the one whose terms have one sign
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    return (outward + root) / (-2.0 * bend) if outward > 0.0 else 2.0 * square / (root - outward)


@helper
def _solved(value: MachineProgram, known: Reals, first: int, side: float, places: Reals, work: Reals,
            on: Integers) -> None:  # fmt: skip
    """Write the turning points of a block of orbits on one side; ``work``: ½F″, d, d before, and what was off then."""
    width, m = value.registers.shape[1], known.shape[0] - 5
    count = min(width, known.shape[1] - first)
    x, F, (bend, d, before, off) = (
        value.registers[0], value.registers[value.outputs[0]], (work[0], work[1], work[2], work[3])
    )  # fmt: skip
    left = 0
    for j in range(count):
        square, slope = known[m + 1, first + j], known[m + 2, first + j]
        on[j], places[first + j], x[j] = 0, np.nan, 0.0
        if bend[j] < 0.0 and (square > 0.0 or slope != 0.0):
            d[j], before[j], off[j] = _quadratic(square, side * slope, bend[j]), 0.0, 0.0
            before[j], x[j] = d[j], side * d[j]
            if d[j] == 0.0:
                places[first + j] = 0.0
            else:
                on[j], left = 1, left + 1
    # d ← zero of the quadratic with F[q₀, q₀, q₀ + d]; Steffensen's secant of what is off makes it superlinear
    for step_number in range(_FIXED):
        if left == 0:
            break
        run(value, (count + 7) // 8 * 8)
        for j in range(count):
            if on[j] == 0:
                continue
            here = _quadratic(known[m + 1, first + j], side * known[m + 2, first + j], F[j]) - d[j]
            step = here
            if step_number > 0 and here != off[j]:
                secant = -here * (d[j] - before[j]) / (here - off[j])
                # a longer step is the noise of the secant's denominator
                step = secant if abs(secant) <= 2.0 * abs(here) else here
            before[j], off[j] = d[j], here
            d[j] += step
            x[j] = side * d[j]
            if not math.isfinite(here) or abs(step) <= 2.0 * EPS * d[j]:
                places[first + j] = side * d[j] if math.isfinite(here) else np.nan
                on[j], left = 0, left - 1


@helper
def _bounded(bounds: MachineProgram, known: Reals, uncertainty: Reals, first: int, count: int, row: Reals) -> None:
    """Bounds on the error of F[b, b, q] at places that lie in the program's first register."""
    m = uncertainty.shape[0]
    for k in range(m):
        for j in range(count):
            bounds.registers[1 + k, j], bounds.registers[1 + m + k, j] = (
                known[k, first + j], uncertainty[k, first + j]
            )  # fmt: skip
    run(bounds, (count + 7) // 8 * 8)
    error = bounds.registers[bounds.outputs[1]]
    for j in range(count):
        row[j] = error[j]


@kernel
def small_ends(
    value: MachineProgram, bounds: MachineProgram, known: Reals, uncertainty: Reals, floors: Reals, places: Reals,
    work: Reals, on: Integers,
) -> None:  # fmt: skip
    """Write the turning points of small motions; NaN where a motion is not as small as that.

    Args:
        value, bounds: programs of small motions, of the same width.
        known: constants, q₀, P₀², F′₀, and room for a bound on the error of F[b, b, q], b being the start or a turning
            point, and for the width, which are filled in; shape (constants + 5, n).
        uncertainty: bounds on the errors of the constants, shape (constants, n).
        floors: distances of the ends of the domain, shape (2, n), the first negative.
        places: filled, shape (2, n).
        work, on: scratch, shapes (7, width) and (width,).
    """
    n, width, m = known.shape[1], value.registers.shape[1], known.shape[0] - 5
    for first in range(0, n, width):
        count = min(width, n - first)
        for k in range(m + 5):
            for j in range(count):
                value.registers[1 + k, j] = known[k, first + j]
        for j in range(count):
            value.registers[0, j] = 0.0
        run(value, (count + 7) // 8 * 8)
        for j in range(count):
            work[0, j] = value.registers[value.outputs[0], j]
        _solved(value, known, first, -1.0, places[0], work, on)
        _solved(value, known, first, 1.0, places[1], work, on)
        for where in range(3):
            for j in range(count):
                away = 0.0 if where == 0 else places[where - 1, first + j]
                bounds.registers[0, j] = known[m, first + j] + away
            _bounded(bounds, known, uncertainty, first, count, work[4 + where])
        for j in range(count):
            i, here, low, high = first + j, work[4, j], work[5, j], work[6, j]
            known[m + 3, i], known[m + 4, i] = max(here, low, high), places[1, i] - places[0, i]
            # the uncertainty of the slopes is known at the start: it has to hold at the turning points, too
            alike = low <= _ALIKE * here and high <= _ALIKE * here
            near = places[0, i] >= _FAR * floors[0, i] and places[1, i] <= _FAR * floors[1, i]
            if not (alike and near):
                places[0, i], places[1, i] = np.nan, np.nan
