"""two_point of one coordinate: every branch's energies isolated, each refined by motions that run to q1.

An angle is followed on the line: q1 + 2πk for every k that the turns asked allow; farther than a turn away only without
turning points, for V repeats itself and a libration is shorter than a turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import sympy as sp

from hjsolve.algebra.time_limit import within_seconds
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.errors import HJSolveError, InvalidInputError
from hjsolve.motion.initial_data import domain_ends, to_bits
from hjsolve.two_point.asked.answers import MORE_SECONDS, Completeness, Connection, Connections
from hjsolve.two_point.asked.question import TwoPlaceQuestion
from hjsolve.two_point.one_freedom.line_branches import LineBranch, branches
from hjsolve.two_point.one_freedom.proved_search import EnergyProof, IsolatedEnergy, TravelTimes, all_energies
from hjsolve.two_point.one_freedom.travel_time import Line
from hjsolve.two_point.search.searched import and_searched, connection_of, reach
from hjsolve.two_point.search.shooting import solved_from

PROVED = (
    "Complete: on every branch (direction at the start, turning points) the energies were isolated by enclosures of "
    "the time over intervals of E, and bounds hold beyond them; places and time rounded to doubles"
)


class LineShell(NamedTuple):
    """One coordinate with dt = μ dq/√(E − V)."""

    potential: sp.Expr
    weight: sp.Expr
    shift: sp.Expr


@dataclass(frozen=True)
class _Goal:
    """One image of q1 on the line."""

    times: TravelTimes
    branches: tuple[LineBranch, ...]
    target: float
    order: int


def shell_of(question: TwoPlaceQuestion) -> LineShell | None:
    """Return V, μ and the shift of a system of one coordinate whose P² is linear in E; None for another."""
    solution = question.solution
    if solution.chart is not None or len(solution.system.coordinates) != 1 or len(solution.coordinates) != 1:
        return None
    name = solution.coordinates[0]
    square = solution.momentum_squared.get(name)
    if square is None or solution.system.kinks or solution.system.functions or solution.system.relativity is not None:
        return None
    E = solution.constants[solution.separation.shell.energy.name].symbol
    A = sp.diff(square, E)
    if sp.diff(A, E) != 0 or A.has(E):
        return None
    C = sp.expand(square.subs(E, 0)) if square.is_polynomial(E) else square.subs(E, 0)
    return LineShell(sp.simplify(-C / A), sp.sqrt(A) / 2, solution.shift[name])


def joined_on_a_line(
    question: TwoPlaceQuestion, values: Mapping[sp.Symbol, sp.Expr], shell: LineShell, budget: float
) -> Connections | None:
    """Return all motions of one coordinate that join two places; None where the enclosures do not serve.

    Args:
        question: what is asked.
        values: symbol → exact number, of the parameters.
        shell: of the system.
        budget: seconds for the proof.
    """
    coordinate = question.system.coordinates[0]
    T = float(to_bits(question.time)(64))
    turning = coordinate.domain.kind == "angle"
    ends = domain_ends(question.system, coordinate.name, values)
    low, high = (None if e is None else float(to_bits(e)(64)) for e in ends)
    limits = (-np.inf if low is None else low, np.inf if high is None else high)
    try:
        line = Line(coordinate.symbol, shell.potential, shell.weight, values, limits, 2 * np.pi if turning else 0.0)
    except InvalidInputError:
        return None
    start = float(to_bits(question.q0[coordinate.name])(64))
    first = float(to_bits(question.q1[coordinate.name])(64))
    found: list[tuple[_Goal, IsolatedEnergy]] = []
    proof = EnergyProof()
    μ = float(line.over(np.array([start]), np.array([start]), 1)[3].high[0])
    with within_seconds(budget):
        for goal in _goals(question, line, start, first):
            straight = μ * max(abs(goal.target - start), 1e-3 * (1 + abs(start))) / T
            part = all_energies(goal.times, goal.branches, T, straight)
            found += [(goal, energy) for energy in part.energies]
            proof.undecided += part.undecided
            proof.least, proof.faster = min(proof.least, part.least), proof.faster or part.faster
            proof.ended |= part.ended
    connections, lost = _refined(question, values, shell, found)
    proof.undecided += lost
    connections.sort(key=lambda c: (c.turns, c.principal_function.value))
    if proof.ended:
        connections, _ = and_searched(connections, question, values)
    least = None
    if not connections and not proof.faster and np.isfinite(proof.least):
        least = Estimate(proof.least, 0.02 * proof.least)
    return Connections(tuple(connections), _completeness(proof), (), least)


def _goals(question: TwoPlaceQuestion, line: Line, start: float, first: float) -> Iterator[_Goal]:
    """Return the images of q1 with the branches that lead to each."""
    most, asked = max(question.turns), set(question.turns)
    images = [first]
    if line.turn:
        nearest = first - line.turn * np.rint((first - start) / line.turn)
        images = [nearest + line.turn * k for k in range(-most - 1, most + 2)]
    for target in images:
        apart = target - start
        order = int(np.sign(apart)) if abs(apart) > 1e-14 * (1 + abs(start)) else 0
        times = TravelTimes(line, min(start, target), max(start, target))
        direct = (
            [LineBranch(order, 1, 0, 0, int((abs(apart) + 1e-12) // line.turn) if line.turn else 0)] if order else []
        )
        if line.turn and abs(apart) >= line.turn * (1 - 1e-12):
            chosen = direct
        else:
            chosen = direct + [b for b in branches(order, most) if b.upper + b.lower]
        chosen = [b for b in chosen if b.turns in asked]
        if chosen:
            yield _Goal(times, tuple(chosen), target, order)


def _refined(
    question: TwoPlaceQuestion,
    values: Mapping[sp.Symbol, sp.Expr],
    shell: LineShell,
    found: list[tuple[_Goal, IsolatedEnergy]],
) -> tuple[list[Connection], list[tuple[float, float]]]:
    """Return Connections from energies; and the intervals whose motion could not be run to q1."""
    coordinate = question.system.coordinates[0]
    at = {**values, coordinate.symbol: question.q0[coordinate.name]}
    V, μ, shift = (float(sp.N(e.subs(at), 20)) for e in (shell.potential, shell.weight, shell.shift))
    connections: list[Connection] = []
    lost: list[tuple[float, float]] = []
    for goal, energy in found:
        P = energy.branch.sign * 2 * μ * np.sqrt(max(energy.value - V, 0.0))
        try:
            p, ends = solved_from(question, values, np.array([P - shift]), goal.target)
            connection = connection_of(question, reach(question, p, ends), energy.branch.path, energy.branch.turns)
        except HJSolveError:
            lost.append((energy.low, energy.high))
            continue
        inside = (
            energy.low - 1e-9 * (1 + abs(energy.low))
            <= connection.energy.value
            <= energy.high + 1e-9 * (1 + abs(energy.high))
        )
        if inside:
            connections.append(connection)
        else:
            lost.append((energy.low, energy.high))
    return connections, lost


def _completeness(proof: EnergyProof) -> Completeness:
    if not proof.undecided:
        return Completeness(proved=True, statement=PROVED)
    low, high = min(a for a, _ in proof.undecided), max(b for _, b in proof.undecided)
    return Completeness(
        proved=False,
        statement="Energies were isolated by enclosures of the time, but not decided within these intervals"
        + (MORE_SECONDS if proof.ended else ""),
        searched={"energy": (low, high)},
    )
