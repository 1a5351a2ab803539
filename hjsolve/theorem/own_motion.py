"""A complete integral of the user's own next to what hjsolve found: its constants, and its motion.

The constants c(q, p) of a separation are functions g(α) of the user's where c(q, ∂S/∂q) holds neither q nor t: that is
the map between the two. Along a motion, α follows from p = ∂S/∂q (5-50), and Jacobi's equations −β = ∂S/∂α (5-54) hold
where their derivative by the time vanishes, in which no integral is left:

    Σᵢ ∂²S/∂qᵢ∂αⱼ q̇ᵢ + ∂²S/∂t∂αⱼ = 0     (Greenwood (5-57) with q̇ = ∂H/∂p)
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import mpmath
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.shown import Shown, listed_names
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.precision import NAMES, mp
from hjsolve.separation import Undecided
from hjsolve.solution.quadratures import Solution
from hjsolve.theorem.answers import Flaw
from hjsolve.theorem.phase_space import PhaseSpace

DIGITS = 40
STARTS = 24
"""Random starts of Newton's method for the constants at one state."""
STATES = 24
"""Times at which a motion is looked at where none are given."""
FEWEST = 3
"""States on the branch of the formula that are worth a comparison."""
MOMENTUM = "p"
"""The key of the momenta among the deviations."""


@dataclass(frozen=True, repr=False)
class OwnMotion(Shown):
    """Jacobi's equations of a complete integral, along a motion that hjsolve computed by its own quadratures.

    Attributes:
        constants: name → the value of the user's constant α, with its error.
        times: where the momenta have the signs of the formula's; the others are on another branch and were left out.
        deviations: name → the largest size of Σ ∂²S/∂q∂α q̇ + ∂²S/∂t∂α, which (5-54) says is zero; and ``p``, the
            largest distance of ∂S/∂q from p, in units of its error.
        errors: name → what the errors of states and constants make of that at most; of ``p`` 1.
    """

    constants: Mapping[str, Estimate]
    times: tuple[float, ...]
    deviations: Mapping[str, float]
    errors: Mapping[str, float]

    @property
    def agrees(self) -> bool:
        """Whether every deviation is explained by the errors."""
        return all(deviation <= self.errors[name] for name, deviation in self.deviations.items())

    def __bool__(self) -> bool:
        """Return ``agrees``."""
        return self.agrees

    def __str__(self) -> str:
        """Return the statement in one sentence."""
        values = ", ".join(f"{name} = {value}" for name, value in self.constants.items())
        word = "agree" if self.agrees else "do not agree"
        return f"Jacobi's equations {word} with the motion at {len(self.times)} times, with {values}."


def constants_in(
    space: PhaseSpace, S: sp.Expr, alphas: Sequence[sp.Symbol], solution: Solution, budget: float
) -> dict[str, sp.Expr | Flaw | Undecided]:
    """Return the constants of a solution as functions of the user's.

    Args:
        S: the principal function, proved.
        alphas: its constants.
        solution: of the same system in the same coordinates.
        budget: seconds for each zero test.

    Returns:
        Constant of the solution → its expression in α; a flaw, with a witness, where it varies with q or t.

    Raises:
        InvalidInputError: a solution in other coordinates.
    """
    _refuse_other_coordinates(space, solution, "constants_in: the solution")
    slopes = {p: sp.diff(S, q) for q, p in space.pairs}
    found = dict[str, sp.Expr | Flaw | Undecided]()
    for constant in solution.constants.values():
        value = _renamed(constant.expression, space).xreplace(slopes)
        variables = [*(q for q, _ in space.pairs), space.time]
        for variable in variables:
            statement = f"{constant.name} is not a function of {listed_names([a.name for a in alphas])}"
            wrong = space.proved_zero(sp.diff(value, variable), "constants", statement, budget)
            if wrong is not None:
                found[constant.name] = wrong
                break
        else:
            found[constant.name] = _at_any_place(value, variables, space)
    return found


def _refuse_other_coordinates(space: PhaseSpace, solution: Solution, what: str) -> None:
    own, others = ([c.name for c in subject.coordinates] for subject in (space.subject, solution.system))
    if own != others:
        raise InvalidInputError(
            f"{what} is in {listed_names(others)}, the integral in {listed_names(own)}; solve in its coordinates"
        )


def _renamed(expression: sp.Expr, space: PhaseSpace) -> sp.Expr:
    """Return an expression of a solution in the symbols of the space."""
    return expression.xreplace({s: space.symbols[s.name] for s in expression.free_symbols if s.name in space.symbols})


def _at_any_place(value: sp.Expr, variables: Sequence[sp.Symbol], space: PhaseSpace) -> sp.Expr:
    """Return what is left of an expression that does not depend on the variables."""
    plain = sp.simplify(value)
    for k, variable in enumerate(variables):
        if plain.has(variable):
            low, high = space.bounds.get(variable, (None, None))
            inside = sp.Rational(k + 3, 7) if low is None else low + (1 if high is None else (high - low) / (k + 3))
            plain = sp.simplify(plain.subs(variable, inside))
    return plain


def along(
    space: PhaseSpace, S: sp.Expr, alphas: Sequence[sp.Symbol], motion: Motion, times: Sequence[float] | None
) -> OwnMotion | Undecided:
    """Compare Jacobi's equations with a motion.

    Args:
        S: the principal function, proved.
        alphas: its constants.
        motion: of the same system in the same coordinates.
        times: at which to look; by default over two of the longest periods, or over ten units of time.

    Raises:
        InvalidInputError: a motion in other coordinates.
    """
    _refuse_other_coordinates(space, motion.solution, "along: the motion")
    with mp.workdps(DIGITS):
        made = _Along(space, S, tuple(alphas), motion)
        states = [made.state(t) for t in (times if times is not None else made.times())]
        begun = next(((state, α) for state in states if (α := made.constants(state)) is not None), None)
        if begun is None:
            return _undecided(space, S, "no constants were found with p = dS/dq at the states; give other times")
        state, α = begun
        held = [state for state in states if made.is_on_branch(state, α)]
        if len(held) < FEWEST:
            return _undecided(space, S, "the momenta have other signs than dS/dq; give times at which they agree")
        spread = made.spread(state, α)
        values = {
            a.name: Estimate(float(v), float(e) + 1e-16 * abs(float(v)))
            for a, v, e in zip(alphas, α, spread, strict=True)
        }
        worst, errors = dict[str, float](), dict[str, float]()
        for k, a in enumerate(alphas):
            rows = [made.residual(k, state, α, spread) for state in held]
            worst[a.name], errors[a.name] = max(rows, key=lambda row: row[0] / row[1])
        worst[MOMENTUM], errors[MOMENTUM] = max(made.apart(state, α, spread) for state in held), 1.0
        return OwnMotion(values, tuple(float(state.t) for state in held), worst, errors)


def _undecided(space: PhaseSpace, S: sp.Expr, advice: str) -> Undecided:
    return Undecided(cast("System", space.subject), None, (), "motion", S, {}, None, advice, ())


@dataclass(frozen=True)
class _State:
    """Numbers at one time: t, then q, p and q̇ as (value, error), in the order of the pairs."""

    t: mpmath.mpf
    q: tuple[tuple[mpmath.mpf, mpmath.mpf], ...]
    p: tuple[tuple[mpmath.mpf, mpmath.mpf], ...]
    rates: tuple[tuple[mpmath.mpf, mpmath.mpf], ...]


class _Along:
    """The equations at numbers."""

    def __init__(self, space: PhaseSpace, S: sp.Expr, alphas: tuple[sp.Symbol, ...], motion: Motion):
        self.space, self.alphas, self.motion = space, alphas, motion
        self.names = [c.name for c in space.subject.coordinates]
        self._rows: dict[int, Callable[..., list[mpmath.mpf]]] = {}
        self.q = [q for q, _ in space.pairs]
        self.rates = [sp.Dummy(f"rate_{q}") for q in self.q]
        numbers = {s.name: value for s, value in motion.initial.values.items()}
        parameters = {p: numbers[p.name] for p in space.parameters if p.name in numbers}
        self.slopes = [sp.diff(S, q).subs(parameters) for q in self.q]
        self.equations = [
            sp.Add(*(sp.diff(P, a) * rate for P, rate in zip(self.slopes, self.rates, strict=True)))
            + sp.diff(S.subs(parameters), a, space.time)
            for a in alphas
        ]

    def times(self) -> list[float]:
        """Return times over two of the longest periods, or over ten units."""
        periods = [float(e.value) for e in self.motion.periods.values()]
        span = 2 * max(periods) if periods else 10.0
        return [span * (k + 0.37) / STATES for k in range(STATES)]

    def state(self, t: float) -> _State:
        """Numbers at a time."""
        state = self.motion.at(t)

        def pairs(
            values: Mapping[str, object], errors: Mapping[str, object]
        ) -> tuple[tuple[mpmath.mpf, mpmath.mpf], ...]:
            return tuple((mp.mpf(values[n]), mp.mpf(errors[n])) for n in self.names)

        error = state.error
        return _State(
            mp.mpf(t), pairs(state.q, error.q), pairs(state.p, error.p), pairs(state.velocity, error.velocity)
        )

    @cached_property
    def _momenta(self) -> Callable[..., list[mpmath.mpf]]:
        return sp.lambdify([self.space.time, *self.q, *self.alphas], self.slopes, NAMES)

    @cached_property
    def _jacobian(self) -> Callable[..., list[list[mpmath.mpf]]]:
        return self._by(self.alphas)

    @cached_property
    def _by_place(self) -> Callable[..., list[list[mpmath.mpf]]]:
        return self._by(self.q)

    def _by(self, symbols: Sequence[sp.Symbol]) -> Callable[..., list[list[mpmath.mpf]]]:
        rows = sp.Matrix(self.slopes).jacobian(symbols).tolist()
        return sp.lambdify([self.space.time, *self.q, *self.alphas], rows, NAMES)

    def constants(self, state: _State) -> list[mpmath.mpf] | None:
        """α with p = ∂S/∂q at a state, by Newton's method from random starts; None where none was found."""
        generator = random.Random(5)  # noqa: S311
        for _ in range(STARTS):
            start = [mp.mpf(generator.uniform(-1, 1)) * 10 ** generator.uniform(-1, 1.5) for _ in self.alphas]
            try:
                found = self._root(state, start)
            except (ZeroDivisionError, ValueError, TypeError):
                continue  # a singular step
            # roots of negative numbers on the way do no harm
            if found is not None and all(abs(mp.im(a)) <= mp.mpf(10) ** -20 * abs(a) for a in found):
                return [mp.re(a) for a in found]
        return None

    def _root(self, state: _State, α: list[mpmath.mpf]) -> list[mpmath.mpf] | None:
        """Return the α that forty of Newton's steps reach; mpmath's damped steps may halve without end."""
        q, p = [v for v, _ in state.q], [v for v, _ in state.p]
        for _ in range(40):
            gap = [P - v for P, v in zip(self._momenta(state.t, *q, *α), p, strict=True)]
            step = mp.lu_solve(mp.matrix(self._jacobian(state.t, *q, *α)), mp.matrix(gap))
            α = [a - s for a, s in zip(α, step, strict=True)]
            if not all(mp.isfinite(a) for a in α):
                return None
            if all(abs(s) <= mp.mpf(10) ** (8 - DIGITS) * (1 + abs(a)) for a, s in zip(α, step, strict=True)):
                return α
        return None

    def is_on_branch(self, state: _State, α: Sequence[mpmath.mpf]) -> bool:
        """Whether the momenta have the signs of the formula's, so that no root has another sign."""
        found = self._momenta(state.t, *(v for v, _ in state.q), *α)
        return all(not isinstance(P, mp.mpc) and P * v > 0 for P, (v, _) in zip(found, state.p, strict=True))

    def apart(self, state: _State, α: Sequence[mpmath.mpf], spread: Sequence[mpmath.mpf]) -> float:
        """How far ∂S/∂q is from p, over what the errors allow to first order, twice."""
        q = [v for v, _ in state.q]
        found, by_α, by_q = (f(state.t, *q, *α) for f in (self._momenta, self._jacobian, self._by_place))
        worst = mp.mpf(0)
        for P, (p, e), row, other in zip(found, state.p, by_α, by_q, strict=True):
            lost = e + mp.fsum(abs(c) * δ for c, δ in zip(row, spread, strict=True))
            lost += mp.fsum(abs(c) * δ for c, (_, δ) in zip(other, state.q, strict=True))
            worst = max(worst, abs(P - p) / (2 * lost + abs(p) * mp.mpf(10) ** (10 - DIGITS)))
        return float(worst)

    def spread(self, state: _State, α: Sequence[mpmath.mpf]) -> list[mpmath.mpf]:
        """Errors of α: of p, and of q through ∂p/∂q."""
        q = [v for v, _ in state.q]
        lost = [
            e + mp.fsum(abs(c) * δ for c, (_, δ) in zip(row, state.q, strict=True))
            for row, (_, e) in zip(self._by_place(state.t, *q, *α), state.p, strict=True)
        ]
        inverse = mp.matrix(self._jacobian(state.t, *q, *α)) ** -1
        return [mp.fsum(abs(inverse[j, i]) * e for i, e in enumerate(lost)) for j in range(len(α))]

    def residual(
        self, k: int, state: _State, α: Sequence[mpmath.mpf], spread: Sequence[mpmath.mpf]
    ) -> tuple[float, float]:
        """Return |d(∂S/∂α)/dt|, and its error to first order, twice."""
        held = [*state.q, *state.rates, *zip(α, spread, strict=True)]
        value, *slopes = self._with_slopes(k)(state.t, *(v for v, _ in held))
        error = 2 * mp.fsum(abs(c) * e for c, (_, e) in zip(slopes, held, strict=True))
        size = mp.fsum(abs(c * v) for c, (v, _) in zip(slopes, held, strict=True))
        return float(abs(value)), float(error + size * mp.mpf(10) ** (10 - DIGITS))

    def _with_slopes(self, k: int) -> Callable[..., list[mpmath.mpf]]:
        if k not in self._rows:
            symbols, e = [*self.q, *self.rates, *self.alphas], self.equations[k]
            self._rows[k] = sp.lambdify([self.space.time, *symbols], [e, *(sp.diff(e, s) for s in symbols)], NAMES)
        return self._rows[k]
