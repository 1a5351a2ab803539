"""What shifted momenta add to the actions of rotations, with derivatives.

Where p = P − A(q; κ), P = ±√F, a rotation has J = (1/2π) ∮ p dq = ±(1/2π) ∮ √F dq − ⟨A⟩, the mean of A over a turn; a
libration passes every place both ways, so A drops out. Means are sums over equal steps, which converge geometrically
(Trefethen & Weideman, SIAM Review 56 (2014) 385, §3); half of the steps show what is left open.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.lowering import lower
from hjsolve.motion.derivatives.formulas import VariedSymbols
from hjsolve.solution.quadratures import Solution

_TURN_STEPS = 256
"""Steps of a turn."""
_ROUNDED = 16 * EPS
"""Rounding of a mean, over the largest value."""


class MeanShifts(NamedTuple):
    """⟨A⟩ of n orbits, its derivatives by the variables, and by a constant and a variable, each with a bound.

    Attributes:
        value: shape (2, n), the bound second.
        first: shape (2, variables, n).
        second: shape (2, constants, variables, n).
    """

    value: Reals
    first: Reals
    second: Reals


def mean_shifts(
    solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], variables: VariedSymbols, numbers: Reals
) -> MeanShifts:
    """Return the means over a turn of q from 0 to 2π.

    Args:
        values: every parameter → exact number.
        numbers: the variables of n orbits, shape (variables, n).
    """
    n, N, count = len(variables.constants), variables.count, numbers.shape[1]
    if solution.shift[name] == 0:
        return MeanShifts(np.zeros((2, count)), np.zeros((2, N, count)), np.zeros((2, n, N, count)))
    q = solution.system.coordinate(name).symbol
    momenta = {c.momentum: c.momentum for c in solution.system.coordinates}
    A = solution.shift[name].subs(momenta)
    fixed = {s: v for s, v in values.items() if s not in variables.symbols}
    tape = _lowered(A.subs(fixed), q, variables)
    turn = (2 * np.pi * np.arange(_TURN_STEPS) / _TURN_STEPS)[:, None]
    with np.errstate(all="ignore"):
        rows = [np.broadcast_to(x, (_TURN_STEPS, count)) for x in tape.run(Float64(), [turn, *numbers[:, None, :]])]
        found = np.stack([row.mean(axis=0) for row in rows])
        open_ = np.abs(found - np.stack([row[::2].mean(axis=0) for row in rows]))
        open_ = open_ + _ROUNDED * np.stack([np.abs(row).max(axis=0) for row in rows])
    both = np.stack([found, open_])
    return MeanShifts(both[:, 0], both[:, 1 : 1 + N], both[:, 1 + N :].reshape(2, n, N, count))


@lru_cache(maxsize=64)
def _lowered(A: sp.Expr, q: sp.Symbol, variables: VariedSymbols) -> Tape:
    first = [sp.diff(A, x) for x in variables.symbols]
    second = [sp.diff(A, c, x) for c in variables.symbols[: len(variables.constants)] for x in variables.symbols]
    return lower([A, *first, *second], [q, *variables.symbols])
