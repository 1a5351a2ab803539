"""States of n tori in coordinates that were found, carried back to the user's own (``motion.charted.state_map``)."""

from __future__ import annotations

import numpy as np

from hjsolve.coordinates.chart import Chart
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.to_states.from_actions import FoundStates, InverseTask
from hjsolve.motion.charted.state_map import state_in
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.state import Errors, State


def carried_back(task: InverseTask, chart: Chart, found: FoundStates) -> FoundStates:
    """Return states in the user's coordinates; not converged where the map to them loses all digits, as on an axis.

    Args:
        task: what was wanted, in the separated coordinates.
        chart: from these to the user's.
        found: the states.
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
