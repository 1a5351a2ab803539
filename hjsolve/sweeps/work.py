"""What is left to do of a sweep, and the columns of one of its parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hjsolve.arithmetic.number_types import Columns, Reals
from hjsolve.display.progress import Tally
from hjsolve.ensembles.compute import compute_columns
from hjsolve.ensembles.states_from_actions import state_columns
from hjsolve.ensembles.task import EnsembleTask
from hjsolve.ensembles.to_states.from_actions import InverseTask
from hjsolve.scenes.initial_grid import TORI
from hjsolve.sweeps.points import SweepPoints

if TYPE_CHECKING:
    from hjsolve.sweeps.folder import Folder


SweepTask = EnsembleTask | InverseTask


@dataclass(frozen=True, eq=False)
class SweepWork:
    """What is left to do, and how; passed to whoever conducts it."""

    task: SweepTask
    points: SweepPoints
    folder: Folder
    left: tuple[int, ...]
    tally: Tally

    @property
    def names(self) -> list[str]:
        """The coordinates."""
        system = self.task.solution.system if isinstance(self.task, InverseTask) else self.task.system
        return [c.name for c in system.coordinates]

    def starts(self, part: int) -> dict[str, Reals]:
        """Return the initial conditions of a part.

        Args:
            part: its number, from 0 on.
        """
        return self.points.window(self.names, *self.folder.plan.window(part))

    def keep(self, part: int, starts: Columns, columns: Columns) -> None:
        """Write a part that is done.

        Args:
            part: its number, from 0 on.
            starts: initial conditions, name → array of shape (n,).
            columns: results, name → array of shape (n,).
        """
        begin, end = self.folder.plan.window(part)
        self.folder.write(part, starts, columns, self.points.kept(begin, end))
        self.tally.add(end - begin)


def columns_of(task: SweepTask, starts: Columns, threads: int | None) -> Columns:
    """Return the columns of a part; runs here or on a worker.

    Args:
        task: what is to be computed of each orbit.
        starts: initial conditions, name → array of shape (n,).
        threads: at most; None for as many as there are cores.
    """
    if isinstance(task, InverseTask):
        return state_columns(task, [starts[f"{group}.{name}"] for group in TORI for name in task.names])
    names = [c.name for c in task.system.coordinates]
    q, rates = ([starts[f"{group}.{name}"] for name in names] for group in ("q", task.kind))
    return compute_columns(task, q, rates, threads=threads)
