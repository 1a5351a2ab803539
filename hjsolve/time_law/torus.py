"""From time to phases: Jacobi's equations Σᵢ Gᵢⱼ(χᵢ) = Cⱼ + δⱼ₁ (t − t₀) solved for χ₁ … χₙ.

Where every coordinate is bounded the equations are multiplied by the inverse of the mean growths:
χₖ + Σᵢ Dₖᵢ(χᵢ) = θₖ⁰ + Ωₖ (t − t₀), with D periodic. The right sides are the angle variables; they are
reduced to one turn in double-double, so the millionth period is as accurate as the first.
Coordinates whose equation holds no unsolved other one are solved alone, by bracketed Newton steps;
the rest together. With unbounded coordinates the equations are solved as they stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from hjsolve.arithmetic.error_free import split
from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Context, Counts, Elementwise, Mask, Mpf, Reals
from hjsolve.arithmetic.root_finding import bracketed_roots
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate.coordinate_motion import AtRest, Periodic
from hjsolve.one_coordinate.fourier_series import FourierSeries, combine
from hjsolve.time_law.phase_reduction import turns_and_rest

_NEWTON_STEPS, _SHORTENINGS, _SETTLED = 40, 12, 1e-9
"""Steps of Newton's method, how often one is divided by four, and the step, radians, that is small."""
_STRIDE, _LONGEST_STRIDE, _SHORTEST_STRIDE = 0.25, 0.5, 1e-7
"""Radians of phase of the first step along a torus, and bounds on later ones: D is smooth on the scale of a radian."""


@dataclass(frozen=True)
class TorusEquations:
    """The equations of a motion all of whose coordinates are bounded.

    Attributes:
        coordinate_motions: one a coordinate.
        rates: Ωₖ in many digits.
        starts: θₖ⁰, the angle at t₀.
        growth: inverse of the matrix of mean growths, growth[k][j].
        oscillations: Dₖᵢ as series (their means are ignored).
        order: coordinates in the order in which they can be solved alone; the rest are coupled.
        coupled: coordinates to be solved together, last.
        roundings: how far rounded series leave the angles at t₀ open; 0 where the motion starts at turning points.
    """

    coordinate_motions: tuple[Periodic | AtRest, ...]
    rates: tuple[Mpf, ...]
    starts: tuple[Mpf, ...]
    growth: tuple[tuple[Mpf, ...], ...]
    oscillations: tuple[tuple[FourierSeries, ...], ...]
    order: tuple[int, ...]
    coupled: tuple[int, ...]
    roundings: tuple[float, ...]

    @property
    def torus(self) -> TorusEquations:
        """These equations."""
        return self

    @property
    def scheme(self) -> None:
        """None: nothing is left as it stands."""
        return None


def torus_equations(coordinate_motions: Sequence[Periodic | AtRest], bits: int) -> TorusEquations:
    """Set up the angle form of Jacobi's equations.

    Args:
        coordinate_motions: of the separated coordinates, in their order.

    Raises:
        NotConvergedError: the matrix of mean growths is singular, so the angles do not exist.
    """
    n = len(coordinate_motions)
    context = multiprecision(bits)
    # ∂Jᵢ/∂cⱼ, the mean growth of Gᵢⱼ with χᵢ; its inverse exists where the actions are independent
    means = context.matrix([[c.growth(j) for c in coordinate_motions] for j in range(n)])
    try:
        inverse = means**-1
    except ZeroDivisionError:
        raise NotConvergedError("the separated integrals are dependent: this motion has no angle variables") from None
    growth = tuple(tuple(inverse[k, j] for j in range(n)) for k in range(n))
    # Dₖᵢ = Σⱼ growthₖⱼ (Gᵢⱼ less its mean growth): a sum of series of the same phase is one series
    oscillations = tuple(tuple(combine(list(growth[k]), c.kernels[:n]) for c in coordinate_motions) for k in range(n))
    starts, roundings = [], []
    for k in range(n):
        total = context.mpf(0)
        for i, c in enumerate(coordinate_motions):
            # θₖ⁰ is the left side at t₀; at a turning point sin kχ = 0, so that it is exact there
            total += (c.start if i == k else 0) + _at(oscillations[k][i], c.start, context)
        starts.append(total)
        roundings.append(sum(_rounding(oscillations[k][i], c.start, context) for i, c in enumerate(coordinate_motions)))
    # a constant Dₖᵢ means that θₖ does not feel χᵢ: the matrix of equations is triangular as far as it goes
    order, coupled = _ordering([[i for i in range(n) if not oscillations[k][i].constant] for k in range(n)])
    # Ωₖ = ∂E/∂Jₖ, the row of the inverse that belongs to the energy
    rates = tuple(growth[k][0] for k in range(n))
    return TorusEquations(
        tuple(coordinate_motions), rates, tuple(starts), growth, oscillations, order, coupled, tuple(roundings)
    )


def mean_rate(system: TorusEquations, j: int) -> Mpf:
    """Return the mean growth of the coordinate that belongs to the j-th constant, an ignorable momentum.

    Args:
        system: the equations in angle form.
        j: position of the constant.
    """
    # an ignorable coordinate stands on the other side of its Jacobi equation, hence the sign
    return -cast(
        "Mpf",
        sum(
            rate * coordinate_motion.growth(j)
            for rate, coordinate_motion in zip(system.rates, system.coordinate_motions, strict=True)
        ),
    )


def oscillation(system: TorusEquations, i: int, j: int) -> FourierSeries:
    """Return what that coordinate adds to its mean growth, as a function of the phase of coordinate i.

    Args:
        system: the equations in angle form.
        i: position of the separated coordinate.
        j: position of the constant, an ignorable momentum.
    """
    coordinate_motion = system.coordinate_motions[i]
    own = combine([-1], [coordinate_motion.kernels[j]])
    return combine(
        [1, *(c.growth(j) for c in system.coordinate_motions)], [own, *(row[i] for row in system.oscillations)]
    )


def _at(series: FourierSeries, χ: Mpf | int, context: Context) -> Mpf | int:
    """Ripple at one many-digit phase; nothing at a turning point, exactly."""
    return 0 if series.constant else series.oscillation(context.mpf(χ))


def _rounding(series: FourierSeries, χ: Mpf | int, context: Context) -> float:
    """Return what rounded coefficients leave open of the ripple at one phase; nothing at a turning point."""
    return series.unresolved(context.mpf(χ))


def _ordering(needs: list[list[int]]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Split coordinates into those that can be solved one after the other and those that cannot."""
    order: list[int] = []
    left = set(range(len(needs)))
    while ready := [k for k in sorted(left) if set(needs[k]) & left <= {k}]:
        order.append(ready[0])
        left.discard(ready[0])
    return tuple(order), tuple(sorted(left))


def torus_phases(system: TorusEquations, time: tuple[Reals, Reals]) -> tuple[list[Reals], list[Counts], list[Reals]]:
    """Solve for the phases at times given as two doubles each, relative to t₀.

    Args:
        time: high and low parts, float arrays of shape (m,).

    Returns:
        For each coordinate: χ near [−π, π], the whole turns (integers), and a bound on the error of χ; shape (m,).
    """
    n = len(system.coordinate_motions)
    angles: list[Reals] = []
    whole: list[Counts] = []
    for k in range(n):
        turn = 2 * multiprecision(160).pi
        # Ω t/2π to 32 digits before turns are taken away: a double would lose a digit for every factor of ten of t
        count, rest = turns_and_rest(split(system.rates[k] / turn), time, split(system.starts[k] / turn))
        angles.append(2 * np.pi * rest)
        whole.append(count)
    χ: list[Any] = [None] * n
    errors: list[Any] = [None] * n
    for k in system.order:
        others, error_bound = _of_others(system, k, χ, errors)
        χ[k], errors[k] = _alone(system.oscillations[k][k], angles[k] - others, error_bound)
    if system.coupled:
        _together(system, angles, χ, errors)
    return χ, whole, errors


def _of_others(
    system: TorusEquations, k: int, χ: list[Reals | None], errors: list[Reals | None]
) -> tuple[Elementwise, Elementwise]:
    """Oscillations of θₖ next to the phases known by now, and what their errors and rounding do to that sum."""
    total, error_bound = 0.0, 0.0
    for i in system.order:
        periodic = system.oscillations[k][i]
        if i != k and χ[i] is not None and not periodic.constant:
            total = total + periodic.oscillation(χ[i])
            # an error δχᵢ of a phase that was found before moves this equation by |D′| δχᵢ
            slope = np.abs(periodic.value(χ[i]) - float(periodic.mean))
            error_bound = error_bound + slope * errors[i] + 2 * EPS * periodic.wave_size
    return total, error_bound


def _alone(periodic: FourierSeries, goal: Reals, error_bound: Reals) -> tuple[Reals, Reals]:
    """Solve χ + D(χ) = θ, monotone in χ; the start comes from a table of the inverse."""
    rounding = EPS * (np.abs(goal) + np.pi) + error_bound
    if periodic.constant:
        return goal, rounding
    # the goal is brought into the turn of the table, and bracketed between two of its places
    grid = np.linspace(-np.pi, np.pi, 1025)
    shift = 2 * np.pi * np.rint(goal / (2 * np.pi))
    goal = goal - shift
    table = grid + periodic.oscillation(grid)
    # χ + D(χ) at ±π is not ±π: the goal may belong to the turn before or after
    offset = np.where(goal > table[-1], 2 * np.pi, np.where(goal < table[0], -2 * np.pi, 0.0))
    # the table is increasing, since 1 + D′ = dθ/dχ > 0: one bracket, and it holds the only zero
    position = np.clip(np.searchsorted(table, goal - offset) - 1, 0, len(grid) - 2)
    low, high = grid[position] + offset, grid[position + 1] + offset
    # start by interpolation, then Newton's method that never leaves the bracket
    fraction = (goal - offset - table[position]) / np.maximum(table[position + 1] - table[position], 1e-300)
    χ = low + (high - low) * np.clip(fraction, 0, 1)
    χ, residual, slope = bracketed_roots(
        lambda x: (x + periodic.oscillation(x) - goal, 1 + periodic.value(x) - float(periodic.mean)), χ, low, high
    )
    # what bisection or Newton's method left open counts as an error of the right side
    rounding = rounding + 2 * EPS * (periodic.wave_size + np.pi) + np.abs(residual)
    # δχ = δθ/(dθ/dχ): the slope is small where little time passes along χ, as next to a pericentre
    return χ + shift, rounding / np.maximum(slope, EPS) + EPS * np.pi


def _together(system: TorusEquations, angles: list[Reals], χ: list[Reals | None], errors: list[Reals | None]) -> None:
    """Solve the coupled coordinates by Newton's method, following the torus from the start where it fails."""
    block = system.coupled
    others = [_of_others(system, k, χ, errors) for k in block]
    goal = np.stack([angles[k] - oscillations for k, (oscillations, _) in zip(block, others, strict=True)])
    # Newton's method from the angles themselves, which differ from the phases by the periodic parts only
    found = _newton(system, goal, goal.copy(), _NEWTON_STEPS)
    residual, inverse, unsolved = _reached(system, goal, found)
    # what has not settled is tried from better starts, dearer ones last
    bad = np.flatnonzero(unsolved)
    if len(bad):
        found[:, bad] = _newton(system, goal[:, bad], _one_by_one(system, goal[:, bad]), _NEWTON_STEPS)
        residual[:, bad], inverse[bad], unsolved = _reached(system, goal[:, bad], found[:, bad])
        bad = bad[unsolved]
    if len(bad):
        # the last resort: it cannot fail but by the size of its steps
        found[:, bad] = _follow(system, goal[:, bad])
        residual[:, bad], inverse[bad], _ = _reached(system, goal[:, bad], found[:, bad])
    # δχ ≤ |J⁻¹| δθ in the largest norm of the residuals
    rounding = np.max(np.abs(residual), axis=0) + _rounding_of_angles(system, goal)
    rounding = rounding + np.max(np.stack([0 * rounding + error_bound for _, error_bound in others]), axis=0)
    bound = np.sum(np.abs(inverse), axis=2) * rounding[:, None]
    for row, k in enumerate(block):
        χ[k], errors[k] = found[row], bound[:, row] + EPS * np.pi


def _reached(system: TorusEquations, goal: Reals, x: Reals) -> tuple[Reals, Reals, Mask]:
    """Return residuals, dχ/dθ, and the times at which Newton's next step is larger than rounding leaves it.

    The step, not the residual, says how far phases are from a solution: where a coordinate passes close by a centre
    dθ/dχ may be 10⁻¹⁰, and a residual of 10⁻⁹ leaves the phase open altogether.
    """
    residual, inverse = _residual(system, goal, x), _inverse(system, x)
    step = np.max(np.abs(_product(inverse, residual)), axis=0)
    return residual, inverse, ~(step < np.maximum(_SETTLED, _open_by_rounding(system, goal, inverse)))


def _rounding_of_angles(system: TorusEquations, goal: Reals) -> Reals:
    """Return what rounding leaves open of the equations."""
    size = sum(system.oscillations[k][i].size for k in system.coupled for i in system.coupled)
    return np.asarray(2 * EPS * (np.max(np.abs(goal), axis=0) + size + np.pi))


def _open_by_rounding(system: TorusEquations, goal: Reals, inverse: Reals) -> Reals:
    """Return what rounding of the equations leaves open of the phases."""
    return np.asarray(np.max(np.sum(np.abs(inverse), axis=2), axis=1) * _rounding_of_angles(system, goal))


def _one_by_one(system: TorusEquations, goal: Reals) -> Reals:
    """Solve for one phase after the other, twice: next to the energy of escape one of them hardly sees the others."""
    x, block = goal.copy(), system.coupled
    for row, k in (*enumerate(block), *enumerate(block)):
        terms = (system.oscillations[k][i].oscillation(x[c]) for c, i in enumerate(block) if c != row)
        x[row], _ = _alone(system.oscillations[k][k], goal[row] - sum(terms), np.zeros(goal.shape[1]))
    return x


def _residual(system: TorusEquations, goal: Reals, x: Reals) -> Reals:
    block = system.coupled
    return np.stack(
        [
            x[row] - goal[row] + sum(system.oscillations[k][i].oscillation(x[c]) for c, i in enumerate(block))
            for row, k in enumerate(block)
        ]
    )


def _jacobian(system: TorusEquations, x: Reals) -> Reals:
    block = system.coupled
    return np.stack(
        [
            np.stack(
                [
                    (row == c) + system.oscillations[k][i].value(x[c]) - float(system.oscillations[k][i].mean)
                    for c, i in enumerate(block)
                ]
            )
            for row, k in enumerate(block)
        ]
    )


def _inverse(system: TorusEquations, x: Reals) -> Reals:
    """Return dχ/dθ at phases of shape (n, m), shape (m, n, n)."""
    slopes = _jacobian(system, x)
    if len(slopes) == 2:  # the usual case, three times as fast as one matrix after the other
        (a, b), (c, d) = slopes
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.array([[d, -b], [-c, a]]) / (a * d - b * c)
        return np.ascontiguousarray(found.transpose(2, 0, 1))
    return np.asarray(np.linalg.inv(slopes.transpose(2, 0, 1)))


def _product(inverse: Reals, vectors: Reals) -> Reals:
    """Return matrices of shape (m, n, n) times vectors of shape (n, m)."""
    return np.asarray(np.einsum("mij,jm->im", inverse, vectors))


def _newton(system: TorusEquations, goal: Reals, x: Reals, steps: int) -> Reals:
    """Damped Newton's method, of each time by itself.

    A step is shortened until the next one, with the same slopes, is not longer. That does not depend on how unequal
    the slopes are: the residual would, and next to a centre refuses good steps (natural monotonicity: P. Deuflhard,
    Newton Methods for Nonlinear Problems, Springer 2004, chapter 3).
    """
    residual = _residual(system, goal, x)
    for _ in range(steps):
        inverse = _inverse(system, x)
        step = -_product(inverse, residual)
        size = np.max(np.abs(step), axis=0)
        # no step is longer than a radian: beyond it the linear model of D knows nothing
        step *= np.minimum(1.0, 1.0 / np.maximum(size, 1e-300))
        trial = x + step
        if np.all(size < 4 * EPS * np.pi):
            return trial
        new = _residual(system, goal, trial)
        for _ in range(_SHORTENINGS):
            worse = (np.max(np.abs(_product(inverse, new)), axis=0) > size) & (size > _SETTLED)
            if worse.any():  # smaller steps are not shortened: they are rounding, and grow and fall by chance
                worse &= size > _open_by_rounding(system, goal, inverse)
            if not worse.any():
                break
            step = np.where(worse, step / 4, step)
            trial = x + step
            new = _residual(system, goal, trial)
        x, residual = trial, new
    return x


def _follow(system: TorusEquations, goal: Reals) -> Reals:
    """Walk on the torus from the start to each goal: the map is one to one, so small steps cannot fail.

    Steps are as long in the phases, not in the angles: past a centre phases run by radians while angles stand still.

    Raises:
        NotConvergedError: the steps became too small.
    """
    begin = np.array([[float(system.coordinate_motions[k].start)] for k in system.coupled])
    # the straight line from θ at the start to the goal: every point of it is an angle of the torus
    origin = begin + sum_oscillations(system, begin)
    result = np.empty_like(goal)
    for m in range(goal.shape[1]):
        x, done, stride = begin.copy(), 0.0, _STRIDE
        way = goal[:, m : m + 1] - origin
        while done < 1:
            change = _product(_inverse(system, x), way)
            step = min(1 - done, stride / max(float(np.max(np.abs(change))), 1e-300))
            target = origin + (done + step) * way
            trial = _newton(system, target, x + step * change, 12)
            # as a step control: double where it went well, a quarter where it did not
            if not _reached(system, target, trial)[2][0] and np.max(np.abs(trial - x)) < 2 * _LONGEST_STRIDE:
                x, done, stride = trial, 1.0 if step == 1 - done else done + step, min(2 * stride, _LONGEST_STRIDE)
            elif stride < _SHORTEST_STRIDE:
                raise NotConvergedError("the phases of coupled coordinates could not be followed from the start")
            else:
                stride /= 4
        result[:, m] = x[:, 0]
    return result


def sum_oscillations(system: TorusEquations, x: Reals) -> Reals:
    """Return Σᵢ Dₖᵢ(χᵢ) over the coupled block; shapes (coordinates, m).

    Args:
        system: the equations in angle form.
        x: phases χ, shape (coordinates, m).
    """
    block = system.coupled
    return np.stack([sum(system.oscillations[k][i].oscillation(x[c]) for c, i in enumerate(block)) for k in block])
