"""A search for the motions that join two places, by Newton's method on the initial momenta from many starts.

With L Lᵀ = M⁻¹(q0) and u = Lᵀ (p − a), |u|² is twice the kinetic energy; misses are divided by L and the time. In these
units the derivative of the miss, L⁻¹ (∂q/∂p0) L⁻ᵀ/T, is the identity for free motion, whatever the coordinates. Steps
are as long as the miss allows: one that does not lessen it is halved. Where the derivative loses rank at a zero, the
zero is not a point: it is followed along the null directions, and if it goes on the places are joined by a continuum.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.errors import NotConvergedError
from hjsolve.scenes.extrapolated_flow import PARTS
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.search.flow import Ends, RegularFlow

_STARTS = {1: 60, 2: 800}
_MOST_STARTS = 1280
_NEWTON_STEPS, _LEAST_FACTOR, _LONGEST = 30, 1 / 128, 0.5
_FAST, _COARSE, _LONG_ENOUGH = (2, 4, 6), 1e-5, 250
"""Parts of the extrapolation, relative error of a step and most steps while zeros are looked for."""
_EXACT, _FINER = (2, 4, 6, 8), 1e-10
"""The same while they are refined."""
_LAST = 1e-14
"""Relative error of a step, of full order, in the last step of Newton's method."""
_FOUND, _SOLVED, _RANK, _SAME = 1e-3, 1e-7, 1e-5, 1e-3
"""Misses at which a zero is taken to be found and solved, the singular value that counts as zero, and how near two
zeros are one; in units of the speed looked for."""
_REFINED, _PATIENT = 5, 20
_FOLLOWED = 0.2


@dataclass(frozen=True)
class MomentumZero:
    """Initial momenta that lead to q1, in doubles.

    Attributes:
        p: shape (n,).
        free: dimension of the family it belongs to; 0 for a single motion.
        ends: where they lead, as the only one of its columns.
    """

    p: Reals
    free: int
    ends: Ends


@dataclass(frozen=True)
class SearchResult:
    """What a search found, and where it looked.

    Attributes:
        zeros: the momenta.
        starts: how many starts there were.
        energy: the largest kinetic energy of a start.
    """

    zeros: tuple[MomentumZero, ...]
    starts: int
    energy: float


class _Target:
    """The miss at q1 as a function of u, in units of velocity."""

    def __init__(self, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]):
        self.flow = flow = RegularFlow(question, values)
        self.n, self.time, self.q0, self.q1 = flow.n, flow.time, flow.q0, flow.q1
        self.angle = np.array([c.domain.kind == "angle" for c in question.system.coordinates])
        inverse = flow.inverse_masses()
        self.L = np.linalg.cholesky(inverse)
        self.back = np.linalg.inv(self.L)
        drift = flow.energy_and_rates(self.q0[:, None], np.zeros((self.n, 1)))[1][:, 0]
        self.centre = -np.linalg.solve(inverse, drift)

    def momenta(self, u: Reals) -> Reals:
        """Return p of u, shape (n, m) both.

        Args:
            u: Lᵀ (p − a).
        """
        return self.back.T @ u + self.centre[:, None]

    def wrapped(self, r: Reals) -> Reals:
        """Return misses with angles in (−π, π].

        Args:
            r: shape (n, m).
        """
        turned = r - 2 * np.pi * np.rint(r / (2 * np.pi))
        return np.where(self.angle[:, None], turned, r)

    def miss(self, u: Reals, *, exact: bool = False) -> tuple[Reals, Reals, Mask]:
        """Return the miss (n, m) and its derivative (m, n, n), and which starts came to the end.

        Args:
            u: shape (n, m).
            exact: whether zeros are refined.
        """
        if exact:
            ends = self.flow.run(self.momenta(u), tolerance=_FINER, parts=_EXACT)
        else:
            ends = self.flow.run(self.momenta(u), tolerance=_COARSE, parts=_FAST, most=_LONG_ENOUGH)
        return (*self._in_units(ends), ends.reached)

    def _in_units(self, ends: Ends) -> tuple[Reals, Reals]:
        y = self.back @ self.wrapped(ends.q - self.q1[:, None]) / self.time
        return y, self.back @ ends.position_by_momentum @ self.back.T / self.time

    def followed(self, u: Reals, alone: Mask) -> tuple[Reals, Ends]:
        """Take a last step with all digits of doubles, and count the conjugate points along the motions.

        Args:
            u: shape (n, m).
            alone: which are zeros that do not go on; the others stay where they are.

        Returns:
            Momenta, shape (n, m), and the ends.
        """
        ends = self.flow.run(self.momenta(u), tolerance=_LAST, parts=PARTS, count=True)
        y, slope = self._in_units(ends)
        moved = alone & ends.reached
        step = _solved(np.where(moved[:, None, None], slope, 0.0), np.where(moved, y, 0.0))
        return self.momenta(u - step), ends

    @property
    def scale(self) -> float:
        """A speed that motions of interest have: that of the straight path, and that which the forces give."""
        straight = self.back @ self.wrapped((self.q1 - self.q0)[:, None])[:, 0] / self.time
        return float(np.sqrt(np.sum(straight**2) + 2 * max(self._work(self.q0), self._work(self.q1))))

    def _work(self, q: Reals) -> float:
        """Σ |q ∂V/∂q|, what a force may do over a length of the size of q; half a turn for an angle."""
        length = np.where(self.angle, np.pi, np.abs(q) + np.abs(self.q1 - self.q0))
        force = self.flow.energy_and_rates(q[:, None], np.zeros((self.n, 1)))[2][:, 0]
        return float(np.sum(np.abs(force) * length))


def search(question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]) -> SearchResult:
    """Search for initial momenta that lead to q1 in the time.

    Args:
        question: what is asked.
        values: symbol → exact number, of the parameters.

    Raises:
        NotConvergedError: no start came to its end.
    """
    target = _Target(question, values)
    turn = 2 * np.pi * (max(question.turns) + 1) * target.angle
    round_ = float(np.linalg.norm(target.back @ turn)) / target.time if target.angle.any() else 0.0
    scale = target.scale
    largest = 2 * scale + (round_ if np.any(turn) else 0.0)
    count = _STARTS.get(target.n, _MOST_STARTS)
    u = _ball(target.n, count) * largest
    near = _newton(target, u, scale)
    return SearchResult(tuple(_refined(target, near, scale)), count, largest**2 / 2)


def _ball(n: int, count: int) -> Reals:
    """Return Starts that fill a ball evenly in their radius: directions of Gaussian numbers, radii equally spaced."""
    directions = np.random.default_rng(20250).normal(size=(n, count))
    return directions / np.linalg.norm(directions, axis=0) * (np.arange(count) + 0.5) / count


def _newton(target: _Target, u: Reals, scale: float) -> Reals:
    """Newton's method on every start, with halved steps; what is near a zero, shape (n, number of zeros)."""
    n, m = u.shape
    y, slope, reached = target.miss(u)
    if not reached.any():
        raise NotConvergedError("every motion from q0 meets a singularity before the given time; choose a shorter time")
    size = np.where(reached, np.linalg.norm(y, axis=0), np.inf)
    live, found = np.flatnonzero(reached), np.zeros((n, 0))
    factor = np.ones(m)
    for _ in range(_NEWTON_STEPS):
        done = live[size[live] <= _FOUND * scale]
        found = _different(np.concatenate([found, u[:, done]], axis=1), scale)
        live = live[(size[live] > _FOUND * scale) & (factor[live] >= _LEAST_FACTOR)]
        live = live[_apart(u[:, live], scale)]
        if not len(live):
            break
        step = -_solved(slope[live], y[:, live])
        length = np.linalg.norm(step, axis=0)
        cap = _LONGEST * (np.linalg.norm(u[:, live], axis=0) + scale)
        step = step * np.minimum(1, cap / np.maximum(length, 1e-300)) * factor[live]
        trial = u[:, live] + step
        y_new, slope_new, reached = target.miss(trial)
        size_new = np.where(reached, np.linalg.norm(y_new, axis=0), np.inf)
        better = size_new < size[live] * (1 - factor[live] / 8)
        taken = live[better]
        u[:, taken], y[:, taken], slope[taken] = trial[:, better], y_new[:, better], slope_new[better]
        size[taken] = size_new[better]
        factor[live] = np.where(better, np.minimum(1, 2 * factor[live]), factor[live] / 4)
    return found


def _solved(slope: Reals, y: Reals) -> Reals:
    """Return the least solution of slope · x = y for each start, shape (n, m); singular values below 1e-6 are zero."""
    left, s, right = np.linalg.svd(slope)
    with np.errstate(all="ignore"):
        inverse = np.where(s > 1e-6 * s[:, :1], 1 / s, 0.0)
    inner = inverse * np.einsum("mji,jm->mi", left, y)
    return np.einsum("mji,mj->im", right, inner)


def _apart(u: Reals, scale: float) -> Integers:
    """Positions of starts that are not all but the same."""
    cells = np.rint(u / (_SAME * scale)).astype(int)
    return np.sort(np.unique(cells, axis=1, return_index=True)[1])


def _different(u: Reals, scale: float) -> Reals:
    """Columns that are apart by more than what makes two zeros one."""
    kept: list[int] = []
    for k in range(u.shape[1]):
        if all(np.linalg.norm(u[:, k] - u[:, j]) > 2 * _SAME * scale for j in kept):
            kept.append(k)
    return u[:, kept]


def _refined(target: _Target, u: Reals, scale: float) -> list[MomentumZero]:
    """Zeros solved exactly, all at once, each once, with the dimensions of their families."""
    if not u.shape[1]:
        return []
    for _ in range(_REFINED):
        y, slope, reached = target.miss(u, exact=True)
        size = np.where(reached, np.linalg.norm(y, axis=0), np.inf)
        if np.all((size <= _SOLVED * scale) | ~reached):
            break
        u = u - np.where(reached, _solved(slope, np.where(reached, y, 0.0)), 0.0)
    u, slope = u[:, size <= 10 * _SOLVED * scale], slope[size <= 10 * _SOLVED * scale]
    order = np.arange(u.shape[1])
    kept: list[tuple[int, int]] = []
    for k in order:
        s = np.linalg.svd(slope[k])[1]
        null = int(np.sum(s < _RANK * max(1.0, float(s[0]))))
        if any(_one(u[:, k], u[:, j], free, scale) for j, free in kept):
            continue
        kept.append((int(k), _dimension(target, u[:, k], slope[k], null, scale) if null else 0))
    chosen = [k for k, _ in kept]
    p, ends = target.followed(u[:, chosen], np.array([free == 0 for _, free in kept], dtype=bool))
    return [MomentumZero(p[:, i], free, ends.column(i)) for i, (_, free) in enumerate(kept) if ends.reached[i]]


def _one(u: Reals, other: Reals, free: int, scale: float) -> bool:
    """Whether a zero is another one, or a member of its family: of the same energy, or of full dimension."""
    if np.linalg.norm(u - other) <= 1e-5 * scale:
        return True
    alike = abs(np.sum(other**2) - np.sum(u**2)) <= 1e-5 * (np.sum(u**2) + scale**2)
    return free == len(u) or (free > 0 and bool(alike))


def _dimension(target: _Target, u: Reals, slope: Reals, null: int, scale: float) -> int:
    """In how many of the null directions a zero goes on: it is displaced there, solved anew, and must not come back."""
    directions = np.linalg.svd(slope)[2][-null:]
    count = 0
    length = _FOLLOWED * (np.linalg.norm(u) + scale) / 2
    for direction in directions:
        moved: Reals = np.asarray(u + length * direction, dtype=float)
        for _ in range(8):
            y, J, reached = target.miss(moved[:, None], exact=True)
            if not reached[0]:
                break
            if np.linalg.norm(y) <= _SOLVED * scale:
                count += bool(np.linalg.norm(moved - u) > length / 2)
                break
            moved = np.asarray(moved - _solved(J, y)[:, 0], dtype=float)
    return count


def solved_from(
    question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr], p: Reals, image: float | None = None
) -> tuple[Reals, Ends]:
    """Solve for the momenta of one motion from momenta near them.

    Args:
        question: what is asked.
        values: symbol → exact number, of the parameters.
        p: shape (n,).
        image: for one angle, which image of q1 is meant.

    Returns:
        The momenta; and where they lead, with conjugate points counted.

    Raises:
        NotConvergedError: Newton's method does not lead to q1.
    """
    target = _Target(question, values)
    if image is not None:
        target.q1, target.angle = np.array([image]), np.array([False])
    u: Reals = np.asarray((target.L.T @ (p - target.centre))[:, None], dtype=float)
    scale = max(target.scale, float(np.linalg.norm(u)))
    y, slope, reached = target.miss(u, exact=True)
    size = float(np.linalg.norm(y))
    for _ in range(_PATIENT):
        if not reached[0] or size <= _SOLVED * 1e-2 * scale:
            break
        step, factor = _solved(slope, y), 1.0
        y_new, slope_new = y, slope
        while factor > _LEAST_FACTOR:
            y_new, slope_new, reached_new = target.miss(u - factor * step, exact=True)
            if reached_new[0] and np.linalg.norm(y_new) < size:
                break
            factor /= 2
        else:
            break
        u, y, slope, size = np.asarray(u - factor * step, dtype=float), y_new, slope_new, float(np.linalg.norm(y_new))
    if not size <= _SOLVED * scale:
        raise NotConvergedError("Newton's method on the initial momenta does not lead to q1")
    p, ends = target.followed(u, np.array([True]))
    return p[:, 0], ends
