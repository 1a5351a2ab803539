"""The process that answers: a question beyond a limit ends it, and the next one is answered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

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
