"""Error bounds of a state, from the bounds on its phases and the rounding of what follows.

q, p and v are coordinate → array of shape (m,), ``unit`` is the relative rounding of the arithmetic.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np
import sympy as sp

from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS, Multi, multiprecision
from hjsolve.arithmetic.number_types import Counts, Mask, Numbers, Reals
from hjsolve.errors import required
from hjsolve.mechanics.system import hamiltonian, velocities
from hjsolve.motion.near_poles import lost_in_two_doubles, places, worked_out
from hjsolve.motion.phases import Phases, coordinate_motions_of
from hjsolve.motion.positions import constant_index, evaluate_along, rounding
from hjsolve.motion.tabulated import DenseOutput
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion
from hjsolve.time_law.torus import oscillation

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion

_LEAST = 2.0**-1074
"""The smallest double: what is too small for doubles is not exactly zero."""
_TABLE = 1e-14
"""Relative accuracy of a table, above the phases' own."""
_ANGLE = 5e-15
"""The same of an angle that is put together from a table and an even growth, above the size of π and its own."""


def errors_of_state(
    motion: SeparatedMotion,
    phases: Phases,
    q: Mapping[str, Numbers],
    p: Mapping[str, Numbers],
    whole: Mapping[str, Counts],
    sharp: Mask | None = None,
) -> tuple[dict[str, Reals], dict[str, Reals], dict[str, Reals]]:
    """Return bounds on q, p and velocity from the bounds on the phases.

    ``sharp``: where velocities were not worked out from rounded places (``near_poles.badly_rounded``); None where all
    were.

    Args:
        phases: with their error bounds.
        whole: coordinate → turns of the angles, shape (m,).
        sharp: bool array of shape (m,), True where velocities come from places in two doubles; None where none do.

    Returns:
        Coordinate → absolute bounds of shape (m,), of q, of p and of the velocity.
    """
    unit = EPS if phases.exact is None else float(multiprecision(64).mpf(10) ** -motion.digits)
    dq, dp = {}, {}
    χ = [x.astype(float) for x in phases.χ]
    coordinate_motions = coordinate_motions_of(motion, phases)
    phase_error = phase_errors(motion, phases, unit)
    for name, coordinate_motion, x, e in zip(
        motion.solution.coordinates, coordinate_motions, χ, phase_error, strict=True
    ):
        slope_q, slope_p = _slopes(coordinate_motion, x, e)
        size_q, size_p = _unreduced(coordinate_motion, q[name], whole.get(name)), np.abs(p[name].astype(float))
        # q = a + (b − a) s: next to q = 0 between the turning points the terms cancel, and their rounding is left
        if motion.turning_points.get(name, (None, None))[0] is not None and _straddles(motion, name):
            size_q = size_q + _width(motion, name)
        dq[name] = slope_q * e + 4 * unit * size_q + _LEAST
        moved, shift = _shifted(motion, name, q)
        size_p = size_p + shift  # p = P − A(q): where they cancel, the rounding of both is left
        dp[name] = slope_p * e + moved * dq[name] + (16 + coordinate_motion.momentum_noise(x)) * unit * size_p + _LEAST
    for coordinate in motion.solution.system.coordinates:
        name = coordinate.name
        if name not in dq:  # ignorable: its momentum is constant, and given
            dq[name] = ignorable_error(motion, phases, phase_error, name, unit) + 4 * unit * (
                np.abs(q[name].astype(float)) + np.pi
            )
            dp[name] = unit * np.abs(p[name].astype(float))
    dv = velocity_errors(motion, q, p, dq, dp, unit)
    if sharp is not None and sharp.any():
        phases_there, errors_there = [x[sharp] for x in χ], [e[sharp] for e in phase_error]
        _put_in(dv, _sharp_errors(motion, coordinate_motions, phases_there, errors_there, q, sharp), sharp)
    return dq, dp, dv


def _put_in(errors: dict[str, Reals], better: Mapping[str, Numbers], where: Mask) -> None:
    for name, values in better.items():
        errors[name] = np.array(np.broadcast_to(errors[name], where.shape))
        errors[name][where] = values


def _sharp_errors(
    motion: SeparatedMotion,
    coordinate_motions: list[CoordinateMotion],
    χ: list[Reals],
    phase_error: list[Reals],
    q: Mapping[str, Numbers],
    where: Mask,
) -> dict[str, Reals]:
    """Return bounds on velocities worked out in two doubles: what the phases leave open, and the last rounding."""
    exact, shell = places(motion, coordinate_motions, χ)
    uncertainties: dict[sp.Symbol, Reals] = {}
    for name, coordinate_motion, x, e in zip(
        motion.solution.coordinates, coordinate_motions, χ, phase_error, strict=True
    ):
        c = motion.solution.system.coordinate(name)
        slope_q, slope_p = _slopes(coordinate_motion, x, e)
        moved, _ = _shifted(motion, name, {n: values[where] for n, values in q.items()})
        uncertainties[c.symbol] = slope_q * e + 16 * EPS * coordinate_motion.place_spacing(x) + _LEAST
        own = slope_p * e + (16 + coordinate_motion.momentum_noise(x)) * EPS * np.abs(shell[name]) + _LEAST
        uncertainties[c.momentum] = own + moved * uncertainties[c.symbol]
    return _by_uncertainties(motion, uncertainties, exact, shell, q, where)


def _by_uncertainties(
    motion: SeparatedMotion, uncertainties: Mapping[sp.Symbol, Reals], exact: Mapping[str, Pair],
    shell: Mapping[str, Numbers], q: Mapping[str, Numbers], where: Mask,
) -> dict[str, Reals]:  # fmt: skip
    """Return what doubts of separated coordinates and momenta leave open of the velocities, and the last rounding."""
    rest = {name: values[where] for name, values in q.items() if name not in exact}
    formulas = velocities(motion.solution.system)
    # next to a pole the slopes, too, hold differences that doubles have lost
    gradients = tuple(sp.diff(f, s) for f in formulas.values() for s in uncertainties)
    found = worked_out(motion, (*gradients, *formulas.values()), exact, shell, rest)
    lost = lost_in_two_doubles(motion, tuple(formulas.values()), exact, shell, rest)
    result: dict[str, Reals] = {}
    for row, name in enumerate(formulas):
        parts = zip(found[row * len(uncertainties) :], uncertainties.values(), strict=False)
        summed = cast("Reals", sum(np.abs(slope) * uncertainty for slope, uncertainty in parts))
        result[name] = summed + lost[row] + 4 * EPS * np.abs(found[len(gradients) + row]) + _LEAST
    return result


def table_errors(
    motion: SeparatedMotion,
    table: DenseOutput,
    θ: Reals,
    q: Mapping[str, Numbers],
    p: Mapping[str, Numbers],
    v: Mapping[str, Numbers],
    sharp: Mask | None = None,
) -> tuple[dict[str, Reals], dict[str, Reals], dict[str, Reals]]:
    """Bounds on q, p and velocity read from a table: its own accuracy, and the rounding of its argument as a delay.

    ``sharp`` as in ``errors_of_state``.

    Args:
        table: what the state was read from.
        sharp: as in ``errors_of_state``.

    Returns:
        As ``errors_of_state``.
    """
    system = motion.solution.system
    torus = motion.torus
    if torus is not None:
        delay = (3 * EPS * np.abs(θ) + torus.roundings[0] + table.table.uncertainty(θ)) / abs(float(torus.rates[0]))
    else:
        delay = 3 * EPS * (np.abs(θ) + abs(table.begin))
        delay = delay + table.table.uncertainty(θ)
    separated = motion.solution.coordinates[0]
    H = hamiltonian(system)
    # a delay moves q by q̇ and p by −∂H/∂q times itself
    forces = evaluate_along(motion, tuple(-sp.diff(H, c.symbol) for c in system.coordinates), q, p)
    dq, dp = {}, {}
    for c, force in zip(system.coordinates, forces, strict=True):
        index = 0 if c.name == separated else table.waves[c.name][0]
        inner = _TABLE * table.table.sizes(index, θ)
        runs_on = c.name != separated or (
            c.domain.kind == "line" and motion.located[separated].coordinate_motion.rotates
        )
        # the growth is added to what the table holds: the sum is rounded to the size of the angle
        inner = inner if not runs_on else np.maximum(inner, _ANGLE * (np.pi + np.abs(q[c.name])))
        dq[c.name] = np.abs(v[c.name]) * delay + inner
        own = _TABLE * table.table.sizes(1, θ) if c.name == separated else 2 * EPS * np.abs(p[c.name])
        moved, shift = _shifted(motion, c.name, q)
        own = own + moved * inner + 8 * EPS * shift
        dp[c.name] = np.abs(force) * delay + own
    dv = velocity_errors(motion, q, p, dq, dp, EPS)
    if sharp is not None and sharp.any():
        c = system.coordinate(separated)
        below, above = (table.table.sizes(end, θ) for end in required(table.ends))
        spacing_q = np.where(below < above, above, below)  # either may have been the nearer one on the panel
        moved, _ = _shifted(motion, separated, q)
        delay = np.broadcast_to(delay, θ.shape)
        dq_inner = np.abs(v[separated]) * delay + _TABLE * spacing_q + _LEAST
        dp_inner = np.abs(forces[list(dq).index(separated)]) * delay + _TABLE * table.table.sizes(1, θ) + _LEAST
        uncertainties = {c.symbol: dq_inner[sharp], c.momentum: (dp_inner + moved * dq_inner)[sharp]}
        _put_in(dv, _by_uncertainties(motion, uncertainties, *table.places(motion, θ[sharp]), q, sharp), sharp)
    return dq, dp, dv


def _shifted(motion: SeparatedMotion, name: str, q: Mapping[str, Numbers]) -> tuple[Reals | float, Reals | float]:
    """|∂A/∂q| of the shift between the canonical momentum and the root, p = P − A(q), and the size A is rounded to."""
    A = motion.solution.shift.get(name, sp.Integer(0))
    if A == 0:
        return 0.0, 0.0
    symbol = motion.solution.system.coordinate(name).symbol
    slope, value = evaluate_along(motion, (sp.diff(A, symbol), A), q, {})
    # ``rounding`` counts 4 EPS of each size; what is asked for here are sizes
    own = rounding(motion, (A,), q, {})[0] / (4 * EPS)
    return np.abs(np.asarray(slope, dtype=float)), np.abs(np.asarray(value, dtype=float)) + own


def _unreduced(coordinate_motion: CoordinateMotion, q: Numbers, whole: Counts | None) -> Reals:
    """Return the size of q before whole turns were taken from it: that is what was rounded."""
    if whole is None:
        return np.abs(q.astype(float))
    if coordinate_motion.cycle is not None and coordinate_motion.rotates:  # whole turns of its phase were never added
        middle = coordinate_motion.cycle.anomaly.place(multiprecision(64).zero, Multi(64)).q
        return np.abs(q.astype(float)) + (abs(float(middle)) + np.pi) / 4
    return np.abs(q.astype(float) + 2 * np.pi * whole.astype(float))


def _straddles(motion: SeparatedMotion, name: str) -> bool:
    low, high = motion.turning_points[name]
    return high is None or low is None or float(low.value) * float(high.value) <= 0


def _width(motion: SeparatedMotion, name: str) -> float:
    return sum(abs(float(end.value)) for end in motion.turning_points[name] if end is not None)


def _slopes(coordinate_motion: CoordinateMotion, χ: Reals, error: Reals) -> tuple[Reals, Reals]:
    """|dq/dχ| and |dp/dχ| by differences over the error of χ, or small ones; generous where they vary."""
    coordinate_motion = coordinate_motion.in_doubles()
    scale = np.maximum(1.0, np.abs(χ)) if coordinate_motion.branches else 1.0  # far out, steps must be seen
    h, rest = np.clip(error, 1e-6 * scale, 0.5 * scale), 1e-6 / scale
    (q1, p1), (q0, p0), (q2, p2) = (coordinate_motion.place(χ + s) for s in (-h, 0.0, h))
    return 2 * np.maximum(np.abs(q2 - q0), np.abs(q0 - q1)) / h + rest * np.abs(q2 - q1), 2 * np.maximum(
        np.abs(p2 - p0), np.abs(p0 - p1)
    ) / h + rest * np.abs(p2 - p1)


def phase_errors(motion: SeparatedMotion, phases: Phases, unit: float) -> list[Reals]:
    """Return the bounds on the phases, with the rounding of stretched anomalies; one array a separated coordinate.

    Args:
        phases: of its separated coordinates, with their own bounds.
    """
    together = zip(phases.errors, coordinate_motions_of(motion, phases), phases.χ, strict=True)
    return [np.asarray(e, dtype=float) + c.phase_rounding(x.astype(float)) * (unit / EPS) for e, c, x in together]


def ignorable_error(motion: SeparatedMotion, phases: Phases, phase_error: list[Reals], name: str, unit: float) -> Reals:
    """Return what the phases leave open of an ignorable coordinate, without the rounding of the last sum.

    Args:
        phase_error: bounds on them, one array of shape (m,) a separated coordinate.
        name: of the ignorable coordinate.
    """
    χ = [x.astype(float) for x in phases.χ]
    total = 0.0 * phases.time[0]
    if motion.equations is None:
        return total
    j = constant_index(motion, name)
    for i, coordinate_motion in enumerate(coordinate_motions_of(motion, phases)):
        rate = np.abs(np.asarray(coordinate_motion.rate(j, χ[i] if phases.exact is None else phases.χ[i]), dtype=float))
        total = total + rate * phase_error[i]
        if motion.torus is not None:
            total = total + 4 * unit * oscillation(motion.torus, i, j).size
        elif coordinate_motion.branches:
            begin = np.array([float(coordinate_motion.start)])
            total = total + 4 * unit * (coordinate_motion.spacing(j, χ[i]) + coordinate_motion.spacing(j, begin)[0])
        else:
            total = total + 4 * unit * coordinate_motion.spacing(j, phases.χ[i])
            if coordinate_motion.cycle is not None:
                total = total + 4 * unit * 2 * np.pi * np.abs(
                    phases.whole[i] * float(coordinate_motion.cycle.growth(j))
                )
    return total


def velocity_errors(
    motion: SeparatedMotion,
    q: Mapping[str, Numbers],
    p: Mapping[str, Numbers],
    dq: Mapping[str, Numbers],
    dp: Mapping[str, Numbers],
    unit: float,
) -> dict[str, Reals]:
    """Return bounds on the errors of the velocities, from those of places and momenta and their own rounding.

    Args:
        dq, dp: coordinate → absolute bounds on their errors, shape (m,).

    Returns:
        Coordinate → absolute bounds, shape (m,).
    """
    system = motion.solution.system
    formulas = velocities(system)
    variables = [(c.symbol, dq[c.name]) for c in system.coordinates] + [
        (c.momentum, dp[c.name]) for c in system.coordinates
    ]
    gradients = tuple(sp.diff(f, s) for f in formulas.values() for s, _ in variables)
    slopes = evaluate_along(motion, gradients, q, p)
    values = evaluate_along(motion, tuple(formulas.values()), q, p)
    own = rounding(motion, tuple(formulas.values()), q, p)
    result = {}
    for row, name in enumerate(formulas):
        parts = slopes[row * len(variables) : (row + 1) * len(variables)]
        result[name] = sum(np.abs(np.asarray(s, dtype=float)) * e for s, (_, e) in zip(parts, variables, strict=True))
        size = np.abs(np.asarray(values[row], dtype=float))
        with np.errstate(over="ignore"):  # next to a pole of the velocities
            result[name] = result[name] + 2 * unit * np.maximum(4 * size, own[row] / EPS)
    return result
