"""Means of complex integrands over paths of many orbits, each with as many steps as the others.

A path has the places x = b ± (A X + B Y) with tables X, Y of complex numbers, dq/dχ = ±(A T + B U); as programs of both
halves see them, like the nodes of ``cycle_integrals``.
"""

from __future__ import annotations

from typing import NamedTuple

from hjsolve.arithmetic.machine.compiling import helper, kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.midpoint_rule import dot
from hjsolve.ensembles.engine.kernels.types import SLOTS

PLACE, ROUNDING_ERROR = 4, 4.0 * 2.0**-53
"""Inputs that say where a step is; rounding of a place in proportion to the parts it is the sum of."""


class PathTable(NamedTuple):
    """The steps of a path.

    Attributes:
        steps: real and imaginary parts of X, Y, T, U, shape (8, steps).
        weights: with which the real and imaginary part of an integrand show what half of the steps leave open, and the
            same times e^{iχ}, shape (4, steps).
        below: int64, shape (1,): how many steps, from the first one, are seen from the lower end.
    """

    steps: Reals
    weights: Reals
    below: Integers


class Paths(NamedTuple):
    """The paths of n orbits.

    Attributes:
        bases: b of the lower and of the upper half, shape (2, n).
        signs: ±1 of either half.
        wide, narrow: A and B, shape (n,).
        known: constants, then bounds on their errors, shape (n, 2 constants).
    """

    bases: Reals
    signs: Reals
    wide: Reals
    narrow: Reals
    known: Reals


@helper
def _steps(program: MachineProgram, at: int, span: tuple[int, int], half: int, paths: Paths, i: int, steps: Reals,
           bounds: bool) -> None:  # fmt: skip
    """Write some steps of one path into the lanes of a program, from one lane on."""
    start, n = span[0], span[1] - span[0]
    b, s, A, B = paths.bases[half, i], paths.signs[half], paths.wide[i], paths.narrow[i]
    registers, known = program.registers, paths.known.shape[1]
    for part in range(2):
        x, t = registers[part, at : at + n], registers[2 + part, at : at + n]
        X, Y = steps[part, start:], steps[2 + part, start:]
        T, U = steps[4 + part, start:], steps[6 + part, start:]
        # b is real: the imaginary part of a place is that of the path alone
        origin = b if part == 0 else 0.0
        for j in range(n):
            x[j] = origin + s * (A * X[j] + B * Y[j])
            t[j] = A * T[j] + B * U[j]
    first = PLACE
    if bounds:
        rounding_error, X, Y = registers[PLACE, at : at + n], steps[:2, start:], steps[2:4, start:]
        for j in range(n):
            # rounding of a sum refers to its terms: b, and both parts of the path
            wide, narrow = A * (abs(X[0, j]) + abs(X[1, j])), B * (abs(Y[0, j]) + abs(Y[1, j]))
            rounding_error[j] = ROUNDING_ERROR * (abs(b) + wide + narrow)
        first += 1
    else:
        known //= 2
    for k in range(known):
        row, value = registers[first + k, at : at + n], paths.known[i, k]
        for j in range(n):
            row[j] = value


@helper
def _row(below: MachineProgram, above: MachineProgram, k: int, at: tuple[int, int], counts: tuple[int, int],
         to: Reals) -> None:  # fmt: skip
    low, high = below.registers[below.outputs[k], at[0] :], above.registers[above.outputs[k], at[1] :]
    for j in range(counts[0]):
        to[j] = low[j]
    for j in range(counts[1]):
        to[counts[0] + j] = high[j]


@helper
def _means(below: MachineProgram, above: MachineProgram, at: tuple[int, int], counts: tuple[int, int],
           weights: Reals, work: Reals, made: Reals, i: int) -> None:  # fmt: skip
    """Means of one orbit: r continued along the path, F r, and every integrand with what half of the steps leave."""
    n = counts[0] + counts[1]
    re, im, sign, signed = work[0], work[1], work[2], work[3:7]
    _row(below, above, 0, at, counts, re)
    _row(below, above, 1, at, counts, im)
    sign[0] = 1.0 if re[0] > 0.0 else -1.0
    for j in range(1, n):
        # r has no zero next to the path: from step to step it turns by less than a right angle
        sign[j] = sign[j - 1] if re[j] * re[j - 1] + im[j] * im[j - 1] >= 0.0 else -sign[j - 1]
    made[0, i] = sign[n - 1] * re[n - 1]
    for k in range(4):
        for j in range(n):
            # the sign of r goes into the weights once, for all integrands
            signed[k, j] = sign[j] * weights[k, j]
    _row(below, above, 2, at, counts, re)
    made[1, i] = dot(re, sign, n) / n
    for k in range((made.shape[0] - 2) // 3):
        _row(below, above, 3 + 2 * k, at, counts, re)
        _row(below, above, 4 + 2 * k, at, counts, im)
        made[2 + 3 * k, i] = dot(re, sign, n) / n
        made[3 + 3 * k, i] = abs(dot(re, signed[0], n) + dot(im, signed[1], n))
        made[4 + 3 * k, i] = abs(dot(re, signed[2], n) + dot(im, signed[3], n))


@helper
def _largest(below: MachineProgram, above: MachineProgram, at: tuple[int, int], counts: tuple[int, int],
             work: Reals, made: Reals, i: int) -> None:  # fmt: skip
    """Means over one orbit of what is at most as large as the next one before or after."""
    n, row = counts[0] + counts[1], work[0]
    for k in range(made.shape[0]):
        _row(below, above, k, at, counts, row)
        total = 0.0
        for j in range(n):
            # every fourth step is looked at: between two of them the larger one counts
            before, after = row[j - 1 if j > 0 else 0], row[j + 1 if j + 1 < n else n - 1]
            total += max(row[j], before, after)
        made[k, i] = total / n


@kernel
def path_means(below: MachineProgram, above: MachineProgram, table: PathTable, paths: Paths, bounds: bool,
               work: Reals, made: Reals) -> None:  # fmt: skip
    """Run programs on the paths of n orbits and take means.

    Args:
        below, above: programs of both halves, with other registers.
        table: the steps.
        paths: of the orbits.
        bounds: whether the programs are those of bounds.
        work: scratch, shape (7, steps).
        made: filled, shape (results, n). Of integrands r at the last step, the mean of F r, and mean and two remainders
            of every other one; of bounds their means.
    """
    n, count, split = paths.wide.shape[0], table.steps.shape[1], table.below[0]
    counts = (split, count - split)
    # the steps of several short paths fill one run of the programs: a run has a price of its own
    most = max(1, SLOTS // max(counts[0], counts[1]))
    for first in range(0, n, most):
        here = min(most, n - first)
        for t in range(here):
            _steps(below, t * counts[0], (0, split), 0, paths, first + t, table.steps, bounds)
            if counts[1] > 0:
                _steps(above, t * counts[1], (split, count), 1, paths, first + t, table.steps, bounds)
        # lanes come in eights; what the last ones hold is not looked at
        run(below, (here * counts[0] + 7) // 8 * 8)
        if counts[1] > 0:
            run(above, (here * counts[1] + 7) // 8 * 8)
        for t in range(here):
            at = (t * counts[0], t * counts[1])
            if bounds:
                _largest(below, above, at, counts, work, made, first + t)
            else:
                _means(below, above, at, counts, table.weights, work, made, first + t)
