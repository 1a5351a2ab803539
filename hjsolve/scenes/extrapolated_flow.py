"""One step of many ordinary differential equations at once, by extrapolation, with an estimate of its error.

Gragg's modified midpoint rule with 2, 4, …, 2K parts has an error in even powers of the step alone; Aitken's and
Neville's scheme takes K of them to order 2K (Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*,
§II.9). The difference of the last two columns is the error of the lower one, so a bound in practice on that of the
result.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hjsolve.arithmetic.number_types import Reals

Slopes = Callable[[Reals], Reals]
PARTS = (2, 4, 6, 8, 10, 12)
ORDER = 2 * len(PARTS)


def extrapolated(slopes: Slopes, state: Reals, step: Reals, parts: tuple[int, ...] = PARTS) -> tuple[Reals, Reals]:
    """Take a step.

    Args:
        slopes: state ↦ its rate of change, shape (n, m) both: n variables of m motions.
        state: shape (n, m).
        step: of each motion, shape (m,).
        parts: K even numbers, the order being 2K; fewer of them cost less where few digits are wanted.

    Returns:
        The state after the step, and the estimate of its error; shapes (n, m).
    """
    begin = slopes(state)
    rows: list[Reals] = []
    for k, count in enumerate(parts):
        h = step / count
        before, here = state, state + h * begin
        for _ in range(count - 1):
            before, here = here, before + 2 * h * slopes(here)
        row = [here]
        for j in range(1, k + 1):
            row.append(row[j - 1] + (row[j - 1] - rows[j - 1]) / ((count / parts[k - j]) ** 2 - 1))
        rows = row
    return rows[-1], np.abs(rows[-1] - rows[-2])
