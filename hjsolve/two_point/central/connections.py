"""two_point about a centre of force: every pair (E, L) isolated, each refined by a motion that runs to q1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.algebra.time_limit import within_seconds
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.errors import HJSolveError, InvalidInputError, NotConvergedError
from hjsolve.motion.initial_data import to_bits
from hjsolve.two_point.asked.answers import MORE_SECONDS, Completeness, Connection, Connections
from hjsolve.two_point.asked.central_force import RADIUS, CentralForce
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.central.isolated_constants import energy_and_momentum, is_solved_by
from hjsolve.two_point.central.proved_search import (
    IsolatedMotion,
    RadialProblem,
    RadialProof,
    all_motions,
)
from hjsolve.two_point.central.radial_range import radial_problem
from hjsolve.two_point.kepler.central_places import CentralPlaces, geometry
from hjsolve.two_point.search.searched import and_searched, connection_of, reach
from hjsolve.two_point.search.shooting import solved_from

PROVED = (
    "Complete: on every radial path (turning points passed) and for every image of q1 the pairs (E, L) were isolated "
    "by enclosures of time and angle over boxes of both, and bounds hold beyond them; motions through the centre do "
    "not count; places and time rounded to doubles"
)
_BITS = 160
_IN_LINE = 1e-9
"""Sines of half the angle between the places below which a motion through the centre may join them."""


@dataclass(frozen=True)
class _Asked:
    """The question in the plane of the orbit.

    Attributes:
        question: as it was asked.
        values: symbol → exact number, of the parameters.
        force: the central force.
        mass: m.
        places: of its geometry, in numbers of many digits.
        problem: for the proof.
        images: for each angle of the problem, the way round (1 or −1) and whole turns.
    """

    question: TwoPlaceQuestion
    values: Mapping[sp.Symbol, sp.Expr]
    force: CentralForce
    mass: float
    places: CentralPlaces[Mpf]
    problem: RadialProblem
    images: tuple[tuple[int, int], ...]


def joined_about_a_centre(
    force: CentralForce, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr], budget: float
) -> Connections | None:
    """Return all motions about a centre that join two places; None where the enclosures do not serve.

    Args:
        force: the central force.
        question: what is asked.
        values: symbol → exact number, of the parameters.
        budget: seconds for the proof.
    """
    asked = _read(force, question, values)
    if asked is None:
        return None
    with within_seconds(budget):
        proof = all_motions(asked.problem)
    connections, lost = _refined(asked, proof)
    if not proof.undecided and not proof.high and not lost:
        connections.sort(key=lambda c: (c.turns, c.principal_function.value))
        return Connections(tuple(connections), Completeness(proved=True, statement=PROVED))
    return _with_search(asked, connections, (proof, lost))


def _read(force: CentralForce, question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr]) -> _Asked | None:
    q0, q1 = ([to_bits(q[name])(_BITS) for name in force.names] for q in (question.q0, question.q1))
    places = geometry(force.kind, q0, q1, Multi(_BITS))
    sine, cosine = float(places.half_sine), float(places.half_cosine)
    if sine < _IN_LINE or abs(cosine) < _IN_LINE:
        return None
    mass = float(to_bits(force.mass.xreplace(dict(values)))(64))
    if mass <= 0:
        return None
    sweep = 2 * np.arctan2(sine, cosine)
    both = [
        (sense, N, (sweep if sense > 0 else 2 * np.pi - sweep) + 2 * np.pi * N)
        for N in question.turns
        for sense in (1, -1)
    ]
    both.sort(key=lambda image: image[2])
    T = float(to_bits(question.time)(64))
    distances = float(places.r0), float(places.r1)
    try:
        problem = radial_problem(
            RADIUS, force.potential.xreplace(dict(values)), distances, T * np.sqrt(2 / mass),
            np.array([angle for *_, angle in both]), max(question.turns),
        )  # fmt: skip
    except InvalidInputError:
        return None
    if problem is None:
        return None
    return _Asked(question, values, force, mass, places, problem, tuple((sense, N) for sense, N, _ in both))


def _refined(asked: _Asked, proof: RadialProof) -> tuple[list[Connection], list[IsolatedMotion]]:
    """Return connections of isolated motions; and those that could not be run to q1."""

    connections: list[Connection] = []
    lost: list[IsolatedMotion] = []
    for motion in proof.motions:
        sense, turns = asked.images[motion.angle]
        try:
            p, ends = solved_from(asked.question, asked.values, _momenta(asked, motion))
            if not is_solved_by(asked.problem, motion, *_constants(asked, p)):
                raise NotConvergedError("Newton's method leads to another motion")
            path = f"{_sense_in_words(asked, sense)}, {asked.problem.branches[motion.branch].path}"
            connection = connection_of(asked.question, reach(asked.question, p, ends), path, turns)
        except HJSolveError:
            lost.append(motion)
            continue
        if not any(_same(connection, other) for other in connections):
            connections.append(connection)
    return connections, lost


def _sense_in_words(asked: _Asked, sense: int) -> str:
    if len(asked.force.names) == 3:
        return "the short way round" if sense > 0 else "the long way round"
    return "counterclockwise" if sense > 0 else "clockwise"


def _momenta(asked: _Asked, motion: IsolatedMotion) -> Reals:
    """Momenta at q0, in the order of the system's coordinates."""
    E, λ = energy_and_momentum(asked.problem, motion.chart, motion.at)
    sense, _ = asked.images[motion.angle]
    r0, places = float(asked.places.r0), asked.places
    V = float(sp.N(asked.problem.potential.V.subs(asked.problem.potential.r, r0)))
    radial = asked.problem.branches[motion.branch].sign * np.sqrt(max(2 * asked.mass * (E - V - (λ / r0) ** 2), 0.0))
    transverse = sense * λ * np.sqrt(2 * asked.mass) / r0
    p = {
        name: radial * float(a) + transverse * float(b)
        for name, a, b in zip(asked.force.names, places.radial0, places.tangent0, strict=True)
    }
    return np.array([p[c.name] for c in asked.question.system.coordinates])


def _constants(asked: _Asked, p: Reals) -> tuple[float, float]:
    """E and λ of a motion with these momenta at q0."""
    by_name = {c.name: float(x) for c, x in zip(asked.question.system.coordinates, p, strict=True)}
    p0 = np.array([by_name[name] for name in asked.force.names])
    # the momenta are radial·a + transverse·b; the metric of the transverse part is r0 times that of an angle
    A = np.array([[float(a), float(b)] for a, b in zip(asked.places.radial0, asked.places.tangent0, strict=True)])
    radial, transverse = np.linalg.lstsq(A, p0, rcond=None)[0]
    r0 = float(asked.places.r0)
    V = float(sp.N(asked.problem.potential.V.subs(asked.problem.potential.r, r0)))
    E = (radial**2 + transverse**2) / (2 * asked.mass) + V
    return float(E), float(abs(transverse) * r0 / np.sqrt(2 * asked.mass))


def _same(one: Connection, other: Connection) -> bool:
    """Whether two connections are one motion, found on two paths that meet where a place is a turning point."""
    return all(abs(float(one.p0[n].value - other.p0[n].value)) <= one.p0[n].error + other.p0[n].error for n in one.p0)


def _with_search(
    asked: _Asked,
    connections: list[Connection],
    left: tuple[RadialProof, list[IsolatedMotion]],
) -> Connections:
    """Return what was isolated and what a search finds, with the energies that are not decided."""
    proof, lost = left
    found, continua = and_searched(connections, asked.question, asked.values)
    ends = list(proof.undecided)
    ends += [(E, E) for E, _ in (energy_and_momentum(asked.problem, m.chart, m.at) for m in lost)]
    if proof.high:
        ends.append((asked.problem.top, np.inf))
    statement = (
        "Pairs (E, L) were isolated by enclosures of time and angle, but not decided within these energies, where a "
        "search looked"
    ) + (MORE_SECONDS if proof.ended else "")
    ranges = {"energy": (min(a for a, _ in ends), max(b for _, b in ends))}
    return Connections(tuple(found), Completeness(False, statement, ranges), continua)
