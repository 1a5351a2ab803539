"""Proved enclosures of a motion's numbers: ``motion(..., certified=True)``.

The kinds of motion and first guesses come from the ordinary computation; everything returned is then enclosed by balls
(``numeric/ball``): constants from the exact initial data, turning points by the interval Newton test, actions and mean
growths by rigorous quadrature, frequencies from the inverse of the matrix of growths in ball arithmetic.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy as sp

from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.lowering import lower
from hjsolve.numeric import ball
from hjsolve.numeric.arithmetic import multiprecision
from hjsolve.numeric.ball import Balls, Integrand, flint, from_mpf, working
from hjsolve.numeric.course import Bounded
from hjsolve.numeric.estimate import Estimate

if TYPE_CHECKING:
    from hjsolve.motion import Motion


@dataclass(frozen=True)
class Enclosed:
    """Enclosures of one motion; keys as in ``Motion``."""

    constants: Mapping[str, Estimate]
    turning_points: Mapping[str, tuple[Estimate | None, Estimate | None]]
    actions: Mapping[str, Estimate]
    frequencies: Mapping[str, Estimate]
    periods: Mapping[str, Estimate]


def enclose(motion: Motion, digits: int) -> Enclosed:
    """Enclose all numbers of a bounded motion.

    Args:
        motion: the motion, computed without proof.
        digits: relative digits wanted.

    Returns:
        Estimates with ``certified`` True, each containing the truth.

    Raises:
        InvalidInputError: a coordinate neither librates nor rotates; that is not certified yet.
        NotConvergedError: an enclosure stayed wider than asked.
        MissingExtraError: python-flint is not installed.
    """
    ball.require_flint()
    unfit = [name for name, place in motion.located.items() if not isinstance(place.course, Bounded)]
    if unfit:
        raise InvalidInputError(
            f"certified=True encloses librations and rotations; {unfit[0]} is in {motion.kinds[unfit[0]]}"
        )
    bits, work = int(3.33 * digits) + 12, int(3.33 * digits) + 80
    for _ in range(6):
        try:
            with working(work):
                return _enclose(motion, digits, bits, work)
        except NotConvergedError:
            work *= 2
    with working(work):
        return _enclose(motion, digits, bits, work)


def _enclose(motion: Motion, digits: int, bits: int, work: int) -> Enclosed:
    names = list(motion.solution.coordinates)
    inputs = [exact_ball(value) for value in (*motion.initial.constants.values(), *_parameters(motion))]
    integrands = {name: _integrand(motion, name, inputs, work) for name in names}
    constants = dict(zip(motion.initial.constants, inputs, strict=False))
    ends = {n: (f.lower, f.upper) for n, f in integrands.items() if f.lower is not None}
    timed = integrands if "time" in motion.parts else {}
    growths = {n: [_growth(motion, n, f, j, bits) for j in range(len(f.kernels))] for n, f in timed.items()}
    actions = _actions(motion, integrands, bits) if "action" in motion.parts else {}
    frequencies = _frequencies(motion, growths) if growths else {}

    def rounded(balls: Mapping[str, Any]) -> dict[str, Estimate]:
        return {key: estimate(value, digits) for key, value in balls.items()}

    periods = {n: 2 * flint.arb.pi() / abs(f) for n, f in frequencies.items() if not f.contains(0)}
    pairs = {n: (estimate(a, digits), estimate(b, digits)) for n, (a, b) in ends.items()}
    return Enclosed(rounded(constants), pairs, rounded(actions), rounded(frequencies), rounded(periods))


def _growth(motion: Motion, name: str, f: Integrand, j: int, bits: int) -> Any:
    constant = list(motion.solution.constants.values())[j].symbol
    absent = sp.diff(motion.solution.momentum_squared[name], constant) == 0
    return flint.arb(0) if absent else ball.mean(f, j, bits)


def exact_ball(value: sp.Expr) -> Any:
    """Enclose an exact number at the current precision."""
    return lower([value], []).run(Balls(), [])[0]


def _parameters(motion: Motion) -> list[sp.Expr]:
    return [motion.initial.values[p.symbol] for p in motion.solution.system.parameters]


def _integrand(motion: Motion, name: str, inputs: list[Any], work: int) -> Integrand:
    """Prove the turning points and set up the integrands of one coordinate."""
    solution, course = motion.solution, motion.located[name].course
    assert isinstance(course, Bounded)
    symbols = [c.symbol for c in solution.constants.values()]
    arguments = [solution.system.coordinate(name).symbol, *symbols, *(p.symbol for p in solution.system.parameters)]
    kernels = tuple(lower([sp.diff(solution.momentum_squared[name], c) / 2], arguments) for c in symbols)
    if not course.anomaly.even:
        return Integrand(course.radicand, inputs, None, None, kernels)
    guesses = (course.anomaly.lower, course.anomaly.upper)  # type: ignore[union-attr]
    ends = [ball.turning_point(course.radicand, guess, inputs, work) for guess in guesses]
    return Integrand(course.radicand, inputs, ends[0], ends[1], kernels)


def _actions(motion: Motion, integrands: Mapping[str, Integrand], bits: int) -> dict[str, Any]:
    result = {}
    for c in motion.solution.system.coordinates:
        if c.name in integrands:
            f, course = integrands[c.name], motion.located[c.name].course
            if f.lower is None and motion.solution.shift[c.name] != 0:
                continue
            direction = course.anomaly.direction if isinstance(course, Bounded) else 1
            result[c.name] = direction * ball.mean(f, -1, bits)
        elif c.domain.kind == "angle":
            result[c.name] = exact_ball(motion.initial.values[c.momentum])
    return result


def _frequencies(motion: Motion, growths: Mapping[str, list[Any]]) -> dict[str, Any]:
    """Ω from the growths: first row of the inverse, and −Σ Ωᵢ·growth for ignorable angles."""
    names = list(motion.solution.coordinates)
    n = len(names)
    if n == 0:
        return {}
    matrix = flint.arb_mat([[growths[i][j] for i in names] for j in range(n)])
    rates = [matrix.inv()[k, 0] for k in range(n)]
    result = {}
    for c in motion.solution.system.coordinates:
        if c.name in names:
            course = motion.located[c.name].course
            direction = course.anomaly.direction if isinstance(course, Bounded) else 1
            result[c.name] = direction * rates[names.index(c.name)]
        elif c.domain.kind == "angle":
            j = list(motion.solution.constants).index(c.momentum.name)
            result[c.name] = -sum((rate * growths[i][j] for rate, i in zip(rates, names, strict=True)), flint.arb(0))
    return result


def estimate(value: Any, digits: int) -> Estimate:
    """Return a ball as an estimate whose error holds the radius and the rounding of its centre.

    Raises:
        NotConvergedError: the ball is wider than the digits asked.
    """
    middle = value.mid()
    if digits <= 15:
        number: Any = float(middle)
        error: Any = float((value - flint.arb(number)).abs_upper()) * (1 + 2.0**-50)
    else:
        number = to_mpf(middle, int(3.33 * digits) + 16)
        error = to_mpf((value - from_mpf(number)).abs_upper(), 64) * (1 + 2.0**-50)
    if not value.is_finite() or error > abs(number) * multiprecision(64).mpf(10) ** (1 - digits):
        raise NotConvergedError("an enclosure stayed wider than the digits asked")
    return Estimate(number, error, certified=True)


def to_mpf(x: Any, bits: int) -> Any:
    """Round the centre of a ball to an mpf."""
    mantissa, exponent = x.mid().man_exp()
    context = multiprecision(bits)
    return context.ldexp(context.convert(int(mantissa)), int(exponent))
