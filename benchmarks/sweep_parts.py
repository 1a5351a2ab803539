"""What a sweep costs in addition to its orbits: reading starts, writing parts, managing a folder of many parts.

    python -m benchmarks.sweep_parts [--parts 100000]

Processor time of one process, and wall time of what a reader waits for; docs/ensembles.md shows the figures.
"""

from __future__ import annotations

import argparse
import json
import pickle
import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from hjsolve.arithmetic.number_types import Columns
from hjsolve.ensembles.layout import RECOMPUTED, STATUS
from hjsolve.sweeps.folder import SweepPlan, opened
from hjsolve.sweeps.parquet_table import opened_table

CHUNK, WRITTEN, ROWS, FILES, GROUP = 16_384, 20, 4_000_000, 4, 250_000
COORDINATES = ("R", "z", "phi")
NEEDED = tuple(f"c{k}" for k in range(6))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=100_000)
    parts = parser.parse_args().parts
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        reading(folder / "table.parquet")
        writing(folder / "out")
        many_parts(folder / "many", parts)


def told(what: str, work: Callable[[], object], orbits: int = 0) -> None:
    """Print the processor time of some work, in µs an orbit where orbits are given; its wall time else.

    Args:
        what: the work is.
        work: to be measured.
        orbits: that it treats.
    """
    begin, wall = time.process_time(), time.perf_counter()
    work()
    spent, wall = time.process_time() - begin, time.perf_counter() - wall
    price = f"{spent / orbits * 1e6:.2f} µs an orbit" if orbits else f"{spent:.2f} s, wall {wall:.2f} s"
    print(f"{what}: {price}", flush=True)


def reading(path: Path) -> None:
    """Read a folder of Parquet files part by part.

    Args:
        path: where it is made.
    """
    path.mkdir()
    rng, size = np.random.default_rng(0), ROWS // FILES
    for k in range(FILES):
        numbers = {f"c{i}": rng.normal(size=size) for i in range(12)}
        table = pa.table({**numbers, "source_id": np.arange(size) + k * size})
        pq.write_table(table, path / f"{k}.parquet", row_group_size=GROUP)
    table = opened_table(path)

    def all_parts() -> None:
        for begin in range(0, ROWS, CHUNK):
            end = min(begin + CHUNK, ROWS)
            table.read(("source_id",), begin, end)
            table.doubles(NEEDED, begin, end)

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    told("reading", all_parts, ROWS)
    print(f"  {(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024:.0f} MB more than before")


def writing(path: Path) -> None:
    """Write parts, and pass them on as to and from a worker.

    Args:
        path: of the folder.
    """
    rng = np.random.default_rng(1)
    columns: Columns = {STATUS: np.zeros(CHUNK, np.int8), RECOMPUTED: np.zeros(CHUNK, bool)}
    for quantity in ("actions", "frequencies", "angles"):
        for name in COORDINATES:
            columns[f"{quantity}.{name}"] = rng.normal(size=CHUNK)
            columns[f"error.{quantity}.{name}"] = rng.normal(size=CHUNK) * 1e-12
    starts: Columns = {f"{group}.{name}": rng.normal(size=CHUNK) for group in "qp" for name in COORDINATES}
    kept = {"source_id": pa.chunked_array([np.arange(CHUNK)])}
    with opened(path, SweepPlan({}, {}, CHUNK * WRITTEN, CHUNK, "")) as folder:

        def write() -> None:
            for k in range(WRITTEN):
                folder.write(k, starts, columns, kept)

        told("writing", write, CHUNK * WRITTEN)
        print(f"  {folder.part(0).stat().st_size / CHUNK:.0f} bytes an orbit")
    told("to and from a worker", lambda: [pickle.loads(pickle.dumps(x, 5)) for x in (starts, columns)], CHUNK)


def many_parts(path: Path, parts: int) -> None:
    """Open and finish a folder of many parts of two orbits: copies of one, and their lines in the journal.

    Args:
        path: of the folder.
        parts: how many.
    """
    plan = SweepPlan({}, {}, 2 * parts, 2, "")
    with opened(path, plan) as folder:
        folder.write(0, {"q.r": np.ones(2)}, {STATUS: np.zeros(2, np.int8), RECOMPUTED: np.zeros(2, bool)})
        content, noted = folder.part(0).read_bytes(), folder.journal.parts()[0]
        for k in range(1, parts):
            folder.part(k).write_bytes(content)
        with folder.journal.path.open("a") as file:
            file.writelines(json.dumps(asdict(replace(noted, part=k))) + "\n" for k in range(1, parts))
        told("left, none missing", folder.left)
        for k in range(0, parts, 10):
            folder.part(k).unlink()
        told("left, a tenth missing", folder.left)
        for k in range(0, parts, 10):
            folder.part(k).write_bytes(content)
        told("finish", folder.finish)

    def again() -> None:
        with opened(path, plan) as folder:
            folder.left()

    told("open a complete one", again)


if __name__ == "__main__":
    main()
