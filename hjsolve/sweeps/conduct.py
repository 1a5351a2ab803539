"""sweep(): the orbits that a scene declares, part by part into a folder, on threads or on a cluster."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from hjsolve import arguments
from hjsolve.display.progress import ProgressBar, Tally
from hjsolve.display.shown import Shown
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.layout import wanted
from hjsolve.ensembles.orbits import task_for
from hjsolve.ensembles.states_from_actions import task_of_tori
from hjsolve.errors import MissingExtraError, required
from hjsolve.scenes import Scene
from hjsolve.solution.quadratures import solve
from hjsolve.sweeps.identity import code, sweep_digest
from hjsolve.sweeps.points import points_of
from hjsolve.sweeps.work import SweepTask, SweepWork, columns_of


@dataclass(frozen=True, repr=False)
class SweepResult(Shown):
    """A sweep that is complete.

    Attributes:
        path: the folder; ``pyarrow.dataset.dataset(path)`` reads it as one table.
        orbits: in all.
        parts: files.
        kept: of these, how many an earlier run had written.
        statuses: word → orbits, as ``Batch.summary``.
        notes: what was amiss in the folder and was mended, and what is to be known of the orbits; a sentence each.
    """

    path: Path
    orbits: int
    parts: int
    kept: int
    statuses: Mapping[str, int]
    notes: tuple[str, ...] = ()


@arguments.with_known_names('sweep("scene.toml", "results", threads=2)')
def sweep(
    scene: Scene | str | Path | Mapping[str, object],
    out: str | Path,
    *,
    threads: int | None = None,
    scheduler: str | None = None,
    chunk: int | None = None,
    shown: bool | None = None,
    verify: bool = False,
) -> SweepResult:
    """Compute the orbits that the table ``[sweep]`` of a scene declares into a folder of Parquet files.

    Call it again with the same arguments to resume a run that was killed, whenever it was. Parts whose bytes have the
    digest that was noted when they were written stay, the others are computed, and the data are those of an undisturbed
    run, byte for byte. What was amiss is said in ``notes``.

    Args:
        scene: a scene, its table or its file; docs/ensembles.md describes ``[sweep]``.
        out: the folder, e.g. ``orbits.parquet``; made where it is missing.
        threads: how many; None for all cores that this process may use.
        scheduler: address of a dask scheduler, ``tcp://…``; its workers compute, this process writes.
        chunk: orbits of one part; None for what the scene says. Belongs to the sweep: the same on every run.
        shown: whether progress is shown on standard error; None: on a terminal.
        verify: compute and write nothing; examine every part of a finished sweep.

    Returns:
        What was written, or with ``verify`` what is there.

    Raises:
        InvalidInputError: the scene declares no sweep, the folder holds another one or what belongs to none, or the
            scheduler is not there. With ``verify``: a part is missing or is not what was written; all are listed.
        NotSeparableError: the system does not separate.
        ClusterError: the scheduler was lost, or an orbit kills every worker; the parts written so far stay.
        MissingExtraError: pyarrow, or for a cluster distributed, is not installed.

    Example:
        >>> sweep("orbits.toml", "orbits.parquet").statuses  # doctest: +SKIP
        {'ok': 100000}
    """
    try:
        from hjsolve.sweeps.folder import SweepPlan, opened, verified
    except ImportError as error:
        raise MissingExtraError('a sweep writes Parquet and needs pyarrow: pip install "hjsolve[cluster]"') from error
    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    points, table = points_of(scene)
    size = (None if chunk is None else arguments.whole(chunk, "chunk", 1)) or scene.sweep.chunk  # type: ignore[union-attr] # points_of has seen it
    plan = SweepPlan(sweep_digest(scene, table, size), code(), points.count, size, scene.title)
    if verify:
        statuses = verified(Path(out), plan)
        return SweepResult(Path(out), points.count, plan.parts, plan.parts, statuses, _on_failures(statuses))
    task = _task(scene, points.kind)
    with opened(Path(out), plan) as folder:
        left = folder.left()
        if left:
            folder.begin()
        done = points.count - sum(end - begin for begin, end in map(plan.window, left))
        with ProgressBar(stays=True, shown=shown) as progress:
            work = SweepWork(task, points, folder, tuple(left), Tally(points.count, done, progress))
            if scheduler is None:
                _on_threads(work, threads)
            else:
                from hjsolve.sweeps.cluster import on_cluster

                on_cluster(work, scheduler)
        statuses = folder.finish()
        notes = (*folder.notes, *(f"{fault}; it was computed again" for fault in folder.bad), *_on_failures(statuses))
        return SweepResult(folder.path, points.count, plan.parts, plan.parts - len(left), statuses, notes)


def _task(scene: Scene, kind: str) -> SweepTask:
    solution, parameters = solve(scene.system, scene.coordinates), dict(scene.parameters)
    if kind == "angles":
        sweep = required(scene.sweep)
        return task_of_tori(solution, sweep.kinds, parameters, wells={n: float(x) for n, x in sweep.wells.items()})
    return task_for(solution, wanted(scene.want), parameters, kind, frame=scene.velocity_frame)


def _on_failures(statuses: Mapping[str, int]) -> tuple[str, ...]:
    """Return the commonest reason, where more than half of the orbits are not ok."""
    words = {status: statuses.get(status.word, 0) for status in Status}
    total, failed = sum(words.values()), sum(count for status, count in words.items() if status is not Status.OK)
    if 2 * failed <= total:
        return ()
    common = max((status for status in Status if status is not Status.OK), key=lambda status: words[status])
    return (
        f"{failed} of {total} orbits are not ok; {words[common]} of them are {common.word} ({common.meaning}): check "
        "the units and the columns of the initial conditions",
    )


def _on_threads(work: SweepWork, threads: int | None) -> None:
    for part in work.left:
        starts = work.starts(part)
        work.keep(part, starts, columns_of(work.task, starts, threads))
