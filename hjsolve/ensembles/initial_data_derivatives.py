"""Derivatives of many orbits by their initial data and by parameters at fixed initial data.

∂f/∂x = Σⱼ ∂f/∂αⱼ ∂αⱼ/∂x for x of q and p, with the formulas of α; for a parameter x what it does at fixed α is added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.ensembles.initial_conditions import arrays_of
from hjsolve.lowering import lower
from hjsolve.mechanics.system import momenta
from hjsolve.solution.quadratures import Solution

Column = Reals | tuple[Reals, Reals]
"""One number an orbit, or of turning points two."""

Slopes = dict[str, dict[str, tuple[Reals, Reals]]]
""""q.r", "p.r" … or parameter → constant → ∂α/∂x and bounds on its errors."""


def slopes_of_constants(
    solution: Solution, starts: Mapping[str, Mapping[str, object]], values: Mapping[sp.Symbol, sp.Expr],
    parameters: Sequence[str] = (),
) -> Slopes:  # fmt: skip
    """Differentiate the constants of the motion by q and p, and by parameters at fixed q and p.

    Args:
        solution: of the system, in its own coordinates.
        starts: ``q``, and ``p`` or ``velocity`` → coordinate → numbers, which broadcast.
        values: parameter → exact number.
        parameters: names of those that are varied.
    """
    coordinates = solution.system.coordinates
    names = [c.name for c in coordinates]
    given, shape = arrays_of(starts, names)
    q, rates = (
        [np.broadcast_to(np.asarray(given[group][name], dtype=float), shape) for name in names] for group in given
    )
    arithmetic = RunningError(Float64())
    places, moving = [WithErrorBound(x) for x in q], [WithErrorBound(x) for x in rates]
    if "velocity" in given:
        formulas = [momenta(solution.system)[name].subs(values) for name in names]
        rule = lower(formulas, [c.symbol for c in coordinates] + [c.velocity for c in coordinates])
        # p = M(q) v with its rounding, which counts in what follows
        moving = rule.run(arithmetic, [*places, *moving])
    symbols = [c.symbol for c in coordinates] + [c.momentum for c in coordinates]
    varied = {f"q.{c.name}": c.symbol for c in coordinates} | {f"p.{c.name}": c.momentum for c in coordinates}
    varied |= {p.name: p.symbol for p in solution.system.parameters if p.name in parameters}
    constants = {name: c.expression for name, c in solution.constants.items()}
    tape = lower([sp.diff(e, s).subs(values) for s in varied.values() for e in constants.values()], symbols)
    with np.errstate(all="ignore"):
        found = [
            (
                np.broadcast_to(x.value, shape),
                np.broadcast_to(0.0 if x.error is None else SECOND_ORDER * x.error, shape),
            )
            for x in tape.run(arithmetic, [*places, *moving])
        ]
    n = len(constants)
    return {key: dict(zip(constants, found[j * n : (j + 1) * n], strict=True)) for j, key in enumerate(varied)}


def by_initial_data(
    value: Mapping[str, Column], error: Mapping[str, Column], slopes: Slopes
) -> tuple[dict[str, Column], dict[str, Column]]:
    """Return derivatives of one quantity by q, p and parameters, and bounds on their errors.

    Args:
        value, error: constant, and parameter at fixed constants → array, or a pair of them for turning points.
        slopes: of the constants, by what is varied.
    """
    found: dict[str, Column] = {}
    bounds: dict[str, Column] = {}
    for key, by in slopes.items():
        rows = [(np.asarray(value[c]), np.asarray(error[c]), *by[c]) for c in by]
        if key in value:
            # a parameter acts through the constants and by itself: its derivative at fixed constants is added
            rows.append((np.asarray(value[key]), np.asarray(error[key]), np.ones(()), np.zeros(())))
        with np.errstate(all="ignore"):
            total = np.sum(np.stack([a * b for a, _, b, _ in rows]), axis=0)
            # the product rule of errors, term by term: terms may cancel, their errors do not
            open_ = [np.abs(b) * δa + np.abs(a) * δb + 4 * EPS * np.abs(a * b) for a, δa, b, δb in rows]
            left = np.sum(np.stack(open_), axis=0)
        pair = isinstance(next(iter(value.values())), tuple)
        found[key], bounds[key] = ((total[0], total[1]), (left[0], left[1])) if pair else (total, left)
    return found, bounds
