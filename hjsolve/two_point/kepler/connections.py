"""two_point of a Kepler problem: all conics through two places in a time, exact special cases distinguished.

q0 and q1 in one direction from the centre are joined on the line alone, up to the same place, which every ellipse of
the right period passes again; q0 and q1 in opposite directions in space leave the plane of the orbit free.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS, Multi, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.two_point.asked.answers import Completeness, Connection, Connections, Continuum
from hjsolve.two_point.asked.central_force import Attraction
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.asked.verified import started
from hjsolve.two_point.kepler.central_places import CentralPlaces, geometry
from hjsolve.two_point.kepler.kernels.lambert import Transfer, conics
from hjsolve.two_point.kepler.many_digits import (
    ExactTransfer,
    exact_transfer,
    momenta_exactly,
    precision,
    refined,
)
from hjsolve.two_point.kepler.momenta import Column, ConicNumbers, Problems, numbers_of

_BITS = 160
_ZERO = 2.0**-100
"""Sines and cosines of exact angles below this are zero: they come from numbers of 160 bits."""
PROVED = Completeness(
    proved=True,
    statement=(
        "Complete: T(x) falls from infinity to 0 without a full turn, and has one minimum with N turns, so these are "
        "all the conics for each way round (Lancaster and Blanchard 1969)"
    ),
)
_ON_LINE = Completeness(
    proved=True,
    statement=(
        "Complete: both places are in one direction from the centre, so L = 0, and what returns on this line after a "
        "turn has fallen into the centre"
    ),
)
_SENSES = {1: "counterclockwise", -1: "clockwise"}


@dataclass(frozen=True)
class _Asked:
    """The question in numbers of 160 bits, and which of its special cases it is."""

    attraction: Attraction
    question: TwoPlaceQuestion
    values: Mapping[sp.Symbol, sp.Expr]
    exact: ExactTransfer

    @property
    def in_line(self) -> bool:
        """Whether both places are in one direction from the centre."""
        return bool(self.exact.places.half_sine < _ZERO)

    @property
    def same(self) -> bool:
        """Whether both places are one."""
        return self.in_line and bool(abs(self.exact.places.r0 - self.exact.places.r1) <= _ZERO * self.exact.places.r0)

    @property
    def plane_free(self) -> bool:
        """Whether the plane of the orbit is free: in space, in opposite directions."""
        return self.dimension == 3 and bool(abs(self.exact.places.half_cosine) < _ZERO)

    @property
    def dimension(self) -> int:
        """Of the space."""
        return len(self.attraction.names)


def joined_by_conics(
    attraction: Attraction, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]
) -> Connections:
    """Return all conics that join two places in a time.

    Args:
        attraction: the Kepler problem.
        question: what is asked.
        values: symbol → exact number, of the parameters.
    """
    asked = _Asked(attraction, question, values, _exactly(attraction, question, values, _BITS))
    slots = _slots(asked)
    continua = list(_returns(asked))
    proof = _ON_LINE if asked.in_line and not asked.same else PROVED
    if not slots:
        return Connections((), proof, tuple(continua), None if continua else _least_return(asked))
    problems = _problems(asked.exact, [sense for sense, _ in slots])
    found, least = conics(problems.path, problems.wanted, np.array([N for _, N in slots]))
    numbers = numbers_of(problems, found, np.array([sense for sense, _ in slots]))
    connections = []
    for i, slot in enumerate(found.problem):
        sense, N = slots[slot]
        several = N > 0 and bool(found.slope[i] != 0)
        x = float(found.w[i] - 1 if found.w[i] < found.v[i] else 1 - found.v[i])
        connections.append(_connection(asked, numbers, i, (sense, N, x), bool(found.upper[i]) if several else None))
    if asked.plane_free:
        continua += [_turned(connection) for connection in connections]
        connections = []
    nothing = not connections and not continua
    return Connections(tuple(connections), proof, tuple(continua), _least(problems, least) if nothing else None)


def _exactly(
    attraction: Attraction, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr], bits: int
) -> ExactTransfer:
    """Return the transfer with so many bits."""
    context = multiprecision(bits)
    q0, q1 = ([to_bits(q[name])(bits) for name in attraction.names] for q in (question.q0, question.q1))
    places = geometry(attraction.kind, q0, q1, Multi(bits))
    m, k = (to_bits(e.xreplace(values))(bits) for e in (attraction.mass, attraction.strength))
    return exact_transfer(context, places, k / m, m, to_bits(question.time)(bits))


def _slots(asked: _Asked) -> list[tuple[int, int]]:
    """Ways round and turns for which there may be conics, those with fewer turns first."""
    turns = asked.question.turns
    if asked.in_line:
        return [(1, 0)] if 0 in turns else []
    senses = (1,) if asked.plane_free else (1, -1)
    return [(sense, N) for N in turns for sense in senses]


def _problems(exact: ExactTransfer, senses: Sequence[int]) -> Problems:
    """Return the transfers in doubles, from many digits: λ and 1 − λ² are right to the last one."""
    ones = np.ones(len(senses))
    places = exact.places
    signs = np.array(senses, dtype=float)
    c, s = float(exact.chord), float(exact.s)
    path = Transfer(signs * float(exact.λ(1)), ones * float(exact.chord / exact.s), ones * c, ones * s)
    flat = CentralPlaces(
        ones * float(places.r0), ones * float(places.r1), ones * float(places.half_sine),
        signs * float(places.half_cosine),
        *([ones * float(a) for a in vector] for vector in places[4:]),
    )  # fmt: skip
    return Problems(flat, path, ones * float(exact.attraction), float(exact.mass), ones * float(exact.time))


def _connection(
    asked: _Asked, numbers: ConicNumbers, i: int, which: tuple[int, int, float], upper: bool | None
) -> Connection:
    sense, N, _ = which
    names = asked.attraction.names
    sweep = _sweep(asked, sense, N)
    conjugate = int(numbers.conjugate_points[i])
    if asked.dimension == 3 and not asked.in_line:
        conjugate += _half_turns(asked, sense, N)
    return Connection(
        turns=N,
        path=_words(asked, sense, N, upper),
        p0={name: _estimate(column, i) for name, column in zip(names, numbers.p0, strict=True)},
        p1={name: _estimate(column, i) for name, column in zip(names, numbers.p1, strict=True)},
        energy=_estimate(numbers.energy, i),
        principal_function=_estimate(numbers.principal_function, i),
        conjugate_points=conjugate,
        sweep=sweep,
        begin=_Beginning(asked.attraction, asked.question, asked.values, which),
    )


def _words(asked: _Asked, sense: int, N: int, upper: bool | None) -> str:
    if asked.in_line:
        return "on the line through the centre"
    if asked.dimension == 3:
        angle = "the short way round" if sense > 0 else "the long way round"
        direction = "half a turn" if asked.plane_free else angle
    else:
        direction = _SENSES[sense]
    turns = "" if N == 0 else f", {N} full turn{'s' if N > 1 else ''}"
    return direction + turns + ("" if upper is None else f", {'shorter' if upper else 'longer'} period")


def _half_turns(asked: _Asked, sense: int, N: int) -> int:
    """How often the orbit passes the line through q0 and the centre before its end."""
    long = (asked.exact.places.half_cosine < 0) == (sense > 0) and abs(asked.exact.places.half_cosine) >= _ZERO
    return 2 * N + int(long)


def _sweep(asked: _Asked, sense: int, N: int) -> dict[str, float]:
    if asked.attraction.kind != "polar":
        return {}
    if asked.in_line:
        return {asked.attraction.names[1]: 0.0}
    places, context = asked.exact.places, asked.exact.context
    angle = 2 * context.atan2(places.half_sine, sense * places.half_cosine)
    return {asked.attraction.names[1]: float(sense * (angle + 2 * context.pi * N))}


def _estimate(column: Column, i: int) -> Estimate:
    return Estimate(float(column.value[i]), float(column.error[i]))


@dataclass(frozen=True)
class _Beginning:
    """How the motion of one conic starts: x to many digits, and momenta from it."""

    attraction: Attraction
    question: TwoPlaceQuestion
    values: Mapping[sp.Symbol, sp.Expr]
    which: tuple[int, int, float]

    def __call__(self) -> Motion:
        """Return the motion."""
        sense, N, x = self.which
        bits = int(3.33 * precision(self.question.digits)) + 8
        exact = _exactly(self.attraction, self.question, self.values, bits)
        p = momenta_exactly(exact, sense, refined(exact, sense, N, x))
        return started(self.question, dict(zip(self.attraction.names, p, strict=True)))


# ------------------------------------------------------------------------------------------------ special cases
def _returns(asked: _Asked) -> Iterable[Continuum]:
    """Ellipses that come back to the same place after whole turns: E is fixed by the period, the direction is free."""
    if not asked.same:
        return
    for N in asked.question.turns:
        if N == 0 or asked.exact.time < _least_period(asked, N):
            continue
        context, μ, m, t = (getattr(asked.exact, name) for name in ("context", "attraction", "mass", "time"))
        a = context.cbrt(μ * (t / (2 * context.pi * N)) ** 2)
        E, W = -m * μ / (2 * a), 2 * context.pi * N * m * context.sqrt(μ * a)
        yield Continuum(
            statement=f"Every ellipse through q0 with the period T/{N} is there again after {N} turn{'s'[: N > 1]}."
            if N > 1
            else "Every ellipse through q0 with the period T is there again after one turn.",
            free=("the direction of the velocity at q0",),
            turns=N,
            energy=_rounded(E),
            principal_function=_rounded(W - E * t),
        )


def _rounded(x: Mpf) -> Estimate:
    return Estimate(float(x), EPS * abs(float(x)))


def _least_period(asked: _Asked, N: int) -> Mpf:
    """N periods of the least ellipse through q0, that of the semimajor axis r/2."""
    context, r = asked.exact.context, asked.exact.places.r0
    return 2 * context.pi * N * context.sqrt((r / 2) ** 3 / asked.exact.attraction)


def _least_return(asked: _Asked) -> Estimate | None:
    """Return the least time of a return to the same place; None where there is no motion with full turns at all."""
    whole = [N for N in asked.question.turns if N > 0]
    return _rounded(_least_period(asked, min(whole))) if asked.same and whole else None


def _turned(connection: Connection) -> Continuum:
    """Half a turn in space: the plane of the orbit is free."""
    return Continuum(
        statement=f"q1 is opposite to q0 as seen from the centre: {connection.path}, in any plane through both.",
        free=("the plane of the orbit",),
        turns=connection.turns,
        energy=connection.energy,
        principal_function=connection.principal_function,
    )


def _least(problems: Problems, least: Reals) -> Estimate | None:
    """Return the least time of all lanes that were asked."""
    unit = problems.time / problems.wanted
    times = np.where(least > 0, least * unit, np.inf)
    value = float(np.min(times))
    return Estimate(value, 64 * EPS * value) if np.isfinite(value) else None


def is_attraction(attraction: Attraction, values: Mapping[sp.Symbol, sp.Expr]) -> bool:
    """Whether k > 0 and m > 0 with these numbers.

    Args:
        attraction: the Kepler problem.
        values: symbol → exact number.
    """
    return all(to_bits(e.xreplace(values))(64) > 0 for e in (attraction.mass, attraction.strength))
