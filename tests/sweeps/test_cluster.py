"""A sweep on a dask cluster of separate processes: a worker dies, the client dies, and every orbit is there once."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import hjsolve

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")
dataset = pytest.importorskip("pyarrow.dataset", reason="needs the extra cluster")

from tests.sweeps.conftest import parts, start, start_slowly, wait_until  # noqa: E402

SLOW_WORKER = """
import time
from hjsolve.sweeps import cluster
from hjsolve.sweeps.conduct import columns_of as quick
def slow(*arguments, **options):
    time.sleep(0.3)
    return quick(*arguments, **options)
cluster.columns_of = slow
"""


@contextlib.contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and workers, as `dask scheduler` and `dask worker ADDRESS` start them."""
    (folder / "slow_worker.py").write_text(SLOW_WORKER)
    begun = [start("-m", "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(folder / "s.json"))]  # fmt: skip
    try:
        wait_until((folder / "s.json").exists)
        address = ""

        def known() -> bool:
            nonlocal address
            found = re.search(r'"address": "(tcp://[\d.:]+)"', (folder / "s.json").read_text())
            address = found[1] if found else ""
            return bool(found)

        wait_until(known)
        begun += [
            start("-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard",
                  "--local-directory", str(folder), "--preload", str(folder / "slow_worker.py"))
            for _ in range(workers)
        ]  # fmt: skip
        yield address, begun[1:]
    finally:
        for process in reversed(begun):
            process.terminate()
        for process in begun:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=10)
            if process.poll() is None:
                process.kill()
                process.communicate()


def test_a_cluster_that_loses_a_worker_gives_the_bytes_of_threads(
    scene: Path, tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The small version: the cluster lives in this process, and a worker leaves when the first part is there."""
    from hjsolve.sweeps.work import SweepWork

    out, kept = tmp_path / "out", []
    keep = SweepWork.keep
    local = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, protocol="tcp://", dashboard_address=None, silence_logs=50
    )

    def noted(work: SweepWork, part: int, *rest: object) -> None:
        keep(work, part, *rest)  # type: ignore[arg-type]
        kept.append(part)
        if len(kept) == 1:
            local.sync(local.workers[0].close)

    monkeypatch.setattr(SweepWork, "keep", noted)
    with local:
        hjsolve.sweep(scene, out, scheduler=local.scheduler_address)
    assert sorted(kept) == list(range(6))
    assert parts(out) == parts(undisturbed)


GALAXY = """
system = "kuzmin-kutuzov"
want = ["actions", "frequencies", "angles"]
[sweep]
chunk = 500
[sweep.q]
u = {start = "0.5", stop = "1.2", count = 40}
w = {start = "-0.6", stop = "0.6", count = 25}
phi = "0"
[sweep.p]
u = {start = "-0.2", stop = "0.2", count = 5}
w = ["0.05", "0.1", "0.15", "0.2"]
phi = "0.3"
"""


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("text", "orbits", "least", "added"),
    [pytest.param(None, 12, 1, 1, id="12 orbits"), pytest.param(GALAXY, 20_000, 4, 8, id="20 000 orbits")],
)
def test_a_worker_dies_and_the_client_dies_and_every_orbit_is_there_once(
    text: str | None, orbits: int, least: int, added: int, scene: Path, tmp_path: Path, undisturbed: Path
) -> None:
    """A worker is killed after ``least`` parts, the client after ``added`` more, then the sweep is gone on with."""
    if text:
        scene.write_text(text, encoding="utf-8")
        undisturbed = hjsolve.sweep(scene, tmp_path / "undisturbed").path
    out, all_parts = tmp_path / "out", len(parts(undisturbed))
    with cluster(tmp_path, workers=2) as (address, workers):
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        sweeping = start_slowly(scene, out, address)
        wait_until(lambda: len(parts(out)) >= least, sweeping)
        workers[0].send_signal(signal.SIGKILL)  # in mid-run
        before = len(parts(out))
        wait_until(lambda: len(parts(out)) >= before + added, sweeping)  # the other one goes on
        sweeping.kill()
        sweeping.communicate()
        survived = parts(out)
        assert least + added <= len(survived) < all_parts
        done = hjsolve.sweep(scene, out, scheduler=address)
    assert done.kept >= len(survived)
    assert parts(out) == parts(undisturbed)
    assert (out / "_manifest.json").read_bytes() == (undisturbed / "_manifest.json").read_bytes()
    table = dataset.dataset(out).to_table()
    assert np.array_equal(np.sort(table["orbit"].to_numpy()), np.arange(orbits))
    assert set(table["status"].to_pylist()) <= {"ok", "unbounded"}  # of the twelve, those with L = 1.9 escape


def test_a_worker_with_other_code_is_refused() -> None:
    from hjsolve.ensembles.orbits import task_for
    from hjsolve.sweeps.cluster import remote_part

    task = task_for(hjsolve.solve(hjsolve.catalog.load("kepler-planar")), ("actions",), {}, "p", compiled=False)
    with pytest.raises(hjsolve.ClusterError, match="other code"):
        remote_part(task, {"hjsolve": "0.0.1"}, {})


def test_an_address_where_nobody_answers_is_told_in_one_line(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hjsolve.sweeps import cluster as module

    monkeypatch.setattr(module, "_PATIENCE", 0.3)
    with pytest.raises(
        hjsolve.InvalidInputError, match=r"tcp://127\.0\.0\.1:9 cannot be reached; start one by `dask scheduler`"
    ):
        hjsolve.sweep(scene, tmp_path / "out", scheduler="tcp://127.0.0.1:9")
