"""What ``ensemble(actions=…, angles=…, want={"state"})`` does: read the arrays, run the tori, give a batch."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from hjsolve import arguments
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.initial_conditions import arrays_of
from hjsolve.ensembles.layout import ERROR, RECOMPUTED, STATUS, Layout
from hjsolve.ensembles.to_states.from_actions import InverseTask, states_of
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.initial_data import parameter_values
from hjsolve.motion.tori.from_actions import names_of_actions
from hjsolve.precision import shared_libraries
from hjsolve.solution.quadratures import Solution

_KINDS = ("libration", "rotation")


def batch_of_states(
    solution: Solution, *, actions: Mapping[str, Any], angles: Mapping[str, Any] | None,
    kinds: Mapping[str, str] | None, want: Any, parameters: Mapping[str, Any] | None, fallback: bool,
) -> Batch:  # fmt: skip
    """Return the states of many orbits from their actions and angles.

    Args:
        solution: of the system.
        actions: every coordinate that has one → array of J, any shape; arrays broadcast.
        angles: the same names → θ in radians; 0 where left out.
        kinds: separated coordinate → libration or rotation, of all orbits.
        want: ``"state"`` or None.
        parameters: name → number, where it differs from the default.
        fallback: whether what the engine hands back goes to single motions.

    Raises:
        InvalidInputError: an unknown name, arrays of no real numbers, lazy ones, found coordinates, something else
            wanted, or a coordinate that may librate or rotate with the same actions.
        MissingValueError: an action or a parameter without a value.
    """
    if solution.chart is not None:
        raise InvalidInputError(
            "actions: not with coordinates that were found; give the system in them, solution.system"
        )
    refuse_kinks(solution.system.kinks, "actions=")
    words = {"state"} if want is None else set(arguments.words(want, "want", '["state"]'))
    if words != {"state"}:
        raise InvalidInputError('want: from actions "state" is computed; for more give its q and p to a second call')
    names = names_of_actions(solution)
    given, shape = arrays_of({"actions": actions, "angles": angles or {}}, names)
    chosen = dict(arguments.table(kinds or {}, "kinds", '{"theta": "libration"}'))
    for name, kind in chosen.items():
        if name not in solution.coordinates or kind not in _KINDS:
            raise InvalidInputError(
                f"kinds[{name}]: a separated coordinate ({', '.join(solution.coordinates)}) and one of "
                f"{', '.join(_KINDS)} are needed"
            )
    parameter_values(solution.system, dict(parameters or {}))
    n = math.prod(shape)

    def rows(group: str) -> Any:
        return np.stack([np.broadcast_to(given[group].get(name, 0.0), shape).reshape(n) for name in names])

    task = InverseTask(
        solution, tuple(names), rows("actions"), rows("angles"), chosen, dict(parameters or {}), fallback
    )  # fmt: skip
    with shared_libraries:
        found = states_of(task)
    columns: dict[str, Any] = {STATUS: found.status, RECOMPUTED: found.recomputed}
    for name in found.q:
        columns |= {f"q.{name}": found.q[name], f"p.{name}": found.p[name]}
        columns |= {f"{ERROR}q.{name}": found.q_errors[name], f"{ERROR}p.{name}": found.p_errors[name]}
    layout = Layout({"q": tuple(found.q), "p": tuple(found.p)}, solution if solution.system.declared_units else None)
    return Batch({name: column.reshape(shape) for name, column in columns.items()}, layout, shape)
