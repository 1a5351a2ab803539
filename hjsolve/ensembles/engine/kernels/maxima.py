"""Maxima of F next to given places: where librations about them begin.

Newton's method on F′, uphill: where F is convex its maximum is farther on, a step that leads down is shortened, and the
ends of the domain are never reached (Kelley, Iterative methods for optimization (1999), §3.2).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.machine.compiling import kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Reals

_NEWTON_STEPS, _STILL = 24, 1e-6  # the relative step that ends the search: the place need not be the top
_STRIDE = 0.5  # step uphill where F is convex, over the distance from zero, or over that on which its slope changes
_NEXT_TO_END = 0.75  # the part of the distance from an end of the domain that a step may go


@kernel
def climbed(bend: MachineProgram, places: Reals, constants: Reals, low: float, high: float, curvature: Reals,
            work: Reals) -> None:  # fmt: skip
    """Move places to the maxima of F.

    Args:
        bend: x, constants ↦ F, F′, F″.
        places: x, shape (n,); moved.
        constants: shape (constants, n).
        low, high: ends of the domain.
        curvature: filled with F″ there, shape (n,).
        work: scratch, shape (4, lanes).
    """
    registers, (value, slope, second) = bend.registers, bend.outputs
    n, lanes = places.shape[0], registers.shape[1]
    trial, F, F1, F2 = registers[0], registers[value], registers[slope], registers[second]
    x, best, first, fraction = work[0], work[1], work[2], work[3]
    for begin in range(0, n, lanes):
        count = min(lanes, n - begin)
        used = (count + 7) // 8 * 8
        own = curvature[begin : begin + count]
        for k in range(constants.shape[0]):
            row = registers[1 + k]
            for j in range(count):
                row[j] = constants[k, begin + j]
        for j in range(count):
            trial[j] = places[begin + j]
        run(bend, used)
        for j in range(count):
            x[j], best[j], first[j], own[j], fraction[j] = trial[j], F[j], F1[j], F2[j], 1.0
        for _ in range(_NEWTON_STEPS):
            moving = False
            for j in range(count):
                ratio = first[j] / own[j]
                step = -ratio if own[j] < 0.0 else np.sign(first[j]) * _STRIDE * max(abs(x[j]), abs(ratio))
                new = x[j] + fraction[j] * step
                lowest, highest = x[j] - _NEXT_TO_END * (x[j] - low), x[j] + _NEXT_TO_END * (high - x[j])
                if new < lowest:  # nan stays nan, and is never uphill
                    new = lowest
                elif new > highest:
                    new = highest
                trial[j] = new if fraction[j] > 0.0 else x[j]
            run(bend, used)
            for j in range(count):
                if fraction[j] == 0.0:
                    continue
                still = abs(trial[j] - x[j]) <= _STILL * abs(x[j])
                # so near the top F in doubles tells nothing of up and down, which the smallest motions see
                uphill = F[j] > best[j] or (still and own[j] < 0.0 and fraction[j] == 1.0)
                if uphill:
                    x[j], best[j], first[j], own[j] = trial[j], F[j], F1[j], F2[j]
                fraction[j] = 0.0 if still else 1.0 if uphill else 0.25 * fraction[j]
                moving = moving or not still
            if not moving:
                break
        for j in range(count):
            places[begin + j] = x[j]
