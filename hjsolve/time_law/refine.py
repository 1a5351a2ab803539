"""Phases in many digits: Newton's method on Jacobi's equations, started from the phases in doubles.

On a torus χₖ + Σᵢ Dₖᵢ(χᵢ) = θₖ⁰ + Ωₖ (t − t₀) is solved for all times at once, with slopes in doubles: these are wrong
by δ = 1e-16 times the condition of the Jacobian, and each step leaves δ times the error before it. Times at which that
is too much, and motions that do not come back, take slopes of many digits, one time after the other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Context, Counts, Elementwise, Mpf, MpfMatrix, Numbers, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion
from hjsolve.one_coordinate.fourier_series import oscillations
from hjsolve.time_law.torus import TorusEquations

_GUARD = 64
"""Of the binary digits of the arithmetic, those that phases are not refined to: twenty digits are not told."""
_UNSTEADY = 2.0**6
"""By how much a step may contract less than the one before."""
_MOST_BITS = 900
"""Above, steps underflow in doubles."""
_MOST_UNEVEN = 1e8
"""Condition of the slopes up to which steps with slopes in doubles contract."""


def on_torus(
    system: TorusEquations, χ: list[Reals], whole: list[Counts], time: list[Mpf], bits: int
) -> tuple[list[Numbers], list[Numbers]]:
    """Refine phases of a bounded motion.

    Args:
        χ, whole: phases and whole turns in doubles, one array a coordinate, shape (m,).
        time: t − t₀ in many digits, m numbers.
        bits: working precision; it must cover the number of turns as well.

    Returns:
        The phases as object arrays near [−π, π], and bounds on their errors.
    """
    context = multiprecision(bits)
    n, turn = len(system.coordinate_motions), 2 * context.pi
    t: Elementwise = np.array(time, dtype=object)
    # the turns counted in doubles are whole numbers, exact: taking them away leaves angles of order one in many digits
    goal: list[Numbers] = [system.starts[k] + system.rates[k] * t - turn * whole[k].astype(object) for k in range(n)]
    # what the series lack moves the angles, and |J⁻¹| of that the phases
    cut = np.array([float(sum(series.left_out for series in row)) for row in system.oscillations])
    x, error, spread = _together(system, goal, χ, cut, context, bits)
    for m in np.flatnonzero(~np.isfinite(error.astype(float))):
        one = [goal[k][m] for k in range(n)]
        place, left, inverse = _alone(system, one, [float(χ[k][m]) for k in range(n)], context, bits)
        error[m] = left
        for k in range(n):
            x[k][m], spread[m, k] = place[k], float(sum(abs(inverse[k, i]) * cut[i] for i in range(n)))
    return x, [error + spread[:, k] for k in range(n)]


def _together(
    system: TorusEquations, goal: list[Numbers], χ: list[Reals], cut: Reals, context: Context, bits: int
) -> tuple[list[Numbers], Numbers, Reals]:
    """Take steps at all times at once, with slopes in doubles: each one brings some fifteen digits.

    Returns:
        The phases, bounds on what the steps leave, infinite where they do not contract, and what the terms that the
        series lack do to the phases, shape (m, n).
    """
    n, m = len(goal), len(goal[0])
    as_digits = np.frompyfunc(lambda v: context.mpf(float(v)), 1, 1)
    x = [as_digits(c) for c in χ]
    error, spread = np.array([context.inf] * m, dtype=object), np.full((m, n), np.inf)
    # 2⁻⁹⁰⁰ is near the least double: steps in doubles would be 0
    if bits > _MOST_BITS or not m:
        return x, error, spread
    slopes = np.stack(
        [np.stack([(k == i) + _slope(system, k, i, c) + 0 * c for i, c in enumerate(χ)]) for k in range(n)]
    )
    with np.errstate(all="ignore"):
        # a slope in doubles is wrong by 1e-16 × condition, by which factor each step contracts: 1e-8 at least
        good = np.linalg.cond(slopes.transpose(2, 0, 1)) < _MOST_UNEVEN
    open_, last = np.flatnonzero(good), np.full(m, np.inf)
    inverse = np.linalg.inv(slopes[:, :, open_].transpose(2, 0, 1))
    spread[open_] = np.abs(inverse) @ cut
    least = 2.0 ** (_GUARD - bits)
    # slopes in doubles and this condition leave 1e-8 of an error at worst: 24 bits a step, and a few steps more for the
    # start
    for _ in range(4 + bits // 24):
        if not len(open_):
            break
        at = [c[open_] for c in x]
        variations = [oscillations([row[i] for row in system.oscillations], at[i]) for i in range(n)]
        residual = [at[k] - goal[k][open_] + sum(variations[i][k] for i in range(n)) for k in range(n)]
        step = (inverse @ np.stack([r.astype(float) for r in residual], axis=1)[:, :, None])[:, :, 0]
        size = np.max(np.abs(step), axis=1)
        for k in range(n):
            x[k][open_] = at[k] - as_digits(step[:, k])
        # linear convergence: the next error is this step times the rate at which steps have shrunk
        rate = np.where(np.isinf(last[open_]), 1.0, np.minimum(1.0, _UNSTEADY * size / last[open_]))
        left = size * rate  # what this step leaves, when it contracts nearly as well as the one before
        done = (left < least) & (size <= last[open_] / 4)
        error[open_[done]] = context.mpf(4 * least)
        going = ~done & (size <= last[open_] / 4)  # those that do not contract are left to Newton's method
        last[open_] = size
        open_, inverse = open_[going], inverse[going]
    return x, error, spread


def _alone(
    system: TorusEquations, goal: list[Mpf], χ: list[float], context: Context, bits: int
) -> tuple[list[Mpf], Mpf, MpfMatrix]:
    """One time by Newton's method in many digits: the phases, a bound, and the inverse of the slopes there."""
    n = len(goal)

    def equations(x: list[Mpf]) -> tuple[MpfMatrix, MpfMatrix]:
        residual = context.matrix(
            [x[k] - goal[k] + sum(_oscillation(system, k, i, x[i]) for i in range(n)) for k in range(n)]
        )
        slopes = context.matrix([[(k == i) + _slope(system, k, i, x[i]) for i in range(n)] for k in range(n)])
        return residual, slopes

    # slopes in many digits: quadratic however uneven they are, one time after the other
    x, error = _newton(equations, [context.convert(c) for c in χ], context, bits)
    return x, error, equations(x)[1] ** -1


def _oscillation(system: TorusEquations, k: int, i: int, x: Elementwise) -> Elementwise:
    series = system.oscillations[k][i]
    return 0 if series.constant else series.oscillation(x)


def _slope(system: TorusEquations, k: int, i: int, x: Elementwise) -> Elementwise:
    series = system.oscillations[k][i]
    if series.constant:
        return 0
    doubles = isinstance(x, np.ndarray) and x.dtype == float
    return series.value(x) - (float(series.mean) if doubles else series.mean)


def unbounded(
    coordinate_motions: list[CoordinateMotion], equations: int, χ: list[Reals], time: list[Mpf], bits: int
) -> tuple[list[Numbers], list[Numbers]]:
    """Refine phases where some coordinate does not come back; arguments as in ``on_torus``.

    Args:
        coordinate_motions: of the separated coordinates, in their order.
        equations: number of Jacobi's equations.
        χ: phases in doubles, one array a coordinate, shape (m,).
        time: t − t₀ in many digits, m numbers.
        bits: binary digits wanted.
    """
    context = multiprecision(bits)
    n = len(coordinate_motions)

    def single(value: object) -> NDArray[np.object_]:
        return np.array([value], dtype=object)

    # Cⱼ = Σᵢ Gᵢⱼ(χᵢ(t₀)): what the sums are at the start
    targets = [sum(c.integral(j, single(c.start))[0] for c in coordinate_motions) for j in range(equations)]
    result = [np.empty(len(time), dtype=object) for _ in range(n)]
    bounds = [np.empty(len(time), dtype=object) for _ in range(n)]
    for m, t in enumerate(time):

        def system(x: list[Mpf], t: Mpf = t) -> tuple[MpfMatrix, MpfMatrix]:
            residual = context.matrix(
                [
                    sum(c.integral(j, single(x[i]))[0] for i, c in enumerate(coordinate_motions))
                    - targets[j]
                    - (t if j == 0 else 0)
                    for j in range(equations)
                ]
            )
            slopes = context.matrix(
                [[c.rate(j, single(x[i]))[0] for i, c in enumerate(coordinate_motions)] for j in range(equations)]
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
        # no longer quadratic and already small: rounding of the integrals is reached
        if size >= last / 2 and size < context.mpf(2) ** (-bits // 3):
            return x, 4 * last
        last = size
        # a step of 2^(12 − bits) is the rounding of the residual itself
        if size < context.mpf(2) ** (12 - bits):
            return x, 4 * max(size, context.mpf(2) ** (12 - bits))
    raise NotConvergedError("the phases could not be refined to the digits asked")
