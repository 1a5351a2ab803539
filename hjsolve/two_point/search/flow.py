"""Hamilton's equations in a time of their own, in which close encounters are regular: where the search looks.

    Γ(Q, P; E) = g (H − E),   Q' = ∂Γ/∂P,  P' = −∂Γ/∂Q,  t' = g,   Γ = 0,

g the least common multiple of the denominators of T in the coordinates that separate (Poincaré's transformation of the
time; H. Poincaré, Les méthodes nouvelles III; Siegel & Moser, Lectures on Celestial Mechanics, §7). In those of a web
of two centres or of Stark's problem Γ has no denominator left, as Thiele and Levi-Civita found: a motion that comes as
near to a centre as it likes is as smooth as any, and so is where it ends as a function of p0.

With the motion run its variations by p0, E's among them. At one time, z = (Q, P),

    (B, D) = ∂z/∂p0 = δz − z' δt/g,   (B, D)' = ∂z'/∂z (B, D) + ∂z'/∂E δE − z' (∂g/∂Q B)/g,

and q is a function of Q alone. The argument of det U of ``conjugate_points.py`` is one more variable of the flow.

What leaves two_point is not taken from here: it is run by quadratures to its end (``searched.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
import sympy as sp

from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.coordinates.chart import Chart
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.motion.charted.initial_map import carried
from hjsolve.motion.initial_data import to_bits
from hjsolve.scenes.extrapolated_flow import extrapolated
from hjsolve.solution.quadratures import Solution
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.search.conjugate_points import ConjugatePoints

_MOST_STEPS = 4000
_SHORTEST = 1e-15
"""Step of t, in units of T, below which a motion is given up: it meets a singularity."""
_SAFETY_OF_A_STEP, _SHRINK, _GROW = 0.8, 0.1, 4.0
_ARGUMENT = 1e-5
"""Error of the argument of det U in one step, in radians."""
_ENERGY = sp.Dummy("E")
_ARRIVED = 1e-9
"""How far from T the time may be at the end, in units of T: from there on along the tangent, the square is rounding."""


@dataclass(frozen=True)
class Ends:
    """Where starts are at the time T, arrays over m starts.

    Attributes:
        q: in the user's coordinates, shape (n, m).
        position_by_momentum, momentum_by_momentum: ∂q/∂p0 and ∂p/∂p0 at this time, shape (m, n, n).
        reversals: how often each velocity changed its sign, shape (n, m).
        index: number of conjugate points passed, −1 where doubles do not decide it or it was not asked; shape (m,).
        reached: whether the time was reached.
    """

    q: Reals
    position_by_momentum: Reals
    momentum_by_momentum: Reals
    reversals: Integers
    index: Integers
    reached: Mask

    def column(self, i: int) -> Ends:
        """Return one start alone.

        Args:
            i: which.
        """
        one = slice(i, i + 1)
        return Ends(
            self.q[:, one], self.position_by_momentum[one], self.momentum_by_momentum[one],
            self.reversals[:, one], self.index[one], self.reached[one],
        )  # fmt: skip


@dataclass(frozen=True)
class _Formulas:
    """Functions of (Q, P, E, parameters).

    Attributes:
        rates: Q', P', t', then the derivatives of these by Q, P and E that are not zero.
        entries: rows and columns of the derivatives.
        place: q, then ∂q/∂Q by rows, then ∂²q/∂Q² likewise; of (Q, parameters).
        own: of the user's coordinates and momenta: H, ∂H/∂p, −∂H/∂q, and ∂²H/∂p² by rows.
        parameters: symbols, in their order.
    """

    rates: Callable[..., list[Reals]]
    entries: tuple[Integers, Integers]
    place: Callable[..., list[Reals]]
    own: Callable[..., list[Reals]]
    parameters: tuple[sp.Symbol, ...]


@dataclass(frozen=True)
class _Orbits:
    """What does not change along m starts.

    Attributes:
        energy: E, shape (m,).
        slopes: ∂E/∂p0, shape (n, m).
    """

    energy: Reals
    slopes: Reals

    def take(self, index: Integers) -> _Orbits:
        """Return those of some starts."""
        return _Orbits(self.energy[index], self.slopes[:, index])


def _in_web(solution: Solution) -> Chart | None:
    """Return the chart of a solution whose momenta are those of a change of Cartesian coordinates; None for none."""
    chart = solution.chart
    if chart is None or chart.space is not chart.original or chart.gauge != 0 or chart.linear:
        return None
    straight = all(c.domain.kind == "line" for c in chart.original.coordinates)
    return chart if straight and len(chart.symbols) == len(chart.original.coordinates) else None


@lru_cache(maxsize=32)
def _common_denominator(system: System) -> sp.Expr:
    """Return that of T in the coordinates and momenta, up to its sign."""
    H, found = hamiltonian(system), sp.Integer(1)
    for c in system.coordinates:
        found = sp.lcm(found, sp.fraction(sp.together(sp.diff(H, c.momentum, 2)))[1])
    return found.as_independent(*(c.symbol for c in system.coordinates), as_Add=False)[1]


@lru_cache(maxsize=32)
def _formulas(system: System, g: sp.Expr, original: System, place: tuple[sp.Expr, ...]) -> _Formulas:
    H = hamiltonian(system)
    Q, P = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    z = [*Q, *P, _ENERGY]
    Γ = sp.Add(*(sp.cancel(g * term) for term in sp.Add.make_args(sp.expand(H)))) - g * _ENERGY
    rates = [*(sp.diff(Γ, p) for p in P), *(-sp.diff(Γ, q) for q in Q), g]
    matrix = [[sp.diff(rate, s) for s in z] for rate in rates]
    where = [(i, j) for i in range(len(rates)) for j in range(len(z)) if matrix[i][j] != 0]
    parameters = tuple(p.symbol for p in system.parameters)
    slopes = [sp.diff(x, q) for x in place for q in Q]
    bends = [sp.diff(x, q) for x in slopes for q in Q]
    q, p = ([getattr(c, what) for c in original.coordinates] for what in ("symbol", "momentum"))
    own = hamiltonian(original)
    velocity, force = [sp.diff(own, s) for s in p], [-sp.diff(own, s) for s in q]
    masses = [sp.diff(v, s) for v in velocity for s in p]
    return _Formulas(
        sp.lambdify([*z, *parameters], [*rates, *(matrix[i][j] for i, j in where)], modules="numpy", cse=True),
        (np.array([i for i, _ in where]), np.array([j for _, j in where])),
        sp.lambdify([*Q, *parameters], [*place, *slopes, *bends], modules="numpy", cse=True),
        sp.lambdify([*q, *p, *parameters], [own, *velocity, *force, *masses], modules="numpy", cse=True),
        parameters,
    )  # fmt: skip


class RegularFlow:
    """The flow of one system from one place, with numbers for its parameters.

    Attributes:
        n: number of coordinates.
        time: T.
    """

    def __init__(self, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]):
        solution, original = question.solution, question.system
        chart = _in_web(solution)
        start = [question.q0[c.name] for c in original.coordinates]
        system, place = original, tuple(c.symbol for c in original.coordinates)
        if chart is not None:
            resting = {c.name: 0 for c in original.coordinates}
            try:
                begin = carried(solution, chart, q=question.q0, velocity=None, p=resting, parameters=question.given)
            except InvalidInputError:  # q0 is a singular place of the web
                chart = None
            else:
                system = chart.system
                start = [begin.values[c.symbol] for c in system.coordinates]
                place = tuple(chart.transformation[c.name].subs(chart.lengths) for c in original.coordinates)
        g = _common_denominator(system)
        at = {c.symbol: x for c, x in zip(system.coordinates, start, strict=True)}
        self._formulas = _formulas(system, -g if to_bits(g.subs({**values, **at}))(64) < 0 else g, original, place)
        self.n, self.time = len(start), float(to_bits(question.time)(64))
        self._known = [float(to_bits(values[symbol])(64)) for symbol in self._formulas.parameters]
        self._domains = _domains_of(system, values)
        self._start = np.array([float(to_bits(x)(64)) for x in start])
        self.q0, self.q1 = (
            np.array([float(to_bits(q[c.name])(64)) for c in original.coordinates]) for q in (question.q0, question.q1)
        )
        self._turn = self._place(self._start[:, None])[1][0]

    def _place(self, Q: Reals) -> tuple[Reals, Reals, Reals]:
        """Return q, ∂q/∂Q and ∂²q/∂Q² of shapes (n, m), (m, n, n) and (m, n, n, n)."""
        n = self.n
        with np.errstate(all="ignore"):
            rows = np.stack([row + 0 * Q[0] for row in self._formulas.place(*Q, *self._known)])
        slopes, bends = rows[n : n + n * n].reshape(n, n, -1), rows[n + n * n :].reshape(n, n, n, -1)
        return rows[:n], slopes.transpose(2, 0, 1), bends.transpose(3, 0, 1, 2)

    def energy_and_rates(self, q: Reals, p: Reals) -> tuple[Reals, Reals, Reals]:
        """Return H, q̇ and ṗ of the user's coordinates; shapes (m,), (n, m) and (n, m).

        Args:
            q, p: shape (n, m).
        """
        with np.errstate(all="ignore"):
            rows = np.stack([row + 0 * p[0] for row in self._formulas.own(*q, *p, *self._known)])
        return rows[0], rows[1 : self.n + 1], rows[self.n + 1 : 2 * self.n + 1]

    def inverse_masses(self) -> Reals:
        """Return ∂²H/∂p² at q0, shape (n, n)."""
        rows = self._formulas.own(*self.q0, *np.zeros(self.n), *self._known)
        return np.array(rows[2 * self.n + 1 :], dtype=float).reshape(self.n, self.n)

    def run(
        self, p: Reals, *, tolerance: float, parts: tuple[int, ...], most: int = _MOST_STEPS, count: bool = False
    ) -> Ends:
        """Run starts for the time T.

        Args:
            p: momenta at q0 in the user's coordinates, shape (n, m).
            tolerance: relative error of a step.
            parts: of the extrapolation.
            most: steps.
            count: whether conjugate points are counted.

        Returns:
            Where they are; ``reached`` is False for those that left the domain or met a singularity.
        """
        n, m, T = self.n, p.shape[1], self.time
        state = self._begun(p)
        orbits, counter = _Orbits(*self.energy_and_rates(np.repeat(self.q0[:, None], m, axis=1), p)[:2]), None
        if count:
            counter = self._counter(state, orbits)
        size = np.stack([*self._sizes(state)[:2], np.full(m, T)])
        step = T / 16 / self._linearised(state, orbits)[0][2 * n]
        velocity, reversals = orbits.slopes.copy(), np.zeros((n, m), dtype=int)
        live, lost, there = np.arange(m), np.zeros(m, dtype=bool), np.zeros(m, dtype=bool)
        for _ in range(most):
            if not len(live):
                break
            some = orbits.take(live)
            h, rate = self._shortened(state[:, live], some, step[live])
            with np.errstate(all="ignore"):
                slopes = partial(self._slopes, orbits=some, counter=counter)
                new, error = extrapolated(slopes, state[:, live], h, parts)
                scale = np.maximum(size[:, live], self._sizes(new))
                ratio = np.max(error[: 2 * n + 1] / (tolerance * scale[[0] * n + [1] * n + [2]]), axis=0)
                ratio = np.maximum(ratio, error[-1] / _ARGUMENT)
            good = (ratio <= 1) & np.isfinite(ratio)
            step[live] = np.where(good & (np.abs(h) < step[live]), step[live], _grown(np.abs(h), ratio, parts))
            moved = live[good]
            state[:, moved], size[:, moved] = new[:, good], scale[:, good]
            here = self._velocity(new[:, good], some.take(np.flatnonzero(good)))
            reversals[:, moved] += here * velocity[:, moved] < 0
            velocity[:, moved] = here
            there[moved] = np.abs(state[2 * n, moved] - T) <= _ARRIVED * T
            lost[live] = ~(step[live] * rate >= _SHORTEST * T) | _outside(state[:n, live], self._domains)
            live = live[~lost[live] & ~there[live]]
        return self._arrived(state, orbits, reversals, there & ~lost, counter)

    def _counter(self, state: Reals, orbits: _Orbits) -> ConjugatePoints:
        """Return units in which B is about the identity after the time."""
        rates, matrix = self._linearised(state[:, :1], orbits.take(np.zeros(1, dtype=int)))
        masses = matrix[0, : self.n, self.n : 2 * self.n] / rates[-1]
        return ConjugatePoints(np.linalg.inv(np.linalg.cholesky(masses)) / np.sqrt(self.time))

    def _begun(self, p: Reals) -> Reals:
        """Q, P and t, their variations by p0, and the argument of det U, in rows; shape ((2n + 1)(n + 1) + 1, m)."""
        n, m = p.shape
        turn = self._turn.T
        variations = np.zeros((2 * n + 1, n, m))
        variations[n : 2 * n] = turn[:, :, None]
        Q = np.repeat(self._start[:, None], m, axis=1)
        return np.concatenate([Q, turn @ p, np.zeros((1, m)), variations.reshape(-1, m), np.zeros((1, m))])

    def _sizes(self, state: Reals) -> Reals:
        """Sizes of Q, of P and of t."""
        n = self.n
        return np.stack([np.abs(state[:n]).max(axis=0), np.abs(state[n : 2 * n]).max(axis=0), np.abs(state[2 * n])])

    def _linearised(self, state: Reals, orbits: _Orbits) -> tuple[Reals, Reals]:
        """(Q', P', t'), and its derivatives by Q, P and E; shapes (2n + 1, m) and (m, 2n + 1, 2n + 1)."""
        m, count = state.shape[1], 2 * self.n + 1
        with np.errstate(all="ignore"):
            rows = self._formulas.rates(*state[: count - 1], orbits.energy, *self._known)
        matrix = np.zeros((m, count, count))
        for i, j, row in zip(*self._formulas.entries, rows[count:], strict=True):
            matrix[:, i, j] = row
        return np.stack([row + 0 * state[0] for row in rows[:count]]), matrix

    def _slopes(self, state: Reals, orbits: _Orbits, counter: ConjugatePoints | None) -> Reals:
        """Return the rate of change of a state."""
        m, count = state.shape[1], 2 * self.n + 1
        rates, matrix = self._linearised(state, orbits)
        varied = self._varied(state)
        late, varied[:, -1] = varied[:, -1].copy(), orbits.slopes.T  # nothing depends on t: E takes its place
        change, turning = matrix @ varied, np.zeros((1, m))
        if counter is not None:
            along = (rates[:-1] / rates[-1]).T[:, :, None]
            frame = varied[:, :-1] - along * late[:, None, :]
            own = np.concatenate([frame, varied[:, -1:]], axis=1)
            turned = matrix[:, :-1] @ own - along * (matrix[:, -1:] @ own)
            turning[0] = counter.rate(frame, turned)
        return np.concatenate([rates, change.transpose(1, 2, 0).reshape((count * self.n, m)), turning])

    def _varied(self, state: Reals) -> Reals:
        """Return the variations of Q, P and t by p0, shape (m, 2n + 1, n)."""
        count = 2 * self.n + 1
        return state[count:-1].reshape(count, self.n, state.shape[1]).transpose(2, 0, 1).copy()

    def _velocity(self, state: Reals, orbits: _Orbits) -> Reals:
        """Return q̇, shape (n, m)."""
        rates = self._linearised(state, orbits)[0]
        with np.errstate(all="ignore"):
            return np.asarray(np.einsum("mij,jm->im", self._place(state[: self.n])[1], rates[: self.n] / rates[-1]))

    def _shortened(self, state: Reals, orbits: _Orbits, step: Reals) -> tuple[Reals, Reals]:
        """Return steps that end about at T where they would go beyond, h of δ = g h + g' h²/2; and g."""
        rates, matrix = self._linearised(state, orbits)
        g, bend = rates[-1], np.einsum("mi,im->m", matrix[:, -1, :-1], rates[:-1])
        left = self.time - state[2 * self.n]
        with np.errstate(all="ignore"):
            h = 2 * left / (g + np.sqrt(np.maximum(g * g + 2 * bend * left, 0.0)))
        return np.where(np.abs(h) < step, h, step), g

    def _arrived(
        self, state: Reals, orbits: _Orbits, reversals: Integers, reached: Mask, counter: ConjugatePoints | None
    ) -> Ends:
        n = self.n
        rates, varied = self._linearised(state, orbits)[0], self._varied(state)
        with np.errstate(all="ignore"):
            along = rates[:-1] / rates[-1]
            z = state[: 2 * n] + along * (self.time - state[2 * n])
            frame = varied[:, :-1] - along.T[:, :, None] * varied[:, -1:]
            q, slope, bend = self._place(z[:n])
            back = np.linalg.inv(np.where(np.isfinite(slope), slope, np.eye(n))).transpose(0, 2, 1)
            p = np.einsum("mij,jm->mi", back, z[n:])  # P = (∂q/∂Q)ᵀ p
            B = slope @ frame[:, :n]
            D = back @ (frame[:, n:] - np.einsum("mi,miab->mab", p, bend) @ frame[:, :n])
        fine = np.isfinite(q).all(axis=0) & np.isfinite(B).all(axis=(1, 2)) & np.isfinite(D).all(axis=(1, 2))
        index = np.full(state.shape[1], -1) if counter is None else counter.index(frame, state[-1])
        return Ends(q, B, D, reversals, index, reached & fine)


def _grown(h: Reals, ratio: Reals, parts: tuple[int, ...]) -> Reals:
    """Return the next steps.

    Args:
        h: the last ones.
        ratio: of their errors to what is allowed.
        parts: of the extrapolation.
    """
    with np.errstate(all="ignore"):
        factor = np.clip(_SAFETY_OF_A_STEP * ratio ** (-1 / (2 * len(parts) - 1)), _SHRINK, _GROW)
    factor = np.where(np.isfinite(factor), factor, _SHRINK)
    return h * np.where(ratio <= 1, np.maximum(factor, 0.5), np.minimum(factor, 0.5))


def _domains_of(system: System, values: Mapping[sp.Symbol, sp.Expr]) -> list[tuple[float, float]]:
    """Return the ends of all domains in doubles.

    Args:
        system: whose coordinates they are of.
        values: symbol → exact number, of the parameters.
    """
    found = []
    for c in system.coordinates:
        ends = [None if e is None else float(to_bits(e.subs(values))(64)) for e in (c.domain.lower, c.domain.upper)]
        found.append((-np.inf if ends[0] is None else ends[0], np.inf if ends[1] is None else ends[1]))
    return found


def _outside(q: Reals, domains: list[tuple[float, float]]) -> Mask:
    """Tell which of m places are outside their domains.

    Args:
        q: shape (n, m).
        domains: of each coordinate.
    """
    gone = np.zeros(q.shape[1], dtype=bool)
    for values, (low, high) in zip(q, domains, strict=True):
        gone |= (values <= low) | (values >= high)
    return gone
