"""Hamilton's equations with those of their variations by p0, many starts at once: where the search for motions looks.

    q̇ = ∂H/∂p,  ṗ = −∂H/∂q,  Ḃ = H_pq B + H_pp D,  Ḋ = −H_qq B − H_qp D,  B = ∂q/∂p0,  D = ∂p/∂p0

(Greenwood (4-16), (4-17)). Steps are extrapolated to order 12, each start with its own. What leaves two_point is not
taken from here: it is started as a motion by quadratures and run to its end (``asked/verified.py``).

The frame (B, D) is Lagrangian, so U = (D + iB)(D − iB)⁻¹ is unitary; its eigenvalues pass 1 where q is conjugate to q0,
all in one direction where T is positive definite. With φ_j their arguments in [0, 2π) and Φ that of det U, followed
continuously from 0, the number of conjugate points is (Φ − Σ φ_j)/2π, each counted with its multiplicity (Arnold,
Functional Analysis and its Applications 1 (1967) 1).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes.extrapolated_flow import PARTS, extrapolated

_SAFETY, _SHRINK, _GROW = 0.8, 0.1, 4.0
_MOST_STEPS = 4000
_FINE, _PARTS = 1e-10, (2, 4, 6, 8)
"""Relative error of a step and parts of its extrapolation where conjugate points are counted."""
_ARGUMENT, _WHOLE = 1e-5, 0.05
"""Error of the argument of det U in one step, in radians; and how far a count may be from a whole number."""


@dataclass(frozen=True)
class _Formulas:
    """Functions of (q, p, parameters) that a flow needs.

    Attributes:
        first: ∂H/∂z.
        second: ∂H/∂z and the entries of the matrix of the variational equations that are not zero.
        entries: rows and columns of these.
        parameters: symbols, in their order.
    """

    first: Callable[..., list[Reals]]
    second: Callable[..., list[Reals]]
    entries: tuple[Integers, Integers]
    parameters: tuple[sp.Symbol, ...]


@lru_cache(maxsize=32)
def _formulas(system: System) -> _Formulas:
    H = hamiltonian(system)
    n = len(system.coordinates)
    z = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    first = [sp.diff(H, s) for s in z]
    rates = [*first[n:], *(-f for f in first[:n])]
    matrix = [[sp.diff(rate, s) for s in z] for rate in rates]
    places = [(i, j) for i in range(2 * n) for j in range(2 * n) if matrix[i][j] != 0]
    parameters = tuple(p.symbol for p in system.parameters)
    inputs = [*z, *parameters]
    entries = np.array([i for i, _ in places]), np.array([j for _, j in places])
    both = [*rates, *(matrix[i][j] for i, j in places)]
    return _Formulas(
        sp.lambdify(inputs, rates, modules="numpy", cse=True), sp.lambdify(inputs, both, modules="numpy", cse=True),
        entries, parameters,
    )  # fmt: skip


@dataclass(frozen=True)
class Ends:
    """Where starts come to, arrays over m starts.

    Attributes:
        q, p: shape (n, m).
        position_by_momentum, momentum_by_momentum: B and D, shape (m, n, n).
        reversals: how often each velocity changed its sign, shape (n, m).
        index: number of conjugate points passed, where it was asked; shape (m,).
        reached: whether the end was reached.
    """

    q: Reals
    p: Reals
    position_by_momentum: Reals
    momentum_by_momentum: Reals
    reversals: Integers
    index: Integers
    reached: Mask

    def column(self, i: int) -> Ends:
        """Return one start alone."""
        one = slice(i, i + 1)
        return Ends(
            self.q[:, one], self.p[:, one], self.position_by_momentum[one], self.momentum_by_momentum[one],
            self.reversals[:, one], self.index[one], self.reached[one],
        )  # fmt: skip


class VariedFlow:
    """The flow of one system with numbers for its parameters.

    Attributes:
        n: number of coordinates.
    """

    def __init__(self, system: System, values: Mapping[sp.Symbol, sp.Expr]):
        self._formulas = _formulas(system)
        self.n = len(system.coordinates)
        self._known = [float(to_bits(values[symbol])(64)) for symbol in self._formulas.parameters]
        self._domains = [_ends(c.domain.lower, c.domain.upper, values) for c in system.coordinates]

    def rates(self, z: Reals) -> Reals:
        """Return (q̇, ṗ), shape (2n, m).

        Args:
            z: q and p, shape (2n, m).
        """
        with np.errstate(all="ignore"):
            rows = self._formulas.first(*z, *self._known)
        return np.stack([row + 0 * z[0] for row in rows])

    def _linearised(self, z: Reals) -> tuple[Reals, Reals]:
        """(q̇, ṗ), and the matrix of the variational equations; shapes (2n, m) and (m, 2n, 2n)."""
        size, m = 2 * self.n, z.shape[1]
        with np.errstate(all="ignore"):
            rows = self._formulas.second(*z, *self._known)
        matrix = np.zeros((m, size, size))
        for i, j, row in zip(*self._formulas.entries, rows[size:], strict=True):
            matrix[:, i, j] = row
        return np.stack([row + 0 * z[0] for row in rows[:size]]), matrix

    def slopes(self, state: Reals, counter: _Conjugates | None = None) -> Reals:
        """Return the rate of change of q, p, B and D, and of the argument of det U.

        Args:
            state: shape (2n + 2n² + 1, m).
            counter: how it turns; None where it is not followed.
        """
        n, m = self.n, state.shape[1]
        rates, matrix = self._linearised(state[: 2 * n])
        frame = state[2 * n : -1].reshape(2 * n, n, m).transpose(2, 0, 1)
        turning = np.zeros((1, m))
        with np.errstate(all="ignore"):
            change = matrix @ frame
            if counter is not None:
                turning[0] = counter.rate(
                    frame.reshape(m, 2, n, n).swapaxes(0, 1), change.reshape(m, 2, n, n).swapaxes(0, 1)
                )
        return np.concatenate([rates, change.transpose(1, 2, 0).reshape(2 * n * n, m), turning])

    def velocity(self, q: Reals, p: Reals) -> Reals:
        """Return q̇, shape (n, m).

        Args:
            q, p: shape (n, m).
        """
        return self.rates(np.concatenate([q, p]))[: self.n]

    def kinetic_form(self, q: Reals) -> Reals:
        """Return H_pp at p = 0, which is the inverse of the mass matrix; shape (n, n).

        Args:
            q: shape (n,).
        """
        return self._linearised(np.concatenate([q, 0 * q])[:, None])[1][0, : self.n, self.n :]

    def force(self, q: Reals) -> Reals:
        """Return −∂H/∂q at p = 0, shape (n,).

        Args:
            q: shape (n,).
        """
        return self.rates(np.concatenate([q, 0 * q])[:, None])[self.n :, 0]

    def _outside(self, q: Reals) -> Mask:
        gone = np.zeros(q.shape[1], dtype=bool)
        for values, (low, high) in zip(q, self._domains, strict=True):
            gone |= (values <= low) | (values >= high)
        return gone

    def run(
        self, q: Reals, p: Reals, time: float, *, tolerance: float = 1e-10, count: bool = False,
        parts: tuple[int, ...] = PARTS, most: int = _MOST_STEPS,
    ) -> Ends:  # fmt: skip
        """Run starts for a time.

        Args:
            q, p: shape (n, m).
            time: > 0.
            tolerance: relative error of a step.
            count: whether conjugate points are counted.
            parts: of the extrapolation.
            most: steps.

        Returns:
            Where they are; ``reached`` is False for those that left the domain or met a singularity.
        """
        n, m = q.shape
        identity = np.broadcast_to(np.eye(n)[:, :, None], (n, n, m))
        state = np.concatenate([q, p, np.zeros((n * n, m)), identity.reshape(n * n, m), np.zeros((1, m))])
        counter = None
        if count:
            scale = np.linalg.inv(np.linalg.cholesky(self.kinetic_form(q[:, 0]))) / np.sqrt(time)
            counter = _Conjugates(scale)
        now, step = np.zeros(m), np.full(m, time / 16)
        velocity, reversals = self.velocity(q, p), np.zeros((n, m), dtype=int)
        live, lost = np.arange(m), np.zeros(m, dtype=bool)
        for _ in range(most):
            if not len(live):
                break
            h = np.minimum(step[live], time - now[live])
            new, ratio = self._stepped(state[:, live], h, tolerance, counter, parts)
            good = (ratio <= 1) & np.isfinite(ratio)
            with np.errstate(all="ignore"):
                factor = np.clip(_SAFETY * ratio ** (-1 / (2 * len(parts) - 1)), _SHRINK, _GROW)
            factor = np.where(np.isfinite(factor), factor, _SHRINK)
            step[live] = h * np.where(good, np.maximum(factor, 0.5), np.minimum(factor, 0.5))
            moved = live[good]
            state[:, moved] = new[:, good]
            now[moved] += h[good]
            here = self.velocity(state[:n, moved], state[n : 2 * n, moved])
            reversals[:, moved] += here * velocity[:, moved] < 0
            velocity[:, moved] = here
            lost[live] = (step[live] < 1e-12 * time) | self._outside(state[:n, live])
            live = live[~lost[live] & (now[live] < time * (1 - 1e-14))]
        frame = state[2 * n : -1].reshape(2, n, n, m).transpose(0, 3, 1, 2)
        index = np.zeros(m, dtype=int) if counter is None else counter.index(frame, state[-1])
        reached = ~lost & (now >= time * (1 - 1e-14)) & np.all(np.isfinite(state), axis=0)
        return Ends(state[:n], state[n : 2 * n], frame[0], frame[1], reversals, index, reached)

    def _stepped(
        self, state: Reals, h: Reals, tolerance: float, counter: _Conjugates | None, parts: tuple[int, ...]
    ) -> tuple[Reals, Reals]:
        """Return a step of each start, and its error in units of what is allowed."""
        n = self.n
        with np.errstate(all="ignore"):
            new, error = extrapolated(lambda y: self.slopes(y, counter), state, h, parts)
            size = np.maximum(np.abs(state[: 2 * n]), np.abs(new[: 2 * n]))
            scale = np.repeat(np.stack([np.max(size[:n], axis=0), np.max(size[n:], axis=0)]), n, axis=0)
            ratio = np.max(error[: 2 * n] / (tolerance * scale + 1e-300), axis=0)
            return new, np.maximum(ratio, error[-1] / _ARGUMENT)


@dataclass(frozen=True)
class _Conjugates:
    """How det U turns.

    Attributes:
        scale: A of q = A⁻¹ x, units in which B is about the identity after the time: A M⁻¹ Aᵀ = 1/time.
    """

    scale: Reals

    def _scaled(self, frame: Reals) -> tuple[Reals, Reals]:
        """B and D in these units, of frames of shape (2, m, n, n)."""
        A, back = self.scale, np.linalg.inv(self.scale)
        return A @ frame[0] @ A.T, back.T @ frame[1] @ A.T

    def rate(self, frame: Reals, rates: Reals) -> Reals:
        """Return d(arg det U)/dt = 2 Im tr((D + iB)⁻¹ (Ḋ + iḂ)), shape (m,).

        Args:
            frame, rates: B and D, and how they change; shape (2, m, n, n).
        """
        (B, D), (B_rate, D_rate) = self._scaled(frame), self._scaled(rates)
        try:
            return 2 * np.trace(np.linalg.solve(D + 1j * B, D_rate + 1j * B_rate), axis1=1, axis2=2).imag
        except np.linalg.LinAlgError:
            return np.full(B.shape[0], np.nan)

    def index(self, frame: Reals, argument: Reals) -> Integers:
        """Return how many conjugate points are passed; −1 where doubles do not decide them.

        Args:
            frame: B and D at the end, shape (2, m, n, n).
            argument: of det U, from 0 at the start; shape (m,).
        """
        B, D = self._scaled(frame)
        with np.errstate(all="ignore"):
            phases = np.angle(np.linalg.eigvals((D + 1j * B) @ np.linalg.inv(D - 1j * B))) % (2 * np.pi)
        turns = (argument - np.sum(phases, axis=1)) / (2 * np.pi)
        return np.where(np.abs(turns - np.rint(turns)) < _WHOLE, np.rint(turns), -1).astype(int)


def followed(flow: VariedFlow, q: Reals, p: Reals, time: float) -> Ends:
    """Run motions exactly enough to count the places conjugate to the first along them, their ends not among them.

    Args:
        flow: of the system.
        q, p: where they start, shape (n, m).
        time: how long they run.

    Returns:
        The ends with their variations; ``index`` is −1 where doubles do not decide it.
    """
    return flow.run(q, p, time, tolerance=_FINE, count=True, parts=_PARTS)


def _ends(low: sp.Expr | None, high: sp.Expr | None, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[float, float]:
    """Return the ends of a domain in doubles."""
    ends = [None if e is None else float(to_bits(e.subs(values))(64)) for e in (low, high)]
    return (-np.inf if ends[0] is None else ends[0], np.inf if ends[1] is None else ends[1])
