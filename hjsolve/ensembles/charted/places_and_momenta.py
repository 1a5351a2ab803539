"""Places and momenta of orbits in the separated coordinates, in doubles with bounds on their errors.

û comes from the inverse formulas and Newton's method, whose last step tells its error; p̂ is what the momentum would be
if û were the place. Numpy and compiled programs run the same formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Generic, NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import N, Reals
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Arithmetic
from hjsolve.ensembles.charted.chart_map import ChartMap
from hjsolve.ensembles.charted.inverse_arrays import inverse_arrays
from hjsolve.ensembles.charted.momenta_to_32_digits import literals, rounded
from hjsolve.ensembles.engine.orbit_vectors import run_in_vectors, vector_text
from hjsolve.ensembles.engine.program_texts import OWN
from hjsolve.ensembles.engine.programs import program

_STEPS = {"ellipsoidal": 3, "paraboloidal": 3, "conical": 3}
"""Newton steps by kind, where it is not one."""
_SAFETY = 2
_CONVERGED = 1e-6


class SeparatedStarts(NamedTuple):
    """Of n orbits, rows in the order of the system.

    Attributes:
        q, loss: û, NaN where it could not be had, and bounds on its errors, shape (coordinates, n).
        p, p_loss: p̂, and bounds on what it is off from the momentum at u, the same shape.
        slope, bend: F′ and F″ at û of the separated coordinates, shape (separated, n).
    """

    q: Reals
    loss: Reals
    p: Reals
    p_loss: Reals
    slope: Reals
    bend: Reals


def carried(chart: ChartMap, x: Reals, rates: Reals, *, compiled: bool) -> SeparatedStarts:
    """Carry places and momenta or velocities to the separated coordinates.

    Args:
        chart: the map.
        x, rates: in the user's coordinates, shape (coordinates, n).
        compiled: whether by numba.
    """
    n, m = len(x), len(chart.model.separated)
    X = chart.local.run(Float64(), [*x, *_high(chart)])
    near = _inside(chart, inverse_arrays(chart.kind, [np.broadcast_to(row, x.shape[1:]) for row in X], chart.lengths))
    if compiled:
        rows = run_in_vectors(_compiled(chart), np.concatenate([near, x, rates]), 4 * n + 2 * m)
    else:
        found = _formulas(chart, Float64(), 2, _Given(near, [*x], [*rates]), _high(chart), rounded(chart.numbers))
        rows = np.stack([np.broadcast_to(row, x.shape[1:]) for row in found])
    q, *others = np.split(rows, np.cumsum([n, n, n, n, m]))
    order = list(chart.order)
    converged = (others[0] < _CONVERGED * (1 + np.abs(q))).all(axis=0)
    q, loss, p, p_loss = (block[order] for block in (np.where(converged, q, np.nan), *others[:3]))
    return SeparatedStarts(q, loss, p, p_loss, *others[3:])


class _Given(NamedTuple, Generic[N]):
    """Coordinates next to û in the order of the chart, and the user's."""

    near: Sequence[N]
    x: Sequence[N]
    rates: Sequence[N]


def _formulas(
    chart: ChartMap, plain: Arithmetic[N], own: int, given: _Given[N], numbers: Sequence[N],
    bounded: Sequence[WithErrorBound[N]],
) -> list[N]:  # fmt: skip
    """û, bounds on its errors, p̂ and bounds on its errors in the order of the chart, F′, F″."""
    errors = RunningError(plain, own=own)

    def known(value: N | None) -> N:
        return plain.rational(0, 1) if value is None else value

    u = list(given.near)
    for _ in range(_STEPS.get(chart.kind, 1)):
        u = [plain.add(a, b) for a, b in zip(u, chart.step.run(plain, [*u, *given.x, *numbers]), strict=True)]
    steps = chart.step.run(errors, [*(WithErrorBound(row) for row in (*u, *given.x)), *bounded])
    sizes = [plain.add(plain.unary("abs", step.value), known(step.error)) for step in steps]
    loss = [plain.mul(plain.rational(_SAFETY, 1), size) for size in sizes]
    inputs = [WithErrorBound(a, e) for a, e in zip(u, loss, strict=True)] + [WithErrorBound(w) for w in given.rates]
    lifted = chart.lifted.run(errors, [*inputs, *bounded])
    parameters = [plain.rational(*x.high.as_integer_ratio()) for x in chart.model.numbers]
    places, momenta = [u[k] for k in chart.order], [lifted[k].value for k in chart.order]
    constants = chart.model.rule.run(plain, [*places, *momenta, *parameters])
    jets = Jets(plain)
    fixed = [*map(Jet, constants), *map(Jet, parameters)]
    squares = [c.plain.squared.run(jets, [jets.variable(places[c.index]), *fixed])[0] for c in chart.model.separated]
    slopes, bends = [known(s.first) for s in squares], [known(s.second) for s in squares]
    return [*u, *loss, *(r.value for r in lifted), *(known(r.error) for r in lifted), *slopes, *bends]


def _inside(chart: ChartMap, u: list[Reals]) -> list[Reals]:
    """(−u, −v) for (u, v) where one of them has to be positive; NaN on the edge, where V has a crease."""
    for k, (positive, half) in enumerate(chart.edges):
        if positive and chart.kind.startswith(("elliptic", "parabolic")):
            edge = (u[k] == 0) | (half & (np.abs(u[k]) >= np.pi))
            sign = np.where(edge, np.nan, np.where(u[k] < 0, -1.0, 1.0))
            return [sign * u[0], sign * u[1], *u[2:]]
    return u


def _high(chart: ChartMap) -> list[float]:
    return [float(x.high) for x in chart.numbers]


# ------------------------------------------------------------------------------------------------------- compiled
@lru_cache(maxsize=64)
def _compiled(chart: ChartMap) -> Callable[..., None]:
    source, n = PythonSource(), len(chart.order)
    given = _Given(*([f"g{first + k}" for k in range(n)] for first in (0, n, 2 * n)))
    numbers = [f"({x!r})" for x in _high(chart)]
    results = _formulas(chart, source, OWN, given, numbers, literals(chart.numbers))
    return program(vector_text("carried", 3 * n, source, results), "carried")
