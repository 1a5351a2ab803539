"""Clusters of dask for tests: of processes, as users start them, and in this process."""

from __future__ import annotations

import contextlib
import re
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tests.sweeps.conftest import start, wait_until

SLOW = """
import time
from hjsolve.sweeps import cluster
from hjsolve.sweeps.conduct import columns_of as quick
def slow(*arguments, **options):
    time.sleep(0.3)
    return quick(*arguments, **options)
cluster.columns_of = slow
"""


def local_cluster(workers: int = 2) -> Any:
    """A cluster in this process.

    Args:
        workers: how many, of one thread each.
    """
    import distributed

    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=False, protocol="tcp://", dashboard_address="127.0.0.1:0",
        silence_logs=50,
    )  # fmt: skip


@contextlib.contextmanager
def cluster(folder: Path, preloads: Sequence[str]) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and workers, as `dask scheduler` and `dask worker ADDRESS` start them; the scheduler is the last.

    Args:
        folder: for their files.
        preloads: for every worker, what it runs first.
    """
    begun = [start("-m", "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard",
                   "--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(folder / "s.json"))]  # fmt: skip
    try:
        wait_until((folder / "s.json").exists)
        address = ""

        def known() -> bool:
            nonlocal address
            found = re.search(r'"address": "(tcp://[\d.:]+)"', (folder / "s.json").read_text())
            address = found[1] if found else ""
            return bool(found)

        wait_until(known)
        for k, text in enumerate(preloads):
            (folder / f"preload_{k}.py").write_text(text)
            begun.append(
                start("-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard",
                      "--dashboard-address", "127.0.0.1:0", "--local-directory", str(folder),
                      "--preload", str(folder / f"preload_{k}.py"))
            )  # fmt: skip
        _wait_for(address, len(preloads))
        yield address, [*begun[1:], begun[0]]
    finally:
        for process in reversed(begun):
            process.terminate()
        for process in begun:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=5)
            if process.poll() is None:
                process.kill()
                process.communicate()


def _wait_for(address: str, workers: int) -> None:
    import distributed

    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=60)
