"""What the shift p = P − A(q; c, λ) of a momentum adds to derivatives: A = ∂χ/∂q, and −∂χ/∂c in the law of c."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.arithmetic.tape import Tape
from hjsolve.motion.derivatives.bounded import Bounded
from hjsolve.motion.derivatives.formulas import VariedSymbols
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import Initial
from hjsolve.motion.positions import tape_of
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False)
class ShiftSlopes:
    """Derivatives of the shift at one place.

    Attributes:
        by_place: ∂A_i/∂q_k, shape (separated, separated).
        by: ∂A_i/∂z_b, shape (separated, variables).
        law_by_place: ∂²χ/∂c_m∂q_k, shape (ignorable, separated).
        law_by: ∂²χ/∂c_m∂z_b, shape (ignorable, variables).
    """

    by_place: Bounded
    by: Bounded
    law_by_place: Bounded
    law_by: Bounded


def shift_slopes(
    tape: Tape, solution: Solution, initial: Initial, count: int, q: list[Mpf], context: Context
) -> ShiftSlopes:
    """Return the derivatives of the shift at a place.

    Args:
        tape: of ``shift_tape``.
        solution: what is solved.
        initial: the exact initial data and constants.
        count: how many variables there are.
        q: places of the separated coordinates.
        context: of the numbers.
    """
    values = {**initial.values, **{solution.constants[c].symbol: initial.constants[c] for c in solution.constants}}
    numbers = [to_bits(values[s])(context.prec) for s in _known(solution)]
    found = tape.run(Multi(context.prec), [*(context.convert(x) for x in q), *numbers])
    ns = len(solution.coordinates)
    nm = len(solution.system.coordinates) - ns
    parts, position = [], 0
    for shape in ((ns, ns), (ns, count), (nm, ns), (nm, count)):
        size = shape[0] * shape[1]
        parts.append(Bounded.exact(np.array(found[position : position + size], dtype=object).reshape(shape)))
        position += size
    return ShiftSlopes(*parts)


def shift_tape(solution: Solution, variables: VariedSymbols) -> Tape | None:
    """Return the formulas of all derivatives of the shift; None where no momentum is shifted.

    Args:
        solution: what is solved.
        variables: what is varied.
    """
    if all(A == 0 for A in solution.shift.values()):
        return None
    system = solution.system
    q = [system.coordinate(name).symbol for name in solution.coordinates]
    ignorable = [c for c in system.coordinates if c.name not in solution.coordinates]
    A, χ = [solution.shift[name] for name in solution.coordinates], solution.shift_potential
    laws = [sp.diff(χ, c.momentum) for c in ignorable]
    outputs = [sp.diff(a, x) for a in A for x in q] + [sp.diff(a, z) for a in A for z in variables.symbols]
    outputs += [sp.diff(a, c.momentum) for c in ignorable for a in A]
    outputs += [sp.diff(law, z) for law in laws for z in variables.symbols]
    return tape_of(tuple(outputs), (*q, *_known(solution)))


def _known(solution: Solution) -> list[sp.Symbol]:
    return [c.symbol for c in solution.constants.values()] + [p.symbol for p in solution.system.parameters]
