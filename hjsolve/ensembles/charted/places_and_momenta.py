"""Positions and momenta of orbits in the separated coordinates, in doubles with bounds on their errors.

û comes from the inverse formulas and Newton's method, whose last step gives its error; p̂ is what the momentum would be
if û were the position.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.ensembles.charted.chart_map import ChartMap
from hjsolve.ensembles.charted.momenta_to_32_digits import ChartFormulas, formulas_of, known_values, parameter_values
from hjsolve.motion.charted.inverse_charts import inverse_chart

_NEWTON_STEPS = {"ellipsoidal": 3, "paraboloidal": 3, "conical": 3}
"""Newton steps by kind, where it is not one."""
_ERROR_FACTOR = 2  # times first-order bounds, for the terms of second order
_CONVERGED = 1e-6
"""Last step of Newton's method, over 1 + |q|, above which a place is not known: the next one would be below 1e-12."""


class SeparatedStarts(NamedTuple):
    """What is known of n orbits, rows in the order of the system.

    Attributes:
        q, loss: û, NaN where Newton's method did not converge, and bounds on its errors, shape (coordinates, n).
        p, p_loss: p̂, and bounds on what it is off from the momentum at u, the same shape.
        slope, bend: F′ and F″ at û of the separated coordinates, shape (separated, n).
    """

    q: Reals
    loss: Reals
    p: Reals
    p_loss: Reals
    slope: Reals
    bend: Reals


def carried(chart: ChartMap, x: Reals, rates: Reals) -> SeparatedStarts:
    """Carry positions and momenta or velocities to the separated coordinates.

    Args:
        x, rates: in the user's coordinates, shape (coordinates, n).
    """
    n, m = len(x), len(chart.model.separated)
    X = chart.local.run(Float64(), [*x, *(float(c.high) for c in chart.numbers)])
    places, onward = [np.broadcast_to(row, x.shape[1:]) for row in X], [0.0] * len(X)
    # inverse formulas lose digits next to edges of the web; Newton's steps in the forward map give them back
    near = _inside(chart, inverse_chart(chart.kind, places, onward, chart.lengths, Float64()))
    code = _written(formulas_of(chart), _NEWTON_STEPS.get(chart.kind, 1))
    rows = run_rows(code, parameter_values(chart), np.concatenate([near, x, rates]))
    q, *others = np.split(rows, np.cumsum([n, n, n, n, m]))
    order = list(chart.order)
    converged = (others[0] < _CONVERGED * (1 + np.abs(q))).all(axis=0)
    q, loss, p, p_loss = (block[order] for block in (np.where(converged, q, np.nan), *others[:3]))
    return SeparatedStarts(q, loss, p, p_loss, *others[3:])


@lru_cache(maxsize=64)
def _written(formulas: ChartFormulas, steps: int) -> MachineCode:
    """û, bounds on its errors, p̂ and bounds on its errors in the order of the chart, F′, F″."""
    plain, n = InstructionWriter(), len(formulas.order)
    errors, (u, x, rates) = RunningError(plain, own=ROUNDINGS), (plain.inputs(n) for _ in range(3))
    known, _ = known_values(plain, formulas)
    numbers, parameters = [k.value for k in known.numbers], [k.value for k in known.parameters]

    def or_zero(value: Value | None) -> Value:
        return plain.number(0.0) if value is None else value

    for _ in range(steps):
        u = [plain.add(a, b) for a, b in zip(u, formulas.step.run(plain, [*u, *x, *numbers]), strict=True)]
    # one more step, not taken: it is the error of û, with the rounding of the step itself
    last = formulas.step.run(errors, [*(WithErrorBound(row) for row in (*u, *x)), *known.numbers])
    sizes = [plain.add(plain.unary("abs", step.value), or_zero(step.error)) for step in last]
    loss = [plain.mul(plain.number(_ERROR_FACTOR), size) for size in sizes]
    # p̂ is what the momentum would be at û: its error is that of the lift at a place known to δu
    inputs = [WithErrorBound(a, e) for a, e in zip(u, loss, strict=True)] + [WithErrorBound(w) for w in (*x, *rates)]
    lifted = formulas.lifted.run(errors, [*inputs, *known.numbers])
    places, momenta = [u[k] for k in formulas.order], [lifted[k].value for k in formulas.order]
    constants = formulas.rule.run(plain, [*places, *momenta, *parameters])
    jets = Jets(plain)
    fixed = [*map(Jet, constants), *map(Jet, parameters)]
    squares = [
        tape.run(jets, [jets.variable(places[k]), *fixed])[0]
        for tape, k in zip(formulas.squares, formulas.separated, strict=True)
    ]
    slopes, bends = [or_zero(s.first) for s in squares], [or_zero(s.second) for s in squares]
    momenta_and_errors = [*(r.value for r in lifted), *(or_zero(r.error) for r in lifted)]
    return plain.code([*u, *loss, *momenta_and_errors, *slopes, *bends])


def _inside(chart: ChartMap, u: list[Reals]) -> list[Reals]:
    """(−u, −v) for (u, v) where one of them has to be positive; NaN on the edge, where V has a crease."""
    for k, (positive, half) in enumerate(chart.edges):
        if positive and chart.kind.startswith(("elliptic", "parabolic")):
            edge = (u[k] == 0) | (half & (np.abs(u[k]) >= np.pi))
            sign = np.where(edge, np.nan, np.where(u[k] < 0, -1.0, 1.0))
            return [sign * u[0], sign * u[1], *u[2:]]
    return u
