"""States of n orbits from actions and angles: seeds, constants, states; what is left over goes to single motions.

Units in which tori with small or large actions have numbers of order one: a coordinate is as long as makes p q of the
order of the action: where p² without constants, U(q), is 2^f at q = 2^e, e is the solution of e + f/2 = A. In a core,
where U is kept as a difference (``arithmetic.block_exponents``), f = 2e.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from hjsolve.arithmetic.block_exponents import NOTHING, Unit, tape_in_units, unit_of
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.coordinates.chart import Chart
from hjsolve.ensembles.engine.lowered_solution import Model, Separated, lowered_model, next_to_poles
from hjsolve.ensembles.engine.programs import system_programs
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.engine.units_of_orbits import LARGE_BITS, UnitsOfOrbits, model_in_units, rounded_exponents
from hjsolve.ensembles.to_states.narrow_tori import narrow_librations
from hjsolve.ensembles.to_states.newton_on_actions import Asked, Solved
from hjsolve.ensembles.to_states.other_wells import in_the_wells_meant
from hjsolve.ensembles.to_states.places_on_tori import frames_of
from hjsolve.ensembles.to_states.searches import found_again, found_from_seeds
from hjsolve.ensembles.to_states.seeds import Scales, Seeds, seeds_of
from hjsolve.ensembles.to_states.states_on_tori import StatesOnTori, states_at
from hjsolve.ensembles.to_states.tori import AngleTask, unknown_of
from hjsolve.ensembles.to_states.wells import Landscape
from hjsolve.errors import InvalidInputError, NotConvergedError, SeveralToriError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.tori.radicand_curve import curves_of
from hjsolve.precision import shared_libraries
from hjsolve.solution.quadratures import Solution

_FARTHEST_EXPONENT = 1000
"""Of the length of a coordinate."""

_CHUNK, _LEAST_CHUNK = 32768, 8192
"""Orbits that one thread treats at a time: half of them, for two threads, but not fewer than the second number."""
_NEAR_UNIT = 2.0**8
"""How far from a length of its own, by what factor, a coordinate is looked for."""
_TOLERANCE, _OF_PLACE = 1e-6, 2.0**-40
"""Largest claimed error of q, over the width of its motion or over q itself, with which a state is kept."""

Rows = dict[str, Reals]
_Pattern = tuple[bool, ...]


@dataclass(frozen=True)
class InverseTask:
    """Actions and angles of n orbits.

    Attributes:
        solution: of the system.
        names: coordinates that have an action.
        actions, angles: shape (names, n).
        kinds: separated coordinate → libration or rotation, where it is told.
        parameters: name → number.
        fallback: whether what is left over goes to single motions.
        chart: from the separated coordinates, in which all of this is, to the user's; None where they are his.
        wells: coordinate → a place in the well that is meant, shape (n,).
        threads: how many work on chunks; the result does not depend on it.
    """

    solution: Solution
    names: tuple[str, ...]
    actions: Reals
    angles: Reals
    kinds: Mapping[str, str]
    parameters: Mapping[str, Any]
    fallback: bool
    chart: Chart | None = None
    wells: Mapping[str, Reals] = field(default_factory=dict)
    threads: int = 1


@dataclass(frozen=True)
class FoundStates:
    """States: coordinate → array (n,), their errors, the status of every orbit, and which a single motion computed."""

    q: Rows
    p: Rows
    q_errors: Rows
    p_errors: Rows
    status: Any
    recomputed: Mask


def states_of(task: InverseTask) -> FoundStates:
    """Return the states of n orbits."""
    found = _none(task)
    finite = np.isfinite(task.actions).all(axis=0) & np.isfinite(task.angles).all(axis=0)
    found.status[~finite] = Status.NOT_FINITE
    with shared_libraries:
        near = next_to_poles(task.solution)
    for one in (task, *([] if near is None else [replace(task, solution=near)])):
        left = np.flatnonzero(finite & _open(found.status))
        known = _lowered(one) if len(left) else None
        if known is not None:
            with shared_libraries:
                ready = _ready(one, known[0], _scales(one, known[1]), np.flatnonzero(finite))
            _in_chunks(one, ready, found, left)
    _in_their_own_units(task, found, np.flatnonzero(finite & _open(found.status)))
    if task.fallback:
        for k in np.flatnonzero(finite & _open(found.status)):
            with shared_libraries:
                _one(task, found, int(k))
    return found


def _in_chunks(task: InverseTask, ready: _Ready, found: FoundStates, index: Integers) -> None:
    """Return the states of some orbits, chunk by chunk: which orbits are in one does not depend on the threads."""
    size = min(_CHUNK, max(len(index) // 2, _LEAST_CHUNK))
    chunks = [index[begin : begin + size] for begin in range(0, len(index), max(size, 1))]
    if min(task.threads, len(chunks)) <= 1:
        for chunk in chunks:
            _chunk(task, ready, found, chunk)
        return
    with ThreadPoolExecutor(min(task.threads, len(chunks))) as pool:
        try:
            for _ in pool.map(partial(_chunk, task, ready, found), chunks):
                pass
        finally:  # after an error, or the user's Ctrl-C, what has not begun need not begin
            pool.shutdown(wait=True, cancel_futures=True)


def _open(status: Integers) -> Mask:
    """Return which orbits have no state and no reason yet why they have none."""
    return np.asarray((status != Status.OK) & (status != Status.AMBIGUOUS))


def _none(task: InverseTask) -> FoundStates:
    n = task.actions.shape[1]
    coordinates = [c.name for c in task.solution.system.coordinates]
    q, p, dq, dp = ({name: np.full(n, np.nan) for name in coordinates} for _ in range(4))
    return FoundStates(q, p, dq, dp, np.full(n, Status.NOT_CONVERGED, dtype=np.int8), np.zeros(n, dtype=bool))


def _in_their_own_units(task: InverseTask, found: FoundStates, left: Integers) -> None:
    """Find tori whose actions are far from 1 in units in which they are not (``engine.units_of_orbits``)."""
    known = _lowered(task) if len(left) else None
    if known is None:
        return
    with shared_libraries:
        model, scales = known[0], _scales(task, known[1])
    with np.errstate(divide="ignore"):
        sizes = np.log2(np.abs(task.actions[:, left]).max(axis=0))
    kinds = rounded_exponents(np.where(np.isfinite(sizes), sizes, 0.0))
    for action in np.unique(kinds[(kinds < 0) | (kinds > LARGE_BITS)]):
        index = left[kinds == action]
        with shared_libraries:
            units = units_of_tori(task.solution, model, int(action))
        actions, angles = np.ldexp(task.actions[:, index], -units.action), task.angles[:, index]
        lengths_of = dict(zip(model.names, units.places, strict=True))
        wells = {name: np.ldexp(places[index], -lengths_of[name]) for name, places in task.wells.items()}
        one = replace(task, actions=actions, angles=angles, wells=wells)
        part, everything = _none(one), np.arange(len(index))
        lengths = [units.places[c.index] for c in model.separated]
        near = [_near_one(scale) if e else scale for scale, e in zip(scales, lengths, strict=True)]
        with shared_libraries:
            ready = _ready(one, model_in_units(model, units).model, near, everything)
        _in_chunks(one, ready, part, everything)
        solved = np.flatnonzero(part.status == Status.OK)
        for name, place, momentum in zip(model.names, units.places, units.momenta, strict=True):
            for old, new, e in (
                (found.q, part.q, place), (found.q_errors, part.q_errors, place),
                (found.p, part.p, momentum), (found.p_errors, part.p_errors, momentum),
            ):  # fmt: skip
                old[name][index[solved]] = np.ldexp(new[name][solved], e)
        found.status[index[solved]] = Status.OK


class _Ready(NamedTuple):
    """What all orbits share.

    Attributes:
        angles: the system.
        seeds: tori to begin from.
        landscape: where other wells are looked for.
        own, others: rows of the separated and of the ignorable coordinates among all actions.
    """

    angles: AngleTask
    seeds: Seeds
    landscape: Landscape
    own: list[int]
    others: list[int]


def _lowered(task: InverseTask) -> tuple[Model, Mapping[sp.Symbol, sp.Expr]] | None:
    """Return the lowered solution with the parameters; None for systems that are left to single motions."""
    with shared_libraries:
        values = parameter_values(task.solution.system, task.parameters)
        model = lowered_model(task.solution, values)
    if not model.separated or any(c.shifted or c.repeats for c in model.separated) or task.solution.system.kinks:
        return None
    return model, values


def _scales(task: InverseTask, values: Mapping[sp.Symbol, sp.Expr]) -> list[Scales]:
    return [Scales(curve.samples(), bool(curve.turn)) for curve in curves_of(task.solution, values, {})]


def _near_one(scales: Scales) -> Scales:
    sizes = np.abs(scales.places)
    return Scales(scales.places[(sizes > 1 / _NEAR_UNIT) & (sizes < _NEAR_UNIT)], scales.turns)


def _ready(task: InverseTask, model: Model, scales: list[Scales], finite: Integers) -> _Ready:
    """Prepare the engine."""
    rows = {name: k for k, name in enumerate(task.names)}
    own, others = [rows[c.name] for c in model.separated], [rows[name] for name in model.angles]
    programs = system_programs(model, kernels=True)
    wanted = task.actions[:, finite]
    seeds = seeds_of(model, programs, scales, (wanted[own], wanted[others]))
    landscape = Landscape.of(model, programs, [scale.places for scale in scales], seeds.tori)
    return _Ready(AngleTask(model, programs), seeds, landscape, own, others)


def _chunk(task: InverseTask, ready: _Ready, found: FoundStates, index: Integers) -> None:
    """Return the states of some orbits by the engine, as far as it goes."""
    model, seeds = ready.angles.model, ready.seeds
    J, momenta = task.actions[ready.own][:, index], task.actions[ready.others][:, index]
    kinds = [task.kinds.get(c.name, "") for c in model.separated]
    patterns = [tuple(bool(x) for x in column) for column in np.unique(seeds.shells.rotations.T, axis=0)]
    told = [one for one in patterns if all(k in ("", _word(x)) for k, x in zip(kinds, one, strict=True))]
    searches, none = [], np.ones(len(index), dtype=bool)
    for pattern in told:
        some = np.flatnonzero(_possible(J, pattern))
        if len(some):
            mine = seeds.take((seeds.shells.rotations == np.array(pattern)[:, None]).all(axis=0))
            hints = _hints(task, model, index[some])
            wanted = Asked.of(model, J[:, some], momenta[:, some], pattern, hints)
            found_ = found_from_seeds(ready.angles, mine, wanted, everyone=len(told) == 1)
            one = _Search(pattern, some, mine, wanted, *found_)
            found_again(ready.angles, mine, wanted, one.solved, one.sought)
            searches.append(one)
            none[some[one.solved.good]] = False
    done, ambiguous = (np.zeros(len(index), dtype=bool) for _ in range(2))
    for one in searches:
        some, solved = one.orbits, one.solved
        # an orbit that no kind of motion has next to others is sought among all
        found_again(ready.angles, one.seeds, one.wanted, solved, none[some] & ~one.sought)
        several = in_the_wells_meant(ready.landscape, one.seeds, solved, one.wanted)
        twice = several | (solved.good & done[some])
        ambiguous[some[twice]] = True
        done[some[solved.good]] = True
        solved.good[twice] = False
        _written(task, found, ready.angles, (index[some], one.pattern), solved)
    _withdrawn(found, index[ambiguous])


class _Search(NamedTuple):
    """A search for tori of one kind of motion.

    Attributes:
        pattern: which coordinates go round.
        orbits: whose actions such a torus may have, shape (n,).
        seeds: of this kind.
        wanted: actions.
        solved: the tori found.
        sought: which were looked for.
    """

    pattern: _Pattern
    orbits: Integers
    seeds: Seeds
    wanted: Asked
    solved: Solved
    sought: Mask


def _hints(task: InverseTask, model: Model, index: Integers) -> Reals:
    """Return places in the wells that are meant, shape (separated, n); NaN where none is given."""
    none = np.full(len(index), np.nan)
    return np.stack([task.wells[c.name][index] if c.name in task.wells else none for c in model.separated])


def _withdrawn(found: FoundStates, index: Integers) -> None:
    """Take states back of orbits that may librate or rotate with the same actions."""
    for group in (found.q, found.p, found.q_errors, found.p_errors):
        for column in group.values():
            column[index] = np.nan
    found.status[index] = Status.AMBIGUOUS


def _word(rotates: bool) -> str:
    return "rotation" if rotates else "libration"


def _possible(J: Reals, pattern: tuple[bool, ...]) -> Mask:
    """Librations have no negative J, rotations none that is zero."""
    fine = np.ones(J.shape[1], dtype=bool)
    for row, rotates in zip(J, pattern, strict=True):
        fine &= (row != 0) if rotates else (row >= 0)
    return fine


def _written(
    task: InverseTask,
    found: FoundStates,
    angle_task: AngleTask,
    which: tuple[Integers, _Pattern],
    solved: Solved,
) -> None:
    """Write the states on tori that were found."""
    (index, pattern), model = which, angle_task.model
    good = np.flatnonzero(solved.good)
    if not len(good):
        return
    index, tori = index[good], solved.tori.take(good)
    rows = {name: k for k, name in enumerate(task.names)}
    own, others = [rows[c.name] for c in model.separated], [rows[name] for name in model.angles]
    J = task.actions[own][:, index]
    rotating = np.broadcast_to(np.array(pattern)[:, None], J.shape)
    directions = np.where(rotating & (J < 0), -1.0, 1.0)
    unknown = unknown_of(solved.actions.slopes[:, :, good], tori.values)
    narrow = narrow_librations(angle_task, tori, np.abs(J), unknown, ~rotating)
    frames = frames_of(angle_task, tori, directions, rotating, J == 0, narrow.rows)
    spread = solved.actions.errors[:, good] + np.abs(solved.actions.values[:, good] - np.abs(J)) + unknown
    spread = np.where(J == 0, 0.0, np.where(np.isfinite(narrow.errors), narrow.errors, spread))
    angles = task.angles[own][:, index], task.angles[others][:, index]
    states = states_at(angle_task, tori, frames, angles, (solved.actions.values[:, good], spread))
    wide = np.where(frames.widths > 0, frames.widths, 1.0)
    # a narrow motion may be hardly wider than the rounding of q
    fine = states.good & (states.q_errors <= np.fmax(_TOLERANCE * wide, _OF_PLACE * np.abs(states.q))).all(axis=0)
    for k, (coordinate, hints) in enumerate(zip(model.separated, _hints(task, model, index), strict=True)):
        if coordinate.periodic:
            # a libration about the place that is told, or about 0
            middle = states.q[k] if rotating[k].all() else tori.q[k] - np.where(np.isnan(hints), 0.0, hints)
            turns = np.rint(middle / (2 * np.pi))
            states.q[k] -= 2 * np.pi * turns
            states.q_errors[k] += 4 * EPS * np.abs(2 * np.pi * turns)
    _put(task, found, angle_task, (index[fine], fine), states)


def _put(
    task: InverseTask, found: FoundStates, angle_task: AngleTask, which: tuple[Integers, Mask], states: StatesOnTori
) -> None:
    (index, fine), model = which, angle_task.model
    for k, coordinate in enumerate(model.separated):
        name = coordinate.name
        found.q[name][index], found.p[name][index] = states.q[k, fine], states.P[k, fine]
        found.q_errors[name][index], found.p_errors[name][index] = states.q_errors[k, fine], states.P_errors[k, fine]
    for k, name in enumerate(model.angles):
        found.q[name][index], found.q_errors[name][index] = states.angles[k, fine], states.angle_errors[k, fine]
        found.p[name][index] = task.actions[task.names.index(name)][index]
        found.p_errors[name][index] = 0.0
    found.status[index] = Status.OK


def _one(task: InverseTask, found: FoundStates, k: int) -> None:
    """One orbit by a single motion."""
    actions, angles = (
        {name: float(rows[j, k]) for j, name in enumerate(task.names)} for rows in (task.actions, task.angles)
    )
    found.recomputed[k] = True
    try:
        motion = task.solution.motion(
            actions=actions, angles=angles, kinds=dict(task.kinds), parameters=dict(task.parameters),
            q={name: float(places[k]) for name, places in task.wells.items()},
        )  # fmt: skip
        state = motion.at(0)
    except SeveralToriError:
        found.status[k] = Status.AMBIGUOUS
        return
    except InvalidInputError:
        found.status[k] = Status.FORBIDDEN
        return
    except NotConvergedError:
        found.status[k] = Status.NOT_CONVERGED
        return
    for name in found.q:
        found.q[name][k], found.p[name][k] = float(state.q[name]), float(state.p[name])
        found.q_errors[name][k], found.p_errors[name][k] = float(state.error.q[name]), float(state.error.p[name])
    found.status[k] = Status.OK


def units_of_tori(solution: Solution, model: Model, action: int) -> UnitsOfOrbits:
    """Return units for tori.

    Args:
        solution: of the system.
        model: the same, lowered.
        action: exponent of the largest action, about.
    """
    places = [0] * len(model.names)
    for one in model.separated:
        if not one.periodic and _grows_from_zero(solution.system.coordinate(one.name)):
            places[one.index] = _length(one, model, action)
    return UnitsOfOrbits(tuple(places), action)


def _grows_from_zero(coordinate: Coordinate) -> bool:
    """Return whether the domain is a line or a half of it, which every unit leaves as it is."""
    ends = [end for end in (coordinate.domain.lower, coordinate.domain.upper) if end is not None]
    return len(ends) < 2 and all(end == 0 for end in ends)


def _length(one: Separated, model: Model, action: int) -> int:
    """Return the exponent of a coordinate's length; 0 where there is none."""
    constants = [Unit(NOTHING)] * len(model.constants)
    own = [unit_of(pair) for pair in model.numbers]

    def too_short(e: int) -> bool:
        (f,) = tape_in_units(one.plain.squared, [Unit(e), *constants, *own]).exponents
        return 2 * e + f < 2 * action

    low, high = -_FARTHEST_EXPONENT, _FARTHEST_EXPONENT
    if not too_short(low) or too_short(high):
        return 0
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if too_short(middle) else (low, middle)
    return high
