"""Angle variables along a motion, θ = θ₀ + Ω (t − t₀), with their errors.

θ₀ is the right side of Jacobi's equations in angle form at t₀ (``time_law.torus``), counted from where librations stand
at their lower turning points and rotations opposite to their highest barrier. Ω is known to more digits than it is
rounded to; whole turns are taken away in double-double, or in the digits of the motion. The error is that of θ₀, whose
series have coefficients in the digits of the motion, and the rounding of the last sum.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.error_free import split
from hjsolve.arithmetic.floats import EPS, Multi, multiprecision
from hjsolve.arithmetic.number_types import Context, Mpf, Numbers, Reals
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.motion.characteristic import unit_of
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.phases import times_at
from hjsolve.motion.positions import constant_index, principal_values
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.shapes import shaped
from hjsolve.motion.times import read_times, whole_numbers, within_doubles
from hjsolve.one_coordinate.anomaly import Rotation, TwoBarrierAnomaly
from hjsolve.one_coordinate.coordinate_motion import Periodic
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.one_coordinate.resting_motion import AtRest
from hjsolve.one_coordinate.stretched_anomaly import Stretched
from hjsolve.time_law.open_motion import TriangularScheme, own_turns
from hjsolve.time_law.phase_reduction import turns_and_rest
from hjsolve.time_law.torus import mean_rate, oscillation


@dataclass(frozen=True, repr=False, eq=False)
class AngleVariables(ByValue, Shown, Mapping[str, Any]):
    """Angle variables at some times: a mapping from coordinates to their angles, and the errors of these.

    Attributes:
        value: coordinate → angle in (−π, π], radians; a number for one time, else an array of the shape of the times.
        error: coordinate → bound on its error modulo 2π, of the same shape.
    """

    value: Mapping[str, Any]
    error: Mapping[str, Any]

    def __getitem__(self, name: str) -> Any:
        return self.value[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.value)

    def __len__(self) -> int:
        return len(self.value)


@dataclass(frozen=True)
class _Line:
    """θ = direction · (start + rate · (t − t₀)) of one coordinate, and how far the start is known."""

    rate: Mpf
    start: Mpf
    direction: int
    uncertainty: float


def angle_variables(motion: SeparatedMotion, t: object) -> AngleVariables:
    """Return θ = θ₀ + Ω (t − t₀) in (−π, π]; see ``Motion.angles``."""
    shape, floats, exact = read_times(t)
    time, precise, bits = times_at(motion, floats, exact)
    time = within_doubles(time)
    value, error = {}, {}
    for name, line in _lines(motion, bits).items():
        if motion.digits > FLOAT_DIGITS:
            found, bound = _in_many_digits(line, precise, bits, unit_of(motion))
        else:
            found, bound = _in_doubles(line, time)
        value[name], error[name] = shaped(found, shape), shaped(bound, shape)
    return AngleVariables(value, error)


def _in_doubles(line: _Line, time: tuple[Reals, Reals]) -> tuple[Numbers, Reals]:
    turn = 2 * multiprecision(160).pi
    # turns are taken out in two doubles: θ after 10⁹ periods is as good as after one
    whole, rest = turns_and_rest(split(line.rate / turn), time, split(line.start / turn))
    whole_numbers(whole)
    angle, _ = principal_values(line.direction * (2 * np.pi * rest))
    # 2⁻¹⁰⁰ of all that was grown is what two doubles lose of the turns
    grown = np.abs(time[0]) * abs(float(line.rate))
    return angle, line.uncertainty + 2 * EPS * np.abs(angle) + 2.0**-100 * (grown + abs(float(line.start)))


def _in_many_digits(line: _Line, time: list[Mpf], bits: int, unit: float) -> tuple[Numbers, Reals]:
    context = multiprecision(bits)
    angles = np.empty(len(time), dtype=object)
    for m, t in enumerate(time):
        angles[m] = line.direction * (context.convert(line.start) + context.convert(line.rate) * t)
    reduced, whole = principal_values(angles)
    whole_numbers(whole)
    return reduced, line.uncertainty + unit * np.abs(reduced).astype(float) + np.zeros(len(time))


def _lines(motion: SeparatedMotion, bits: int) -> dict[str, _Line]:
    torus = motion.torus
    if motion.scheme is not None:
        return _lines_of_own_clocks(motion, motion.scheme, bits)
    if torus is None:
        return {name: _even(motion, name, bits) for name in motion.frequencies}
    context, unit = multiprecision(bits), unit_of(motion)
    begins = [phase_of_zero(coordinate_motion, context, bits) for coordinate_motion in torus.coordinate_motions]
    result = {}
    for name, frequency in motion.frequencies.items():
        if name in motion.located:
            k = list(motion.solution.coordinates).index(name)
            rate, series = torus.rates[k], torus.oscillations[k]
            # the phase follows its own rate; θ has the sign of Ω
            direction = 1 if float(frequency.value) * float(rate) > 0 else -1
            start, uncertainty = (
                torus.starts[k] - begins[k],
                torus.roundings[k] + _slopes(torus.coordinate_motions, series, unit),
            )
            # θ counts from the lower turning point, or opposite the highest barrier: what oscillates is 0 there
            start -= sum(oscillation_at(s, begin) for s, begin in zip(series, begins, strict=True))
        else:
            j = constant_index(motion, name)
            rate, direction = mean_rate(torus, j), 1  # Ω is the mean growth itself, which may be 0
            start = to_bits(motion.initial.values[motion.solution.system.coordinate(name).symbol])(bits)
            series = tuple(oscillation(torus, i, j) for i in range(len(torus.coordinate_motions)))
            for coordinate_motion, s, begin in zip(torus.coordinate_motions, series, begins, strict=True):
                start -= oscillation_at(s, context.mpf(coordinate_motion.start)) - oscillation_at(s, begin)
            uncertainty = _slopes(torus.coordinate_motions, series, unit)
        result[name] = _Line(rate, start, direction, float(uncertainty) + sum(map(_inexact, series)) * unit)
    return result


def _lines_of_own_clocks(motion: SeparatedMotion, scheme: TriangularScheme, bits: int) -> dict[str, _Line]:
    """Angles of the coordinates that come back while another one does not."""
    context, unit, names = multiprecision(bits), unit_of(motion), list(motion.solution.coordinates)
    result = {}
    for own in own_turns(scheme, bits):
        if (name := names[own.index]) in motion.frequencies:
            begin = phase_of_zero(own.cycle, context, bits)
            start = own.start - begin - oscillation_at(own.series, begin)
            uncertainty = own.rounding + _slopes([own.cycle], [own.series], unit) + _inexact(own.series) * unit
            result[name] = _Line(own.rate, start, own.cycle.direction, uncertainty)
    return result


def _even(motion: SeparatedMotion, name: str, bits: int) -> _Line:
    """Return the angle of an ignorable coordinate where no coordinate is left: it grows evenly, Ω = ∂H/∂p."""
    coordinate, values = motion.solution.system.coordinate(name), motion.initial.values
    rate = sp.diff(motion.solution.separation.shell.potential, coordinate.momentum).subs(values)
    return _Line(to_bits(rate)(bits), to_bits(values[coordinate.symbol])(bits), 1, 0.0)


def phase_of_zero(coordinate_motion: Periodic | AtRest, context: Context, bits: int) -> Mpf:
    """Return the phase from which an angle is counted: of a rotation that of the place opposite to its highest barrier.

    Args:
        coordinate_motion: of the coordinate.
        context, bits: of the arithmetic.
    """
    if isinstance(coordinate_motion, Periodic):
        anomaly = (
            coordinate_motion.anomaly.inner
            if isinstance(coordinate_motion.anomaly, Stretched)
            else coordinate_motion.anomaly
        )
        if isinstance(anomaly, Rotation | TwoBarrierAnomaly):
            arithmetic = Multi(bits)
            return context.mpf(
                coordinate_motion.anomaly.phase(arithmetic.convert(anomaly.slow) + arithmetic.pi(), 1, arithmetic)
            )
    return context.mpf(0)


def oscillation_at(series: FourierSeries, phase: Mpf) -> Mpf | int:
    """Return a series without its mean at one phase; nothing at phase 0.

    Args:
        series: odd.
        phase: in many digits.
    """
    return 0 if series.constant or not phase else series.oscillation(phase)


def _inexact(series: FourierSeries) -> float:
    """Return what the rounding of an oscillation is relative to.

    Twice, at the start and at the beginning of the angle.
    """
    return 0.0 if series.constant else 2 * series.oscillation_size


def _slopes(coordinate_motions: Sequence[Periodic | AtRest], series: Sequence[FourierSeries], unit: float) -> float:
    """Return what the phases at t₀ leave open of the angle: dθ/dχ at the start, times the rounding of χ."""
    total = 0.0
    for coordinate_motion, s in zip(coordinate_motions, series, strict=True):
        phase = float(coordinate_motion.start)
        slope = abs(float(s.value(np.array([phase]))[0]) - float(s.mean)) if not s.constant else 0.0
        grown = (
            coordinate_motion.phase_rounding(np.array([phase]))[0] * (unit / EPS)
            if isinstance(coordinate_motion, Periodic)
            else 0.0
        )
        total += (1 + slope) * (unit * abs(phase) + float(grown))
    return total
