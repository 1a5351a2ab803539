"""Phases in many digits: Newton's method on Jacobi's equations, started from the phases in doubles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Context, Counts, Mpf, MpfMatrix, Numbers, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion
from hjsolve.time_law.torus import TorusEquations


def on_torus(
    system: TorusEquations, χ: list[Reals], whole: list[Counts], time: list[Mpf], bits: int
) -> tuple[list[Numbers], list[Numbers]]:
    """Refine phases of a bounded motion.

    Args:
        system: the equations.
        χ, whole: phases and whole turns in doubles, one array a coordinate, shape (m,).
        time: t − t₀ in many digits, m numbers.
        bits: working precision; it must cover the number of turns as well.

    Returns:
        The phases as object arrays near [−π, π], and bounds on their errors.
    """
    context = multiprecision(bits)
    n, turn = len(system.courses), 2 * context.pi
    result = [np.empty(len(time), dtype=object) for _ in range(n)]
    bounds = [np.empty(len(time), dtype=object) for _ in range(n)]
    # where dt/dχ is far below its mean, terms that a series lacks move the phase by much more
    cut = context.matrix([sum(series.left_out for series in row) for row in system.oscillations])
    for m, t in enumerate(time):
        goal = [system.starts[k] + system.rates[k] * t - turn * int(whole[k][m]) for k in range(n)]

        def equations(x: list[Mpf], goal: list[Mpf] = goal) -> tuple[MpfMatrix, MpfMatrix]:
            residual = context.matrix(
                [x[k] - goal[k] + sum(_ripple(system, k, i, x[i]) for i in range(n)) for k in range(n)]
            )
            slopes = context.matrix([[(k == i) + _slope(system, k, i, x[i]) for i in range(n)] for k in range(n)])
            return residual, slopes

        x, error = _newton(equations, [context.convert(float(χ[k][m])) for k in range(n)], context, bits)
        spread = (equations(x)[1] ** -1).apply(abs) * cut
        for k in range(n):
            result[k][m], bounds[k][m] = x[k], error + spread[k]
    return result, bounds


def _ripple(system: TorusEquations, k: int, i: int, x: Mpf) -> Mpf | int:
    series = system.oscillations[k][i]
    return 0 if series.constant else series.oscillation(x)


def _slope(system: TorusEquations, k: int, i: int, x: Mpf) -> Mpf | int:
    series = system.oscillations[k][i]
    return 0 if series.constant else series.value(x) - series.mean


def unbounded(
    courses: list[CoordinateMotion], equations: int, χ: list[Reals], time: list[Mpf], bits: int
) -> tuple[list[Numbers], list[Numbers]]:
    """Refine phases where some coordinate does not come back; arguments as in ``on_torus``.

    Args:
        courses: of the separated coordinates, in their order.
        equations: number of Jacobi's equations.
        χ: phases in doubles, one array a coordinate, shape (m,).
        time: t − t₀ in many digits, m numbers.
        bits: binary digits wanted.
    """
    context = multiprecision(bits)
    n = len(courses)

    def single(value: object) -> NDArray[np.object_]:
        return np.array([value], dtype=object)

    targets = [sum(c.integral(j, single(c.start))[0] for c in courses) for j in range(equations)]
    result = [np.empty(len(time), dtype=object) for _ in range(n)]
    bounds = [np.empty(len(time), dtype=object) for _ in range(n)]
    for m, t in enumerate(time):

        def system(x: list[Mpf], t: Mpf = t) -> tuple[MpfMatrix, MpfMatrix]:
            residual = context.matrix(
                [
                    sum(c.integral(j, single(x[i]))[0] for i, c in enumerate(courses))
                    - targets[j]
                    - (t if j == 0 else 0)
                    for j in range(equations)
                ]
            )
            slopes = context.matrix(
                [[c.rate(j, single(x[i]))[0] for i, c in enumerate(courses)] for j in range(equations)]
            )
            return residual, slopes

        x, error = _newton(system, [context.convert(float(χ[k][m])) for k in range(n)], context, bits)
        for k in range(n):
            result[k][m], bounds[k][m] = x[k], error
    return result, bounds


def _newton(
    equations: Callable[[list[Mpf]], tuple[MpfMatrix, MpfMatrix]], x: list[Mpf], context: Context, bits: int
) -> tuple[list[Mpf], Mpf]:
    """Newton's method from a start good to doubles.

    Raises:
        NotConvergedError: the corrections did not become small.
    """
    last = context.inf
    for _ in range(24):
        residual, slopes = equations(x)
        step = context.lu_solve(slopes, -residual)
        size = max(abs(s) for s in step)
        x = [a + s for a, s in zip(x, step, strict=True)]
        if size >= last / 2 and size < context.mpf(2) ** (-bits // 3):
            return x, 4 * last
        last = size
        if size < context.mpf(2) ** (12 - bits):
            return x, 4 * max(size, context.mpf(2) ** (12 - bits))
    raise NotConvergedError("the phases could not be refined to the digits asked")
