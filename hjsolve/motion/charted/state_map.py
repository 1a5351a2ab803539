"""States carried back to the user's coordinates, with their errors.

    x = origin + frame·X(u),  ẋ = frame·Σ (∂X/∂u_k) (p_k − a_k)/(m h_k²)

Then q, q̇, p by the outer map; a is zero but in a changed gauge.

The velocity of the separated coordinates is not used: next to a focus p_k and h_k² are small and well known, and their
quotient is not. Errors of u and p_u, and the rounding of every operation, are carried through the formulas to first
order (``arithmetic.running_error``) and doubled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import AtTimes, Numbers, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.coordinates.chart import Chart
from hjsolve.motion.charted.curvilinear_states import bounds_in_users_coordinates, in_users_coordinates
from hjsolve.motion.formulas_at_places import bits_in, bounded_at, tape_of, values_at
from hjsolve.motion.shapes import shaped
from hjsolve.motion.state import Errors, State

Made = tuple[Tape, tuple[sp.Symbol, ...]]
"""The formulas, and the parameters that are their last inputs."""
_LOST = 8
"""Where the error of an h² is more than its 8th part, nothing is known of the velocity."""


def formulas_of(chart: Chart, resting: tuple[str, ...] = ()) -> tuple[sp.Expr, ...]:
    """Return the point x, then q̇, then p of the user's coordinates, then h_k², in u, p_u and the parameters.

    Args:
        chart: how the coordinates are tied together.
        resting: separated coordinates whose momentum is zero; their h_k² may vanish, and are left out.
    """
    u, moving = chart.symbols, [name not in resting for name in chart.coordinates]
    momenta = [chart.system.coordinate(name).momentum for name in chart.coordinates]
    if chart.linear:
        momenta = [p - a for p, a in zip(momenta, chart.linear, strict=True)]
    # h_k² = 0 on the axis of an angle that rests: its rate is 0, not 0/0
    rates = [p / (chart.mass * h) if m else sp.S.Zero for p, h, m in zip(momenta, chart.scale, moving, strict=True)]
    local = [sum(sp.diff(X, s) * rate for s, rate in zip(u, rates, strict=True)) for X in chart.place]
    x = [o + row for o, row in zip(chart.origin, _times(chart.frame, chart.place), strict=True)]
    v = _times(chart.frame, local)
    scale = [h for h, m in zip(chart.scale, moving, strict=True) if m]
    rates, lifted = chart.outer.rates(x, v)
    return (*x, *rates, *lifted, *scale)


def _times(matrix: sp.MatrixBase, vector: Sequence[sp.Expr]) -> list[sp.Expr]:
    return [sp.Add(*(a * b for a, b in zip(row, vector, strict=True))) for row in matrix.tolist()]


def state_in(chart: Chart, values: Mapping[sp.Symbol, sp.Expr], state: State, resting: tuple[str, ...] = ()) -> State:
    """Return a state in the user's coordinates.

    Args:
        chart: how the coordinates are tied together.
        values: parameter → exact number.
        resting: separated coordinates whose momentum is zero.
    """
    names = [q.name for q in chart.original.coordinates]
    shape = np.shape(state.status)
    tape = _tape(chart, resting)
    found = values_at(tape[0], _inputs(chart, state.q, state.p), [values[s] for s in tape[1]])
    n, q = len(names), in_users_coordinates(chart.outer, found)

    def group(columns: Sequence[Numbers], k: int) -> dict[str, AtTimes]:
        return {name: shaped(columns[k * n + i], shape) for i, name in enumerate(names)}

    @cache
    def errors() -> Errors:
        bounds = _bounds(chart, tape, values, state, found)
        return Errors(group(bounds, 0), group(bounds, 2), group(bounds, 1))

    return State(state.t, group(q, 0), group(q, 2), group(q, 1), {}, state.status, errors)


def _inputs(chart: Chart, group: Mapping[str, AtTimes], other: Mapping[str, AtTimes]) -> list[Numbers]:
    """Return the arrays of two groups in the order of the formulas, flat."""
    return [np.ravel(np.asarray(g[name])) for g in (group, other) for name in chart.coordinates]


def _bounds(
    chart: Chart, made: Made, values: Mapping[sp.Symbol, sp.Expr], state: State, found: list[Numbers]
) -> list[Reals]:
    """Error bounds of the formulas, each of the shape of its values."""
    tape, fixed = made
    places, bits = _inputs(chart, state.q, state.p), bits_in(found[0])
    uncertainties = [np.asarray(x, dtype=float) for x in _inputs(chart, state.error.q, state.error.p)]
    outputs = bounded_at(tape, places, uncertainties, [values[s] for s in fixed], bits)
    result, n, k = [error for _, error in outputs], len(chart.original.coordinates), len(chart.outer.place)
    with np.errstate(all="ignore"):
        # first-order propagation of p/h² holds while the error of h² is a small part of it
        lost = np.zeros(places[0].shape, dtype=bool)
        for h, error in outputs[k + 2 * n :]:
            lost |= ~(_LOST * error < h)
        velocities = [np.where(lost & (places[0] == places[0]), np.inf, e) for e in result[k : k + 2 * n]]
        points = [np.asarray(x, dtype=float) for x in found[:k]]
        return bounds_in_users_coordinates(chart.outer, points, [*result[:k], *velocities], bits)


def _tape(chart: Chart, resting: tuple[str, ...]) -> Made:
    fixed = tuple(s.symbol for s in chart.system.parameters)
    momenta = tuple(chart.system.coordinate(name).momentum for name in chart.coordinates)
    return tape_of(formulas_of(chart, resting), (*chart.symbols, *momenta, *fixed)), fixed
