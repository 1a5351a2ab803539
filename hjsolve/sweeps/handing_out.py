"""Parts handed out to workers that come and go, are slow, stand still, or have little memory.

Whatever workers do, a part is kept once: when its first result is here, others of the same part are dropped.
"""

from __future__ import annotations

import queue
import statistics
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from hjsolve.arithmetic.number_types import Columns
from hjsolve.errors import ClusterError
from hjsolve.sweeps.identity import code
from hjsolve.sweeps.work import SweepWork

_AHEAD = 2
"""Parts a thread of the cluster holds or waits for: more would only fill memory."""

_LOOK = 1.0
"""Seconds without a result until the workers are looked at again."""

_ALONE = 600.0
"""Seconds without any worker until the run is given up."""

_OVERDUE = 3.0
"""A part that takes so many times what parts take is given to a second worker, when one has nothing else to do."""

_RECENT = 100
"""Parts whose times say what parts take."""

_ATTEMPTS = 3
"""Times that a part may find too little memory on its way into a worker."""


@dataclass(frozen=True)
class UnfitWorker:
    """What a worker returns instead of columns where its machine does not let it compute them.

    Attributes:
        worker: its address.
        reason: in words.
    """

    worker: str
    reason: str


class _Future(Protocol):
    """What is used of a future of dask."""

    @property
    def key(self) -> str: ...
    def result(self, timeout: float) -> Columns | UnfitWorker: ...
    def cancel(self) -> object: ...
    def add_done_callback(self, call: Callable[[_Future], object], /) -> None: ...


class _Client(Protocol):
    """What is used of a client of dask."""

    def nthreads(self) -> Mapping[str, int]: ...
    def processing(self) -> Mapping[str, Iterable[object]]: ...
    def submit(self, function: Callable[..., object], /, *arguments: object, **options: object) -> _Future: ...


@dataclass
class HeldPart:
    """A part that workers have.

    Attributes:
        part: its number.
        starts: initial conditions, name → array of shape (n,).
        since: when it was first handed out, seconds of the monotonic clock.
        futures: key of dask → future; two where a second worker was asked.
    """

    part: int
    starts: Columns
    since: float
    futures: dict[str, _Future] = field(default_factory=dict)


class HandingOut:
    """Keep every thread of a cluster busy and take in what is done, in whatever order it comes.

    Args:
        client: of dask.
        work: the sweep, and what is left of it.
        remote: what a worker calls with the task, the versions of the code and the starts.
    """

    def __init__(self, client: _Client, work: SweepWork, remote: Callable[..., Columns | UnfitWorker]) -> None:
        self._client, self._work, self._remote = client, work, remote
        self._parts = iter(work.left)
        self._held: dict[int, HeldPart] = {}
        self._owner: dict[str, int] = {}
        self._done: queue.SimpleQueue[_Future] = queue.SimpleQueue()
        self._unfit: dict[str, str] = {}
        self._stuck: dict[int, int] = {}
        self._patience: dict[str, float] = {}
        self._took: deque[float] = deque(maxlen=_RECENT)
        self._alone_since: float | None = None

    def run(self) -> None:
        """Hand out all that is left, and keep it.

        Raises:
            ClusterError: a part ended several workers, no worker can compute it, or there was none for long.
        """
        self._refill()
        while self._held:
            try:
                future = self._done.get(timeout=_LOOK)
            except queue.Empty:
                self._look_around()
            else:
                self._take(future)
            self._refill()

    def _take(self, future: _Future) -> None:
        """Keep a part that is done; what comes of a part that is kept already is dropped."""
        number = self._owner.pop(future.key, None)
        if number is None:
            return
        held = self._held[number]
        del held.futures[future.key]
        patience = self._patience.pop(future.key, _LOOK)
        try:
            columns = future.result(timeout=patience)
        except TimeoutError:  # its worker is gone since, with what it had, or the way here is slow
            self._owner[future.key], held.futures[future.key] = number, future
            self._patience[future.key] = 2 * patience
            self._look_around()
            self._done.put(future)
        except MemoryError:  # not in our call: the starts did not fit
            self._stuck[number] = self._stuck.get(number, 0) + 1
            self._again(held)
        except _killed_worker() as error:
            raise ClusterError(
                f"{self._named(held)} ended several workers, for lack of memory or by a fault. Finished parts are kept"
            ) from error
        else:
            if isinstance(columns, UnfitWorker):
                self._unfit[columns.worker] = columns.reason
                self._work.tally.tell(f"{columns.worker} gets nothing more: {columns.reason}")
                self._again(held)
            else:
                self._forget(held)
                self._work.keep(number, held.starts, columns)

    def _forget(self, held: HeldPart) -> None:
        self._took.append(time.monotonic() - held.since)
        for key, future in held.futures.items():
            del self._owner[key]
            future.cancel()
        del self._held[held.part]

    def _again(self, held: HeldPart) -> None:
        """Give a part to another worker, if there is one that may be asked."""
        workers = self._client.nthreads()
        fit = workers.keys() - self._unfit.keys()
        if self._stuck.get(held.part, 0) >= _ATTEMPTS or (workers and not fit):
            why = "; ".join(sorted(set(self._unfit.values()))) or "too little memory"
            raise ClusterError(
                f"{self._named(held)}: no worker could compute this part ({why}). Finished parts are kept; run "
                "the same command with larger workers, or write to another folder with a smaller chunk"
            )
        if not held.futures:
            self._submit(held, fit)

    def _refill(self) -> None:
        workers = self._client.nthreads()
        fit = workers.keys() - self._unfit.keys()
        room = max(_AHEAD * sum(workers[name] for name in fit), 1) - len(self._held)
        for _ in range(room):
            part = next(self._parts, None)
            if part is None:
                return
            self._held[part] = HeldPart(part, self._work.starts(part), time.monotonic())
            self._submit(self._held[part], fit if self._unfit else ())

    def _submit(self, held: HeldPart, workers: Iterable[str]) -> None:
        """Hand a part out, to some workers if they are still there, to any where none is named."""
        names = sorted(workers)
        where: dict[str, object] = {"workers": names, "allow_other_workers": True} if names else {}
        future = self._client.submit(self._remote, self._work.task, code(), held.starts, pure=False, **where)
        held.futures[future.key] = future
        self._owner[future.key] = held.part
        future.add_done_callback(self._done.put)

    def _look_around(self) -> None:
        """Nothing came: there may be no worker at all, or one that keeps the others waiting."""
        busy = {name: set(map(str, keys)) for name, keys in self._client.processing().items()}
        if not busy:
            self._wait_alone()
            return
        self._alone_since = None
        if not self._took:
            return
        idle = [name for name, keys in busy.items() if not keys and name not in self._unfit]
        for held in sorted(self._held.values(), key=lambda held: held.since):
            age = time.monotonic() - held.since
            if idle and len(held.futures) == 1 and age > _OVERDUE * statistics.median(self._took):
                self._submit(held, [idle.pop()])

    def _wait_alone(self) -> None:
        now = time.monotonic()
        self._alone_since = now if self._alone_since is None else self._alone_since
        self._work.tally.tell("no worker is left, waiting for one")
        if now - self._alone_since > _ALONE:
            raise ClusterError(
                f"no worker was available for {_ALONE:.0f} s. Finished parts are kept; run the same command again"
            )

    def _named(self, held: HeldPart) -> str:
        begin, end = self._work.folder.plan.window(held.part)
        return f"part {held.part} (orbits {begin} to {end - 1})"


def _killed_worker() -> type[Exception]:
    from distributed import KilledWorker

    return KilledWorker
