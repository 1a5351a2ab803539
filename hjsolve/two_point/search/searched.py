"""two_point where nothing is proved: a stated search, each motion of which is started by quadratures and run to q1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.errors import HJSolveError, NotConvergedError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.system import hamiltonian
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.two_point.asked.answers import Completeness, Connection, Connections, Continuum
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.asked.verified import difference, end_point, started
from hjsolve.two_point.search.flow import Ends
from hjsolve.two_point.search.shooting import MomentumZero, SearchResult, search

_PASSES = 6
_LEFT, _SURE = 1e-3, 0.05
"""What a step of Newton's method leaves of a miss at most, its derivatives being known to more digits than that; and
which part of what the end point is allowed to be off is small enough."""
_EXTRA = 12
"""Decimal digits that momenta have beyond those of the motion."""


@dataclass(frozen=True)
class _Reached:
    """Momenta that lead to q1, and the motion by quadratures next to theirs: one step of Newton's method away.

    Attributes:
        motion: that ends next to q1.
        p: momenta at q0 to many digits, after the step.
        step: what the step took from its momenta, shape (n,).
        miss: where it ends, minus q1, shape (n,).
        rest: how far from q1 the momenta may lead, the error of the motion itself aside, shape (n,).
        ends: of the flow, with its variations.
    """

    motion: Motion
    p: Mapping[str, Mpf]
    step: Reals
    miss: Reals
    rest: Reals
    ends: Ends


def joined_by_search(question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]) -> Connections:
    """Return the motions that a search finds.

    Args:
        question: what is asked.
        values: symbol → exact number, of the parameters.

    Raises:
        InvalidInputError: T or V has kinks.
        NotConvergedError: no motion could be followed for the time asked.
    """
    refuse_kinks(question.system.kinks, "two_point")
    found = search(question, values)
    connections: list[Connection] = []
    continua: list[Continuum] = []
    lost = 0
    for zero in found.zeros:
        if turns_of(question, zero.ends) not in question.turns:
            continue
        try:
            reached = reach(question, zero.p, zero.ends)
        except HJSolveError:
            lost += 1
            continue
        connection = connection_of(question, reached)
        if zero.free:
            continua.append(_family(zero, connection))
        elif not any(_same(connection, other) for other in connections):
            connections.append(connection)
    connections.sort(key=lambda c: (c.turns, c.principal_function.value))
    return Connections(tuple(connections), _stated(question, found, lost), tuple(continua))


def and_searched(
    connections: list[Connection], question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]
) -> tuple[list[Connection], tuple[Continuum, ...]]:
    """Return connections together with those that a search finds besides, and its continua.

    Args:
        connections: of which a proof is not finished.
        question: what is asked.
        values: symbol → exact number, of the parameters.

    Raises:
        InvalidInputError: as of ``joined_by_search``.
    """
    try:
        searched = joined_by_search(question, values)
    except NotConvergedError:  # no start could be followed
        return connections, ()
    found = connections + [c for c in searched if not any(_same(c, other) for other in connections)]
    return sorted(found, key=lambda c: (c.turns, c.principal_function.value)), searched.continua


def _stated(question: TwoPlaceQuestion, found: SearchResult, lost: int) -> Completeness:
    more = f"; {lost} more could not be run to the end by quadratures" if lost else ""
    return Completeness(
        proved=False,
        statement=(
            f"A search, not a proof: Newton's method on the initial momenta from {found.starts} starts, without "
            f"motions that leave the domain of a coordinate or collide{more}"
        ),
        searched={
            "kinetic energy at q0": (0.0, found.energy),
            "turns": (float(min(question.turns)), float(max(question.turns))),
        },
    )


def reach(question: TwoPlaceQuestion, p: Reals, ends: Ends) -> _Reached:
    """Refine momenta by Newton's method on motions by quadratures.

    The last step is not run again where it is sure to leave less of the miss than errors and roundings allow.

    Args:
        question: what is asked.
        p: momenta in doubles, shape (n,).
        ends: where they lead in the flow.

    Raises:
        NotConvergedError: they do not end there.
    """
    coordinates = question.system.coordinates
    if ends.index[0] < 0:
        raise NotConvergedError("the conjugate points along a motion could not be counted in doubles")
    context = multiprecision(int(3.33 * (question.digits + _EXTRA)) + 16)
    exact = [context.mpf(float(x)) for x in p]
    inverse = np.linalg.pinv(ends.position_by_momentum[0], rcond=1e-9)
    best: _Reached | None = None
    least = np.inf
    for _ in range(_PASSES):
        momenta = {c.name: x for c, x in zip(coordinates, exact, strict=True)}
        motion = question.solution.motion(
            q=dict(question.q0), p=momenta, parameters=dict(question.given), digits=question.digits
        )
        allowed = end_point(question, motion)[1]
        miss, room = _miss(question, motion), np.array([allowed[c.name] for c in coordinates])
        step = inverse @ miss
        with np.errstate(all="ignore"):
            worst = float(np.max(np.where(miss != 0, np.abs(miss) / room, 0.0)))
        if not worst < least:
            break
        exact = [x - context.mpf(float(d)) for x, d in zip(exact, step, strict=True)]
        least, best = worst, _Reached(motion, dict(zip(momenta, exact, strict=True)), step, miss, _LEFT * miss, ends)
        if worst * _LEFT <= _SURE:
            break
    if best is not None and least <= max(1.0, _SURE / _LEFT):
        return best
    raise NotConvergedError("a motion that the search found does not end at q1 by quadratures")


def _miss(question: TwoPlaceQuestion, motion: Motion) -> Reals:
    """Return where a motion ends, minus q1; shape (n,)."""
    state = motion.at(question.time)
    return np.array(
        [difference(state, c.name, question.q1[c.name], angle=c.domain.kind == "angle", digits=question.digits)
         for c in question.system.coordinates]
    )  # fmt: skip


def connection_of(
    question: TwoPlaceQuestion, reached: _Reached, path: str = "", turns: int | None = None
) -> Connection:
    """Return how the motion to q1 is reported.

    What the motion next to it misses is added to first order: to S as −∂S/∂q1 of it, to p1 as ∂p1/∂p0 of the step.
    Momenta err by the error of the end point through the inverse of ∂q/∂p0.

    Args:
        question: what is asked.
        reached: the momenta, and the motion.
        path: in words.
        turns: whole turns; None to count them.
    """
    coordinates, motion, ends = question.system.coordinates, reached.motion, reached.ends
    state, miss = motion.at(question.time), reached.miss
    off = np.abs(reached.rest) + np.array([float(state.error.q[c.name]) for c in coordinates])
    inverse = np.abs(np.linalg.pinv(ends.position_by_momentum[0], rcond=1e-9))
    p0_error = inverse @ off
    p1_error = np.abs(ends.momentum_by_momentum[0]) @ p0_error
    p0 = {c.name: _value(reached.p[c.name], question.digits, e) for c, e in zip(coordinates, p0_error, strict=True)}
    shift = ends.momentum_by_momentum[0] @ reached.step
    p1 = {
        c.name: Estimate(
            state.p[c.name] - float(d), 2 * e + float(state.error.p[c.name]) + EPS * abs(float(state.p[c.name]))
        )
        for c, e, d in zip(coordinates, p1_error, shift, strict=True)
    }
    S = motion.principal_function(question.time)
    slopes = np.array([float(state.p[c.name]) for c in coordinates])
    correction = -float(slopes @ miss)
    bend = float(np.abs(miss) @ np.abs(shift))
    S_error = float(S.error) + bend + float(np.abs(slopes) @ off) + 4 * EPS * abs(float(S.value))
    sweep = _sweep(question, ends)
    turns = turns_of(question, ends) if turns is None else turns
    return Connection(
        turns=turns,
        path=path or _words(sweep, turns),
        p0=p0,
        p1=p1,
        energy=_energy(question, p0),
        principal_function=Estimate(S.value + correction, S_error),
        conjugate_points=int(ends.index[0]),
        sweep=sweep,
        begin=partial(started, question, reached.p),
    )


def _value(x: Mpf, digits: int, error: float) -> Estimate:
    value = float(x) if digits <= 15 else x
    return Estimate(value, 2 * error + EPS * abs(float(x)))


def _energy(question: TwoPlaceQuestion, p0: Mapping[str, Estimate]) -> Estimate:
    """H at q0, with the error that the momenta give it."""
    system = question.system
    H = hamiltonian(system)
    values = {p.symbol: p.value for p in system.parameters if p.value is not None}
    for name, given in question.given.items():
        values[system.symbols[name]] = sp.sympify(str(given)) if isinstance(given, str) else sp.nsimplify(given)
    point = values | {c.symbol: question.q0[c.name] for c in system.coordinates}
    at = {c.momentum: sp.Float(float(p0[c.name].value), 20) for c in system.coordinates}
    E = float(sp.N(H.xreplace(point).xreplace(at), 20))
    spread = sum(
        abs(float(sp.N(sp.diff(H, c.momentum).xreplace(point).xreplace(at), 20))) * float(p0[c.name].error)
        for c in system.coordinates
    )
    return Estimate(E, 2 * spread + 16 * EPS * abs(E))


def _sweep(question: TwoPlaceQuestion, ends: Ends) -> dict[str, float]:
    """How far each angle runs."""
    result = {}
    for i, c in enumerate(question.system.coordinates):
        if c.domain.kind == "angle":
            result[c.name] = float(ends.q[i, 0]) - float(to_bits(question.q0[c.name])(64))
    return result


def turns_of(question: TwoPlaceQuestion, ends: Ends) -> int:
    """Return whole turns: of the angle that turns most, else half the reversals of the velocity that has most.

    Args:
        question: what is asked.
        ends: of the motion.
    """
    sweep = _sweep(question, ends)
    whole = [int((abs(angle) + 1e-9) // (2 * np.pi)) for angle in sweep.values()]
    if whole:
        return max(whole)
    return int(np.max(ends.reversals[:, 0])) // 2


def _words(sweep: Mapping[str, float], turns: int) -> str:
    parts = [f"{name} by {angle:+.4g} rad" for name, angle in sweep.items()]
    return ", ".join(parts) or (f"{turns} there-and-back{'' if turns == 1 else 's'}" if turns else "directly")


def _family(zero: MomentumZero, member: Connection) -> Continuum:
    count = zero.free
    return Continuum(
        statement="q1 is conjugate to q0: motions with other initial momenta are there at the same time.",
        free=(f"{count} component{'s' if count > 1 else ''} of the initial momentum",),
        turns=member.turns,
        energy=None,
        principal_function=member.principal_function,
        member=member,
    )


def _same(one: Connection, other: Connection) -> bool:
    """Whether two connections are one motion: momenta alike within their errors or a part in 10⁸."""
    size = max(abs(float(e.value)) for e in (*one.p0.values(), *other.p0.values()))
    return all(
        abs(float(one.p0[n].value - other.p0[n].value)) <= 1e-7 * size + one.p0[n].error + other.p0[n].error
        for n in one.p0
    )
