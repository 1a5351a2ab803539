"""The family of one place: all motions that leave it with the same energy, in every direction.

Along each of them W is the action from the place; the points with the same W make a wavefront. Neighbouring orbits
meet where the determinant of velocity and ∂q/∂ψ vanishes (ψ the direction): the conjugate points, whose locus is the
envelope. ∂q/∂ψ is a difference over the directions, of eighth order; the error counts how far the sixth differs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import sympy as sp
from numpy.polynomial.chebyshev import chebval

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.root_finding import bisected
from hjsolve.display.shown import Shown
from hjsolve.errors import HJSolveError, InvalidInputError, required
from hjsolve.mechanics.system import mass_matrix
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import Errors, KnownErrors, Placing
from hjsolve.motion.tabulated import needs_table
from hjsolve.precision import mp
from hjsolve.rays.family_curve import FamilyCurve
from hjsolve.rays.same_constants import started_with_same_constants

_FEWEST = 16
_TIMES, _ORBIT_POINTS = 129, 161
_DOUBLINGS, _STEPS_TO_A_VALUE, _REFINEMENTS = 30, 12, 4
_HALVINGS_OF_A_BRACKET = 60  # to less than the spacing of doubles in [−1, 1]
_CHEBYSHEV = np.cos(np.pi * (np.arange(8) + 0.5) / 8)
_TO_TERMS = np.cos(np.outer(np.arccos(_CHEBYSHEV), np.arange(8))) * np.array([1, 2, 2, 2, 2, 2, 2, 2]) / 8
_BESIDE = np.array([1 - 1e-4, 1.0, 1 + 1e-4])
_EIGHTH = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
_FOURTH = np.array([2 / 3, -1 / 12, 0.0, 0.0])
_SIXTH = np.array([3 / 4, -3 / 20, 1 / 60, 0.0])
_SIDE = 4
_SLOWEST = 0.25
"""Where an order more does not make a difference that much smaller, the directions are too far apart to be believed."""
_NOTHING = 1e-15
"""A component of a momentum that is rounding, as a part of the other: straight at a centre, not just next to it."""
_UNCLEAR = 1e-4
"""Error of a point of the envelope, as a fraction of its path, beyond which it is left out."""


@dataclass(frozen=True)
class _States:
    """States of all rays: q, velocity, p and errors, each coordinate an array of shape (rays, times)."""

    q: tuple[Reals, Reals]
    velocity: tuple[Reals, Reals]
    p: tuple[Reals, Reals]
    q_error: tuple[Reals, Reals]
    p_error: tuple[Reals, Reals]

    def columns(self, begin: int, end: int) -> _States:
        """Return the same at some of the times."""
        groups = (self.q, self.velocity, self.p, self.q_error, self.p_error)
        return _States(*((a[:, begin:end], b[:, begin:end]) for a, b in groups))


@dataclass(frozen=True, eq=False, repr=False)
class SamePlace(Shown):
    """What the curves of a family of motions from one place are made from.

    Attributes:
        names: of the two coordinates.
        rays: one motion a direction, at equal angles in the metric of T; None where it did not converge.
        start, length: the time they leave at, and how long they are followed.
        placing: where coordinates are in space; None where unknown.
    """

    names: tuple[str, str]
    rays: tuple[Motion | None, ...] = field(repr=False)
    start: float
    length: float
    placing: Placing | None

    def levels(self, count: int) -> Reals:
        """Choose values of W at equal steps along the motion."""
        own = required(self.rays[0])
        whole = float(np.asarray(own.characteristic_function([self.start + self.length]).value, float)[0])
        return whole * (np.arange(count) + 1) / count

    # -------------------------------------------------------------------------------------------- wavefronts
    def fronts(self, values: Reals) -> tuple[FamilyCurve, ...]:
        """Return the lines on which W has some values."""
        found = [self._times_of(ray, values) for ray in self.rays]
        times, uncertainties = (np.array(x) for x in zip(*found, strict=True))
        states, forces = self._states_and_forces(times, uncertainties)
        curves = []
        for i, value in enumerate(values):
            q, p, q_error, p_error = {}, {}, {}, {}
            for k, name in enumerate(self.names):
                q[name], p[name] = (_closed(x[k][:, i]) for x in (states.q, states.p))
                q_error[name] = _closed((states.q_error[k] + np.abs(states.velocity[k]) * uncertainties)[:, i])
                p_error[name] = _closed((states.p_error[k] + forces[k])[:, i])
            curves.append(
                FamilyCurve("front", float(value), q, p, KnownErrors(Errors(q_error, p_error, {})), self.placing)
            )
        return tuple(curves)

    def _states_and_forces(self, times: Reals, uncertainties: Reals) -> tuple[_States, tuple[Reals, Reals]]:
        """Return states at times, and how far p moves while the time does, from neighbouring states."""
        m = times.shape[1]
        far = np.where(np.isfinite(uncertainties), uncertainties, 0.0)
        asked = self._states(np.concatenate([times, times + far, times - far], axis=1))
        here, ahead, behind = (asked.columns(k * m, (k + 1) * m) for k in range(3))
        first, second = (
            np.where(
                np.isfinite(uncertainties),
                np.abs(ahead.p[k] - behind.p[k]) + ahead.p_error[k] + behind.p_error[k],
                np.nan,
            )
            for k in range(2)
        )
        return here, (first, second)

    def _times_of(self, ray: Motion | None, values: Reals) -> tuple[Reals, Reals]:
        """Return times at which a ray has gained W, and how far they may be off; NaN where it never does.

        W of a ray that passes close to a centre takes many digits and a second a value: its points are left out.
        """
        never = np.full(len(values), np.nan)
        if ray is None or needs_table(ray.separated):
            return never, never
        t, reach = self._first_guess(ray, values)
        known = np.isfinite(t)
        for left in reversed(range(_STEPS_TO_A_VALUE)):
            W, error = self._action(ray, t, reach)
            speed = self._growth(ray, np.where(known, t, 0.0))
            with np.errstate(all="ignore"):
                step = (W - values) / speed
                moving = np.abs(step) > 4 * EPS * (np.abs(t) + abs(self.start)) + error / np.abs(speed)
            if not left or not moving.any():
                break
            t = np.where(moving, t - np.clip(step, -reach / _TIMES, reach / _TIMES), t)
        with np.errstate(all="ignore"):
            uncertainty = 2 * (np.abs(W - values) + error + EPS * np.abs(values)) / speed + 2 * EPS * (
                abs(self.start) + np.abs(t)
            )
        return t, uncertainty

    def _growth(self, ray: Motion, t: Reals) -> Reals:
        """dW/dt = p·dq/dt, twice the kinetic energy."""
        state = ray.at(self.start + t)
        first, second = (np.asarray(state.p[n], float) * np.asarray(state.velocity[n], float) for n in self.names)
        return first + second

    def _first_guess(self, ray: Motion, values: Reals) -> tuple[Reals, float]:
        """Return times at which W has about some values, by the trapezoidal rule, and the size of the greatest; NaN.

        Never.
        """
        t, reach = np.full(len(values), np.nan), self.length
        for side in (-1, 1):
            wanted = values < 0 if side < 0 else values >= 0
            far = self.length
            for _ in range(_DOUBLINGS if wanted.any() else 0):
                grid = np.linspace(0.0, far, _TIMES)
                growth = self._growth(ray, side * grid)
                W = np.concatenate([[0.0], np.cumsum((growth[1:] + growth[:-1]) / 2) * grid[1]])
                t[wanted] = side * np.interp(np.abs(values[wanted]), W, grid, right=np.nan)
                if not np.isfinite(W[-1]) or W[-1] >= np.abs(values[wanted]).max():
                    break
                far *= 2
            reach = max(reach, far)
        return t, 1.1 * reach

    def _action(self, ray: Motion, t: Reals, reach: float) -> tuple[Reals, Reals]:
        """W at times within ±reach: asked together with the last of them, so that the integrals are made once."""
        known = np.isfinite(t)
        found = ray.characteristic_function(self.start + np.append(np.where(known, t, 0.0), (-reach, reach)))
        value, error = np.asarray(found.value, float)[:-2], np.asarray(found.error, float)[:-2]
        return np.where(known, value, np.nan), np.where(known, error, np.nan)

    # -------------------------------------------------------------------------------------------- states of all rays
    def _states(self, times: Reals) -> _States:
        """Return states at times since the start, shape (rays, times); NaN where a ray has none."""
        rows = [_ray_states(ray, self.names, self.start, t) for ray, t in zip(self.rays, times, strict=True)]
        table = np.array(rows)  # rays, quantities, coordinates, times
        groups = [(table[:, i, 0], table[:, i, 1]) for i in range(5)]
        return _States(*groups)

    def orbits(self, count: int) -> tuple[FamilyCurve, ...]:  # noqa: ARG002  (they were counted before)
        """Return the rays, followed for the time of the family; the first is the motion."""
        t = np.linspace(0.0, self.length, _ORBIT_POINTS)
        states = self._states(np.broadcast_to(t, (len(self.rays), len(t))))
        curves = []
        for k in range(len(self.rays)):
            q, p, q_error, p_error = (
                {n: group[i][k] for i, n in enumerate(self.names)}
                for group in (states.q, states.p, states.q_error, states.p_error)
            )
            curves.append(FamilyCurve("orbit", float(k), q, p, KnownErrors(Errors(q_error, p_error, {})), self.placing))
        return tuple(curves)

    # -------------------------------------------------------------------------------------------- the envelope
    def caustics(self) -> tuple[FamilyCurve, ...]:
        """Return the envelope: where each ray first meets its neighbours."""
        rays = len(self.rays)
        grid = np.broadcast_to(np.linspace(0.0, self.length, _TIMES)[1:], (rays, _TIMES - 1))
        D, _ = self._meeting(grid)
        change = (D[:, :-1] * D[:, 1:] < 0) & (np.cumsum(~np.isfinite(D), axis=1)[:, 1:] == 0)
        first = change.argmax(axis=1)
        row = np.arange(rays)
        met = change[row, first]
        t, uncertainty = self._roots(grid[row, first], grid[row, first + 1])
        t = np.where(met, t, np.nan)
        states, forces = self._states_and_forces(t[:, None], uncertainty[:, None])
        q, p, q_error, p_error = {}, {}, {}, {}
        unclear = ~np.isfinite(uncertainty) | (uncertainty > _UNCLEAR * self.length)
        for k, name in enumerate(self.names):
            values = np.where(unclear, np.nan, states.q[k][:, 0])
            q[name], p[name] = _closed(values), _closed(states.p[k][:, 0])
            q_error[name] = _closed(2 * np.abs(states.velocity[k][:, 0]) * uncertainty + states.q_error[k][:, 0])
            p_error[name] = _closed(states.p_error[k][:, 0] + forces[k][:, 0])
        if np.isfinite(q[self.names[0]]).sum() < 2:
            return ()
        return (FamilyCurve("caustic", np.nan, q, p, KnownErrors(Errors(q_error, p_error, {})), self.placing),)

    def _roots(self, low: Reals, high: Reals) -> tuple[Reals, Reals]:
        """Zeros of the determinant between brackets, and how far they may be off.

        The zero of the polynomial through its values at Chebyshev's points, then Newton's steps with that slope: asking
        many times of a ray at once costs little more than asking one.
        """
        middle, half = (low + high) / 2, (high - low) / 2
        D, _ = self._meeting(middle[:, None] + half[:, None] * _CHEBYSHEV)
        with np.errstate(all="ignore"):
            terms = D @ _TO_TERMS
            rising, ends = chebval(1.0, terms.T) > 0, np.ones(len(low))
            begin, end = bisected(
                lambda u: (chebval(u, terms.T, tensor=False) > 0) != rising, -ends, ends, _HALVINGS_OF_A_BRACKET
            )
            t = middle + half * (begin + end) / 2
            for _ in range(_REFINEMENTS):
                D, rounding_errors = self._meeting(t[:, None] * _BESIDE)
                value, rounding_error, slope = (
                    D[:, 1],
                    rounding_errors[:, 1],
                    (D[:, 2] - D[:, 0]) / (t * (_BESIDE[2] - _BESIDE[0])),
                )
                step = value / slope
                if not ((np.abs(value) > rounding_error) & (np.abs(step) <= half)).any():
                    break
                t = np.where((np.abs(value) > rounding_error) & (np.abs(step) <= half), t - step, t)
            return t, 2 * (np.abs(value) + rounding_error) / np.abs(slope) + 4 * EPS * t

    def _meeting(self, t: Reals) -> tuple[Reals, Reals]:
        """Return determinant of velocity and ∂q/∂ψ at times of each ray, shape (rays, m), and a bound on its error."""
        rays, many = t.shape
        h = 2 * np.pi / rays
        shifts = list(range(-_SIDE, _SIDE + 1))
        asked = np.concatenate([np.roll(t, k, axis=0) for k in shifts], axis=1)  # a ray's own times and its neighbours'
        states = self._states(asked)

        def of_neighbour(values: Reals, k: int) -> Reals:
            """Return the values of the ray k further on at the times of each ray."""
            place = shifts.index(k) * many
            return np.roll(values[:, place : place + many], -k, axis=0)

        slopes, rounding_errors = [], []
        for c in range(2):
            q, noise = states.q[c], states.q_error[c] + 4 * EPS * np.abs(states.q[c])
            steps = [of_neighbour(q, k) - of_neighbour(q, -k) for k in range(1, _SIDE + 1)]
            uncertainties = [of_neighbour(noise, k) + of_neighbour(noise, -k) for k in range(1, _SIDE + 1)]
            fourth, sixth, eighth = (
                np.asarray(sum(w * s for w, s in zip(weights, steps, strict=True))) / h
                for weights in (_FOURTH, _SIXTH, _EIGHTH)
            )
            rounding = sum(abs(w) * d for w, d in zip(_EIGHTH, uncertainties, strict=True)) / h
            last, before = np.abs(eighth - sixth), np.abs(sixth - fourth)
            slopes.append(eighth)
            rounding_errors.append(np.where(last > _SLOWEST * before + rounding, np.inf, 2 * last + rounding))
        v = [of_neighbour(x, 0) for x in states.velocity]
        D = v[0] * slopes[1] - v[1] * slopes[0]
        rounding_error = np.abs(v[0]) * rounding_errors[1] + np.abs(v[1]) * rounding_errors[0]
        return D, rounding_error + 8 * EPS * (np.abs(v[0] * slopes[1]) + np.abs(v[1] * slopes[0]))


def _closed(values: Reals) -> Reals:
    """Return the same with the first value once more at the end."""
    return np.append(values, values[:1])


def _ray_states(ray: Motion | None, names: tuple[str, str], start: float, t: Reals) -> Reals:
    """q, velocity, p and the errors of q and p, shape (5, 2, m)."""
    found = np.full((5, 2, len(t)), np.nan)
    known = np.isfinite(t)
    if ray is None or not known.any():
        return found
    state = ray.at(start + t[known])
    error = state.error
    for k, name in enumerate(names):
        rows = (state.unwrapped(name), state.velocity[name], state.p[name], error.q[name], error.p[name])
        for i, values in enumerate(rows):
            found[i, k, known] = np.asarray(values, float)
    return found


# ------------------------------------------------------------------------------------------------ the rays
def started_at_one_place(motion: Motion, placing: Placing | None, directions: int) -> SamePlace:
    """Start motions from the place of a motion with its energy, in directions at equal angles.

    Args:
        motion: the first of them.
        placing: where coordinates are in space; None where unknown.

    Raises:
        InvalidInputError: not two coordinates, a motion that begins at rest, or too few directions.
    """
    solution, values = motion.solution, motion.initial.values
    system = solution.system
    if len(system.coordinates) != 2:
        raise InvalidInputError("wavefronts: the family of motions from one point needs a system of two coordinates")
    if directions < _FEWEST:
        raise InvalidInputError(f"wavefronts: at least {_FEWEST} orbits are needed to find an envelope")
    names = (system.coordinates[0].name, system.coordinates[1].name)
    M = np.array(mass_matrix(system).subs(values).evalf(30).tolist(), dtype=float)
    p0 = np.array([float(sp.N(values[c.momentum], 30)) for c in system.coordinates])
    if not p0.any():
        raise InvalidInputError("wavefronts: a motion that begins at rest is the only one of its energy there")
    root = np.linalg.cholesky(M)
    across = np.linalg.solve(root, p0)
    q = {c.name: values[c.symbol] for c in system.coordinates}
    parameters = {p.name: values[p.symbol] for p in system.parameters if p.symbol in values}
    rays: list[Motion | None] = [motion]
    for k in range(1, directions):
        ψ = 2 * mp.pi * k / directions
        c, s = float(mp.cos(ψ)), float(mp.sin(ψ))
        p = root @ np.array([c * across[0] - s * across[1], s * across[0] + c * across[1]])
        p[np.abs(p) < _NOTHING * np.abs(p).max()] = 0.0
        rays.append(_ray(motion, q, dict(zip(names, map(float, p))), parameters))
    start = float(motion.t0)
    return SamePlace(names, tuple(rays), start, _length(motion), placing)


def _ray(motion: Motion, q: dict[str, sp.Expr], p: dict[str, float], parameters: dict[str, sp.Expr]) -> Motion | None:
    try:
        found: Motion = motion.solution.motion(q=q, p=p, parameters=parameters, t0=motion.t0)
    except HJSolveError:
        return None
    return found


def _length(motion: Motion) -> float:
    """Return how long rays are followed: a cycle of the slowest coordinate, or the passage of the window."""
    periods = [float(e.value) for n, e in motion.periods.items() if n in motion.solution.coordinates]
    if motion.separated.torus is not None and periods:
        return max(periods)
    return float(started_with_same_constants(motion, None).times[-1]) - float(motion.t0)
