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

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import AtTimes, Mpf, Numbers, Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER, RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Tape
from hjsolve.coordinates.chart import Chart
from hjsolve.motion.charted.curvilinear_states import bounds_in_users_coordinates, in_users_coordinates
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.positions import tape_of
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
    found = _evaluated(chart, tape, values, state)
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


def _evaluated(chart: Chart, made: Made, values: Mapping[sp.Symbol, sp.Expr], state: State) -> list[Numbers]:
    tape, fixed = made
    arrays = _inputs(chart, state.q, state.p)
    if arrays[0].dtype != object:
        approximate = [float(to_bits(values[s])(64)) for s in fixed]
        with np.errstate(all="ignore"):
            return [np.broadcast_to(x, arrays[0].shape) for x in tape.run(Float64(), [*arrays, *approximate])]
    bits = _bits(arrays)
    numbers = [to_bits(values[s])(bits) for s in fixed]
    rows = [_in_many_digits(tape, bits, row, numbers) for row in zip(*arrays, strict=True)]
    return [np.array(column, dtype=object) for column in zip(*rows, strict=True)]


def _bits(arrays: list[Numbers]) -> int:
    return max((x.context.prec for x in arrays[0] if hasattr(x, "context")), default=128)


def _in_many_digits(tape: Tape, bits: int, row: tuple[Mpf | float, ...], numbers: list[Mpf]) -> list[Mpf]:
    """One row; NaN where the motion has ended."""
    field = Multi(bits)
    inputs = [field.convert(x) for x in row]
    if any(x != x for x in inputs):
        return [field.context.nan] * len(tape.outputs)
    return list(tape.run(field, [*inputs, *numbers]))


def _bounds(
    chart: Chart, made: Made, values: Mapping[sp.Symbol, sp.Expr], state: State, found: list[Numbers]
) -> list[Reals]:
    """Error bounds of the formulas, each of the shape of its values."""
    tape, fixed = made
    places = [np.asarray(x, dtype=float) for x in _inputs(chart, state.q, state.p)]
    uncertainties = [np.asarray(x, dtype=float) for x in _inputs(chart, state.error.q, state.error.p)]
    many = found[0].dtype == object
    bits = _bits([found[0]]) if many else 53
    field, unit = RunningError(Float64(), bits=bits), 2.0**-bits
    inputs = [WithErrorBound(x, e) for x, e in zip(places, uncertainties, strict=True)]
    numbers = (np.asarray(float(to_bits(values[s])(64))) for s in fixed)
    inputs += [WithErrorBound(x, unit * np.abs(x)) for x in numbers]
    with np.errstate(all="ignore"):
        outputs = tape.run(field, inputs)
        result = [np.broadcast_to(0.0 if x.error is None else SECOND_ORDER * x.error, places[0].shape) for x in outputs]
        n, k = len(chart.original.coordinates), len(chart.outer.place)
        lost = np.zeros(places[0].shape, dtype=bool)
        for h, error in zip(outputs[k + 2 * n :], result[k + 2 * n :], strict=True):
            lost |= ~(_LOST * error < h.value)
        velocities = [np.where(lost & (places[0] == places[0]), np.inf, e) for e in result[k : k + 2 * n]]
        points = [np.asarray(x, dtype=float) for x in found[:k]]
        return bounds_in_users_coordinates(chart.outer, points, [*result[:k], *velocities], bits)


def _tape(chart: Chart, resting: tuple[str, ...]) -> Made:
    fixed = tuple(s.symbol for s in chart.system.parameters)
    momenta = tuple(chart.system.coordinate(name).momentum for name in chart.coordinates)
    return tape_of(formulas_of(chart, resting), (*chart.symbols, *momenta, *fixed)), fixed
