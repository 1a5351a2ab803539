"""Any public call from any number of threads gives bit for bit what it gives alone, and leaves the user's settings as it found them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import thread_jobs

ROOT = Path(__file__).resolve().parents[2]
SHORT = ("50 digits", "certified", "certified, 40 digits", "closed forms", "separate", "functions")


def told(folder: Path, threads: int, numba: str, jobs: tuple[str, ...]) -> dict:
    """What jobs tell in a fresh process, whose folder of machine code is empty.

    Args:
        folder: for machine code.
        threads: that run them all at once.
        numba: ``numba`` or ``plain``.
        jobs: their names.
    """
    settings = {**os.environ, "HJSOLVE_CACHE_DIR": str(folder / f"{threads} {numba}"), "PYTHONHASHSEED": "0"}
    command = [sys.executable, "-m", "tests.support.thread_jobs", str(threads), numba, *jobs]
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=settings, timeout=900)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads(run.stdout)


def compare(folder: Path, threads: int, numba: str, jobs: tuple[str, ...]) -> None:
    alone, together = told(folder, 1, numba, jobs), told(folder, threads, numba, jobs)
    (expected,) = alone["told"]
    assert not [text for text in expected.values() if "Error: " in text]
    for one in together["told"]:
        assert {job for job in jobs if one[job] != expected[job]} == set()
    assert all(alone["kept"].values())
    assert all(together["kept"].values())


def test_three_threads_that_start_cold_get_what_one_gets(tmp_path):
    compare(tmp_path, 3, "plain", SHORT)


@pytest.mark.nightly
@pytest.mark.parametrize("numba", ["numba", "plain"])
@pytest.mark.parametrize("threads", [2, 4, 8])
def test_threads_that_start_cold_get_what_one_gets(threads, numba, tmp_path):
    compare(tmp_path, threads, numba, tuple(thread_jobs.JOBS))
