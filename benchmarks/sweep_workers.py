"""Rates of a sweep with one worker and with two, as processes of a dask cluster on this machine, interleaved.

    python -m benchmarks.sweep_workers [--parts 24] [--repeats 3]

Prints wall times, what each process spent of the processor, and the load. On a machine with two cores the scheduler and
the process that writes take part of them: the ratio by processor time says what two workers do that have a core each.
Then what 10⁹ such orbits cost on 1, 10 and 100 workers: arithmetic with what was measured.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import distributed
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import hjsolve
from benchmarks.ensemble_scale import SYSTEM, WANT, orbits

CHUNK = 16_384


@dataclass(frozen=True)
class Run:
    """One sweep: wall time, and the processor time of the workers, of the scheduler and of this process, seconds."""

    wall: float
    workers: list[float]
    scheduler: float
    here: float


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=24)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    count = options.parts * CHUNK
    runs: dict[int, list[Run]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as name:
        scene = Path(name) / "scene.toml"
        with multiprocessing.get_context("spawn").Pool(1) as elsewhere:  # its memory does not count
            elsewhere.apply(starts, (scene, count))
        with cluster(Path(name), 1) as one, cluster(Path(name), 2) as two:
            for address, _ in (one, two):  # compiles, or loads what was compiled
                hjsolve.sweep(scene, Path(name) / f"warm-{address[-5:]}", scheduler=address)
            for k in range(options.repeats):
                for address, processes in (one, two):
                    out = Path(name) / f"{k}-{address[-5:]}"
                    runs[len(processes) - 1].append(measured(scene, out, address, processes))
            handing = int(Path(f"/proc/{two[1][0]}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
        size = sum(file.stat().st_size for file in out.iterdir()) / count
    print(f"{count} orbits in {options.parts} parts, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    prices = {number: priced(found, count) for number, found in runs.items()}
    for number, price in prices.items():
        print(
            f"{number} workers: {price.wall:.1f} µs of wall time an orbit; processor: workers {sum(price.workers):.1f}"
            f", scheduler {price.scheduler:.2f}, process that writes {price.here:.2f}"
        )
    print(f"two over one, wall: {prices[1].wall / prices[2].wall:.2f}")
    print(f"two over one, by processor time of the busiest process: {busiest(prices[1]) / busiest(prices[2]):.2f}")
    print(f"the scheduler of two workers takes {handing:.0f} MB")
    billion(prices[2], size, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def busiest(price: Run) -> float:
    """Processor time of the busiest process: what a run takes where each has a core of its own.

    Args:
        price: of a run.
    """
    return max(*price.workers, price.scheduler, price.here)


def billion(price: Run, size: float, memory: float) -> None:
    """Print what 10⁹ orbits cost on 1, 10 and 100 workers, as a table.

    Args:
        price: measured, µs an orbit.
        size: of the folder, bytes an orbit.
        memory: of the process that writes, MB.
    """
    each, serial = sum(price.workers), max(price.here, price.scheduler)
    print("\n| workers | hours | bound by | parts an hour | into the process that writes, MB/s |")
    print("|---|---|---|---|---|")
    for number in (1, 10, 100):
        took = max(each / number, serial)
        bound = "workers" if each / number > serial else "the process that writes"
        print(f"| {number} | {took / 3.6:.1f} | {bound} | {3.6e9 / took / CHUNK:.0f} | {size / took:.0f} |")
    print(
        f"\n{1e9 / CHUNK:.0f} parts, {size:.0f} GB on the disk; the process that writes takes {memory:.0f} MB, "
        f"and is busy with {each / serial:.0f} workers"
    )


def priced(runs: list[Run], count: int) -> Run:
    """Return the medians over some runs, µs an orbit.

    Args:
        runs: with one number of workers.
        count: orbits of each.
    """

    def median(times: list[float]) -> float:
        return statistics.median(times) / count * 1e6

    workers = [median(list(times)) for times in zip(*(sorted(run.workers) for run in runs), strict=True)]
    return Run(
        median([run.wall for run in runs]),
        workers,
        median([run.scheduler for run in runs]),
        median([run.here for run in runs]),
    )


def starts(scene: Path, count: int) -> None:
    """Write the scene, and the table of starts next to it.

    Args:
        scene: where to.
        count: orbits.
    """
    q, p = orbits(count)
    columns = {f"{group}.{name}": x for group, values in (("q", q), ("p", p)) for name, x in values.items()}
    columns = {name: np.broadcast_to(np.asarray(x, float), count) for name, x in columns.items()}
    pq.write_table(
        pa.table({"source_id": np.arange(count), **columns}), scene.parent / "stars.parquet", row_group_size=250_000
    )
    sweep = f'[sweep]\ntable = "stars.parquet"\nkeep = ["source_id"]\nchunk = {CHUNK}\n'
    scene.write_text(f'system = "{SYSTEM}"\nwant = {list(WANT)}\n{sweep}')


def measured(scene: Path, out: Path, address: str, processes: list[int]) -> Run:
    """Run a sweep and see what every process spent.

    Args:
        scene: of the sweep.
        out: where to.
        address: of the scheduler.
        processes: ids of the scheduler and of the workers.
    """
    before, begin, here = [spent(k) for k in processes], time.perf_counter(), time.process_time()
    hjsolve.sweep(scene, out, scheduler=address)
    wall, here = time.perf_counter() - begin, time.process_time() - here
    scheduler, *workers = [spent(k) - b for k, b in zip(processes, before, strict=True)]
    return Run(wall, workers, scheduler, here)


def spent(process: int) -> float:
    """Processor time of a process so far.

    Args:
        process: its id.
    """
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[int]]]:
    """Yield a scheduler and workers of one thread: their address and the ids of the processes.

    Args:
        folder: for their files.
        workers: how many.
    """
    file = folder / f"scheduler-{workers}.json"
    place = ("--no-dashboard", "--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(file))
    begun = [_begun("dask_scheduler", "--port", "0", "--host", "127.0.0.1", *place)]
    try:
        begun += [
            _begun("dask_worker", "--no-nanny", "--nthreads", "1", "--local-directory", str(folder), *place)
            for _ in range(workers)
        ]
        with distributed.Client(scheduler_file=str(file), set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=60)
            address = client.scheduler.address
        yield address, [process.pid for process in begun]
    finally:
        for process in reversed(begun):
            process.terminate()
            process.wait()


def _begun(what: str, *arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", f"distributed.cli.{what}", *arguments]
    surroundings = {**os.environ, "DASK_DISTRIBUTED__ADMIN__LOW_LEVEL_LOG_LENGTH": "10"}  # as docs/ensembles.md says
    return subprocess.Popen(command, env=surroundings, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
