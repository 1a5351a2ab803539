"""loop_integral(): ∮ Σ p dq of a closed curve of states as it moves, which stays (Greenwood (6-391), (6-396), P6-17).

The curve q(s), p(s), 0 ≤ s ≤ 2π, is followed point by point by quadratures. At a time t the integrand p·∂q/∂s is a
smooth periodic function of s: the trapezoidal rule on N points, ∂q/∂s by trigonometric interpolation of the same
points, converges geometrically where the curve is analytic (Trefethen and Weideman 2014). Its error is taken from the
change with half of the points, which are a rule of their own. Errors δq, δp of the states make at most

    (2π/N) Σ |∂q/∂s| δp + |∂p/∂s| δq,

since the interpolated ∂/∂s is antisymmetric as a matrix. For one freedom the integral is the area of phase space inside
the curve, by Stokes' theorem: Liouville's (4-210).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.number_types import Reals
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.formulas.read import formula_of, number
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.motion.times import exact_numbers
from hjsolve.solution.quadratures import Solution

_FEWEST, _SAFETY_OF_DIFFERENCES = 16, 4
_EXAMPLE = '{"x": "1 + cos(s)/10"}'


@dataclass(frozen=True, eq=False, repr=False)
class LoopIntegral(Shown):
    """∮ Σ p dq of a closed curve of states at several times.

    Attributes:
        times: shape (m,).
        value: of the integral, shape (m,).
        error: shape (m,): what the states are off, and the change with half of the points.
        points: that were followed.
    """

    times: Reals
    value: Reals
    error: Reals
    points: int

    def __bool__(self) -> bool:
        """Return whether all values are the same within their errors."""
        return bool(np.all(np.abs(self.value - self.value[0]) <= self.error + self.error[0]))


@arguments.with_known_names('loop_integral(solution, q={"x": "1 + cos(s)/10"}, p={"x": "sin(s)/10"})')
def loop_integral(
    solution: Solution, *, q: Mapping[str, object], p: Mapping[str, object], times: object = (0,),
    parameters: Mapping[str, object] | None = None, t0: object = 0, tolerance: object = 1e-12, most: object = 512,
) -> LoopIntegral:  # fmt: skip
    """Follow a closed curve of states, and integrate Σ p dq along it.

    Args:
        solution: of the system; its motions follow the curve.
        q, p: every coordinate → its formula in s, at t0, of period 2π but for whole turns of angles; as text or sympy
            expression.
        times: when the integral is wanted.
        parameters: values that differ from the defaults.
        t0: the time of the curve given.
        tolerance: relative, of the rule; the number of points is doubled until it is reached.
        most: points.

    Returns:
        ``LoopIntegral``; it is true as a condition where all values agree within their errors.

    Raises:
        InvalidInputError: a coordinate without a formula, or a curve that is not closed.
        NotConvergedError: the tolerance is not reached with ``most`` points, or a state was not computed.

    Example:
        >>> import hjsolve
        >>> pendulum = hjsolve.solve("pendulum")
        >>> curve = {"q": {"theta": "1 + sin(s)/5"}, "p": {"theta": "cos(s)/5"}}
        >>> moved = hjsolve.loop_integral(pendulum, **curve, times=[0, 1, 5], parameters={"m": 1, "l": 1, "g": 1})
        >>> bool(moved), moved.value.round(10).tolist()  # pi/25, the area of the circle
        (True, [0.1256637061, 0.1256637061, 0.1256637061])

    References:
        Greenwood, Classical Dynamics (1977), (4-210), (6-391), (6-396), P6-17.
    """
    if not isinstance(solution, Solution):
        raise InvalidInputError(
            f"loop_integral: a solution is needed, as hjsolve.solve gives it, not {arguments.described(solution)}"
        )
    if not isinstance(tolerance, float) or not 0 < tolerance < 1:
        raise InvalidInputError(f"tolerance: a number between 0 and 1 is needed, not {arguments.described(tolerance)}")
    greatest = arguments.whole(most, "most", 2 * _FEWEST)
    coordinates = solution.system_as_given.coordinates
    s = sp.Symbol("s", real=True)
    curves = [_curve(given, coordinates, s, source) for given, source in ((q, "q"), (p, "p"))]
    _refuse_open(curves, coordinates, s)
    moments = np.array([float(sp.N(t, 20)) for t in exact_numbers(times, "times")[1]])
    states: dict[sp.Rational, tuple[Reals, Reals]] = {}
    points = _FEWEST
    while True:
        places = [sp.Rational(k, points) for k in range(points)]
        for turn in places:
            if turn not in states:
                at = {s: 2 * sp.pi * turn}
                start = [{n: number(sp.N(f.subs(at), 25), source="loop") for n, f in curve.items()} for curve in curves]
                motion = solution.motion(q=start[0], p=start[1], parameters=parameters, t0=t0, want={"trajectory"})
                states[turn] = _states(motion.at(moments), [c.name for c in coordinates])
        fine = _rule(np.array([states[turn] for turn in places]), coordinates)
        half = _rule(np.array([states[turn] for turn in places[::2]]), coordinates)
        error = fine[1] + _SAFETY_OF_DIFFERENCES * np.abs(fine[0] - half[0])
        if np.all(np.abs(fine[0] - half[0]) <= tolerance * np.maximum(np.abs(fine[0]), 1e-300) + fine[1]):
            return LoopIntegral(moments, fine[0], error, points)
        points *= 2
        if points > greatest:
            raise NotConvergedError(
                f"loop_integral: not to {tolerance:g} with {points // 2} points; allow more with most="
            )


def _curve(given: object, coordinates: tuple[Coordinate, ...], s: sp.Symbol, source: str) -> dict[str, sp.Expr]:
    table = arguments.one_for_each(given, source, [c.name for c in coordinates], _EXAMPLE)
    return {name: formula_of(f, {"s": s}, source=f"{source}[{name}]") for name, f in table.items()}


def _refuse_open(curves: list[dict[str, sp.Expr]], coordinates: tuple[Coordinate, ...], s: sp.Symbol) -> None:
    """Refuse a curve whose end is not its beginning: p and lines come back, angles by whole turns."""
    for kind, curve in zip("qp", curves, strict=True):
        for c in coordinates:
            gap = sp.N((curve[c.name].subs(s, 2 * sp.pi) - curve[c.name].subs(s, 0)) / (2 * sp.pi), 25)
            turns = sp.Integer(round(float(gap))) if kind == "q" and c.domain.kind == "angle" else sp.S.Zero
            if abs(gap - turns) > sp.Float("1e-20"):
                raise InvalidInputError(f"{kind}[{c.name}]: the curve is not closed; its period in s must be 2*pi")


def _states(state: object, names: list[str]) -> tuple[Reals, Reals]:
    """Return q and p, and their errors, each of shape (2, n, m)."""
    q, p = (np.array([np.asarray(getattr(state, group)[n], dtype=float) for n in names]) for group in ("q", "p"))
    errors = getattr(state, "error")  # noqa: B009 - of a State, whose type loads more than is needed here
    δq, δp = (np.array([np.asarray(getattr(errors, g)[n], dtype=float) for n in names]) for g in ("q", "p"))
    if not np.isfinite(q).all() or not np.isfinite(p).all():
        raise NotConvergedError("loop_integral: a state of the curve ends, or was not computed, before the last time")
    return np.array([q, p]), np.array([δq, δp])


def _rule(table: Reals, coordinates: tuple[Coordinate, ...]) -> tuple[Reals, Reals]:
    """Return the integral at every time, and what the errors of states make of it; shape of table (N, 2, 2, n, m)."""
    count = len(table)
    q, p, δq, δp = (np.moveaxis(table[:, i, j], 0, -1) for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)))
    slopes = np.empty_like(q)
    for k, c in enumerate(coordinates):
        slopes[k] = _slope(np.unwrap(q[k], axis=-1), turning=True) if c.domain.kind == "angle" else _slope(q[k])
    fraction = 2 * np.pi / count
    value = fraction * (p * slopes).sum(axis=(0, 2))
    error = fraction * (np.abs(slopes) * δp + np.abs(_slope(p)) * δq).sum(axis=(0, 2))
    return value, error + 64 * np.finfo(float).eps * fraction * np.abs(p * slopes).sum(axis=(0, 2))


def _slope(values: Reals, *, turning: bool = False) -> Reals:
    """Differentiate samples of a periodic function by trigonometric interpolation, whole turns taken off before."""
    count = values.shape[-1]
    s = 2 * np.pi * np.arange(count) / count
    turns = np.zeros(values.shape[:-1])
    if turning:
        last = values[..., -1] + np.angle(np.exp(1j * (values[..., 0] - values[..., -1])))
        turns = np.round((last - values[..., 0]) / (2 * np.pi))
        values = values - turns[..., None] * s
    waves = np.fft.rfft(values, axis=-1) * 1j * np.arange(count // 2 + 1)
    waves[..., -1] = 0.0 if count % 2 == 0 else waves[..., -1]
    found: Reals = np.fft.irfft(waves, n=count, axis=-1) + turns[..., None]
    return found
