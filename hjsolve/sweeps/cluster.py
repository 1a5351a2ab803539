"""A sweep on the workers of a dask cluster; this process hands out starts, takes columns in, and alone writes.

A worker that is lost costs its unfinished parts, which the scheduler gives to others; a client that is lost costs the
parts on their way. Either way a part is written once, because it is written here, under its one name.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING

from hjsolve.arithmetic.number_types import Columns
from hjsolve.errors import ClusterError, InvalidInputError, MissingExtraError
from hjsolve.sweeps.handing_out import HandingOut, UnfitWorker
from hjsolve.sweeps.identity import code
from hjsolve.sweeps.work import SweepTask, SweepWork, columns_of

if TYPE_CHECKING:
    from distributed import Client

_PATIENCE = 20.0
"""Seconds until a scheduler that does not answer, or has no worker, is given up."""

_LOG, _MESSAGES = "distributed.admin.low-level-log-length", 10
"""Messages that dask keeps of what was sent, for developers: by default a thousand, with the starts of their parts."""


def on_cluster(work: SweepWork, scheduler: str) -> None:
    """Compute what is left on a cluster; see ``hjsolve.sweep``.

    Args:
        work: the sweep, and what is left of it.
        scheduler: address of the scheduler, such as ``tcp://host:8786``.

    Raises:
        MissingExtraError: distributed is not installed.
        ClusterError: the connection was lost, one part ended several workers, or no worker has memory enough; what is
            written stays.
    """
    try:
        import distributed
        from distributed.comm.core import CommClosedError
    except ImportError as error:
        raise MissingExtraError('a cluster needs distributed: pip install "hjsolve[cluster]"') from error
    if not work.left:
        return
    with _client(distributed, scheduler) as client:
        _wait_for_workers(distributed, client, scheduler)
        try:
            HandingOut(client, work, remote_part).run()
        except (distributed.client.FutureCancelledError, CommClosedError) as error:
            raise ClusterError(
                f"{scheduler}: the connection was lost. Finished parts are kept; run the same command again"
            ) from error


def _client(distributed: ModuleType, scheduler: str) -> Client:
    import dask

    try:
        with dask.config.set({_LOG: _MESSAGES}):
            return distributed.Client(scheduler, timeout=_PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InvalidInputError(
            f"scheduler: {scheduler} cannot be reached; start one by `dask scheduler`, and give the address it prints"
        ) from error


def _wait_for_workers(distributed: ModuleType, client: Client, scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except (TimeoutError, distributed.TimeoutError) as error:
        raise InvalidInputError(f"scheduler: {scheduler} has no worker; start `dask worker {scheduler}`") from error


def remote_part(task: SweepTask, expected: Mapping[str, str], starts: Columns) -> Columns | UnfitWorker:
    """Return the columns of one part, on a worker.

    Args:
        task: what is to be computed of each orbit.
        expected: versions and digests of the code that the run began with.
        starts: initial conditions, name → array of shape (n,).

    Returns:
        Name of the column → array of shape (n,); or that this worker cannot, for want of memory or of what its system
        refuses (libraries that do not load, a full disk).

    Raises:
        ClusterError: the worker's code is not that of the run.
    """
    if code() != dict(expected):
        raise ClusterError(f"a worker has other code ({code()}) than this process ({dict(expected)}); install the same")
    try:
        return columns_of(task, starts, threads=1)
    except (MemoryError, OSError) as error:
        return UnfitWorker(_this_worker(), str(error) or "too little memory")


def _this_worker() -> str:
    from distributed import get_worker

    return str(get_worker().address)
