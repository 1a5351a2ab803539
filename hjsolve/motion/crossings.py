"""t(q): when a coordinate passes a position or reaches an end of its domain."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Numbers
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.errors import InvalidInputError, NotConvergedError, OutsideMotionError
from hjsolve.formulas.read import number
from hjsolve.motion.coupled_crossing import coupled_crossing_time
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.phases import solve_phases
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.state_at import state_at_times
from hjsolve.motion.times import exact_numbers
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Periodic
from hjsolve.one_coordinate.open_branch import farthest
from hjsolve.time_law.open_motion import DecoupledStep, integral_at

Time = float | Mpf
"""A time or a phase, in doubles or in many digits."""
_SCAN, _TREND, _MOST_PASSAGES = 200_000, 16, 2**60
"""Steps of a scan along the motion; doublings of the time over which a trend is taken for the rule."""


def crossing_time(motion: SeparatedMotion, name: str, value: object, passage: int) -> Estimate:
    """Return the time of a crossing; see ``Motion.time_at``."""
    if abs(arguments.whole(passage, "passage")) > _MOST_PASSAGES:
        raise InvalidInputError("passage: more than 2**60; two doubles do not tell its phase")
    target = to_bits(number(value, source=f"value of {name}"))
    if name not in motion.located:
        return _scanned(motion, name, float(target(64)), passage)
    coordinate_motion = motion.located[name].coordinate_motion
    phase = _phase_of(motion, name, coordinate_motion, target, passage)
    elapsed, error = _elapsed(motion, list(motion.solution.coordinates).index(name), phase)
    return _shifted(motion, elapsed, error)


def crossing_times(motion: SeparatedMotion, name: str, values: object) -> Numbers:
    """Return the times of the first crossings after t₀, array of shape (m,).

    Args:
        motion: where the crossings are looked for.
        name: coordinate.
        values: positions, shape (m,); for an angle modulo 2π.
    """
    return np.array([crossing_time(motion, name, v, 0).value for v in exact_numbers(values, "values")[1]])


def _shifted(motion: SeparatedMotion, elapsed: Time, error: Time) -> Estimate:
    """t₀ + elapsed time."""
    if motion.digits > 15:
        bits = bits_for(motion.digits, 32)
        value = to_bits(motion.t0)(bits) + elapsed
        return Estimate(value, abs(error) + abs(value) * multiprecision(bits).mpf(10) ** -motion.digits)
    approximate = float(to_bits(motion.t0)(160) + elapsed)
    return Estimate(approximate, float(error) + EPS * abs(approximate))


def _phase_of(
    motion: SeparatedMotion, name: str, coordinate_motion: CoordinateMotion, target: Callable[[int], Mpf], passage: int
) -> Mpf:
    """Phase of the passage-th crossing, counted from the start."""
    bits = bits_for(motion.digits, 128)
    place, arithmetic = target(bits), Multi(bits)
    if coordinate_motion.rests:
        raise OutsideMotionError(
            f"{name} rests at {float(coordinate_motion.place(np.zeros(1))[0][0]):.12g}: it crosses nothing"
        )
    if (cycle := coordinate_motion.cycle) is not None:
        χ = cycle.phase(between_turning_points(motion, name, cycle, place), arithmetic)
        turn = 2 * arithmetic.pi()
        if cycle.rotates and motion.solution.system.coordinate(name).domain.kind == "line":
            return _only_phase(name, cycle, place, χ, passage)
        # a libration passes a place twice a turn, at ±χ, at a turning point once: equal doubles are one place
        around = {float(x % turn): x % turn for x in ((χ,) if cycle.rotates else (χ, -χ))}
        start = cycle.start
        # the first passage after t₀ of each; later ones follow a whole turn apart
        first = sorted(x + turn * arithmetic.context.ceil((start - x) / turn) for x in around.values())
        return first[passage % len(first)] + turn * (passage // len(first))
    phases = sorted(x for x in open_phases(name, coordinate_motion, place, bits))
    # an open motion has no turns: passages before t₀ are counted backwards, −1 the last of them
    later = (
        [x for x in phases if x >= coordinate_motion.start]
        if passage >= 0
        else [x for x in phases if x < coordinate_motion.start][::-1]
    )
    index = passage if passage >= 0 else -passage - 1
    if index >= len(later):
        raise OutsideMotionError(
            f"{name} passes {float(place):.9g} {len(later)} times {'after' if passage >= 0 else 'before'} t0, not more"
        )
    return later[index]


def _only_phase(name: str, cycle: Periodic, place: Mpf, χ: Mpf, passage: int) -> Mpf:
    """Return the phase at which a rotation along a line passes a place, which it does once.

    Raises:
        OutsideMotionError: it does so on the other side of t₀, or not so often.
    """
    context = χ.context
    turn = 2 * context.pi
    there = cycle.place(np.array([χ], dtype=object))[0][0]
    # q grows by a length a turn: the turn in which the place lies is a quotient, rounded
    χ += turn * context.nint(cycle.direction * (place - there) / (turn * cycle.radian))
    if passage != (0 if χ >= cycle.start else -1):
        side = "after" if passage >= 0 else "before"
        raise OutsideMotionError(f"{name} passes {float(place):.9g} once, and not as passage {passage} {side} t0")
    return χ


def between_turning_points(motion: SeparatedMotion, name: str, coordinate_motion: Periodic, place: Mpf) -> Mpf:
    """Return a place that is passed; a turning point itself where it is that, but for the rounding of both.

    Args:
        coordinate_motion: its libration or rotation.

    Raises:
        OutsideMotionError: it lies beyond.
    """
    if coordinate_motion.rotates:
        return place
    a, b = coordinate_motion.turning_points
    # a place typed as the turning point is one in the digits it was typed with
    phase_rounding = (abs(a) + abs(b)) * multiprecision(64).mpf(2) ** -(bits_for(motion.digits, 96))
    if not a - phase_rounding <= place <= b + phase_rounding:
        low, high = motion.turning_points[name]
        raise OutsideMotionError(f"{name} never reaches {float(place):.12g}: it moves between {low} and {high}")
    return min(max(place, a), b)


def open_phases(name: str, coordinate_motion: CoordinateMotion, place: Mpf, bits: int) -> list[Mpf]:
    """Return the phases of an unbounded course at a place: one on a branch, two where the branch turns.

    Args:
        bits: of the phases.

    Raises:
        OutsideMotionError: the motion never has that place.
    """
    found = []
    for sign, branch in zip((1, -1), coordinate_motion.branches, strict=True):
        y = branch.end_map.parameter(multiprecision(bits).convert(place))
        if y is not None:
            found.append(sign * y)
    if not found:
        raise OutsideMotionError(f"{name} never reaches {float(place):.12g}")
    return found


def _elapsed(motion: SeparatedMotion, k: int, phase: Mpf) -> tuple[Time, Time]:
    """Return the time from t₀ until coordinate k has a phase, and a bound on its error."""
    torus, scheme, many = motion.torus, motion.scheme, motion.digits > 15
    if torus is not None and all(s.constant for i, s in enumerate(torus.oscillations[k]) if i != k):
        # the time law of this phase holds no other phase: t = (χ + D(χ) − θ₀)/Ω, no search
        periodic = torus.oscillations[k][k]
        wave = (
            0
            if periodic.constant
            else periodic.oscillation(phase)
            if many
            else float(periodic.oscillation(np.array([float(phase)]))[0])
        )
        time = (phase + wave - torus.starts[k]) / torus.rates[k]
        size = periodic.size + 4.0
        return time, _noise(motion) * size / abs(torus.rates[k])
    if (
        scheme is not None
        and (step := next((s for s in scheme.steps if s.index == k), None))
        and step is scheme.steps[0]
        and step.weights[0]
    ):
        return _own_time(motion, scheme.coordinate_motions[k], step, phase)
    return coupled_crossing_time(motion, k, phase) or _sought(motion, k, float(phase))


def _noise(motion: SeparatedMotion) -> Time:
    return 4 * EPS if motion.digits <= 15 else multiprecision(64).mpf(10) ** -motion.digits


def _own_time(
    motion: SeparatedMotion, coordinate_motion: CoordinateMotion, step: DecoupledStep, phase: Mpf
) -> tuple[Time, Time]:
    """Return the time of a coordinate whose equation holds no other."""
    coordinate_motion = coordinate_motion.with_reach(abs(float(phase)))
    total: Time = 0.0
    size = 0.0
    for j, w in enumerate(step.weights):
        if w:
            (there, first), (begin, second) = (
                _integral_at(motion, coordinate_motion, j, χ) for χ in (phase, coordinate_motion.start)
            )
            # Σ wⱼ Gⱼ = t w₀: Jacobi's equations, combined so that no other coordinate is left
            total, size = total + w * (there - begin), size + abs(w) * (first + second)
    return total / step.weights[0], _noise(motion) * size / abs(step.weights[0])


def _integral_at(
    motion: SeparatedMotion, coordinate_motion: CoordinateMotion, j: int, χ: Mpf | int
) -> tuple[Time, float]:
    """Gⱼ at one phase of many digits, and the size that its rounding refers to: that of the series of its panel."""
    near = np.array([float(χ)])
    size = float(coordinate_motion.spacing(j, near)[0])
    if motion.digits > FLOAT_DIGITS:
        return coordinate_motion.integral(j, np.array([χ], dtype=object))[0], size
    return integral_at(coordinate_motion, j, χ), size


def _sought(motion: SeparatedMotion, k: int, goal: float) -> tuple[float, float]:
    """Return the time at which χₖ(t), increasing, passes a phase; by bracketing and the secant rule."""

    def full(t: float) -> tuple[float, float]:
        χ, whole, errors, ended = solve_phases(motion, (np.array([t]), np.zeros(1)))
        return (np.inf if ended[0] else float(χ[k][0] + 2 * np.pi * whole[k][0])) - goal, float(errors[k][0])

    low, high = 0.0, 0.0
    step = 1.0 / max(float(abs(f.value)) for f in motion.frequencies.values()) if motion.frequencies else 1.0
    if full(0.0)[0] < 0:
        left = [full(high)[0]]
        # doubled steps forward until the phase is passed; its growth has a least mean rate or fades
        while left[-1] < 0:
            low, high, step = high, high + step, 2 * step
            left.append(full(high)[0])
            _limit(step, left)
    else:
        while full(low)[0] > 0:
            low, high, step = low - step, low, 2 * step
            _limit(step, [])
    values = full(low)[0], full(high)[0]
    time = interpolated_root(lambda t: full(t)[0], (low, high), values, width=EPS)
    return time, _time_error(full, low, high)


def _limit(step: float, left: list[float]) -> None:
    """Stop a search: too late, or what is gained halves with every doubling of the time and will never suffice."""
    gains = [b - a for a, b in itertools.pairwise(left[-_TREND - 1 :])]
    # gains that shrink to 0.7 of the last add up to 0.7/0.3 = 2.3 of it: where 8 are missing, the phase lies beyond
    fading = len(gains) == _TREND and all(0 <= b <= 0.7 * a for a, b in itertools.pairwise(gains))
    if step > 1e200 or (fading and left[-1] < -8 * gains[-1]):
        raise OutsideMotionError("the place is not reached in any finite time")


def _time_error(full: Callable[[float], tuple[float, float]], low: float, high: float) -> float:
    """Return what the doubt of the phase leaves of the time, by the least slope nearby: there is none beyond an end."""
    t = low
    h = max(high - low, abs(t) * 1e-6, 1e-9)
    # the phase over a few steps on either side, without those after an end of the motion
    near = [phase for phase in (full(t + side * h)[0] for side in (-2, -1, 0, 1)) if np.isfinite(phase)]
    slope = min((abs(b - a) / h for a, b in itertools.pairwise(near)), default=0.0)
    return 4 * full(t)[1] / max(slope, 1e-300) + 4 * EPS * abs(t)


def _scanned(motion: SeparatedMotion, name: str, value: float, passage: int) -> Estimate:
    """Crossings of an ignorable coordinate, found by walking along the motion: it need not be monotone."""
    if passage < 0:
        raise InvalidInputError(f"time_at: passage counts from 0 for the ignorable coordinate {name}")
    rates = [abs(float(f.value)) for f in motion.frequencies.values()]
    start = float(to_bits(motion.t0)(64))
    # a 150th of the fastest period: two passages nearer to each other than that are seen as none
    step = 0.04 / max(rates) if rates else 0.05
    angle = motion.solution.system.coordinate(name).domain.kind == "angle"

    def off(t: float) -> float:
        return float(state_at_times(motion, t).unwrapped(name)) - value

    def level(x: float) -> float:
        return np.floor(x / (2 * np.pi)) if angle else float(x >= 0)

    before, left = off(start), passage
    if before == 0:
        left -= 1
    for k in range(_SCAN if rates else 4000):
        t = start + (k + 1) * step if rates else start + step * 1.02**k
        after = off(t)
        if level(after) != level(before) or after == 0:
            left -= 1
            if left < 0:
                edge = 2 * np.pi * max(level(after), level(before)) if angle else 0.0
                previous = start + k * step if rates else (start + step * 1.02 ** (k - 1) if k else start)
                values = before - edge, after - edge
                time = interpolated_root(lambda s: off(s) - edge, (previous, t), values, width=EPS)  # noqa: B023 (called at once)
                state = state_at_times(motion, time)
                return Estimate(
                    time,
                    2 * float(state.error.q[name]) / max(abs(float(state.velocity[name])), 1e-300)
                    + 4 * EPS * abs(time),
                )
        before = after
    raise NotConvergedError(f"{name} did not pass {value:.12g} in the time searched")


def boundary_times(motion: SeparatedMotion) -> dict[str, Estimate]:
    """Return, for every coordinate that will reach an end of its domain, when."""
    result = {}
    for k, name in enumerate(motion.solution.coordinates):
        coordinate_motion = motion.located[name].coordinate_motion
        if coordinate_motion.ends(1) in {"boundary", "fall"}:
            # the phase at the end of the domain itself, or the farthest one that is integrated
            context = multiprecision(bits_for(motion.digits, 64))
            phase = coordinate_motion.branches[0].end_map.last(context) or context.mpf(farthest(motion.digits))
            with suppress(OutsideMotionError):  # the others run away before, in a time of its own that ends
                result[name] = _shifted(motion, *_elapsed(motion, k, phase))
    return result
