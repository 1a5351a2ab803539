"""A sweep on a dask cluster of separate processes: a worker dies, the client dies, and every orbit is there once."""

from __future__ import annotations

import gc
import signal
import weakref
from pathlib import Path

import numpy as np
import pytest

import hjsolve

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")
dataset = pytest.importorskip("pyarrow.dataset", reason="needs the extra cluster")

from tests.sweeps.clusters import SLOW, cluster, local_cluster  # noqa: E402
from tests.sweeps.conftest import parts, start_slowly, wait_until  # noqa: E402


def test_a_cluster_that_loses_a_worker_gives_the_bytes_of_threads(
    scene: Path, tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The small version: the cluster lives in this process, and a worker leaves when the first part is there."""
    from hjsolve.sweeps.work import SweepWork

    out, kept = tmp_path / "out", []
    keep = SweepWork.keep
    local = local_cluster()

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


@pytest.mark.nightly
def test_starts_of_parts_that_are_done_are_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Dask's client logs its last messages, a thousand by default: with their starts that was a gigabyte."""
    from hjsolve.sweeps.work import SweepWork

    known: list[weakref.ref[np.ndarray]] = []
    alive: list[int] = []
    starts, keep = SweepWork.starts, SweepWork.keep

    def begun(work: SweepWork, part: int) -> dict[str, np.ndarray]:
        found = {name: column.copy() for name, column in starts(work, part).items()}
        known.append(weakref.ref(found["q.r"]))
        return found

    def noted(work: SweepWork, part: int, *rest: object) -> None:
        keep(work, part, *rest)  # type: ignore[arg-type]
        gc.collect()
        alive.append(sum(one() is not None for one in known))

    monkeypatch.setattr(SweepWork, "starts", begun)
    monkeypatch.setattr(SweepWork, "keep", noted)
    scene = tmp_path / "orbits.toml"
    grid = '[sweep.q]\nr = {start = "0.9", stop = "1.6", count = 60}\ntheta = "0"\n[sweep.p]\nr = "0.1"\ntheta = "1"\n'
    scene.write_text(f'system = "kepler-planar"\nwant = ["actions"]\n[sweep]\nchunk = 1\n{grid}', encoding="utf-8")
    with local_cluster(1) as local:
        hjsolve.sweep(scene, tmp_path / "out", scheduler=local.scheduler_address)
    assert len(alive) == 60
    assert max(alive) <= 20


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
    ("text", "orbits", "least", "added", "statuses"),
    [
        pytest.param(None, 12, 1, 1, {"ok", "unbounded"}, id="12 orbits"),
        pytest.param(GALAXY, 20_000, 4, 8, {"ok"}, id="20 000 orbits"),
    ],
)
def test_a_worker_dies_and_the_client_dies_and_every_orbit_is_there_once(
    text: str | None, orbits: int, least: int, added: int, statuses: set[str],
    scene: Path, tmp_path: Path, undisturbed: Path,
) -> None:  # fmt: skip
    """A worker is killed after ``least`` parts, the client after ``added`` more, then the sweep resumes."""
    if text:
        scene.write_text(text, encoding="utf-8")
        undisturbed = hjsolve.sweep(scene, tmp_path / "undisturbed").path
    out, all_parts = tmp_path / "out", len(parts(undisturbed))
    with cluster(tmp_path, [SLOW, SLOW]) as (address, workers):
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
    assert set(table["status"].to_pylist()) == statuses


def test_a_worker_with_other_code_is_refused() -> None:
    from hjsolve.ensembles.orbits import task_for
    from hjsolve.sweeps.cluster import remote_part

    task = task_for(hjsolve.solve(hjsolve.catalog.load("kepler-planar")), ("actions",), {}, "p")
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
