"""Workers with too little memory, that stand still, that a part ends: every orbit is there once, and it is told."""

from __future__ import annotations

import signal
import threading
from pathlib import Path
from typing import Any

import pytest

import hjsolve

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")
dataset = pytest.importorskip("pyarrow.dataset", reason="needs the extra cluster")

from hjsolve.display.progress import Tally  # noqa: E402
from hjsolve.sweeps import cluster as cluster_module  # noqa: E402
from hjsolve.sweeps import handing_out  # noqa: E402
from hjsolve.sweeps.work import SweepWork  # noqa: E402
from tests.sweeps.clusters import SLOW, cluster, local_cluster  # noqa: E402
from tests.sweeps.conftest import parts, start_slowly, wait_until  # noqa: E402

quick = cluster_module.columns_of


def address_here() -> str:
    return str(distributed.get_worker().address)


@pytest.fixture
def kept(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the parts in the order in which they are written."""
    found: list[int] = []
    keep = SweepWork.keep

    def noted(work: SweepWork, part: int, *rest: Any) -> None:
        found.append(part)
        keep(work, part, *rest)

    monkeypatch.setattr(SweepWork, "keep", noted)
    return found


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is remarked next to the progress."""
    found: list[str] = []
    monkeypatch.setattr(Tally, "tell", lambda _, remark="": found.append(remark))
    return found


# ------------------------------------------------------------------------------------------------ in this process
def test_a_worker_with_too_little_memory_is_asked_once_a_held_part_and_others_go_on(
    scene: Path, tmp_path: Path, undisturbed: Path, kept: list[int], told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    with local_cluster() as local:
        small = local.workers[0].address

        def columns_of(*arguments: Any, **options: Any) -> Any:
            asked.append(address_here())
            if address_here() == small:
                raise MemoryError
            return quick(*arguments, **options)

        monkeypatch.setattr(cluster_module, "columns_of", columns_of)
        hjsolve.sweep(scene, tmp_path / "out", scheduler=local.scheduler_address)
    assert sorted(kept) == list(range(6))
    assert parts(tmp_path / "out") == parts(undisturbed)
    assert 1 <= asked.count(small) <= 4  # what was on its way to it
    assert f"{small} gets nothing more: too little memory" in told


def test_too_little_memory_everywhere_ends_the_run_and_what_is_written_stays(
    scene: Path, tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"

    def columns_of(task: Any, starts: Any, **options: Any) -> Any:
        if starts["q.r"][0] == 1.6:
            raise MemoryError
        return quick(task, starts, **options)

    monkeypatch.setattr(cluster_module, "columns_of", columns_of)
    with local_cluster() as local:
        with pytest.raises(
            hjsolve.ClusterError,
            match=r"part 5 \(orbits 10 to 11\): no worker could compute this part .too little memory.*smaller chunk",
        ):
            hjsolve.sweep(scene, out, scheduler=local.scheduler_address)
        survived = len(parts(out))
        monkeypatch.setattr(cluster_module, "columns_of", quick)
        assert hjsolve.sweep(scene, out, scheduler=local.scheduler_address).kept == survived
    assert parts(out) == parts(undisturbed)


@pytest.mark.nightly
def test_a_part_that_stands_still_is_given_to_another_worker_and_kept_once(
    scene: Path, tmp_path: Path, undisturbed: Path, kept: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    released, asked, woken = threading.Event(), [], []
    with local_cluster() as local:
        still = local.workers[0].address

        def columns_of(*arguments: Any, **options: Any) -> Any:
            asked.append(address_here())
            if address_here() == still:
                woken.append(released.wait(60))
            return quick(*arguments, **options)

        monkeypatch.setattr(cluster_module, "columns_of", columns_of)
        hjsolve.sweep(scene, tmp_path / "out", scheduler=local.scheduler_address)
        assert not woken, "the sweep waited for the part that stood still"
        released.set()
    assert still in asked
    assert sorted(kept) == list(range(6))
    assert parts(tmp_path / "out") == parts(undisturbed)


@pytest.mark.nightly
def test_without_any_worker_it_waits_says_so_and_gives_up_in_the_end(
    scene: Path, tmp_path: Path, undisturbed: Path, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    local = local_cluster(1)

    def columns_of(*arguments: Any, **options: Any) -> Any:
        monkeypatch.setattr(cluster_module, "columns_of", quick)
        local.scale(0)  # while this part is on its way
        return quick(*arguments, **options)

    monkeypatch.setattr(cluster_module, "columns_of", columns_of)
    monkeypatch.setattr(handing_out, "_ALONE", 1.5)
    with local:
        with pytest.raises(
            hjsolve.ClusterError, match=r"no worker was available for 2 s. Finished parts are kept; run the same command again"
        ):
            hjsolve.sweep(scene, tmp_path / "out", scheduler=local.scheduler_address)
        assert "no worker is left, waiting for one" in told
        local.scale(1)
        hjsolve.sweep(scene, tmp_path / "out", scheduler=local.scheduler_address)
    assert parts(tmp_path / "out") == parts(undisturbed)


# ------------------------------------------------------------------------------------------------ of processes
MANY = """
system = "kepler-planar"
want = ["actions"]
[sweep]
chunk = {chunk}
[sweep.q]
r = {start = "0.9", stop = "1.6", count = {count}}
theta = "0"
[sweep.p]
r = "0.1"
theta = "1"
"""
LITTLE_MEMORY = """
import resource
from hjsolve.sweeps import cluster
from hjsolve.sweeps.conduct import columns_of as quick
def limited(*arguments, **options):
    open("ASKED", "a").write("x")  # before: the compiler ends the whole process where it gets no memory
    pages = int(open("/proc/self/statm").read().split()[0])
    limit = pages * resource.getpagesize() + 2 ** 23
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    try:
        return quick(*arguments, **options)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
cluster.columns_of = limited
"""
DEADLY = """
import os, signal
from hjsolve.sweeps import cluster
from hjsolve.sweeps.conduct import columns_of as quick
def deadly(task, starts, **options):
    if starts["q.r"][0] == 1.6:
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(task, starts, **options)
cluster.columns_of = deadly
"""


@pytest.mark.nightly
@pytest.mark.parametrize("chunk", [30_000, 200_000])
def test_a_worker_that_the_system_gives_no_memory(chunk: int, scene: Path, tmp_path: Path, kept: list[int]) -> None:
    """Too little for arrays, and too little for the compiler, which then ends the worker's process."""
    scene.write_text(MANY.replace("{chunk}", str(chunk)).replace("{count}", str(3 * chunk)), encoding="utf-8")
    undisturbed = hjsolve.sweep(scene, tmp_path / "undisturbed").path
    kept.clear()
    asked = tmp_path / "asked"
    with cluster(tmp_path, [LITTLE_MEMORY.replace("ASKED", str(asked)), SLOW]) as (address, _):
        hjsolve.sweep(scene, tmp_path / "out", scheduler=address)
    assert asked.exists()
    assert sorted(kept) == [0, 1, 2]
    assert parts(tmp_path / "out") == parts(undisturbed)


@pytest.mark.nightly
def test_a_worker_that_is_stopped_in_mid_run(
    scene: Path, tmp_path: Path, undisturbed: Path, kept: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    with cluster(tmp_path, [SLOW, SLOW]) as (address, workers):
        keep = SweepWork.keep

        def stopping(work: SweepWork, *rest: Any) -> None:
            keep(work, *rest)
            workers[0].send_signal(signal.SIGSTOP)

        monkeypatch.setattr(SweepWork, "keep", stopping)
        try:
            hjsolve.sweep(scene, tmp_path / "out", scheduler=address)
        finally:
            workers[0].send_signal(signal.SIGCONT)
    assert sorted(kept) == list(range(6))
    assert parts(tmp_path / "out") == parts(undisturbed)


@pytest.mark.nightly
def test_a_part_that_ends_its_workers_is_named(
    scene: Path, tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "1")
    out = tmp_path / "out"
    with (
        cluster(tmp_path, [DEADLY] * 3) as (address, _),
        pytest.raises(hjsolve.ClusterError, match=r"part 5 \(orbits 10 to 11\) ended several workers.*Finished parts are kept"),
    ):
        hjsolve.sweep(scene, out, scheduler=address)
    survived = len(parts(out))
    assert survived >= 1
    assert hjsolve.sweep(scene, out).kept == survived
    assert parts(out) == parts(undisturbed)


@pytest.mark.nightly
def test_a_scheduler_that_is_lost_ends_the_run_in_one_line(scene: Path, tmp_path: Path, undisturbed: Path) -> None:
    out = tmp_path / "out"
    with cluster(tmp_path, [SLOW, SLOW]) as (address, processes):
        sweeping = start_slowly(scene, out, address)
        wait_until(lambda: len(parts(out)) >= 1, sweeping)
        processes[-1].kill()
        _, errors = sweeping.communicate(timeout=120)
    assert sweeping.returncode != 0
    assert "ClusterError" in errors.decode().splitlines()[-1], errors.decode()
    assert hjsolve.sweep(scene, out).kept >= 1
    assert parts(out) == parts(undisturbed)
