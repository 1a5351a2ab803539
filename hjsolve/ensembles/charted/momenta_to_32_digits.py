"""Momenta of starts to 32 digits: what ``charted_starts`` needs of the map in two doubles.

The exact position u comes from û by Newton's method, p_u and the constants there, then √F(û), all in two doubles;
bounds on what doubles lose of them come from a running error.

Here x and ``rates`` are in the user's coordinates and q is û, in the order of the system, each of shape (coordinates,
n).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.machine.elementary import ROUNDINGS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.pair_writer import PairOfValues, PairWriter
from hjsolve.arithmetic.machine.writer import InstructionWriter, MachineCode, Value
from hjsolve.arithmetic.number_types import N, Reals
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.arithmetic.tape import Arithmetic, Tape
from hjsolve.ensembles.charted.chart_map import ChartMap

T = TypeVar("T")
_UNIT = 2.0**-53
_NEWTON = 2


class ExactStarts(NamedTuple):
    """What is known of n orbits, rows in the order of the system.

    Attributes:
        high, low: the momenta p_u at the exact position, shape (coordinates, n).
        lost: bounds on what doubles lose of them, the same shape.
        roots, roots_low: √F(û) of the separated coordinates, shape (separated, n).
        uncertainties: bounds on what doubles lose of F(û), the same shape.
    """

    high: Reals
    low: Reals
    lost: Reals
    roots: Reals
    roots_low: Reals
    uncertainties: Reals


class ChartFormulas(NamedTuple):
    """The formulas of a map and of the system that it leads to, without the values of their parameters.

    Attributes:
        step, lifted, rule: of ``ChartMap`` and of its ``Model``.
        squares: F of the separated coordinates.
        separated: positions of these coordinates in the system.
        order: of ``ChartMap``.
        numbers, parameters: how many the map and the system have.
    """

    step: Tape
    lifted: Tape
    rule: Tape
    squares: tuple[Tape, ...]
    separated: tuple[int, ...]
    order: tuple[int, ...]
    numbers: int
    parameters: int


def formulas_of(chart: ChartMap) -> ChartFormulas:
    """Return the formulas of a map."""
    parts = chart.model.separated
    return ChartFormulas(
        chart.step, chart.lifted, chart.model.rule, tuple(c.plain.squared for c in parts),
        tuple(c.index for c in parts), chart.order, len(chart.numbers), len(chart.model.numbers),
    )  # fmt: skip


def exact_starts(chart: ChartMap, q: Reals, x: Reals, rates: Reals) -> ExactStarts:
    """Compute the momenta."""
    n, m = len(q), len(chart.model.separated)
    formulas, known, given = formulas_of(chart), parameter_values(chart), np.concatenate([q, x, rates])
    made = run_rows(_starts(formulas, True), known, given)
    far = np.flatnonzero(~np.isfinite(made).all(axis=0))
    if len(far):  # û is not so near to u that sines come from those nearby, or there is no number
        made[:, far] = run_rows(_starts(formulas, False), known, given[:, far])
    return ExactStarts(*np.split(made, np.cumsum([n, n, n, m, m])))


def exact_point(chart: ChartMap, q: Reals, x: Reals, rates: Reals) -> list[Pair]:
    """Return the exact positions u in two doubles, in the order of the system."""
    made = run_rows(_point(formulas_of(chart)), parameter_values(chart), np.concatenate([q, x, rates]))
    return [Pair(*both) for both in zip(*np.split(made, 2), strict=True)]


# ---------------------------------------------------------------------------------------- formulas, in any arithmetic
def exactly(
    formulas: ChartFormulas, pairs: Arithmetic[N], numbers: Sequence[N], parameters: Sequence[N], q: Sequence[N],
    x: Sequence[N], rates: Sequence[N], *, moved: Callable[[N, N], N],
) -> tuple[list[N], list[N], list[N], list[N]]:  # fmt: skip
    """Return u, p_u, the constants and √F(û), in the order of the system.

    Args:
        pairs: an arithmetic of two doubles, or of more digits.
        numbers, parameters: values of the map's and the system's.
        q: û, in the order of the system.
        moved: adds a small step to a position.
    """
    u = in_order_of_chart(formulas.order, q)
    for _ in range(_NEWTON):
        u = [moved(a, b) for a, b in zip(u, formulas.step.run(pairs, [*u, *x, *numbers]), strict=True)]
    lifted = formulas.lifted.run(pairs, [*u, *x, *rates, *numbers])
    places, momenta = [u[k] for k in formulas.order], [lifted[k] for k in formulas.order]
    constants = formulas.rule.run(pairs, [*places, *momenta, *parameters])
    squares = [
        tape.run(pairs, [q[k], *constants, *parameters])[0]
        for tape, k in zip(formulas.squares, formulas.separated, strict=True)
    ]
    return places, momenta, constants, [pairs.unary("sqrt", F) for F in squares]


def _rounding(
    formulas: ChartFormulas, errors: RunningError[N], known: Known[N], given: tuple[list[N], list[N], list[N]],
    constants: list[N],
) -> tuple[list[N], list[N]]:  # fmt: skip
    """Return what doubles lose of p_u and of F(û); two doubles lose 2⁻⁴⁴ of it at most."""
    q, x, rates = given
    # the same formulas once in doubles with bounds: two doubles lose 2⁻⁴⁴ of that
    start = [WithErrorBound(row) for row in (*in_order_of_chart(formulas.order, q), *x)]
    steps = [r.error for r in formulas.step.run(errors, [*start, *known.numbers])]
    inputs = [WithErrorBound(a, e) for a, e in zip(in_order_of_chart(formulas.order, q), steps, strict=True)]
    lifted = formulas.lifted.run(errors, [*inputs, *(WithErrorBound(row) for row in (*x, *rates)), *known.numbers])
    momenta, places = [lifted[k] for k in formulas.order], [inputs[k] for k in formulas.order]
    uncertain = [r.error for r in formulas.rule.run(errors, [*places, *momenta, *known.parameters])]
    bounded = [WithErrorBound(c, e) for c, e in zip(constants, uncertain, strict=True)]
    squares = [
        tape.run(errors, [WithErrorBound(q[k]), *bounded, *known.parameters])[0]
        for tape, k in zip(formulas.squares, formulas.separated, strict=True)
    ]
    nothing = errors.plain.rational(0, 1)
    lost, uncertainties = ([nothing if r.error is None else r.error for r in found] for found in (momenta, squares))
    return lost, uncertainties


def in_order_of_chart(order: Sequence[int], rows: Iterable[T]) -> list[T]:
    """Return rows of the system in the order of the chart.

    Args:
        order: position of each coordinate of the system in the chart.
        rows: one for each coordinate.
    """
    own = list(rows)
    found = own.copy()
    for row, k in zip(own, order, strict=True):
        found[k] = row
    return found


# ------------------------------------------------------------------------------------------ programs of the machine
class Known(NamedTuple, Generic[N]):
    """Numbers of the map, and parameters of the system, with bounds on their rounding."""

    numbers: list[WithErrorBound[N]]
    parameters: list[WithErrorBound[N]]


def parameter_values(chart: ChartMap) -> list[float]:
    """Return the values of the parameters that ``known_values`` has written into a program."""
    return [
        value
        for high, low in (map(float, pair) for pair in (*chart.numbers, *chart.model.numbers))
        for value in (high, low, _UNIT * abs(high) if low else 0.0)
    ]


def known_values(writer: InstructionWriter, formulas: ChartFormulas) -> tuple[Known[Value], list[PairOfValues]]:
    """Return the values of a map and the parameters of its system: in doubles with bounds, and in two doubles.

    Args:
        writer: of the program, whose parameters they become.
    """
    rows = [writer.parameters(3) for _ in range(formulas.numbers + formulas.parameters)]
    bounded, pairs = [WithErrorBound(row[0], row[2]) for row in rows], [PairOfValues(row[0], row[1]) for row in rows]
    return Known(bounded[: formulas.numbers], bounded[formulas.numbers :]), pairs


@lru_cache(maxsize=64)
def _starts(formulas: ChartFormulas, near: bool) -> MachineCode:
    """Return the rows of ``ExactStarts``; with ``near`` functions of u come from those of û."""
    writer, n = InstructionWriter(), len(formulas.order)
    pairs, (q, x, rates) = PairWriter(writer), (writer.inputs(n) for _ in range(3))
    known, exact = known_values(writer, formulas)
    _, momenta, constants, roots = exactly(
        formulas, pairs, exact[: formulas.numbers], exact[formulas.numbers :],
        *([pairs.of(value) for value in block] for block in (q, x, rates)),
        # sines of a place a rounding away follow by the addition theorem from those of û
        moved=pairs.displaced if near else pairs.add,
    )  # fmt: skip
    lost, uncertainties = _rounding(
        formulas, RunningError(writer, own=ROUNDINGS), known, (q, x, rates), [c.high for c in constants]
    )
    return writer.code([
        *(p.high for p in momenta), *(p.low for p in momenta), *lost,
        *(r.high for r in roots), *(r.low for r in roots), *uncertainties,
    ])  # fmt: skip


@lru_cache(maxsize=64)
def _point(formulas: ChartFormulas) -> MachineCode:
    """Return the exact positions, high parts and then low ones."""
    writer, n = InstructionWriter(), len(formulas.order)
    pairs = PairWriter(writer)
    blocks = [[pairs.of(value) for value in writer.inputs(n)] for _ in range(3)]
    _, exact = known_values(writer, formulas)
    numbers, parameters = exact[: formulas.numbers], exact[formulas.numbers :]
    places, *_ = exactly(formulas, pairs, numbers, parameters, *blocks, moved=pairs.add)
    return writer.code([*(p.high for p in places), *(p.low for p in places)])
