"""The work of an ensemble: arrays of starts in, columns out, chunk by chunk, on as many threads as there are cores."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from hjsolve.ensembles.charted import run_charted
from hjsolve.ensembles.engine.status import ENDLESS, Status
from hjsolve.ensembles.layout import ERROR, RECOMPUTED, STATUS, Layout
from hjsolve.ensembles.task import EnsembleTask, TaskContext, tools_of
from hjsolve.motion.velocity_frame import COORDINATE

CHUNK = 65536
"""Orbits that one thread treats at a time: passes for few hard orbits cost less together."""

_FEWEST = 1024
"""Orbits of a chunk: at some 3 µs each they take longer than the 0.5 ms of Python that a chunk costs."""
_ROOM = 31 << 20
"""Bytes, just below the 32 MB up to which the C library raises its limit."""

Columns = dict[str, Any]


def dtypes(layout: Layout) -> dict[str, np.dtype[Any]]:
    """Return the type of every column.

    Args:
        layout: names of the columns.
    """
    return {STATUS: np.dtype(np.int8), RECOMPUTED: np.dtype(np.bool_)} | dict.fromkeys(
        layout.numbers(), np.dtype(np.float64)
    )


def compute_columns(
    task: EnsembleTask, q: list[Any], rates: list[Any], *, threads: int | None = None,
    done: Callable[[int], None] = lambda _: None,
) -> Columns:  # fmt: skip
    """Compute the columns of n orbits.

    Args:
        task: what to compute.
        q, rates: for every coordinate of the system, in its order, an array of shape (n,).
        threads: how many; None for the cores that this process may use. The result does not depend on it.
        done: told how many more orbits are done, by any of the threads.

    Returns:
        Column name → array of shape (n,).
    """
    _keep_memory()
    n, tools = len(q[0]), tools_of(task)
    columns: Columns = {name: _empty(n, dtype) for name, dtype in dtypes(tools.layout).items()}

    stop = threading.Event()

    def part(window: slice) -> None:
        _fill(task, tools, columns, window, [x[window] for x in q], [x[window] for x in rates], stop, done)

    windows = list(_windows(n, threads or cores()))
    count = min(threads or cores(), len(windows))
    if count <= 1:
        for window in windows:
            part(window)
    else:
        with ThreadPoolExecutor(count) as pool:
            try:
                for _ in pool.map(part, windows):
                    pass
            finally:  # after an error, or the user's Ctrl-C, the other threads need not finish
                stop.set()
                pool.shutdown(wait=False, cancel_futures=True)
    return columns


@cache
def _keep_memory() -> None:
    """Let the C library keep what is freed: it raises its limit (glibc, to 32 MB at most) when a large array goes.

    Else temporary arrays of all sizes are given back to the system and come again page by page, which can take longer
    than the arithmetic. The array is never touched.
    """
    np.empty(_ROOM, dtype=np.uint8)


def cores() -> int:
    """Return the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _empty(n: int, dtype: np.dtype[Any]) -> Any:
    return np.full(n, np.nan) if dtype.kind == "f" else np.zeros(n, dtype)


def _windows(n: int, threads: int) -> Iterator[slice]:
    """Chunks; smaller ones where they are few, so that no thread waits long for the last."""
    size = min(CHUNK, max(_FEWEST, -(-n // (4 * threads)))) if threads > 1 else CHUNK
    yield from (slice(k, min(k + size, n)) for k in range(0, n, size))


def _fill(
    task: EnsembleTask, tools: TaskContext, columns: Columns, window: slice, q: list[Any], rates: list[Any],
    stop: threading.Event, done: Callable[[int], None],
) -> None:  # fmt: skip
    """Compute one chunk into its window of the columns."""
    names = [c.name for c in task.system.coordinates]
    places, speeds = dict(zip(names, q, strict=True)), dict(zip(names, rates, strict=True))
    codes = columns[STATUS][window]
    # NaN and places outside the domain get their status here: the engine sees none of them
    codes[:] = _at_the_door(tools, places, speeds)
    good = np.flatnonzero(codes == Status.OK)
    if not len(good):
        done(len(codes))
        return
    places, speeds = ({name: np.ascontiguousarray(x[good]) for name, x in group.items()} for group in (places, speeds))
    if tools.engine is None:
        for k, row in enumerate(map(int, good)):
            if stop.is_set():
                return
            _one(task, tools, columns, window.start + row, _start(task, places, speeds, k), False)
            done(1)
        done(len(codes) - len(good))
        return
    if tools.chart is not None:
        at = (places, speeds) if tools.about is None else tools.about.in_space(places, speeds)
        found = run_charted(tools.engine, tools.chart, *at)
        if tools.about is not None and (name := f"angles.{tools.about.turned}") in found.error:
            tools.about.turn_back(
                found.group("angles")[str(tools.about.turned)], found.error[name], places[tools.about.azimuth]
            )
    elif task.kind == "p":
        found = tools.engine.run(places, speeds)
    else:
        found = tools.engine.run_velocities(places, speeds, tools.momenta)
    fine = (found.status == Status.OK) | (found.status == Status.UNBOUNDED)
    for name in tools.layout.values():
        quantity, _, key = name.partition(".")
        columns[name][window][good] = np.where(fine, found.group(quantity)[key], np.nan)
        columns[ERROR + name][window][good] = np.where(fine, found.error[name], np.nan)
    codes[good] = np.where(fine, found.status, Status.NOT_CONVERGED)  # what doubles say of the others is not proved
    if not task.fallback:
        done(len(codes))
        return
    singly = np.flatnonzero(~fine)
    done(len(codes) - len(singly))
    for k in map(int, singly):
        if stop.is_set():
            return
        # an orbit that seems to run away has no frequencies: of the single motion less is asked
        endless = bool(found.status[k] == ENDLESS)
        _one(task, tools, columns, window.start + int(good[k]), _start(task, places, speeds, k), endless)
        done(1)


def _start(task: EnsembleTask, places: Mapping[str, Any], speeds: Mapping[str, Any], k: int) -> dict[str, Any]:
    """Return the initial data of one orbit."""
    start: dict[str, Any] = {"q": _picked(places, k), task.kind: _picked(speeds, k)}
    return start if task.frame == COORDINATE else {**start, "velocity_frame": task.frame}


def _at_the_door(tools: TaskContext, q: Mapping[str, Any], rates: Mapping[str, Any]) -> Any:
    """Return the status of orbits that need no engine, ``OK`` for the others."""
    finite = np.logical_and.reduce([np.isfinite(x) for group in (q, rates) for x in group.values()])
    within = np.ones(finite.shape, dtype=bool)
    with np.errstate(invalid="ignore"):
        for end in tools.bounds:
            beyond = end.side * q[end.name] > end.side * end.value
            within &= beyond | (q[end.name] == end.value) if end.closed else beyond
    return np.where(finite, np.where(within, Status.OK, Status.OUTSIDE_DOMAIN), Status.NOT_FINITE).astype(np.int8)


def _picked(arrays: Mapping[str, Any], k: int) -> dict[str, float]:
    return {name: float(array[k]) for name, array in arrays.items()}


def _one(
    task: EnsembleTask,
    tools: TaskContext,
    columns: Columns,
    place: int,
    start: Mapping[str, Mapping[str, float]],
    endless: bool,
) -> None:
    """Compute one orbit by the engine of single motions into its row."""
    from hjsolve.ensembles.fallback import single_orbit  # single motions cost a tenth of a second to load

    status, row = single_orbit(tools.solution, tools.layout, start, dict(task.parameters), endless=endless)
    columns[STATUS][place], columns[RECOMPUTED][place] = status, True
    for column, value in row.items():
        columns[column][place] = value
