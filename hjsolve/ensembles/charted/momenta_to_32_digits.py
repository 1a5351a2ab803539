"""Momenta of starts to 32 digits: what ``charted_starts`` needs of the map in two doubles, by numpy or compiled.

The exact place u is had by Newton's method from û, p_u and the constants there, then √F(û), all in two doubles; bounds
on what doubles lose of them come from a running error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Elementwise, N, Reals
from hjsolve.arithmetic.pair_source import NamedPair, PairSource, written
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Arithmetic
from hjsolve.ensembles.charted.chart_map import ChartMap
from hjsolve.ensembles.engine.orbit_vectors import run_in_vectors, vector_text
from hjsolve.ensembles.engine.program_texts import OWN
from hjsolve.ensembles.engine.programs import program

T = TypeVar("T")
_UNIT = 2.0**-53
_NEWTON = 2
_DOUBLES = DoubleDouble()


class ExactStarts(NamedTuple):
    """Of n orbits, rows in the order of the system.

    Attributes:
        high, low: the momenta p_u at the exact place, shape (coordinates, n).
        lost: bounds on what doubles lose of them, the same shape.
        roots, roots_low: √F(û) of the separated coordinates, shape (separated, n).
        doubts: bounds on what doubles lose of F(û), the same shape.
    """

    high: Reals
    low: Reals
    lost: Reals
    roots: Reals
    roots_low: Reals
    doubts: Reals


def exact_starts(chart: ChartMap, q: Reals, x: Reals, rates: Reals, *, compiled: bool) -> ExactStarts:
    """Work them out.

    Args:
        chart: the map.
        q: û, in the order of the system, shape (coordinates, n).
        x, rates: in the user's coordinates.
        compiled: whether by numba.
    """
    if compiled:
        n, m = len(q), len(chart.model.separated)
        made = run_in_vectors(_compiled(chart), np.concatenate([q, x, rates]), 3 * (n + m))
        far = np.flatnonzero(~np.isfinite(made).all(axis=0))
        if len(far):  # where û is not so near to u, or there is no number
            made[:, far] = np.concatenate(exact_starts(chart, q[:, far], x[:, far], rates[:, far], compiled=False))
        return ExactStarts(*np.split(made, np.cumsum([n, n, n, m, m])))
    _, momenta, constants, roots = _exactly(
        chart, _DOUBLES, chart.numbers, chart.model.numbers,
        *([Pair(row, 0.0 * row) for row in block] for block in (q, x, rates)), moved=_DOUBLES.add,
    )  # fmt: skip
    lost, doubts = _rounding(
        chart, RunningError(Float64()), rounded(chart.numbers), rounded(chart.model.numbers),
        (list(q), list(x), list(rates)), [c.high for c in constants],
    )  # fmt: skip
    blocks = [p.high for p in momenta], [p.low for p in momenta], lost, [r.high for r in roots], [r.low for r in roots]
    return ExactStarts(*(np.stack([np.broadcast_to(r, q.shape[1:]) for r in rows]) for rows in (*blocks, doubts)))


def exact_point(chart: ChartMap, q: Reals, x: Reals, rates: Reals) -> list[Pair]:
    """The exact places u in two doubles, in the order of the system.

    Args:
        chart: the map.
        q: û, in the order of the system, shape (coordinates, n).
        x, rates: in the user's coordinates.
    """
    blocks = ([Pair(row, 0.0 * row) for row in block] for block in (q, x, rates))
    return _exactly(chart, _DOUBLES, chart.numbers, chart.model.numbers, *blocks, moved=_DOUBLES.add)[0]


# ------------------------------------------------------------------------------- formulas, in numbers or in names
def _exactly(
    chart: ChartMap, pairs: Arithmetic[N], numbers: Sequence[N], parameters: Sequence[N], q: list[N], x: list[N],
    rates: list[N], *, moved: Callable[[N, N], N],
) -> tuple[list[N], list[N], list[N], list[N]]:  # fmt: skip
    """u, p_u, the constants and √F(û), in an arithmetic of two doubles; ``moved`` adds a small step to a place."""
    u = in_order_of_chart(chart, q)
    for _ in range(_NEWTON):
        u = [moved(a, b) for a, b in zip(u, chart.step.run(pairs, [*u, *x, *numbers]), strict=True)]
    lifted = chart.lifted.run(pairs, [*u, *rates, *numbers])
    places, momenta = [u[k] for k in chart.order], [lifted[k] for k in chart.order]
    constants = chart.model.rule.run(pairs, [*places, *momenta, *parameters])
    squares = [c.plain.squared.run(pairs, [q[c.index], *constants, *parameters])[0] for c in chart.model.separated]
    return places, momenta, constants, [pairs.unary("sqrt", F) for F in squares]


def _rounding(
    chart: ChartMap, errors: RunningError[N], numbers: list[WithErrorBound[N]], parameters: list[WithErrorBound[N]],
    given: tuple[list[N], list[N], list[N]], constants: list[N],
) -> tuple[list[N], list[N]]:  # fmt: skip
    """What doubles lose of p_u and of F(û); two doubles lose 2⁻⁴⁴ of it at most."""
    q, x, rates = given
    start = [WithErrorBound(row) for row in (*in_order_of_chart(chart, q), *x)]
    steps = [r.error for r in chart.step.run(errors, [*start, *numbers])]
    inputs = [WithErrorBound(a, e) for a, e in zip(in_order_of_chart(chart, q), steps, strict=True)]
    lifted = chart.lifted.run(errors, [*inputs, *(WithErrorBound(row) for row in rates), *numbers])
    momenta, places = [lifted[k] for k in chart.order], [inputs[k] for k in chart.order]
    uncertain = [r.error for r in chart.model.rule.run(errors, [*places, *momenta, *parameters])]
    known = [WithErrorBound(c, e) for c, e in zip(constants, uncertain, strict=True)]
    squares = [
        c.plain.squared.run(errors, [WithErrorBound(q[c.index]), *known, *parameters])[0]
        for c in chart.model.separated
    ]
    nothing = errors.plain.rational(0, 1)
    lost, doubts = ([nothing if r.error is None else r.error for r in found] for found in (momenta, squares))
    return lost, doubts


def in_order_of_chart(chart: ChartMap, rows: Iterable[T]) -> list[T]:
    """Rows of the system in the order of the chart.

    Args:
        chart: the map.
        rows: one for each coordinate.
    """
    own = list(rows)
    found = own.copy()
    for row, k in zip(own, chart.order, strict=True):
        found[k] = row
    return found


def rounded(numbers: Sequence[Pair]) -> list[WithErrorBound[Elementwise]]:
    """Return numbers in two doubles as doubles with bounds on their errors.

    Args:
        numbers: the pairs.
    """
    return [WithErrorBound(x.high, _UNIT * abs(x.high) if x.low else None) for x in numbers]


# ------------------------------------------------------------------------------------------------------- compiled
@lru_cache(maxsize=64)
def _compiled(chart: ChartMap) -> Callable[..., None]:
    return program(_text(chart), "exact_starts")


def _text(chart: ChartMap) -> str:
    """The text of a function that makes the rows of ``ExactStarts``; functions of u are had from those of û."""
    source = PythonSource()
    pairs, n = PairSource(source), len(chart.order)
    q, x, rates = ([f"g{first + k}" for k in range(n)] for first in (0, n, 2 * n))
    _, momenta, constants, roots = _exactly(
        chart, pairs, [*map(written, chart.numbers)], [*map(written, chart.model.numbers)],
        *([NamedPair(name, "(0.0)") for name in block] for block in (q, x, rates)), moved=pairs.displaced,
    )  # fmt: skip
    lost, doubts = _rounding(
        chart, RunningError(source, own=OWN), literals(chart.numbers), literals(chart.model.numbers),
        (q, x, rates), [c.high for c in constants],
    )  # fmt: skip
    results = [
        *(p.high for p in momenta), *(p.low for p in momenta), *lost,
        *(r.high for r in roots), *(r.low for r in roots), *doubts,
    ]  # fmt: skip
    return vector_text("exact_starts", 3 * n, source, results)


def literals(numbers: Sequence[Pair]) -> list[WithErrorBound[str]]:
    """Return the literals of the same.

    Args:
        numbers: the pairs.
    """
    return [WithErrorBound(f"({x.high!r})", f"({abs(x.high) * _UNIT!r})" if x.low else None) for x in numbers]
