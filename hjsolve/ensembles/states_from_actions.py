"""What ``ensemble(actions=…, angles=…, want={"state"})`` does: read the arrays, run the tori, give a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hjsolve import arguments
from hjsolve.coordinates.chart import Chart
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.compute import Columns, cores
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.initial_conditions import arrays_of, is_dask
from hjsolve.ensembles.layout import ERROR, RECOMPUTED, STATUS, Layout
from hjsolve.ensembles.to_states.from_actions import FoundStates, InverseTask, states_of
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.charted.state_map import state_in
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.state import Errors, State
from hjsolve.motion.tori.from_actions import kinds_given, names_of_actions
from hjsolve.precision import shared_libraries
from hjsolve.solution.quadratures import Solution


def batch_of_states(
    solution: Solution, *, actions: Mapping[str, object], angles: Mapping[str, object] | None,
    q: Mapping[str, object] | None, kinds: Mapping[str, str] | None, want: object,
    parameters: Mapping[str, object] | None, fallback: bool,
    threads: int | None = None,
) -> Batch:  # fmt: skip
    """Return the states of many orbits from their actions and angles.

    Args:
        actions: every coordinate that has one (of the separated ones where they were found) → array of J, any shape;
            arrays broadcast. Dask arrays make the result lazy, one task a block.
        angles: the same names → θ in radians; 0 where left out.
        q: coordinate → a place in the well that is meant, as an array.
        kinds: separated coordinate → libration or rotation, of all orbits.
        want: ``"state"`` or None.
        parameters: name → number, where it differs from the default.
        fallback: whether what the engine hands back goes to single motions.
        threads: how many; None for the cores that this process may use.

    Raises:
        InvalidInputError: an unknown name, arrays of no real numbers, something else wanted, or a coordinate that may
            librate or rotate with the same actions.
        MissingValueError: an action or a parameter without a value.
    """
    words = {"state"} if want is None else set(arguments.words(want, "want", '["state"]'))
    if words != {"state"}:
        raise InvalidInputError('want: from actions "state" is computed; for more give its q and p to a second call')
    task = task_of_tori(solution, kinds, parameters, fallback=fallback)
    names = list(task.names)
    given, shape = arrays_of({"actions": actions, "angles": angles or {}, "q": q or {}}, names)
    lazy = any(is_dask(array) for group in given.values() for array in group.values())
    inputs = [given[group].get(name, np.zeros(())) for group in ("actions", "angles") for name in names]
    inputs += given["q"].values()
    task = replace(task, wells=dict.fromkeys(given["q"], np.empty(0)))
    own = solution.system_as_given
    coordinates = tuple(c.name for c in own.coordinates)
    layout = Layout({"q": coordinates, "p": coordinates}, solution if own.declared_units else None)
    if lazy:
        from hjsolve.ensembles.dask_blocks import by_blocks

        return by_blocks(partial(state_columns, task), inputs, layout, shape)
    task = replace(task, threads=cores() if threads is None else arguments.whole(threads, "threads", 1))
    columns = state_columns(task, [np.broadcast_to(array, shape).reshape(-1) for array in inputs])
    return Batch({name: column.reshape(shape) for name, column in columns.items()}, layout, shape)


def task_of_tori(
    solution: Solution, kinds: Mapping[str, str] | None, parameters: Mapping[str, Any] | None, *, fallback: bool = True,
    wells: Mapping[str, float] | None = None,
) -> InverseTask:  # fmt: skip
    """Write the task of states on tori, without actions and angles yet.

    Args:
        kinds: separated coordinate → libration or rotation, of all orbits.
        parameters: name → number, where it differs from the default.
        fallback: whether what the engine hands back goes to single motions.
        wells: coordinate → a place in the well that is meant, of all orbits.

    Raises:
        InvalidInputError: kinks of V, a coordinate that never comes back, an unknown kind, or well of no coordinate.
        MissingValueError: a parameter without a value.
    """
    refuse_kinks(solution.system.kinks, "actions=")
    names = names_of_actions(solution)
    chosen = kinds_given(solution, kinds or {})
    parameter_values(solution.system, dict(parameters or {}))
    none = np.empty((len(names), 0))
    separated = replace(solution, chart=None)
    if unknown := set(wells or {}).difference(names):
        raise InvalidInputError(f"wells: {', '.join(sorted(unknown))}: known are {', '.join(names)}")
    places = {name: np.asarray(float(x)) for name, x in (wells or {}).items()}
    return InverseTask(
        separated, tuple(names), none, none, chosen, dict(parameters or {}), fallback, solution.chart, places
    )  # fmt: skip


def state_columns(task: InverseTask, inputs: Sequence[NDArray[np.generic]]) -> Columns:
    """Return the columns of orbits.

    Args:
        inputs: actions, angles, both in the order of the task's names, and places in wells where orbits have
            their own; each of shape (n,).
    """
    size = len(task.names)
    actions, angles = (np.stack(group).astype(float) for group in (inputs[:size], inputs[size : 2 * size]))
    places = inputs[2 * size :] or list(task.wells.values())
    wells = {
        name: np.broadcast_to(np.asarray(x, dtype=float), actions.shape[1])
        for name, x in zip(task.wells, places, strict=True)
    }
    found = states_of(replace(task, actions=actions, angles=angles, wells=wells))
    if task.chart is not None:
        with shared_libraries:
            found = carried_back(task, task.chart, found)
    columns: Columns = {STATUS: found.status, RECOMPUTED: found.recomputed}
    columns |= {f"q.{name}": x for name, x in found.q.items()} | {f"p.{name}": x for name, x in found.p.items()}
    columns |= {f"{ERROR}q.{name}": x for name, x in found.q_errors.items()}
    return columns | {f"{ERROR}p.{name}": x for name, x in found.p_errors.items()}


def carried_back(task: InverseTask, chart: Chart, found: FoundStates) -> FoundStates:
    """Return states in the user's coordinates; not converged where the map to them loses all digits, as on an axis.

    Args:
        task: what was wanted, in the separated coordinates.
        chart: from these to the user's.
    """
    values = parameter_values(task.solution.system, task.parameters)
    state = State(
        0, found.q, found.p, {}, {}, np.where(found.status == Status.OK, "ok", "not_converged"),
        lambda: Errors(found.q_errors, found.p_errors, {}),
    )  # fmt: skip
    there = state_in(chart, values, state)
    groups = there.q, there.p, there.error.q, there.error.p
    q, p, dq, dp = ({name: np.array(row, dtype=float) for name, row in group.items()} for group in groups)
    rows = np.stack([*q.values(), *p.values(), *dq.values(), *dp.values()])
    fine = (found.status == Status.OK) & np.isfinite(rows).all(axis=0)
    for group in (q, p, dq, dp):
        for row in group.values():
            row[~fine] = np.nan
    status = np.where((found.status == Status.OK) & ~fine, Status.NOT_CONVERGED, found.status)
    return FoundStates(q, p, dq, dp, status.astype(np.int8), found.recomputed)
