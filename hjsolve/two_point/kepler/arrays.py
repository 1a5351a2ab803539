"""two_point of a Kepler problem for arrays of places and times: columns over all conics found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from hjsolve import arguments
from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError, MissingValueError, of_kind
from hjsolve.motion.initial_data import parameter_values, to_bits
from hjsolve.solution.quadratures import Solution
from hjsolve.two_point.asked.answers import Completeness, Connections
from hjsolve.two_point.asked.central_force import Attraction
from hjsolve.two_point.asked.question import read_turns
from hjsolve.two_point.kepler.central_places import CentralPlaces, geometry
from hjsolve.two_point.kepler.connections import PROVED
from hjsolve.two_point.kepler.kernels.lambert import conics, transfer
from hjsolve.two_point.kepler.momenta import Column, Problems, numbers_of


@dataclass(frozen=True, eq=False, repr=False)
class ConnectionTable(Shown):
    """All motions that join pairs of places in their times: one row for each motion.

    Attributes:
        problem: which of the problems asked a row belongs to, in increasing order; shape (rows,).
        turns: whole turns.
        way: 1 counterclockwise, or the short way round in space; −1 the other way.
        p0, p1: coordinate → momenta at both ends, with errors.
        energy, principal_function: E and S, with errors.
        conjugate_points: as of ``Connection``.
        complete: proved for every problem.
        continuum: problems for which families are left out: the same place again, or opposite places in space;
            shape (problems,).
    """

    problem: Integers
    turns: Integers
    way: Integers
    p0: Mapping[str, EstimateArray]
    p1: Mapping[str, EstimateArray]
    energy: EstimateArray
    principal_function: EstimateArray
    conjugate_points: Integers
    complete: Completeness
    continuum: Mask
    asked: tuple[Solution, Mapping[str, Reals], Mapping[str, Reals], Reals, tuple[int, ...], Mapping[str, object]] = (
        field(repr=False)
    )

    def __len__(self) -> int:
        return len(self.problem)

    def connections(self, problem: int) -> Connections:
        """Return the answer for one problem, with its motions.

        Args:
            problem: its index, from 0 on.
        """
        solution, q0, q1, time, turns, parameters = self.asked
        places = ({name: float(x[problem]) for name, x in q.items()} for q in (q0, q1))
        found = solution.two_point(
            q0=next(places), q1=next(places), time=float(time[problem]), turns=turns, parameters=parameters
        )
        return of_kind(found, Connections)


def has_arrays(*given: object) -> bool:
    """Tell whether a place or the time is an array or a list.

    Args:
        given: q0, q1 and the time, as they came.
    """
    single = [x for g in given for x in (g.values() if isinstance(g, Mapping) else (g,))]
    return any(isinstance(x, (list, tuple)) or getattr(x, "ndim", 0) > 0 for x in single)


def table_of_conics(
    solution: Solution, attraction: Attraction, given: tuple[object, object, object, object], parameters: object
) -> ConnectionTable:
    """Solve Lambert's problem for arrays.

    Args:
        solution: of the Kepler problem.
        attraction: what it is.
        given: q0, q1, time and turns as they came; arrays of shape (n,) or numbers.
        parameters: name → number.

    Raises:
        InvalidInputError: arrays of different lengths, places that are no numbers or outside the domain, times that
            are not positive.
    """
    system = solution.system if solution.chart is None else solution.chart.original
    known = arguments.table({} if parameters is None else parameters, "parameters", '{"m": 1}')
    values = parameter_values(system, known)
    turns = read_turns(given[3])
    q0, q1, time = _columns(attraction, *given[:3])
    m, k = (float(to_bits(e.xreplace(values))(64)) for e in (attraction.mass, attraction.strength))
    if attraction.kind != "cartesian" and not (np.all(q0[0] > 0) and np.all(q1[0] > 0)):
        raise InvalidInputError(f"{attraction.names[0]}: it is positive at every place")
    places = geometry(attraction.kind, q0, q1, Float64())
    count, senses = len(time), np.array([1, -1])
    slots = [(N, sense) for N in turns for sense in senses]
    problem = np.repeat(np.arange(count), len(slots))
    sense = np.tile(np.array([w for _, w in slots]), count)
    N = np.tile(np.array([n for n, _ in slots]), count)
    in_line = places.half_sine == 0
    opposite = (places.half_cosine == 0) & (len(attraction.names) == 3)
    allowed = ~opposite[problem] & (~in_line[problem] | ((sense == 1) & (N == 0) & (places.half_cosine[problem] > 0)))
    allowed |= in_line[problem] & (sense == -1) & (N == 0) & (places.half_cosine[problem] < 0)
    problem, sense, N = problem[allowed], sense[allowed], N[allowed]
    slot = CentralPlaces(
        places.r0[problem], places.r1[problem], places.half_sine[problem], sense * places.half_cosine[problem],
        *([x[problem] if np.ndim(x) else x for x in vector] for vector in places[4:]),
    )  # fmt: skip
    path = transfer(slot.r0, slot.r1, slot.half_sine, slot.half_cosine)
    problems = Problems(slot, path, np.full(len(problem), k / m), m, time[problem])
    found, _ = conics(path, problems.wanted, N)
    numbers = numbers_of(problems, found, sense)
    conjugate = numbers.conjugate_points
    if len(attraction.names) == 3:
        at = found.problem
        conjugate = conjugate + np.where(in_line[problem[at]], 0, 2 * found.turns + (slot.half_cosine[at] < 0))
    same = in_line & (places.r0 == places.r1)
    p0, p1 = (
        {name: _estimates(c) for name, c in zip(attraction.names, p, strict=True)} for p in (numbers.p0, numbers.p1)
    )
    given_places = [dict(zip(attraction.names, q, strict=True)) for q in (q0, q1)]
    return ConnectionTable(
        problem[found.problem], found.turns, sense[found.problem], p0, p1, _estimates(numbers.energy),
        _estimates(numbers.principal_function), conjugate, PROVED, same | opposite,
        (solution, given_places[0], given_places[1], time, turns, known),
    )  # fmt: skip


def _columns(attraction: Attraction, q0: object, q1: object, time: object) -> tuple[list[Reals], list[Reals], Reals]:
    """Places and times as arrays of one length."""
    tables = [arguments.table(q, name, '{"r": 1, "theta": 0}') for name, q in (("q0", q0), ("q1", q1))]
    columns: list[Reals] = []
    for name, table in zip(("q0", "q1"), tables, strict=True):
        for coordinate in table:
            if coordinate not in attraction.names:
                raise InvalidInputError(f"{name}: {coordinate!r} is not a coordinate of this system")
        for coordinate in attraction.names:
            if coordinate not in table:
                raise MissingValueError(f"{name}: no value for {coordinate}; every coordinate needs one")
            columns.append(_numbers(table[coordinate], f"{name}[{coordinate}]"))
    columns.append(_numbers(time, "time"))
    try:
        flat = [np.array(c) for c in np.broadcast_arrays(*columns)]
    except ValueError:
        raise InvalidInputError("two_point: the arrays of q0, q1 and time have different lengths") from None
    if flat[0].ndim != 1:
        raise InvalidInputError("two_point: arrays of one dimension are needed")
    if not np.all(flat[-1] > 0):
        raise InvalidInputError("time: every time is positive (to go back in time exchange q0 and q1)")
    n = len(attraction.names)
    return flat[:n], flat[n : 2 * n], flat[-1]


def _numbers(x: object, source: str) -> Reals:
    try:
        column = np.asarray(x, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{source}: in arrays only numbers are taken, not {arguments.described(x)}") from None
    if not np.all(np.isfinite(column)):
        raise InvalidInputError(f"{source}: a number is not finite")
    return column


def _estimates(column: Column) -> EstimateArray:
    return EstimateArray(column.value, column.error)
