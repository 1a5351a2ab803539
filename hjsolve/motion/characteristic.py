"""W and S as numbers: Hamilton's characteristic and principal function along a motion, and Jacobi's constants β.

Along the motion from t₀, W = ∫ p·dq = Σᵢ ∫ Pᵢ dqᵢ + Σ c_k Δq_k − Δχ (Greenwood (5-65), (5-83); χ the potential of the
shift p = P − A), each term from the series of its coordinate, so that a cycle adds ∮ Pᵢ dqᵢ exactly however many
there were; S = W − E (t − t₀). No differential equation is integrated.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.floats import EPS, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Counts, Elementwise, Mpf, Numbers, Reals
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.phases import Phases, coordinate_motions_of, phases_at
from hjsolve.motion.positions import evaluate_along, positions_at, travelled
from hjsolve.motion.quantities import FLOAT_DIGITS, rounded
from hjsolve.motion.separated import SeparatedMotion, separated_motion
from hjsolve.motion.shapes import Shape, shaped
from hjsolve.motion.state_errors import ignorable_error, phase_errors
from hjsolve.motion.tabulated import needs_table
from hjsolve.motion.times import read_times
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion

FINER = 26
"""Digits of the phases where doubles leave too much of them open (``tabulated.needs_table``)."""


def waves_along(motion: SeparatedMotion, t: object, *, principal: bool) -> Estimate | EstimateArray:
    """Return W, or S = W − E (t − t₀) where ``principal``, at times; see ``Motion.characteristic_function``."""
    shape, floats, exact = read_times(t)
    # where q(t) needs a table W has none: more digits take its place
    source = _finer(motion) if motion.digits <= FLOAT_DIGITS and needs_table(motion) else motion
    phases = phases_at(source, floats, exact)
    value, error = _characteristic(source, phases)
    if principal:
        term, uncertainty = _energy_term(source, phases)
        value, error = value - term, error + uncertainty + unit_of(source) * (abs(value) + abs(term)).astype(float)
    if phases.ended.any():
        value, error = np.where(phases.ended, np.nan, value), np.where(phases.ended, np.nan, error)
    return estimates(value, error, shape, motion.digits)


def estimates(value: Numbers, error: Reals, shape: Shape, digits: int) -> Estimate | EstimateArray:
    """Return numbers with their errors in the shape asked for, as doubles where no more digits are asked.

    Args:
        value, error: the numbers and bounds on their errors, shape (m,).
        shape: asked for; empty or None for one number.
        digits: asked for.
    """
    if digits <= FLOAT_DIGITS and value.dtype == object:
        value = value.astype(float)
        error = error.astype(float) + EPS * np.abs(value)
    if shape:
        return EstimateArray(value.reshape(shape), error.reshape(shape))
    return Estimate(shaped(value, shape), shaped(error, shape))


@lru_cache(maxsize=16)
def _finer(motion: SeparatedMotion) -> SeparatedMotion:
    return separated_motion(motion.solution, motion.initial, motion.t0, FINER, motion.parts)


def unit_of(motion: SeparatedMotion) -> float:
    """Return the rounding unit of a motion's numbers.

    Args:
        motion: in its digits.
    """
    return EPS if motion.digits <= FLOAT_DIGITS else float(multiprecision(64).mpf(10) ** (1 - motion.digits))


def _characteristic(motion: SeparatedMotion, phases: Phases) -> tuple[Numbers, Reals]:
    """W and a bound on its error, shape (m,)."""
    solution, unit = motion.solution, unit_of(motion)
    many = phases.exact is not None
    value, error = _zeros(motion, phases), 0.0 * phases.time[0]
    phase_error = phase_errors(motion, phases, unit)
    for k, coordinate_motion in enumerate(coordinate_motions_of(motion, phases)):
        part, slope, size = swept_from_start(coordinate_motion, phases.χ[k], phases.whole[k], many=many)
        value = value + part
        # δW = p dq/dχ δχ, and the rounding of a difference of two integrals of this size
        error = error + slope.astype(float) * phase_error[k] + 4 * unit * size.astype(float)
    q, _, whole = positions_at(motion, phases)
    for coordinate in solution.system.coordinates:
        if coordinate.name not in solution.coordinates:
            exact = to_bits(motion.initial.values[coordinate.momentum])(bits_for(motion.digits, 96))
            c: Any = exact if many else float(exact)
            # ∫ p_φ dφ = p_φ Δφ with all turns, as p_φ is a constant
            end_map = travelled(motion, phases, coordinate.name, q)
            value = value + c * end_map
            uncertainty = ignorable_error(motion, phases, phase_error, coordinate.name, unit)
            error = error + abs(float(c)) * (uncertainty + 4 * unit * abs(end_map).astype(float))
    if solution.shift_potential != 0:
        # ∮ p dq = ∮ P dq − Δχ: the shift of a momentum is a gradient
        shift, uncertainty = gauge(motion, q, whole)
        value, error = value - shift, error + uncertainty
    return value, error + unit * abs(value).astype(float)


def _zeros(motion: SeparatedMotion, phases: Phases) -> Numbers:
    if phases.exact is None:
        return 0.0 * phases.time[0]
    return np.array([multiprecision(bits_for(motion.digits, 96)).zero] * len(phases.exact), dtype=object)


def swept_from_start(
    coordinate_motion: CoordinateMotion, χ: Numbers, whole: Counts, *, many: bool
) -> tuple[Numbers, Numbers, Numbers]:
    """Return ∫ P dq from the start to χ + 2π·whole, its slope by χ, and the size that rounding refers to.

    Args:
        χ: phases, shape (m,).
        whole: turns next to them, shape (m,).
        many: whether they have many digits.
    """
    start = np.array([coordinate_motion.start], dtype=object) if many else np.array([float(coordinate_motion.start)])
    there, slope, size = coordinate_motion.momentum_integral(χ)
    begin, rate, first = coordinate_motion.momentum_integral(start)
    if not many:  # the rounding of the phase of the start, to first order
        begin = begin + rate * float(coordinate_motion.start - start[0])
    value, size = there - begin[0], size + first[0]
    if coordinate_motion.cycle is not None and whole.any():
        context = coordinate_motion.cycle.density.mean.context  # type: ignore[union-attr]
        # a turn adds 2πJ, exactly: the number of turns loses no digits of what is left of one
        cycle = 2 * context.pi * coordinate_motion.action
        turned = whole.astype(int) * (cycle if many else float(cycle))
        value, size = value + turned, size + abs(turned)
    return value, slope, size


def gauge(motion: SeparatedMotion, q: dict[str, Numbers], whole: dict[str, Counts]) -> tuple[Numbers, Reals]:
    """Return Δχ from the start, χ(q) the potential of the shift with angles not reduced, and its rounding.

    Args:
        q: coordinate → places, shape (m,).
        whole: angle → turns that are not in q.
    """
    formula = motion.solution.shift_potential
    begin = to_bits(formula.subs(motion.initial.values))(bits_for(motion.digits, 96))
    # χ need not be periodic: it takes angles with all their turns
    full = {n: values + 2 * _pi(values) * whole[n].astype(int) if n in whole else values for n, values in q.items()}
    now = evaluate_along(motion, (formula,), full, {})[0]
    slopes = evaluate_along(
        motion, tuple(sp.diff(formula, c.symbol) for c in motion.solution.system.coordinates), full, {}
    )
    unit = unit_of(motion)
    uncertainty = 8 * unit * (abs(now).astype(float) + abs(float(begin)))
    for values, slope in zip(full.values(), slopes, strict=True):
        uncertainty = uncertainty + 4 * unit * abs(values * slope).astype(float)
    first: Any = begin if now.dtype == object else float(begin)
    return now - first, uncertainty


def _pi(values: NDArray[Any]) -> Elementwise:
    return values.flat[0].context.pi if values.dtype == object and values.size else np.pi


def _energy_term(motion: SeparatedMotion, phases: Phases) -> tuple[Numbers, Reals]:
    """E (t − t₀) and the rounding of it."""
    bits = bits_for(motion.digits, 96)
    E = to_bits(energy_of(motion))(bits)
    if phases.exact is not None:
        value = np.array([E * t for t in phases.exact], dtype=object)
    else:
        value = float(E) * phases.time[0]
    return value, 2 * unit_of(motion) * abs(value).astype(float)


def betas(motion: SeparatedMotion) -> dict[str, Estimate]:
    """Return Jacobi's constants; see ``Motion.betas``."""
    result, energy = {}, motion.solution.separation.shell.energy.name
    for j, name in enumerate(motion.solution.constants):
        if name == energy and not motion.solution.coordinates:
            continue  # a function of the other constants
        total, size, nodes = _integrals_at_start(motion, j)
        here, uncertainty = _outside_integrals(motion, name)
        # β_E = t₀ − Σ G_E and β_c = −(φ₀ − ∂χ/∂c + Σ G_c): Jacobi's equations at t₀ (Greenwood 6-79)
        value = here - total if name == energy else -(here + total)
        plain = rounded(value, motion.digits, nodes)
        noise = 4 * unit_of(motion) * (size + uncertainty)
        result[name] = Estimate(plain.value, plain.error + noise, nodes=nodes)
    return result


def _integrals_at_start(motion: SeparatedMotion, j: int) -> tuple[Mpf, float, int]:
    """Σᵢ Gᵢⱼ from the lower limits to the place at t₀, the size its rounding refers to, and the nodes behind it."""
    total, size, nodes = multiprecision(bits_for(motion.digits, 96)).zero, 0.0, 0
    for place in motion.located.values():
        coordinate_motion = place.coordinate_motion
        if coordinate_motion.rests or not _turns(coordinate_motion):
            continue
        if (cycle := coordinate_motion.cycle) is not None:
            series = cycle.kernels[j]
            periodic = 0 if series.constant else series.oscillation(coordinate_motion.start)
            # G(χ) = mean · χ + oscillation, from the lower turning point, where χ = 0
            part, nodes = series.mean * coordinate_motion.start + periodic, max(nodes, series.nodes)
            size += abs(float(series.mean * coordinate_motion.start)) + series.wave_size_at(coordinate_motion.start)
        else:
            begin = np.array([coordinate_motion.start], dtype=object if motion.digits > FLOAT_DIGITS else float)
            reaching = coordinate_motion.with_reach(abs(float(coordinate_motion.start)))
            part = reaching.integral(j, begin)[0]
            size += float(reaching.spacing(j, begin.astype(float))[0])
        total += part
    return total, size, nodes


def _turns(coordinate_motion: CoordinateMotion) -> bool:
    """Whether phase 0 is a turning point; else the lower limit is the place at t₀ itself, and nothing is integrated."""
    return all(branch.end_map.turning for branch in coordinate_motion.branches[:1]) and not coordinate_motion.rotates


def _outside_integrals(motion: SeparatedMotion, name: str) -> tuple[Mpf, float]:
    """Return what stands next to the integrals: t₀ for E.

    q − ∂χ/∂c at t₀ for the momentum of an ignorable coordinate.
    """
    solution, values, bits = motion.solution, motion.initial.values, bits_for(motion.digits, 96)
    constant = solution.constants[name].symbol
    if solution.coordinates and name == solution.separation.shell.energy.name:
        terms = [motion.t0]
    else:
        own = [c.symbol for c in solution.system.coordinates if c.momentum == constant]
        terms = [q.subs(values) for q in own] + [-sp.diff(solution.shift_potential, constant).subs(values)]
        if not solution.coordinates:
            terms.append(-motion.t0 * sp.diff(solution.separation.shell.potential, constant).subs(values))
    numbers = [to_bits(term)(bits) for term in terms]
    return sum(numbers, multiprecision(bits).zero), float(sum(abs(number) for number in numbers))


def lower_limits(motion: SeparatedMotion) -> dict[str, Estimate]:
    """Return where the quadratures of ``betas`` begin; see ``Motion.lower_limits``."""
    result = {}
    for name, place in motion.located.items():
        coordinate_motion, bits = place.coordinate_motion, bits_for(motion.digits, 96)
        if coordinate_motion.rests:
            value = coordinate_motion.place(np.zeros(1, dtype=object))[0][0]
        elif not _turns(coordinate_motion):
            value = to_bits(motion.initial.values[motion.solution.system.coordinate(name).symbol])(bits)
        elif coordinate_motion.cycle is not None:
            value = coordinate_motion.cycle.turning_points[0]
        else:
            value = coordinate_motion.branches[0].end_map.start
        result[name] = rounded(value, motion.digits)
    return result


def energy_of(motion: SeparatedMotion) -> sp.Expr:
    """Return the exact value of E, the constant that goes with the time."""
    shell = motion.solution.separation.shell
    if motion.solution.coordinates:
        return motion.initial.constants[shell.energy.name]
    return shell.potential.subs(motion.initial.values)
