"""Two coordinates that share their equations, some of them unbounded: a bracket within a bracket.

Two combinations of Jacobi's equations (Greenwood (5-70), (5-71)) are left for the two phases,

    Σⱼ uⱼ (Gⱼ(x) + Hⱼ(y)) = a,      Σⱼ vⱼ (Gⱼ(x) + Hⱼ(y)) = b,

and u can be chosen so that its kernel has one sign along y, and the other along x: for a positive definite T the
cofactors of the Stäckel matrix have the sign of its determinant (Greenwood (5-139)). So the first equation gives y as
an increasing function of x, and the second one then grows with x. Neither search can miss, however far away
the motion is, and no step in time is made. The coordinate searched in is the one that comes to its end first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.one_coordinate.coordinate_motion import CoordinateMotion, Weights
from hjsolve.time_law.one_phase import solve_alone

_BRACKET_STEPS, _NEWTON_STEPS = 120, 3
"""Steps of one search, of which every fourth halves where Newton's steps do not; steps of both equations at the end."""
_NEAR, _ROUNDING_ERROR = 1e-11, 1e-13  # where both equations take over; of a Fourier series, in its greatest value


@dataclass(frozen=True)
class CoupledPair:
    """Two courses and the two combinations of the equations that they share.

    Attributes:
        coordinate_motions: of the two coordinates.
        level: u, monotone in each of them.
        clock: v, any other combination; the energy's where it can be.
    """

    coordinate_motions: tuple[CoordinateMotion, CoordinateMotion]
    level: Weights
    clock: Weights


@dataclass(frozen=True)
class CoupledPhases:
    """Phases of both coordinates at some times.

    Attributes:
        χ: phases, shape (2, m).
        errors: bounds on their errors, shape (2, m).
        ended: True where the motion has ended before.
        short: True where panels do not reach far enough to say.
    """

    χ: Reals
    errors: Reals
    ended: Mask
    short: Mask


def choose_pair(
    coordinate_motions: tuple[CoordinateMotion, CoordinateMotion], used: Sequence[Weights], equations: int
) -> CoupledPair | None:
    """Choose the two combinations; None where no single equation is monotone in both coordinates.

    Args:
        coordinate_motions: of the two coordinates.
        used: combinations spent on other coordinates.
        equations: number of the equations.
    """
    rows = [_kernels(c, equations) for c in coordinate_motions]
    units = [tuple(float(j == k) for j in range(equations)) for k in range(equations)]
    # combinations without the time first: then the search for one phase does not depend on the clock
    for level in (*units[1:], units[0]):
        signs = [_sign(c, part, level) for c, part in zip(coordinate_motions, rows, strict=True)]
        # opposite signs: the level curve is increasing, and the second equation monotone along it
        if signs[0] * signs[1] != -1:
            continue
        # the clock must be independent of the combinations that are used up
        size = [abs(np.linalg.det(np.array([*used, level, clock]))) for clock in units]
        # the energy's equation where it can be: it is the one that holds the time
        clock = units[0] if size[0] > 1e-9 else units[int(np.argmax(size))]
        if max(size) > 1e-9:
            return CoupledPair(coordinate_motions, level, clock)
    return None


def _kernels(coordinate_motion: CoordinateMotion, n: int) -> Reals:
    """Rows of kernels at phases all along a course, shape (phases, n)."""
    χ = coordinate_motion.probes()
    return np.stack([np.broadcast_to(coordinate_motion.rate(j, χ), χ.shape) for j in range(n)], axis=1)


def _sign(coordinate_motion: CoordinateMotion, rows: Reals, level: Weights) -> int:
    """Return the sign of a combination of kernels all along a course, 0 where it has none.

    Beside a pole in a coordinate a kernel may be smaller than the rounding of its series: that counts as zero.
    """
    values = rows @ np.array(level)
    # a Fourier series is rounded like its greatest value; panels each have a size of their own
    error_bounds = _ROUNDING_ERROR * float(np.max(np.abs(rows) @ np.abs(level))) if coordinate_motion.one_scale else 0.0
    side = 1 if values[int(np.argmax(np.abs(values)))] > 0 else -1
    return side if np.all(side * values >= -error_bounds) and np.any(values) and (error_bounds or np.all(values)) else 0


def solve_pair(couple: CoupledPair, goals: Reals, noise: Reals, time: Reals) -> CoupledPhases:
    """Solve for both phases.

    Args:
        couple: from ``choose_pair``.
        goals: right sides of Jacobi's equations, shape (equations, m).
        noise: bounds on their errors, shape (equations, m).
        time: relative to t₀, shape (m,); only its sign is used.
    """
    goals = np.stack([np.array(w) @ goals for w in (couple.level, couple.clock)])
    noise = np.stack([np.abs(w) @ noise for w in (couple.level, couple.clock)])
    found = CoupledPhases(np.empty((2, len(time))), np.empty((2, len(time))), time != time, time != time)
    for side in (1, -1):
        chosen = np.where(side * time >= 0)[0] if side > 0 else np.where(time < 0)[0]
        if len(chosen):
            part = _one_direction(couple, side, goals[:, chosen], noise[:, chosen])
            for ours, theirs in zip((found.χ, found.errors), (part.χ, part.errors), strict=True):
                ours[:, chosen] = theirs
            found.ended[chosen], found.short[chosen] = part.ended, part.short
    return found


def _one_direction(pair: CoupledPair, side: int, goals: Reals, error_bounds: Reals) -> CoupledPhases:
    """Return times on one side of t₀."""
    # the coordinate whose side of the level equation is used up first ends the motion: it is the one searched in
    gains = [_gain(c, pair.level, side) for c in pair.coordinate_motions]
    k = int(gains[1] < gains[0])
    outer, inner = pair.coordinate_motions[k], pair.coordinate_motions[1 - k]
    search = _Search(pair, outer, inner, goals)
    places = outer.stations(side)
    # where the equation is still early at the last station the goal lies beyond what panels reach
    last = search.late(np.broadcast_to(places[-1:], goals.shape[1:]))
    passed = side * last < 0
    x = search.between(places, side)
    χ = np.empty_like(goals)
    # the inner phase from the outer one, and then both at once: next to an end one of the two is ill conditioned
    χ[k], χ[1 - k] = x, search.other(x)[0]
    χ = _polished(pair, goals, χ)
    finished = outer.finished(side)
    errors = np.where(passed, 0.0, _bound(pair, goals, error_bounds, χ))
    return CoupledPhases(χ, errors, passed & finished, passed & (not finished))


def _gain(coordinate_motion: CoordinateMotion, level: Weights, side: int) -> float:
    """Return how much the first equation can still grow along a course; infinite where it goes on for ever."""
    limit = coordinate_motion.limits()[side > 0]
    if not np.isfinite(limit):
        return np.inf
    return abs(
        float(
            _amount(coordinate_motion, level, np.array([float(limit)]))[0]
            - _amount(coordinate_motion, level, _start(coordinate_motion))[0]
        )
    )


def _start(coordinate_motion: CoordinateMotion) -> Reals:
    return np.array([float(coordinate_motion.start)])


def _amount(coordinate_motion: CoordinateMotion, weights: Weights, χ: Reals) -> Reals:
    return cast("Reals", sum(w * coordinate_motion.integral(j, χ) for j, w in enumerate(weights) if w))


def _weighted_rate(coordinate_motion: CoordinateMotion, weights: Weights, χ: Reals) -> Reals:
    return cast("Reals", sum(w * coordinate_motion.rate(j, χ) for j, w in enumerate(weights) if w))


@dataclass(frozen=True)
class _Search:
    """The search in one phase, the other one being a function of it."""

    pair: CoupledPair
    outer: CoordinateMotion
    inner: CoordinateMotion
    goals: Reals

    def other(self, x: Reals) -> tuple[Reals, Mask]:
        """Return the other phase, and where the other coordinate would have ended."""
        never = (np.zeros_like(x), np.zeros_like(x))
        level = self.pair.level
        y, whole, _, ended = solve_alone(
            self.inner, level, self.goals[0] - _amount(self.outer, level, x), 0 * x, 0.0, never
        )
        return y + 2 * np.pi * whole, ended

    def late(self, x: Reals) -> Reals:
        """Left side less right side of the second equation, made to grow with x."""
        return self._equation(x)[0]

    def _equation(self, x: Reals) -> tuple[Reals, Reals]:
        y, ended = self.other(x)
        clock = self.pair.clock
        off = _amount(self.outer, clock, x) + _amount(self.inner, clock, y) - self.goals[1]
        # where the inner coordinate has ended there is no level curve: that place is taken to be too late, so that the
        # search turns back
        outward = np.where(x >= float(self.outer.start), np.inf, -np.inf)
        return np.where(ended, outward, self._sign * off), self._sign * self._slope(x, y)

    def _slope(self, x: Reals, y: Reals) -> Reals:
        """Growth of the left side of the second equation along the first one's curve."""
        level, clock = self.pair.level, self.pair.clock
        with np.errstate(all="ignore"):
            # dy/dx along the level curve, by the implicit function theorem
            ratio = -_weighted_rate(self.outer, level, x) / _weighted_rate(self.inner, level, y)
        return _weighted_rate(self.outer, clock, x) + _weighted_rate(self.inner, clock, y) * ratio

    @cached_property
    def _sign(self) -> float:
        return -1.0 if self._slope(_start(self.outer), _start(self.inner))[0] < 0 else 1.0

    def between(self, stations: Reals, side: int) -> Reals:
        """Return the phase: first between which stations, then by Newton's method in that bracket."""
        shape = self.goals.shape[1:]
        # bisection over the stations, for all times at once
        first, last = np.zeros(shape, dtype=int), np.full(shape, len(stations) - 1)
        while np.any(last - first > 1):
            # stations are few, and each look costs one inner search for all times
            middle = (first + last) // 2
            beyond = side * self.late(stations[middle]) > 0
            first, last = np.where(beyond, first, middle), np.where(beyond, middle, last)
        ends = stations[first], stations[last]
        low, high = np.minimum(*ends), np.maximum(*ends)
        # Newton's method in the bracket; every fourth step halves it where Newton's steps do not: an equation whose
        # slope is itself from a search is too rough for ``bracketed_roots``, which goes to the last bits
        x, width = (low + high) / 2, high - low
        for count in range(_BRACKET_STEPS):
            off, slope = self._equation(x)
            low, high = np.where(off <= 0, x, low), np.where(off >= 0, x, high)
            with np.errstate(all="ignore"):
                new = x - off / slope
            # four steps that shrink the bracket by less than 4: halving is better (the safeguard of Brent's method)
            slow = (count % 4 == 3) & (high - low > width / 4)  # Newton's steps are worth less than halving
            new = np.where((new >= low) & (new <= high) & ~slow, new, (low + high) / 2)
            width = np.where(count % 4 == 3, high - low, width)
            moved, x = np.abs(new - x), new
            if np.all(moved <= _NEAR * np.abs(x)) or np.all(high - low <= 4 * EPS * np.abs(x)):
                break
        return x


def _polished(pair: CoupledPair, goals: Reals, χ: Reals) -> Reals:
    """Newton's method for both, from nearby: what one search leaves of an ill conditioned phase the other takes up."""
    for _ in range(_NEWTON_STEPS):
        residual, ((a, b), (c, d)) = _residual(pair, goals, χ), _slopes(pair, χ)
        with np.errstate(all="ignore"):
            # Cramer's rule of two equations, rows (a, b) and (c, d)
            step = np.stack([b * residual[1] - d * residual[0], c * residual[0] - a * residual[1]]) / (a * d - b * c)
            # a correction, not a search: a long step says that the slopes are useless here
            small = np.all(np.abs(step) <= 1e-3 * np.abs(χ) + 1e-8, axis=0)
        trial = np.where(small, χ + step, χ)
        for row, coordinate_motion in enumerate(pair.coordinate_motions):
            trial[row] = np.clip(trial[row], *coordinate_motion.limits())
        χ = trial
    return χ


def _residual(pair: CoupledPair, goals: Reals, χ: Reals) -> Reals:
    sums = [
        sum(_amount(c, w, x) for c, x in zip(pair.coordinate_motions, χ, strict=True)) for w in (pair.level, pair.clock)
    ]
    return np.stack(sums) - goals


def _slopes(pair: CoupledPair, χ: Reals) -> Reals:
    """Rows: equations; columns: coordinates; shape (2, 2, m)."""
    return np.stack(
        [
            np.stack([_weighted_rate(c, w, x) + 0 * x for c, x in zip(pair.coordinate_motions, χ, strict=True)])
            for w in (pair.level, pair.clock)
        ]
    )


def _bound(pair: CoupledPair, goals: Reals, error_bounds: Reals, χ: Reals) -> Reals:
    """Bound the errors of the phases from the residuals and the rounding of the sums."""
    (a, b), (c, d) = _slopes(pair, χ)
    sizes = [
        sum(c.rounding_size(w, x) for c, x in zip(pair.coordinate_motions, χ, strict=True))
        for w in (pair.level, pair.clock)
    ]
    left = np.abs(_residual(pair, goals, χ)) + error_bounds + 4 * EPS * np.stack(sizes)
    with np.errstate(all="ignore"):
        # |J⁻¹| times residual, errors of the right sides and rounding of both sums
        inverse = np.abs(np.stack([np.stack([d, -b]), np.stack([-c, a])]) / (a * d - b * c))
    return np.sum(inverse * left[None, :], axis=1) + 2 * EPS * np.abs(χ)
