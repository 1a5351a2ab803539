"""Equations of motion solved by Taylor series to many digits: the witness that trajectories are measured against.

It shares nothing with the quadratures: no separation, no turning points, no time law. The right-hand side, a ``Tape``,
is run once over power series (``arithmetic.power_series``; Jorba & Zou, Experimental Mathematics 14 (2005) 99). Numbers
are integers in units of 2^−P, and the k-th coefficient is that of hᵏ, so that all of them are of the size of the state.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.power_series import ConstantSeries, FixedPoint, SeriesProgram, Slot
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import NotConvergedError

Series = list[int]
_LONGEST_STRETCH, _MOST_TRIALS, _TAIL, _PATIENCE = 1.25, 200, 8, 0.4


def follow(slopes: Tape, start: Mpf, state: Sequence[Mpf], constants: Sequence[Mpf], times: Sequence[Mpf], digits: int,
           *, deadline: float = math.inf) -> list[list[Mpf]]:  # fmt: skip
    """Solve y′ = f(y) and give y at given times.

    Args:
        slopes: f; its inputs are the state and then the constants.
        start: the initial time, mpf.
        state: y there, mpf, length n.
        constants: mpf.
        times: mpf, in increasing distance from the start, all on one side of it.
        digits: decimal digits of a step.
        deadline: the moment of ``time.perf_counter`` by which to be done; given up as soon as that cannot be.

    Returns:
        y at the times reached, mpf; fewer than asked where the deadline came first.

    Raises:
        NotConvergedError: the solution runs into a singularity.
    """
    order = math.ceil(digits * math.log(10) / 2) + 2
    sizes = [abs(float(y)) for y in state if y]
    small = max(0, -math.frexp(min(sizes))[1]) if sizes else 0
    program = SeriesProgram(FixedPoint(math.ceil(3.33 * digits) + order // 3 + 64 + small))
    numbers = program.numbers
    inputs = [program.new() for _ in state]
    slots: list[Slot[int]] = [*inputs, *(ConstantSeries(numbers.plain.convert(c)) for c in constants)]
    rates = slopes.run(program, slots)
    derivatives = [program.coefficients(rate) for rate in rates]
    values, now, found = [numbers.of(y) for y in state], numbers.plain.convert(start), list[list[Mpf]]()
    step = _first_step(numbers.plain, times, now)
    begun, far = time.perf_counter(), max((abs(t - now) for t in times), default=0)
    for goal in times:
        while now != goal:
            spent, gone = time.perf_counter() - begun, abs(now - start)
            if spent > _PATIENCE and (not gone or begun + spent * float(far / gone) > deadline):
                return found
            values, now, step = _stepped(program, inputs, derivatives, order, digits, values, now, goal, step)
        found.append([numbers.real(value) for value in values])
    return found


def _first_step(plain: Multi, times: Sequence[Mpf], now: Mpf) -> Mpf:
    ahead = [t - now for t in times if t != now]
    return plain.context.convert(ahead[0] / 1024) if ahead else plain.context.mpf(1)


def _stepped(program: SeriesProgram[int], inputs: list[Series], derivatives: list[Callable[[int], int]], order: int,
             digits: int, values: Series, now: Mpf, goal: Mpf, step: Mpf) -> tuple[Series, Mpf, Mpf]:  # fmt: skip
    """One step towards the goal, as long as the series of the state allows."""
    left, numbers = goal - now, program.numbers
    for _ in range(_MOST_TRIALS):
        try:
            _expand(program, inputs, derivatives, order, values, numbers.of(step))
        except ZeroDivisionError:
            raise NotConvergedError("the Taylor series met a division by zero") from None
        reach = _reach(inputs, order, digits)
        if reach <= _LONGEST_STRETCH or abs(left) <= abs(step):
            break
        step = step * min(reach, 1024.0)
    part = min(reach, _LONGEST_STRETCH)
    if part * abs(float(step)) < 1e-12 * max(1e-3, abs(float(now)), abs(float(left))):
        raise NotConvergedError(f"the Taylor series stops near t = {float(now):.12g}")
    last = abs(left) <= abs(step) * part
    ratio = numbers.of(left / step if last else numbers.plain.context.mpf(part))
    result = []
    for series in inputs:
        total = 0
        for coefficient in reversed(series):
            total = numbers.product(total * ratio) + coefficient
        result.append(total)
    longer = step * part
    return result, (goal if last else now + numbers.real(ratio) * step), longer


def _expand(program: SeriesProgram[int], inputs: list[Series], derivatives: list[Callable[[int], int]], order: int,
            values: Series, step: int) -> None:  # fmt: skip
    """All coefficients of one step."""
    program.restart()
    for series, value in zip(inputs, values):
        series.append(value)
    for k in range(order):
        program.extend(k)
        for series, derivative in zip(inputs, derivatives):
            series.append(program.numbers.mean(derivative(k) * step, k + 1))


def _reach(inputs: list[Series], order: int, digits: int) -> float:
    """Return how many steps long the step may be so that the last terms are negligible; ∞ for a polynomial.

    Two terms are too few: by symmetry several in a row may vanish (a pendulum released at 90°: three of four).
    """
    scale = math.log2(max(1, *(abs(series[0]) for series in inputs)))
    goal = scale - digits * math.log2(10)
    bounds = []
    for k in range(order - _TAIL, order + 1):
        size = max(abs(series[k]) for series in inputs)
        if size > 1:
            bounds.append(2 ** ((goal - math.log2(size)) / k))
    return min(bounds, default=math.inf)
