"""q(t) and t(q) of a motion: the time law inverted, angles unwound, errors carried along."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from hjsolve.expressions import number
from hjsolve.initial import to_bits
from hjsolve.lowering import lower
from hjsolve.numeric import inverse, refine, unbounded
from hjsolve.numeric.arithmetic import Float64, Multi, multiprecision
from hjsolve.numeric.clock import halves, relative, relative_exact
from hjsolve.numeric.course import Bounded, Course, Open, arithmetic_of
from hjsolve.numeric.double import split, turns
from hjsolve.numeric.series import Series, combine, zero
from hjsolve.numeric.tape import Tape
from hjsolve.state import Errors, State
from hjsolve.system import velocities

if TYPE_CHECKING:
    from hjsolve.motion import Motion

_EPS = 2.0**-52


@dataclass(frozen=True)
class Phases:
    """Phases of all separated coordinates at given times.

    Attributes:
        time: t − t₀ as two doubles, shape (m,).
        exact: t − t₀ in many digits, or None in double precision.
        χ, whole, errors: one array a coordinate, shape (m,).
        ended: True where the motion has ended before.
    """

    time: tuple[Any, Any]
    exact: list[Any] | None
    χ: list[Any]
    whole: list[Any]
    errors: list[Any]
    ended: Any


def state_at(motion: Motion, t: Any) -> State:
    """Return the state at a time or times; see ``Motion.at``."""
    phases, shape = _phases(motion, t)
    q, p, whole = _positions(motion, phases)
    v = _velocities(motion, q, p)
    status = np.where(phases.ended, "reaches_boundary", "ok")
    for group in (q, p, v):
        for name, values in group.items():
            group[name] = np.where(phases.ended, np.nan, values) if phases.ended.any() else values

    def errors() -> Errors:
        dq, dp, dv = _errors(motion, phases, q, p)
        return Errors(*({name: _shaped(values, shape) for name, values in group.items()} for group in (dq, dp, dv)))

    def shaped(group: Mapping[str, Any]) -> dict[str, Any]:
        return {name: _shaped(values, shape) for name, values in group.items()}

    return State(t, shaped(q), shaped(p), shaped(v), {name: _shaped(n.astype(int), shape) for name, n in whole.items()},
                 _shaped(status, shape), errors)


def _shaped(values: Any, shape: tuple[int, ...] | None) -> Any:
    if shape is None:
        return values[0].item() if hasattr(values[0], "item") else values[0]
    return values.reshape(shape)


def _phases(motion: Motion, t: Any) -> tuple[Phases, tuple[int, ...] | None]:
    """Solve Jacobi's equations at the times t."""
    shape, floats, exact = _read_times(t)
    start = to_bits(motion.t0)
    many = motion.digits > 15
    bits = int(3.33 * motion.digits) + 96
    if many:
        largest = max((abs(float(x(64))) for x in exact), default=0.0)
        rate = max((abs(f.value) for f in motion.frequencies.values()), default=0.0)
        bits += max(0, int(np.log2(largest * float(rate) + 1.0)))
    precise = relative_exact(exact, start, bits) if floats is None or many else None
    time = relative(floats, start) if floats is not None else halves(precise or [])
    χ, whole, errors, ended = solve(motion, time)
    if many and precise is not None:
        χ, errors = _refined(motion, χ, whole, precise, bits)
    return Phases(time, precise if many else None, χ, whole, errors, ended), shape


def _read_times(t: Any) -> tuple[tuple[int, ...] | None, Any | None, list[Any]]:
    """Return shape (None for a scalar), a float array where all times are floats or small ints, and exact rules."""
    array = np.asarray(t) if not isinstance(t, str) else np.array(t, dtype=object)
    shape = None if array.ndim == 0 else array.shape
    flat = array.ravel()
    if array.dtype.kind == "f" and array.dtype.itemsize <= 8 and np.isfinite(flat).all():
        floats = flat.astype(float)
        return shape, floats, _Lazy(floats)
    return shape, None, [to_bits(number(x.item() if hasattr(x, "item") else x, source="t")) for x in flat]


class _Lazy(list):  # type: ignore[type-arg]
    """Float times as exact rules, made only when many digits are wanted."""

    def __init__(self, floats: Any):
        super().__init__((lambda bits, x=float(x): multiprecision(bits).convert(x)) for x in (floats if len(floats) < 20000 else []))


def solve(motion: Motion, time: tuple[Any, Any]) -> tuple[list[Any], list[Any], list[Any], Any]:
    """Return phases, whole turns, error bounds and "has ended" at times relative to t₀ (two doubles, shape (m,))."""
    never = np.zeros(time[0].shape, dtype=bool)
    if motion.equations is None:
        return [], [], [], never
    if isinstance(motion.equations, inverse.Torus):
        return *inverse.phases(motion.equations, time), never
    return unbounded.phases(motion.equations, time)


def _refined(motion: Motion, χ: list[Any], whole: list[Any], precise: list[Any], bits: int) -> tuple[list[Any], list[Any]]:
    if motion.equations is None:
        return χ, []
    if isinstance(motion.equations, inverse.Torus):
        return refine.on_torus(motion.equations, χ, whole, precise, bits)
    full = [phase + 2 * np.pi * n for phase, n in zip(χ, whole, strict=True)]
    courses = [_with_reach(c, x) for c, x in zip(motion.equations.courses, full, strict=True)]
    return refine.unbounded(courses, motion.equations.equations, full, precise, bits)


def _with_reach(course: Course, χ: Any) -> Course:
    if not isinstance(course, Open):
        return course
    return Open(course.kind, course.ahead, course.behind, course.start, (None, 2 * max(1.0, float(np.max(np.abs(χ), initial=0)), abs(float(course.start)))))


def _courses(motion: Motion, phases: Phases) -> list[Course]:
    """The courses, reaching as far as the phases need."""
    if motion.equations is None:
        return []
    return [_with_reach(c, x) for c, x in zip(motion.equations.courses, phases.χ, strict=True)]


def _positions(motion: Motion, phases: Phases) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """q, canonical p, and whole turns of the angles."""
    q, shell, whole = {}, {}, {}
    for name, course, χ, n in zip(motion.solution.coordinates, _courses(motion, phases), phases.χ, phases.whole, strict=True):
        q[name], shell[name] = course.place(χ)
        rotating = isinstance(course, Bounded) and not course.anomaly.even
        whole[name] = course.anomaly.direction * n if rotating else 0 * n  # type: ignore[union-attr]
    for coordinate in motion.solution.system.coordinates:
        if coordinate.name not in q:
            q[coordinate.name], whole[coordinate.name] = _ignorable(motion, phases, coordinate.name, q)
    p = _momenta(motion, q, shell)
    for coordinate in motion.solution.system.coordinates:
        if coordinate.domain.kind == "angle":
            q[coordinate.name], more = _principal(q[coordinate.name])
            whole[coordinate.name] = whole[coordinate.name] + more
        else:
            whole.pop(coordinate.name)
    names = [c.name for c in motion.solution.system.coordinates]
    return {n: q[n] for n in names}, p, {n: whole[n] for n in names if n in whole}


def _principal(angle: Any) -> tuple[Any, Any]:
    """Reduce to (−π, π] and count the turns taken away."""
    arithmetic = arithmetic_of(angle)
    if isinstance(arithmetic, Float64):
        n = np.ceil((angle - np.pi) / (2 * np.pi))
        return np.where(n == 0, angle, angle - 2 * np.pi * n), n
    context, turn = arithmetic.context, 2 * arithmetic.pi()
    n = np.array([int(context.ceil((x - context.pi) / turn)) for x in angle])
    return np.array([x - turn * int(k) for x, k in zip(angle, n, strict=True)], dtype=object), n


def _momenta(motion: Motion, q: Mapping[str, Any], shell: Mapping[str, Any]) -> dict[str, Any]:
    """Canonical momenta: p = P − A for separated coordinates, the constants for ignorable ones."""
    solution = motion.solution
    result = {}
    for coordinate in solution.system.coordinates:
        name = coordinate.name
        if name in shell:
            A = solution.shift[name]
            result[name] = shell[name] if A == 0 else shell[name] - _evaluate(motion, (A,), q, {})[0]
        else:
            constant = to_bits(motion.initial.values[coordinate.momentum])(int(3.33 * motion.digits) + 64)
            some = next(iter(q.values()))
            result[name] = (float(constant) if some.dtype != object else constant) + 0 * some
    return result


def _velocities(motion: Motion, q: Mapping[str, Any], p: Mapping[str, Any]) -> dict[str, Any]:
    formulas = velocities(motion.solution.system)
    return dict(zip(formulas, _evaluate(motion, tuple(formulas.values()), q, p), strict=True))


@lru_cache(maxsize=64)
def _tape(formulas: tuple[sp.Expr, ...], arguments: tuple[sp.Symbol, ...]) -> Tape:
    return lower(formulas, arguments)


def _evaluate(motion: Motion, formulas: tuple[sp.Expr, ...], q: Mapping[str, Any], p: Mapping[str, Any]) -> list[Any]:
    """Evaluate formulas in coordinates, momenta, constants and parameters along the motion."""
    system = motion.solution.system
    variables = [c.symbol for c in system.coordinates if c.name in q] + [c.momentum for c in system.coordinates if c.name in p]
    arrays = [q[c.name] for c in system.coordinates if c.name in q] + [p[c.name] for c in system.coordinates if c.name in p]
    fixed = {s: v for s, v in motion.initial.values.items() if s not in variables}
    tape = _tape(tuple(formulas), tuple(variables) + tuple(fixed))
    many = arrays[0].dtype == object
    bits = arrays[0].flat[0].context.prec if many else 64
    numbers = [to_bits(v)(bits) if many else float(to_bits(v)(64)) for v in fixed.values()]
    if many:
        rows = [tape.run(Multi(bits), [*row, *numbers]) for row in zip(*arrays, strict=True)]
        return [np.array(column, dtype=object) for column in zip(*rows, strict=True)]
    with np.errstate(all="ignore"):
        return [np.broadcast_to(value, arrays[0].shape) for value in tape.run(Float64(), [*arrays, *numbers])]


def _ignorable(motion: Motion, phases: Phases, name: str, q: Mapping[str, Any]) -> tuple[Any, Any]:
    """φ(t) = φ₀ − Σᵢ [Gᵢ(χᵢ) − Gᵢ(χᵢ⁰)] + ∂χ/∂c: Greenwood (5-83). On a torus the mean growth is reduced exactly."""
    from hjsolve.motion import mean_growth, mean_rate

    solution, equations = motion.solution, motion.equations
    coordinate = solution.system.coordinate(name)
    j = list(solution.constants).index(coordinate.momentum.name) if equations is not None else 0
    begin = to_bits(motion.initial.values[coordinate.symbol])
    if equations is None:
        rate = to_bits(sp.diff(solution.separation.shell.potential, coordinate.momentum).subs(motion.initial.values))(256)
        return _grown(begin, rate, phases, coordinate.domain.kind == "angle", 0)
    gauge = _gauge(motion, coordinate.momentum, q)
    if isinstance(equations, inverse.Torus):
        wave = gauge
        for i, course in enumerate(equations.courses):
            series = oscillation(equations, i, j)
            if len(series.cosines):
                wave = wave + _rise(series, phases.χ[i], course.start)
        value = _grown(begin, mean_rate(solution, equations, name), phases, coordinate.domain.kind == "angle", wave)
        return value
    total = gauge
    for course, χ, n in zip(_courses(motion, phases), phases.χ, phases.whole, strict=True):
        first = np.array([course.start], dtype=object) if χ.dtype == object else np.array([float(course.start)])
        total = total - (course.integral(j, χ) - course.integral(j, first)[0])
        if isinstance(course, Bounded) and n.any():
            total = total - 2 * np.pi * n * float(mean_growth(course, j))
    return _grown(begin, 0, phases, True, total)


def oscillation(equations: inverse.Torus, i: int, j: int) -> Series:
    """Periodic part, along coordinate i, of the integral for the ignorable constant j."""
    from hjsolve.motion import mean_growth

    course = equations.courses[i]
    growths = [mean_growth(c, j) for c in equations.courses]
    own = combine([-1], [course.kernels[j]]) if isinstance(course, Bounded) else zero()
    return combine([1, *growths], [own, *(row[i] for row in equations.ripples)])


def _rise(series: Series, χ: Any, start: Any) -> Any:
    """Ripple at χ minus ripple at the start."""
    if χ.dtype == object:
        return np.array([series.ripple(x) for x in χ], dtype=object) - series.ripple(start)
    return series.ripple(χ) - series.ripple(np.array([float(start)]))


def _gauge(motion: Motion, constant: sp.Symbol, q: Mapping[str, Any]) -> Any:
    """∂χ/∂c at q minus its value at the start; 0 where no shift was made."""
    formula = sp.diff(motion.solution.shift_potential, constant)
    if formula == 0:
        return 0
    begin = to_bits(formula.subs(motion.initial.values))(int(3.33 * motion.digits) + 64)
    values = _evaluate(motion, (formula,), q, {})[0]
    return values - (float(begin) if values.dtype != object else begin)


def _grown(begin: Any, rate: Any, phases: Phases, angle: bool, wave: Any) -> tuple[Any, Any]:
    """begin + rate·(t − t₀) + wave, with whole turns of the growth taken out."""
    if phases.exact is not None:
        context = phases.exact[0].context
        values = np.array([begin(context.prec) + rate * t for t in phases.exact], dtype=object) + wave
        return values, np.zeros(len(values))
    unit = 2 * multiprecision(256).pi if angle else multiprecision(256).mpf(1)
    whole, rest = turns(split(rate / unit), phases.time)
    first = begin(256)
    count = int(multiprecision(256).nint(first / unit)) if angle else 0
    value = float(first - count * unit) + float(unit) * rest + wave
    return (value, whole + count) if angle else (value + whole, 0 * whole)


def _errors(motion: Motion, phases: Phases, q: Mapping[str, Any], p: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Bounds on q, p and velocity from the bounds on the phases."""
    unit = _EPS if phases.exact is None else float(multiprecision(64).mpf(10) ** (1 - motion.digits))
    dq, dp = {}, {}
    χ = [x.astype(float) for x in phases.χ]
    slack = [np.asarray(e, dtype=float) for e in phases.errors]
    for name, course, x, e in zip(motion.solution.coordinates, _courses(motion, phases), χ, slack, strict=True):
        slope_q, slope_p = _slopes(course, x)
        size_q, size_p = np.abs(q[name].astype(float)), np.abs(p[name].astype(float))
        if motion.turning_points.get(name, (None, None))[0] is not None and _straddles(motion, name):
            size_q = size_q + _width(motion, name)
        dq[name] = slope_q * e + 4 * unit * size_q
        dp[name] = slope_p * e + 16 * unit * size_p
    for coordinate in motion.solution.system.coordinates:
        name = coordinate.name
        if name not in dq:
            dq[name] = _ignorable_error(motion, phases, χ, slack, name, unit) + 4 * unit * (np.abs(q[name].astype(float)) + np.pi)
            dp[name] = unit * np.abs(p[name].astype(float))
    return dq, dp, _velocity_errors(motion, q, p, dq, dp, unit)


def _straddles(motion: Motion, name: str) -> bool:
    low, high = motion.turning_points[name]
    return high is None or low is None or float(low.value) * float(high.value) <= 0


def _width(motion: Motion, name: str) -> float:
    return sum(abs(float(end.value)) for end in motion.turning_points[name] if end is not None)


def _slopes(course: Course, χ: Any) -> tuple[Any, Any]:
    """|dq/dχ| and |dp/dχ| by small differences, generous where they vary."""
    if isinstance(course, Bounded) and course.momentum.cosines.dtype == object:
        course = _rounded(course)
    h = 1e-6
    (q1, p1), (q0, p0), (q2, p2) = (course.place(χ + s) for s in (-h, 0.0, h))
    return 2 * np.maximum(np.abs(q2 - q0), np.abs(q0 - q1)) / h + h * np.abs(q2 - q1), 2 * np.maximum(np.abs(p2 - p0), np.abs(p0 - p1)) / h + h * np.abs(p2 - p1)


def _rounded(course: Bounded) -> Bounded:
    series = course.momentum
    sines = None if series.sines is None else series.sines.astype(float)
    return Bounded(course.kind, course.anomaly, course.kernels, Series(series.mean, series.cosines.astype(float), sines, series.nodes, series.tail),
                   course.action, course.start)


def _ignorable_error(motion: Motion, phases: Phases, χ: list[Any], slack: list[Any], name: str, unit: float) -> Any:
    equations = motion.equations
    total = 0.0 * phases.time[0]
    if equations is None:
        return total
    j = list(motion.solution.constants).index(motion.solution.system.coordinate(name).momentum.name)
    for i, course in enumerate(_courses(motion, phases)):
        rate = np.abs(np.asarray(course.rate(j, χ[i] if phases.exact is None else phases.χ[i]), dtype=float))
        total = total + rate * slack[i]
        if not isinstance(equations, inverse.Torus):
            total = total + 4 * unit * np.abs(np.asarray(course.integral(j, phases.χ[i]), dtype=float))
        elif isinstance(course, Bounded):
            total = total + 4 * unit * float(np.sum(np.abs(oscillation(equations, i, j).cosines.astype(float))))
    return total


def _velocity_errors(motion: Motion, q: Mapping[str, Any], p: Mapping[str, Any], dq: Mapping[str, Any], dp: Mapping[str, Any], unit: float) -> dict[str, Any]:
    system = motion.solution.system
    formulas = velocities(system)
    variables = [(c.symbol, dq[c.name]) for c in system.coordinates] + [(c.momentum, dp[c.name]) for c in system.coordinates]
    gradients = tuple(sp.diff(f, s) for f in formulas.values() for s, _ in variables)
    slopes = _evaluate(motion, gradients, q, p)
    values = _evaluate(motion, tuple(formulas.values()), q, p)
    result = {}
    for row, name in enumerate(formulas):
        parts = slopes[row * len(variables) : (row + 1) * len(variables)]
        result[name] = sum(np.abs(np.asarray(s, dtype=float)) * e for s, (_, e) in zip(parts, variables, strict=True))
        result[name] = result[name] + 8 * unit * np.abs(np.asarray(values[row], dtype=float))
    return result
