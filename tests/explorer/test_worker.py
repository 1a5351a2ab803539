"""The process that answers: a question beyond a limit ends it, and the next one is answered."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hjsolve.explorer.first_question import question_about
from hjsolve.explorer.worker import Worker

ENDLESS = "x**2/2 + exp(x)*(" + " + ".join(f"sin({2500 + 37 * k}*x)" for k in range(12)) + ")/100000"
"""A minute of proofs that nothing hides between tens of thousands of nodes."""


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    made = Worker(seconds=60, megabytes=1024)
    made.begin()
    yield made
    made.end()


def test_a_question_is_answered(worker: Worker) -> None:
    assert worker.ask(question_about("kepler-planar")).verdict == "yes"


@pytest.mark.nightly
def test_too_long_a_computation_is_stopped_and_the_next_question_answered(worker: Worker) -> None:
    worker.seconds = 3
    told = worker.ask(replace(question_about(None), potential=ENDLESS))
    worker.seconds = 60

    assert "more than 3 s" in told.problem
    assert worker.ask(question_about(None)).verdict == "yes"


@pytest.mark.nightly
def test_too_much_memory_ends_the_process_and_the_next_question_is_answered() -> None:
    small = Worker(seconds=60, megabytes=4)
    try:
        told = small.ask(question_about("kerr"))
        assert "memory" in told.problem
        small.megabytes = 1024
        assert small.ask(question_about(None)).verdict == "yes"
    finally:
        small.end()


@pytest.mark.nightly
def test_a_process_that_was_killed_is_said_to_have_been_killed(worker: Worker) -> None:
    worker.ready()
    assert worker._process is not None
    os.kill(worker._process.pid, signal.SIGKILL)
    connection = worker._connection
    assert connection is not None
    worker.ready = lambda: None  # type: ignore[method-assign] - it ends while it is asked
    try:
        told = worker.ask(question_about(None))
    finally:
        del worker.ready

    assert "SIGKILL" in told.problem
    assert "memory" not in told.problem
    assert worker.ask(question_about(None)).verdict == "yes"


SERVER = f"""
from dataclasses import replace
from hjsolve.explorer.first_question import question_about
from hjsolve.explorer.worker import Worker
if __name__ == "__main__":
    worker = Worker(600, 1024)
    worker.begin()
    worker._connection.send(replace(question_about(None), potential={ENDLESS!r}))
    print(worker._process.pid, flush=True)
    worker._connection.poll(600)
"""


def runs(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return False


@pytest.mark.nightly
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_a_process_that_computes_ends_with_its_server(tmp_path) -> None:
    script = tmp_path / "server.py"
    script.write_text(SERVER, encoding="utf-8")
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        pid = int(server.stdout.readline())
        time.sleep(2)
        assert runs(pid)
        server.kill()
    for _ in range(50):
        if not runs(pid):
            break
        time.sleep(0.1)
    ended = not runs(pid)
    if not ended:
        os.kill(pid, signal.SIGKILL)
    assert ended
