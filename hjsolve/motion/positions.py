"""From phases to positions and momenta: separated coordinates by their courses, ignorable ones by Greenwood (5-83).

q and p are coordinate → array of shape (m,); phases are those of the separated coordinates at m times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from hjsolve.arithmetic.error_free import split
from hjsolve.arithmetic.floats import Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Counts, Elementwise, Mpf, N, Numbers, Reals
from hjsolve.mechanics.system import velocities
from hjsolve.motion.formulas_at_places import bounded_at, tape_of, values_at
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.phases import Phases, coordinate_motions_of
from hjsolve.one_coordinate.coordinate_motion import arithmetic_of
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.time_law.open_motion import integral_at_start
from hjsolve.time_law.phase_reduction import grown_by, turns_and_rest
from hjsolve.time_law.phase_reduction import principal as principal_of_doubles
from hjsolve.time_law.torus import mean_rate, oscillation

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion


def constant_index(motion: SeparatedMotion, name: str) -> int:
    """Return the place of an ignorable coordinate's momentum among the constants."""
    return list(motion.solution.constants).index(motion.solution.system.coordinate(name).momentum.name)


def positions_at(
    motion: SeparatedMotion, phases: Phases
) -> tuple[dict[str, Numbers], dict[str, Numbers], dict[str, Counts]]:
    """Return q, canonical p, and whole turns of the angles.

    Returns:
        Coordinate → array of shape (m,), three times; turns of angles only.
    """
    q: dict[str, Numbers] = {}
    shell: dict[str, Numbers] = {}
    whole: dict[str, Counts] = {}
    for name, coordinate_motion, χ, n in zip(
        motion.solution.coordinates, coordinate_motions_of(motion, phases), phases.χ, phases.whole, strict=True
    ):
        q[name], shell[name] = coordinate_motion.place(χ)
        # only rotations leave their turns in q; a libration is at the same place after each
        whole[name] = coordinate_motion.direction * n if coordinate_motion.rotates else 0 * n
        cycle, domain = coordinate_motion.cycle, motion.solution.system.coordinate(name).domain
        if cycle is not None and cycle.rotates and domain.kind == "line":
            # along a line p² repeats itself while q goes on
            q[name] = q[name] + cycle.length_of_turns(n, q[name])
    for coordinate in motion.solution.system.coordinates:
        if coordinate.name not in q:
            q[coordinate.name], whole[coordinate.name] = _ignorable(motion, phases, coordinate.name, q)
    p = canonical_momenta(motion, q, shell, [c.name for c in motion.solution.system.coordinates])
    for coordinate in motion.solution.system.coordinates:
        if coordinate.domain.kind == "angle":
            # an angle is given in (−π, π]; what was taken away is in ``turns``
            q[coordinate.name], more = principal_values(q[coordinate.name])
            whole[coordinate.name] = whole[coordinate.name] + more
        else:
            whole.pop(coordinate.name)
    names = [c.name for c in motion.solution.system.coordinates]
    return {n: q[n] for n in names}, p, {n: whole[n] for n in names if n in whole}


def principal_values(angle: Numbers) -> tuple[Numbers, Counts]:
    """Reduce to (−π, π] and count the turns taken away.

    Args:
        angle: in radians, shape (m,).

    Returns:
        The angle in (−π, π], and the turns taken away; shape (m,) each.
    """
    arithmetic = arithmetic_of(angle)
    return arithmetic.choose(
        lambda _: principal_of_doubles(angle.astype(float, copy=False)), lambda many: _principal_of_digits(angle, many)
    )


def _principal_of_digits(angle: Numbers, arithmetic: Multi) -> tuple[Numbers, Counts]:
    context, turn = arithmetic.context, 2 * arithmetic.pi()
    n = np.array([int(context.ceil((x - context.pi) / turn)) for x in angle])
    return np.array([x - turn * int(k) for x, k in zip(angle, n, strict=True)], dtype=object), n


def canonical_momenta(
    motion: SeparatedMotion, q: Mapping[str, Numbers], shell: Mapping[str, Numbers], wanted: list[str]
) -> dict[str, Numbers]:
    """Canonical momenta: p = P − A for separated coordinates, the constants for ignorable ones.

    Args:
        shell: separated coordinate → P = p + A, shape (m,).
        wanted: names of the coordinates whose p is to be given.
    """
    solution = motion.solution
    result = {}
    for coordinate in solution.system.coordinates:
        name = coordinate.name
        if name not in wanted:
            continue
        if name in shell:
            A = solution.shift[name]
            result[name] = shell[name] if A == 0 else shell[name] - evaluate_along(motion, (A,), q, {})[0]
        else:
            constant = to_bits(motion.initial.values[coordinate.momentum])(bits_for(motion.digits, 64))
            some = next(iter(q.values()))
            result[name] = (float(constant) if some.dtype != object else constant) + 0 * some
    return result


def coordinate_velocities(
    motion: SeparatedMotion, q: Mapping[str, Numbers], p: Mapping[str, Numbers]
) -> dict[str, Numbers]:
    """Return dq/dt of every coordinate."""
    formulas = velocities(motion.solution.system)
    return dict(zip(formulas, evaluate_along(motion, tuple(formulas.values()), q, p), strict=True))


def evaluate_along(
    motion: SeparatedMotion, formulas: tuple[sp.Expr, ...], q: Mapping[str, Numbers], p: Mapping[str, Numbers]
) -> list[Numbers]:
    """Evaluate formulas in coordinates, momenta, constants and parameters along the motion.

    Args:
        q, p: coordinate → array of shape (m,), doubles or many digits; those left out take their initial values.

    Returns:
        One array of shape (m,) for each formula.
    """
    arrays, fixed = known_along(motion, q, p)
    return values_at(tape_of(tuple(formulas), (*arrays, *fixed)), list(arrays.values()), list(fixed.values()))


def known_along(
    motion: SeparatedMotion, q: Mapping[str, N], p: Mapping[str, N]
) -> tuple[dict[sp.Symbol, N], dict[sp.Symbol, sp.Expr]]:
    """Return what varies along a motion by its symbol, places before momenta, and the exact values of the rest.

    Args:
        q, p: coordinate → what it is.
    """
    coordinates = motion.solution.system.coordinates
    varies = {c.symbol: q[c.name] for c in coordinates if c.name in q}
    varies |= {c.momentum: p[c.name] for c in coordinates if c.name in p}
    return varies, {s: v for s, v in motion.initial.values.items() if s not in varies}


def rounding(
    motion: SeparatedMotion, formulas: tuple[sp.Expr, ...], q: Mapping[str, Numbers], p: Mapping[str, Numbers]
) -> list[Reals]:
    """Bound what evaluating formulas in doubles loses, cancellation included (``arithmetic.running_error``).

    Returns:
        One array of absolute bounds, shape (m,), for each formula.
    """
    places, fixed = known_along(motion, q, p)
    tape = tape_of(tuple(formulas), (*places, *fixed))
    # places count as exact here: their own errors are bounded with the slopes (``state_errors``)
    found = bounded_at(tape, list(places.values()), [None] * len(places), list(fixed.values()))
    return [error for _, error in found]


def travelled(motion: SeparatedMotion, phases: Phases, name: str, q: Mapping[str, Numbers]) -> Numbers:
    """Return how far an ignorable coordinate has come since t₀; an angle with all its turns.

    Args:
        name: of the ignorable coordinate.
        q: separated coordinate → array of shape (m,).
    """
    return _grown_from(motion, phases, name, q, to_bits(sp.S.Zero), angle=False)[0]


def _ignorable(motion: SeparatedMotion, phases: Phases, name: str, q: Mapping[str, Numbers]) -> tuple[Numbers, Counts]:
    """Return an ignorable coordinate, and the whole turns taken from it."""
    coordinate = motion.solution.system.coordinate(name)
    begin = to_bits(motion.initial.values[coordinate.symbol])
    return _grown_from(motion, phases, name, q, begin, angle=coordinate.domain.kind == "angle")


def _grown_from(
    motion: SeparatedMotion,
    phases: Phases,
    name: str,
    q: Mapping[str, Numbers],
    begin: Callable[[int], Mpf],
    *,
    angle: bool,
) -> tuple[Numbers, Counts]:
    """φ(t) = φ₀ − Σᵢ [Gᵢ(χᵢ) − Gᵢ(χᵢ⁰)] + ∂χ/∂c: Greenwood (5-83). On a torus the mean growth is reduced exactly."""
    solution, torus = motion.solution, motion.torus
    coordinate = solution.system.coordinate(name)
    if motion.equations is None:
        # no separated coordinate at all: ignorable ones grow evenly, by ∂H/∂p
        rate = to_bits(sp.diff(solution.separation.shell.potential, coordinate.momentum).subs(motion.initial.values))(
            256
        )
        return grown(begin, rate, phases.time, phases.exact, angle, 0)
    j = constant_index(motion, name)
    gauge = gauge_angle(motion, coordinate.momentum, q)
    if torus is not None:
        wave = gauge
        for i, bounded in enumerate(torus.coordinate_motions):
            # on a torus the mean growth Ω_φ t is apart, reduced by whole turns; here is only what oscillates
            series = oscillation(torus, i, j)
            if not series.constant:
                wave = wave + _rise(series, phases.χ[i], bounded.start)
        return grown(begin, mean_rate(torus, j), phases.time, phases.exact, angle, wave)
    total = gauge
    for coordinate_motion, χ, n in zip(coordinate_motions_of(motion, phases), phases.χ, phases.whole, strict=True):
        many = χ.dtype == object
        first = (
            coordinate_motion.integral(j, np.array([coordinate_motion.start], dtype=object))[0]
            if many
            else integral_at_start(coordinate_motion, j)
        )
        total = total - (coordinate_motion.integral(j, χ) - first)
        if coordinate_motion.cycle is not None and n.any():
            turn = 2 * multiprecision(bits_for(motion.digits, 96)).pi if χ.dtype == object else 2 * np.pi
            growth = (
                coordinate_motion.cycle.growth(j) if χ.dtype == object else float(coordinate_motion.cycle.growth(j))
            )
            # turns of a bounded coordinate next to one that runs away: each adds the growth of its integral
            total = total - n.astype(int) * (turn * growth)
    return grown(begin, 0, phases.time, phases.exact, angle, total)


def _rise(series: FourierSeries, χ: Numbers, start: Mpf | int) -> Numbers:
    """Ripple at χ minus ripple at the start."""
    if χ.dtype == object:
        return series.oscillation(χ) - series.oscillation(start)
    return series.oscillation(χ) - series.oscillation(np.array([float(start)]))


def gauge_angle(motion: SeparatedMotion, constant: sp.Symbol, q: Mapping[str, Numbers]) -> Numbers | int:
    """∂χ/∂c at q minus its value at the start; 0 where no shift was made.

    Args:
        constant: c, the symbol of a constant of the motion.
    """
    formula = sp.diff(motion.solution.shift_potential, constant)
    # of q only what the formula has: a place that is not worked out yet may wait for this very angle
    seen = [c.name for c in motion.solution.system.coordinates if formula.has(c.symbol)]
    if not seen:
        return 0
    begin: Elementwise = to_bits(formula.subs(motion.initial.values))(bits_for(motion.digits, 64))
    values = evaluate_along(motion, (formula,), {name: q[name] for name in seen}, {})[0]
    return values - (float(begin) if values.dtype != object else begin)


def grown(
    begin: Callable[[int], Mpf],
    rate: Mpf | int,
    time: tuple[Reals, Reals],
    exact: list[Mpf] | None,
    angle: bool,
    wave: Numbers | float,
) -> tuple[Numbers, Counts]:
    """Return begin + rate·(t − t₀) + wave, with whole turns of the growth taken out.

    Args:
        begin: rule that gives q at t₀ in any number of binary digits.
        rate: mean dq/dt, in many digits.
        time: t − t₀ as two doubles, shape (m,).
        exact: t − t₀ in many digits; None in double precision.
        angle: True where turns are taken out.
        wave: what comes on top of the growth, shape (m,).

    Returns:
        The coordinate, and the whole turns; shape (m,) each.
    """
    if exact is not None:
        context = exact[0].context
        # many digits hold all turns: nothing need be taken out
        values = np.array([begin(context.prec) + rate * t for t in exact], dtype=object) + wave
        return values, np.zeros(len(values), dtype=int)
    if not angle:
        value = grown_by(split(multiprecision(256).mpf(rate)), time, float(begin(256)) + wave)
        return value, np.zeros(value.shape, dtype=int)
    turn = 2 * multiprecision(256).pi
    # (rate/2π)(t − t₀) in two doubles, whole turns apart: the rest has an absolute error of a few units of 2⁻⁵³
    whole, rest = turns_and_rest(split(rate / turn), time, split(begin(256) / turn))
    return 2 * np.pi * rest + wave, whole
