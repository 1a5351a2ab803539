"""How turning points of many orbits move with constants and parameters, and periods with the frequencies.

A turning point is a zero of F(q; κ) = p², so ∂q/∂κⱼ = −F_κⱼ/F_q; a parameter is a variable κⱼ like a constant. Both are
evaluated with their running error, that of the place and of the constants included. Where F_q is not known from 0 the
ends of the motion grow like √J, and have no derivative: the motion is at rest, or at the top of a barrier.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.formulas.removable_poles import without_removable_poles
from hjsolve.lowering import lower, with_plain_exponents
from hjsolve.motion.derivatives.formulas import VariedSymbols
from hjsolve.solution.quadratures import Solution

_KNOWN = 1e-3
"""Largest part of a derivative that its error may be."""


class EndSlopes(NamedTuple):
    """∂q/∂κⱼ of the turning points of one coordinate, shape (k, 2, n); NaN where there is none."""

    value: Reals
    error: Reals


def tape_of_ends(solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], variables: VariedSymbols) -> Tape:
    """Lower F and F_κⱼ of one coordinate; inputs q, the variables and, where they are not varied, the parameters."""
    q = solution.system.coordinate(name).symbol
    fixed = tuple(p.symbol for p in solution.system.parameters if p.symbol not in variables.symbols)
    return _lowered(solution.momentum_squared[name], q, variables.symbols, fixed, tuple(values.items()))


@lru_cache(maxsize=64)
def _lowered(
    F: sp.Expr, q: sp.Symbol, varied: tuple[sp.Symbol, ...], fixed: tuple[sp.Symbol, ...],
    values: tuple[tuple[sp.Symbol, sp.Expr], ...],
) -> Tape:  # fmt: skip
    numbers = dict(values)
    seen = [with_plain_exponents(e, numbers) for e in (F, *(sp.diff(F, x) for x in varied))]
    return lower([without_removable_poles(e, q) for e in seen], [q, *varied, *fixed])


def slopes_of_ends(
    tape: Tape, parameters: tuple[Pair, ...], ends: tuple[Reals, Reals], variables: tuple[Reals, Reals]
) -> EndSlopes:
    """Differentiate the turning points of one coordinate.

    Args:
        tape: of ``tape_of_ends``.
        parameters: those that are not varied, in two doubles.
        ends: lower and upper turning points, shape (2, n), and bounds on their errors.
        variables: κ, shape (k, n), and bounds on their errors.
    """
    plain: Any = Float64()
    q, κ = ends[0], variables[0][:, None, :]
    x: Jet[WithErrorBound[Any]] = Jet(WithErrorBound(q, ends[1]), WithErrorBound(np.float64(1.0)))
    known: list[Jet[WithErrorBound[Any]]] = [
        Jet(WithErrorBound(v, e)) for v, e in zip(κ, variables[1][:, None, :], strict=True)
    ]
    known += [Jet(WithErrorBound(np.float64(high), np.float64(abs(low) + EPS * abs(low)))) for high, low in parameters]
    arithmetic: Jets[WithErrorBound[Any]] = Jets(RunningError(plain))
    with np.errstate(all="ignore"):
        F, *others = tape.run(arithmetic, [x, *known])
        zero = WithErrorBound(np.zeros(q.shape), np.zeros(q.shape))
        slope, slope_error = _both(F[1] if F[1] is not None else zero, q)
        value, error = np.full((len(κ), *q.shape), np.nan), np.full((len(κ), *q.shape), np.nan)
        for j, other in enumerate(others):
            by, by_error = _both(other[0], q)
            # the implicit function theorem on F(q; κ) = 0
            value[j] = -by / slope
            rounding = 4 * EPS * np.abs(value[j])
            error[j] = SECOND_ORDER * (by_error + np.abs(value[j]) * slope_error) / np.abs(slope) + rounding
        # next to a double zero ∂q/∂κ grows without bound: it is given as long as its sign and three digits are sure
        good = slope_error < _KNOWN * np.abs(slope)
    return EndSlopes(np.where(good, value, np.nan), np.where(good, error, np.nan))


def _both(x: WithErrorBound[Reals], like: Reals) -> tuple[Reals, Reals]:
    error = np.float64(0.0) if x.error is None else x.error
    return np.broadcast_to(x.value, like.shape), np.broadcast_to(error, like.shape)


def periods_by_constants(Ω: tuple[Reals, Reals], slopes: tuple[Reals, Reals]) -> tuple[Reals, Reals]:
    """Return ∂T/∂α = −(T/Ω) ∂Ω/∂α with its error, T = 2π/|Ω|.

    Args:
        Ω: frequencies, shape (n,), and bounds on their errors.
        slopes: ∂Ω/∂α, shape (n,), and bounds on their errors.
    """
    with np.errstate(all="ignore"):
        rate = 2 * np.pi / np.abs(Ω[0])
        value = -rate / Ω[0] * slopes[0]
        off = Ω[1] / np.abs(Ω[0])
        error = rate / np.abs(Ω[0]) * slopes[1] + np.abs(value) * (2 * off / (1 - off) ** 2 + 8 * EPS)
        # 1/Ω² over the whole interval Ω ± δΩ
        error = error / (1 - off) ** 2
    return value, np.where(off < 1, error, np.inf)
